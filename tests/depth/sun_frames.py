#!/usr/bin/env python3
"""Renders the scenes of `compare_cycles.py` in white, lit by their sun alone, with and without its shadow.

    venv/bin/python sun_frames.py SCENES OUT [--seed 1] [--size 320x180] [--frames 1-24] [--samples 64]

SCENES is the script that renders all other frames, with `bpy` of Blender 5: it makes the scene of a seed when it is run. Writes `sun`
and `open`, and `sun6` and `open6` with a sun whose diameter in the sky is 6 degrees and four times as many samples. Light takes one
way only, from the sun to a surface to the camera, so that `sun` is `open` times the share of the sun that is seen.
"""
import argparse, math, os, runpy, sys

import bpy


def white():
    """A surface that reflects all light evenly."""
    material = bpy.data.materials.new("white")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    diffuse, output = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    diffuse.inputs["Color"].default_value = (1, 1, 1, 1)
    tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
    return material


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("scenes")
    parser.add_argument("out")
    parser.add_argument("--seed", default="1")
    parser.add_argument("--size", default="320x180")
    parser.add_argument("--frames", default="1-24")
    parser.add_argument("--samples", type=int, default=64)
    args = parser.parse_args()
    first, last = map(int, args.frames.split("-"))

    # A range without frames: the script makes its scene, and renders nothing.
    sys.argv = [args.scenes, args.out, "--seed", args.seed, "--size", args.size, "--frames", "1-0"]
    made = runpy.run_path(args.scenes)
    scene, sun = made["scene"], made["sun_data"]
    scene.camera = made["camera"]
    scene.cycles.max_bounces, scene.cycles.use_denoising = 0, False
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BLACKMAN_HARRIS", 1.5
    made["layer"].material_override = white()
    made["world"].node_tree.nodes["Background"].inputs[1].default_value = 0

    for frame in range(first, last + 1):
        scene.frame_set(frame)
        for wide in (False, True):
            sun.angle = math.radians(6) if wide else 0
            scene.cycles.samples = args.samples * (4 if wide else 1)
            for name, shadow in (("open", False), ("sun", True)):
                sun.use_shadow = shadow
                scene.render.filepath = os.path.join(args.out, f"{name}{'6' if wide else ''}.{frame:04d}.exr")
                bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    main()
