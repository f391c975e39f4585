#!/usr/bin/env bash
# Builds the viewer for browsers: graph/view/web/build.sh [FOLDER]. Any static host can serve the folder, `out/page` by
# default, as it is and under any path.
# With rustup, first: rustup target add wasm32-unknown-unknown; cargo install wasm-bindgen-cli --version 0.2.130
# A nightly Rust with rust-src builds the standard library instead: RUSTUP_TOOLCHAIN=nightly BUILD_STD=1 graph/view/web/build.sh
# wasm-opt would make the program 8 % smaller, but what a browser loads not.
set -euo pipefail
cd "$(dirname "$0")/../../.."

out=${1:-out/page}
target=${CARGO_TARGET_DIR:-target}
version=$(grep -A1 '^name = "wasm-bindgen"$' Cargo.lock | sed -n 's/^version = "\(.*\)"$/\1/p')
lacking=()
command -v cargo >/dev/null || lacking+=("cargo, of rustup: https://rustup.rs")
library=$(rustc --print sysroot 2>/dev/null)/lib/rustlib/wasm32-unknown-unknown/lib
[ -n "${BUILD_STD:-}" ] || [ -d "$library" ] || lacking+=("the target: rustup target add wasm32-unknown-unknown")
found=$(wasm-bindgen --version 2>/dev/null || echo "none")
[ "$found" = "wasm-bindgen $version" ] ||
    lacking+=("wasm-bindgen $version, not $found: cargo install wasm-bindgen-cli --version $version")
command -v gzip >/dev/null || lacking+=("gzip")
if [ ${#lacking[@]} -gt 0 ]; then
    printf 'build.sh needs %s\n' "${lacking[@]}" >&2
    exit 1
fi

# Every browser with WebGPU has SIMD, and the program is smaller with it.
export RUSTFLAGS="${RUSTFLAGS:-} -Ctarget-feature=+simd128"
cargo build --profile page ${BUILD_STD:+-Zbuild-std=std,panic_abort} --target wasm32-unknown-unknown \
    -p afterimage-view --bin afterimage-page --features page
mkdir -p "$out"
wasm=$out/afterimage-page_bg.wasm
wasm-bindgen --target web --no-typescript --out-dir "$out" "$target/wasm32-unknown-unknown/page/afterimage-page.wasm"
bytes=$(stat -c %s "$wasm" 2>/dev/null || stat -f %z "$wasm")
gzip -9 -n -f "$wasm"
compressed=$(stat -c %s "$wasm.gz" 2>/dev/null || stat -f %z "$wasm.gz")
stamp=$(cksum <"$wasm.gz" | cut -d ' ' -f 1)
sed "s/^const BYTES = 0;/const BYTES = $compressed;/; s/^const VERSION = \"\";/const VERSION = \"?$stamp\";/" \
    graph/view/web/index.html >"$out/index.html"
cp graph/view/web/still.exr "$out/"
echo "$out: $bytes bytes of program, $compressed on the way; serve it, for example: python3 -m http.server -d $out"
