"""Writes DPX files with ffmpeg and OpenImageIO, which `render` reads, and compares codes and light:
dpxs.py PROGRAM FOLDER"""

import numpy
import OpenImageIO

from judge import check, pipeline, render, run, start

PIPELINE = """Pipeline(inputs: { "in": Color }, nodes: { "same": Exposure(source: "in", stops: 0.0) }, outputs: { "light": "same" })"""


def film(codes):
    exposure = lambda code: 10 ** ((code - 685) * 0.002 / 0.6)
    return (exposure(codes) - exposure(95)) / (1 - exposure(95))


def main(program):
    pipeline("same.ron", PIPELINE)
    random = numpy.random.default_rng(1)
    for width, height in [(37, 5), (1, 1), (130, 75), (2, 3)]:
        for samples, raw, bits in [("gbrp10be", "gbrp10le", 10), ("gbrp10le", "gbrp10le", 10), ("gbrp12be", "gbrp12le", 12), ("gbrp12le", "gbrp12le", 12),
                                   ("rgb48be", "gbrp16le", 16), ("rgb48le", "gbrp16le", 16), ("rgb24", "rgb24", 8), ("rgba64be", "gbrp16le", 16)]:
            codes = random.integers(0, 2**bits, (height, width, 3)).astype("<u2")
            planes = codes.astype("u1").tobytes() if bits == 8 else numpy.moveaxis(codes[..., [1, 2, 0]], -1, 0).tobytes()
            encode = ["ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", raw, "-s", f"{width}x{height}", "-i", "-", "-pix_fmt", samples, "in.dpx"]
            run(*encode, input=planes)
            decode = ["ffmpeg", "-loglevel", "error", "-i", "in.dpx", "-f", "rawvideo", "-pix_fmt", raw, "-"]
            again = run(*decode)
            found = render(program, "same.ron", "in.dpx") * (2**bits - 1)
            check(f"ffmpeg {samples} {width}x{height}", again == planes and numpy.abs(found - codes).max() < (0.3 if bits == 8 else 0.02))
    codes = random.integers(0, 1024, (75, 131, 3))
    for color, expected in [("KodakLog", film(codes)), ("lin_rec709", codes / 1023)]:
        for order in ["little", "big"]:
            spec = OpenImageIO.ImageSpec(131, 75, 3, "uint16")
            spec.attribute("oiio:BitsPerSample", 10)
            spec.attribute("oiio:ColorSpace", color)
            spec.attribute("oiio:Endian", order)
            out = OpenImageIO.ImageOutput.create("out.dpx")
            out.open("in.dpx", spec)
            out.write_image((codes * 64 + codes // 16).astype("uint16"))
            out.close()
            # Light below 0 is limited where the luminance is negative.
            is_lit = expected @ [0.2126, 0.7152, 0.0722] >= 0
            check(f"OpenImageIO {color} {order}", numpy.abs(render(program, "same.ron", "in.dpx") - expected)[is_lit].max() < 1e-4)


start(main)
