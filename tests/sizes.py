#!/usr/bin/env python3
"""How far a look changes with the size of the picture: tests/sizes.py PROGRAM PIPELINE.ron...

Renders a scene of soft lamps, of which none is smaller than 8 lines at 2160, at eight heights, and prints the mean of
NVIDIA's FLIP against the picture of 1080 lines at the smaller of both sizes. Needs flip-evaluator, numpy, OpenEXR and
pillow (pip). Takes a minute a pipeline on two cores.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import flip_evaluator
import numpy
import OpenEXR
from PIL import Image

HEIGHTS = [180, 270, 360, 540, 720, 900, 1080, 2160]


def scene(height, lamps, samples=2):
    """Light and, in alpha, a mask of what gives out light."""
    width = round(height * 16 / 9)
    y, x = (numpy.mgrid[0 : height * samples, 0 : width * samples] + 0.5) / (height * samples)
    sky = 0.05 + 0.35 * (1 - y) ** 2 + 0.05 * numpy.sin(9 * x) * numpy.sin(7 * y)
    light = sky[..., None] * [1.0, 0.9, 1.1]
    mask = numpy.zeros_like(sky)
    for at_x, at_y, radius, brightness, color in lamps:
        edge = (numpy.hypot(x - at_x, y - at_y) - radius) / (0.25 * radius)
        inside = 1 / (1 + numpy.exp(numpy.minimum(edge, 80)))
        light = light + brightness * inside[..., None] * color
        mask = numpy.maximum(mask, inside * (brightness > 2))
    pixels = numpy.concatenate([light, mask[..., None]], -1)
    pixels = pixels.reshape(height, samples, width, samples, 4).mean((1, 3)).astype(numpy.float16)
    return {"RGBA": numpy.ascontiguousarray(pixels)}


def light_of(path):
    signal = numpy.asarray(Image.open(path).convert("RGB")) / numpy.float32(255)
    return numpy.where(signal <= 0.04045, signal / 12.92, ((signal + 0.055) / 1.055) ** 2.4)


def signal_at(light, height):
    size = (round(height * 16 / 9), height)
    channels = [Image.fromarray(light[..., c].astype(numpy.float32)).resize(size, Image.BOX) for c in range(3)]
    light = numpy.stack([numpy.asarray(channel) for channel in channels], -1)
    signal = numpy.where(light <= 0.0031308, 12.92 * light, 1.055 * numpy.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)
    return signal.astype(numpy.float32)


program, pipelines = sys.argv[1], sys.argv[2:]
random = numpy.random.default_rng(5)
lamps = [
    (
        random.uniform(0, 16 / 9),
        random.uniform(),
        10 ** random.uniform(-2.2, -1),
        10 ** random.uniform(-0.5, 2),
        random.uniform(0.2, 1, 3),
    )
    for _ in range(24)
]
with tempfile.TemporaryDirectory() as folder:
    folder = Path(folder)
    for height in HEIGHTS:
        header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        OpenEXR.File(header, scene(height, lamps)).write(str(folder / f"{height}.exr"))
    print("pipeline", *(height for height in HEIGHTS if height != 1080), sep=",")
    for pipeline in pipelines:
        shown = {}
        for height in HEIGHTS:
            out = folder / f"{height}.png"
            command = [program, "render", pipeline, folder / f"{height}.exr", "--out", out, "--no-dither"]
            subprocess.run(command, check=True, capture_output=True)
            shown[height] = light_of(out)
        errors = []
        for height in HEIGHTS:
            size = min(height, 1080)
            pair = [signal_at(shown[h], size) for h in (1080, height)]
            errors.append(f"{flip_evaluator.evaluate(*pair, 'LDR')[1]:.4f}")
        del errors[HEIGHTS.index(1080)]
        print(Path(pipeline).stem, *errors, sep=",", flush=True)
