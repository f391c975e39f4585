#!/usr/bin/env bash
# Times and errors of all tiers of the built-in pipelines: tests/tiers.sh FOLDER [IMAGE...]
# Runs the program of AFTERIMAGE, or `afterimage`, on the fastest graphics adapter; takes some ten minutes on a GPU. Times
# are those of the built-in scene at 4K and 1080p. Errors are the worst over the images, a square at night and the charts,
# in their own size, and over eight frames of the walk through the built-in scene at 720p and 4K. What is claimed is judged
# on NEW, images and sequences on which no tier was chosen, separated by spaces. Writes the JSON of every run into the
# folder, and prints graph/docs/measurements/tiers.csv, of which `tests/tiers.py claims` makes what tiers claim.
# Without images, only times are measured, in four minutes: `tests/tiers.py times FOLDER` replaces them in the table.
# WHERE names the device and what errors are of, without commas. PIPELINES has the names of those to measure; otherwise
# all are.
set -euo pipefail
[ $# -ge 1 ] || { sed -n '2,10s/^# //p' "$0" >&2; exit 2; }
folder=$1; shift
program=${AFTERIMAGE:-afterimage}
here=$(dirname "$0")
mkdir -p "$folder"
for file in "$here"/../pipelines/*.ron; do
    name=$(basename "$file" .ron)
    [[ " ${PIPELINES:-$name} " == *" $name "* ]] || continue
    if [ $# -gt 0 ]; then
        "$program" measure "$file" "$@" "$here/../pipelines/scenes/square.exr" --charts --tiers --walk 1 --repeats 1 --json "$folder/$name.json" >/dev/null
        "$program" measure "$file" --tiers --walk 8 --size 1280x720 --size 3840x2160 --repeats 1 --json "$folder/$name.walk.json" >/dev/null
        "$program" measure "$file" ${NEW:?} --tiers --walk 1 --repeats 1 --json "$folder/$name.new.json" >/dev/null
    fi
    for size in 3840x2160 1920x1080; do
        "$program" bench "$file" --size $size --frames 100 --json "$folder/$name.$size.json" >/dev/null
        for tier in $(python3 "$here/tiers.py" names "$folder/$name.json"); do
            "$program" bench "$file" --tier "$tier" --size $size --frames 100 --json "$folder/$name-$tier.$size.json" >/dev/null
        done
    done
done
[ $# -eq 0 ] || python3 "$here/tiers.py" table "$folder" "${WHERE:?}"
