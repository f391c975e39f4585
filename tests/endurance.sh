#!/usr/bin/env bash
# Runs the rounds of tests/endurance.rs and writes a table and a plot: tests/endurance.sh [ROUNDS [FOLDER [KIND]]]
# 200 rounds, the default, are 10 000 reloads, 5 000 resizes, 20 000 frames and 200 openings of a device. With `reloads`,
# `resizes`, `frames` or `openings` as the kind, rounds have only these, twice as often.
set -euo pipefail
cd "$(dirname "$0")/.."

# Without it glibc gives new threads heaps of their own, up to eight for each core, and each keeps what shader compilers
# have used at most: memory in use then grows in steps for minutes, and the plot shows nothing else.
export MALLOC_ARENA_MAX=${MALLOC_ARENA_MAX:-1}

folder=${2:-target/endurance}
mkdir -p "$folder"
export AFTERIMAGE_ENDURANCE_ONLY=${3:-}
AFTERIMAGE_ENDURANCE="${1:-200} $(cd "$folder" && pwd)" cargo test -p afterimage-tests endurance -- --nocapture
