#!/usr/bin/env bash
# Runs the rounds of tests/endurance.rs and writes a table and a plot: tests/endurance.sh [ROUNDS [FOLDER]]
# 200 rounds, the default, are 10 000 reloads, 5 000 resizes, 20 000 frames and 200 openings of a device.
set -euo pipefail
cd "$(dirname "$0")/.."

folder=${2:-target/endurance}
mkdir -p "$folder"
AFTERIMAGE_ENDURANCE="${1:-200} $(cd "$folder" && pwd)" cargo test -p afterimage-tests endurance -- --nocapture
