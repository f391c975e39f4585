#!/usr/bin/env python3
"""Compares `OcioTransform` and `--input-space` with OpenColorIO, and prints a table. Optional: no test needs it.

    python3 -m venv v
    v/bin/pip install opencolorio==2.6.0 numpy openexr opencv-python-headless
    cargo build --release --features ocio
    v/bin/python tests/color/ocio.py target/release/afterimage > graph/docs/measurements/ocio.csv

A row is a transform of a built-in config, or a file that this script makes, in ACEScct, on 17^3 colors of -0.1 to 1 and of
2^-8 to 2^6. Signals are compared from PNG files of 16 bits in units of 8-bit codes, where rounding alone makes 0.002; light
relative to its size above 1, and only where a pipeline does not limit it. OpenColorIO runs on the CPU in 32 bits, without
optimizations. The exit status is 1 if the program refuses a transform, or a difference is above the limit of its unit.
"""

import itertools
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np
import OpenEXR
import PyOpenColorIO as ocio

PROGRAM = Path(sys.argv[1]).resolve()
FOLDER = Path(tempfile.mkdtemp())
SIDE = 17
ACES2, ACES1 = "ocio://studio-config-v4.0.0_aces-v2.0_ocio-v2.5", "ocio://studio-config-v2.1.0_aces-v1.3_ocio-v2.3"
LIGHT = "Linear Rec.709 (sRGB)"

VIEWS = [
    (ACES2, "sRGB - Display", "ACES 2.0 - SDR 100 nits (Rec.709)"),
    (ACES2, "sRGB - Display", "Un-tone-mapped"),
    (ACES2, "Display P3 - Display", "ACES 2.0 - SDR 100 nits (P3 D65)"),
    (ACES2, "Gamma 2.2 Rec.709 - Display", "ACES 2.0 - SDR 100 nits (Rec.709)"),
    (ACES2, "Rec.1886 Rec.709 - Display", "ACES 2.0 - SDR 100 nits (Rec.709)"),
    (ACES2, "P3-D65 - Display", "ACES 2.0 - SDR 100 nits (P3 D65)"),
    (ACES2, "Rec.2100-PQ - Display", "ACES 2.0 - HDR 1000 nits (Rec.2020)"),
    (ACES2, "Rec.2100-PQ - Display", "ACES 2.0 - HDR 1000 nits (P3 D65)"),
    (ACES2, "Rec.2100-HLG - Display", "ACES 2.0 - HDR 1000 nits (P3 D65)"),
    (ACES2, "ST2084-P3-D65 - Display", "ACES 2.0 - HDR 1000 nits (P3 D65)"),
    (ACES1, "sRGB - Display", "ACES 1.0 - SDR Video"),
    (ACES1, "sRGB - Display", "ACES 1.0 - SDR Video (D60 sim on D65)"),
    (ACES1, "Rec.1886 Rec.709 - Display", "ACES 1.0 - SDR Video"),
    (ACES1, "P3-D65 - Display", "ACES 1.1 - SDR Cinema (Rec.709 lim)"),
    (ACES1, "Rec.2100-PQ - Display", "ACES 1.1 - HDR Video (1000 nits & Rec.2020 lim)"),
]
LOOKS = [(ACES1, "ACES 1.3 Reference Gamut Compression")]
SPACES = [
    (ACES2, "ACEScct"),
    (ACES2, "ACEScc"),
    (ACES2, "ARRI LogC4"),
    (ACES2, "ARRI LogC3 (EI800)"),
    (ACES2, "S-Log3 S-Gamut3"),
    (ACES2, "Log3G10 REDWideGamutRGB"),
    (ACES2, "sRGB Encoded Rec.709 (sRGB)"),
    (ACES2, "Gamma 2.4 Encoded Rec.709"),
]
# The color space that files are made for.
GRADED = "ACEScct"
# What OpenColorIO bakes: the format, the ending, the entries of a side, and whether with a curve before the table.
BAKED = [
    ("flame", "3dl", 17, False),
    ("lustre", "3dl", 17, False),
    ("cinespace", "csp", 17, False),
    ("cinespace", "csp", 17, True),
    ("houdini", "lut", 17, False),
    ("houdini", "lut", 17, True),
    ("truelight", "cub", 17, False),
    ("Color Transform Format", "ctf", 17, True),
    ("Academy/ASC Common LUT Format", "clf", 17, True),
    ("iridas_cube", "cube", 17, False),
    ("iridas_itx", "itx", 17, False),
    ("resolve_cube", "cube", 17, True),
    ("spi1d", "spi1d", 1024, False),
    ("spi3d", "spi3d", 17, False),
]


def colors():
    low = np.array(list(itertools.product(np.linspace(-0.1, 1, SIDE), repeat=3)))
    wide = np.array(list(itertools.product(2.0 ** np.linspace(-8, 6, SIDE), repeat=3)))
    # Light whose luminance is negative is limited on the way in: it is no color.
    low = low[low @ [0.2126, 0.7152, 0.0722] >= 0]
    return np.concatenate([low, wide]).astype(np.float32)


def render(pixels, node, config, *options):
    is_signal = "display" in node
    source, result, pipeline = FOLDER / "in.exr", FOLDER / ("out.png" if is_signal else "out.exr"), FOLDER / "p.ron"
    with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, {"RGB": pixels[None]}) as file:
        file.write(str(source))
    nodes = f'"exposed": Exposure(source: "in", stops: 0.0, format: Rgba32Float), {node}'
    last = "result" if node else "exposed"
    pipeline.write_text(f'Pipeline(inputs: {{ "in": Color }}, nodes: {{ {nodes} }}, outputs: {{ "out": "{last}" }})')
    precise = ["--depth", "16"] if is_signal else ["--depth", "32"]
    command = [PROGRAM, "render", pipeline, source, "-o", result, "--exact", *precise]
    done = subprocess.run([*command, "--ocio", config, *options], capture_output=True, text=True)
    if done.returncode:
        return done.stderr.strip().replace("\n", " ")
    if is_signal:
        return cv2.imread(str(result), cv2.IMREAD_UNCHANGED)[0, :, 2::-1] / 65535
    with OpenEXR.File(str(result)) as file:
        channels = file.channels()
        return channels["RGBA" if "RGBA" in channels else "RGB"].pixels[0, :, :3]


def reference(config, transform, pixels):
    processor = ocio.Config.CreateFromFile(str(config)).getProcessor(transform)
    cpu = processor.getOptimizedCPUProcessor(ocio.BIT_DEPTH_F32, ocio.BIT_DEPTH_F32, ocio.OPTIMIZATION_NONE)
    pixels = np.ascontiguousarray(pixels).reshape(1, -1, 3).copy()
    cpu.apply(ocio.PackedImageDesc(pixels, pixels.shape[1], 1, 3))
    return pixels[0]


def grade():
    """A grade of numbers from 0 to 1 that mixes channels, bends them and stays within that range."""
    mixed = ocio.MatrixTransform([0.8, 0.15, 0.05, 0, 0.1, 0.85, 0.05, 0, 0.02, 0.08, 0.9, 0, 0, 0, 0, 1])
    bent = ocio.CDLTransform(slope=[0.95, 0.9, 0.85], offset=[0.02, 0.0, 0.04], power=[1.2, 1.0, 0.8], sat=1.1)
    bounded = ocio.RangeTransform(minInValue=0, maxInValue=1, minOutValue=0, maxOutValue=1)
    return ocio.GroupTransform([mixed, bent, bounded])


def curves():
    """The part of a grade that curves can hold."""
    return ocio.CDLTransform(slope=[0.95, 0.9, 0.85], offset=[0.02, 0.0, 0.04], power=[1.2, 1.0, 0.8])


def baked(name, ending, side, is_shaped):
    config = ocio.Config.CreateRaw()
    graded = curves() if ending == "spi1d" else grade()
    config.addColorSpace(ocio.ColorSpace(name="graded", fromReference=graded))
    config.addColorSpace(ocio.ColorSpace(name="plain"))
    config.addColorSpace(ocio.ColorSpace(name="shaped", fromReference=ocio.ExponentTransform([0.7, 0.7, 0.7, 1])))
    baker = ocio.Baker(config, name, "plain", "graded", shaperSpace="shaped" if is_shaped else "", cubeSize=side)
    if is_shaped:
        baker.setShaperSize(1024)
    return baker.bake()


def bent(values):
    return values**1.4 * 0.9 + 0.05


def written():
    """Files that OpenColorIO reads and does not write: their names and texts."""
    steps, side = np.linspace(0, 1, 1024), np.linspace(0, 1, SIDE)
    columns = np.stack([bent(steps), steps**0.8, steps**1.1], 1)
    cube = np.array([[b, g, r] for r, g, b in itertools.product(side, repeat=3)])  # red is fastest
    cube = np.clip(cube @ np.array([[0.8, 0.1, 0.02], [0.15, 0.85, 0.08], [0.05, 0.05, 0.9]]), 0, 1) ** 1.2
    lines = lambda values, form: "\n".join(" ".join(form % v for v in value) for value in values) + "\n"
    discreet = "LUT: 3 1024\n\n" + "\n".join("%d" % v for v in np.rint(columns.T.ravel() * 1023)) + "\n"
    csp = "CSPLUTV100\n1D\n\n" + "2\n0.0 1.0\n0.0 1.0\n" * 3 + f"\n1024\n{lines(columns, '%.6f')}"
    houdini = "Version\t\t1\nFormat\t\tany\nType\t\tC\nFrom\t\t0.0 1.0\nTo\t\t0.0 1.0\nBlack\t\t0.0\nWhite\t\t1.0\n"
    houdini += "Length\t\t1024\nLUT:\nRGB {\n" + lines(columns[:, :1], "%.6f") + "}\n"
    # Blue is fastest.
    rows = cube.reshape(SIDE, SIDE, SIDE, 3).transpose(2, 1, 0, 3).reshape(-1, 3)
    pandora = f"channel 3d\nin {SIDE**3}\nout 4096\n\nformat lut\n\nvalues\tred\tgreen\tblue\n"
    pandora += "".join("%d\t%d\t%d\t%d\n" % (at, *np.rint(value * 4095)) for at, value in enumerate(rows))
    nuke = f"#Inventor V2.1 ascii\ngrid_size {SIDE} {SIDE} {SIDE}\ndata\n"
    matrix = "0.8 0.15 0.05 0\n0.1 0.85 0.05 0\n0.02 0.08 0.9 655.35\n"
    return {
        "discreet.lut": discreet,
        "1d.csp": csp,
        "1d.lut": houdini,
        "pandora.m3d": pandora,
        "nuke.vf": nuke + lines(rows, "%.6f"),
        "matrix.spimtx": matrix,
    }


def operators():
    """Operators that only a .ctf has, each as a file."""
    steps = {
        "exposure": ocio.ExposureContrastTransform(style=ocio.EXPOSURE_CONTRAST_LOGARITHMIC, exposure=0.5, contrast=1.1),
        "grading": ocio.GradingPrimaryTransform(style=ocio.GRADING_LOG),
        "surround": ocio.FixedFunctionTransform(ocio.FIXED_FUNCTION_REC2100_SURROUND, params=[0.9]),
    }
    primary = ocio.GradingPrimary(ocio.GRADING_LOG)
    primary.contrast, primary.saturation = ocio.GradingRGBM(1.1, 1.0, 0.9, 1.0), 1.2
    steps["grading"].setValue(primary)
    group = lambda step: ocio.GroupTransform([step])
    return {f"{name}.ctf": group(step).write(formatName="Color Transform Format") for name, step in steps.items()}


def files():
    names = {}
    for name, ending, side, is_shaped in BAKED:
        file = f"{name.split('/')[0].split()[0].lower()}{'-shaped' if is_shaped else ''}.{ending}"
        names[file] = baked(name, ending, side, is_shaped)
    names |= written() | operators()
    for name, text in names.items():
        (FOLDER / name).write_text(text)
    return list(names)


def is_kept(light):
    """Where a pipeline does not limit light: its luminance is not negative, and no half float is exceeded."""
    return (light @ [0.2126, 0.7152, 0.0722] >= 0) & (np.abs(light).max(1) < 65504)


# Of a code, and relative.
LIMITS = {255: 0.5, None: 2e-4}
failed = []


def row(kind, config, name, found, wanted, scale):
    if isinstance(found, str):
        failed.append(name)
        print(f'{kind},{config.split("://")[1]},"{name}",,,"{found}"')
        return
    if not scale:
        kept = is_kept(wanted)
        found, wanted = found[kept], wanted[kept]
    off = np.abs(found.astype(float) - wanted) / (1 if scale else np.maximum(1, np.abs(wanted))) * (scale or 1)
    print(f'{kind},{config.split("://")[1]},"{name}",{off.max():.2g},{off.mean():.2g},{"8-bit codes" if scale else "relative"}')
    if not off.max() <= LIMITS[scale]:
        failed.append(name)


def main():
    pixels = colors()
    print("kind,config,transform,largest,mean,unit")
    for config, display, view in VIEWS:
        node = f'"result": OcioTransform(source: "exposed", display: "{display}", view: "{view}")'
        wanted = reference(config, ocio.DisplayViewTransform(LIGHT, display, view), pixels)
        row("view", config, f"{display}: {view}", render(pixels, node, config), np.clip(wanted, 0, 1), 255)
    for config, look in LOOKS:
        node = f'"result": OcioTransform(source: "exposed", looks: "{look}", state: Source, format: Rgba32Float)'
        wanted = reference(config, ocio.LookTransform(LIGHT, LIGHT, look), pixels)
        row("look", config, look, render(pixels, node, config), wanted, None)
    config = FOLDER / "files.ocio"
    found = ocio.Config.CreateFromFile(ACES2)
    found.setSearchPath(".")
    config.write_text(found.serialize())
    for name in files():
        node = f'"result": OcioTransform(source: "exposed", file: "{name}", space: "{GRADED}", state: Source, format: Rgba32Float)'
        steps = [ocio.ColorSpaceTransform(LIGHT, GRADED), ocio.FileTransform(name), ocio.ColorSpaceTransform(GRADED, LIGHT)]
        wanted = reference(config, ocio.GroupTransform(steps), pixels)
        row("file", ACES2, name, render(pixels, node, config), wanted, None)
    for config, space in SPACES:
        numbers = np.array(list(itertools.product(np.linspace(0.1, 0.9, SIDE), repeat=3)), dtype=np.float32)
        wanted = reference(config, ocio.ColorSpaceTransform(space, LIGHT), numbers)
        row("input", config, space, render(numbers, "", config, "--input-space", space), wanted, None)
    sys.exit(f"refused or too far apart: {', '.join(failed)}" if failed else 0)


if __name__ == "__main__":
    main()
