#!/usr/bin/env python3
"""Compares the color files of `ColorLut` and `Cdl` with OpenColorIO. Optional: no test needs it.

    pip install opencolorio numpy
    cargo build -p afterimage-color --example color_file
    python3 tests/color/compare_ocio.py target/debug/examples/color_file

For each kind of process node it writes a file, evaluates it over about 56 000 colors with OpenColorIO (32 bits,
without optimizations) and with the double-precision version of Afterimage, and prints the largest difference, divided
by the larger of 1 and the value. The files of graph/color/tests/files follow. The exit status is 1 above 1e-4.
"""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np
import PyOpenColorIO as ocio

FILES = pathlib.Path(__file__).parents[2] / "graph/color/tests/files"


def process_list(*nodes):
    return '<ProcessList id="test" compCLFversion="3.0">\n%s\n</ProcessList>' % "\n".join(nodes)


def node(name, body, depths=("32f", "32f"), **attributes):
    attributes = "".join(f' {key}="{value}"' for key, value in attributes.items())
    return f'<{name} inBitDepth="{depths[0]}" outBitDepth="{depths[1]}"{attributes}>{body}</{name}>'


def array(dim, values):
    return '<Array dim="%s">\n%s\n</Array>' % (dim, "\n".join(f"{value:.9g}" for value in values))


def cdl(style):
    sop = "<Slope>1.1 0.9 1.3</Slope><Offset>0.05 -0.1 0.02</Offset><Power>1.2 0.8 2.0</Power>"
    sat = "<Saturation>1.3</Saturation>"
    return node("ASC_CDL", f"<SOPNode>{sop}</SOPNode><SatNode>{sat}</SatNode>", style=style)


def log(style, **params):
    params = "".join(f' {key}="{value}"' for key, value in params.items())
    return node("Log", f"<LogParams{params}/>" if params else "", style=style)


def exponent(style):
    curve = ' offset="0.055"' if style.startswith("monCurve") else ""
    channels = zip("RGB", (2.4, 1.8, 3.0))
    return node("Exponent", "".join(f'<ExponentParams channel="{c}" exponent="{g}"{curve}/>' for c, g in channels), style=style)


def bounds(style, **values):
    body = "".join(f"<{key}>{value}</{key}>" for key, value in values.items())
    return node("Range", body, ("10i", "12i"), **({"style": style} if style else {}))


def half_curve():
    halves = np.arange(65536, dtype=np.uint16).view(np.float16).astype(np.float64)
    finite = np.where(np.isfinite(halves), halves, 0.0)
    values = np.sign(finite) * np.abs(finite) ** 0.5
    return node("LUT1D", array("65536 1", values), halfDomain="true")


def raw_half_curve():
    codes = "\n".join(str(code ^ 0x8000 if code & 0x7C00 != 0x7C00 else 0) for code in range(65536))
    body = f'<Array dim="65536 1">\n{codes}\n</Array>'
    return node("LUT1D", body, ("16f", "16f"), halfDomain="true", rawHalfs="true")


def cases():
    wave = [v for i in range(17) for v in ((i / 16) ** 2 * 1023, (i / 16) ** 0.5 * 1023, 1023 - i * 60)]
    lattice = np.random.default_rng(7).random(9**3 * 3) * 255.0
    cineon = dict(base=10, logSideSlope=0.29325, logSideOffset=0.66959, linSideSlope=0.98920, linSideOffset=0.0108)
    camera = dict(base=10, logSideSlope=0.24719, logSideOffset=0.385537, linSideSlope=5.555556, linSideOffset=0.052272,
                  linSideBreak=0.010591)
    steep = dict(camera, linearSlope=5.5)
    yield "Matrix", [node("Matrix", array("3 4", (0.9, 0.2, -0.1, 0.5, 0.05, 1.1, 0.0, -2, 0.3, 0.0, 0.7, 9)), ("8i", "10i")),
                     node("Matrix", array("3 3", (1.7, -0.6, -0.1, -0.1, 1.1, 0.0, 0.0, -0.1, 1.2)))], "light"
    both = dict(minInValue=64, maxInValue=940, minOutValue=0, maxOutValue=4095)
    yield "Range", [bounds(None, **both), bounds("noClamp", **both),
                    bounds(None, minInValue=102.3, minOutValue=409.5), bounds(None, maxInValue=511.5, maxOutValue=2047.5)], "light"
    yield "ASC_CDL", [cdl(style) for style in ("Fwd", "Rev", "FwdNoClamp", "RevNoClamp")], "unit"
    yield "Log, to logarithms", [log("log10"), log("log2"), log("linToLog", **cineon)], "light"
    yield "Log, to light", [log("antiLog10"), log("antiLog2"), log("logToLin", **cineon)], "unit"
    yield "Log, cameras, to logarithms", [log("cameraLinToLog", **camera), log("cameraLinToLog", **steep)], "light"
    yield "Log, cameras, to light", [log("cameraLogToLin", **camera), log("cameraLogToLin", **steep)], "unit"
    basic = [form + end for form in ("basic", "basicMirror", "basicPassThru") for end in ("Fwd", "Rev")]
    yield "Exponent, basic", [exponent(style) for style in basic], "unit"
    curve = [form + end for form in ("monCurve", "monCurveMirror") for end in ("Fwd", "Rev")]
    yield "Exponent, monCurve", [exponent(style) for style in curve], "unit"
    yield "LUT1D", [node("LUT1D", array("17 3", wave), ("8i", "10i")), node("LUT1D", array("17 1", wave[::3]), ("8i", "10i"))], "unit"
    yield "LUT1D, half domain", [half_curve(), raw_half_curve()], "light"
    yield "LUT3D, trilinear", [node("LUT3D", array("9 9 9 3", lattice), ("32f", "8i"))], "unit"
    yield "LUT3D, tetrahedral", [node("LUT3D", array("9 9 9 3", lattice), ("32f", "8i"), interpolation="tetrahedral")], "unit"


def colors(kind):
    side = np.linspace(-0.25, 1.25, 33)
    grid = np.stack(np.meshgrid(side, side, side), axis=-1).reshape(-1, 3)
    rng = np.random.default_rng(1)
    high = 6.0 if kind == "light" else 0.0
    random = np.exp2(rng.uniform(-14.0, high, (20000, 3))) * np.where(rng.random((20000, 3)) < 0.1, -1.0, 1.0)
    return np.concatenate([grid, random]).astype(np.float32)


def by_ocio(path, pixels):
    transform = ocio.FileTransform(str(path))
    processor = ocio.Config.CreateRaw().getProcessor(transform)
    cpu = processor.getOptimizedCPUProcessor(ocio.BIT_DEPTH_F32, ocio.BIT_DEPTH_F32, ocio.OPTIMIZATION_NONE)
    result = pixels.copy()
    cpu.applyRGB(result)
    return result.astype(np.float64)


def by_afterimage(program, path, pixels):
    lines = "\n".join("%.9e %.9e %.9e" % tuple(pixel) for pixel in pixels)
    run = subprocess.run([program, str(path), "tetrahedral"], input=lines, capture_output=True, text=True, check=True)
    return np.array(run.stdout.split(), dtype=np.float64).reshape(-1, 3)


def difference(program, path, kind):
    pixels = colors(kind)
    expected, found = by_ocio(path, pixels), by_afterimage(program, path, pixels)
    return float(np.max(np.abs(found - expected) / np.maximum(1.0, np.abs(expected))))


def main():
    program = sys.argv[1]
    largest = 0.0
    print("| file | largest difference |\n|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "case.clf"
        for name, nodes, kind in cases():
            worst = 0.0
            for index, one in enumerate(nodes):
                path = pathlib.Path(folder) / f"{name.replace(' ', '_')}{index}.clf"
                path.write_text(process_list(one))
                worst = max(worst, difference(program, path, kind))
            largest = max(largest, worst)
            print(f"| `{name.split(',')[0]}`{name[len(name.split(',')[0]):]} | {worst:.1e} |")
    for name in ("display.clf", "teal.clf", "warm.cc", "edit.cdl"):
        worst = difference(program, FILES / name, "unit")
        largest = max(largest, worst)
        print(f"| `{name}` | {worst:.1e} |")
    sys.exit(not largest <= 1e-4)


if __name__ == "__main__":
    main()
