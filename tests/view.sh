#!/usr/bin/env bash
# Drives the viewer's window as a person would, on a display of its own: tests/view.sh [FOLDER for the screenshots]
# Each gesture is judged by the file that is saved, by the window's title or by files that are written; screenshots are
# compared where the picture must change, or must not. MINUTES=10 also drags for so long, and measures memory.
# Needs Xvfb, openbox, xdotool, ImageMagick and python-xlib, and takes some minutes on a processor:
#   apt-get install -y xvfb openbox xdotool imagemagick mesa-vulkan-drivers; pip install python-xlib
set -euo pipefail
cd "$(dirname "$0")/.."
tests=$PWD/tests

for need in Xvfb openbox xdotool import; do
    command -v "$need" >/dev/null || { sed -n '2,6s/^# //p' "$0" >&2; exit 2; }
done
python3 -c 'import Xlib' 2>/dev/null || { sed -n '2,6s/^# //p' "$0" >&2; exit 2; }
out=$(mkdir -p "${1:-out/view}" && cd "${1:-out/view}" && pwd)
work=$(mktemp -d)
display=:$((90 + $$ % 100))
export XDG_RUNTIME_DIR=${XDG_RUNTIME_DIR:-/tmp}
[ -n "${AFTERIMAGE:-}" ] || cargo build --quiet --workspace --bin afterimage
program=$(realpath "${AFTERIMAGE:-${CARGO_TARGET_DIR:-target}/debug/afterimage}")
Xvfb $display -screen 0 3840x2160x24 >/dev/null 2>&1 & screen=$!
trap 'kill $screen ${viewer:-} 2>/dev/null; rm -rf "$work"' EXIT
sleep 2
export DISPLAY=$display
# The list of pipelines that were opened before is that of the user otherwise.
export XDG_CACHE_HOME=$work/cache
# A window that opens while openbox starts is never shown.
openbox >/dev/null 2>&1 &
sleep 3

# The dialog of the desktop, which chooses the file that the script names.
mkdir "$work/bin" "$work/files"
printf '#!/bin/sh\ncat "%s/choice"\n' "$work" >"$work/bin/zenity"
chmod +x "$work/bin/zenity"
export PATH=$work/bin:$PATH

# A picture, its depth and its camera.
cd "$work/files"
cat >scene.ron <<'RON'
Pipeline(inputs: {}, nodes: { "scene": DemoScene() }, outputs: { "scene": "scene", "depth": "scene.depth" })
RON
"$program" render scene.ron --size 320x180 --output scene=photo.exr --output depth=z.exr --depth 32 2>/dev/null
cat >camera.json <<'JSON'
{ "view": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], "jitter": [0, 0],
  "projection": [[1.3, 0, 0, 0], [0, 2.35, 0, 0], [0, 0, 0, 0.1], [0, 0, -1, 0]] }
JSON
# A comment, tabs and the line ends of Windows, which every gesture leaves.
sed 's/$/\r/' >look.ron <<'RON'
// A look with a comment.
Pipeline(
	inputs: { "scene": Color, "depth": Depth(optional: true), "camera": Camera(optional: true) },
	usual: { "lit.strength": "factor of the bloom" },
	nodes: {
		"linear": LinearDepth(depth: "depth", camera: "camera", encoding: Distance), // in meters
		"foggy": Fog(source: "scene", depth: "linear", camera: "camera", density: 0.2),
		"exposed": Exposure(source: "foggy"),
		"bright": Extract(source: "exposed", threshold: 1.0),
		"mips": Downsample(source: "bright", levels: 4),
		"bloom": Upsample(source: "mips"),
		"lit": Composite(base: "exposed", bloom: "bloom", strength: 0.1),
		"mapped": ToneMap(source: "lit", curve: AcesNarkowicz),
		"display": Encode(source: "mapped", transfer: Srgb),
	},
	outputs: { "display": "display" },
)
RON
cp look.ron first.ron
cat >grade.ron <<'RON'
Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "exposed": Exposure(source: "scene"),
        "balance": WhiteBalance(source: "exposed"),
        "mapped": ToneMap(source: "balance", curve: AcesNarkowicz),
        "bent": Curves(source: "mapped"),
        "display": Encode(source: "bent", transfer: Srgb),
    },
    outputs: { "display": "display" },
)
RON
"$program" check look.ron >/dev/null

# Places in a window of 1280x720, for `click` and `drag`. The graph is another one after each edit.
more_of_scene=(236 93) path_of_depth=(165 117) more_of_camera=(236 141) picture=(700 250)
strength=(185 192 215 192) weaker=(215 192 130 192)
row_of_depth=(50 117) thumbnails=(333 527) small=(333 403) text=(72 527)
pick=(212 175) wall=(400 340) bent=(770 624) curve=(156 247 156 210) menu=(44 12) before=(50 112)
rewire=(939 636 455 633) wire=(796 681) node=(700 661) output=(571 638)

fail() { echo "failed: $*" >&2; cat "$work/log" >&2; exit 1; }
alive() { kill -0 $viewer 2>/dev/null || fail "the viewer has ended after: $1"; }
settle() { sleep "${1:-3}"; }
title() { xdotool getwindowname "$window"; }
# Whether the title begins with a text, once a busy machine has come to it.
titled() {
    for _ in $(seq 30); do [[ $(title) == "$1"* ]] && return; sleep 1; done
    fail "the title is $(title), and not $1"
}
# Opens a window of a size in points, at a scale.
open_window() {
    WINIT_X11_SCALE_FACTOR=$2 "$program" view "${@:3}" --window "$1" >"$work/log" 2>&1 & viewer=$!
    for _ in $(seq 60); do window=$(xdotool search --onlyvisible --name 'Afterimage$' | tail -1) && [ -n "$window" ] && break; sleep 1; done
    [ -n "${window:-}" ] || fail "there is no window"
    xdotool windowmove "$window" 0 0
}
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
# A screenshot, once the picture is there: panels alone have few colors.
opened() {
    for _ in $(seq 60); do
        still "$1" || true
        [ "$(identify -format %k "$out/$1.png")" -gt 5000 ] && return
    done
    fail "there is no picture: $out/$1.png"
}
key() { xdotool windowfocus "$window" key "$@"; settle 1; }
click() { xdotool mousemove --window "$window" "$1" "$2" click "${3:-1}"; settle 1; }
drag() {
    xdotool mousemove --window "$window" "$1" "$2"; settle 1
    xdotool mousedown 1; settle 1
    xdotool mousemove --window "$window" $((($1 + $3) / 2)) $((($2 + $4) / 2)); settle 1
    xdotool mousemove --window "$window" "$3" "$4"; settle 2
    xdotool mouseup 1; settle 1
}
# Drops a file on a place of the window.
drop() { python3 "$tests/drag_source.py" "$window" "$1" "$2" "$3" || fail "$3 cannot be dropped"; settle 2; }
# The number of colors of the graph: boxes and wires have few.
colors() { convert "$out/$1.png" -crop 1260x140+10+560 -format %k info:; }
# The parameters from the first one on.
top() { xdotool mousemove --window "$window" 150 300 click --repeat 60 --delay 20 4; settle 2; }
words() { xdotool type --delay 150 "$1"; settle 1; }
# The mean difference of the pictures of two screenshots, in codes, above the names that stand where two are compared.
apart() {
    compare -metric MAE -extract 560x250+420+150 "$out/$1.png" "$out/$2.png" null: 2>&1 | sed 's/ .*//' | awk '{ print $1 / 257 }'
}
near() { awk "BEGIN { exit !($(apart "$1" "$2") < 0.7) }" || fail "$1 and $2 are $(apart "$1" "$2") codes apart"; }
far() { awk "BEGIN { exit !($(apart "$1" "$2") > 1.5) }" || fail "$1 and $2 are only $(apart "$1" "$2") codes apart"; }
# Ends a window without changes.
close_window() { key ctrl+q; wait $viewer || fail "it ends with $?"; viewer=; window=; }
# Saves. Whether the file has a text, and otherwise differs from another one by so many lines.
saved_with() {
    key ctrl+s; settle 2
    grep -qF -- "$1" look.ron || fail "$2: the file has no $1"
    differing=$(diff "$3" look.ron | grep -c '^>' || true)
    [ "$differing" = "$4" ] || fail "$2: $differing lines differ, and not $4"
    [ "$(grep -c $'\r$' look.ron)" = "$(grep -c '' look.ron)" ] || fail "$2: a line end is another one"
    cp look.ron "$work/$2.ron"
}

echo "opened at three sizes"
for size in 1440x900@1 3840x2160@2 1280x720@1; do
    points=${size%@*} scale=${size#*@}
    [ "$scale" = 1 ] || points=1920x1080
    open_window "$points" "$scale" look.ron --size 320x180
    opened "opened-$size"
    [ "$scale" = 1 ] || { kill $viewer; wait $viewer 2>/dev/null || true; continue; }
    [ "$size" = 1280x720@1 ] || { key ctrl+q; wait $viewer || fail "Ctrl+Q ends with $?"; }
done
# The scene plays, except on a processor.
for _ in $(seq 5); do still opened && break; done || key space
shot opened

echo "each input is chosen: in the dialog of the desktop, by its path, in the dialog"
echo "$work/files/photo.exr" >"$work/choice"
click "${more_of_scene[@]}"; settle
[[ $(title) == *photo.exr* ]] || fail "the title is $(title)"
shot chosen
click "${path_of_depth[@]}"; words z.exr; key Return
echo "$work/files/camera.json" >"$work/choice"
click "${more_of_camera[@]}"
shot inputs; far chosen inputs

echo "a parameter is dragged and saved: one line differs"
drag "${strength[@]}"
shot dragged; far inputs dragged
[[ $(title) == *\** ]] || fail "nothing is unsaved: $(title)"
key ctrl+s; settle
[ "$(diff first.ron look.ron | grep -c '^>')" = 1 ] || fail "more than one line differs"
cp look.ron "$work/dragged.ron"
strong=$(grep -o 'strength: [0-9.]*' look.ron)

echo "a snapshot is taken, compared with and gone back to"
key ctrl+1
drag "${weaker[@]}"
shot weaker; far dragged weaker
key alt+1; key Escape; key d; shot difference; far weaker difference
key w; key alt+1
key ctrl+alt+1
saved_with "$strong" snapshot "$work/dragged.ron" 0

echo "a wire is dragged from an input to another output"
drag "${rewire[@]}"
shot rewired; far dragged rewired
saved_with '"mapped": ToneMap(source: "exposed"' rewired "$work/dragged.ron" 1

echo "a kind is inserted on a wire"
click "${wire[@]}"; words vign; key Return
shot inserted
saved_with '"vignette": Vignette(source: "mapped")' inserted "$work/rewired.ron" 2

echo "a node is renamed where it is read, too"
click "${node[@]}"; key F2; key ctrl+a; words tone; key Return
shot renamed
saved_with '"tone": ToneMap(source: "exposed"' renamed "$work/inserted.ron" 2
grep -qF 'Vignette(source: "tone")' look.ron || fail "a reader has the old name"

echo "undone to the beginning: the bytes of before"
for _ in $(seq 20); do key ctrl+z; done
shot undone; near undone inputs
key ctrl+s; settle
cmp look.ron first.ron || fail "the bytes are others"

echo "a broken file keeps the picture, a mended one is shown"
sed -i 's/AcesNarkowicz/AcesNarkowich/' look.ron; shot broken; near undone broken
sed -i 's/AcesNarkowich/AcesNarkowicz/' look.ron; shot mended; near undone mended

echo "compared with the reference, by a wipe, side by side, by the difference, in figures"
key Escape; key r; shot wipe; near mended wipe
key b; shot beside; far wipe beside
key d; shot difference; far wipe difference
key e; settle 5; shot measured
key w; key r

echo "a wire is shown, and the result comes back"
click "${output[@]}"; shot wire; far mended wire
click "${picture[@]}"; key Escape; shot result; near mended result

echo "exported"
ls look*.png >/dev/null 2>&1 && fail "there was a picture before"
key ctrl+e; settle
[ "$(identify -format '%wx%h' look.png)" = 320x180 ] || fail "no picture of 320x180 was exported"
key h; shot alone; key h

echo "saved as another file, which the check accepts"
key ctrl+shift+s; key ctrl+a; words second.ron; key Return; settle
cmp second.ron first.ron || fail "the second file is another one"
titled second.ron
"$program" check second.ron >/dev/null

echo "resized and minimized"
for number in $(seq 60); do
    xdotool windowsize "$window" $((640 + number * 137 % 700)) $((400 + number * 89 % 400)); sleep 0.05
done
xdotool windowsize "$window" 1280 720
xdotool windowminimize "$window"; sleep 1; xdotool windowmap "$window"
shot restored; near result restored

if [ "${MINUTES:-0}" != 0 ]; then
    echo "dragged for $MINUTES minutes with everything on"
    memory() { awk '/VmRSS/ { print int($2 / 1024) }' /proc/$viewer/status; }
    top
    click "${picture[@]}"; key p; click "${picture[@]}"; key r; key space
    read -r x y x2 _ <<<"${strength[*]}"
    xdotool mousemove --window "$window" "$x" "$y" mousedown 1
    end=$(($(date +%s) + 60 * MINUTES)) middle=$(($(date +%s) + 30 * MINUTES)) half=
    while [ "$(date +%s)" -lt $end ]; do
        for at in $x $x2; do xdotool mousemove --window "$window" "$at" "$y"; sleep 0.1; done
        [ -n "$half" ] || [ "$(date +%s)" -lt $middle ] || { half=$(memory); import -window "$window" "$out/everything.png"; }
    done
    xdotool mouseup 1
    whole=$(memory)
    echo "$half MiB after half of the time, $whole MiB after all"
    [ $((20 * whole)) -le $((21 * half)) ] || fail "memory grows by more than 5 %"
    # Keys are those of the picture while it has the focus.
    click "${picture[@]}"; key space; key r; key p; key ctrl+z
fi

echo "closed: a question is asked while something is unsaved, and the process ends well"
top
drag "${strength[@]}"
key ctrl+q; alive "Ctrl+Q with changes"
shot question
key Escape; key ctrl+z; close_window

echo "what is gray is picked, and a point of a curve is dragged"
open_window 1280x720 1 grade.ron photo.exr
opened grade
click "${pick[@]}"; shot picking
click "${wall[@]}"
shot picked; far grade picked
click "${bent[@]}"; settle
drag "${curve[@]}"
shot bent; far picked bent
key ctrl+s; settle
for change in 'mode: Temperature' 'temperature: ' 'luminance_middle: ('; do
    grep -qF "$change" grade.ron || fail "grade.ron has no $change"
done
"$program" check grade.ron >/dev/null

echo "a pipeline that was opened before is opened again"
click "${menu[@]}"; shot menu
click "${before[@]}"; settle
titled second.ron
close_window

echo "files are dropped: on the picture, on the row of an input, a pipeline on the window"
cp z.exr 0001.exr
open_window 1280x720 1 look.ron --size 320x180
opened scene
drop "${picture[@]}" photo.exr
titled "look.ron – photo.exr"
drop "${picture[@]}" camera.json
shot without-depth
# Its name does not tell its input: the place does.
drop "${row_of_depth[@]}" 0001.exr
shot with-depth; far without-depth with-depth
titled "look.ron – photo.exr"
drop "${picture[@]}" grade.ron
titled "grade.ron – photo.exr"

echo "wires have small pictures on request"
opened small
few=$(colors small)
click "${thumbnails[@]}"
for _ in $(seq 30); do settle; still thumbnails || true; [ "$(colors thumbnails)" -gt $((4 * few)) ] && break; done
[ "$(colors thumbnails)" -gt $((4 * few)) ] || fail "the graph has $(colors thumbnails) colors, and $few before"
click "${small[@]}"

echo "a value is completed in the text"
click "${text[@]}"
key ctrl+f; words Srgb; key Escape; key BackSpace BackSpace BackSpace BackSpace; words L
key ctrl+space; shot completion
key Return; key ctrl+s; settle
grep -qF 'transfer: Linear' grade.ron || fail "grade.ron has no Linear: $(grep transfer grade.ron)"
close_window
echo "all is well"
