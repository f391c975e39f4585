#!/usr/bin/env python3
"""A blind trial: a pipeline beside three other operators at equal mean luminance. Optional: no test needs it.

    apt install pfstools; python3 -m venv v && v/bin/pip install opencolorio==2.6.0 numpy scipy openexr pillow opencv-python
    v/bin/python tests/color/trial.py sheets target/release/afterimage pipelines/tsushima.ron trial IMAGE...
    # Look at trial/*.png and write a line `NAME LETTER` for each image to a file. Then:
    v/bin/python tests/color/trial.py reveal trial choices.txt IMAGE...

The first command draws for each image the results of the pipeline, ACES 2.0 (OpenColorIO), `pfstmo_reinhard02 -s` and
`pfstmo_mantiuk08`, in random order, and keeps the order in trial/key.json. The second one compares the choices with it.
It prints for each operator the share of pixels above code 250, and the halo: at the scale of 1/64 of the width, the
codes by which luminance falls where that of the scene rises, exceeded by one pixel in a thousand.
"""

import json
import random
import subprocess
import sys
from pathlib import Path

import numpy as np

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
LETTERS = "ABCD"


def load(path):
    """Linear RGB of an EXR or HDR image, at most 1024 pixels wide; what is not finite becomes 0 or 65504."""
    if str(path).endswith(".hdr"):
        import cv2

        image = cv2.imread(str(path), -1)[..., ::-1].astype(float)
    else:
        import OpenEXR

        channels = OpenEXR.File(str(path)).channels()
        packed = next((name for name in ("RGB", "RGBA") if name in channels), None)
        planes = channels[packed].pixels[..., :3] if packed else np.stack([channels[c].pixels for c in "RGB"], 2)
        image = planes.astype(float)
    step = 2 if image.shape[1] > 1024 else 1
    return np.nan_to_num(image, nan=0, posinf=65504, neginf=0).clip(0, 65504)[::step, ::step]


def save(path, image):
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": np.ascontiguousarray(image.astype(np.float32))}).write(str(path))


def encode(light):
    light = light.clip(0, 1)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def decode(code):
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)


def mean(picture):
    return (decode(picture) @ LUMINANCE).mean()


def at_mean(operator, target, low, high):
    """The result of an operator at the exposure, in stops, that has the mean luminance `target`."""
    for _ in range(14):
        middle = (low + high) / 2
        low, high = (middle, high) if mean(operator(middle)) < target else (low, middle)
    return operator((low + high) / 2)


def aces2():
    import PyOpenColorIO as ocio

    config = ocio.Config.CreateFromBuiltinConfig("cg-config-v4.0.0_aces-v2.0_ocio-v2.5")
    display = next(name for name in config.getDisplays() if "sRGB" in name)
    view = next(name for name in config.getViews(display) if "SDR" in name and "709" in name)
    source = next(name for name in ("lin_rec709_srgb", "lin_rec709") if config.getColorSpace(name))
    processor = config.getProcessor(source, display, view, ocio.TRANSFORM_DIR_FORWARD).getDefaultCPUProcessor()

    def apply(light):
        pixels = np.ascontiguousarray(light.astype(np.float32))
        processor.applyRGB(pixels)
        return pixels.astype(float).clip(0, 1)

    return apply


def pfs(folder, image, *command):
    given, result = folder / "given.exr", folder / "result.exr"
    save(given, image)
    line = f"pfsinexr {given} | {' '.join(command)} | pfsoutexr {result}"
    subprocess.run(line, shell=True, check=True, stderr=subprocess.DEVNULL)
    return load(result).clip(0, 1)


def pictures(binary, pipeline, folder, image, transform):
    """The codes from 0 to 1 of every operator, all of the mean luminance that the pipeline gives."""
    from PIL import Image

    given, result = folder / "given.exr", folder / "result.png"
    save(given, image)
    subprocess.run([binary, "render", pipeline, given, "-o", result], check=True, stdout=subprocess.DEVNULL)
    own = np.asarray(Image.open(result).convert("RGB")) / 255
    exposed = image * 0.18 / np.exp(np.log(np.maximum(image @ LUMINANCE, 1e-6)).mean())
    target = mean(own)
    # The first of the two gives display-linear light, the second codes.
    reinhard = pfs(folder, exposed, "pfstmo_reinhard02", "-s")
    mantiuk = decode(pfs(folder, exposed, "pfstmo_mantiuk08"))
    return {
        "pipeline": own,
        "aces2": at_mean(lambda stops: transform(exposed * 2**stops), target, -8, 8),
        "reinhard02": at_mean(lambda stops: encode(reinhard * 2**stops), target, -6, 6),
        "mantiuk08": at_mean(lambda stops: encode(mantiuk * 2**stops), target, -6, 6),
    }


def sheets(binary, pipeline, folder, paths):
    from PIL import Image, ImageDraw

    folder, transform, key = Path(folder), aces2(), {}
    (folder / "work").mkdir(parents=True, exist_ok=True)
    for path in map(Path, paths):
        shown = pictures(binary, pipeline, folder / "work", load(path), transform)
        order = random.SystemRandom().sample(list(shown), len(shown))
        height, width, _ = shown["pipeline"].shape
        sheet = Image.new("RGB", (2 * width, 2 * height))
        for index, name in enumerate(order):
            corner = (index % 2 * width, index // 2 * height)
            sheet.paste(Image.fromarray((shown[name] * 255 + 0.5).astype(np.uint8)), corner)
            style = {"fill": "white", "stroke_width": 2, "stroke_fill": "black"}
            ImageDraw.Draw(sheet).text((corner[0] + 6, corner[1] + 3), LETTERS[index], **style)
        sheet.save(folder / f"{path.stem}.png")
        key[path.stem] = order
    (folder / "key.json").write_text(json.dumps(key))


def halo(codes, light):
    """Codes by which a result falls where the scene rises, at the scale of 1/64 of the width."""
    from scipy.ndimage import gaussian_filter

    sigma = codes.shape[1] / 64
    result = np.stack(np.gradient(gaussian_filter(codes, sigma)))
    scene = np.stack(np.gradient(gaussian_filter(np.log2(np.maximum(light, 1e-6)), sigma)))
    slope = np.sqrt((scene**2).sum(0))
    against = -(result * scene).sum(0) / np.maximum(slope, 1e-9) * sigma
    return np.quantile(np.where(slope * sigma > 0.25, against, 0).clip(0), 0.999)


def reveal(folder, choices, paths):
    from PIL import Image

    key = json.loads((Path(folder) / "key.json").read_text())
    chosen = dict(line.split() for line in Path(choices).read_text().splitlines())
    names, counts = ("pipeline", "aces2", "reinhard02", "mantiuk08"), {}
    print("| image | chosen |", " | ".join(f"{name}: above 250, halo" for name in names), "|")
    print("|---|---|" + "---|" * len(names))
    for path in map(Path, paths):
        order = key[path.stem]
        sheet = np.asarray(Image.open(Path(folder) / f"{path.stem}.png")).astype(float)
        height, width = sheet.shape[0] // 2, sheet.shape[1] // 2
        light, figures = load(path) @ LUMINANCE, {}
        for index, name in enumerate(order):
            top, left = index // 2 * height, index % 2 * width
            codes = sheet[top : top + height, left : left + width] @ LUMINANCE
            figures[name] = f"{100 * (codes > 250).mean():.2f} %, {halo(codes, light):.1f}"
        choice = order[LETTERS.index(chosen[path.stem])]
        counts[choice] = counts.get(choice, 0) + 1
        print(f"| {path.stem} | {choice} |", " | ".join(figures[name] for name in names), "|")
    print("\nchosen:", ", ".join(f"{name} {count}" for name, count in sorted(counts.items())))


if __name__ == "__main__":
    command, *rest = sys.argv[1:] or [""]
    if command == "sheets" and len(rest) > 3:
        sheets(*rest[:3], rest[3:])
    elif command == "reveal" and len(rest) > 2:
        reveal(*rest[:2], rest[2:])
    else:
        sys.exit(__doc__)
