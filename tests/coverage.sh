#!/usr/bin/env bash
# How much of the front end the inputs of fuzzing reach: tests/coverage.sh [RUNS]
#
# It builds the fuzz targets with `-C instrument-coverage`, runs `document`, `declaration` and `linker` with that many
# inputs (200 000 in all by default), and prints for each part of the front end the share of regions, functions and lines
# that ran. It needs the tools of an LLVM that is as new as rustc's: `apt install llvm-22`.
set -euo pipefail
cd "$(dirname "$0")/.."

profdata=${LLVM_PROFDATA:-llvm-profdata-22}
cov=${LLVM_COV:-llvm-cov-22}
"$cov" --version >/dev/null 2>&1 || { echo "first: apt install llvm-22, or set LLVM_COV and LLVM_PROFDATA" >&2; exit 2; }
runs=${1:-200000}
export CARGO_TARGET_DIR="$PWD/target/coverage"
RUSTFLAGS="-C instrument-coverage" cargo build --quiet -p afterimage-fuzz --bin afterimage-fuzz
program="$CARGO_TARGET_DIR/debug/afterimage-fuzz"
rm -f "$CARGO_TARGET_DIR"/*.profraw
for share in document:2 declaration:1 linker:1; do
    target=${share%:*}
    LLVM_PROFILE_FILE="$CARGO_TARGET_DIR/$target.profraw" \
        "$program" --target "$target" --runs $((runs * ${share#*:} / 4)) --seed 17 | tail -n 1
done
"$profdata" merge --sparse "$CARGO_TARGET_DIR"/*.profraw -o "$CARGO_TARGET_DIR/fuzz.profdata"

# The parts, and the folders of their files.
parts=(
    "text: graph/src/document"
    "check: graph/src/check"
    "kinds in folders: graph/src/node/folder"
    "shader files: graph/wgsl/src/module graph/wgsl/src/token.rs graph/wgsl/src/library.rs graph/wgsl/src/limits"
    "linker: graph/wgsl/src/link"
    "diagnostics: graph/base/src/diagnostic"
    "all of these: graph/src/document graph/src/check graph/src/node/folder graph/wgsl/src graph/base/src/diagnostic"
)
printf '\n| part | regions | functions | lines |\n| --- | ---: | ---: | ---: |\n'
for part in "${parts[@]}"; do
    read -ra folders <<<"${part#*: }"
    # A row has the name; of regions, functions and lines each how many there are, how many were missed, and a share.
    "$cov" report "$program" -instr-profile="$CARGO_TARGET_DIR/fuzz.profdata" "${folders[@]}" |
        awk -v part="${part%%:*}" '/^TOTAL/ { printf "| %s | %s | %s | %s |\n", part, $4, $7, $10 }'
done
