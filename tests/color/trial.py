#!/usr/bin/env python3
"""A blind trial: a pipeline beside five other operators at equal mean luminance. Optional: no test needs it.

    apt install pfstools; python3 -m venv v && v/bin/pip install opencolorio numpy scipy openexr pillow opencv-python-headless
    v/bin/python tests/color/trial.py views trial/views SEED PANORAMA...
    v/bin/python tests/color/trial.py sheets target/release/afterimage pipelines/tsushima.ron trial trial/views/*.exr
    # Look at trial/*.png and write a line `NAME LETTERS`, the best two in order, for each to a file. Then:
    v/bin/python tests/color/trial.py reveal trial choices.txt trial/views/*.exr

`views` looks into each panorama in a direction that the seed gives, through a lens of 75 degrees. `sheets` draws for each
image the results of the pipeline, ACES 2.0 (OpenColorIO), AgX, Khronos Neutral, `pfstmo_reinhard02 -s` and
`pfstmo_mantiuk08`, in random order, and keeps the order in trial/key.json. `reveal` compares the choices with it. It
prints for each operator how often it was first and second, the share of pixels above code 250, and the halo: at the scale
of 1/64 of the width, the codes by which luminance falls where that of the scene rises, exceeded by one pixel in a
thousand.
"""

import json
import random
import subprocess
import sys
from pathlib import Path

import numpy as np

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
LETTERS = "ABCDEF"
NAMES = ("pipeline", "aces2", "agx", "neutral", "reinhard02", "mantiuk08")
COLUMNS = 2


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


def agx(light):
    """The AgX of Troy Sobotka, by the matrices and the polynomial that three.js has of it."""
    to_rec2020 = np.array([[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0113], [0.0164, 0.0880, 0.8956]])
    inset = np.array(
        [[0.856627153315983, 0.0951212405381588, 0.0482516061458583],
         [0.137318972929847, 0.761241990602591, 0.101439036467562],
         [0.11189821299995, 0.0767994186031903, 0.811302368396859]]
    )
    outset = np.array(
        [[1.1271005818144368, -0.11060664309660323, -0.016493938717834573],
         [-0.1413297634984383, 1.157823702216272, -0.016493938717834257],
         [-0.14132976349843826, -0.11060664309660294, 1.2519364065950405]]
    )
    low, high = -12.47393, 4.026069
    x = (np.log2(np.maximum(light @ to_rec2020.T @ inset.T, 1e-10)).clip(low, high) - low) / (high - low)
    curve = ((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x * x + 0.1191 * x - 0.00232
    linear = np.maximum(curve @ outset.T, 0) ** 2.2
    return encode((linear @ np.linalg.inv(to_rec2020).T).clip(0, 1))


def neutral(light):
    """The Khronos PBR Neutral tone mapper, from its specification."""
    darkest = light.min(-1, keepdims=True)
    color = light - np.where(darkest < 0.08, darkest - 6.25 * darkest**2, 0.04)
    peak, start = color.max(-1, keepdims=True), 0.8 - 0.04
    distance = 1 - start
    new = 1 - distance**2 / (peak + distance - start)
    share = 1 - 1 / (0.15 * (peak - new) + 1)
    mapped = color * new / np.maximum(peak, 1e-9) * (1 - share) + new * share
    return encode(np.where(peak < start, color, mapped).clip(0, 1))


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
        "agx": at_mean(lambda stops: agx(exposed * 2**stops), target, -8, 8),
        "neutral": at_mean(lambda stops: neutral(exposed * 2**stops), target, -8, 8),
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
        sheet = Image.new("RGB", (COLUMNS * width, len(order) // COLUMNS * height))
        for index, name in enumerate(order):
            corner = (index % COLUMNS * width, index // COLUMNS * height)
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
    counts = {name: [0, 0] for name in NAMES}
    print("| image | first, second |", " | ".join(f"{name}: above 250, halo" for name in NAMES), "|")
    print("|---|---|" + "---|" * len(NAMES))
    for path in map(Path, paths):
        order = key[path.stem]
        sheet = np.asarray(Image.open(Path(folder) / f"{path.stem}.png")).astype(float)
        height, width = COLUMNS * sheet.shape[0] // len(order), sheet.shape[1] // COLUMNS
        light, figures = load(path) @ LUMINANCE, {}
        for index, name in enumerate(order):
            top, left = index // COLUMNS * height, index % COLUMNS * width
            codes = sheet[top : top + height, left : left + width] @ LUMINANCE
            figures[name] = f"{100 * (codes > 250).mean():.2f} %, {halo(codes, light):.1f}"
        best = [order[LETTERS.index(letter)] for letter in chosen[path.stem]]
        for place, name in enumerate(best):
            counts[name][place] += 1
        print(f"| {path.stem} | {', '.join(best)} |", " | ".join(figures[name] for name in NAMES), "|")
    print("\nfirst, second:", ", ".join(f"{name} {first}, {second}" for name, (first, second) in counts.items()))


def views(folder, seed, paths):
    """A perspective view into each panorama, 800x450, as EXR."""
    from scipy.ndimage import map_coordinates

    Path(folder).mkdir(parents=True, exist_ok=True)
    choice = random.Random(seed)
    for path in map(Path, paths):
        image = load(path)
        turn, pitch = choice.uniform(0, 2 * np.pi), np.radians(choice.uniform(-10, 5))
        x, y = np.meshgrid(np.linspace(-1, 1, 800), np.linspace(-1, 1, 450) * 450 / 800)
        ray = np.stack([x, -y, np.full_like(x, 1 / np.tan(np.radians(75 / 2)))], -1)
        ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
        up = ray[..., 1] * np.cos(pitch) + ray[..., 2] * np.sin(pitch)
        ahead = ray[..., 2] * np.cos(pitch) - ray[..., 1] * np.sin(pitch)
        column = ((np.arctan2(ray[..., 0], ahead) + turn) / (2 * np.pi) % 1) * image.shape[1] - 0.5
        row = (0.5 - np.arcsin(up.clip(-1, 1)) / np.pi) * image.shape[0] - 0.5
        planes = [map_coordinates(image[..., c], [row, column], order=1, mode="grid-wrap") for c in range(3)]
        save(Path(folder) / f"{path.stem}.exr", np.stack(planes, -1))


if __name__ == "__main__":
    command, *rest = sys.argv[1:] or [""]
    if command == "sheets" and len(rest) > 3:
        sheets(*rest[:3], rest[3:])
    elif command == "views" and len(rest) > 2:
        views(rest[0], rest[1], rest[2:])
    elif command == "reveal" and len(rest) > 2:
        reveal(*rest[:2], rest[2:])
    else:
        sys.exit(__doc__)
