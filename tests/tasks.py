#!/usr/bin/env python3
"""Tasks of a pipeline TD, in an empty folder with images that this script makes. Optional: no test needs it.

    python3 -m venv v && v/bin/pip install numpy openexr pillow opencv-python-headless colour-science openjd-model==0.14.0
    apt-get install parallel
    cargo build --release
    v/bin/python tests/tasks.py target/release/afterimage > graph/docs/measurements/tasks.csv

A row is a task: its command, how it ended, what it printed last, and what a reader that is not ours says of the files.
The exit status is 1 if any reader disagrees.
"""

import csv
import json
import os
import struct
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml
from pathlib import Path

import colour
import cv2
import numpy as np
import OpenEXR
from openjd.model import decode_job_template
from PIL import Image, ImageOps

PROGRAM = str(Path(sys.argv[1]).resolve())
FOLDER = Path(tempfile.mkdtemp())
WIDTH, HEIGHT = 96, 54


# The images.


def light(frame=1):
    """A dim ramp, a saturated lamp above white, and gray that gets brighter from frame to frame."""
    x, y = np.meshgrid(np.linspace(0, 1, WIDTH), np.linspace(0, 1, HEIGHT))
    pixels = np.stack([0.02 + 0.3 * x, 0.02 + 0.2 * y, 0.1 + 0 * x], -1)
    pixels[10:16, 20:30] = [12, 4, 0.5]
    return (pixels * (1 + 0.1 * frame)).astype(np.float32)


def write_exr(name, channels, header=None):
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage} | (header or {})
    with OpenEXR.File(header, channels) as file:
        file.write(str(FOLDER / name))


def write_radiance(name, pixels):
    """Flat RGBE."""
    mantissa, exponent = np.frexp(pixels.max(-1))
    scaled = np.floor(pixels * (mantissa * 256 / pixels.max(-1))[..., None])
    texels = np.concatenate([scaled, (exponent + 128)[..., None]], -1).astype(np.uint8)
    head = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {HEIGHT} +X {WIDTH}\n"
    (FOLDER / name).write_bytes(head.encode() + texels.tobytes())


def make_images():
    for frame in range(1, 9):
        write_exr(f"shot.{frame:04}.exr", {"RGB": light(frame).astype(np.float16)})
        (FOLDER / "gap").mkdir(exist_ok=True)
        if frame != 4:
            write_exr(f"gap/shot.{frame:04}.exr", {"RGB": light(frame).astype(np.float16)})
    write_exr("in.exr", {"RGB": light()})
    depth = np.linspace(1, 50, WIDTH * HEIGHT, dtype=np.float32).reshape(HEIGHT, WIDTH)
    write_exr("layers.exr", {"RGB": light().astype(np.float16), "Z": depth, "albedo.R": depth.astype(np.float16),
                             "albedo.G": depth.astype(np.float16), "albedo.B": depth.astype(np.float16)})
    broken = light()
    broken[5, 5], broken[6, 9, 1] = np.nan, np.inf
    write_exr("broken.exr", {"RGB": broken})
    ap1 = (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767)
    write_exr("acescg.exr", {"RGB": light()}, {"chromaticities": ap1})
    window = (np.array([-8, -4], np.int32), np.array([WIDTH - 9, HEIGHT - 5], np.int32))
    shown = (np.array([0, 0], np.int32), np.array([WIDTH - 17, HEIGHT - 9], np.int32))
    write_exr("overscan.exr", {"RGB": light()}, {"dataWindow": window, "displayWindow": shown})
    write_radiance("in.hdr", light())
    (FOLDER / "cutshort.exr").write_bytes((FOLDER / "in.exr").read_bytes()[:900])
    codes = np.random.default_rng(7).integers(0, 256, (HEIGHT, WIDTH, 3), np.uint8)
    Image.fromarray(codes).save(FOLDER / "codes.png")
    exif = Image.Exif()
    exif[0x0112] = 6
    smooth = Image.fromarray(np.uint8(np.clip(light() * 150, 0, 255)))
    smooth.save(FOLDER / "held.jpg", exif=exif, quality=98, subsampling=0)
    rows = [f"{1 - r} {1 - g} {1 - b}" for b in (0, 1) for g in (0, 1) for r in (0, 1)]
    (FOLDER / "invert.cube").write_text("LUT_3D_SIZE 2\n" + "\n".join(rows) + "\n")


PIPELINES = {
    "through.ron": 'Pipeline(inputs: { "in": Color }, nodes: { "lit": Exposure(source: "in", stops: 0.0) }, '
    'outputs: { "light": "lit" })',
    "shown.ron": 'Pipeline(extends: "through.ron", nodes: { "mapped": ToneMap(source: "lit", curve: None, keep_hue: 0.0, '
    'gamut: Clip), '
    '"signal": Encode(source: "mapped", transfer: Srgb) }, outputs: { "out": "signal" })',
    "lut.ron": 'Pipeline(extends: "shown.ron", nodes: { "graded": ColorLut(source: "signal", file: "invert.cube") }, '
    'outputs: { "out": "graded" })',
    "posterized.ron": 'Pipeline(extends: "shown.ron", nodes: { "few": Posterize(source: "signal", levels: 4.0) }, '
    'outputs: { "out": "few" })',
    "wrong.ron": 'Pipeline(\n    inputs: { "in": Color },\n    nodes: { "lit": Exposre(source: "in") },\n'
    '    outputs: { "light": "lit" },\n)\n',
}


def make_files():
    for name, text in PIPELINES.items():
        (FOLDER / name).write_text(text)
    kind = FOLDER / "kinds" / "posterize"
    kind.mkdir(parents=True)
    (kind / "node.ron").write_text(
        'Kind(name: "Posterize", doc: "Few levels.", inputs: { "source": Image(doc: "An image.", accepts: [Encoded]) }, '
        'outputs: { "result": Image(doc: "The result.", state: Same("source")) }, '
        'parameters: { "levels": Float(doc: "Levels.", default: 4.0, within: (2.0, 256.0)) })'
    )
    (kind / "posterize.wgsl").write_text(
        "struct Posterize { levels: f32 }\nfn posterize(source: vec4f, params: Posterize) -> vec4f {\n"
        "    let steps = params.levels - 1.0;\n    return vec4f(round(source.rgb * steps) / steps, source.a);\n}\n"
    )


# Readers that are not ours.


def exr(name):
    with OpenEXR.File(str(FOLDER / name)) as file:
        return dict(file.header()), {key: channel.pixels for key, channel in file.channels().items()}


def rgb(name):
    channels = exr(name)[1]
    return channels["RGBA" if "RGBA" in channels else "RGB"][..., :3].astype(float)


def png(name):
    """The codes of a PNG by libpng, in OpenCV."""
    return cv2.imread(str(FOLDER / name), cv2.IMREAD_UNCHANGED)[..., 2::-1]


def chunk(name, kind):
    data = (FOLDER / name).read_bytes()
    at = data.index(kind.encode())
    return data[at + 4 : at + 4 + struct.unpack(">I", data[at - 4 : at])[0]]


def codes(name):
    return np.asarray(Image.open(FOLDER / name).convert("RGB")).astype(int)


def same(first, second):
    return (FOLDER / first).read_bytes() == (FOLDER / second).read_bytes()


def need(is_so, what):
    assert is_so, what
    return what


# The tasks: what is done, the command, the exit status, and what a reader says.

TASKS = []


def task(what, command, status=0, shell=False):
    def keep(check):
        TASKS.append((what, command, status, shell, check))
        return check

    return keep


@task("list the built-in pipelines", "pipelines")
def _(out):
    return need(len(out.splitlines()) >= 13, f"{len(out.splitlines())} lines")


@task("a picture with a built-in look", "render tsushima in.exr -o look.png")
def _(out):
    return need(codes("look.png").shape == (HEIGHT, WIDTH, 3), "Pillow: 96x54, RGB")


@task("16 bits for a retoucher", "render tsushima in.exr -o deep.png --depth 16")
def _(out):
    off = np.abs(png("deep.png") / 257 - codes("look.png")).max()
    return need(png("deep.png").dtype == np.uint16 and off < 1.6, f"OpenCV: 16 bits, within {off:.2f} codes of 8 bits")


@task("a JPEG for a producer", "render tsushima in.exr -o look.jpg --quality 95")
def _(out):
    off = np.abs(codes("look.jpg") - codes("look.png")).mean()
    return need(off < 3, f"Pillow: {off:.1f} codes beside the PNG")


@task("graded light as half EXR", "render through.ron in.exr -o light.exr")
def _(out):
    found = exr("light.exr")[1]["RGBA"]
    return need(found.dtype == np.float16 and np.allclose(found[..., :3], light(), rtol=1e-3), "OpenEXR: half, the same light")


@task("ACEScg, 32 bits", "render through.ron in.exr -o acescg-out.exr --output-space ACEScg --depth 32")
def _(out):
    header = exr("acescg-out.exr")[0]
    return need(abs(header["chromaticities"][0] - 0.713) < 1e-4, f"OpenEXR: {header['colorInteropID']}")


@task("an ACES container", "render through.ron in.exr -o aces.exr --output-space ACES2065-1 --compression none")
def _(out):
    header = exr("aces.exr")[0]
    return need(header["acesImageContainerFlag"] == 1, "OpenEXR: acesImageContainerFlag 1, no compression")


@task("an EXR in ACEScg is read as its label says", "render through.ron acescg.exr -o from.exr --depth 32")
def _(out):
    to_rec709 = np.array([[1.7050, -0.6217, -0.0833], [-0.1301, 1.1407, -0.0106], [-0.0240, -0.1289, 1.1529]])
    off = np.abs(rgb("from.exr") - light() @ to_rec709.T).max()
    return need(off < 2e-3, f"published matrix: within {off:.0e}")


@task("a file that lies", "render through.ron in.exr -o told.exr --depth 32 --input-space ACEScg")
def _(out):
    return need(np.array_equal(rgb("told.exr"), rgb("from.exr")), "OpenEXR: as the labeled file")


@task("a sequence", "render tsushima shot.####.exr -o out/shot.####.png")
def _(out):
    return need(len(list((FOLDER / "out").glob("shot.000?.png"))) == 8, "8 files")


@task("a range in the middle warns", "render tsushima shot.####.exr -o out/part.####.png --frames 5-8")
def _(out):
    return need(not same("out/part.0005.png", "out/shot.0005.png"), "the exposure begins anew, as it warns")


@task("measure, in any order", "meter tsushima shot.####.exr -o shot.meter")
def _(out):
    return need(len((FOLDER / "shot.meter").read_text().splitlines()) >= 8, "a line for each frame")


@task("a range like the whole", "render tsushima shot.####.exr -o out/same.####.png --frames 5-8 --meter shot.meter")
def _(out):
    return need(all(same(f"out/same.{f:04}.png", f"out/shot.{f:04}.png") for f in range(5, 9)), "cmp: 4 files equal")


@task("a job for a farm", "job tsushima shot.####.exr -o out/farm.####.png --chunk 3")
def _(out):
    template = decode_job_template(template=json.loads(out), supported_extensions=["TASK_CHUNKING"])
    return need([step.name for step in template.steps] == ["Meter", "Render"], "openjd-model: valid, Meter and Render")


FARM = (
    "parallel -j 2 \"$AFTERIMAGE meter tsushima shot.####.exr -o m.####.meter --frames {}\" ::: 1-4 5-8 && "
    "parallel -j 2 \"$AFTERIMAGE render tsushima shot.####.exr -o out/gnu.####.png --meter m.####.meter --frames {}\" "
    "::: 5-8 1-4"
)


@task("a farm of one machine", FARM, shell=True)
def _(out):
    return need(all(same(f"out/gnu.{f:04}.png", f"out/shot.{f:04}.png") for f in range(1, 9)), "cmp: 8 files equal")


@task("progress for a farm", "render tsushima in.exr -o out/progress.png --openjd")
def _(out):
    return need("openjd_progress: 100.0" in out, "openjd_progress: 100.0")


@task("a missing frame is an error", "render tsushima gap/shot.####.exr -o out/gap.####.png --frames 1-8", 1)
def _(out):
    return need("4" in out, "it names the frame")


@task("a missing frame is held", "render tsushima gap/shot.####.exr -o out/gap.####.png --frames 1-8 --missing hold")
def _(out):
    return need(len(list((FOLDER / "out").glob("gap.*.png"))) == 8, "8 files")


@task("render what is missing", "render tsushima shot.####.exr -o out/same.####.png --meter shot.meter --skip-existing")
def _(out):
    return need(same("out/same.0001.png", "out/shot.0001.png") and "4 skipped" in out, "4 skipped, cmp: equal")


@task("a report", "render tsushima shot.####.exr -o out/r.####.png --frames 1-2 --json report.json")
def _(out):
    report = json.loads((FOLDER / "report.json").read_text())
    return need(len(report["frames"]) == 2, f"json: {', '.join(sorted(report))}"[:90])


@task("what is in a file", "info layers.exr --json")
def _(out):
    return need("albedo" in out and json.loads(out), "json: with the layer albedo")


@task("is anything broken", "info broken.exr --pixels")
def _(out):
    return need("NaN" in out, "it counts NaN")


@task("broken pixels are repaired", "render through.ron broken.exr -o repaired.exr --depth 32")
def _(out):
    return need(np.isfinite(rgb("repaired.exr")).all(), "OpenEXR: all finite")


@task("a file that was cut short", "render tsushima cutshort.exr -o out/x.png", 1)
def _(out):
    return need(not (FOLDER / "out/x.png").exists(), "no file is left")


@task("other layers are kept", "render through.ron layers.exr -o kept.exr")
def _(out):
    kept, given = exr("kept.exr")[1], exr("layers.exr")[1]
    return need(np.array_equal(kept["Z"], given["Z"]) and "albedo" in kept, "OpenEXR: Z and albedo bit for bit")


@task("a layer as input", "render through.ron layers.exr#albedo -o layer.exr")
def _(out):
    depth = exr("layers.exr")[1]["Z"].astype(np.float16)
    return need(np.array_equal(exr("layer.exr")[1]["albedo"][..., 0], depth), "OpenEXR: the layer's numbers")


@task("overscan", "render through.ron overscan.exr -o over.exr --window data")
def _(out):
    header = exr("over.exr")[0]
    return need(list(header["dataWindow"][0]) == [-8, -4], "OpenEXR: both windows as they were")


@task("sRGB in and out", "render shown.ron codes.png -o again.png --no-dither")
def _(out):
    off = np.abs(codes("again.png") - codes("codes.png")).max()
    return need(off <= 1, f"Pillow: within {off} code")


@task("a photograph on its side", "render shown.ron held.jpg -o upright.png --no-dither")
def _(out):
    wanted = np.asarray(ImageOps.exif_transpose(Image.open(FOLDER / "held.jpg"))).astype(int)
    off = np.abs(codes("upright.png") - wanted).max()
    return need(off <= 3, f"Pillow: upright, within {off} codes")


@task("a Radiance environment", "render through.ron in.hdr -o hdr.exr --depth 32")
def _(out):
    off = np.abs(rgb("hdr.exr") - light()).max() / light().max()
    return need(off < 0.01, "OpenEXR: within RGBE's precision")


@task("SDR and HDR at once", "render hdr in.exr --output sdr=sdr.png --output hdr=pq.png")
def _(out):
    is_hdr = list(chunk("pq.png", "cICP")) == [9, 16, 0, 1] and chunk("pq.png", "mDCV") and chunk("pq.png", "cLLI")
    # In the middle of the ramp both show the same light: its luminance by PQ and by sRGB.
    nits = colour.models.eotf_ST2084(png("pq.png")[40, 48] / 65535) @ [0.2627, 0.678, 0.0593]
    shown = 203 * colour.models.eotf_sRGB(codes("sdr.png")[40, 48] / 255) @ [0.2126, 0.7152, 0.0722]
    return need(is_hdr and abs(nits / shown - 1) < 0.1, f"OpenCV, color-science: {nits:.0f} and {shown:.0f} cd/m2 at a pixel")


@task("a parameter", "render through.ron in.exr -o twice.exr --set lit.stops=1.0")
def _(out):
    return need(np.allclose(rgb("twice.exr"), 2 * rgb("light.exr"), rtol=1e-3), "OpenEXR: twice the light")


@task("a look-up table", "render lut.ron codes.png -o inverted.png --no-dither")
def _(out):
    off = np.abs(255 - codes("inverted.png") - codes("codes.png")).max()
    return need(off <= 1, f"Pillow: inverted, within {off} code")


@task("a kind of the show", "render posterized.ron codes.png -o few.png --no-dither --nodes kinds")
def _(out):
    return need(len(np.unique(codes("few.png"))) == 4, "Pillow: 4 codes")


@task("a wrong name", "check wrong.ron", 1)
def _(out):
    return need("wrong.ron:3" in out and "Exposure" in out, "line 3, and what is meant")


@task("and its correction", "check wrong.ron --fix")
def _(out):
    return need('"lit": Exposure(' in (FOLDER / "wrong.ron").read_text(), "the file has the right word")


@task("a drawing of the plan", "plan tsushima --format svg")
def _(out):
    return need(xml.fromstring(out).tag.endswith("svg"), "ElementTree: an SVG")


def main():
    make_images()
    make_files()
    (FOLDER / "out").mkdir()
    environment = {**os.environ, "AFTERIMAGE": PROGRAM}
    table = csv.writer(sys.stdout, lineterminator="\n")
    table.writerow(["number", "task", "command", "status", "last line", "an outside reader"])
    is_good = True
    for number, (what, command, status, shell, check) in enumerate(TASKS, 1):
        words = command if shell else [PROGRAM, *command.split()]
        done = subprocess.run(words, shell=shell, capture_output=True, text=True, cwd=FOLDER, env=environment)
        lines = (done.stdout + done.stderr).strip().splitlines()
        try:
            assert done.returncode == status, f"status {done.returncode}: {' / '.join(lines[-3:])}"
            said = check(done.stdout + done.stderr if status or shell or not done.stdout else done.stdout)
        except (AssertionError, KeyError, ValueError, OSError) as error:
            said, is_good = f"NO: {type(error).__name__} {error}", False
        shown = command if shell else f"afterimage {command}"
        table.writerow([number, what, shown, done.returncode, (lines or [""])[-1].strip()[:100], said])
    sys.exit(not is_good)


main()
