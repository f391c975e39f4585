#!/usr/bin/env bash
# Gives the release program thousands of hostile files and command lines, and writes the table of outcomes:
# tests/hostile.sh [OPTION VALUE]... With `--share 5` it runs a twentieth of the cases, with `--class images` those of
# one class, with `--only N` one of them again. Without options it replaces the table in graph/docs/hostile.md.
set -euo pipefail
cd "$(dirname "$0")/.."

cargo build --release --quiet -p afterimage
cargo build --quiet -p afterimage-fuzz --bin afterimage-hostile
hostile=("${CARGO_TARGET_DIR:-target}/debug/afterimage-hostile" "${CARGO_TARGET_DIR:-target}/release/afterimage")
if [ $# -gt 0 ]; then
    exec "${hostile[@]}" "$@"
fi
table=$(mktemp)
trap 'rm -f "$table"' EXIT
"${hostile[@]}" --markdown "$table" || status=$?
document=graph/docs/hostile.md
{ sed '/^| input /,$d' "$document"; cat "$table"; sed '1,/^| `lines`/d' "$document"; } > "$table.new"
mv "$table.new" "$document"
exit "${status:-0}"
