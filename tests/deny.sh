#!/usr/bin/env bash
# Licenses, bans and sources of all dependencies on all targets, by the rules of `.cargo/deny.toml`: tests/deny.sh
# Without `cargo deny` it builds one in a temporary folder, which takes about five minutes on two cores.
# `cargo deny check advisories` is not part of it: it clones a database from GitHub.
set -euo pipefail
cd "$(dirname "$0")/.."

if ! cargo deny --version >/dev/null 2>&1; then
    scratch=$(mktemp -d)
    trap 'rm -rf "$scratch"' EXIT
    CARGO_TARGET_DIR="$scratch/target" cargo install cargo-deny --version 0.20.2 --locked --quiet --root "$scratch"
    PATH="$scratch/bin:$PATH"
fi
cargo deny --all-features check --hide-inclusion-graph licenses bans sources "$@"
