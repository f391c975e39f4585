#!/usr/bin/env bash
# Checks that the crates which hosts embed compile for other targets, without linking: tests/targets.sh [TARGET...]
# With rustup, add the targets first: rustup target add aarch64-apple-darwin x86_64-pc-windows-gnu ...
# A nightly Rust with rust-src builds the standard library instead: RUSTUP_TOOLCHAIN=nightly BUILD_STD=1 tests/targets.sh
# For Windows that needs the dlltool of Debian's binutils-mingw-w64-x86-64. All four take a quarter of an hour on two cores.
set -euo pipefail
cd "$(dirname "$0")/.."

targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(wasm32-unknown-unknown aarch64-apple-darwin x86_64-pc-windows-gnu aarch64-linux-android)
for target in "${targets[@]}"; do
    echo "$target"
    cargo check ${BUILD_STD:+-Zbuild-std=std,panic_abort} --target "$target" \
        -p afterimage-graph -p afterimage-nodes -p afterimage-plan -p afterimage-gpu
done
