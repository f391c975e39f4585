"""Lets OpenColorIO read the tables that `afterimage lut` writes, and compares its results with what the nodes render, on
100 thousand random colors of each table's own space. Fails if one of them is further off than the largest error that
the program states: luts.py PROGRAM FOLDER"""

import os
import re

import imagecodecs
import numpy
import PyOpenColorIO as ocio

from judge import check, pipeline, run, start, write

PIPELINE = """Pipeline(inputs: { "scene": Color }, nodes: { "exposed": Exposure(source: "scene", stops: 0.5), %s },
    outputs: { "display": "encoded" })"""
FILM = """"vivid": Saturation(source: "exposed", amount: 1.2), "mapped": ToneMap(source: "vivid"),
    "encoded": Encode(source: "mapped", transfer: %s)"""
LOOKS = {
    "Srgb": FILM % "Srgb",
    "Pq": FILM % "Pq",
    "graded": """"graded": Cdl(source: "exposed", slope: (1.1, 1.0, 0.9), offset: (0.0, 0.01, 0.02), saturation: 1.3),
        "mapped": ToneMap(source: "graded", curve: AgX), "curved": Encode(source: "mapped", transfer: Srgb),
        "encoded": Contrast(source: "curved", amount: 0.8)""",
}
SIZE = (320, 320)
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


def main(program):
    random = numpy.random.default_rng(1)
    cases = [("log.cube", "LogC3", [], from_log_c), ("log65.clf", "LogC3", ["--size=65"], from_log_c),
             ("srgb.cube", "Srgb", [], from_srgb), ("linear.cube", "LinearRec709", ["--shaper"], None),
             ("linear.clf", "LinearRec709", ["--shaper=8", "--size=17"], None)]
    for look, nodes in LOOKS.items():
        pipeline("look.ron", PIPELINE % nodes)
        for name, space, options, decode in cases:
            name = f"{look}-{name}"  # OpenColorIO reads a name once.
            words = [program, "lut", "look.ron", "-o", name, "--from", space, *options]
            printed = run(*words).decode()
            stated = re.search(r"99.9 % at most ([\d.]+); the largest that a search finds is ([\d.]+)", printed)
            nearly_all, largest = map(float, stated.groups())
            codes = random.random((*SIZE, 3))
            if decode is None:
                codes = numpy.exp2(codes[..., :1] * 17 - 12) * random.random((*SIZE, 3))
            light = codes if decode is None else decode(codes)
            write("in.exr", light)
            run(program, "render", "look.ron", "in.exr", "-o", "out.png", "--depth=16", "--exact")
            with open("out.png", "rb") as file:
                exact = imagecodecs.png_decode(file.read()).reshape(-1, 3) / 65535
            config = ocio.Config.CreateRaw()
            transform = ocio.FileTransform(os.path.abspath(name), interpolation=ocio.INTERP_TETRAHEDRAL)
            table = config.getProcessor(transform).getDefaultCPUProcessor()
            shown = numpy.ascontiguousarray(codes, dtype="float32")
            table.applyRGB(shown)
            errors = numpy.abs(shown.reshape(exact.shape) - exact).max(axis=1) * 255
            share, worst = numpy.percentile(errors, 99.9), errors.max()
            # Linear light is in another distribution than the colors that the program measures.
            is_close = (share <= nearly_all * 1.1 + 0.01 or decode is None) and worst <= largest
            check(f"{name}: 99.9 % {share:.3f}, {nearly_all} stated; largest {worst:.3f}, {largest} stated", is_close)


start(main)
