#!/usr/bin/env bash
# Writes a crate with a new node kind in Rust (`afterimage nodes --new NAME --rust`), and runs its tests and its program.
# It takes some minutes, since the crate is a workspace of its own. CARGO_TARGET_DIR may name a folder to keep.
set -euo pipefail
cd "$(dirname "$0")/.."

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
target=${CARGO_TARGET_DIR:-$folder/target}
mkdir -p "$target"
# The crate lies in another folder.
export CARGO_TARGET_DIR=$(realpath "$target")
repository=$PWD
cargo build -p afterimage-cli
program=$CARGO_TARGET_DIR/debug/afterimage
cd "$folder"
"$program" nodes --new SoftGlow --rust --repository "$repository"
cd soft_glow
# The versions of the repository.
cp "$repository/Cargo.lock" .
cargo test
cargo run --example program -- render soft_glow.ron -o soft_glow.png --size 640x360
test -s soft_glow.png
