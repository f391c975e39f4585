#!/usr/bin/env python3
"""The way of saturated light to white: codes, hues in three spaces, and a neon sign. Optional: no test needs it.

    python3 -m venv v && v/bin/pip install numpy scipy openexr pillow opencolorio opencv-python-headless colour-science
    v/bin/python tests/color/white.py target/release/afterimage graph/docs/measurements/white

Writes white.csv, white.svg and white.jpg. The table has the sRGB codes of six primaries of three gamuts from -4 to 8
stops, for every curve of `ToneMap` with its defaults, for ACES 2.0 (OpenColorIO) and for AgX as three.js has it. The
plot has the way of `ToneMap` with its defaults and of ACES 2.0 in CAM16-UCS, JzAzBz and ICtCp, each seen along its axis
of lightness; dots mark each second stop. The picture has tubes of the six primaries of AP1, of 20 times white, before a
gray wall that they light: above by `ToneMap`, in the middle by ACES 2.0, below by AgX.
"""

import csv
import subprocess
import sys
import tempfile
from pathlib import Path

import colour
import numpy as np
from PIL import Image

import trial

CURVES = (
    "Aces2ToneScale Reinhard ReinhardLuminance ReinhardExtended Exponential AcesNarkowicz AcesHill Hable Uchimura "
    "KhronosNeutral AgX Gt7"
).split()
GAMUTS = {"Rec.709": "ITU-R BT.709", "Rec.2020": "ITU-R BT.2020", "AP1": "ACEScg"}
PRIMARIES = {
    "red": (1, 0, 0),
    "green": (0, 1, 0),
    "blue": (0, 0, 1),
    "cyan": (0, 1, 1),
    "magenta": (1, 0, 1),
    "yellow": (1, 1, 0),
}
STOPS = range(-4, 9)
SPACES = {
    "CAM16-UCS": lambda xyz: colour.XYZ_to_CAM16UCS(xyz)[..., 1:],
    "JzAzBz": lambda xyz: colour.XYZ_to_Jzazbz(100 * xyz)[..., 1:],
    "ICtCp": lambda xyz: colour.RGB_to_ICtCp(
        colour.XYZ_to_RGB(100 * xyz, "ITU-R BT.2020", apply_cctf_encoding=False)
    )[..., 1:],
}
COLORS = {"red": "#c33", "green": "#282", "blue": "#33c", "cyan": "#088", "magenta": "#a2a", "yellow": "#a80"}


def matrix(gamut):
    """From a gamut to linear Rec.709."""
    return colour.matrix_RGB_to_RGB(GAMUTS[gamut], "ITU-R BT.709", "Bradford")


def mapped(program, light, curve):
    """Codes from 0 to 1 of exposed light by a curve of `ToneMap`."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        text = (
            'Pipeline(inputs: { "in": Exposed }, outputs: { "out": "code" }, nodes: { "mapped": '
            f'ToneMap(source: "in", curve: {curve}), "code": Encode(source: "mapped", transfer: Srgb) }})'
        )
        (folder / "p.ron").write_text(text)
        trial.save(folder / "in.exr", light)
        line = [program, "render", folder / "p.ron", folder / "in.exr", "-o", folder / "out.png", "--no-dither"]
        subprocess.run(line, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return np.asarray(Image.open(folder / "out.png").convert("RGB")) / 255


def write_table(path, rows, found):
    names = [f"{stop:+d}" for stop in STOPS]
    with open(path, "w") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["gamut", "primary", "operator", *names])
        for index, (gamut, primary) in enumerate(rows):
            for operator, codes in found.items():
                text = ["%02x%02x%02x" % tuple(np.round(255 * code).astype(int)) for code in codes[index]]
                table.writerow([gamut, primary, operator, *text])


def write_plot(path, rows, found):
    size, gap = 300, 24
    drawn = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {3 * (size + gap) + gap} {size + 56}" '
        'font-family="sans-serif" font-size="12">',
        '<rect width="100%" height="100%" fill="#fff"/>',
        f'<text x="{gap}" y="18">Primaries of Rec.709 and AP1 to white: ToneMap (lines), ACES 2.0 (dashes)</text>',
    ]
    for panel, (name, place) in enumerate(SPACES.items()):
        left, top = gap + panel * (size + gap), 34
        drawn.append(f'<rect x="{left}" y="{top}" width="{size}" height="{size}" fill="none" stroke="#999"/>')
        drawn.append(f'<text x="{left + 6}" y="{top + 16}">{name}</text>')
        ways = {key: place(colour.sRGB_to_XYZ(codes)) for key, codes in found.items()}
        most = max(np.abs(way).max() for way in ways.values()) * 1.05
        for operator, dashes in [("Aces2ToneScale", ""), ("ACES 2.0", 'stroke-dasharray="3 3"')]:
            for index, (gamut, primary) in enumerate(rows):
                if gamut == "Rec.2020":
                    continue
                x, y = ways[operator][index].T / most * size / 2
                points = [(left + size / 2 + u, top + size / 2 - v) for u, v in zip(x, y)]
                text = " ".join(f"{u:.1f},{v:.1f}" for u, v in points)
                drawn.append(f'<polyline points="{text}" fill="none" stroke="{COLORS[primary]}" {dashes}/>')
                if not dashes:
                    dots = [f'<circle cx="{u:.1f}" cy="{v:.1f}" r="1.8"/>' for u, v in points[::2]]
                    drawn += [f'<g fill="{COLORS[primary]}">', *dots, "</g>"]
    Path(path).write_text("\n".join([*drawn, "</svg>\n"]))


def neon():
    """Linear Rec.709 of six tubes before a wall."""
    width, height = 640, 160
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    light = np.full((height, width, 3), 0.02)
    for index, primary in enumerate(PRIMARIES.values()):
        color = np.array(primary) @ matrix("AP1").T
        middle = (index + 0.5) * width / 6
        off = np.hypot(x - middle, np.maximum(np.abs(y - height / 2) - height * 0.3, 0))
        glow = 0.35 / (1 + (off / 14) ** 2)
        light += color * (glow + 20 * np.clip(4.5 - off, 0, 1))[..., None]
    return light


def main(program, stem):
    rows = [(gamut, primary) for gamut in GAMUTS for primary in PRIMARIES]
    light = [[np.array(PRIMARIES[p]) @ matrix(g).T * 2.0**stop for stop in STOPS] for g, p in rows]
    light = np.array(light)
    aces2 = trial.aces2()
    found = {curve: mapped(program, light, curve) for curve in CURVES}
    found |= {"ACES 2.0": aces2(light), "AgX of three.js": trial.agx(light)}
    write_table(f"{stem}.csv", rows, found)
    write_plot(f"{stem}.svg", rows, found)
    wall = neon()
    shown = np.concatenate([mapped(program, wall, "Aces2ToneScale"), aces2(wall), trial.agx(wall)])
    Image.fromarray(np.round(255 * shown).astype(np.uint8)).save(f"{stem}.jpg", quality=88)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
