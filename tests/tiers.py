"""The table of `tests/tiers.sh`: `names FILE` prints the tiers of one, `table FOLDER WHERE` the rows of all measurements,
made there, `times FOLDER` replaces times in graph/docs/measurements/tiers.csv, `new FOLDER` what NAME.new.json has of new
images, `worse FOLDER...` counts more images among those that were measured, and `claims` writes that table into the
pipelines as what their tiers claim."""

import csv
import json
import re
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
TABLE = ROOT / "graph/docs/measurements/tiers.csv"
SIZES = ("3840x2160", "1920x1080")
# As `tune`, claims state errors this factor above the worst that was measured.
MARGIN = 1.1
# And codes, FLIP and JOD at least this much worse.
LEAST_CODES, LEAST_FLIP, LEAST_JOD = 0.05, 0.003, 0.02
# The quality in JOD of what looks like the reference.
NO_DIFFERENCE = 10

def tiers(measured):
    """The variants of a measurement that are tiers, and the pipeline as it is written, with their rows."""
    for row in measured["rows"]:
        if row["kind"] in ("written", "tier"):
            yield row["variant"].removeprefix("tier "), row


def milliseconds(folder, name, tier, size):
    """The time of a tier with three decimals, or nothing if it was not measured: a processor's is no claim."""
    stem = name if tier == "as written" else f"{name}-{tier}"
    measured = folder / f"{stem}.{size}.json"
    return f"{json.loads(measured.read_text())['gpu_ms']:.3f}" if measured.exists() else ""


def prices():
    """Megabytes and operations of each pipeline and tier, which the times are of, and the hash of all values, which the
    errors are of."""
    known = {}
    for line in (ROOT / "graph/plan/tests/golden/prices.txt").read_text().splitlines():
        if not line.startswith("#"):
            *name, megabytes, _, _, operations, _, values = line.split()
            known[" ".join(name)] = f"{megabytes},{operations}", values
    return known


def worst(pictures):
    """The largest error and FLIP of measured pictures, and the name of that with the largest error."""
    largest = max(pictures, key=lambda picture: picture["p999"])
    flip = max(picture["flip"] for picture in pictures)
    return f"{largest['p999']:.2f},{flip:.3f},{largest['image']}"


def claimed_codes(p999):
    return max(MARGIN * p999, p999 + LEAST_CODES)


def count_held(pictures, p999):
    """The pictures whose error is within what is claimed of the worst that was measured."""
    return sum(picture["p999"] <= claimed_codes(p999) for picture in pictures)


def by_motion(measured):
    """For each tier its figures on stills and on sequences."""
    is_moving = [image["frames"] > 1 for image in measured["images"]]
    for tier, row in tiers(measured):
        of = lambda moving: [image for image, moves in zip(row["images"], is_moving) if moves == moving]
        yield tier, of(False), of(True)


def table(folder, where):
    print(
        "pipeline,tier,ms_4k,ms_1080p,p999,flip,worst_on,p999_moving,flip_moving,worst_moving,"
        "p999_new,flip_new,new,held,mb_4k,operations,jod,jod_moving,jod_new,display,on,values"
    )
    price = prices()
    for path in sorted(folder.glob("*.json")):
        if "." in path.stem:
            continue
        walks, news = (dict(tiers(json.loads(path.with_suffix(of).read_text()))) for of in (".walk.json", ".new.json"))
        measured = json.loads(path.read_text())
        for tier, stills, moving in by_motion(measured):
            times = ",".join(milliseconds(folder, path.stem, tier, size) for size in SIZES)
            moving += walks[tier]["images"]
            new = news[tier]["images"]
            held = count_held(new, max(picture["p999"] for picture in stills + moving))
            p999_new, flip_new, _ = worst(new).split(",")
            figures = f"{times},{worst(stills)},{worst(moving)},{p999_new},{flip_new},{len(new)},{held}"
            jod = ",".join(f"{min(picture['jod'] for picture in of):.3f}" for of in (stills, moving, new))
            plan, values = price[f"{path.stem} {tier}"]
            print(f"{path.stem},{tier},{figures},{plan},{jod},{measured['display']},{where},{values}")


def change(change_row):
    """Writes the table with changed rows."""
    with TABLE.open() as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        change_row(row)
    with TABLE.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def times(folder):
    """New times for the table, whose errors stay."""
    price = prices()

    def change_row(row):
        name, tier = row["pipeline"], row["tier"]
        row["ms_4k"], row["ms_1080p"] = (milliseconds(folder, name, tier, size) for size in SIZES)
        row["mb_4k"], row["operations"] = price[f"{name} {tier}"][0].split(",")

    change(change_row)


def new(folder):
    """New pictures for the table, whose claims stay."""

    def change_row(row):
        path = folder / f"{row['pipeline']}.new.json"
        if path.exists():
            pictures = dict(tiers(json.loads(path.read_text())))[row["tier"]]["images"]
            row["p999_new"], row["flip_new"], _ = worst(pictures).split(",")
            row["new"] = len(pictures)
            row["held"] = count_held(pictures, max(float(row["p999"]), float(row["p999_moving"])))
            row["jod_new"] = f"{min(picture['jod'] for picture in pictures):.3f}"

    change(change_row)


def worse(folders):
    """More images count: the worst of each figure is that of the table and of theirs."""

    def change_row(row):
        paths = [path for folder in folders for path in folder.glob(f"{row['pipeline']}.*json")]
        count = 0
        for path in paths:
            stills, moving = next(of for tier, *of in by_motion(json.loads(path.read_text())) if tier == row["tier"])
            count += len(stills) + len(moving)
            for pictures, of, worst_on in ((stills, "", "worst_on"), (moving, "_moving", "worst_moving")):
                if pictures:
                    p999, flip, name = worst(pictures).split(",")
                    if float(p999) > float(row[f"p999{of}"]):
                        row[f"p999{of}"], row[worst_on] = p999, name
                    row[f"flip{of}"] = max(row[f"flip{of}"], flip, key=float)
                    jod = min(picture["jod"] for picture in pictures)
                    row[f"jod{of}"] = f"{min(float(row[f'jod{of}']), jod):.3f}"
        if count:
            row["on"] += f" and {count} more"

    change(change_row)


def names(path):
    """The tiers of a measurement, or of its pipeline in the table if nothing was measured."""
    if path.exists():
        of_pipeline = [name for name, _ in tiers(json.loads(path.read_text()))]
    else:
        with TABLE.open() as file:
            of_pipeline = [row["tier"] for row in csv.DictReader(file) if row["pipeline"] == path.stem]
    return [name for name in of_pipeline if name != "as written"]


def claims():
    sections = {}
    for row in csv.DictReader(TABLE.open()):
        if row["tier"] != "as written":
            p999, flip = (max(float(row[of]), float(row[f"{of}_moving"])) for of in ("p999", "flip"))
            p999, flip = claimed_codes(p999), max(MARGIN * flip, flip + LEAST_FLIP)
            # A picture that has changed has not been judged on the new ones.
            on = row["on"] + (f"; codes held on {row['held']} of {row['new']} new ones" if row["held"] else "")
            jod = min(float(row["jod"]), float(row["jod_moving"]))
            jod = min(NO_DIFFERENCE - MARGIN * (NO_DIFFERENCE - jod), jod - LEAST_JOD)
            errors = f"jod: {jod:.3f}, p999: {p999:.2f}, flip: {flip:.3f}, for: {json.dumps(row['display'])}"
            time = f"ms: {row['ms_4k']}, " if row["ms_4k"] else ""
            figures = f"{time}{errors}, on: {json.dumps(on)}"
            sections[row["pipeline"]] = sections.get(row["pipeline"], "") + f'        "{row["tier"]}": Claim({figures}),\n'
    for name, section in sections.items():
        file = ROOT / f"pipelines/{name}.ron"
        text = re.sub(r"    claims: \{\n(?:        .*\n)*    \},\n", "", file.read_text())
        file.write_text(text.removesuffix(")\n") + f"    claims: {{\n{section}    }},\n)\n")


command, *rest = sys.argv[1:]
if command == "names":
    print(" ".join(names(Path(*rest))))
elif command == "table":
    table(Path(rest[0]), rest[1])
elif command == "times":
    times(Path(*rest))
elif command == "worse":
    worse([Path(folder) for folder in rest])
elif command == "new":
    new(Path(*rest))
else:
    claims()
