#!/usr/bin/env bash
# Licenses, bans and sources of all dependencies on all targets, by the rules of `.cargo/deny.toml`: tests/deny.sh
# The Bevy plug-in is a workspace of its own, with rules of its own.
# The check takes two seconds. Without `cargo deny` it builds one in a temporary folder, which takes about five minutes on
# two cores: CI has `tests/tidy` instead, which compares licenses and sources with the same rules.
# `cargo deny check advisories` is not part of it: it clones a database from GitHub.
set -euo pipefail
cd "$(dirname "$0")/.."

if ! cargo deny --version >/dev/null 2>&1; then
    scratch=$(mktemp -d)
    trap 'rm -rf "$scratch"' EXIT
    CARGO_TARGET_DIR="$scratch/target" cargo install cargo-deny --version 0.20.2 --locked --quiet --root "$scratch"
    PATH="$scratch/bin:$PATH"
fi
for workspace in . graph/bevy; do
    (cd "$workspace" && cargo deny --all-features check --hide-inclusion-graph licenses bans sources "$@")
done
