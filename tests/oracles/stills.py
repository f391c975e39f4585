"""Writes AVIF and JPEG XL files with libavif and libjxl, which `render` reads, and compares codes with those that their
own decoders give back, and with planes of ffmpeg's decoder, converted by H.273 in doubles: stills.py PROGRAM FOLDER.
The program has the features `avif` and `jxl`."""

import imagecodecs
import numpy

from judge import check, pipeline, render, run, start

PIPELINE = """Pipeline(inputs: { "in": Color }, nodes: { "same": Exposure(source: "in", stops: 0.0) }, outputs: { "light": "same" })"""
TO_XYZ = {  # ITU-R BT.709, SMPTE EG 432-1, ITU-R BT.2020
    1: [[0.412391, 0.357584, 0.180481], [0.212639, 0.715169, 0.072192], [0.019331, 0.119195, 0.950532]],
    12: [[0.486571, 0.265668, 0.198217], [0.228975, 0.691739, 0.079287], [0.0, 0.045113, 1.043944]],
    9: [[0.636958, 0.144617, 0.168881], [0.262700, 0.677998, 0.059302], [0.0, 0.028073, 1.060985]],
}


def signals(light, primaries, transfer):
    """Signals of light in Rec.709."""
    light = light @ (numpy.linalg.inv(TO_XYZ[primaries]) @ TO_XYZ[1]).T
    if transfer == 8:
        return light
    if transfer == 13:
        light = numpy.clip(light, 0, 1)
        return numpy.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    power = numpy.clip(light * 203 / 10000, 0, 1) ** 0.1593017578125
    return ((0.8359375 + 18.8515625 * power) / (1 + 18.6875 * power)) ** 78.84375


def picture(random, bits, size):
    """Smooth colors with some noise: halved planes of color show them, too."""
    y, x = numpy.mgrid[0:size[1], 0:size[0]] / 40
    waves = numpy.stack([numpy.sin(x), numpy.cos(y), numpy.sin(x + y)], -1) * 0.3 + 0.5
    noise = random.integers(-4, 5, waves.shape) * 2 ** (bits - 8)
    return numpy.clip(waves * (2**bits - 1) + noise, 0, 2**bits - 1).astype("u1" if bits == 8 else "u2")


WEIGHTS = {1: (0.2126, 0.0722), 6: (0.299, 0.114), 9: (0.2627, 0.0593)}


def upsampled(plane, count, axis):
    """A plane of `count` samples along an axis, linear between the centers of those that it has."""
    has = plane.shape[axis]
    place = numpy.clip((numpy.arange(count) + 0.5) * has / (count + count % 2 * (has < count)) - 0.5, 0, has - 1)
    before = numpy.floor(place).astype(int)
    share = (place - before)[:, None] if axis == 0 else place - before
    after = numpy.minimum(before + 1, has - 1)
    return numpy.take(plane, before, axis) * (1 - share) + numpy.take(plane, after, axis) * share


def by_definition(name, size, bits, layout, matrix):
    """Codes of a file of full range, by the planes that ffmpeg decodes."""
    planes = numpy.frombuffer(run("ffmpeg", "-v", "error", "-i", name, "-f", "rawvideo", "-"), "u1" if bits == 8 else "<u2")
    (width, height), (least, most) = size, (0.0, 2.0**bits - 1)
    of_color = {"444": size, "422": ((width + 1) // 2, height), "420": ((width + 1) // 2, (height + 1) // 2)}.get(layout, (0, 0))
    ends = numpy.cumsum([width * height, of_color[0] * of_color[1]])
    luma, blue, red = numpy.split(planes.astype("f8"), ends)
    luma = luma.reshape(height, width)
    if layout == "400":
        return numpy.stack([luma] * 3, -1)
    blue, red = (upsampled(upsampled(p.reshape(of_color[::-1]), height, 0), width, 1) for p in (blue, red))
    if matrix == 0:
        return numpy.stack([red, luma, blue], -1)
    (kr, kb), gray = WEIGHTS[matrix], 2.0 ** (bits - 1)
    red, blue = luma + 2 * (1 - kr) * (red - gray), luma + 2 * (1 - kb) * (blue - gray)
    green = (luma - kr * red - kb * blue) / (1 - kr - kb)
    return numpy.clip(numpy.stack([red, green, blue], -1), least, most)


def avif(program, random):
    for bits in [8, 10, 12]:
        for layout in ["444", "422", "420", "400"]:
            for primaries, transfer, matrix in [(1, 13, 1), (12, 13, 6), (9, 16, 9), (1, 13, 0)]:
                if matrix == 0 and layout != "444":
                    continue
                for size in [(64, 36), (37, 21)]:
                    codes = picture(random, bits, size)
                    file = imagecodecs.avif_encode(codes, level=95, speed=8, bitspersample=bits, pixelformat=layout,
                                                   primaries=primaries, transfer=transfer, matrix=matrix)
                    with open("in.avif", "wb") as out:
                        out.write(file)
                    theirs = numpy.atleast_3d(imagecodecs.avif_decode(file))[..., :3].astype("f8")
                    ours = signals(render(program, "same.ron", "in.avif"), primaries, transfer) * (2**bits - 1)
                    error = numpy.abs(ours - theirs).max()
                    exact = numpy.abs(ours - by_definition("in.avif", size, bits, layout, matrix)).max()
                    what = f"AVIF of {bits} bits, {layout}, {primaries}/{transfer}/{matrix}, {size}"
                    # libavif rounds halved planes of color twice, then the picture: 2 * 0.886 * (0.5 + 0.5) + 0.5 + its products.
                    check(f"{what}: {error:.2f} codes from libavif, {exact:.4f} from the definition", error < 2.8 and exact < 0.05)


def jxl(program, random):
    for bits in [8, 16]:
        codes = picture(random, bits, (37, 21))
        file = imagecodecs.jpegxl_encode(codes, lossless=True)
        with open("in.jxl", "wb") as out:
            out.write(file)
        # imagecodecs states linear light for 16 bits.
        stated = run("ffprobe", "-v", "error", "-show_entries", "stream=color_transfer", "-of", "csv=p=0", "in.jxl").decode()
        transfer = {"iec61966-2-1": 13, "linear": 8}[stated.strip()]
        ours = signals(render(program, "same.ron", "in.jxl"), 1, transfer) * (2**bits - 1)
        error = numpy.abs(ours - imagecodecs.jpegxl_decode(file)).max() / 2 ** (bits - 8)
        check(f"JPEG XL of {bits} bits: {error:.3f} codes of 8 bits", error < 0.02)


def main(program):
    pipeline("same.ron", PIPELINE)
    random = numpy.random.default_rng(1)
    avif(program, random)
    jxl(program, random)


start(main)
