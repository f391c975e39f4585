#!/usr/bin/env python3
"""Compares operators, run by the program, with outside implementations, and prints a table. Optional: no test needs it.

    python3 -m venv v
    v/bin/pip install colour-science==0.4.7 opencolorio==2.6.0 scipy numpy openexr opencv-python-headless
    cargo build --release
    v/bin/python tests/color/operators.py target/release/afterimage

Differences are absolute up to 1 and relative above it, unless a row says otherwise. Signals are read from PNG files of
16 bits, whose rounding alone makes 7.6e-6. tests/color/aces2.py and tests/color/compare_ocio.py compare ACES 2.0 and
the steps of color files.
"""

import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

warnings.filterwarnings("ignore")

import colour
import cv2
import numpy as np
import OpenEXR
import PyOpenColorIO as ocio
import scipy.ndimage

SIDE = 128
random = np.random.default_rng(11)
FOLDER = Path(tempfile.mkdtemp())
PROGRAM = ""


def unit():
    """Colors from 0 to 1."""
    return random.uniform(0, 1, (SIDE * SIDE, 3)).astype(np.float32).astype(float)


def light(low=-9, high=7):
    """Colors of any saturation, from 2^low to 2^high per channel."""
    return (2.0 ** random.uniform(low, high, (SIDE * SIDE, 3))).astype(np.float32).astype(float)


def signed():
    """Colors in and outside of Rec.709, with a luminance of at least 0.05."""
    colors = random.uniform(-0.3, 1, (8 * SIDE * SIDE, 3)) * 2.0 ** random.uniform(-2, 4, (8 * SIDE * SIDE, 1))
    colors = colors[colors @ [0.2126, 0.7152, 0.0722] > 0.05]
    return colors[: SIDE * SIDE].astype(np.float32).astype(float)


def grays():
    """Grays of 16 stops."""
    return np.repeat((0.18 * 2.0 ** np.linspace(-8, 8, SIDE * SIDE))[:, None], 3, 1).astype(np.float32).astype(float)


def run(state, node, pixels, *options, suffix=".exr"):
    """The result of a node, in 32 bits, or from a PNG file of 16 bits."""
    source, result, pipeline = FOLDER / "in.exr", FOLDER / f"out{suffix}", FOLDER / "pipeline.ron"
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"RGB": pixels.reshape(SIDE, SIDE, 3).astype(np.float32)}) as file:
        file.write(str(source))
    kind, parameters = node.removesuffix(")").split("(", 1)
    pipeline.write_text(
        f'Pipeline(inputs: {{ "in": {state} }}, nodes: {{ "result": {kind}(source: "in", format: Rgba32Float, '
        f'{parameters}) }}, outputs: {{ "out": "result" }})'
    )
    options = options or (("--depth", "32") if suffix == ".exr" else ("--depth", "16", "--no-dither"))
    command = [PROGRAM, "render", pipeline, source, "-o", result, *options]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{node}: {done.stderr}")
    if suffix == ".png":
        return cv2.imread(str(result), cv2.IMREAD_UNCHANGED)[..., 2::-1].reshape(-1, 3) / 65535
    with OpenEXR.File(str(result)) as file:
        channels = file.channels()
        return channels["RGBA" if "RGBA" in channels else "RGB"].pixels[..., :3].reshape(-1, 3).astype(float)


def space(name):
    found = colour.RGB_COLOURSPACES[name].copy()
    found.use_derived_transformation_matrices(True)
    return found


REC709 = space("ITU-R BT.709")


def conversion(target, adaptation="Bradford"):
    """Linear Rec.709 to another space."""
    return colour.matrix_RGB_to_RGB(REC709, space(target), adaptation).T


def through_ocio(pixels, *transforms):
    """What OpenColorIO makes of numbers, in 32 bits without optimizations."""
    processor = ocio.Config.CreateRaw().getProcessor(ocio.GroupTransform(list(transforms)))
    cpu = processor.getOptimizedCPUProcessor(ocio.BIT_DEPTH_F32, ocio.BIT_DEPTH_F32, ocio.OPTIMIZATION_NONE)
    pixels = np.ascontiguousarray(pixels, dtype=np.float32).reshape(1, -1, 3)
    cpu.apply(ocio.PackedImageDesc(pixels, pixels.shape[1], 1, 3))
    return pixels[0].astype(float)


def display(name, pixels):
    """An output transform of ACES to XYZ: its luminance."""
    ap0 = pixels @ conversion("ACES2065-1")
    return through_ocio(ap0, ocio.BuiltinTransform(f"ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - {name}"))[:, 1]


def off(found, wanted):
    return (np.abs(found - wanted) / np.maximum(1, np.abs(wanted))).max()


def transfer_functions():
    c = colour.models
    wide = conversion("ITU-R BT.2020")
    cases = [
        ("Srgb", "", 1.0, "sRGB", lambda v: c.eotf_inverse_sRGB(v)),
        ("Gamma", "gamma: 2.4", 1.0, "BT.1886", lambda v: c.eotf_inverse_BT1886(v, L_B=0, L_W=1)),
        ("Pq", "primaries: Rec2020", 4.9, "ST 2084", lambda v: c.eotf_inverse_ST2084(203 * (v @ wide))),
        ("Hlg", "primaries: Rec2020", 4.9, "BT.2100", lambda v: c.eotf_inverse_BT2100_HLG(203 * (v @ wide), L_W=1000)),
    ]
    for name, rest, top, what, reference in cases:
        pixels = (top * unit()).astype(np.float32).astype(float)
        found = run("DisplayLinear", f"Encode(transfer: {name}, gamut: Clip, {rest})", pixels, suffix=".png")
        yield f"`Encode(transfer: {name})`", f"color-science, {what}", off(found, np.clip(reference(pixels), 0, 1))


def primaries():
    for name, target in [("DisplayP3", "Display P3"), ("Rec2020", "ITU-R BT.2020")]:
        pixels = unit()
        found = run("DisplayLinear", f"Encode(transfer: Linear, primaries: {name})", pixels, suffix=".png")
        yield f"`Encode(primaries: {name})`", "color-science", off(found, pixels @ conversion(target))


def white_balance():
    to_xyz = REC709.matrix_RGB_to_XYZ
    d65 = colour.xy_to_XYZ([0.3127, 0.3290])
    for cones in ("Bradford", "Cat16"):
        largest = 0
        for kelvin in (2000, 2856, 5000, 9000, 20000):
            locus = colour.temperature.CCT_to_xy_CIE_D if kelvin > 4000 else colour.temperature.CCT_to_xy_Kang2002
            white = colour.xy_to_XYZ(locus(kelvin))
            model = cones.replace("Cat", "CAT")
            adapt = colour.adaptation.matrix_chromatic_adaptation_VonKries(white, d65, transform=model)
            pixels = light(-9, 3)
            node = f"WhiteBalance(mode: Temperature, temperature: {kelvin}.0, adaptation: {cones})"
            matrix = np.linalg.inv(to_xyz) @ adapt @ to_xyz
            largest = max(largest, off(run("Color", node, pixels), pixels @ matrix.T))
        operator = f"`WhiteBalance(adaptation: {cones})`, 2000 to 20000 K"
        yield operator, "color-science: D illuminants, Kang 2002", largest


def decisions(**values):
    transform = ocio.CDLTransform(**values)
    transform.setStyle(ocio.CDL_NO_CLAMP)
    return transform


def color_decisions():
    pixels = light(-9, 2)
    sop = dict(slope=[1.1, 0.9, 1.3], offset=[0.05, 0.1, 0.02], power=[1.2, 0.8, 2.0])
    parameters = ", ".join(f"{key}: ({', '.join(map(str, value))})" for key, value in sop.items())
    found = run("DisplayLinear", f"Cdl({parameters}, saturation: 1.3)", pixels)
    wanted = through_ocio(pixels, decisions(sat=1.3, **sop))
    yield "`Cdl`", "OpenColorIO, `CDL_NO_CLAMP`", off(found, wanted)
    found = run("Exposed", "Saturation(amount: 1.5)", pixels)
    wanted = through_ocio(pixels, decisions(sat=1.5))
    yield "`Saturation`", "OpenColorIO, `CDL_NO_CLAMP`", off(found, wanted)


def cube_file(size, entries):
    path = FOLDER / "look.cube"
    path.write_text(f"LUT_3D_SIZE {size}\n" + "\n".join(" ".join(f"{x:.7f}" for x in entry) for entry in entries))
    return path


def tables():
    path = cube_file(17, random.uniform(0, 1, (17**3, 3)))
    for name, interpolation in [("Tetrahedral", ocio.INTERP_TETRAHEDRAL), ("Trilinear", ocio.INTERP_LINEAR)]:
        pixels = unit()
        found = run("Encoded", f'ColorLut(file: "{path}", interpolation: {name})', pixels, suffix=".png")
        wanted = through_ocio(pixels, ocio.FileTransform(str(path), interpolation=interpolation))
        yield f"`ColorLut`, `.cube`, `{name}`", "OpenColorIO", off(found, wanted)


def spaces():
    steps = np.linspace(0, 1, 2)
    path = cube_file(2, [(r, g, b) for b in steps for g in steps for r in steps])
    c = colour.models
    cases = [
        ("AcesCct", "ACEScct", lambda v: c.log_encoding_ACEScct(v)),
        ("LogC3", "ARRI Wide Gamut 3", lambda v: c.log_encoding_ARRILogC3(v, EI=800)),
    ]
    for name, gamut, curve in cases:
        pixels = light(-9, 5)
        found = run("Exposed", f'ColorLut(file: "{path}", from: {name}, to: LinearRec709)', pixels)
        wanted = np.clip(curve(pixels @ conversion(gamut)), 0, 1)
        yield f"`ColorLut(from: {name})`", "color-science", off(found, wanted)


def gamuts():
    pixels = signed()
    ap0 = conversion("ACES2065-1")
    compress = ocio.BuiltinTransform("ACES-LMT - ACES 1.3 Reference Gamut Compression")
    wanted = through_ocio(pixels @ ap0, compress) @ np.linalg.inv(ap0)
    yield "`ReferenceGamutCompress`", "OpenColorIO", off(run("Exposed", "ReferenceGamutCompress()", pixels), wanted)


def oklab(pixels):
    lab = colour.XYZ_to_Oklab(pixels @ REC709.matrix_RGB_to_XYZ.T)
    return lab[:, 0], lab[:, 1] + 1j * lab[:, 2]


def jzazbz(nits):
    """az + i bz of cd/m2."""
    jab = colour.XYZ_to_Jzazbz(nits @ REC709.matrix_RGB_to_XYZ.T)
    return jab[:, 1] + 1j * jab[:, 2]


def hues():
    pixels = light(-6, 1)
    pixels = np.resize(pixels[oklab(pixels)[0] < 0.95], (SIDE * SIDE, 3))
    found = run("Exposed", "ToneMap(curve: None)", pixels)
    wanted_c, found_c = oklab(pixels)[1], oklab(found)[1]
    colored = np.abs(found_c) > 0.02
    turn = np.abs(np.angle(found_c / wanted_c, deg=True))[colored].max()
    yield "`ToneMap(gamut: Compress)`: hue of Oklab, in degrees", "color-science", turn


def tone_curves():
    plain = "middle_gray: Native, keep_hue: 0.0, gamut: Clip"
    pixels = grays()
    found = run("Exposed", f"ToneMap(curve: Aces2ToneScale, {plain})", pixels)[:, 1]
    wanted = display("SDR-100nit-REC709_2.0", pixels)
    yield "`ToneMap(curve: Aces2ToneScale)`, grays", "OpenColorIO, ACES 2.0", off(found, wanted)
    video = display("SDR-VIDEO_1.0", pixels)
    found = run("Exposed", f"ToneMap(curve: AcesHill, {plain})", pixels)[:, 1]
    yield "`ToneMap(curve: AcesHill)`, grays: a fit", "OpenColorIO, ACES 1.0", off(found, video)
    found = run("Exposed", f"ToneMap(curve: AcesNarkowicz, {plain})", 0.6 * pixels)[:, 1]
    yield "`ToneMap(curve: AcesNarkowicz)`, grays times 0.6: a fit", "OpenColorIO, ACES 1.0", off(found, video)


def eetf():
    """The formula of ITU-R BT.2390, 5.4.1, written once more; PQ is that of color-science."""
    encode, decode = colour.models.eotf_inverse_ST2084, colour.models.eotf_ST2084
    pixels = (1000 / 203 * np.repeat(unit()[:, :1], 3, 1)).astype(np.float32).astype(float)
    for peak, black in [(600, 0.0), (300, 0.1)]:
        top, bottom, span = encode(peak) / encode(1000), encode(black) / encode(1000), encode(1000)
        knee = 1.5 * top - 0.5
        e = encode(203 * pixels) / span
        t = (e - knee) / (1 - knee)
        spline = (2 * t**3 - 3 * t**2 + 1) * knee + (t**3 - 2 * t**2 + t) * (1 - knee) + (-2 * t**3 + 3 * t**2) * top
        bent = np.where(e < knee, e, spline)
        # The node also limits the lifted light to the peak.
        wanted = decode(np.minimum(bent + bottom * (1 - bent) ** 4, top) * span) / 203
        node = f"Eetf(source_nits: 1000.0, peak_nits: {peak}.0, black_nits: {black}, on: Extremes)"
        what = "formula of BT.2390, PQ of color-science"
        yield f"`Eetf`, grays, {peak} cd/m2, black {black}", what, off(run("DisplayLinear", node, pixels), wanted)
    pixels = (1000 / 203 * unit() ** 2).astype(np.float32).astype(float)
    found = run("DisplayLinear", "Eetf(source_nits: 1000.0, peak_nits: 203.0, on: Extremes)", pixels)
    wanted_c, found_c = jzazbz(203 * pixels), jzazbz(203 * found)
    turn = np.abs(np.angle(found_c / wanted_c, deg=True))[np.abs(found_c) > 0.02].max()
    yield "`Eetf(on: Extremes)`: hue of JzAzBz, in degrees", "color-science", turn


def blur():
    pixels = light(-4, 4)
    rows = pixels.reshape(SIDE, SIDE, 3)
    for sigma in (1.5, 5.0):
        wanted = scipy.ndimage.gaussian_filter(rows, (sigma, sigma, 0), mode="nearest", radius=int(np.ceil(4 * sigma)))
        found = run("Color", f"Gaussian(sigma: {sigma}, reach: 4.0)", pixels)
        yield f"`Gaussian(sigma: {sigma})`", "SciPy", off(found, wanted.reshape(-1, 3))


GROUPS = [
    transfer_functions, primaries, white_balance, color_decisions, tables, spaces, gamuts, hues, tone_curves, eetf,
    blur,
]

if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    PROGRAM = str(Path(sys.argv[1]).resolve())
    print("| operator | reference | largest difference |\n|---|---|---|")
    for group in GROUPS:
        for operator, reference, difference in group():
            print(f"| {operator} | {reference} | {difference:.1e} |", flush=True)
