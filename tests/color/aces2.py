#!/usr/bin/env python3
"""Compares Aces2Output with OpenColorIO's built-in ACES 2.0 output transforms. Optional: no test needs it.

    python3 -m venv v && v/bin/pip install opencolorio==2.6.0 numpy openexr
    v/bin/python tests/color/aces2.py compare target/release/afterimage  # a dense set through the program: a table
    v/bin/python tests/color/aces2.py vectors > tests/vectors/aces2.txt  # the reference values of the Rust tests
    v/bin/python tests/color/aces2.py gamut > tests/vectors/gamut_compress.txt

Differences are of display-linear light in the primaries of the display, where 1 is 100 cd/m2. The exit status of
`compare` is 1 if one is above 0.001.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import PyOpenColorIO as ocio

D65 = (0.3127, 0.3290)
ACES = (0.32168, 0.33767)
PRIMARIES = {
    "Rec709": ((0.640, 0.330), (0.300, 0.600), (0.150, 0.060), D65),
    "P3": ((0.680, 0.320), (0.265, 0.690), (0.150, 0.060), D65),
    "Rec2020": ((0.708, 0.292), (0.170, 0.797), (0.131, 0.046), D65),
    "AP0": ((0.7347, 0.2653), (0.0, 1.0), (0.0001, -0.0770), ACES),
}
BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
DISPLAYS = [("Rec709", 100), ("P3", 100)] + [(g, n) for n in (500, 1000, 2000, 4000) for g in ("P3", "Rec2020")]


def to_xyz(space):
    """Linear RGB to XYZ, from primaries (SMPTE RP 177)."""
    *primaries, (x, y) = PRIMARIES[space]
    matrix = np.array([[px, py, 1 - px - py] for px, py in primaries]).T
    return matrix @ np.diag(np.linalg.solve(matrix, [x / y, 1, (1 - x - y) / y]))


def conversion(source, target):
    """Linear RGB to linear RGB, whites adapted by Bradford."""
    a, b = to_xyz(source), to_xyz(target)
    adapt = np.linalg.inv(BRADFORD) @ np.diag((BRADFORD @ b.sum(1)) / (BRADFORD @ a.sum(1))) @ BRADFORD
    return np.linalg.inv(b) @ adapt @ a


def reference(rec709, gamut, peak):
    """OpenColorIO's result for linear Rec.709, in the primaries of the display; 1 is 100 cd/m2."""
    names = {"Rec709": "REC709", "P3": "P3-D65", "Rec2020": "REC2020"}
    name = f"{'SDR' if peak == 100 else 'HDR'}-{peak}nit-{names[gamut]}_2.0"
    transform = ocio.BuiltinTransform(f"ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - {name}")
    processor = ocio.Config.CreateRaw().getProcessor(transform)
    cpu = processor.getOptimizedCPUProcessor(ocio.BIT_DEPTH_F32, ocio.BIT_DEPTH_F32, ocio.OPTIMIZATION_NONE)
    pixels = np.ascontiguousarray(rec709 @ conversion("Rec709", "AP0").T, dtype=np.float32).reshape(1, -1, 3)
    cpu.apply(ocio.PackedImageDesc(pixels, pixels.shape[1], 1, 3))
    return pixels[0].astype(float) @ np.linalg.inv(to_xyz(gamut)).T


def dense():
    """65536 colors: a cube, any saturation over 16 stops, and the corners of Rec.709 over 16 stops."""
    random = np.random.default_rng(7)
    side = np.linspace(0, 1, 25)
    cube = np.stack(np.meshgrid(side, side, side), -1).reshape(-1, 3)
    wide = 2.0 ** random.uniform(-9, 7, (24000, 3))
    narrow = random.uniform(0, 1, (24000, 3)) * 2.0 ** random.uniform(-6, 6, (24000, 1))
    corners = np.array([[r, g, b] for r in (0, 1) for g in (0, 1) for b in (0, 1)][1:])
    ramps = (corners[None] * 2.0 ** np.linspace(-8, 8, 273)[:, None, None]).reshape(-1, 3)
    return np.vstack([cube, wide, narrow, ramps])[:65536].astype(np.float32).astype(float)


def sparse():
    """80 colors: special ones, and some of each population of `dense`."""
    special = [[0.18] * 3, [0] * 3, [1] * 3, [65504] * 3]
    special += [[65504, 0, 0], [0, 65504, 1e-6], [0, 0, 65504], [16, 0.5, 0.1]]
    fire = [[2.0**stop * channel for channel in (1, 0.25, 0.04)] for stop in (-2, 0, 2, 4, 6)]
    rows = dense()
    return np.vstack([special, fire, rows[:: len(rows) // 66]])[:80].astype(np.float32).astype(float)


PIPELINE = """Pipeline(
    inputs: {{ "scene": Exposed }},
    nodes: {{ "shown": Aces2Output(
        source: "scene", gamut: {gamut}, peak: {peak}, white_nits: 100.0, middle_gray: Native,
        format: Rgba32Float,
    ) }},
    outputs: {{ "display": "shown" }},
)"""


def rendered(program, folder, rec709, gamut, peak):
    """The program's result, in the primaries of the display."""
    import OpenEXR

    side = 256
    pixels = np.zeros((side * side, 3), np.float32)
    pixels[: len(rec709)] = rec709
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    source, result, pipeline = (folder / name for name in ("in.exr", "out.exr", "pipeline.ron"))
    with OpenEXR.File(header, {"RGB": pixels.reshape(side, side, 3)}) as file:
        file.write(str(source))
    pipeline.write_text(PIPELINE.format(gamut=gamut, peak=peak / 100))
    subprocess.run([program, "render", pipeline, source, "-o", result, "--depth", "32"], check=True, capture_output=True)
    with OpenEXR.File(str(result)) as file:
        channels = file.channels()
        shown = channels["RGBA" if "RGBA" in channels else "RGB"].pixels[..., :3]
    return shown.reshape(-1, 3)[: len(rec709)].astype(float)


def compare(program):
    colors, largest = dense(), 0.0
    print("| display | largest difference | 99.9 % below |\n|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for gamut, peak in DISPLAYS:
            ours = rendered(program, Path(folder), colors, gamut, peak)
            off = np.abs(ours - reference(colors, gamut, peak)).max(1)
            largest = max(largest, off.max())
            print(f"| {gamut}, {peak} cd/m2 | {off.max():.5f} | {np.quantile(off, 0.999):.5f} |")
    sys.exit(not largest <= 0.001)


def vectors():
    print(f"# ACES 2.0 output transforms of OpenColorIO {ocio.__version__}, made by tests/color/aces2.py vectors.")
    print("# Display, peak in cd/m2, linear Rec.709, and the display's linear RGB in units of 100 cd/m2.")
    colors = sparse()
    for gamut, peak in DISPLAYS:
        for source, shown in zip(colors, reference(colors, gamut, peak)):
            print(gamut, peak, *(f"{x:.9g}" for x in source), *(f"{x:.6g}" for x in shown))


def gamut():
    print(f"# The reference gamut compression of ACES 1.3 in OpenColorIO {ocio.__version__}: tests/color/aces2.py gamut.")
    print("# Linear Rec.709, and linear Rec.709.")
    processor = ocio.Config.CreateRaw().getProcessor(
        ocio.BuiltinTransform("ACES-LMT - ACES 1.3 Reference Gamut Compression")
    )
    cpu = processor.getOptimizedCPUProcessor(ocio.BIT_DEPTH_F32, ocio.BIT_DEPTH_F32, ocio.OPTIMIZATION_NONE)
    random = np.random.default_rng(3)
    colors = random.uniform(-0.3, 1, (60, 3)) * 2.0 ** random.uniform(-4, 4, (60, 1))
    pixels = np.ascontiguousarray(colors @ conversion("Rec709", "AP0").T, dtype=np.float32).reshape(1, -1, 3)
    cpu.apply(ocio.PackedImageDesc(pixels, pixels.shape[1], 1, 3))
    for source, result in zip(colors, pixels[0].astype(float) @ conversion("AP0", "Rec709").T):
        print(*(f"{x:.9g}" for x in source), *(f"{x:.7g}" for x in result))


if __name__ == "__main__":
    if sys.argv[1:2] == ["vectors"]:
        vectors()
    elif sys.argv[1:2] == ["gamut"]:
        gamut()
    elif sys.argv[1:2] == ["compare"] and len(sys.argv) == 3:
        compare(sys.argv[2])
    else:
        sys.exit(__doc__)
