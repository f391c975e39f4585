#!/usr/bin/env python3
"""Compares `Gtao` with the ambient occlusion of a path tracer.

    python3 -m venv venv && venv/bin/pip install OpenEXR==3.5.3 flip-evaluator==1.7
    venv/bin/python compare_cycles.py PROGRAM FOLDER...

Each folder holds frames of one scene that Blender's Cycles has rendered: `beauty.####.exr`, multi-part, with the parts
`ViewLayer.Depth` (metres along the view axis), `ViewLayer.Normal` (world) and `ViewLayer.Ambient Occlusion` (rays of at
most 1 m), and `camera.####.json` with the rows of `view` and `projection`. Prints a table in Markdown: PSNR and the mean
of FLIP against the rays, without occlusion and with the node in several settings.
"""
import glob, os, subprocess, sys, tempfile

import flip_evaluator as flip
import numpy as np
import OpenEXR

PIPELINE = """Pipeline(
    inputs: { "depth": Depth, "normal": Normals, "camera": Camera },
    nodes: {
        "grey": DemoScene(),
        "ao": Gtao(source: "grey", depth: "depth", camera: "camera", %s radius: 1.0, falloff: 0.3),
    },
    outputs: { "occlusion": "ao.occlusion" },
)"""
NORMALS = 'normal: "normal", space: World,'
SETTINGS = {
    "defaults": NORMALS,
    "normals from the depth": "",
    "4 slices, 8 steps": NORMALS + " slices: 4, steps: 8,",
    "half of the size": NORMALS + " size: Half,",
}


def channel(path, part, name):
    for found in OpenEXR.File(path, separate_channels=True).parts:
        if found.name() == part:
            return np.array(found.channels[f"{part}.{name}"].pixels)
    raise SystemExit(f"{path} has no part {part}")


def visibility(path):
    channels = OpenEXR.File(path, separate_channels=True).parts[0].channels
    return 1.0 - np.array(channels["R"].pixels).astype(np.float32)


def errors(reference, found):
    """PSNR and the mean of FLIP of two greys."""
    square = float(np.mean((reference - found) ** 2))
    stacked = [np.repeat(np.clip(image, 0, 1)[..., None], 3, 2).astype(np.float32) for image in (reference, found)]
    return 10 * np.log10(1 / square), float(flip.evaluate(*stacked, "LDR")[1])


def render(program, folder, setting, out):
    pipeline = os.path.join(out, "ao.ron")
    with open(pipeline, "w") as file:
        file.write(PIPELINE % setting)
    beauty = os.path.join(folder, "beauty.####.exr")
    line = [program, "render", pipeline, f"{beauty}#ViewLayer.Depth", "--input", f"normal={beauty}#ViewLayer.Normal"]
    line += ["--input", "camera=" + os.path.join(folder, "camera.####.json"), "-o", os.path.join(out, "ao.####.exr")]
    subprocess.run(line, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def main():
    program, folders = sys.argv[1], sys.argv[2:]
    table = {name: [] for name in ["none", *SETTINGS]}
    for folder in folders:
        beauties = sorted(glob.glob(os.path.join(folder, "beauty.*.exr")))
        rows = {name: [] for name in table}
        references = []
        for path in beauties:
            is_seen = channel(path, "ViewLayer.Depth", "Z") < 1e9
            reference = np.where(is_seen, channel(path, "ViewLayer.Ambient Occlusion", "R"), 1.0)
            references.append((is_seen, reference))
            rows["none"].append(errors(reference, np.ones_like(reference)))
        for name, setting in SETTINGS.items():
            with tempfile.TemporaryDirectory() as out:
                render(program, folder, setting, out)
                for path, (is_seen, reference) in zip(beauties, references):
                    found = visibility(os.path.join(out, os.path.basename(path).replace("beauty", "ao")))
                    rows[name].append(errors(reference, np.where(is_seen, found, 1.0)))
        for name, values in rows.items():
            table[name].append(np.mean(values, 0))
    names = [os.path.basename(os.path.normpath(folder)) for folder in folders]
    print("| | " + " | ".join(names) + " |\n|---|" + "---|" * len(names))
    for name, values in table.items():
        print(f"| {name} | " + " | ".join(f"{psnr:.1f} dB, {mean:.3f}" for psnr, mean in values) + " |")


if __name__ == "__main__":
    main()
