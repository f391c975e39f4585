#!/usr/bin/env bash
# Compares what the crates for hosts export with the lists in tests/public_api/, so that a change of the interface is a
# change of a list. `tests/public_api.sh --bless` writes the lists. It needs cargo-public-api 0.52
# (`cargo install cargo-public-api --locked`). What the lists have is stable between minor versions; items that are
# hidden from the documentation are not in them, and are not.
set -euo pipefail
cd "$(dirname "$0")/.."

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
# The JSON of rustdoc is unstable. For it alone, so that no crate is compiled anew.
printf '#!/bin/sh\nRUSTC_BOOTSTRAP=1 exec rustdoc "$@"\n' > "$folder/rustdoc"
chmod +x "$folder/rustdoc"
status=0
for crate in afterimage afterimage-gpu; do
    features=()
    [ $crate = afterimage-gpu ] || features=(--features offline)
    RUSTDOC=$folder/rustdoc cargo rustdoc --quiet -p $crate --lib "${features[@]}" \
        -- -Z unstable-options --output-format json
    json=${CARGO_TARGET_DIR:-target}/doc/${crate//-/_}.json
    cargo public-api --rustdoc-json "$json" -sss > "$folder/list"
    rm "$json"
    if [ "${1:-}" = --bless ]; then
        cp "$folder/list" tests/public_api/$crate.txt
    elif ! diff -u tests/public_api/$crate.txt "$folder/list"; then
        status=1
    fi
done
exit $status
