#!/usr/bin/env bash
# Drives the example `window`, a renderer with a window, on a display of its own: tests/window.sh [FOLDER for screenshots]
# Needs Xvfb, openbox, xdotool and ImageMagick, and takes a minute on a processor:
#   apt-get install -y xvfb openbox xdotool imagemagick mesa-vulkan-drivers
set -euo pipefail
cd "$(dirname "$0")/.."

for need in Xvfb openbox xdotool import; do
    command -v "$need" >/dev/null || { sed -n '2,4s/^# //p' "$0" >&2; exit 2; }
done
out=$(mkdir -p "${1:-out/window}" && cd "${1:-out/window}" && pwd)
work=$(mktemp -d)
display=:$((90 + $$ % 100))
export XDG_RUNTIME_DIR=${XDG_RUNTIME_DIR:-/tmp}
cargo build --quiet --workspace --example window
program=${CARGO_TARGET_DIR:-target}/debug/examples/window
Xvfb $display -screen 0 1400x900x24 >/dev/null 2>&1 & screen=$!
trap 'kill $screen ${renderer:-} 2>/dev/null; rm -rf "$work"' EXIT
sleep 2
export DISPLAY=$display
# A window that opens while openbox starts is never shown.
openbox >/dev/null 2>&1 &
sleep 3
"$program" --still "$work/wanted.ppm" 640x360
"$program" --still >"$work/log" 2>&1 & renderer=$!

fail() { echo "failed: $*" >&2; cat "$work/log" >&2; exit 1; }
shot() {
    sleep 1
    import -window "$window" "$out/$1.png"
    kill -0 $renderer 2>/dev/null || fail "the renderer has ended after: $1"
}
# The mean difference of a screenshot from the picture without a window, in codes.
apart() { compare -metric MAE "$work/wanted.ppm" "$out/$1.png" null: 2>&1 | sed 's/ .*//' | awk '{ print $1 / 257 }'; }
# Takes screenshots until one is as it should be: a processor may need seconds for a frame.
until_apart() {
    for _ in $(seq 30); do
        shot "$1"
        awk "BEGIN { exit !($(apart "$1") $2) }" && return
    done
    fail "$1 is $(apart "$1") codes from the picture without a window"
}
same() { until_apart "$1" "< 0.1"; }
other() { until_apart "$1" "> 2"; }
key() { xdotool windowfocus "$window" key "$@"; }
size() { xdotool windowsize "$window" "$@"; sleep 0.4; }

for _ in $(seq 60); do window=$(xdotool search --name 'Afterimage in a window' | tail -1) && [ -n "$window" ] && break; sleep 1; done
[ -n "${window:-}" ] || fail "there is no window"
xdotool windowmove "$window" 0 0
same opened
for to in "900 560" "300 700" "1300 800" "1 1" "640 360"; do size $to; done
same resized
xdotool windowminimize "$window"; sleep 1; xdotool windowmap "$window"
same restored
key s
other split
size 800 300; size 640 360
key s
same joined
key l
for _ in $(seq 30); do grep -q "the device was lost" "$work/log" && break; sleep 1; done
grep -q "the device was lost" "$work/log" || fail "no device was lost"
# What is shown then is new.
size 700 400; size 640 360
same recovered
key t
key t
same tiers
key Escape
for _ in $(seq 20); do kill -0 $renderer 2>/dev/null || break; sleep 0.5; done
kill -0 $renderer 2>/dev/null && fail "Escape does not end it"
echo "the window shows the picture that is made without a window, after resizes, minimizing, a split screen, a lost device"
