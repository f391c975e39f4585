#!/usr/bin/env python3
"""Measures how far the tone curves bring neighbors in light apart, and prints a table. Optional: no test needs it.

    python3 -m venv v && v/bin/pip install numpy openexr opencv-python-headless
    cargo build --release
    v/bin/python tests/color/hues.py target/release/afterimage [FIELDS...]

Light has 36 hues on the borders of AP0, Rec.2020, P3 and Rec.709, and the same hues of Rec.709 with negative channels:
at five shares of the way to a luminance of 0, and beyond it. It has 65 exposures over 18 stops, with 8 places, 7 of
them at random, in each cell of hue and exposure. A neighbor is brighter by a thousandth, or a channel moves by a
thousandth of the largest one in the direction of the next hue or of gray. The numbers are the largest differences
between neighbors, in codes of 8 bits, of the signal of `ToneMap` and `Encode`, computed exactly and with tables of 64
and 33 entries a side. Without FIELDS, all curves are measured, in two minutes on two cores without a GPU; FIELDS are
parameters of `ToneMap`, such as "curve: Gt7, gamut: Clip".

`encoded` is in thousandths of white what the step of the exact curve is before `Encode`, where the signal has its
largest one: sRGB alone moves a channel near black by 3.3 codes for a thousandth.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

CURVES = (
    "None", "Reinhard", "ReinhardExtended", "ReinhardLuminance", "Exponential", "Aces2ToneScale", "AcesNarkowicz",
    "AcesHill", "Hable", "Uchimura", "Uchimura, linear_length: 0.25, space: Tsushima", "KhronosNeutral", "AgX",
    "AgX, sigmoid: Polynomial", "Gt7",
)
STEP = 1e-3
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
TO_REC709 = {
    "Rec.709": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "P3": [[1.224940, -0.224940, 0], [-0.042057, 1.042057, 0], [-0.019638, -0.078636, 1.098274]],
    "Rec.2020": [[1.660491, -0.587641, -0.072850], [-0.124550, 1.132900, -0.008349], [-0.018151, -0.100579, 1.118730]],
    "AP0": [[2.521686, -1.134131, -0.387555], [-0.276480, 1.372719, -0.096239], [-0.015378, -0.152975, 1.168354]],
}
# Shares of the way from a hue of Rec.709 to a luminance of 0.
SHARES = (0.25, 0.5, 0.75, 0.9, 0.999, 1.001)
RINGS = (*TO_REC709, *(f"{share:g} of the way to no luminance" for share in SHARES))
DIRECTIONS = ("exposure", "hue", "gray")


def hue(turn):
    """The hue at a place from 0 to 6 around the border of a gamut, whose largest channel is 1."""
    offset = np.array([0.0, 4.0, 2.0])
    return (abs((turn[..., None] + offset) % 6 - 3) - 1).clip(0, 1)


def toward_zero(turn, share):
    """A hue of Rec.709 at a share of the way to a luminance of 0."""
    color = hue(turn)
    rest = 1 - color
    return color - share * ((color @ LUMINANCE) / (rest @ LUMINANCE))[..., None] * rest


def ring(index, turn):
    """Light of a hue on one of the rings, in Rec.709."""
    if index < len(TO_REC709):
        return hue(turn) @ np.transpose(list(TO_REC709.values())[index])
    return toward_zero(turn, SHARES[index - len(TO_REC709)])


def light():
    """Light and its three neighbors: directions, rings, places, channels."""
    random = np.random.default_rng(5)
    places = [index.repeat(8) for index in map(np.ravel, np.meshgrid(np.arange(36), np.arange(65), indexing="ij"))]
    turn, row = (at + random.uniform(0, 1, at.shape) * (np.arange(at.size) % 8 > 0) for at in places)
    bright = 2.0 ** (18 * row / 64 - 10)[:, None]
    rings = []
    for index in range(len(RINGS)):
        color = bright * ring(index, turn / 6)
        largest = color.max(-1, keepdims=True)
        rings.append([color, color * (1 + STEP)])
        for way in (bright * ring(index, turn / 6 + 1e-5) - color, largest - color):
            rings[-1].append(color + STEP * largest * way / abs(way).max(-1, keepdims=True))
    return np.stack(rings, 1)


def run(program, folder, colors, fields, encodes, *options):
    """What `ToneMap` makes of colors: codes, or linear light."""
    import cv2
    import OpenEXR

    source, result, pipeline = folder / "in.exr", folder / f"out{'.png' if encodes else '.exr'}", folder / "p.ron"
    pixels = colors.reshape(-1, 1040, 3).astype(np.float32)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"RGB": pixels}) as file:
        file.write(str(source))
    encode = ', "coded": Encode(source: "mapped", format: Rgba32Float)' if encodes else ""
    node = f'"mapped": ToneMap(source: "in", format: Rgba32Float, bake: Auto, {fields})'
    last = "coded" if encodes else "mapped"
    pipeline.write_text(
        f'Pipeline(inputs: {{ "in": Exposed }}, nodes: {{ {node}{encode} }}, outputs: {{ "out": "{last}" }})'
    )
    kind = ("--depth", "16", "--no-dither") if encodes else ("--depth", "32")
    done = subprocess.run([program, "render", pipeline, source, "-o", result, *kind, *options], capture_output=True)
    if done.returncode:
        sys.exit(f"{fields}: {done.stderr.decode()}")
    if encodes:
        return (cv2.imread(str(result), cv2.IMREAD_UNCHANGED)[..., 2::-1] / 257.0).reshape(colors.shape)
    with OpenEXR.File(str(result)) as file:
        channels = file.channels()
        shown = channels["RGBA" if "RGBA" in channels else "RGB"].pixels
    return shown[..., :3].astype(float).reshape(colors.shape)


def steps(shown):
    """The largest difference of a channel from each neighbor: directions, rings, places."""
    return abs(shown[1:] - shown[:1]).max(-1)


def main(program, all_fields):
    folder, colors = Path(tempfile.mkdtemp()), light()
    names = " | ".join(f"{kind}: {direction}" for kind in ("exact", "64", "33") for direction in DIRECTIONS)
    print(f"| fields | {names} | encoded | exact, largest at |\n|---|" + "--:|" * 10 + "---|")
    for fields in all_fields:
        plans = [("--plan", f"bake={bake}") for bake in ("Off", 64, 33)]
        found = [steps(run(program, folder, colors, fields, True, *plan)) for plan in plans]
        row = [f"{step.max():.2f}" for of_bake in found for step in of_bake]
        direction, of_ring, place = np.unravel_index(found[0].argmax(), found[0].shape)
        linear = steps(run(program, folder, colors, fields, False, *plans[0]))[direction, of_ring, place]
        at = ", ".join(f"{channel:.4g}" for channel in colors[0, of_ring, place])
        where = f"{RINGS[of_ring]}: ({at})"
        print(f"| `{fields}` | {' | '.join(row)} | {1000 * linear:.2f} | {where} |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(str(Path(sys.argv[1]).resolve()), sys.argv[2:] or [f"curve: {curve}" for curve in CURVES])
