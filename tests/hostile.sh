#!/usr/bin/env bash
# Gives the release program thousands of hostile files and command lines, and writes the table of outcomes:
# tests/hostile.sh [OPTION VALUE]... With `--class images` it runs the cases of one class and with `--only N` one of them
# again, and prints what came of them. Otherwise it replaces the table in graph/docs/measurements/hostile.md: of all cases, with
# `--share 5` of a twentieth of each class, with `--seed 2` of others.
set -euo pipefail
cd "$(dirname "$0")/.."

cargo build --release --quiet -p afterimage-cli
cargo build --quiet -p afterimage-fuzz --bin afterimage-hostile
target=${CARGO_TARGET_DIR:-target}
hostile=("$target/debug/afterimage-hostile" "$target/release/afterimage")
case " $* " in *" --class "* | *" --only "*) exec "${hostile[@]}" "$@" ;; esac
table=$(mktemp)
trap 'rm -f "$table"' EXIT
"${hostile[@]}" "$@" --markdown "$table" || status=$?
document=graph/docs/measurements/hostile.md
# The table ends at the first empty line.
{ sed '/^| input /,$d' "$document"; cat "$table"; sed '1,/^| input /d' "$document" | sed '1,/^$/{/^$/!d}'; } > "$table.new"
mv "$table.new" "$document"
exit "${status:-0}"
