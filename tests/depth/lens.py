#!/usr/bin/env python3
"""Compares `DepthOfField` with 256 samples of a lens whose circles are about a pixel large, in the built-in scene.

    venv/bin/python lens.py PROGRAM FOLDER

The lens is 32 mm wide and focused on 4 m; the images are 320x180. FOLDER receives them. Prints PSNR and the mean of FLIP
of a pinhole, of the node and of the node with less of its `amount`, exposed by 1 stop, through `ToneMap` and encoded;
the packages are those of `compare_cycles.py`.
"""
import argparse, os

import numpy as np

import frames
from cases import VIEW
from compare_cycles import encoded, errors
from walk import run

WALKS, SIZE, APERTURE, FOCUS, FACTOR = (0.15, 0.4, 0.6), "320x180", 0.032, 4.0, 4.0
# Of a sensor of 24 mm with the scene's field of view, in millimetres.
SENSOR_DISTANCE = 12.0 / 0.4245
SHOW = VIEW.replace("stops: 0.0", "stops: 1.0")
AMOUNTS = {"`DepthOfField`": 1.0, "with 0.85 of its `amount`": 0.85, "with 0.73 of it": 0.73}


def lens(amount):
    focal_length = SENSOR_DISTANCE / (1.0 + SENSOR_DISTANCE / (1000.0 * FOCUS))
    f_stop = FACTOR * focal_length / (1000.0 * APERTURE)
    numbers = f"amount: {FACTOR * amount}, focus: {FOCUS}, f_stop: {f_stop}, focal_length: {focal_length}"
    return f'"made": DepthOfField(source: "scene", depth: "scene.depth", {numbers}, largest: 0.06),'


def shown(program, folder, nodes, light):
    """The encoded image of light that nodes make."""
    out = os.path.join(folder, "out.exr")
    text = f'Pipeline(inputs: {{}}, nodes: {{ {nodes} {SHOW % light} }}, outputs: {{ "out": "view" }})'
    run(program, folder, text, ["--size", SIZE, "-o", out])
    return encoded(frames.channels(out, None, "RGB"))


def reference(program, folder, walk):
    """The mean of four times 64 samples, shown."""
    files, nodes, outputs, more = [], "", "", ["--size", SIZE]
    for first in range(0, 256, 64):
        files.append(os.path.join(folder, f"lens{first}.exr"))
        seen = f"walk: {walk}, samples: 64, first: {first}, aperture: {APERTURE}, focus: {FOCUS}"
        nodes += f'"lens{first}": DemoScene({seen}), '
        outputs += f'"lens{first}": "lens{first}", '
        more += ["--output", f"lens{first}={files[-1]}"]
    run(program, folder, f"Pipeline(inputs: {{}}, nodes: {{ {nodes} }}, outputs: {{ {outputs} }})", more)
    mean = np.mean([frames.channels(file, None, "RGB") for file in files], 0)
    light, out = os.path.join(folder, "mean.exr"), os.path.join(folder, "out.exr")
    frames.write(light, [mean[..., channel] for channel in range(3)])
    text = f'Pipeline(inputs: {{ "scene": Color }}, nodes: {{ {SHOW % "scene"} }}, outputs: {{ "out": "view" }})'
    run(program, folder, text, [light, "-o", out])
    return encoded(frames.channels(out, None, "RGB"))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("folder")
    args = parser.parse_args()
    os.makedirs(args.folder, exist_ok=True)
    wanted = [reference(args.program, args.folder, walk) for walk in WALKS]
    rows = {"a pinhole": ("", "scene")} | {name: (lens(amount), "made") for name, amount in AMOUNTS.items()}
    for name, (nodes, light) in rows.items():
        cells = []
        for walk, reference_image in zip(WALKS, wanted):
            scene = f'"scene": DemoScene(walk: {walk}, samples: 64), '
            psnr, flip = errors(reference_image, shown(args.program, args.folder, scene + nodes, light))
            cells.append(f"{psnr:.1f} dB, {flip:.3f}")
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
