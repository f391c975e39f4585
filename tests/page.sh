#!/usr/bin/env bash
# The viewer's page in Chromium: tests/page.sh [FOLDER of the page, else it is built] [FOLDER for the screenshots]
# Needs Chromium, Node with npm, and Python with venv (apt-get install -y chromium nodejs npm python3-venv
# mesa-vulkan-drivers; CHROMIUM=/path/to/it where it lies elsewhere), the network for Playwright and Pillow, and what
# graph/view/web/build.sh needs. Takes ten minutes.
#
# Chromium's WGSL compiler must accept every module that the built-in kinds and pipelines become. The page must show
# lynx.ron and tsushima.ron as the program renders them (dither off, one frame): 99.9 % of the pixels within 1 code, none
# over 4. A broken text must show its errors. Where the page cannot run, and where it does not find what the address names,
# it must say so in sentences; the address must follow the page, and the page the address; and narrow windows must show the
# picture.
set -euo pipefail
cd "$(dirname "$0")/.."

browser=${CHROMIUM:-/usr/bin/chromium}
lacking=()
for need in cargo node npm python3 "$browser"; do command -v "$need" >/dev/null || lacking+=("$need"); done
python3 -c 'import ensurepip' 2>/dev/null || lacking+=("venv for python3: apt-get install python3-venv")
if [ ${#lacking[@]} -gt 0 ]; then
    printf 'page.sh needs %s\n' "${lacking[@]}" >&2
    exit 1
fi

page=${1:-out/page}
[ $# -ge 1 ] || graph/view/web/build.sh "$page"
mkdir -p "${2:-out/page-shots}"
page=$(cd "$page" && pwd) out=$(cd "${2:-out/page-shots}" && pwd)
work=$(mktemp -d)
port=$((20000 + $$ % 20000))
site=http://localhost:$port
export XDG_RUNTIME_DIR=${XDG_RUNTIME_DIR:-/tmp}
program=${CARGO_TARGET_DIR:-target}/debug/afterimage
# The features of `cargo test --workspace`, so that nothing compiles twice.
cargo build --quiet --workspace --bin afterimage --example modules
cp -r "$page" "$work/site"
cp tests/page/page.mjs "$work/"
(cd "$work" && npm install --silent --no-audit --no-fund playwright-core@1)
python3 -m venv "$work/python" && "$work/python/bin/pip" install --quiet pillow
python3 -m http.server "$port" -d "$work/site" >/dev/null 2>&1 & server=$!
trap 'kill $server 2>/dev/null; rm -rf "$work"' EXIT

browse() { (cd "$work" && node page.mjs "$@"); }
seen() { "$work/python/bin/python" tests/page/seen.py "$@"; }
fail() { echo "failed: $*" >&2; exit 1; }

echo "modules"
"${CARGO_TARGET_DIR:-target}/debug/examples/modules" >"$work/site/modules.json"
browse modules "$site/modules.json" || fail "the browser refuses modules"

"$program" demo --size 320x180 --out "$work/scene" >/dev/null 2>&1
cp "$work/scene/scene.exr" "$work/site/"
# The pipeline without its dither, which depends on the number of the frame.
native() {
    sed "/\"display\": Dither/d; s/outputs: { \"display\": \"display\" }/outputs: { \"display\": \"$2\" }/" \
        "pipelines/$1.ron" >"$work/$1.ron"
    "$program" render "$work/$1.ron" "$work/scene/scene.exr" --out "$out/$1-program.png" --no-dither >/dev/null 2>&1
}
for pair in lynx:encoded tsushima:grain; do
    name=${pair%:*}
    echo "$name"
    native "$name" "${pair#*:}"
    browse shot "$site/#pipeline=$name&image=scene.exr&still&bare" "$work/shot.png" 40 || fail "the page of $name has errors"
    seen same "$out/$name-program.png" "$work/shot.png" "$out/$name-page.png" || fail "$name differs"
done

echo "a broken text"
text=$(python3 -c 'import sys, urllib.parse; print(urllib.parse.quote(sys.stdin.read().replace("Narkowicz", "Narkowich")))' \
    <pipelines/lynx.ron)
browse shot "$site/#text=$text&image=scene.exr&still" "$out/broken.png" 15 || fail "the page of a broken text has errors"
seen errors "$out/broken.png" || fail "the errors are not shown"
browse shot "$site/#pipeline=tsushima&image=scene.exr&still" "$out/page.png" 40 || fail "the page has errors"

echo "sentences and addresses"
browse sentences "$site" || fail "the page does not say what is wrong"
browse address "$site" || fail "the address and the page differ"

echo "files that are dropped"
cp "$work/scene/scene.exr" "$work/site/photo.exr"
cp pipelines/caracal.ron "$work/site/dropped.ron"
camera='{ "view": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
    "projection": [[1, 0, 0, 0], [0, 1.8, 0, 0], [0, 0, 0, 0.1], [0, 0, -1, 0]] }'
echo "$camera" >"$work/site/camera.json"
echo "${camera/view/vie}" >"$work/site/broken.json"
browse drop "$site" || fail "what is dropped is not opened"

for size in 390x844 768x1024 1400x900; do
    echo "$size"
    browse shot "$site/#pipeline=tsushima&image=scene.exr&still" "$out/$size.png" 40 "$size" || fail "the page has errors"
    seen picture "$out/$size.png" || fail "no picture at $size"
done
echo "all is well: $out"
