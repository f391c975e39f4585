#!/usr/bin/env bash
# Builds the viewer for browsers: graph/view/web/build.sh [FOLDER]. The folder, `out/page` by default, can be served as it is.
# With rustup, first: rustup target add wasm32-unknown-unknown; cargo install wasm-bindgen-cli --version 0.2.130
# A nightly Rust with rust-src builds the standard library instead: RUSTUP_TOOLCHAIN=nightly BUILD_STD=1 graph/view/web/build.sh
set -euo pipefail
cd "$(dirname "$0")/../../.."

out=${1:-out/page}
target=${CARGO_TARGET_DIR:-target}
cargo build --release ${BUILD_STD:+-Zbuild-std=std,panic_abort} --target wasm32-unknown-unknown \
    -p afterimage-view --bin afterimage-page --features page
mkdir -p "$out"
wasm-bindgen --target web --no-typescript --out-dir "$out" "$target/wasm32-unknown-unknown/release/afterimage-page.wasm"
cp graph/view/web/index.html "$out/"
echo "$out: $(du -sh "$out" | cut -f1); serve it, for example: python3 -m http.server -d $out"
