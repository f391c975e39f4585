#!/usr/bin/env python3
"""Compares `Taa`, `MotionBlur` and the chain `cinematic.ron` on a walk through the built-in scene with many samples.

    venv/bin/python walk.py PROGRAM REPOSITORY FOLDER [--frames 96]

The camera walks to the window and two objects move, at 24 frames per second, 320x180. FOLDER receives the frames: one
jittered sample in each pixel with depth, normals and motion; 16 samples of one moment; and the mean of eight moments of
eight samples in a shutter of 180 degrees. What is there already is not rendered again. Prints PSNR and the mean of FLIP
of every fourth frame after the first eight; the packages are those of `compare_cycles.py`.
"""
import argparse, json, os, subprocess

import numpy as np

import frames
from cases import VIEW
from compare_cycles import encoded, errors

FIRST, LAST, SIZE, FPS, MOMENTS, AT_ONCE = 0.15, 0.75, (320, 180), 24, 8, 8
TAN_FOV, NEAR = 0.4245, 0.1
SHOW = VIEW.replace("stops: 0.0", "stops: 2.0")


def halton(index, base):
    part, found = 1.0, 0.0
    while index:
        part /= base
        found += part * (index % base)
        index //= base
    return found - 0.5


def jitter(frame):
    return [halton(frame % 8 + 1, 2), halton(frame % 8 + 1, 3)]


def walk(frame, count):
    return FIRST + (LAST - FIRST) * frame / count


def view(place):
    """The rows of the matrix to the camera: the path of `DemoScene`."""
    share = place * place * (3 - 2 * place)
    lerp = lambda a, b: np.array(a) + share * (np.array(b) - np.array(a))
    eye, aim = lerp((1.75, 1.55, 4.7), (-0.45, 1.62, -2.3)), lerp((0.15, 1.72, -4.0), (-1.6, 2.0, -8.0))
    back = (eye - aim) / np.linalg.norm(eye - aim)
    right = np.cross((0, 1, 0), back)
    right /= np.linalg.norm(right)
    turn = np.array([right, np.cross(back, right), back])
    return np.vstack([np.column_stack([turn, -turn @ eye]), [0, 0, 0, 1]]).tolist()


def write_cameras(folder, frame, place):
    """The camera of a frame, without and with its jitter."""
    height = 1 / TAN_FOV
    projection = [[height * SIZE[1] / SIZE[0], 0, 0, 0], [0, height, 0, 0], [0, 0, 0, NEAR], [0, 0, -1, 0]]
    for name, moved in [("steady", [0, 0]), ("jittered", jitter(frame))]:
        with open(frames.at(folder, name, frame, "json"), "w") as file:
            json.dump({"view": view(place), "projection": projection, "jitter": moved}, file)


def run(program, folder, text, more):
    path = os.path.join(folder, "pipeline.ron")
    with open(path, "w") as file:
        file.write(text)
    line = [program, "render", path, "--depth", "32", *more]
    done = subprocess.run(line, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{path}\n{done.stderr[-2000:]}")


def scene(name, at, count, more):
    """A node of the scene at a frame or between two."""
    step = walk(1, count) - walk(0, count)
    return (
        f'"{name}": DemoScene(walk: {walk(at, count)}, step: {step}, time: {1 + at / FPS}, dt: {1 / FPS}, '
        f"objects: 2, {more}),\n"
    )


def render_scene(program, folder, numbers, count):
    """Several frames with one start of the program."""
    nodes, outputs, more = "", "", ["--size", "x".join(map(str, SIZE))]

    def add(name, frame, wire):
        nonlocal outputs
        outputs += f'"{name}{frame}": "{wire}", '
        more.extend(["--output", f"{name}{frame}=" + frames.at(folder, name, frame)])

    for frame in numbers:
        nodes += scene(f"one{frame}", frame, count, f"samples: 1, jitter: {tuple(jitter(frame))}")
        nodes += scene(f"many{frame}", frame, count, "samples: 16")
        add("one", frame, f"one{frame}")
        add("still", frame, f"many{frame}")
        for output in ("depth", "normal", "motion"):
            add(output, frame, f"one{frame}.{output}")
        for moment in range(MOMENTS):
            part = 0.5 * ((moment + 0.5) / MOMENTS - 0.5)
            nodes += scene(f"moment{moment}_{frame}", frame + part, count, "samples: 8")
            add(f"moment{moment}_", frame, f"moment{moment}_{frame}")
    run(program, folder, f"Pipeline(inputs: {{}}, nodes: {{ {nodes} }}, outputs: {{ {outputs} }})", more)
    for frame in numbers:
        files = [frames.at(folder, f"moment{moment}_", frame) for moment in range(MOMENTS)]
        mean = np.mean([frames.channels(file, None, "RGB") for file in files], 0)
        frames.write(frames.at(folder, "mean", frame), [mean[..., channel] for channel in range(3)])
        [os.remove(file) for file in files]
        write_cameras(folder, frame, walk(frame, count))


PORTS = 'depth: "linear", camera: "camera", motion: "motion"'
LINEAR = '"linear": LinearDepth(depth: "depth", camera: "camera", encoding: Distance),'
TAA = f'"made": Taa(source: "scene", history: "made@previous", previous_depth: "linear@previous", {PORTS}),'
BLUR = f'"made": MotionBlur(source: "scene", {PORTS}, largest: 0.1),'
# Name: the source, the nodes that are compared, and the frames that they should come to.
EFFECTS = {
    "one sample": ("one", "", "still"),
    "`Taa`": ("one", TAA, "still"),
    "16 samples of one moment": ("still", "", "mean"),
    "`MotionBlur`": ("still", BLUR, "mean"),
}
# The chain: the source, and what is off.
CHAIN = {
    "reference": ("mean", ["steady", "moved"]),
    "neither": ("one", ["steady", "moved"]),
    "`Taa` alone": ("one", ["moved"]),
    "`MotionBlur` alone": ("one", ["steady"]),
    "both": ("one", []),
}


def inputs(folder, source):
    camera = "jittered" if source == "one" else "steady"
    found = [frames.at(folder, source, 0).replace("0000", "####")]
    for name in ("depth", "motion"):
        found += ["--input", f"{name}=" + os.path.join(folder, f"{name}.####.exr")]
    return found + ["--input", "camera=" + os.path.join(folder, f"{camera}.####.json")]


def shown(program, folder, source, nodes):
    kinds = '"scene": Color, "depth": Depth, "motion": Motion, "camera": Camera'
    text = nodes + SHOW % ("made" if nodes else "scene")
    pipeline = f'Pipeline(inputs: {{ {kinds} }}, nodes: {{ {LINEAR} {text} }}, outputs: {{ "out": "view" }})'
    run(program, folder, pipeline, inputs(folder, source) + ["-o", os.path.join(folder, "out.####.exr")])
    return lambda frame: encoded(frames.channels(frames.at(folder, "out", frame), None, "RGB"))


def chain(program, repository, folder, name):
    """The frames of the whole chain, as PNG."""
    from PIL import Image

    source, off = CHAIN[name]
    title = "chain-" + name.strip("`").split("`")[0]
    line = [program, "render", os.path.join(repository, "pipelines", "cinematic.ron"), *inputs(folder, source)]
    line += ["--input", "normal=" + os.path.join(folder, "normal.####.exr"), "--set", "linear.encoding=Distance"]
    line += [part for node in off for part in ("--set", f"{node}=Off")] + ["--no-dither"]
    subprocess.run([*line, "-o", os.path.join(folder, f"{title}.####.png")], check=True, capture_output=True)
    return lambda frame: np.asarray(Image.open(frames.at(folder, title, frame, "png")).convert("RGB"), np.float32) / 255


def row(name, reference, found, numbers):
    psnr, mean = np.mean([errors(reference[frame], found(frame)) for frame in numbers], 0)
    print(f"| {name} | {psnr:.1f} dB, {mean:.3f} |", flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("repository")
    parser.add_argument("folder")
    parser.add_argument("--frames", type=int, default=96)
    args = parser.parse_args()
    os.makedirs(args.folder, exist_ok=True)
    missing = [f for f in range(args.frames) if not os.path.exists(frames.at(args.folder, "jittered", f, "json"))]
    for start in range(0, len(missing), AT_ONCE):
        render_scene(args.program, args.folder, missing[start : start + AT_ONCE], args.frames)
    numbers = range(8, args.frames, 4)
    for name, (source, nodes, wanted) in EFFECTS.items():
        reference = shown(args.program, args.folder, wanted, "")
        kept = {frame: reference(frame) for frame in numbers}
        row(name, kept, shown(args.program, args.folder, source, nodes), numbers)
    reference = chain(args.program, args.repository, args.folder, "reference")
    kept = {frame: reference(frame) for frame in numbers}
    for name in list(CHAIN)[1:]:
        row(f"`cinematic.ron`: {name}", kept, chain(args.program, args.repository, args.folder, name), numbers)


if __name__ == "__main__":
    main()
