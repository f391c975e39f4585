#!/usr/bin/env python3
"""Shimmer of glow, and veil: tests/color/glow.py PROGRAM FOLDER of pipelines SCENE.exr... prints CSV.

Needs numpy, OpenEXR and opencv-python-headless (pip). Takes four minutes on two cores.

Shimmer: a lamp of 3x3 pixels, 500 times as bright as the gray behind it, moves by a quarter of a pixel in each frame. Glow
is the light of the encoded picture, linear, that the lamp adds more than 12 pixels away from it, summed; shimmer is the
range of that sum over 16 frames, as a share of its mean, after 16 frames in which limits on fireflies settle.

Veil: what a scene gets by the node that adds flares or glare, in codes of 8 bits: the mean, and what one pixel in a thousand
exceeds.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np
import OpenEXR

GRAY, TIMES, SETTLING, FRAMES, NEAR = 0.18, 500, 16, 16, 12
LUMINANCE = np.array([0.0722, 0.7152, 0.2126])
SIZES = [(1280, 720), (1281, 719)]
SHIMMER = {"lynx": None, "tsushima": None, "hdr": "sdr", "mobile": None, "glare": None}
VEIL = {"cinematic": "flared.strength=0", "glare": "lit.strength=0", "course": "lit.strength=0"}


def save(path, gray):
    pixels = np.repeat(gray[..., None], 3, 2).astype(np.float32)
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, {"RGB": pixels}).write(str(path))


def codes(path):
    return cv2.imread(str(path), cv2.IMREAD_UNCHANGED)[..., :3] / 65535


def light(path):
    code = codes(path)
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4) @ LUMINANCE


def covered(length, begin):
    """The share of each pixel of a line that three pixels from `begin` on cover."""
    pixel = np.arange(length)
    return (np.minimum(pixel + 1, begin + 3) - np.maximum(pixel, begin)).clip(0, 1)


def render(program, pipeline, source, result, *options):
    line = [program, "render", pipeline, source, "-o", result, "--depth", "16", "--no-dither", *options]
    subprocess.run(line, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def shimmer(program, pipeline, output, size, folder):
    """The mean sum of glow in units of full light of one pixel, and its range as a share."""
    width, height = size
    begins = [width // 2 + frame / 4 for frame in range(SETTLING + FRAMES)]
    options = ["--output", output] if output else []
    for name, times in (("dark", 1), ("lit", TIMES)):
        for frame, begin in enumerate(begins):
            lamp = covered(height, height // 2)[:, None] * covered(width, begin)[None]
            save(folder / f"{name}.{frame + 1:04}.exr", GRAY * (1 + (times - 1) * lamp))
        render(program, pipeline, folder / f"{name}.####.exr", folder / f"{name}.####.png", *options)
    sums = []
    for frame in range(SETTLING, SETTLING + FRAMES):
        added = light(folder / f"lit.{frame + 1:04}.png") - light(folder / f"dark.{frame + 1:04}.png")
        y, x = np.mgrid[0:height, 0:width] + 0.5
        far = np.hypot(x - begins[frame] - 1.5, y - height // 2 - 1.5) > NEAR
        sums.append(added[far].sum())
    return np.mean(sums), (max(sums) - min(sums)) / np.mean(sums)


def veil(program, pipeline, without, scene, folder):
    """The mean and the quantile of 99.9 % of what the node adds, in codes of 8 bits."""
    render(program, pipeline, scene, folder / "with.png")
    render(program, pipeline, scene, folder / "without.png", "--set", without)
    added = 255 * np.abs(codes(folder / "with.png") - codes(folder / "without.png")).max(-1)
    return added.mean(), np.quantile(added, 0.999)


def main(program, pipelines, *scenes):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        print("measure,pipeline,of,mean,spread")
        for pipeline, output in SHIMMER.items():
            for size in SIZES:
                mean, share = shimmer(program, f"{pipelines}/{pipeline}.ron", output, size, folder)
                print(f"shimmer,{pipeline},{size[0]}x{size[1]},{mean:.2f},{100 * share:.2f} %", flush=True)
        save(folder / "gray.exr", np.full((360, 640), GRAY))
        for pipeline, without in VEIL.items():
            for scene in [folder / "gray.exr", *map(Path, scenes)]:
                mean, most = veil(program, f"{pipelines}/{pipeline}.ron", without, scene, folder)
                print(f"veil,{pipeline},{scene.stem},{mean:.2f},{most:.2f}", flush=True)


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
