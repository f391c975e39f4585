"""Writes TIFFs of many layouts with tifffile, which `render` reads, and reads what `render` writes with tifffile:
tiffs.py PROGRAM FOLDER"""

import subprocess

import av
import numpy
import OpenEXR
import tifffile

from judge import check, pipeline, run, start, write

PIPELINE = """Pipeline(inputs: { "in": Color }, nodes: { "same": Exposure(source: "in", stops: 0.0),
    "shown": ToneMap(source: "same"), "display": Encode(source: "shown", transfer: Srgb) },
    outputs: { "light": "same", "display": "display" })"""


def light(codes, last):
    signal = codes.astype("float64") / last
    return numpy.where(signal <= 0.04045, signal / 12.92, ((signal + 0.055) / 1.055) ** 2.4)


def main(program):
    pipeline("same.ron", PIPELINE)
    random = numpy.random.default_rng(1)
    for number, last in [("uint8", 255), ("uint16", 65535), ("float16", None), ("float32", None)]:
        values = random.random((75, 130, 3))
        pixels = (values * last).round().astype(number) if last else (values * 20).astype(number)
        for options in [{}, {"tile": (32, 48)}, {"planarconfig": "separate"}, {"tile": (16, 16), "planarconfig": "separate"}, {"bigtiff": True},
                        {"byteorder": ">"}, {"compression": "zlib"}, {"compression": "zlib", "predictor": True}, {"compression": "lzw"},
                        {"compression": "lzw", "predictor": True, "tile": (64, 64)}, {"compression": "packbits"}, {"rowsperstrip": 7}]:
            given = numpy.moveaxis(pixels, -1, 0) if "planarconfig" in options else pixels
            tifffile.imwrite("in.tif", given, photometric="rgb", **options)
            words = [program, "render", "same.ron", "in.tif", "-o", "out.exr", "--output=light", "--depth=32"]
            ended = subprocess.run(words, capture_output=True, text=True)
            if ended.returncode:
                # The library that reads TIFF does not read these.
                is_known = "tile" in options and "planarconfig" in options and "each channel has tiles of its own" in ended.stderr
                check(f"{number} {options}: {ended.stderr.strip()}", is_known)
                continue
            found = OpenEXR.File("out.exr").channels()["RGBA"].pixels[..., :3]
            expected = light(pixels, last) if last else pixels.astype("float64")
            check(f"{number} {options}", numpy.abs(found - expected).max() < (1e-3 if number == "uint8" else 1e-5 if last else 1e-6))
    pixels = (random.random((75, 130, 3)) * 4).astype("float32")
    write("in.exr", pixels)
    for depth, number in [(8, "uint8"), (16, "uint16"), (32, "float32")]:
        words = [program, "render", "same.ron", "in.exr", "-o", "out.tif", f"--depth={depth}", "--no-dither"]
        run(*words)
        with tifffile.TiffFile("out.tif") as file:
            found, page = file.asarray(), file.pages[0]
        check(f"written with {depth} bits: {found.dtype} {found.shape}, profile of {page.tags[34675].count} bytes", found.dtype == number and found.shape[:2] == (75, 130))
        if depth == 32:
            check("floats as they are", numpy.array_equal(found[..., :3], pixels))
        else:
            run(*words[:5], "out.png", *words[6:])
            with av.open("out.png") as png:
                frame = next(png.decode(video=0)).to_ndarray(format="rgb24" if depth == 8 else "rgb48le")
            check(f"codes of the PNG of {depth} bits", numpy.array_equal(found[..., :3], frame))


start(main)
