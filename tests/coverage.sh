#!/usr/bin/env bash
# How much of the front end the inputs of fuzzing reach: tests/coverage.sh [RUNS]
#
# It builds the crates of this workspace with `-C instrument-coverage`, runs `document`, `save`, `declaration` and
# `linker` with that many inputs (40 000 in all by default), and prints for each part of the front end the share of
# regions, functions and lines that ran. It needs the tools of an LLVM as new as rustc's: `apt install llvm-22`.
set -euo pipefail
cd "$(dirname "$0")/.."

profdata=${LLVM_PROFDATA:-llvm-profdata-22}
cov=${LLVM_COV:-llvm-cov-22}
"$cov" --version >/dev/null 2>&1 || { echo "first: apt install llvm-22, or set LLVM_COV and LLVM_PROFDATA" >&2; exit 2; }
runs=${1:-40000}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# Dependencies are those of `cargo test`: cargo calls the wrapper for the crates of the workspace alone.
printf '#!/bin/sh\nexec "$@" -C instrument-coverage\n' > "$scratch/rustc"
chmod +x "$scratch/rustc"
RUSTC_WORKSPACE_WRAPPER="$scratch/rustc" LLVM_PROFILE_FILE="$scratch/build-%p.profraw" \
    cargo build --quiet -p afterimage-fuzz --bin afterimage-fuzz
rm -f "$scratch"/build-*
program="${CARGO_TARGET_DIR:-target}/debug/afterimage-fuzz"
for share in document:4 save:1 declaration:1 linker:2; do
    target=${share%:*}
    LLVM_PROFILE_FILE="$scratch/$target.profraw" \
        "$program" --target "$target" --runs $((runs * ${share#*:} / 8)) --seed 17 | tail -n 1
done
"$profdata" merge --sparse "$scratch"/*.profraw -o "$scratch/all.profdata"

# The parts, and the folders of their files.
parts=(
    "text: graph/core/src/document"
    "check: graph/core/src/check"
    "kinds in folders: graph/core/src/node/folder"
    "shader files: graph/wgsl/src/module graph/wgsl/src/token.rs graph/wgsl/src/library.rs graph/wgsl/src/limits"
    "linker: graph/wgsl/src/link"
    "diagnostics: graph/base/src/diagnostic"
    "all of these: graph/core/src/document graph/core/src/check graph/core/src/node/folder graph/wgsl/src graph/base/src/diagnostic"
)
printf '\n| part | regions | functions | lines |\n| --- | ---: | ---: | ---: |\n'
for part in "${parts[@]}"; do
    read -ra folders <<<"${part#*: }"
    # A row has the name; of regions, functions and lines each how many there are, how many were missed, and a share.
    "$cov" report "$program" -instr-profile="$scratch/all.profdata" "${folders[@]}" |
        awk -v part="${part%%:*}" '/^TOTAL/ { printf "| %s | %s | %s | %s |\n", part, $4, $7, $10 }'
done
