#!/usr/bin/env python3
"""Compares `OcioTransform` and `--input-space` with OpenColorIO, and prints a table. Optional: no test needs it.

    python3 -m venv v
    v/bin/pip install opencolorio==2.6.0 numpy openexr opencv-python-headless
    cargo build --release --features ocio
    v/bin/python tests/color/ocio.py target/release/afterimage > graph/docs/measurements/ocio.csv

A row is a transform of a built-in config, on 17^3 colors of -0.1 to 1 and of 2^-8 to 2^6. Signals are compared from PNG
files of 16 bits in units of 8-bit codes, where rounding alone makes 0.002; light relative to its size above 1. OpenColorIO
runs on the CPU in 32 bits, without optimizations.
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
    precise = ["--depth", "16"] if is_signal else ["--channel-type", "float"]
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
    processor = ocio.Config.CreateFromFile(config).getProcessor(transform)
    cpu = processor.getOptimizedCPUProcessor(ocio.BIT_DEPTH_F32, ocio.BIT_DEPTH_F32, ocio.OPTIMIZATION_NONE)
    pixels = np.ascontiguousarray(pixels).reshape(1, -1, 3).copy()
    cpu.apply(ocio.PackedImageDesc(pixels, pixels.shape[1], 1, 3))
    return pixels[0]


def row(kind, config, name, found, wanted, scale):
    if isinstance(found, str):
        print(f'{kind},{config.split("://")[1]},"{name}",,,"{found}"')
        return
    off = np.abs(found.astype(float) - wanted) / (1 if scale else np.maximum(1, np.abs(wanted))) * (scale or 1)
    print(f'{kind},{config.split("://")[1]},"{name}",{off.max():.2g},{off.mean():.2g},{"8-bit codes" if scale else "relative"}')


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
    for config, space in SPACES:
        numbers = np.array(list(itertools.product(np.linspace(0.1, 0.9, SIDE), repeat=3)), dtype=np.float32)
        wanted = reference(config, ocio.ColorSpaceTransform(space, LIGHT), numbers)
        # Light whose luminance is negative is limited by the pipeline; the largest half float limits all light.
        shown = (wanted @ [0.2126, 0.7152, 0.0722] >= 0) & (np.abs(wanted).max(1) < 65504)
        found = render(numbers, "", config, "--input-space", space)
        row("input", config, space, found if isinstance(found, str) else found[shown], wanted[shown], None)


main()
