#!/usr/bin/env bash
# Licenses, bans, sources and advisories of all dependencies on all targets, by the rules of `.cargo/deny.toml` and by
# `cargo audit`: tests/deny.sh
# The plug-in for Bevy and the Python package are workspaces of their own.
# The check takes seconds. Without `cargo deny` and `cargo audit` it builds them in a temporary folder, which takes about
# ten minutes on two cores: CI has `tests/tidy` instead, which compares licenses and sources with the same rules.
# Advisories are those of a clone of RustSec's database, at AFTERIMAGE_ADVISORIES or where `cargo audit` keeps it. The
# script fetches none: status 3 says that everything else was checked, and that there is none.
set -euo pipefail
cd "$(dirname "$0")/.."

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
PATH="$scratch/bin:$PATH"
tool() {
    cargo "$1" --version >/dev/null 2>&1 ||
        CARGO_TARGET_DIR="$scratch/target" cargo install "cargo-$1" --version "$2" --locked --quiet --root "$scratch"
}

tool deny 0.20.2
for workspace in . graph/bevy; do
    (cd "$workspace" && cargo deny --all-features check --hide-inclusion-graph licenses bans sources "$@")
done

database=${AFTERIMAGE_ADVISORIES:-${CARGO_HOME:-$HOME/.cargo}/advisory-db}
if [ ! -d "$database/crates" ]; then
    echo "advisories are NOT checked: $database is no database. One is made by" >&2
    echo "    git clone https://github.com/RustSec/advisory-db $database" >&2
    exit 3
fi
tool audit 0.22.2
echo "advisories of $(git -C "$database" log -1 --format=%cs 2>/dev/null || echo "an unknown date")"
for workspace in . graph/bevy graph/python; do
    cargo audit --no-fetch --db "$database" --file "$workspace/Cargo.lock"
done
