#!/bin/sh
# Lets OpenEXR, OpenImageIO, libpng, libjpeg-turbo, exiftool and LittleCMS read files of every format and label, those
# of the library and those of the program; tifffile judges TIFFs, ffmpeg DPX files, libavif and libjxl what is read of
# theirs, OpenColorIO the tables of `lut`, SciPy, OpenCV and coloraide kinds without Rust, libultrahdr gain maps, and
# ffprobe and PyAV films. Installs the packages of tests/oracles/requirements.txt into a virtual environment:
# target/oracles/venv. CI does not run this. It needs Python 3 with venv and ffmpeg, and reads with exiftool where that
# is installed: apt-get install -y python3-venv ffmpeg libimage-exiftool-perl
set -e
cd "$(dirname "$0")/.."
out="$PWD/target/oracles"
mkdir -p "$out/files"
[ -x "$out/venv/bin/python" ] || python3 -m venv "$out/venv"
"$out/venv/bin/pip" install --quiet -r tests/oracles/requirements.txt
# Decoders that no program has by default have their own tests here.
AFTERIMAGE_ORACLES="$out/files" cargo test --quiet -p afterimage-media --features avif,jxl --test all -- oracles:: avif jxl
"$out/venv/bin/python" tests/oracles/read.py "$out/files"
# The other features of `cargo test --workspace`, so that less compiles twice.
cargo build --quiet --workspace --bin afterimage --features avif,jxl
program="$(cd "${CARGO_TARGET_DIR:-target}" && pwd)/debug/afterimage"
"$out/venv/bin/python" tests/oracles/luts.py "$program" "$out/luts"
"$out/venv/bin/python" tests/oracles/kinds.py "$program" "$out/kinds"
"$out/venv/bin/python" tests/oracles/tiffs.py "$program" "$out/tiffs"
"$out/venv/bin/python" tests/oracles/dpxs.py "$program" "$out/dpxs"
"$out/venv/bin/python" tests/oracles/stills.py "$program" "$out/stills"
"$out/venv/bin/python" tests/oracles/films.py "$program" "$out/films"
"$out/venv/bin/python" tests/oracles/gain_maps.py "$program" "$out/gain_maps" pipelines/scenes/*.exr
exec "$out/venv/bin/python" tests/oracles/written.py "$program" "$out/written"
