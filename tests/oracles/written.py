"""Lets OpenEXR, OpenImageIO, libpng, libjpeg-turbo and exiftool read what the program writes, in every format, depth,
compression, with and without alpha, in every space, and with kept layers and attributes of names up to 255 letters.
Prints each file that a reader refuses, or that two readers see differently: written.py PROGRAM FOLDER"""

import os
import shutil
import subprocess
import sys

import numpy
import OpenEXR
import OpenImageIO
from PIL import Image

PIPELINE = """Pipeline(
    inputs: { "scene": Color },
    nodes: { "exposed": Exposure(source: "scene", stops: 0.5), "mapped": ToneMap(source: "exposed"),
             "encoded": Encode(source: "mapped", transfer: Srgb) },
    outputs: { "display": Output(source: "encoded", alpha: Coverage), "light": Output(source: "exposed", alpha: Coverage) },
)"""
COMPRESSIONS = ["none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"]
SPACES = ["Rec709", "P3", "Rec2020", "ACEScg", "ACES2065-1"]
# Shares of the largest number by which a file may differ from the one that is not packed.
LOSSES = {"pxr24": 1e-3, "b44": 0.05, "b44a": 0.05, "dwaa": 0.05, "dwab": 0.05}
NAMES = [5, 31, 32, 33, 64, 128, 254, 255]
KINDS = {
    "keyCode": OpenEXR.KeyCode(1, 2, 3, 4, 5, 4, 64), "aTime": OpenEXR.TimeCode(),
    "aPair": (1, 2), "aTriple": (1.0, 2.0, 3.0), "aMatrix": numpy.eye(4, dtype="float32"), "aNumber": 2.5, "aList": ["a", "b"],
    "aBox": ((1, 2), (3, 4)), "capDate": "2026:01:02 03:04:05", "utcOffset": 3600.0, "expTime": 0.02,
    "preview": OpenEXR.PreviewImage(numpy.zeros((2, 2, 4), dtype="uint8")),
}
SIZE = (37, 67)  # B44 has blocks of 4x4 and of 32 rows: both are cut.


def write_inputs():
    # Smooth: B44 quantizes the range of each block.
    y, x = numpy.mgrid[: SIZE[0], : SIZE[1]] / 20.0
    pixels = numpy.stack([2 + numpy.sin(x + y), 1 + numpy.cos(y), 3 + numpy.sin(x), x / 4], axis=-1)
    pixels[..., :3] *= pixels[..., 3:]
    pixels, plane = pixels.astype("float16"), (1 + numpy.sin(x) / 2).astype("float32")
    for length in NAMES:
        name = ("n" * 300)[: length - 2]
        channels = {"RGBA": pixels, "Z": plane, "id": (plane * 9e5).astype("uint32")}
        channels |= {f"{name}.{channel}": plane.astype("float16") for channel in "RG"}
        header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, name + "tt": "a text", "owner": "somebody"}
        OpenEXR.File(header, channels).write(f"in{length}.exr")
        if length == NAMES[0]:
            OpenEXR.File(header | KINDS, channels).write("kinds.exr")
    with open("p.ron", "w") as file:
        file.write(PIPELINE)


def run(program, name, *options, source="in5.exr"):
    """Renders a file; what the program says if it fails."""
    output = "light" if name.endswith(".exr") else "display"
    words = [program, "render", "p.ron", source, f"--output={output}={name}", *options]
    ended = subprocess.run(words, capture_output=True, text=True)
    return None if ended.returncode == 0 else f"status {ended.returncode}: {ended.stderr.strip()}"


def by_openimageio(name):
    file = OpenImageIO.ImageInput.open(name)
    if file is None:
        return None, OpenImageIO.geterror()
    pixels, names = file.read_image("float"), list(file.spec().channelnames)
    return (names, pixels), file.geterror() if pixels is None else None


def exr_faults(name):
    """What is wrong for each reader, and the numbers of each channel as OpenEXR has them."""
    try:
        with OpenEXR.File(name, separate_channels=True) as file:
            header, seen = dict(file.header()), {key: value.pixels.copy() for key, value in file.channels().items()}
    except Exception as error:
        return [f"OpenEXR: {error}"], {}, {}
    other, fault = by_openimageio(name)
    faults = [f"OpenImageIO: {fault}"] if fault else []
    if warnings := int(OpenEXR.checkColorMetadata(header)):
        faults.append(f"OpenEXR: colors contradict each other: {warnings:#x}")
    for at, channel in enumerate(other[0] if other and not fault else []):
        # Whole numbers become shares of the largest one there.
        if channel in seen and seen[channel].dtype != "uint32" and not numpy.allclose(other[1][..., at], seen[channel].astype("float32"), rtol=1e-6, equal_nan=True):
            faults.append(f"OpenImageIO has other numbers in {channel}")
    return faults, header, seen


def codes_faults(name, channels, depth):
    try:
        picture = Image.open(name)
        picture.load()
    except Exception as error:
        return [f"Pillow: {error}"]
    other, fault = by_openimageio(name)
    if fault:
        return [f"OpenImageIO: {fault}"]
    faults = [] if len(other[0]) == channels else [f"OpenImageIO sees {other[0]}"]
    if depth == 8 and channels == 3:
        off = numpy.abs(numpy.asarray(picture).astype(float) - other[1] * 255).max()
        faults += [f"Pillow and OpenImageIO differ by {off} codes"] if off > 1.01 else []
    return faults


def exiftool_faults(name):
    if not shutil.which("exiftool"):
        return []
    words = ["exiftool", "-validate", "-warning", "-error", "-s3", "-a", name]
    said = subprocess.run(words, capture_output=True, text=True).stdout.split("\n")
    return [f"exiftool: {line}" for line in said if line and line != "OK" and "Minor" not in line and "minor" not in line]


def main():
    program = os.path.abspath(sys.argv[1])
    os.makedirs(sys.argv[2], exist_ok=True)
    os.chdir(sys.argv[2])
    if not shutil.which("exiftool"):
        print("exiftool is not installed: it reads no file (apt-get install libimage-exiftool-perl)", flush=True)
    write_inputs()
    count, wrong = 0, []

    def check(name, said, faults):
        nonlocal count
        count += 1
        wrong.extend(f"{name}: {fault}" for fault in ([said] if said else faults() + exiftool_faults(name)))

    exact = {}
    for kind, bits in [("half", 16), ("float", 32)]:
        for compression in COMPRESSIONS:
            name = f"{kind}-{compression}.exr"
            said = run(program, name, f"--depth={bits}", f"--compression={compression}")

            def faults():
                found, _, seen = exr_faults(name)
                exact.setdefault(kind, seen)
                for channel, wanted in exact[kind].items():
                    loss = LOSSES.get(compression, 0.0) if channel in "RGBA" or wanted.dtype != "uint32" else 0.0
                    off = numpy.abs(seen[channel].astype(float) - wanted).max() if channel in seen else numpy.inf
                    if off > loss * numpy.abs(wanted.astype(float)).max():
                        found.append(f"{channel} differs by {off} from the file that is not packed")
                return found

            check(name, said, faults)
    for space in SPACES:
        name = f"space-{space}.exr"
        check(name, run(program, name, f"--output-space={space}"), lambda: exr_faults(name)[0])
    for length in NAMES:
        name, kept = f"names-{length}.exr", ("n" * 300)[: length - 2]
        said = run(program, name, source=f"in{length}.exr")

        def faults():
            found, header, seen = exr_faults(name)
            if not found and (f"{kept}tt" not in header or f"{kept}.R" not in seen or "Z" not in seen):
                print(f"{name}: not kept: {[key for key in (f'{kept}tt',) if key not in header]}")
            return found

        check(name, said, faults)
    check("kept.exr", run(program, "kept.exr", source="kinds.exr"), lambda: exr_faults("kept.exr")[0])
    for depth in [8, 16]:
        for alpha, channels in [("keep", 4), ("drop", 3)]:
            name = f"{depth}-{alpha}.png"
            said = run(program, name, f"--depth={depth}", f"--alpha={alpha}")
            check(name, said, lambda: codes_faults(name, channels, depth))
    for quality in [1, 50, 85, 92, 100]:
        name = f"{quality}.jpg"
        check(name, run(program, name, f"--quality={quality}"), lambda: codes_faults(name, 3, 8))
    print("\n".join(wrong))
    print(f"OpenImageIO {OpenImageIO.__version__}: {count} files that the program wrote, {len(wrong)} faults")
    sys.exit(bool(wrong))


main()
