#!/usr/bin/env python3
"""What the figures of single switches say of combinations: tests/combinations.py PROGRAM FOLDER PIPELINE... -- IMAGE...

`tune` measures each switch alone, tries steps in the order of what they save for their error, and leaves out what alone
is beyond the limit. So it expects errors that add up, and none that cancel. This script takes its list of switches,
measures each alone and 25 random combinations of each pipeline on the images, all as tiers of one file, and compares.
Writes graph/docs/measurements/combinations.csv, and prints the distribution of measured over predicted. Errors and
bytes do not depend on the machine; milliseconds do. Needs nothing but Python.
"""

import csv
import json
import random
import statistics
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
TABLE = ROOT / "graph/docs/measurements/combinations.csv"
COUNT = 25


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")


def switches(program, folder, pipeline, image):
    """Each switch with its choices, the most accurate first, as `tune` lists them in its state."""
    state = folder / f"{pipeline.stem}.state.json"
    state.unlink(missing_ok=True)
    wanted = ["--error", "1000", "--repeats", "1", "--state", state, "-o", folder / "tuned.ron"]
    run(program, "tune", pipeline, image, *wanted)
    listed = (line.split(": ", 1) for line in json.loads(state.read_text())["identity"]["switches"])
    return {key: choices.split(", ") for key, choices in listed}


def entries(choice):
    """A tier; a format that the node chooses itself is no entry."""
    return ", ".join(f'"{key}": {value}' for key, value in choice.items() if value != "(default)")


def measured(program, folder, pipeline, images, tiers):
    """The row of each tier by its name."""
    file, report = folder / f"{pipeline.stem}.tiers.ron", folder / f"{pipeline.stem}.json"
    # Names of tiers have no dots.
    text = "".join(f'        "t{at}": {{ {entries(choice)} }},\n' for at, choice in enumerate(tiers.values()))
    file.write_text(f'Pipeline(\n    extends: "{pipeline}",\n    tiers: {{\n{text}    }},\n)\n')
    wanted = ["--tiers", "--repeats", "3", "--json", report, "--allow", pipeline.parent]
    run(program, "measure", file, *images, *wanted)
    rows = {row["variant"].removeprefix("tier "): row for row in json.loads(report.read_text())["rows"]}
    return {name: rows[f"t{at}"] for at, name in enumerate(tiers)}


def combinations(program, folder, pipeline, images):
    """A row for each random combination."""
    known = switches(program, folder, pipeline, images[0])
    exact = {key: choices[0] for key, choices in known.items()}
    tiers = {"exact": exact}
    for key, choices in known.items():
        tiers.update({f"{key}={value}": {**exact, key: value} for value in choices[1:]})
    singles = len(tiers)
    dice = random.Random(pipeline.stem)
    while len(tiers) < singles + COUNT:
        choice = {key: dice.choice(choices) for key, choices in known.items()}
        changed = [f"{key}={value}" for key, value in choice.items() if value != exact[key]]
        if len(changed) > 1:
            tiers[" ".join(changed)] = choice
    rows = measured(program, folder, pipeline, images, tiers)
    base = rows["exact"]
    for name in list(tiers)[singles:]:
        alone = [rows[change] for change in name.split(" ")]
        row = {"pipeline": pipeline.stem, "choice": name}
        for figure, digits in (("p999", 3), ("bytes_moved", 0), ("gpu_ms", 3)):
            predicted = base[figure] + sum(one[figure] - base[figure] for one in alone)
            row |= {f"{figure}_predicted": round(predicted, digits), figure: round(rows[name][figure], digits)}
        yield row | {"p999_largest": round(max(one["p999"] for one in alone), 3)}


def main():
    program, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    pipelines, images = " ".join(sys.argv[3:]).split(" -- ")
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for pipeline in pipelines.split():
        rows += combinations(program, folder, Path(pipeline).resolve(), images.split())
    with TABLE.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    print(f"{len(rows)} combinations; measured over predicted: least, 5 %, median, 95 %, most")
    predictions = ("p999_predicted", "p999_largest", "bytes_moved_predicted", "gpu_ms_predicted")
    for figure, of in ((prediction.rsplit("_", 1)[0], prediction) for prediction in predictions):
        ratios = sorted((row[figure] / row[of], row["pipeline"], row["choice"]) for row in rows)
        cuts = statistics.quantiles([ratio for ratio, *_ in ratios], n=20)
        figures = (ratios[0][0], cuts[0], statistics.median(ratio for ratio, *_ in ratios), cuts[-1], ratios[-1][0])
        print(f"{figure} / {of}: " + " ".join(f"{ratio:.3f}" for ratio in figures))
        for ratio, pipeline, choice in ratios[:3] + ratios[-3:]:
            print(f"  {ratio:.3f} {pipeline}: {choice}")


if __name__ == "__main__":
    main()
