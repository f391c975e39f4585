"""The chart of the errors of all frames, as SVG."""

WIDE, HIGH, LEFT, TOP, GAP, ROW = 380, 84, 60, 64, 70, 118
WITH, WITHOUT = "#0b62a8", "#c4543c"


def line(points, color):
    text = " ".join(f"{x:.0f},{y:.1f}".removesuffix(".0") for x, y in points)
    return f'<polyline points="{text}" fill="none" stroke="{color}" stroke-width="1.6"/>'


def label(x, y, text, more=""):
    return f'<text x="{x:.0f}" y="{y:.0f}" {more}>{text}</text>'


def panel(left, top, scenes, column, is_zero):
    """Without and with the node, one scene after the other."""
    pairs = [list(rows.values())[:2] for rows in scenes]
    values = [row[column] for pair in pairs for rows in pair for row in rows]
    low, high = 0.0 if is_zero else min(values) - 1, max(values) * 1.05
    step = WIDE / len(scenes)
    drawn = [f'<rect x="{left}" y="{top}" width="{WIDE}" height="{HIGH}" fill="none" stroke="#999"/>']
    for at in (low, high):
        y = top + HIGH * (high - at) / (high - low) + 4
        drawn.append(label(left - 6, y, f"{at:.2f}" if is_zero else f"{at:.0f}", 'text-anchor="end"'))
    for index, pair in enumerate(pairs):
        start = left + step * index
        if index > 0:
            drawn.append(f'<path d="M{start:.0f} {top}v{HIGH}" stroke="#bbb"/>')
        for rows, color in zip(pair, (WITHOUT, WITH)):
            frames = [row[0] for row in rows]
            across = (step - 12) / max(frames[-1] - frames[0], 1)
            left_of = [start + 6 + across * (frame - frames[0]) for frame in frames]
            down = [top + HIGH * (high - row[column]) / (high - low) for row in rows]
            drawn.append(line(zip(left_of, down), color))
    return drawn


def draw(found, names):
    """`found`: for each case, for each scene, the rows (frame, PSNR, FLIP) without the node and with it."""
    width, height = LEFT + 2 * WIDE + GAP + 20, TOP + ROW * len(found)
    drawn = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        'font-family="sans-serif" font-size="12">',
        f'<rect width="{width}" height="{height}" fill="#fff"/>',
        label(LEFT, 20, f"Each frame of {', '.join(names)}, against Cycles", 'font-size="15"'),
        label(LEFT, 40, "without the node", f'fill="{WITHOUT}"'),
        label(LEFT + 110, 40, "with it", f'fill="{WITH}"'),
    ]
    for index, (title, scenes) in enumerate(found.items()):
        top = TOP + ROW * index + 12
        for left, unit, column in [(LEFT, "mean of FLIP", 2), (LEFT + WIDE + GAP, "PSNR in dB", 1)]:
            drawn.append(label(left, top - 4, f"{title}, {unit}"))
            drawn += panel(left, top, scenes, column, column == 2)
    return "\n".join([*drawn, "</svg>\n"])
