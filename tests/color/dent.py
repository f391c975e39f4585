#!/usr/bin/env python3
"""A model of hue and gamut compression in f64: what makes neighbors about blue different. Optional: no test needs it.

    python3 -m venv v && v/bin/pip install numpy openexr opencv-python-headless
    v/bin/python tests/color/dent.py target/release/afterimage

It prints the largest difference of the model from the program, in codes of 8 bits, for light of Rec.709, P3 and
Rec.2020, and a table: the largest difference between neighbors a thousandth apart, in hue and toward gray, with the
stages and the constants of shaders/lib/oklab.wgsl as they are, and with some removed or changed; 20 seconds on two
cores. tests/color/hues.py measures the program itself.
"""

import sys
import tempfile
from pathlib import Path

import hues
import numpy as np

TO_LMS = np.array(
    [[0.4122214708, 0.5363325363, 0.0514459929], [0.2119034982, 0.6806995451, 0.1073969566],
     [0.0883024619, 0.2817188376, 0.6299787005]]
)
TO_LAB = np.array(
    [[0.2104542553, 0.7936177850, -0.0040720468], [1.9779984951, -2.4285922050, 0.4505937099],
     [0.0259040371, 0.7827717662, -0.8086757660]]
)
DEVIATION = np.array(
    [[0.3963377774, 0.2158037573], [-0.1055613458, -0.0638541728], [-0.0894841775, -1.2914855480]]
)
FROM_AP1 = np.array(
    [[1.705051, -0.621792, -0.083259], [-0.130256, 1.140805, -0.010548], [-0.024003, -0.128969, 1.152972]]
)
AS_IT_IS = {"slack": 0.01, "dent": True, "slope": 1.2, "share": 0.17, "knee": 0.8, "hue": 1}
CHANGES = {
    "as it is": {},
    "no rule for the dent": {"dent": False},
    "keep_hue: 0.0": {"hue": 0},
    "gamut_knee: 0.5": {"knee": 0.5},
    "OKLAB_LEAST_SHARE 0.35": {"share": 0.35},
    "OKLAB_DENT_SLOPE 0.4": {"slope": 0.4},
    "OKLAB_DENT_SLOPE 0.8": {"slope": 0.8},
    "OKLAB_DENT_SLOPE 1.6": {"slope": 1.6},
}
SHARES = (0.25, 0.4, 0.5, 0.6, 0.7, 0.75, 0.8, 0.9)
EXPOSURES = (0.1, 0.3, 0.5, 0.731, 0.95, 1.19, 1.7)


def soft_floor(v, least):
    light = np.maximum(v, 0)
    return light + np.maximum(2 * least - light, 0) ** 2 * (0.25 / np.maximum(least, 1e-30))


def oklab(lms):
    return np.cbrt(lms) @ TO_LAB.T


def length(v):
    return np.linalg.norm(v, axis=-1, keepdims=True)


def own_hue(chroma, lms, share, amount):
    """Chroma with a share of the hue of the light."""
    above = np.maximum(lms, 0).mean(-1, keepdims=True)
    light = oklab(soft_floor(lms, share * above))[:, 1:]
    turn = amount * np.maximum(lms.mean(-1, keepdims=True), 0) / np.maximum(above, 1e-30)
    size = length(chroma)
    mixed = chroma + turn * (light * size / np.maximum(length(light), 1e-20) - chroma)
    return mixed * size / np.maximum(length(mixed), np.maximum(0.5 * size, 1e-20))


def result(source, mapped, **changes):
    """Codes of 8 bits of light that a curve has mapped, with a peak of 1."""
    at = AS_IT_IS | changes
    lab = oklab(mapped @ TO_LMS.T)
    chroma = own_hue(lab[:, 1:], source @ TO_LMS.T, at["share"], at["hue"])
    lightness = lab[:, :1].clip(0, 1)
    gray = lightness**3
    relative = chroma / np.maximum(lightness, 1e-6)
    k = relative @ DEVIATION.T
    c1, c2, c3 = (np.linalg.inv(TO_LMS) @ v.T for v in (3 * k, 3 * k**2, k**3))
    end = np.full(c1.shape[1], 1e30)
    if at["dent"]:
        slope = at["slope"] * length(relative)[:, 0]
        first = c1[0] + slope
        second = c2[0] + np.sqrt(np.maximum(c2[0] ** 2 - 3 * c3[0] * first, 0))
        has_dent = (first < 0) & (second > 0)
        bend = np.where(has_dent, -first / np.where(has_dent, second, 1), 0)
        red = 1 + bend * (c1[0] + bend * (c2[0] + bend * c3[0]))
        end = np.where(has_dent, bend + np.maximum(red + at["slack"], 0) / np.maximum(slope, 1e-9), end)

    def color(t):
        return 1 + t * (c1 + t * (c2 + t * c3))

    def is_inside(t):
        v = color(t)
        return (t <= end) & (v.min(0) >= -at["slack"]) & (v.max(0) <= 1 / np.maximum(gray[:, 0], 1e-30))

    knee = at["knee"]
    low, high = np.zeros(len(k)), np.ones(len(k))
    for _ in range(30):
        middle = (low + high) / 2
        inside = is_inside(middle / (1 - middle * (1 - knee)))
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    border = low / (1 - low * (1 - knee))
    over, rest = 1 - knee * border, 1 - knee
    share = np.minimum(border * (knee + rest * over / np.maximum(rest * border + over, 1e-20)), 1)
    share = np.where(is_inside(np.full(len(k), 1 / knee)), 1, share)
    rgb = gray * np.maximum(color(share).T, 0)
    rgb = rgb * (1 + (1 - share[:, None]) * np.maximum(1 - rgb.max(-1, keepdims=True), 0))
    light = rgb.clip(0, 1)
    return 255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)


def uchimura(x):
    """The curve with its default parameters."""
    start, straight, exponent = 0.22, 0.4, 1.33
    end = start + (1 - start) * straight
    share = (x / start).clip(0, 1)
    share = share * share * (3 - 2 * share)
    toe = start * (np.minimum(x, start) / start) ** exponent
    shoulder = 1 - (1 - end) * np.exp(-np.maximum(x - end, 0) / (1 - end))
    return np.where(x >= end, shoulder, toe * (1 - share) + x * share)


def of_none(source, **changes):
    return result(source, np.maximum(source, 0), **changes)


def of_uchimura(source, **changes):
    low, high = 0.5, 2.0
    for _ in range(60):
        scale = (low + high) / 2
        low, high = (scale, high) if uchimura(np.array(0.18 * scale)) < 0.18 else (low, scale)
    light = low * (source @ np.linalg.inv(FROM_AP1).T)
    mean = np.maximum(light, 0).mean(-1, keepdims=True)
    return result(source, uchimura(soft_floor(light, 0.1 * mean**2 / (1 + mean))) @ FROM_AP1.T, **changes)


def largest_step(operator, place, changes):
    """The largest difference between neighbors about blue: `place` gives light by its place around a ring."""
    turn, largest = np.linspace(3.3, 4.7, 2801), 0
    for exposure in EXPOSURES:
        light = exposure * place(turn)
        step = hues.STEP * light.max(-1, keepdims=True)
        ways = exposure * place(turn + 1e-5) - light, light.max(-1, keepdims=True) - light
        beside = [light + step * way / abs(way).max(-1, keepdims=True) for way in ways]
        codes = operator(np.concatenate([light, *beside]), **changes).reshape(3, -1, 3)
        largest = max(largest, abs(codes[1:] - codes[:1]).max())
    return largest


def main(program):
    folder, light = Path(tempfile.mkdtemp()), hues.light()
    for curve, operator in (("None", of_none), ("Uchimura", of_uchimura)):
        found = hues.run(program, folder, light, f"curve: {curve}", True, "--plan", "bake=Off")[0, :3]
        model = operator(light[0, :3].reshape(-1, 3)).reshape(found.shape)
        print(f"{curve}: the model is off by {abs(model - found).max():.3f} codes")
    spaces = [lambda turn, rows=rows: hues.hue(turn) @ np.transpose(rows) for rows in hues.TO_REC709.values()]
    rings = spaces + [lambda turn, share=share: hues.toward_zero(turn, share) for share in SHARES]
    rec2020 = spaces[list(hues.TO_REC709).index("Rec.2020")]
    print("| | `None` in Rec.2020 | `Uchimura` in Rec.2020 | `Uchimura` in all |\n|---|--:|--:|--:|")
    for name, changes in CHANGES.items():
        in_all = max(largest_step(of_uchimura, place, changes) for place in rings)
        in_rec2020 = [largest_step(operator, rec2020, changes) for operator in (of_none, of_uchimura)]
        print(f"| {name} | {in_rec2020[0]:.1f} | {in_rec2020[1]:.1f} | {in_all:.1f} |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(str(Path(sys.argv[1]).resolve()))
