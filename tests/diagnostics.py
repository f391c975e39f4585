#!/usr/bin/env python3
"""Ninety wrong inputs of all kinds, and what the program says of each, for people to grade. Optional: no test needs it.

    python3 -m venv v && v/bin/pip install numpy openexr pillow
    cargo build --release
    v/bin/python tests/diagnostics.py target/release/afterimage

graph/docs/measurements/diagnostics.csv has the grades: a point each for where, what and why, how to mend it, no second
error that follows from the first, and plain words with a right suggestion.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image

PROGRAM = str(Path(sys.argv[1]).resolve())

BASE = """Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "exposed": Exposure(source: "scene", stops: 0.5),
        "bright": Extract(source: "exposed", threshold: 1.0),
        "mips": Downsample(source: "bright", levels: 5),
        "bloom": Upsample(source: "mips", radius: 0.85),
        "lit": Composite(base: "exposed", bloom: "bloom", strength: 0.15),
        "mapped": ToneMap(source: "lit", curve: AcesNarkowicz),
        "display": Encode(source: "mapped", transfer: Srgb),
    },
    outputs: { "display": "display" },
    tiers: { "low": { "mips.levels": 3 } },
)
"""

# What is replaced in the pipeline, and by what.
DOCUMENTS = [
    ("Exposure(", "exposure("),
    ("Exposure(", "AutoExpose("),
    ("ToneMap(", "ToneMapping("),
    ('stops: 0.5', 'ev: 0.5'),
    ('stops: 0.5', 'stops: "0.5"'),
    ('stops: 0.5', 'stops: 0,5'),
    ('stops: 0.5', 'stops: 1/2'),
    ('stops: 0.5', 'stops: 500.0'),
    ('levels: 5', 'levels: 5.0'),
    ('levels: 5', 'levels: -1'),
    ('curve: AcesNarkowicz', 'curve: "AcesNarkowicz"'),
    ('curve: AcesNarkowicz', 'curve: ACES'),
    ('curve: AcesNarkowicz', 'curve: Filmic'),
    ('transfer: Srgb', 'transfer: sRGB'),
    ('source: "bright"', 'source: bright'),
    ('source: "bright"', 'source: "brigth"'),
    ('source: "bright"', 'input: "bright"'),
    ('source: "bright", ', ''),
    ('source: "lit"', 'source: "lit.rgb"'),
    ('source: "lit"', 'source: "display"'),
    ('source: "lit"', 'source: "exposed@last"'),
    ('source: "mapped"', 'source: "lit"'),
    ('bloom: "bloom"', 'bloom: "mips"'),
    ('bloom: "bloom"', 'bloom: "scene"'),
    ('bloom: "bloom"', 'bloom: 0.5'),
    ('"bloom": Upsample', '"mips": Upsample'),
    ('"bloom": Upsample', 'bloom: Upsample'),
    ('"scene": Color', '"scene": Colour'),
    ('"scene": Color', '"scene": Image'),
    ('"scene": Color', '"scene": "Color"'),
    ('outputs: { "display": "display" }', 'outputs: { "display" }'),
    ('outputs: { "display": "display" }', 'outputs: ["display"]'),
    ('outputs: { "display": "display" }', 'outputs: { "display": "dispaly" }'),
    ('outputs: { "display": "display" },', ''),
    ('"mips.levels": 3', '"mip.levels": 3'),
    ('"mips.levels": 3', '"levels": 3'),
    ('"mips.levels": 3', 'mips.levels: 3'),
    ('strength: 0.15),', 'strength: 0.15, when: "bloom_on == true"),'),
    ('strength: 0.15),', 'strength: 0.15, format: RGBA16F),'),
    ('strength: 0.15),', 'strength: 0.15, scale: 0.5),'),
    ('strength: 0.15),', 'strength: 0.15,'),
    ('Pipeline(', 'Graph('),
    ('Pipeline(', '{'),
]

SHADER = """struct Posterize { levels: f32 }

fn posterize(source: vec4f, params: Posterize) -> vec4f {
    let steps = params.levels - 1.0;
    return vec4f(round(source.rgb * steps) / steps, source.a);
}
"""
KIND = """Kind(
    name: "Posterize",
    doc: "Few levels.",
    inputs: { "source": Image(doc: "An image.", accepts: [DisplayLinear]) },
    outputs: { "result": Image(doc: "The result.", state: Same("source")) },
    parameters: { "levels": Float(doc: "Levels.", default: 4.0, within: (2.0, 256.0)) },
)
"""

SHADERS = [
    ("source.a);", "source.a)"),
    ("source.rgb", "source.rgbx"),
    ("source.rgb * steps", "source * steps"),
    ("params.levels", "params.level"),
    ("struct Posterize { levels: f32 }", "struct Posterize { steps: f32 }"),
    ("fn posterize(", "fn main("),
    ("source: vec4f,", "image: vec4f,"),
    ("source: vec4f,", "source: vec3f,"),
    ("-> vec4f", "-> vec3f"),
    ("let steps =", "float steps ="),
    ("let steps = params.levels - 1.0;", "let steps = params.levels - 1;\n    let x: i32 = 2.5;"),
    ("struct Posterize", "@group(0) @binding(0) var image: texture_2d<f32>;\nstruct Posterize"),
    ("struct Posterize", "import afterimage::colour::luminance;\nstruct Posterize"),
    ("round(", "lerp("),
]
DECLARATIONS = [
    ("accepts: [DisplayLinear]", "accepts: [Linear]"),
    ("default: 4.0", "default: 1.0"),
    ('"levels": Float(', '"Levels": Float('),
    ('name: "Posterize"', 'name: "posterize"'),
    ('    doc: "Few levels.",\n', ""),
]

# Command lines.
LINES = [
    "rendr look.ron in.exr -o out.png",
    "look.ron in.exr -o out.png",
    "render look.ron in.exr",
    "render look.ron -o out.png",
    "render lok.ron in.exr -o out.png",
    "render tsushma in.exr -o out.png",
    "render look.ron missing.exr -o out.png",
    "render look.ron in.exr -o out.tiff",
    "render look.ron in.exr -o out.exr",
    "render look.ron in.exr -o missing/out.png",
    "render look.ron in.exr -o out.png --set exposed.stop=1",
    "render look.ron in.exr -o out.png --set exposed.stops=bright",
    "render look.ron in.exr -o out.png --tier medium",
    "render look.ron in.exr -o out.png --frames 10-1",
    "render look.ron in.exr -o out.png --input normals=in.exr",
    "render look.ron in.exr -o out.png --depth 12",
    "plan look.ron --size 1920",
    "nodes Blooom",
]
# Files.
FILES = [
    "render look.ron empty.exr -o out.png",
    "render look.ron text.exr -o out.png",
    "render look.ron short.png -o out.png",
    "render look.ron in.tif -o out.png",
    "render look.ron layers.exr#albdo -o out.png",
    "render look.ron folder -o out.png",
    "render lut.ron in.exr -o out.png",
    "render nolut.ron in.exr -o out.png",
    "check latin.ron",
    "check empty.ron",
]


def make_files(folder):
    pixels = np.full((8, 12, 3), 0.5, np.float32)
    for name, channels in [("in.exr", {"RGB": pixels}), ("layers.exr", {"RGB": pixels, "albedo.R": pixels[..., 0].copy(),
                           "albedo.G": pixels[..., 0].copy(), "albedo.B": pixels[..., 0].copy()})]:
        with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, channels) as file:
            file.write(str(folder / name))
    gray = Image.fromarray(np.uint8(pixels * 255))
    gray.save(folder / "in.tif")
    gray.save(folder / "whole.png")
    (folder / "short.png").write_bytes((folder / "whole.png").read_bytes()[:60])
    (folder / "empty.exr").write_bytes(b"")
    (folder / "text.exr").write_text("a note\n")
    (folder / "folder").mkdir()
    (folder / "look.ron").write_text(BASE)
    last = '"graded": ColorLut(source: "display", file: "look.cube"), },\n    outputs: { "display": "graded" },'
    graded = BASE.replace('},\n    outputs: { "display": "display" },', last)
    (folder / "lut.ron").write_text(graded)
    (folder / "nolut.ron").write_text(graded.replace("look.cube", "lok.cube"))
    (folder / "look.cube").write_text("LUT_3D_SIZE 2\n" + "0 0 0\n" * 7)
    (folder / "latin.ron").write_bytes(BASE.replace("scene", "scène").encode("latin-1"))
    (folder / "empty.ron").write_text("")


def kind_folder(folder, declaration, shader):
    kind = folder / "kinds" / "posterize"
    kind.mkdir(parents=True, exist_ok=True)
    (kind / "node.ron").write_text(declaration)
    (kind / "posterize.wgsl").write_text(shader)
    few = '"few": Posterize(source: "mapped", levels: 4.0),\n        "display": Encode(source: "few"'
    (folder / "few.ron").write_text(BASE.replace('"display": Encode(source: "mapped"', few))


def main():
    number = 0
    for kind, cases in [("document", DOCUMENTS), ("shader", SHADERS), ("declaration", DECLARATIONS),
                        ("command line", LINES), ("file", FILES)]:
        for case in cases:
            number += 1
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                make_files(folder)
                if kind == "document":
                    assert case[0] in BASE, case
                    (folder / "look.ron").write_text(BASE.replace(*case, 1))
                    words, shown = ["check", "look.ron"], f"{case[0]} -> {case[1]}"
                elif kind in ("shader", "declaration"):
                    text = SHADER if kind == "shader" else KIND
                    assert case[0] in text, case
                    changed = text.replace(*case, 1)
                    kind_folder(folder, *((KIND, changed) if kind == "shader" else (changed, SHADER)))
                    words, shown = ["check", "few.ron", "--nodes", "kinds", "--plan"], f"{case[0]} -> {case[1]}"
                else:
                    words, shown = case.split(), case
                done = subprocess.run([PROGRAM, *words], capture_output=True, text=True, cwd=folder)
                print(f"=== {number} {kind}: {shown!r}: status {done.returncode}\n{(done.stdout + done.stderr).strip()}\n")


main()
