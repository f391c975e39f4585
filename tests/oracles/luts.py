"""Lets OpenColorIO read the tables that `afterimage lut` writes, and compares its results with what the nodes render, on
random colors of each table's own space. Fails if they are further apart than the error that the program states:
luts.py PROGRAM FOLDER"""

import os
import re
import subprocess
import sys

import numpy
import OpenEXR
import PyOpenColorIO as ocio

PIPELINE = """Pipeline(
    inputs: { "scene": Color },
    nodes: { "exposed": Exposure(source: "scene", stops: 0.5), "vivid": Saturation(source: "exposed", amount: 1.2),
             "mapped": ToneMap(source: "vivid"), "encoded": Encode(source: "mapped", transfer: %s) },
    outputs: { "display": "encoded" },
)"""
SIZE = (256, 256)
# Red, green, blue and white (ARRI, "ALEXA Log C Curve", 2012; ITU-R BT.709).
WIDE = [(0.684, 0.313), (0.221, 0.848), (0.0861, -0.102), (0.3127, 0.329)]
REC709 = [(0.64, 0.33), (0.30, 0.60), (0.15, 0.06), (0.3127, 0.329)]


def to_xyz(primaries):
    columns = numpy.array([[x / y, 1, (1 - x - y) / y] for x, y in primaries]).T
    return columns[:, :3] * numpy.linalg.solve(columns[:, :3], columns[:, 3])


def from_log_c(codes):
    """Linear Rec.709 of LogC3 at EI 800."""
    cut, a, b, c, d, e, f = 0.010591, 5.555556, 0.052272, 0.247190, 0.385537, 5.367655, 0.092809
    light = numpy.where(codes > e * cut + f, (10 ** ((codes - d) / c) - b) / a, (codes - f) / e)
    return light @ (numpy.linalg.inv(to_xyz(REC709)) @ to_xyz(WIDE)).T


def from_srgb(codes):
    return numpy.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)


def main(program, folder):
    os.makedirs(folder, exist_ok=True)
    os.chdir(folder)
    random = numpy.random.default_rng(1)
    failed = []
    cases = [("log.cube", "LogC3", [], from_log_c), ("log65.clf", "LogC3", ["--size=65"], from_log_c),
             ("srgb.cube", "Srgb", [], from_srgb), ("linear.cube", "LinearRec709", ["--shaper"], None),
             ("linear.clf", "LinearRec709", ["--shaper=8", "--size=17"], None)]
    for transfer in ["Srgb", "Pq"]:
        with open("look.ron", "w") as file:
            file.write(PIPELINE % transfer)
        for name, space, options, decode in cases:
            name = f"{transfer}-{name}"  # OpenColorIO reads a name once.
            words = [program, "lut", "look.ron", "-o", name, "--from", space, *options]
            printed = subprocess.run(words, capture_output=True, text=True, check=True).stdout
            nearly_all, largest = map(float, re.search(r"99.9 % at most ([\d.]+); the largest of \d+ is ([\d.]+)", printed).groups())
            codes = random.random((*SIZE, 3))
            if decode is None:
                codes = numpy.exp2(codes[..., :1] * 17 - 12) * random.random((*SIZE, 3))
            light = codes if decode is None else decode(codes)
            pixels = numpy.concatenate([light, numpy.ones((*SIZE, 1))], axis=-1).astype("float32")
            OpenEXR.File({"type": OpenEXR.scanlineimage}, {"RGBA": pixels}).write("in.exr")
            words = [program, "render", "look.ron", "in.exr", "-o", "out.png", "--depth=16", "--exact"]
            subprocess.run(words, check=True, capture_output=True)
            exact = read_16_bits("out.png")
            config = ocio.Config.CreateRaw()
            transform = ocio.FileTransform(os.path.abspath(name), interpolation=ocio.INTERP_TETRAHEDRAL)
            table = config.getProcessor(transform).getDefaultCPUProcessor()
            shown = numpy.ascontiguousarray(codes, dtype="float32")
            table.applyRGB(shown)
            errors = numpy.abs(shown.reshape(exact.shape) - exact).max(axis=1) * 255
            share, worst = numpy.percentile(errors, 99.9), errors.max()
            print(f"{name}: 99.9 % {share:.3f}, {nearly_all} stated; largest {worst:.3f}, {largest} stated")
            # Other colors than those that the program measures, of linear light in another distribution; half a code of 16 bits.
            if not ((share <= nearly_all * 1.1 + 0.01 or decode is None) and worst <= largest * 1.3 + 0.01):
                failed.append(name)
    if failed:
        sys.exit(f"further apart than stated: {', '.join(failed)}")


def read_16_bits(name):
    import zlib
    data = open(name, "rb").read()
    at, packed = 8, b""
    while at < len(data):
        length = int.from_bytes(data[at:at + 4], "big")
        if data[at + 4:at + 8] == b"IHDR":
            width, height = (int.from_bytes(data[at + 8 + i:at + 12 + i], "big") for i in (0, 4))
            assert data[at + 16:at + 18] == b"\x10\x02", "RGB of 16 bits"
        if data[at + 4:at + 8] == b"IDAT":
            packed += data[at + 8:at + 8 + length]
        at += length + 12
    return unfiltered(zlib.decompress(packed), width, height)


def unfiltered(raw, width, height):
    """The numbers from 0 to 1 of the rows of a PNG (ISO 15948, 9)."""
    row, size = width * 6, 6
    rows = numpy.zeros((height, row), dtype="uint8")
    for y in range(height):
        kind, line = raw[y * (row + 1)], list(raw[y * (row + 1) + 1:(y + 1) * (row + 1)])
        above = rows[y - 1].tolist() if y else [0] * row
        for x in range(row):
            a, b, c = line[x - size] if x >= size else 0, above[x], above[x - size] if x >= size else 0
            p = a + b - c
            paeth = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            line[x] = line[x] + [0, a, b, (a + b) // 2, paeth][kind] & 255
        rows[y] = line
    return rows.reshape(-1, 2).astype("uint32").dot([256, 1]).reshape(-1, 3) / 65535


main(*sys.argv[1:])
