#!/usr/bin/env bash
# Checks the Bevy plug-in, which is a workspace of its own: tests/bevy.sh. The first build takes half an hour on two cores.
set -euo pipefail
cd "$(dirname "$0")/../graph/bevy"

export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-$(mktemp -d)}" CARGO_RESOLVER_INCOMPATIBLE_RUST_VERSIONS=allow
cargo fmt --check
cargo clippy --ignore-rust-version --all-targets -- -D warnings
cargo test --ignore-rust-version
pictures="$(mktemp -d)"
AFTERIMAGE_SHOT="$pictures/spheres.png" cargo run --ignore-rust-version --example spheres -- lynx.ron
AFTERIMAGE_SHOT="$pictures/walk.png" cargo run --ignore-rust-version --example walk -- tsushima.ron
[ -s "$pictures/spheres.png" ] && [ -s "$pictures/walk.png" ] && echo "$pictures"
