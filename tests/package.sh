#!/usr/bin/env bash
# Publishes all crates without uploading them: each is packaged, in order, and built from its package alone, as a user of
# a registry would. Arguments go to cargo, such as `--allow-dirty`. `--no-verify` does not build; the registry is asked.
set -euo pipefail
cd "$(dirname "$0")/.."

# A folder of its own: cargo takes a package of the same version from an earlier run for the same.
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
CARGO_TARGET_DIR="$folder" cargo publish --dry-run --workspace "$@"
