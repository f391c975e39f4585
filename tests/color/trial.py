#!/usr/bin/env python3
"""A blind trial: a pipeline beside eight other operators at equal mean luminance. Optional: no test needs it.

    apt install pfstools; python3 -m venv v
    v/bin/pip install opencolorio numpy scipy openexr pillow opencv-python-headless
    v/bin/python tests/color/trial.py views trial/views SEED PANORAMA...
    v/bin/python tests/color/trial.py sheets target/release/afterimage pipelines/tsushima.ron trial trial/views/*.exr
    # Look at trial/*.png and write a line `NAME LETTERS`, the best two in order, for each to choices.txt, and for each
    # view with a sky a line `NAME LEFT TOP RIGHT BOTTOM`, in pixels, to skies.txt. Then:
    v/bin/python tests/color/trial.py reveal trial choices.txt skies.txt trial/views/*.exr

`views` looks into each panorama in a direction that the seed gives, through a lens of 75 degrees. `sheets` draws for
each image the results of the pipeline, ACES 2.0 and ACES 1.3 (OpenColorIO), AgX, Khronos Neutral, Gran Turismo 7,
`pfstmo_reinhard02 -s`, `pfstmo_mantiuk08` and `pfstmo_durand02`, in random order, and keeps the order in
trial/key.json; 16 seconds a view on two cores. `reveal` compares the choices with it. It prints, as CSV, what was
chosen, the share of pixels above code 250 and the halo of each operator: at the scale of 1/64 of the width, the codes
by which luminance falls where that of the scene rises, exceeded by one pixel in a thousand. A table follows of how
often each operator was first and second, and of its means: these two, the share of pixels in rings, the standard
deviation and the 99th percentile of lightness, and the chroma of skies as a share of that of the scene at the same mean.
Lightness and chroma are those of Oklab. A ring is what a halo is at the scale of pixels: along a row or a column on
which the scene only rises, the luminance of the result has fallen by more than 6 codes.
"""

import json
import random
import subprocess
import sys
from pathlib import Path

import numpy as np

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
LETTERS = "ABCDEFGHI"
NAMES = ("pipeline", "aces2", "agx", "neutral", "reinhard02", "mantiuk08", "aces1", "gt7", "durand02")
COLUMNS = 3
LETTER_ROWS = 24
TO_REC2020 = np.array([[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0113], [0.0164, 0.0880, 0.8956]])


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


def aces(name):
    """The view for SDR of a built-in configuration of OpenColorIO."""
    import PyOpenColorIO as ocio

    config = ocio.Config.CreateFromBuiltinConfig(name)
    display = next(name for name in config.getDisplays() if "sRGB" in name)
    view = next(name for name in config.getViews(display) if "SDR" in name)
    source = next(name for name in ("lin_rec709_srgb", "lin_rec709") if config.getColorSpace(name))
    processor = config.getProcessor(source, display, view, ocio.TRANSFORM_DIR_FORWARD).getDefaultCPUProcessor()

    def apply(light):
        pixels = np.ascontiguousarray(light.astype(np.float32))
        processor.applyRGB(pixels)
        return pixels.astype(float).clip(0, 1)

    return apply


def agx(light):
    """The AgX of Troy Sobotka, by the matrices and the polynomial that three.js has of it."""
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
    x = (np.log2(np.maximum(light @ TO_REC2020.T @ inset.T, 1e-10)).clip(low, high) - low) / (high - low)
    curve = ((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x * x + 0.1191 * x - 0.00232
    linear = np.maximum(curve @ outset.T, 0) ** 2.2
    return encode((linear @ np.linalg.inv(TO_REC2020).T).clip(0, 1))


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


def gt7(light):
    """The tone mapping of Gran Turismo 7 for SDR, as published by Yasutomi, Suzuki and Uchimura at SIGGRAPH 2025."""
    to_lms = np.array([[1688, 2146, 262], [683, 2951, 462], [99, 309, 3688]]) / 4096
    to_ictcp = np.array([[2048, 2048, 0], [6610, -13613, 7003], [17933, -17390, -543]]) / 4096
    m1, m2, c1, c2, c3 = 2610 / 16384, 2523 / 32, 3424 / 4096, 2413 / 128, 2392 / 128

    def ictcp(rgb):
        y = (np.maximum(rgb @ to_lms.T, 0) / 100) ** m1
        return ((c1 + c2 * y) / (1 + c3 * y)) ** m2 @ to_ictcp.T

    def rgb_of(ictcp):
        e = np.maximum(ictcp @ np.linalg.inv(to_ictcp).T, 0) ** (1 / m2)
        return 100 * (np.maximum(e - c1, 0) / (c2 - c3 * e)) ** (1 / m1) @ np.linalg.inv(to_lms).T

    def smooth(x, start, end):
        t = ((x - start) / (end - start)).clip(0, 1)
        return t * t * (3 - 2 * t)

    # 1 is 100 cd/m2, and paper white 250.
    peak, alpha, gray, linear, toe = 2.5, 0.25, 0.538, 0.444, 1.280
    k = (linear - 1) / (alpha - 1)
    rgb = np.maximum(light @ TO_REC2020.T, 0)
    shoulder = peak * (linear + k - k * np.exp((linear - rgb / peak) / k))
    share = smooth(rgb, 0, gray)
    below = (1 - share) * gray * (rgb / gray) ** toe + share * rgb
    skewed = np.where(rgb < linear * peak, below, shoulder)
    given = ictcp(rgb)
    fade = 1 - smooth(given[..., :1] / ictcp(np.full(3, peak))[0], 0.98, 1.16)
    scaled = rgb_of(np.concatenate([ictcp(skewed)[..., :1], given[..., 1:] * fade], -1))
    blended = np.minimum(0.4 * skewed + 0.6 * scaled, peak) / peak
    return encode((blended @ np.linalg.inv(TO_REC2020).T).clip(0, 1))


def pfs(folder, image, *command):
    given, result = folder / "given.exr", folder / "result.exr"
    save(given, image)
    line = f"pfsinexr {given} | {' '.join(command)} | pfsoutexr {result}"
    subprocess.run(line, shell=True, check=True, stderr=subprocess.DEVNULL)
    return load(result).clip(0, 1)


def pictures(binary, pipeline, folder, image, aces1, aces2):
    """The codes from 0 to 1 of every operator, all of the mean luminance that the pipeline gives."""
    from PIL import Image

    given, result = folder / "given.exr", folder / "result.png"
    save(given, image)
    subprocess.run([binary, "render", pipeline, given, "-o", result], check=True, stdout=subprocess.DEVNULL)
    own = np.asarray(Image.open(result).convert("RGB")) / 255
    exposed = image * 0.18 / np.exp(np.log(np.maximum(image @ LUMINANCE, 1e-6)).mean())
    target = mean(own)
    curves = {"aces2": aces2, "agx": agx, "neutral": neutral, "aces1": aces1, "gt7": gt7}
    # `pfstmo_mantiuk08` gives codes, the others display-linear light.
    local = {
        "reinhard02": pfs(folder, exposed, "pfstmo_reinhard02", "-s"),
        "mantiuk08": decode(pfs(folder, exposed, "pfstmo_mantiuk08")),
        "durand02": pfs(folder, exposed, "pfstmo_durand02"),
    }
    shown = {name: at_mean(lambda stops: f(exposed * 2**stops), target, -8, 8) for name, f in curves.items()}
    shown |= {name: at_mean(lambda stops: encode(f * 2**stops), target, -6, 6) for name, f in local.items()}
    return {"pipeline": own} | shown


def sheets(binary, pipeline, folder, paths):
    from PIL import Image, ImageDraw

    folder, key = Path(folder), {}
    transforms = aces("cg-config-v2.2.0_aces-v1.3_ocio-v2.4"), aces("cg-config-v4.0.0_aces-v2.0_ocio-v2.5")
    (folder / "work").mkdir(parents=True, exist_ok=True)
    for path in map(Path, paths):
        shown = pictures(binary, pipeline, folder / "work", load(path), *transforms)
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


def rings(codes, light):
    """The share of pixels, per thousand, that are darker than those before them on a line on which the scene rises."""
    deepest = np.zeros(codes.shape)
    for view in (lambda x: x, lambda x: x[:, ::-1], lambda x: x.T, lambda x: x.T[:, ::-1]):
        result, scene, fall = view(codes), view(light), view(deepest)
        peak = result[:, 0]
        for column in range(1, result.shape[1]):
            here = result[:, column]
            peak = np.where(scene[:, column] >= scene[:, column - 1], np.maximum(peak, here), here)
            fall[:, column] = np.maximum(fall[:, column], peak - here)
    return 1000 * (deepest > 6).mean()


def oklab(light):
    """Lightness, and a + ib, of linear light."""
    to_lms = [[0.4122214708, 0.5363325363, 0.0514459929], [0.2119034982, 0.6806995451, 0.1073969566],
              [0.0883024619, 0.2817188376, 0.6299787005]]
    to_lab = [[0.2104542553, 0.7936177850, -0.0040720468], [1.9779984951, -2.4285922050, 0.4505937099],
              [0.0259040371, 0.7827717662, -0.8086757660]]
    lab = np.cbrt(light @ np.transpose(to_lms)) @ np.transpose(to_lab)
    return lab[..., 0], lab[..., 1] + 1j * lab[..., 2]


def lines(path):
    """The words of each line by its first."""
    return {name: words for name, *words in map(str.split, Path(path).read_text().splitlines())}


def reveal(folder, choices, skies, paths):
    from PIL import Image

    key, chosen, skies = json.loads((Path(folder) / "key.json").read_text()), lines(choices), lines(skies)
    counts, means = {name: [0, 0] for name in NAMES}, {name: [] for name in NAMES}
    print("view,first,second,", ",".join(f"{name} above 250 (%),{name} halo (codes)" for name in NAMES), sep="")
    for path in map(Path, paths):
        order = key[path.stem]
        sheet = np.asarray(Image.open(Path(folder) / f"{path.stem}.png"))
        height, width = COLUMNS * sheet.shape[0] // len(order), sheet.shape[1] // COLUMNS
        scene, row = load(path), []
        scene *= mean(sheet / 255) / (scene @ LUMINANCE).mean()
        for name in NAMES:
            index = order.index(name)
            top, left = index // COLUMNS * height, index % COLUMNS * width
            picture = sheet[top : top + height, left : left + width]
            codes = picture @ LUMINANCE
            lightness, color = oklab(decode(picture / 255))
            share = np.nan
            if sky := skies.get(path.stem):
                x, y, right, bottom = map(int, sky)
                part = slice(y, bottom), slice(x, right)
                share = abs(color[part]).mean() / abs(oklab(scene[part])[1]).mean()
            white, around = 100 * (codes > 250).mean(), halo(codes, scene @ LUMINANCE)
            row.append(f"{white:.2f},{around:.1f}")
            # The letter of the picture is in its first rows.
            ringed = rings(codes[LETTER_ROWS:], (scene @ LUMINANCE)[LETTER_ROWS:])
            means[name].append((white, around, ringed, lightness.std(), np.quantile(lightness, 0.99), share))
        best = [order[LETTERS.index(letter)] for letter in chosen[path.stem][0]]
        for place, name in enumerate(best):
            counts[name][place] += 1
        print(",".join([path.stem, *best, *row]))
    heads = "operator | first | second | above 250 | halo | rings | sd | 99 % | chroma of skies"
    print(f"\n| {heads} |\n|---|", "--:|" * 8, sep="")
    for name, (first, second) in counts.items():
        white, around, ringed, spread, top, share = np.nanmean(means[name], 0)
        marks = f"{white:.2f} % | {around:.1f} | {ringed:.2f} ‰"
        print(f"| {name} | {first} | {second} | {marks} | {spread:.3f} | {top:.3f} | {share:.2f} |")


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
    elif command == "reveal" and len(rest) > 3:
        reveal(*rest[:3], rest[3:])
    else:
        sys.exit(__doc__)
