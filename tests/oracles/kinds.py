"""Compares kinds without Rust with other programs: blurs with SciPy and OpenCV, gradients and chroma with coloraide,
the distance to a polygon with OpenCV, dots of a print with a count of their regions. Fails if an error is larger than
the one that stands beside it: kinds.py PROGRAM FOLDER [OPTIONS OF RENDER]"""

import coloraide
import cv2
import numpy
from scipy import ndimage
from scipy.interpolate import PchipInterpolator

from judge import check, pipeline, render, start, write

HEIGHT, WIDTH = 180, 240
OKLAB, LINEAR = "oklab", "srgb-linear"


def smooth(seed):
    """Light of smooth blobs, the brightest 20."""
    random = numpy.random.default_rng(seed)
    noise = ndimage.gaussian_filter(random.random((HEIGHT, WIDTH, 3)), (4, 4, 0), mode="reflect")
    return 20 * ((noise - noise.min()) / (noise.max() - noise.min())) ** 3


class Judge:
    def __init__(self, program, options):
        self.program, self.options = program, options

    def render(self, nodes, pixels, state="Exposed"):
        text = f'Pipeline(inputs: {{ "in": {state} }}, nodes: {{ {nodes} }}, outputs: {{ "out": "result" }})'
        pipeline("kinds.ron", text)
        write("in.exr", pixels)
        return render(self.program, "kinds.ron", "in.exr", "--exact", *self.options)

    def compare(self, name, found, wanted, most, border=0):
        inner = numpy.s_[border:found.shape[0] - border, border:found.shape[1] - border]
        error = numpy.abs(found[inner] - wanted[inner]).max()
        check(f"{name}: {error:.5f}, at most {most} allowed", error <= most)


def blurs(judge):
    light = smooth(1)
    everywhere = '"mask": ShapeMask(source: "in", size: (8.0, 8.0)), '
    # Of two splines in the place of a Gaussian of the same variance: a mixture of both is farthest from it at 0.02.
    for sigma, most in [(0.01, 0.3), (0.02, 0.8), (0.05, 0.2)]:
        nodes = everywhere + f'"result": VariableBlur(source: "in", mask: "mask", sigma: {sigma})'
        wanted = ndimage.gaussian_filter(light, (sigma * HEIGHT, sigma * HEIGHT, 0), mode="reflect", truncate=8)
        judge.compare(f"VariableBlur of {sigma}, SciPy", judge.render(nodes, light), wanted, most)
    found = judge.render('"result": DirectionalBlur(source: "in", length: 0.25)', light)
    wanted = ndimage.uniform_filter1d(light, 45, axis=1, mode="nearest")
    judge.compare("DirectionalBlur, SciPy", found, wanted, 0.03, border=30)
    for zoom, spin in [(0.3, 0.0), (0.0, 40.0), (0.2, -30.0)]:
        wanted = numpy.zeros_like(light)
        for moment in (numpy.arange(400) + 0.5) / 400 - 0.5:
            # OpenCV turns against the clock, and its pixels have their middles at whole numbers.
            center = (0.4 * WIDTH - 0.5, 0.6 * HEIGHT - 0.5)
            moved = cv2.getRotationMatrix2D(center, -spin * moment, (1 + zoom) ** moment)
            size, border = (WIDTH, HEIGHT), cv2.BORDER_REPLICATE
            wanted += cv2.warpAffine(light, moved, size, flags=cv2.INTER_CUBIC, borderMode=border)
        nodes = f'"result": RadialBlur(source: "in", center: (0.4, 0.6), zoom: {zoom}, spin: {spin})'
        found = judge.render(nodes, light)
        judge.compare(f"RadialBlur of {zoom}, {spin}, OpenCV", found, wanted / 400, 0.15, border=45)


def colors(judge):
    stops = [(0.0, 0.02, 0.1), (0.3, 0.0, 0.2), (0.5, 0.4, 0.1), (0.2, 0.7, 0.6), (1.0, 0.9, 0.5)]
    names = ["black", "shadows", "middle", "highlights", "white"]
    codes = numpy.linspace(0, 1, 101)
    grays = numpy.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    lights = [coloraide.Color(LINEAR, stop) for stop in stops]
    between = coloraide.Color.interpolate(lights, space=OKLAB, out_space=LINEAR)
    wanted = numpy.array([[between(code).coords() for code in codes]])
    parameters = ", ".join(f"{name}: {stop}" for name, stop in zip(names, stops))
    nodes = f'"result": GradientMap(source: "in", {parameters})'
    found = judge.render(nodes, grays[None, :, None].repeat(3, axis=2), "DisplayLinear")
    judge.compare("GradientMap, coloraide", found, wanted, 3e-5)

    factors = [0.3, 1.5, 1.2, 0.8, 0.0]
    curve = PchipInterpolator([0, 0.25, 0.5, 0.75, 1], factors)
    random = numpy.random.default_rng(2)
    lights = random.random((1, 64, 3)) ** 2
    wanted = []
    for light in lights[0]:
        lightness, a, b = coloraide.Color(LINEAR, light).convert(OKLAB).coords()
        muted = max(1 - numpy.hypot(a, b) / lightness / 0.5, 0)
        factor = curve(lightness) * (1 + 0.6 * muted**2)
        wanted.append(coloraide.Color(OKLAB, [lightness, factor * a, factor * b]).convert(LINEAR).coords())
    parameters = ", ".join(f"{name}: {factor}" for name, factor in zip(names, factors))
    nodes = f'"result": SaturationCurves(source: "in", vibrance: 0.6, {parameters})'
    found = judge.render(nodes, lights)
    judge.compare("SaturationCurves, coloraide and SciPy", found, numpy.array([wanted]), 5e-5)


def shapes(judge):
    corners = numpy.array([[0.1, 0.15], [0.85, 0.1], [0.7, 0.5], [0.9, 0.9], [0.4, 0.6], [0.15, 0.85]])
    places = ", ".join(f"corner_{i + 1}: ({u}, {v})" for i, (u, v) in enumerate(corners))
    nodes = f'"result": PolygonMask(source: "in", corners: 6, softness: 0.3, {places})'
    contour = (corners * [WIDTH, HEIGHT]).astype("float32")
    rows = [[(x + 0.5, y + 0.5) for x in range(WIDTH)] for y in range(HEIGHT)]
    inside = numpy.array([[cv2.pointPolygonTest(contour, place, True) for place in row] for row in rows])
    ramp = numpy.clip(0.5 + inside / (0.3 * HEIGHT), 0, 1)
    wanted = (ramp**2 * (3 - 2 * ramp))[..., None].repeat(3, axis=2)
    black = numpy.zeros((HEIGHT, WIDTH, 3))
    judge.compare("PolygonMask, OpenCV", judge.render(nodes, black), wanted, 1e-4)

    # Dots on white that do not touch: as many as cells, and as much ink as the picture lacks of white.
    gray = numpy.full((HEIGHT, WIDTH, 3), 0.7)
    found = judge.render('"result": Newsprint(source: "in", cell: 0.1, color: false)', gray, "DisplayLinear")
    count, _ = cv2.connectedComponents((found[..., 0] < 0.5).astype("uint8"))
    cells = HEIGHT * WIDTH / (0.1 * HEIGHT) ** 2
    what = f"Newsprint, OpenCV: {count - 1} dots in {cells:.0f} cells and those that the border cuts"
    check(what, cells <= count - 1 <= cells * 1.35)
    judge.compare("Newsprint, the mean", found.mean(axis=(0, 1))[None, None], numpy.full((1, 1, 3), 0.7), 0.01)


def main(program, *options):
    judge = Judge(program, options)
    for part in [blurs, colors, shapes]:
        part(judge)


start(main)
