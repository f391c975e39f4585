#!/usr/bin/env python3
"""Compares `DepthOfField` with 256 samples of a lens whose circles are about a pixel large, in the built-in scene.

    venv/bin/python lens.py PROGRAM FOLDER

The lens is 32 mm wide and focused on 4 m; the images are 320x180. FOLDER receives them. Prints PSNR and mean of FLIP of
a pinhole, of the node, of the node with less of its `amount`, and of the node with depths whose circles are narrower
by a share of a pixel, exposed by 1 stop, through `ToneMap` and encoded; the packages are those of `compare_cycles.py`.
"""
import argparse, os

import numpy as np

import frames
from cases import VIEW
from compare_cycles import encoded, errors
from walk import run

WALKS, SIZE, APERTURE, FOCUS, FACTOR = (0.15, 0.4, 0.6), "320x180", 0.032, 4.0, 4.0
# Of a sensor of 24 mm with the scene's field of view, in millimeters.
SENSOR_DISTANCE = 12.0 / 0.4245
SHOW = VIEW.replace("stops: 0.0", "stops: 1.0")
AMOUNTS = {"`DepthOfField`": 1.0, "with 0.85 of its `amount`": 0.85, "with 0.73 of it": 0.73}


# What is taken from the square of each circle's radius, in pixels.
NARROWER = {"r^2 less 1/6": 1 / 6, "r^2 less 1/3": 1 / 3}


def lens(amount, depth="scene.depth"):
    focal_length = SENSOR_DISTANCE / (1.0 + SENSOR_DISTANCE / (1000.0 * FOCUS))
    f_stop = FACTOR * focal_length / (1000.0 * APERTURE)
    numbers = f"amount: {FACTOR * amount}, focus: {FOCUS}, f_stop: {f_stop}, focal_length: {focal_length}"
    return f'"made": DepthOfField(source: "scene", depth: "{depth}", {numbers}, largest: 0.06),'


def shown(program, folder, nodes, light, inputs="", more=()):
    """The encoded image of light that nodes make."""
    out = os.path.join(folder, "out.exr")
    text = f'Pipeline(inputs: {{ {inputs} }}, nodes: {{ {nodes} {SHOW % light} }}, outputs: {{ "out": "view" }})'
    run(program, folder, text, [*(more or ["--size", SIZE]), "-o", out])
    return encoded(frames.channels(out, None, "RGB"))


def narrowed(program, folder, walk, less):
    """The encoded image of the node with depths whose circles have less of the square of their radius."""
    files = {name: os.path.join(folder, f"{name}.exr") for name in ("scene", "depth")}
    outputs = '"scene": "scene", "depth": "scene.depth"'
    nodes = f'"scene": DemoScene(walk: {walk}, samples: 64)'
    text = f"Pipeline(inputs: {{}}, nodes: {{ {nodes} }}, outputs: {{ {outputs} }})"
    more = [part for name, file in files.items() for part in ("--output", f"{name}={file}")]
    run(program, folder, text, ["--size", SIZE, *more])
    depth = frames.channels(files["depth"], None, "R")[..., 0].astype(np.float64)
    farthest = APERTURE / FOCUS / (4 * 0.4245) * float(SIZE.split("x")[1])
    radius = np.sqrt(np.maximum((farthest * (depth - FOCUS) / depth) ** 2 - less, 0)) / farthest
    far, near = FOCUS / (1 - np.minimum(radius, 0.9999)), FOCUS / (1 + radius)
    frames.write(files["depth"], [np.where(depth > FOCUS, np.minimum(far, 60000), near)])
    inputs = '"scene": Color, "depth": Depth'
    more = [files["scene"], "--input", "depth=" + files["depth"]]
    return shown(program, folder, lens(1.0, "depth"), "made", inputs, more)


def many_samples(program, folder, walk):
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
    light = os.path.join(folder, "mean.exr")
    frames.write(light, [mean[..., channel] for channel in range(3)])
    return shown(program, folder, "", "scene", '"scene": Color', [light])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("folder")
    args = parser.parse_args()
    os.makedirs(args.folder, exist_ok=True)
    wanted = [many_samples(args.program, args.folder, walk) for walk in WALKS]
    def row(name, image):
        cells = [errors(reference, image(walk)) for walk, reference in zip(WALKS, wanted)]
        print(f"| {name} | {' | '.join(f'{psnr:.1f} dB, {flip:.3f}' for psnr, flip in cells)} |", flush=True)

    def rendered(nodes, light):
        scene = '"scene": DemoScene(walk: %s, samples: 64), '
        return lambda walk: shown(args.program, args.folder, scene % walk + nodes, light)

    row("a pinhole", rendered("", "scene"))
    for name, amount in AMOUNTS.items():
        row(name, rendered(lens(amount), "made"))
    for name, less in NARROWER.items():
        row(name, lambda walk: narrowed(args.program, args.folder, walk, less))


if __name__ == "__main__":
    main()
