"""How much a glow pulses while its light moves by pixels: python tests/color/pulse.py

Needs numpy. A model in f64 of the linear part of lynx.ron: halvings by `Binomial`, five levels meant for 1080 lines, their
enlargement by a tent of radius 0.85, and the enlargement of their sum to the picture. Prints the largest ratio between the
glows at a place relative to a square light of 1, 2, 3 and 8 pixels, where they are a tenth of the brightest or more, over
the phases of the coarsest grid of two levels, for pictures of several heights. Whatever is separable is computed along one
axis.
"""

import numpy as np

LEVELS, LINES, RADIUS = 5, 1080, 0.85
BINOMIAL = np.array([1, 5, 10, 10, 5, 1]) / 32
SMOOTH = (1 / 3, 8 / 33, 1 / 11)
# The radius of the tent over the sum, or None for one read; then the weights by which the sum is smoothed before.
FILTERS = {
    "one read": (None, None),
    "tent of radius 1": (1.0, None),
    "tent of radius 0.93": (0.93, None),
    "smooth and one read": (None, SMOOTH),
}


def halving(count):
    """The matrix of a halving; beyond the border is nothing, which is far from the light."""
    matrix = np.zeros((count // 2, count))
    for row in range(count // 2):
        first = int(np.floor((row + 0.5) * count / (count // 2))) - 3
        for tap, weight in enumerate(BINOMIAL):
            if 0 <= first + tap < count:
                matrix[row, first + tap] += weight
    return matrix


def enlargement(count, source, radius):
    """The matrix of a tent of three reads so many texels apart, or of one read."""
    matrix = np.zeros((count, source))
    reads = [(0.0, 1.0)] if radius is None else [(-radius, 0.25), (0.0, 0.5), (radius, 0.25)]
    for row in range(count):
        for away, weight in reads:
            place = (row + 0.5) * source / count - 0.5 + away
            left = int(np.floor(place))
            for texel, share in ((left, 1 - place + left), (left + 1, place - left)):
                if 0 <= texel < source:
                    matrix[row, texel] += weight * share
    return matrix


def smoothing(count, half):
    matrix = np.zeros((count, count))
    for away, weight in enumerate(half):
        for side in {-away, away}:
            matrix += weight * np.eye(count, k=side)
    return matrix


def weights(lines):
    """The index of the finest level of the sum, and the weight of each from the first on, as `Upsample` has them."""
    octaves = np.log2(lines / LINES)
    octaves = round(octaves) if abs(octaves - round(octaves)) < 0.02 else octaves
    count = LEVELS + int(np.ceil(octaves))
    found = np.zeros(count)
    for level in range(LEVELS):
        place = min(max(level + octaves, 0), count - 1)
        share = (4 ** (place % 1) - 1) / 3
        found[int(place)] += (1 - share) / LEVELS
        found[min(int(place) + 1, count - 1)] += share / LEVELS
    return int(max(octaves, 0)), found


def axis(lines, tent, smooth):
    """For each level its weight and the matrix from the light to its part of the glow, along one axis."""
    finest, shares = weights(lines)
    levels, sizes, chain = [], [lines], np.eye(lines)
    for _ in shares:
        chain = halving(sizes[-1]) @ chain
        sizes.append(chain.shape[0])
        levels.append(chain)
    result = enlargement(lines, sizes[finest + 1], tent)
    if smooth:
        result = result @ smoothing(sizes[finest + 1], smooth)
    for index, share in enumerate(shares):
        if index > finest:
            result = result @ enlargement(sizes[index], sizes[index + 1], RADIUS)
        if index >= finest:
            yield share, result @ levels[index]


def swing(lines, parts, side):
    phases, margin = (16, 40) if lines > 1080 else (8, 24)
    glows = []
    for phase in range(phases):
        def part(place):
            return [(share, m[place - margin:place + side + margin, place:place + side].sum(1)) for share, m in parts]
        across, down = part(lines // 2 - 16 + phase), part(lines // 2 - 16 + 3 * phase % phases)
        glows.append(sum(share * np.outer(y, x) for (share, x), (_, y) in zip(across, down)))
    glows = np.array(glows)
    seen = glows[0] > 0.1 * glows[0].max()
    return (glows.max(0) / glows.min(0))[seen].max()


print("lines,filter,1 pixel,2 pixels,3 pixels,8 pixels")
for lines in (192, 270, 540, 1080, 2160):
    for name, how in FILTERS.items():
        parts = list(axis(lines, *how))
        print(f"{lines},{name}," + ",".join(f"{swing(lines, parts, side):.3f}" for side in (1, 2, 3, 8)), flush=True)
