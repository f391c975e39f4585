#!/usr/bin/env bash
# Renders 60 frames as a farm does, from the templates of `afterimage job`: tasks in random order, three at once, one of
# them killed and run again. The files are those of one run, byte for byte, or the differences are printed:
# tests/farm.sh [PROGRAM]. It needs the package openjd-cli of PyPI, in the Python that OPENJD_PYTHON names.
set -euo pipefail
cd "$(dirname "$0")/.."

program=${1:-}
if [ -z "$program" ]; then
    cargo build --release --quiet -p afterimage-cli
    program=${CARGO_TARGET_DIR:-target}/release/afterimage
fi
program=$(realpath "$program")
python=${OPENJD_PYTHON:-python3}
"$python" -c 'import openjd.cli, openjd.model' || { echo "install openjd-cli: pip install openjd-cli" >&2; exit 2; }
driver=$(realpath tests/farm/run_job.py)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

# A walk from the dim end of the room to its window: 2.5 seconds in which the light grows.
cat > walk.ron <<'RON'
Pipeline(
    inputs: {},
    nodes: { "scene": DemoScene(objects: 1) },
    outputs: { "scene": "scene", "depth": "scene.depth" },
)
RON
for frame in $(seq 1 60); do
    time=$(awk "BEGIN { print $frame / 24 }")
    walk=$(awk "BEGIN { print 0.0135 * $frame }")
    outputs=()
    for name in scene depth; do outputs+=(--output "$name=$name.$frame.exr"); done
    "$program" render walk.ron --size 96x54 --depth 32 --set "scene.time=$time" --set "scene.walk=$walk" \
        "${outputs[@]}" 2> /dev/null
done

# The camera of the walk, as `DemoScene::camera` in nodes/src/demo_scene.rs has it.
"$python" - << 'PYTHON'
import json, math

def sub(a, b): return [x - y for x, y in zip(a, b)]
def dot(a, b): return sum(x * y for x, y in zip(a, b))
def unit(a): return [x / math.sqrt(dot(a, a)) for x in a]
def cross(a, b): return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
def mix(a, b, w): return [x + (y - x) * w for x, y in zip(a, b)]

across = 1 / (0.4245 * 96 / 54)
projection = [[across, 0, 0, 0], [0, 1 / 0.4245, 0, 0], [0, 0, 0, 0.1], [0, 0, -1, 0]]
for frame in range(1, 61):
    w = 0.0135 * frame
    w = w * w * (3 - 2 * w)
    eye = mix([1.75, 1.55, 4.7], [-0.45, 1.62, -2.3], w)
    forward = unit(sub(mix([0.15, 1.72, -4.0], [-1.6, 2.0, -8.0], w), eye))
    side = unit(cross(forward, [0, 1, 0]))
    axes = [side, cross(side, forward), [-x for x in forward]]
    view = [[*axis, -dot(axis, eye)] for axis in axes] + [[0, 0, 0, 1]]
    with open(f"camera.{frame}.json", "w") as file:
        json.dump({"view": view, "projection": projection, "jitter": [0, 0]}, file)
PYTHON

# Linear light of two pipelines, for EXR.
"$program" pipelines exposure --write exposure.ron
"$program" pipelines tsushima --write tsushima.ron
echo 'Pipeline(extends: "exposure.ron", outputs: { "light": "exposed" })' > exposed.ron
echo 'Pipeline(extends: "tsushima.ron", outputs: { "light": "lit" })' > lit.ron

job() { "$python" "$driver" "$program" "$@"; }
scene=scene.#.exr
film=(cinematic "$scene" --input depth=depth.#.exr --input camera=camera.#.json --set linear.encoding=Distance)
job exposure "$scene" -o OUT/exposure.#.png
job exposed.ron "$scene" -o OUT/exposed.#.exr
job tsushima "$scene" -o OUT/tsushima.#.png
job lit.ron "$scene" -o OUT/lit.#.exr
job hdr "$scene" --output sdr=OUT/sdr.#.png --output hdr=OUT/hdr.#.png
job "${film[@]}" -o OUT/cinematic.#.png --cut 21,41
for frames in 6 24; do
    job --differs "${film[@]}" -o OUT/cinematic.#.png --preroll "$frames"
done
