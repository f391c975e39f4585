#!/usr/bin/env bash
# Publishes all crates without uploading them: each is packaged, in order, and built from its package alone, as a user of
# a registry would. Arguments go to cargo, such as `--allow-dirty`. `--no-verify` does not build; the registry is asked.
set -euo pipefail
cd "$(dirname "$0")/.."

# A folder of its own: cargo takes a package of the same version from an earlier run for the same. Debug information
# judges nothing here: packages do not have this workspace's profiles, and would be built with all of it.
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
CARGO_TARGET_DIR="$folder" CARGO_PROFILE_DEV_DEBUG=false CARGO_INCREMENTAL=0 cargo publish --dry-run --workspace "$@"
