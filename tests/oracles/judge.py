"""Parts that the oracles share: the list of checks that failed, the program's renders of EXRs, and the start of a script."""

import os
import subprocess
import sys

import numpy
import OpenEXR

failed = []


def check(what, is_right):
    print(f"{'good' if is_right else 'WRONG'}: {what}", flush=True)
    if not is_right:
        failed.append(what)


def run(*words, **options):
    """Standard output of a command that succeeds."""
    ended = subprocess.run(words, capture_output=True, **options)
    if ended.returncode:
        sys.exit(f"{' '.join(words)}: {ended.stderr.decode()}")
    return ended.stdout


def pipeline(name, text):
    with open(name, "w") as file:
        file.write(text)


def write(name, pixels):
    """An EXR of 32 bits, opaque where there is no alpha."""
    if pixels.shape[-1] == 3:
        pixels = numpy.concatenate([pixels, numpy.ones((*pixels.shape[:2], 1))], axis=-1)
    channels = {"RGBA": numpy.ascontiguousarray(pixels, dtype="float32")}
    OpenEXR.File({"type": OpenEXR.scanlineimage}, channels).write(name)


def render(program, pipeline, image, *options):
    """Red, green and blue of an output without a transfer function."""
    run(program, "render", pipeline, image, "-o", "out.exr", "--depth=32", *options)
    return next(iter(OpenEXR.File("out.exr").channels().values())).pixels[..., :3].astype("float64")


def start(main):
    """Runs `main` with the words of the command line, PROGRAM FOLDER REST, but for the folder, in which it runs."""
    program, folder, *rest = [os.path.abspath(word) if os.path.exists(word) else word for word in sys.argv[1:]]
    os.makedirs(folder, exist_ok=True)
    os.chdir(folder)
    main(program, *rest)
    if failed:
        sys.exit(f"{len(failed)} wrong")
