#!/usr/bin/env python3
"""Formats of wires, chosen by error, against those by hand: tests/formats.py PROGRAM PHOTOGRAPHS FOLDER NAME...

For the tier `low` of each built-in pipeline of these names, without the formats that it has: measures each format of
each wire alone, adds them in the order of error for bytes, and keeps the set that moves the fewest bytes with no larger
error than those written by hand. The images are gray lamps, whose glow must stay gray, a lamp in motion and a pan; see
tests/motion. Prints a table in Markdown, with the bytes that a frame of 4K moves. Needs the packages of
tests/motion/judge.py. Errors and bytes do not depend on the machine.
"""

import json
import re
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "motion"))

import cv2
import footage
import judge
import numpy


def low(name):
    """The entries of the tier as text, and its formats by the names of nodes."""
    text = (judge.ROOT / f"pipelines/{name}.ron").read_text()
    block = re.search(r'\n        "low": \{\n((?:            .*\n)*)        \},', text).group(1)
    every = [line.strip().rstrip(",") for line in block.splitlines() if not line.strip().startswith("//")]
    formats = dict(re.findall(r'"([^"]+)\.format": (\w+)', block))
    return [entry for entry in every if ".format" not in entry], formats


def gray_lamps():
    """Lamps of several sizes on black, a stop from one to the next: their glow is gray."""
    frame = numpy.full((footage.HEIGHT, footage.WIDTH, 3), 0.002, numpy.float32)
    for place in range(12):
        x, y = 40 + 80 * (place % 6), 70 + 130 * (place // 6)
        frame = footage.lamp(frame, x, y, 1 + place % 4, 2.0 ** (1 + place), (1.0, 1.0, 1.0))
    return [frame]


def measured(program, folder, name, images, tiers, *more):
    """The rows of a pipeline with these tiers, by the names of variants, each with the bytes that a frame of 4K moves."""
    file, report = folder / f"{name}.formats.ron", folder / f"{name}.formats.json"
    text = "".join(f'        "{tier}": {{ {", ".join(entries)} }},\n' for tier, entries in tiers.items())
    base = judge.ROOT / f"pipelines/{name}.ron"
    file.write_text(f'Pipeline(\n    extends: "{base}",\n    tiers: {{\n{text}    }},\n)\n')
    allow = ["--allow", base.parent]
    judge.run(program, "measure", file, *images, "--repeats", "1", "--json", report, *allow, *more)
    rows = {row["variant"].removeprefix("tier "): row for row in json.loads(report.read_text())["rows"]}
    for tier in tiers:
        command = [program, "plan", file, "--tier", tier, "--size", "3840x2160", "--format", "json", *allow]
        plan = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
        rows[tier]["moved"] = sum(planned["bytes_moved"] for planned in plan["passes"])
    return rows


def with_formats(entries, formats):
    return entries + [f'"{node}.format": {name}' for node, name in formats.items()]


def chosen(program, folder, name, images, tiny):
    """The figures of the tier by hand, without formats and as chosen, with the formats of each."""
    entries, by_hand = low(name)
    listed = measured(program, folder, name, [tiny], {"wide": entries}, "--tier", "wide")
    alone = [variant.split(".format=") for variant, row in listed.items() if row["kind"] == "format"]
    tiers = {f"alone {at}": with_formats(entries, {node: narrow}) for at, (node, narrow) in enumerate(alone)}
    rows = measured(program, folder, name, images, {"wide": entries, **tiers}, "--tiers")
    wide, trades = rows["wide"], []
    for at, (node, narrow) in enumerate(alone):
        row = rows[f"alone {at}"]
        codes, saved = row["p999"] - wide["p999"], 1 - row["moved"] / wide["moved"]
        print(f"  `{name}`: `{node}` in {narrow} costs {codes:.3f} codes and saves {saved:.1%} of the bytes moved")
        if saved > 0:
            trades.append((max(codes, 1e-3) / saved, node, narrow))
    sets, formats = {}, {}
    for at, (_, node, narrow) in enumerate(sorted(trades)):
        formats = {**formats, node: narrow}
        sets[f"chosen {at}"] = formats
    tiers = {"hand": with_formats(entries, by_hand), "wide": entries}
    tiers |= {tier: with_formats(entries, formats) for tier, formats in sets.items()}
    rows = measured(program, folder, name, images, tiers, "--tiers")
    within = [tier for tier in sets if rows[tier]["p999"] <= rows["hand"]["p999"]]
    best = min([*within, "wide"], key=lambda tier: (rows[tier]["moved"], rows[tier]["p999"]))
    shown = (("by hand", "hand", by_hand), ("none", "wide", {}), ("chosen", best, sets.get(best, {})))
    for label, tier, formats in shown:
        row, words = rows[tier], ", ".join(f"`{node}` {narrow}" for node, narrow in formats.items())
        moved = row["moved"] / rows["wide"]["moved"]
        yield f"| `{name}` | {label} | {words} | {row['p999']:.2f} | {row['jod']:.3f} | {moved:.1%} |"


def main():
    program, folder = str(Path(sys.argv[1]).resolve()), Path(sys.argv[3]).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    every = footage.sequences(sys.argv[2])
    every = {"gray lamps": gray_lamps(), "lamp": every["lamp"][:2], "pan": every["pan"][:2]}
    half = {name: [cv2.resize(frame, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA) for frame in frames]
            for name, frames in every.items()}
    images = [footage.write(folder / "footage", name, frames) for name, frames in half.items()]
    tiny = footage.write(folder / "footage", "tiny", [cv2.resize(every["pan"][0], (64, 36))])
    lines = [line for name in sys.argv[4:] for line in chosen(program, folder, name, images, tiny)]
    print("| pipeline | formats | wires | p99.9 | JOD | bytes moved |\n|---|---|---|--:|--:|--:|")
    print("\n".join(lines))


main()
