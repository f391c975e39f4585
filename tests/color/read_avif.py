#!/usr/bin/env python3
"""Reads AVIF files of the program with FFmpeg: right labels, ten bits and right luminances. Optional: no test needs it.

    python3 -m venv v && v/bin/pip install av colour-science numpy openexr
    cargo build --release --features avif
    v/bin/python tests/color/read_avif.py target/release/afterimage

Gray patches of 32 pixels are encoded with each transfer function. FFmpeg (PyAV) reads the code points of H.273 and
decodes the luma, which is that of a gray signal. The last column is the largest difference of a luminance, in per cent:
it includes AV1 at the highest quality and the rounding to ten bits, 1.9 % of the darkest linear patch. The exit status
is 1 if a label is wrong or a difference exceeds 3 %.
"""

import pathlib
import subprocess
import sys
import tempfile
import warnings

warnings.filterwarnings("ignore")

import av
import colour
import numpy as np
import OpenEXR

WHITE = 203.0
PATCHES = np.array([0.05, 0.1, 0.18, 0.5, 0.9])
SIDE = 32
PRIMARIES = {"Rec709": 1, "DisplayP3": 12, "Rec2020": 9}
TRANSFERS = {"Srgb": 13, "Linear": 8, "Pq": 16, "Hlg": 18}
PIPELINE = """Pipeline(inputs: {{ "light": DisplayLinear }}, nodes: {{
    "out": Encode(source: "light", transfer: {transfer}, primaries: {primaries}),
}}, outputs: {{ "out": "out" }})"""


def light(signal, transfer):
    """cd/m2 of gray signals."""
    decode = {
        "Srgb": lambda v: WHITE * colour.models.eotf_sRGB(v),
        "Linear": lambda v: WHITE * v,
        "Pq": colour.models.eotf_ST2084,
        "Hlg": lambda v: colour.models.eotf_BT2100_HLG(v, L_W=1000.0),
    }
    return decode[transfer](signal)


def main(program):
    folder = pathlib.Path(tempfile.mkdtemp())
    row = np.repeat(np.repeat(PATCHES, SIDE)[None, :, None], 3, axis=2).astype(np.float32)
    OpenEXR.File({}, {"RGB": np.repeat(row, SIDE, axis=0)}).write(str(folder / "in.exr"))
    print("| output | primaries, transfer, matrix, range | format | largest difference of luminance |")
    print("|---|---|---|---|")
    failed = False
    for transfer, code in TRANSFERS.items():
        for primaries, primaries_code in PRIMARIES.items():
            (folder / "p.ron").write_text(PIPELINE.format(transfer=transfer, primaries=primaries))
            command = [program, "render", "p.ron", "in.exr", "-o", "out.avif", "--quality", "100"]
            subprocess.run(command, cwd=folder, check=True, capture_output=True)
            with av.open(str(folder / "out.avif")) as file:
                stream = file.streams.video[0]
                frame = next(file.decode(stream))
                context = stream.codec_context
                stated = context.color_primaries, context.color_trc, context.colorspace, context.color_range
                labels = [int(code) for code in stated]
                plane = frame.planes[0]
                rows = np.frombuffer(plane, "<u2").reshape(-1, plane.line_size // 2)[:, : frame.width]
                luma = rows if frame.format.name == "yuv444p10le" else None
            wanted = [primaries_code, code, 9 if primaries == "Rec2020" else 1, 2]
            if luma is None or labels != wanted:
                failed = True
                print(f"| {transfer}, {primaries} | wrong: {labels}, not {wanted} | {frame.format.name} | |")
                continue
            centers = luma[SIDE // 2, SIDE // 2 :: SIDE].astype(float) / 1023
            off = np.abs(light(centers, transfer) / (PATCHES * WHITE) - 1).max() * 100
            failed |= off > 3
            print(f"| {transfer}, {primaries} | {','.join(map(str, labels))} | {frame.format.name} | {off:.2f} % |")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(str(pathlib.Path(sys.argv[1]).resolve()))
