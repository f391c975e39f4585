#!/usr/bin/env bash
# Drives the viewer's window as a person would, on a display of its own: tests/view.sh [FOLDER for the screenshots]
# Needs Xvfb, openbox, xdotool and ImageMagick, and takes a few minutes on a processor:
#   apt-get install -y xvfb openbox xdotool imagemagick mesa-vulkan-drivers
set -euo pipefail
cd "$(dirname "$0")/.."

for need in Xvfb openbox xdotool import; do
    command -v "$need" >/dev/null || { sed -n '2,4s/^# //p' "$0" >&2; exit 2; }
done
out=$(mkdir -p "${1:-out/view}" && cd "${1:-out/view}" && pwd)
work=$(mktemp -d)
display=:$((90 + $$ % 100))
export XDG_RUNTIME_DIR=${XDG_RUNTIME_DIR:-/tmp}
cargo build --quiet --workspace --bin afterimage
program=$(realpath "${CARGO_TARGET_DIR:-target}/debug/afterimage")
Xvfb $display -screen 0 1400x900x24 >/dev/null 2>&1 & screen=$!
trap 'kill $screen ${viewer:-} 2>/dev/null; rm -rf "$work"' EXIT
sleep 2
export DISPLAY=$display
# A window that opens while openbox starts is never shown.
openbox >/dev/null 2>&1 &
sleep 3
cp pipelines/lynx.ron "$work/look.ron"
(cd "$work" && exec "$program" view look.ron --size 320x180 --window 1280x720 >"$work/log" 2>&1) & viewer=$!

fail() { echo "failed: $*" >&2; cat "$work/log" >&2; exit 1; }
alive() { kill -0 $viewer 2>/dev/null || fail "the viewer has ended after: $1"; }
settle() { sleep "${1:-3}"; }
# Takes a screenshot. Whether the window shows the same two seconds later.
still() {
    import -window "$window" "$out/$1.png"; alive "$1"
    settle 2
    import -window "$window" "$work/again.png"; alive "$1"
    [ "$(compare -metric AE "$out/$1.png" "$work/again.png" null: 2>&1 | sed 's/[ (].*//')" = 0 ]
}
# A screenshot, once the window is still: a busy machine renders late.
shot() {
    settle
    for _ in $(seq 30); do
        if still "$1"; then echo "$out/$1.png"; return; fi
    done
    fail "the window is never still: $out/$1.png"
}
key() { xdotool windowfocus "$window" key "$@"; }
# The mean difference of the pictures of two screenshots, in codes, above the names that stand where two are compared.
apart() {
    compare -metric MAE -extract 560x310+420+110 "$out/$1.png" "$out/$2.png" null: 2>&1 | sed 's/ .*//' | awk '{ print $1 / 257 }'
}
near() { awk "BEGIN { exit !($(apart "$1" "$2") < 0.7) }" || fail "$1 and $2 are $(apart "$1" "$2") codes apart"; }
far() { awk "BEGIN { exit !($(apart "$1" "$2") > 1.5) }" || fail "$1 and $2 are only $(apart "$1" "$2") codes apart"; }

for _ in $(seq 60); do window=$(xdotool search --onlyvisible --name 'look.ron' | tail -1) && [ -n "$window" ] && break; sleep 1; done
[ -n "${window:-}" ] || fail "there is no window"
xdotool windowmove "$window" 0 0
# Panels alone have few colors.
for _ in $(seq 60); do
    still opened || true
    [ "$(identify -format %k "$out/opened.png")" -gt 5000 ] && break
done
# The scene plays, except on a processor.
for _ in $(seq 5); do still opened && break; done || key space
shot opened
echo "a slider is dragged"
xdotool mousemove --window "$window" 90 40 click 1
settle 1
xdotool type --delay 150 "lit.strength"
shot searched
# The only row: below the field, the one input and the one fact of lynx.ron and the name of the node.
xdotool mousemove --window "$window" 170 219; settle 1
xdotool mousedown 1; settle 1
xdotool mousemove --window "$window" 200 219; settle 1
xdotool mousemove --window "$window" 235 219; settle 1
xdotool mouseup 1
shot dragged
far opened dragged
echo "saved"
before=$(cat "$work/look.ron")
key ctrl+s
settle
[ "$before" != "$(cat "$work/look.ron")" ] || fail "nothing was saved"
[ "$(diff <(echo "$before") "$work/look.ron" | grep -c '^>')" = 1 ] || fail "more than one line differs"
shot saved
near dragged saved
echo "a broken file keeps the picture, a mended one is shown"
sed -i 's/AcesNarkowicz/AcesNarkowich/' "$work/look.ron"
shot broken
near saved broken
sed -i 's/AcesNarkowich/AcesNarkowicz/' "$work/look.ron"
shot mended
near saved mended
echo "compared with the reference, by a wipe, side by side, by the difference"
# The field that was typed into gives the keys up.
key Escape; settle 1
key r; shot wipe; near mended wipe
key b; shot beside; far wipe beside
key d; shot difference; far wipe difference
key r
echo "a wire is clicked, and the result comes back"
# The output `result` of the second node, in the graph below.
xdotool mousemove --window "$window" 375 636 click 1
shot wire; far mended wire
key Escape; shot result; near mended result
echo "exported"
(cd "$work" && ls look*.png >/dev/null 2>&1) && fail "there was a picture before"
key ctrl+e; settle
[ "$(identify -format '%wx%h' "$work/look.png")" = 320x180 ] || fail "no picture of 320x180 was exported"
key h; shot alone; key h
echo "resized and minimized"
for number in $(seq 60); do
    xdotool windowsize "$window" $((640 + number * 137 % 700)) $((400 + number * 89 % 400)); sleep 0.05
done
xdotool windowsize "$window" 1280 720
xdotool windowminimize "$window"; sleep 1; xdotool windowmap "$window"
shot restored
near mended restored
echo "all is well"
