#!/usr/bin/env python3
"""The order of variants by JOD against that of other judges: tests/motion/judge.py PROGRAM PHOTOGRAPHS FOLDER [NAME...]

Renders the seven sequences of `footage.py` through the tiers of four pipelines, and through variants that are known to
be bad in motion, and judges each against the most accurate variant with intermediates of 32 bits:

* JOD, FLIP and codes by `measure`;
* JOD by its authors' cvvdp, of the frames as they are written;
* NVIDIA's FLIP over time by flip-evaluator: the mean of all frames, and that of the worst frame;
* FLIP of changes: of the differences of neighboring frames, about middle gray, so that it sees what flickers;
* what the reference has of VMAF 0.6.1 beyond the variant, by the ffmpeg of imageio-ffmpeg: trained on what people say
  of films.

Writes graph/docs/measurements/judges.csv, prints correlations of ranks, and the pairs of variants of which JOD says the
opposite. The worst frame of each variant lies in FOLDER/pictures: reference, variant, FLIP. CGVQM cannot be had: its
repository has the weights of its layers, but the network below them, r3d_18, is on a server of PyTorch.

Names are those of pipelines and sequences: only these are judged, and the other rows of the table stay.

Needs numpy, scipy, opencv-python-headless, OpenEXR, flip-evaluator, imageio-ffmpeg and cvvdp (pip). Takes twenty
minutes on one core. Renders that are in FOLDER are kept.
"""

import csv
import itertools
import json
import subprocess
import sys
from pathlib import Path

import cv2
import flip_evaluator
import imageio_ffmpeg
import numpy
import pycvvdp
from scipy.stats import kendalltau, spearmanr

import footage

ROOT = Path(__file__).parent.parent.parent
TABLE = ROOT / "graph/docs/measurements/judges.csv"
# Output, and tiers beside those of the pipeline: faults that motion shows, and faults that it hides.
HELD = '"bloom.every": 3'
PIPELINES = {
    "lynx": ("display", {"held": HELD, "one-read": '"bloom.filter": Bilinear', "weak": '"lit.strength": 0.13'}),
    "tsushima": ("display", {"held": HELD, "one-read": '"bloom.filter": Bilinear', "no-halos": '"local.span": 5.0'}),
    "mobile": ("display", {"held": HELD, "edges": '"smooth": Off'}),
    "hdr": ("sdr", {"held": HELD, "late-meter": '"bins.every": 4'}),
}
# Larger is better.
JUDGES = {"jod": 1, "jod_original": 1, "flip": -1, "flip_worst": -1, "flip_changes": -1, "vmaf_lost": -1}


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")


def with_tiers(folder, name):
    """A file with the pipeline and more tiers; returns it with the names of all that are judged."""
    tiers = "".join(f'        "{tier}": {{ {entries} }},\n' for tier, entries in PIPELINES[name][1].items())
    path = folder / f"{name}.ron"
    path.write_text(f'Pipeline(\n    extends: "{ROOT / "pipelines" / name}.ron",\n    tiers: {{\n{tiers}    }},\n)\n')
    return path


def frames(pattern, count):
    """Frames with numbers from 0 to 1."""
    paths = [str(pattern).replace("####", f"{number:04}") for number in range(count)]
    return [cv2.imread(path, cv2.IMREAD_UNCHANGED)[..., :3][..., ::-1] / numpy.float32(65535) for path in paths]


def flip(reference, shown):
    pair = (numpy.ascontiguousarray(frame) for frame in (reference, shown))
    return flip_evaluator.evaluate(*pair, "LDR", applyMagma=False)[0]


def original(cvvdp, reference, shown):
    """JOD by ColorVideoVDP itself."""
    pair = (numpy.stack(frames) for frames in (shown, reference))
    return float(cvvdp.predict(*pair, dim_order="FHWC", frames_per_second=24)[0])


def changes(frames):
    """What changes from frame to frame, about the middle of the range."""
    return [0.5 + 0.5 * (after - before) for before, after in itertools.pairwise(frames)]


def vmaf(reference, shown, log):
    """The harmonic mean of VMAF over the frames, as libvmaf pools it."""
    inputs = [word for pattern in (shown, reference) for word in ("-i", str(pattern).replace("####", "%04d"))]
    graph = f"[0:v]format=yuv444p10le[a];[1:v]format=yuv444p10le[b];[a][b]libvmaf=log_fmt=json:log_path={log}"
    run(imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", *inputs, "-lavfi", graph, "-f", "null", "-")
    return json.loads(log.read_text())["pooled_metrics"]["vmaf"]["harmonic_mean"]


def picture(path, reference, shown, error):
    """The worst frame, its reference and its error side by side."""
    heat = cv2.applyColorMap(numpy.uint8(255 * error.squeeze().clip(0, 1)), cv2.COLORMAP_MAGMA)
    both = numpy.uint8(255 * numpy.concatenate([reference, shown], 1) + 0.5)[..., ::-1]
    cv2.imwrite(str(path), numpy.concatenate([both, heat], 1))


def named(known, names):
    """What is named of the known, or all of it."""
    return {name: of for name, of in known.items() if name in names} or known


def judged(program, photographs, folder, names):
    """A row for each variant on each sequence."""
    patterns = named(footage.all_patterns(program, photographs, folder / "footage"), names)
    (folder / "pictures").mkdir(exist_ok=True)
    # The display of `desk`.
    cvvdp = pycvvdp.cvvdp(display_name="standard_4k", quiet=True)
    for name, (output, _) in named(PIPELINES, names).items():
        path, report = with_tiers(folder, name), folder / f"{name}.json"
        allow = ["--allow", ROOT / "pipelines"]
        if not report.exists():
            run(program, "measure", path, *patterns.values(), "--tiers", "--repeats", "1", "--json", report, *allow)
        tiers = {row["variant"].removeprefix("tier "): row for row in json.loads(report.read_text())["rows"]}
        for at, (sequence, pattern) in enumerate(patterns.items()):

            def rendered(tier, *more):
                shown = folder / "shown" / f"{name}-{tier}-{sequence.replace(' ', '-')}.####.png"
                shown.parent.mkdir(exist_ok=True)
                if not Path(str(shown).replace("####", f"{footage.FRAMES - 1:04}")).exists():
                    wanted = ["--depth", "16", "--alpha", "drop", "--output", f"{output}={shown}"]
                    run(program, "render", path, pattern, *wanted, *allow, *more)
                return shown

            exact = rendered("exact", "--tier", "ultra", "--exact")
            reference = frames(exact, footage.FRAMES)
            # It depends on the sequence, and is no 100.
            most = vmaf(exact, exact, folder / "vmaf.json")
            for tier, row in tiers.items():
                if row["kind"] != "tier":
                    continue
                shown = rendered(tier, "--tier", tier)
                seen = frames(shown, footage.FRAMES)
                maps = [flip(one, other) for one, other in zip(reference, seen)]
                means = [float(one.mean()) for one in maps]
                worst = int(numpy.argmax(means))
                name_of_worst = f"{shown.name[:-9]}-{worst}.png"
                picture(folder / "pictures" / name_of_worst, reference[worst], seen[worst], maps[worst])
                of_changes = [float(flip(*pair).mean()) for pair in zip(changes(reference), changes(seen))]
                figures = row["images"][at]
                yield {
                    "pipeline": name,
                    "variant": tier,
                    "sequence": sequence,
                    "jod": f"{figures['jod']:.4f}",
                    "jod_original": f"{original(cvvdp, reference, seen):.4f}",
                    "p999": f"{figures['p999']:.3f}",
                    "flip": f"{numpy.mean(means):.5f}",
                    "flip_worst": f"{max(means):.5f}",
                    "flip_changes": f"{numpy.mean(of_changes):.5f}",
                    "vmaf_lost": f"{most - vmaf(exact, shown, folder / 'vmaf.json'):.3f}",
                }


def orders(rows):
    """The figures of each judge, larger for better."""
    return {judge: numpy.array([sign * float(row[judge]) for row in rows]) for judge, sign in JUDGES.items()}


def agreement(rows, title):
    of = orders(rows)
    print(f"{title}: {len(rows)}")
    for judge in list(JUDGES)[1:]:
        rho, tau = (rank(of["jod"], of[judge]).statistic for rank in (spearmanr, kendalltau))
        print(f"  jod and {judge}: Spearman {rho:.3f}, Kendall {tau:.3f}")


def disagreements(rows):
    """Pairs of the same sequence that JOD orders otherwise than each other judge, those of the largest ranks first."""
    ranks = {judge: figures.argsort().argsort() for judge, figures in orders(rows).items()}
    for judge in list(JUDGES)[1:]:
        pairs = []
        for one, other in itertools.combinations(range(len(rows)), 2):
            steps = [int(ranks[of][one] - ranks[of][other]) for of in ("jod", judge)]
            if rows[one]["sequence"] == rows[other]["sequence"] and steps[0] * steps[1] < 0:
                pairs.append((min(map(abs, steps)), one, other))
        print(f"{judge} says the opposite of {len(pairs)} pairs; the clearest:")
        for _, one, other in sorted(pairs, reverse=True)[:8]:
            if float(rows[one]["jod"]) < float(rows[other]["jod"]):
                one, other = other, one
            better, worse = (
                f"{row['pipeline']} {row['variant']} ({row['jod']} JOD, {judge} {row[judge]})"
                for row in (rows[one], rows[other])
            )
            print(f"  {rows[one]['sequence']}: {better} before {worse}")


def joined(rows):
    """The rows of the table with these in place of those of the same names."""
    key = lambda row: (row["pipeline"], row["variant"], row["sequence"])
    with TABLE.open() as file:
        table = {key(row): row for row in csv.DictReader(file)}
    return list({**table, **{key(row): row for row in rows}}.values())


def main():
    program, photographs, folder, names = sys.argv[1], sys.argv[2], Path(sys.argv[3]).resolve(), sys.argv[4:]
    folder.mkdir(parents=True, exist_ok=True)
    rows = list(judged(str(Path(program).resolve()), photographs, folder, names))
    table = joined(rows) if names else rows
    with TABLE.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)
    agreement(rows, "all variants on all sequences")
    # What nobody sees has no order: ties within a hundredth of a JOD are chance.
    agreement([row for row in rows if float(row["jod"]) < 9.99], "those below 9.99 JOD")
    for sequence in dict.fromkeys(row["sequence"] for row in rows):
        agreement([row for row in rows if row["sequence"] == sequence], sequence)
    # One order of variants: each at its worst.
    keys = dict.fromkeys((row["pipeline"], row["variant"]) for row in rows)
    worst = []
    for pipeline, variant in keys:
        of = [row for row in rows if (row["pipeline"], row["variant"]) == (pipeline, variant)]
        figures = {judge: sign * min(sign * float(row[judge]) for row in of) for judge, sign in JUDGES.items()}
        worst.append({"pipeline": pipeline, "variant": variant, **figures})
    agreement(worst, "variants at their worst")
    for row in sorted(worst, key=lambda row: row["jod"]):
        print("  " + " ".join(str(cell) for cell in row.values()))
    disagreements(rows)


if __name__ == "__main__":
    main()
