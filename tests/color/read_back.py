"""Reads files of the program with other programs: right labels and right luminances.

Usage: python3 read_back.py PROGRAM

PROGRAM is the binary `afterimage`. Needs the packages OpenImageIO, OpenEXR, color-science and numpy. A row of gray
patches and one saturated red is encoded with each transfer function. Chunks of PNG come from a parser of this file,
pixels from OpenImageIO, attributes of EXR from OpenEXR, and curves and matrices from color-science. The last column is
the largest difference of a luminance, in per cent; the exit status is 1 if a label is wrong or a difference exceeds 0.5 %.
"""

import pathlib
import struct
import subprocess
import sys
import tempfile

import colour
import numpy as np
import OpenEXR
import OpenImageIO as oiio

WHITE = 203.0
PATCHES = np.array([0.01, 0.05, 0.18, 0.5, 0.9])
RED = np.array([0.5, 0.05, 0.05])
SPACES = {"Rec709": ("ITU-R BT.709", 1), "DisplayP3": ("Display P3", 12), "Rec2020": ("ITU-R BT.2020", 9)}
CASES = [
    ("Srgb", "Rec709"),
    ("Srgb", "DisplayP3"),
    ("Pq", "Rec2020"),
    ("Pq", "DisplayP3"),
    ("Hlg", "Rec2020"),
    ("Linear", "Rec709"),
    ("Linear", "Rec2020"),
    ("Gamma, gamma: 2.2", "Rec709"),
    ("Gamma, gamma: 2.4", "DisplayP3"),
]
CODES = {"Srgb": 13, "Pq": 16, "Hlg": 18, "Linear": 8, "Gamma, gamma: 2.2": 4}
# Both are display-linear: without a tone curve, 1 is SDR white.
PIPELINE = """Pipeline(inputs: {{ "scene": Color }}, nodes: {{
    "exposed": Exposure(source: "scene"),
    "mapped": ToneMap(source: "exposed", curve: None),
    "out": Encode(source: "mapped", transfer: {transfer}, primaries: {primaries}),
}}, outputs: {{ "light": "mapped", "out": "out" }})"""


def chunks(path):
    data, found = path.read_bytes()[8:], {}
    while len(data) >= 12:
        (length,) = struct.unpack(">I", data[:4])
        found.setdefault(data[4:8].decode(), data[8 : 8 + length])
        data = data[12 + length :]
    return found


def light(signal, transfer):
    """cd/m2 of gray signals."""
    if transfer == "Pq":
        return colour.models.eotf_ST2084(signal)
    if transfer == "Hlg":
        return colour.models.eotf_BT2100_HLG(signal, L_W=1000.0)
    if transfer == "Srgb":
        return WHITE * colour.models.eotf_sRGB(signal)
    gamma = 1.0 if transfer == "Linear" else float(transfer.split()[-1])
    return WHITE * signal**gamma


def label(found, transfer, primaries):
    """What is wrong with the chunks; empty if nothing is."""
    space, code = SPACES[primaries]
    wrong = []
    transfer_code = CODES.get(transfer)
    cicp = bytes([code, transfer_code, 0, 1]) if transfer_code else None
    if found.get("cICP") != cicp:
        wrong.append(f"cICP {found.get('cICP')}")
    hdr = transfer in ("Pq", "Hlg")
    if hdr and set(found) & {"gAMA", "cHRM", "sRGB", "iCCP"}:
        wrong.append("contradicting chunks")
    if hdr:
        peak = struct.unpack(">8H2I", found["mDCV"])[8] / 1e4
        if peak != 1000.0:
            wrong.append(f"peak {peak}")
        brightest = struct.unpack(">2I", found["cLLI"])[0] / 1e4
        if abs(brightest - 0.9 * WHITE) > 1.0:
            wrong.append(f"MaxCLL {brightest}")
    if "cHRM" in found:
        stated = np.array(struct.unpack(">8I", found["cHRM"])) / 1e5
        gamut = colour.RGB_COLOURSPACES[space]
        expected = np.concatenate([gamut.whitepoint, gamut.primaries.ravel()])
        if np.abs(stated - expected).max() > 1.5e-4:
            wrong.append(f"cHRM {stated}")
    if "gAMA" in found:
        gamma = {"Srgb": 2.2, "Linear": 1.0}.get(transfer) or float(transfer.split()[-1])
        if abs(1e5 / struct.unpack(">I", found["gAMA"])[0] - gamma) > 1e-3:
            wrong.append("gAMA")
    if "iCCP" in found and primaries == "Rec709":
        wrong.append("iCCP")
    return ", ".join(wrong)


def main(program):
    folder = pathlib.Path(tempfile.mkdtemp())
    row = np.concatenate([np.repeat(PATCHES[:, None], 3, axis=1), RED[None]]).astype(np.float32)[None]
    OpenEXR.File({}, {"RGB": np.ascontiguousarray(row)}).write(str(folder / "in.exr"))
    print("| output | labels | read by OpenImageIO as | largest difference of luminance |\n|---|---|---|---|")
    failed = False
    for transfer, primaries in CASES:
        (folder / "p.ron").write_text(PIPELINE.format(transfer=transfer, primaries=primaries))
        out = folder / "out.png"
        command = [program, "render", "p.ron", "in.exr", "-o", out.name, "--depth", "16", "--exact", "--output", "out"]
        subprocess.run(command, cwd=folder, check=True)
        found = chunks(out)
        wrong = label(found, transfer, primaries)
        image = oiio.ImageBuf(str(out))
        signal = np.asarray(image.get_pixels(oiio.FLOAT))[0, :, :3].astype(np.float64)
        nits = light(signal[: len(PATCHES), 0], transfer)
        difference = np.abs(nits / (PATCHES * WHITE) - 1.0).max() * 100.0
        rgb = colour.RGB_COLOURSPACES[SPACES[primaries][0]]
        if transfer != "Hlg":
            to709 = colour.matrix_RGB_to_RGB(rgb, colour.RGB_COLOURSPACES["ITU-R BT.709"], "Bradford")
            back = to709 @ light(signal[-1], transfer) / WHITE
            difference = max(difference, np.abs(back / RED - 1.0).max() * 100.0)
        failed |= bool(wrong) or difference > 0.5
        names = ", ".join(name for name in ("cICP", "sRGB", "gAMA", "cHRM", "iCCP", "mDCV", "cLLI") if name in found)
        seen = image.spec().get_string_attribute("oiio:ColorSpace") or "unknown"
        cicp = image.spec().getattribute("CICP")
        seen = f"{seen}, CICP {','.join(map(str, cicp))}" if cicp else seen
        print(f"| {transfer}, {primaries} | {wrong or 'right: ' + names} | {seen} | {difference:.3f} % |")
        failed |= not exr(program, folder, primaries)
    sys.exit(1 if failed else 0)


def exr(program, folder, primaries):
    """Whether the linear output, converted to the primaries, states them and holds the light."""
    command = [program, "render", "p.ron", "in.exr", "-o", "out.exr", "--depth", "32", "--output", "light"]
    subprocess.run([*command, "--output-space", primaries.removeprefix("Display")], cwd=folder, check=True)
    file = OpenEXR.File(str(folder / "out.exr"))
    header = file.header()
    stated = np.array(header["chromaticities"], dtype=float).ravel()
    gamut = colour.RGB_COLOURSPACES[SPACES[primaries][0]]
    expected = np.concatenate([gamut.primaries.ravel(), gamut.whitepoint])
    channels = file.channels()
    pixels = channels["RGB" if "RGB" in channels else "RGBA"].pixels[0, :, :3]
    back = colour.matrix_RGB_to_RGB(gamut, colour.RGB_COLOURSPACES["ITU-R BT.709"], "Bradford") @ pixels[-1]
    light = np.concatenate([pixels[: len(PATCHES), 0] / PATCHES, back / RED]) - 1.0
    right = np.abs(stated - expected).max() < 1.5e-4 and np.abs(light).max() < 2e-3
    white = header.get("whiteLuminance")
    verdict = "right" if right else f"wrong: {stated}, {light}"
    print(f"| EXR, {primaries} | {verdict}: chromaticities{f', whiteLuminance {white}' if white else ''} |"
          f" | {np.abs(light).max() * 100:.3f} % |")
    return right


if __name__ == "__main__":
    main(str(pathlib.Path(sys.argv[1]).resolve()))
