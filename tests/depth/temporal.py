#!/usr/bin/env python3
"""Measures what `Taa` does over time: how it converges, what shimmers, and what stays where an object has been.

    venv/bin/python temporal.py PROGRAM FOLDER STILL [--chart FILE.svg]

FOLDER has the frames of `walk.py`. STILL receives 32 frames of one jittered sample in each pixel from a camera that
stands, and 256 samples of it. All images are compared as `walk.py` does. Prints a table:

convergence   PSNR of frames of the standing camera against its 256 samples
shimmer       of the last 16 of these, the standard deviation of each pixel over time; and on the walk the change from
              frame to frame that 16 samples of each frame do not have: means in codes of 255
ghosts        on the walk, the error of pixels that an object or the camera has uncovered within the last four frames,
              and of all others: means in codes of 255

The chart has the error after the camera stands still, and the changes and the errors of the uncovered pixels of each
frame of the walk.
"""
import argparse, os

import numpy as np

import frames
from chart import WITH, WITHOUT, label, line
from compare_cycles import errors
from walk import SIZE, TAA, jitter, run, shown, write_cameras

WALK, COUNT, SINCE, AGE = 0.4, 32, 8, 4


def render_still(program, folder):
    """The frames of a camera that stands, with all that `Taa` needs, and the mean of 256 samples."""
    nodes, outputs, more = "", "", ["--size", "x".join(map(str, SIZE))]
    scene = f"DemoScene(walk: {WALK}, step: 0.0, time: 1.0, dt: 0.0, objects: 0, "
    for frame in range(COUNT):
        nodes += f'"one{frame}": {scene} samples: 1, jitter: {tuple(jitter(frame))}),\n'
        for name, wire in [("one", ""), ("depth", ".depth"), ("motion", ".motion")]:
            outputs += f'"{name}{frame}": "one{frame}{wire}", '
            more += ["--output", f"{name}{frame}=" + frames.at(folder, name, frame)]
        write_cameras(folder, frame, WALK)
    for part in range(4):
        nodes += f'"many{part}": {scene} samples: 64, first: {64 * part}),\n'
        outputs += f'"many{part}": "many{part}", '
        more += ["--output", f"many{part}=" + frames.at(folder, "many", part)]
    run(program, folder, f"Pipeline(inputs: {{}}, nodes: {{ {nodes} }}, outputs: {{ {outputs} }})", more)
    mean = np.mean([frames.channels(frames.at(folder, "many", part), None, "RGB") for part in range(4)], 0)
    for frame in range(COUNT):
        frames.write(frames.at(folder, "still", frame), [mean[..., channel] for channel in range(3)])


def uncovered(folder, count):
    """For each frame, the pixels whose surface was behind another one in the frame before."""
    y, x = np.mgrid[0 : SIZE[1], 0 : SIZE[0]]
    found = [np.zeros(x.shape, bool)]
    before = frames.channels(frames.at(folder, "depth", 0), None, "R")[..., 0]
    for frame in range(1, count):
        depth = frames.channels(frames.at(folder, "depth", frame), None, "R")[..., 0]
        motion = frames.channels(frames.at(folder, "motion", frame), None, "RG")
        u, v = x - motion[..., 0] * SIZE[0], y - motion[..., 1] * SIZE[1]
        near = np.full(x.shape, np.inf)
        for dy in (0, 1):
            for dx in (0, 1):
                row = np.clip(np.floor(v).astype(int) + dy, 0, SIZE[1] - 1)
                column = np.clip(np.floor(u).astype(int) + dx, 0, SIZE[0] - 1)
                near = np.minimum(near, np.abs(before[row, column] - depth) / depth)
        found.append((near > 0.1) & (u >= 0) & (u < SIZE[0]) & (v >= 0) & (v < SIZE[1]))
        before = depth
    return [np.any(found[max(frame - AGE + 1, 0) : frame + 1], 0) for frame in range(count)]


def measured(program, still, walk, nodes, masks):
    """The figures of a source with these nodes: of the standing camera, and of each frame of the walk."""
    reference, found = shown_all(program, still, "still", ""), shown_all(program, still, "one", nodes)
    converges = [errors(reference[0], image)[0] for image in found]
    trembles = 255 * float(np.mean(np.std(found[-16:], 0)))
    reference, found = shown_all(program, walk, "still", ""), shown_all(program, walk, "one", nodes)
    rows = []
    for frame in range(SINCE, len(found)):
        change = (found[frame] - found[frame - 1]) - (reference[frame] - reference[frame - 1])
        error = np.abs(found[frame] - reference[frame]).mean(-1)
        mask = masks[frame]
        rows.append([255 * float(part) for part in (np.abs(change).mean(), error[mask].mean(), error[~mask].mean())])
    return converges, trembles, np.array(rows)


def shown_all(program, folder, source, nodes):
    image = shown(program, folder, source, nodes)
    return [image(frame) for frame in frames.numbers(folder, source)]


def panel(left, top, title, pairs, least=0):
    """One curve without and one with the node."""
    wide, high = 240, 120
    most = 1.05 * max(max(values) for values in pairs)
    drawn = [
        f'<rect x="{left}" y="{top}" width="{wide}" height="{high}" fill="none" stroke="#999"/>',
        label(left, top - 6, title),
        label(left - 5, top + 8, f"{most:.0f}", 'text-anchor="end"'),
        label(left - 5, top + high, f"{least}", 'text-anchor="end"'),
    ]
    for values, color in zip(pairs, (WITHOUT, WITH)):
        step = wide / max(len(values) - 1, 1)
        down = [top + high * (most - value) / (most - least) for value in values]
        drawn.append(line([(left + step * at, y) for at, y in enumerate(down)], color))
    return drawn


def draw(path, without, with_it):
    drawn = [
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 900 220" font-family="sans-serif" font-size="12">',
        '<rect width="900" height="220" fill="#fff"/>',
        label(40, 22, "Taa over time", 'font-size="15"'),
        label(150, 22, "one jittered sample", f'fill="{WITHOUT}"'),
        label(280, 22, "with Taa", f'fill="{WITH}"'),
    ]
    drawn += panel(40, 60, "PSNR in dB, a camera that stands", (without[0], with_it[0]), 20)
    drawn += panel(340, 60, "wrong change in codes, frames of the walk", (without[2][:, 0], with_it[2][:, 0]))
    drawn += panel(640, 60, "error of what was uncovered, in codes", (without[2][:, 1], with_it[2][:, 1]))
    with open(path, "w") as file:
        file.write("\n".join([*drawn, "</svg>\n"]))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("folder")
    parser.add_argument("still")
    parser.add_argument("--chart")
    args = parser.parse_args()
    os.makedirs(args.still, exist_ok=True)
    if not os.path.exists(frames.at(args.still, "still", COUNT - 1)):
        render_still(args.program, args.still)
    masks = uncovered(args.folder, len(frames.numbers(args.folder, "one")))
    share = 100 * np.mean(masks[SINCE:])
    print(f"uncovered: {share:.2f} % of the pixels of the walk\n")
    print("| | 1st frame | 8th | 16th | 32nd | shimmer, standing | on the walk | uncovered | all others |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|--:|")
    both = []
    for name, nodes in [("one jittered sample", ""), ("`Taa`", TAA)]:
        converges, trembles, rows = measured(args.program, args.still, args.folder, nodes, masks)
        psnr = " | ".join(f"{converges[at]:.1f} dB" for at in (0, 7, 15, 31))
        print(f"| {name} | {psnr} | {trembles:.2f} | {' | '.join(f'{mean:.2f}' for mean in rows.mean(0))} |", flush=True)
        both.append((converges, trembles, rows))
    if args.chart:
        draw(args.chart, *both)


if __name__ == "__main__":
    main()
