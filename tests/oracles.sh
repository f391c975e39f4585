#!/bin/sh
# Lets OpenEXR, libpng and LittleCMS read files of every format and label. Installs the packages of
# tests/oracles/requirements.txt into a virtual environment: target/oracles/venv. CI does not run this.
set -e
cd "$(dirname "$0")/.."
out="$PWD/target/oracles"
mkdir -p "$out/files"
[ -x "$out/venv/bin/python" ] || python3 -m venv "$out/venv"
"$out/venv/bin/pip" install --quiet -r tests/oracles/requirements.txt
AFTERIMAGE_ORACLES="$out/files" cargo test --quiet -p afterimage-media --test all oracles::
exec "$out/venv/bin/python" tests/oracles/read.py "$out/files"
