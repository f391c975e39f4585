#!/usr/bin/env bash
# Packages each library crate and builds it from its package alone, as a user of a registry would.
# Arguments go to cargo: `tests/package.sh --offline --allow-dirty`. `--no-verify` packages without a build.
set -euo pipefail
cd "$(dirname "$0")/.."

# All members but what only tests need: a new crate is packaged unless it is listed here.
unpublished=(halftone afterimage-fuzz afterimage-generators afterimage-tidy afterimage-tests)
# A folder of its own: cargo takes a package of the same version from an earlier run for the same.
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
CARGO_TARGET_DIR="$folder" cargo package --workspace "${unpublished[@]/#/--exclude=}" "$@"
