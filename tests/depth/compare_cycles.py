#!/usr/bin/env python3
"""Compares the nodes that read depth or motion, and those that smooth edges, with frames of a path tracer.

    python3 -m venv venv && venv/bin/pip install OpenEXR==3.5.3 flip-evaluator==1.7
    venv/bin/python compare_cycles.py PROGRAM [--chart FILE.svg] [--only Taa,Smaa] [--keep FOLDER] [--jobs N] FOLDER...

Each folder holds frames of one scene that Blender's Cycles has rendered, multi-part, and `camera.####.json`:

beauty    color; depth in meters along the view axis; normals of the world; `Vector`, in pixels upwards, x and y to the
          frame before; ambient occlusion by rays of at most 1 m
aliased   one sample in the middle of each pixel, moved by `jitter` of the JSON: pixels to the right and upwards
dof, blur, both   the same frames with depth of field, with a shutter of half a frame, with both
light     depth in meters from the sun's orthographic camera, 0.1 m to 60 m
sun, open everything white and lit by the sun alone, with and without its shadow, by `sun_frames.py`
sun6, open6  the same with a sun whose diameter in the sky is 6 degrees

Prints a table in Markdown for each case of `cases.py`: PSNR and the mean of FLIP over the frames of each folder,
without the node and with it in several settings. Colors are compared as a display shows them: exposed by 0 stops,
through `ToneMap` with its defaults, encoded as sRGB. The chart has each frame, with the first setting.
"""
import argparse, os, subprocess, tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial

import flip_evaluator as flip
import numpy as np

import chart
import frames
from cases import CASES, pipeline

WITHOUT = "without"


def render(program, texts, numbers, folder, prepared, out):
    """Renders frames of a pipeline into `out`."""
    text, files = texts
    path = os.path.join(out, "pipeline.ron")
    with open(path, "w") as file:
        file.write(text)
    line = [program, "render", path, "-o", os.path.join(out, "out.####.exr"), "--depth", "32"]
    line += ["--frames", ",".join(map(str, numbers))]
    for name, file in files.items():
        line += ["--input", f"{name}=" + file.format(folder=folder, out=prepared)]
    done = subprocess.run(line, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(line)}\n{text}\n{done.stderr}")


def encoded(light):
    """sRGB of display-linear light."""
    light = np.clip(light, 0, 1)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)


def errors(reference, found):
    """PSNR and the mean of FLIP of two images from 0 to 1."""
    square = float(np.mean((reference - found) ** 2))
    pair = [np.ascontiguousarray(image, np.float32) for image in (reference, found)]
    return 10 * np.log10(1 / max(square, 1e-12)), float(flip.evaluate(*pair, "LDR")[1])


def shown(program, case, nodes, folder, prepared):
    """The frames that a pipeline makes, as they are compared, by their numbers."""
    numbers = frames.numbers(folder, case.reference)
    with tempfile.TemporaryDirectory() as out:
        render(program, pipeline(case, nodes), numbers, folder, prepared, out)
        found = {frame: frames.channels(frames.at(out, "out", frame), None, "RGB") for frame in numbers}
    if case.source:
        return {frame: encoded(light) for frame, light in found.items()}
    return {frame: visibility(folder, frame, 1 - made[..., :1]) for frame, made in found.items()}


def visibility(folder, frame, share):
    """The share of open sky in three channels; 1 where nothing is seen."""
    is_seen = frames.channels(frames.at(folder, "beauty", frame), "Depth", "Z") < 1e9
    return np.repeat(np.clip(np.where(is_seen, share, 1), 0, 1), 3, 2)


def references(program, case, folder, prepared):
    """The images of the path tracer and those without the node."""
    if case.source:
        both = case.reference, case.source
        return [shown(program, replace(case, source=name), "", folder, prepared) for name in both]
    numbers = frames.numbers(folder, case.reference)
    rays = {frame: frames.channels(frames.at(folder, "beauty", frame), "Occlusion", "R") for frame in numbers}
    gray = {frame: visibility(folder, frame, share) for frame, share in rays.items()}
    return [gray, {frame: np.ones_like(image) for frame, image in gray.items()}]


def compare(program, case, folder, prepared, keep):
    """For each setting, and without the node, the errors of each frame: two columns."""
    reference, without = references(program, case, folder, prepared)
    found = {WITHOUT: without}
    found |= {name: shown(program, case, nodes, folder, prepared) for name, nodes in case.settings.items()}
    if keep:
        save(keep, case, os.path.basename(folder), {"reference": reference} | found)
    return {name: [[f, *errors(reference[f], made[f])] for f in sorted(reference)] for name, made in found.items()}


def compare_all(program, cases, keep, folder):
    """All cases of one folder, by their titles."""
    with tempfile.TemporaryDirectory() as prepared:
        frames.prepare(folder, prepared)
        return {case.title: compare(program, case, folder, prepared, keep) for case in cases}


def save(keep, case, scene, found):
    """Writes what is compared as arrays, to look at."""
    for name, made in found.items():
        np.savez_compressed(os.path.join(keep, f"{case.title}-{scene}-{name}.npz"), **{str(f): made[f] for f in made})


def print_table(case, scenes, found):
    print(f"\n| {case.title} | " + " | ".join(scenes) + " |\n|---|" + "---|" * len(scenes))
    for name in found[0]:
        means = [np.mean(rows[name], 0) for rows in found]
        print(f"| {name} | " + " | ".join(f"{psnr:.1f} dB, {mean:.3f}" for _, psnr, mean in means) + " |", flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("folders", nargs="+")
    parser.add_argument("--chart")
    parser.add_argument("--only", help="titles of cases, with commas")
    parser.add_argument("--keep", help="a folder for the compared images")
    parser.add_argument("--jobs", type=int, default=1, help="folders at once")
    args = parser.parse_args()
    folders = [os.path.normpath(folder) for folder in args.folders]
    scenes = [os.path.basename(folder) for folder in folders]
    cases = [case for case in CASES if not args.only or case.title in args.only.split(",")]
    with ProcessPoolExecutor(args.jobs) as pool:
        of_folders = list(pool.map(partial(compare_all, args.program, cases, args.keep), folders))
    found = {case.title: [of_folder[case.title] for of_folder in of_folders] for case in cases}
    for case in cases:
        print_table(case, scenes, found[case.title])
    if args.chart:
        with open(args.chart, "w") as file:
            file.write(chart.draw(found, scenes))


if __name__ == "__main__":
    main()
