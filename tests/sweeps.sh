#!/bin/sh
# Runs the sweeps of all tests whole: `cargo test --workspace` runs a tenth of each. CI does not run this.
set -e
cd "$(dirname "$0")/.."
AFTERIMAGE_SWEEPS=all exec cargo test --workspace "$@"
