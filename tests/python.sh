#!/usr/bin/env bash
# Checks the Python package, which is a workspace of its own: builds its wheel, installs it into a clean virtual
# environment, and runs its tests there, which compare it with the program: tests/python.sh [PROGRAM [WHEELS]]. It needs
# Python 3.11 or newer with `venv`, and what pip installs. PROFILE=dev builds a slower wheel sooner. The wheel stays in
# the folder WHEELS, target/wheels by default.
set -euo pipefail
cd "$(dirname "$0")/.."

program=${1:-}
if [ -z "$program" ]; then
    cargo build --release --quiet --bin afterimage
    program=${CARGO_TARGET_DIR:-target}/release/afterimage
fi
program=$(realpath "$program")
wheels=${2:-${CARGO_TARGET_DIR:-target}/wheels}
mkdir -p "$wheels"
wheels=$(realpath "$wheels")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-$folder}" PIP_DISABLE_PIP_VERSION_CHECK=1

"${PYTHON:-python3}" -m venv "$folder/build"
"$folder/build/bin/pip" install --quiet 'maturin>=1.16,<2' numpy mypy twine
"$folder/build/bin/mypy" --strict graph/python/python graph/python/examples
rm -f "$wheels"/afterimage_post-*.whl
"$folder/build/bin/maturin" build --manifest-path graph/python/Cargo.toml --locked --profile "${PROFILE:-release}" \
    --out "$wheels"
# What PyPI would refuse, such as a page that it cannot show.
"$folder/build/bin/twine" check --strict "$wheels"/afterimage_post-*.whl

"${PYTHON:-python3}" -m venv "$folder/clean"
"$folder/clean/bin/pip" install --quiet "$wheels"/afterimage_post-*.whl OpenEXR pypng
ls -l "$wheels"
package=$(realpath graph/python)
cd "$folder"
AFTERIMAGE_PROGRAM=$program "$folder/clean/bin/python" -m unittest discover --verbose --start-directory "$package/tests"
"$folder/clean/bin/python" "$package/examples/tsushima.py" "$folder/tsushima.png" 96 54
