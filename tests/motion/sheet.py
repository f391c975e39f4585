#!/usr/bin/env python3
"""A contact sheet of `ultra` and `low` in motion: tests/motion/sheet.py PROGRAM PHOTOGRAPHS FOLDER

Writes graph/docs/motion.jpg: for four pipelines a part of four frames each of a lamp that moves, a pan and a
strobe; `ultra` above `low`. Needs numpy, opencv-python-headless and OpenEXR (pip).
"""

import sys
from pathlib import Path

import cv2
import numpy

import footage
import judge

PIPELINES = ("tsushima", "lynx", "hdr", "mobile")
SEQUENCES = {"lamp": (0, 2, 4, 7), "pan": (0, 2, 4, 7), "strobe": (1, 2, 3, 5)}
# The part of a picture, pixel for pixel, and its corner in each sequence: where something is lit.
TILE = (150, 84)
CORNERS = {"lamp": (105, 78), "pan": (150, 40), "strobe": (50, 48)}
SHEET = judge.ROOT / "graph/docs/motion.jpg"
GAP = 4


def tiles(program, folder, name, tier, patterns):
    output = judge.PIPELINES[name][0]
    for sequence, numbers in SEQUENCES.items():
        shown = folder / f"sheet-{name}-{tier}-{sequence}.####.png"
        wanted = ["--tier", tier, "--no-dither", "--alpha", "drop", "--output", f"{output}={shown}"]
        judge.run(program, "render", judge.ROOT / f"pipelines/{name}.ron", patterns[sequence], *wanted)
        for number in numbers:
            picture = cv2.imread(str(shown).replace("####", f"{number:04}"))
            left, top = CORNERS[sequence]
            yield picture[top : top + TILE[1], left : left + TILE[0]]
        yield numpy.zeros((TILE[1], GAP, 3), numpy.uint8)


def main():
    program, photographs, folder = str(Path(sys.argv[1]).resolve()), sys.argv[2], Path(sys.argv[3]).resolve()
    every = footage.sequences(photographs)
    patterns = {name: footage.write(folder / "footage", name, every[name]) for name in SEQUENCES}
    rows = []
    for name in PIPELINES:
        for tier in ("ultra", "low"):
            rows.append(numpy.concatenate(list(tiles(program, folder, name, tier, patterns)), 1))
        rows.append(numpy.zeros((GAP, rows[0].shape[1], 3), numpy.uint8))
    cv2.imwrite(str(SHEET), numpy.concatenate(rows), [cv2.IMWRITE_JPEG_QUALITY, 74])
    print(f"{SHEET.stat().st_size} bytes")


if __name__ == "__main__":
    main()
