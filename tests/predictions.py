#!/usr/bin/env python3
"""How well `tune` predicts errors: tests/predictions.py PLOT.svg TABLE.csv...

The tables are those of `afterimage tune PIPELINE IN... --random COUNT`. Draws predicted against measured errors, a dot
for each choice and image, and prints those of the worst image of each choice as CSV. On standard error, for all and for
the worst images: the RMS of the factor between both, its range, the share of predictions below the measurement, and
below it by more than a fifth, which `tune` allows.
"""

import csv
import math
import sys

SIDE, LEFT, TOP = 480, 70, 50


def rows(path):
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            yield row["choice"], float(row["predicted"]), float(row["measured"])


def of_worst(pairs):
    """The largest predicted and the largest measured error of each choice."""
    worst = {}
    for choice, predicted, measured in pairs:
        before = worst.get(choice, (0.0, 0.0))
        worst[choice] = max(before[0], predicted), max(before[1], measured)
    return [(choice, *errors) for choice, errors in worst.items()]


def figures(pairs):
    logs = sorted(math.log(predicted / measured) for _, predicted, measured in pairs if predicted > 0 and measured > 0)
    rms = math.exp(math.sqrt(sum(log * log for log in logs) / len(logs)))
    below = sum(log < 0 for log in logs) / len(logs)
    far = sum(log < -math.log(1.2) for log in logs) / len(logs)
    spread = f"{math.exp(logs[0]):.2f} to {math.exp(logs[-1]):.2f}"
    return f"{len(logs)}: factor {rms:.3f} (RMS), {spread}; {below:.0%} below, {far:.0%} by more than a fifth"


def plot(pairs):
    errors = [error for _, predicted, measured in pairs for error in (predicted, measured) if error > 0]
    low, high = math.floor(math.log2(min(errors))), math.ceil(math.log2(max(errors)))

    def place(error):
        return SIDE * (math.log2(max(error, 2.0**low)) - low) / (high - low)

    def text(x, y, words, anchor="middle"):
        return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="#6b7480">{words}</text>'

    width, height = LEFT + SIDE + 30, TOP + SIDE + 70
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}"',
        ' font-family="sans-serif" font-size="13">',
        f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
        text(LEFT, 24, "error in 8-bit codes, 99.9th percentile: predicted (up), measured (across)", "start"),
    ]
    for power in range(low, high + 1):
        at = place(2.0**power)
        parts.append(f'<path d="M{LEFT + at:.1f} {TOP}v{SIDE}M{LEFT} {TOP + SIDE - at:.1f}h{SIDE}" stroke="#e3e6ea"/>')
        mark = f"{2.0**power:g}"
        parts += [text(LEFT + at, TOP + SIDE + 20, mark), text(LEFT - 8, TOP + SIDE - at + 4, mark, "end")]
    parts.append(f'<path d="M{LEFT} {TOP + SIDE}l{SIDE} {-SIDE}" stroke="#1c2128"/>')
    dots = [f"M{LEFT + place(measured):.0f} {TOP + SIDE - place(predicted):.0f}h0" for _, predicted, measured in pairs]
    parts.append(f'<path d="{"".join(dots)}" stroke="#3563c9" stroke-width="4" stroke-linecap="round" opacity="0.5"/>')
    spread, below = figures(pairs).split("; ")
    parts += [text(LEFT, height - 26, f"choices and images, {spread}", "start"), text(LEFT, height - 8, below, "start")]
    return "\n".join([*parts, "</svg>", ""])


plot_path, *tables = sys.argv[1:]
pairs = [pair for table in tables for pair in rows(table)]
worst = of_worst(pairs)
print(f"choices and images, {figures(pairs)}\nworst images, {figures(worst)}", file=sys.stderr)
print("choice,predicted,measured")
for choice, predicted, measured in worst:
    print(f"{choice},{predicted:.3f},{measured:.3f}")
with open(plot_path, "w") as file:
    file.write(plot(pairs))
