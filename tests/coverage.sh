#!/usr/bin/env bash
# Coverage of the crates that read what strangers send: the lines that the fuzz targets reach in so many executions.
# tests/coverage.sh [RUNS]. Needs llvm-profdata and llvm-cov of the LLVM of rustc (`rustc -vV`), or their folder in LLVM.
set -euo pipefail
cd "$(dirname "$0")/.."

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-target}/coverage"
export LLVM_PROFILE_FILE="$scratch/%p.profraw" CARGO_INCREMENTAL=0
RUSTFLAGS="-Cinstrument-coverage" cargo build --quiet -p afterimage-fuzz --bin afterimage-fuzz
program="$CARGO_TARGET_DIR/debug/afterimage-fuzz"
rm -f "$scratch"/*.profraw
"$program" --runs "${1:-100000}"
"${LLVM:+$LLVM/}llvm-profdata" merge -sparse "$scratch"/*.profraw -o "$scratch/all.profdata"
"${LLVM:+$LLVM/}llvm-cov" report "$program" --instr-profile "$scratch/all.profdata" \
    --ignore-filename-regex '/(registry|rustc|tests|toolchains)/'
