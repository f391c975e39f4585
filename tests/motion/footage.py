"""Sequences in motion for `judge.py` and `sheet.py`, from photographs and lamps, as EXR files of half floats.

Each is eight frames of 480x270 pixels. Photographs are Radiance or EXR files with a name of `PHOTOGRAPHS` in it.
"""

import subprocess
from pathlib import Path

import cv2
import numpy
import OpenEXR

WIDTH, HEIGHT, FRAMES = 480, 270, 8
# What moves through a photograph, and the one of a lamp.
NIGHT, MARKET, GARDEN, CITY = PHOTOGRAPHS = ("st_peters_square_night", "leadenhall_market", "chinese_garden", "city")


def photograph(folder, name):
    """A photograph whose mean luminance is middle gray, or a fifth of it at night."""
    path = next(path for ending in ("hdr", "exr") for path in sorted(Path(folder).rglob(f"{name}*.{ending}")))
    if path.suffix == ".hdr":
        pixels = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)[..., ::-1]
    else:
        with OpenEXR.File(str(path)) as file:
            pixels = file.channels()[next(iter(file.channels()))].pixels[..., :3]
    pixels = numpy.ascontiguousarray(pixels, numpy.float32)
    gray = numpy.exp(numpy.log(pixels.mean(-1).clip(1e-4)).mean())
    return pixels * ((0.04 if name == NIGHT else 0.18) / gray)


def part(pixels, left, top, zoom=1.0):
    """A part of a photograph, `zoom` times as large; its corner may lie between pixels."""
    matrix = numpy.float32([[1 / zoom, 0, left], [0, 1 / zoom, top]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(pixels, matrix, (WIDTH, HEIGHT), flags=flags, borderMode=cv2.BORDER_REFLECT)


def lamp(frame, x, y, radius, light, color=(1.0, 0.8, 0.5)):
    """A frame with a disc of light, whose edge is a pixel wide."""
    rows, columns = numpy.mgrid[0:HEIGHT, 0:WIDTH] + 0.5
    share = numpy.clip(radius + 0.5 - numpy.hypot(columns - x, rows - y), 0, 1)[..., None]
    return frame * (1 - share) + share * light * numpy.float32(color)


def sequences(photographs):
    """The frames of each sequence by its name."""
    night, market, garden, city = (photograph(photographs, name) for name in PHOTOGRAPHS)
    square = part(night, 270, 120)
    frames = range(FRAMES)
    strobe = {2, 5, 6}
    return {
        "lamp": [lamp(square, 150 + 5 * frame, 120, 4, 60.0) for frame in frames],
        "strobe": [
            lamp(lamp(square * 1.5, 120, 90, 12, 40.0), 340, 150, 3, 300.0, (0.6, 0.8, 1.0)) if frame in strobe
            else square
            for frame in frames
        ],
        "pan": [part(market, 200 + 5 * frame, 110) for frame in frames],
        "slow pan": [part(night, 250 + 0.3 * frame, 110) for frame in frames],
        "zoom": [part(garden, 230 + 3 * frame, 100 + 1.5 * frame, 1.02**frame) for frame in frames],
        "cut": [part(city, 200, 100) if frame < 3 else 6 * part(market, 500, 120) for frame in frames],
    }


def write(folder, name, frames):
    """Writes a sequence, whose frames count from 0 as those of `measure` do; returns its pattern."""
    folder.mkdir(parents=True, exist_ok=True)
    for number, frame in enumerate(frames):
        pixels = numpy.concatenate([frame, numpy.ones_like(frame[..., :1])], -1).clip(0, 65504).astype(numpy.float16)
        path = folder / f"{name.replace(' ', '-')}.{number:04}.exr"
        OpenEXR.File({"type": OpenEXR.scanlineimage}, {"RGBA": numpy.ascontiguousarray(pixels)}).write(str(path))
    return folder / f"{name.replace(' ', '-')}.####.exr"


def walk(program, folder):
    """Renders a walk through the built-in scene; returns its pattern."""
    folder.mkdir(parents=True, exist_ok=True)
    scene = folder / "scene.ron"
    scene.write_text('Pipeline(inputs: {}, nodes: { "scene": DemoScene() }, outputs: { "result": "scene" })\n')
    for frame in range(FRAMES):
        seconds = frame / 24
        moved = [f"--set=scene.time={seconds}", f"--set=scene.walk={0.2 * seconds}", f"--size={WIDTH}x{HEIGHT}"]
        command = [program, "render", scene, "-o", folder / f"walk.{frame:04}.exr", *moved]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return folder / "walk.####.exr"


def all_patterns(program, photographs, folder):
    """Writes all sequences; returns their patterns by their names."""
    patterns = {name: write(folder, name, frames) for name, frames in sequences(photographs).items()}
    return {**patterns, "walk": walk(program, folder)}
