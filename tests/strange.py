"""Runs the program on strange files, names and options that `tests/hostile.sh` does not have:

    target/oracles/venv/bin/python tests/strange.py target/debug/afterimage 2000 --seed 1

The packages are those of `tests/oracles.sh`. Each run has a folder of its own with the same few inputs, of which one is
made strange, or whose name is, or the command line. A fault is a panic, a signal, more than 20 seconds, an input that
has changed, a failure without an error, a status other than 0, 1 and 2, a control character, or a line that a name has
forged. Prints the faults, and how often each kind of message came first, to be read by somebody."""

import argparse
import collections
import hashlib
import os
import random
import re
import shutil
import struct
import subprocess
import tempfile
import zlib

import numpy
import OpenEXR
from PIL import Image

EVIL = ["\x1b[8m", "\r", "\n", "\u202e", "\u2066x", "\x9b2J", "\x7f", "openjd_fail: x\n", "é" * 60, "'", '"', "%s", "{}",
        "####", "#", "%04d", " ", ".", "..", "a" * 240, "\\", "$HOME", "*", "?", "\U0001f4a5", "=", ",", "\ud8ff", "-"]
NUMBERS = ["0", "-1", "-0", "1e999", "NaN", "inf", "1e-45", "4294967296", "18446744073709551616", "0x10", "", " 1", "+1",
           "1_0", "٣", "1.5", "999999999", "1,5", "3/2", "16x0", "0x0", "1x99999", "-1x5", "1-0", "0-", "1-4294967295",
           "4294967295-4294967295", "1-9x0", "1-9x-1", "1,1,1", "5-1", "#", "*", "1K", "9E", "0.0001", "half"]
OPTIONS = ["--size", "--frames", "--fps", "--cut", "--preroll", "--crop", "--quality", "--scale", "--slices", "--memory",
           "--gpu-memory", "--depth", "--alpha", "--compression", "--output-space", "--input-space", "--set", "--fact",
           "--tier", "--missing", "--window", "--resize", "--plan", "--input", "--output", "--meter", "--json", "--chunk"]
FILES = ["p.ron", "in.exr", "in.png", "in.jpg", "s.0001.exr", "look.cube", "kinds/tint/tint.wgsl", "new.png", ".",
         "link.exr", "./in.exr", "kinds/../in.exr", "s.0002.exr", "s.####.exr", "kinds/tint/node.ron"]
PIPELINE = """Pipeline(
    inputs: { "scene": Color },
    facts: { "night": "whether it is dark" },
    nodes: {
        "counted": Histogram(source: "scene"),
        "metered": AutoExposure(histogram: "counted"),
        "exposed": Exposure(source: "scene", meter: "metered"),
        "graded": ColorLut(source: "mapped", file: "look.cube"),
        "mapped": Encode(source: "curve", transfer: Srgb),
        "curve": ToneMap(source: "exposed"),
    },
    outputs: { "display": "graded", "light": "exposed" },
    tiers: { "low": { "curve.curve": Reinhard } },
)"""
NODE = """Kind(name: "Tint", doc: "Tints.", inputs: { "source": Image(doc: "The image.") },
    outputs: { "result": Image(doc: "The image.", state: Same("source")) })"""
TEXTS = {"p.ron": PIPELINE, "look.cube": "LUT_3D_SIZE 2\n" + "".join(f"{i & 1} {i >> 1 & 1} {i >> 2}\n" for i in range(8)),
         "kinds/tint/node.ron": NODE, "kinds/tint/tint.wgsl": "fn tint(source: vec4f) -> vec4f { return source; }"}
RENDER = ["render", "p.ron", "in.exr", "-o", "out.png"]
SEQUENCE = ["render", "p.ron", "s.####.exr", "-o", "o.####.png"]
METER = ["meter", "p.ron", "s.####.exr", "-o", "m.meter"]
FOREIGN = [(b"gAMA", 4), (b"cICP", 4), (b"cHRM", 32), (b"sBIT", 3), (b"pHYs", 9), (b"tEXt", 30), (b"eXIf", 40), (b"acTL", 8),
           (b"tRNS", 5), (b"iCCPa\0\0", 20), (b"PLTE", 7), (b"bKGD", 2), (b"mDCV", 24), (b"cLLI", 8), (b"xxXx", 0)]


def write(path, data):
    with open(path, "wb") as file:
        file.write(data)


def exr(path, channels, attributes):
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, **attributes}
    OpenEXR.File(header, channels).write(path)


def make_inputs(folder):
    pixels = (numpy.arange(16 * 16 * 3) % 97 / 48).reshape(16, 16, 3)
    exr(f"{folder}/in.exr", {"RGB": pixels.astype("float16")}, {})
    for number in range(1, 4):
        shutil.copy(f"{folder}/in.exr", f"{folder}/s.{number:04}.exr")
    codes = Image.fromarray((pixels * 127).astype("uint8"))
    codes.save(f"{folder}/in.png")
    codes.save(f"{folder}/in.jpg", quality=90)
    os.makedirs(f"{folder}/kinds/tint")
    for name, text in TEXTS.items():
        write(f"{folder}/{name}", text.encode())


def damaged(data, rng, spans):
    """The spans of some bytes, of which some are doubled, dropped or swapped, or have other contents."""
    parts = [bytearray(data[begin:end]) for begin, end in spans]
    for _ in range(rng.randint(1, 3)):
        at, other, what = rng.randrange(len(parts)), rng.randrange(len(parts)), rng.randrange(5)
        if what == 0:
            parts.insert(other, bytearray(parts[at]))
        elif what == 1 and len(parts) > 2:
            del parts[at]
        elif what == 2:
            parts[at], parts[other] = parts[other], parts[at]
        elif parts[at]:
            parts[at][rng.randrange(len(parts[at]))] = rng.choice([0, 1, 127, 128, 255, rng.randrange(256)])
    return parts


def png(rng, folder):
    data = open(f"{folder}/in.png", "rb").read()
    spans, at = [], 8
    while at < len(data):
        end = at + 8 + struct.unpack_from(">I", data, at)[0]
        spans.append((at + 4, end))
        at = end + 4
    parts = damaged(data, rng, spans)
    kind, length = rng.choice(FOREIGN)
    parts.insert(rng.randint(0, len(parts)), kind + rng.randbytes(length))
    chunks = (struct.pack(">I", max(len(part) - 4, 0)) + part + struct.pack(">I", zlib.crc32(part)) for part in parts)
    write(f"{folder}/in.png", data[:8] + b"".join(chunks))
    return "in.png"


def jpeg(rng, folder):
    Image.open(f"{folder}/in.png").save(f"{folder}/in.jpg", progressive=rng.random() < 0.5, exif=rng.randbytes(20),
                                       subsampling=rng.randrange(3), restart_marker_rows=rng.randrange(2))
    data = open(f"{folder}/in.jpg", "rb").read()
    marks = [match.start() for match in re.finditer(rb"\xff[^\x00\xff]", data)] + [len(data)]
    write(f"{folder}/in.jpg", b"".join(damaged(data, rng, list(zip(marks, marks[1:])))))
    return "in.jpg"


def strange_text(rng, most):
    return "".join(rng.choice(EVIL) for _ in range(rng.randint(1, 3)))[:most].replace("\ud8ff", "") or "x"


def openexr(rng, folder):
    """An EXR of OpenEXR with strange names of layers, channels and attributes, and then perhaps a damaged header."""
    plane = numpy.ones((16, 16), dtype=rng.choice(["float16", "float32", "uint32"]))
    names = [rng.choice(["", f"{strange_text(rng, rng.choice([5, 31, 250]))}."]) for _ in range(2)]
    channels = {f"{rng.choice(names)}{channel}": plane for channel in rng.choice(["RGB", "RGBA", "Y", "Z", "RG", "UVW"])}
    values = [1, -1.5, strange_text(rng, 9), (1.0, float("nan")), (1, 2, 3)]
    try:
        exr(f"{folder}/in.exr", channels, {strange_text(rng, 60): rng.choice(values) for _ in range(rng.randrange(4))})
    except Exception:  # The library refuses some of them in ways of its own.
        pass
    data = bytearray(open(f"{folder}/in.exr", "rb").read())
    for _ in range(rng.randrange(3)):
        data[rng.randrange(8, min(len(data), 500))] = rng.randrange(256)
    write(f"{folder}/in.exr", data)
    return "in.exr"


def names(rng, folder):
    words = [rng.choice(["render", "render", "job"]), *RENDER[1:]]
    name, at = (rng.choice(EVIL) + rng.choice(EVIL) + rng.choice([".exr", ".ron", ".png", ""])).replace("/", "_"), rng.randrange(1, 5)
    if at < 3 and len(os.fsencode(name.encode("utf-8", "surrogatepass"))) < 250 and name not in (".", ".."):
        os.rename(f"{folder}/{words[at]}", os.path.join(folder.encode(), name.encode("utf-8", "surrogatepass")))
    words[at] = name
    return words + rng.choice([[], ["--openjd"] if words[0] == "render" else [], ["--json", "r.json"]])


def options(rng, _):
    value = rng.choice([*NUMBERS, *EVIL, f"{rng.choice(['scene', 'curve.curve', 'night', ''])}={rng.choice(NUMBERS + FILES)}"])
    words = rng.choice([RENDER, ["job", *SEQUENCE[1:]], SEQUENCE, METER, ["plan", "p.ron"]])
    return [*words, f"{rng.choice(OPTIONS)}={value}"]


def outputs(rng, folder):
    if rng.random() < 0.5:
        os.symlink(rng.choice(FILES[:9]), f"{folder}/link.exr")
    to, other = rng.choice(FILES), rng.choice(FILES)
    return rng.choice([
        [*SEQUENCE[:4], to, "--json", other, "--nodes", "kinds"], [*RENDER[:4], to, f"--output=light={other}"],
        [*METER[:4], to], ["pipelines", "tsushima-night", "--write", to], ["nodes", "--new", rng.choice(["Tint", "kinds", "In"])],
        ["check", "--fix", to], ["render", "p.ron", to, "-o", to], ["plan", to, "--diff", other]])


def sequences(rng, folder):
    odd = ["s.1.exr", "s.00005.exr", "s.-001.exr", "s.0002.EXR", "s.0001 .exr", "o.0002.png", "s.٠٠٠٤.exr", "s.9999999999.exr"]
    whole = open(f"{folder}/in.exr", "rb").read()
    for name in rng.sample(odd, rng.randrange(5)):
        write(f"{folder}/{name}", rng.choice([b"", b"hello", whole[:rng.randrange(800)]]))
    pattern, to = rng.choice(["s.####.exr", "s.#.exr", "s.%04d.exr", "s.*.exr", "."]), rng.choice(["o.####.png", "o.png", "o.#.exr"])
    more = [[], ["--skip-existing"], ["--keep-going"], ["--missing", "hold"], ["--frames", rng.choice(NUMBERS)]]
    return ["render", "p.ron", pattern, "-o", to, *rng.choice(more)]


def documents(rng, folder):
    text = PIPELINE
    for _ in range(rng.randint(1, 2)):
        word, evil = rng.choice(re.findall(r'"[^"]*"|[A-Z]\w+|[(){},:]', text)), rng.choice(EVIL)
        quoted = evil.replace("\\", "\\\\").replace('"', '\\"')
        other = rng.choice([f'"{quoted}"', rng.choice(NUMBERS), word * 2, "", "Pipeline(", '"a@previous(99)"'])
        text = text.replace(word, other, rng.choice([1, -1]))
    write(f"{folder}/p.ron", text.encode("utf-8", "surrogatepass"))
    return rng.choice([RENDER, ["check", "p.ron", "--plan"], ["check", "--json", "p.ron"], ["plan", "p.ron", "--format", "svg"]])


def meters(rng, folder, program):
    subprocess.run([program, *METER], cwd=folder, capture_output=True)
    data = bytearray(open(f"{folder}/m.meter", "rb").read())
    for _ in range(rng.randrange(4)):
        data[rng.randrange(len(data))] = rng.choice([0, 255, 48 + rng.randrange(10), rng.randrange(256)])
    write(f"{folder}/m.meter", data[:rng.choice([len(data), len(data), rng.randrange(len(data))])])
    return [*SEQUENCE, "--meter", "m.meter", "--frames", rng.choice(["2-3", "3", "1-9"])]


def words_of(kind, rng, folder, program):
    if kind is meters:
        return meters(rng, folder, program)
    words = kind(rng, folder)
    if isinstance(words, str):
        return rng.choice([["render", "p.ron", words, "--output=light=out.exr"], ["info", words, "--pixels"], ["info", "--json", words]])
    return words


def hashes(folder):
    paths = (os.path.join(top, name) for top, _, files in os.walk(os.fsencode(folder)) for name in files)
    return {path: hashlib.sha256(open(path, "rb").read()).digest() for path in paths if os.path.isfile(path)}


def is_kept(path, words):
    """Whether a command may not replace a file, even if an option names it: the command reads it, or makes new files."""
    name = os.fsdecode(os.path.basename(path))
    if words[0] not in ("render", "meter"):
        return "--fix" not in words
    is_frame = name.startswith("s.") and "s.####.exr" in words
    return is_frame or name in ("p.ron", "look.cube", *words[1:3]) or "--nodes" in words and b"/kinds/" in path


def fault(before, after, ended, words):
    text = ended.stdout + ended.stderr
    lost = [path for path, digest in before.items() if after.get(path) != digest and is_kept(path, words)]
    if ended.returncode not in (0, 1, 2) or "panicked at" in text:
        return f"status {ended.returncode}"
    if lost:
        return f"lost {lost}"
    if ended.returncode and not re.search(r'(?m)^(error|openjd_fail)|"severity": "error"', text):
        return "a failure without an error"
    if re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]", text):
        return "a control character"
    return "a forged line" if "openjd_fail: x" in text.splitlines() else None


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("program", type=os.path.abspath)
    arguments.add_argument("count", type=int)
    arguments.add_argument("--seed", type=int, default=1)
    given = arguments.parse_args()
    classes = [png, jpeg, openexr, names, options, meters, outputs, sequences, documents]
    kinds, firsts, faults = collections.Counter(), collections.Counter(), 0
    environment = {**os.environ, "XDG_RUNTIME_DIR": tempfile.gettempdir(), "XDG_CACHE_HOME": tempfile.mkdtemp()}
    for number in range(given.seed * 1_000_000, given.seed * 1_000_000 + given.count):
        with tempfile.TemporaryDirectory() as folder:
            make_inputs(folder)
            rng, kind, ended = random.Random(number), classes[number % len(classes)], None
            words = words_of(kind, rng, folder, given.program)
            before = hashes(folder)
            line = [given.program, *(word.encode("utf-8", "surrogatepass") for word in words)]
            try:
                ended = subprocess.run(line, cwd=folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True,
                                       timeout=20, encoding="utf-8", errors="replace")
                why = fault(before, hashes(folder), ended, words)
            except subprocess.TimeoutExpired:
                why = "more than 20 s"
        kinds[f"{kind.__name__}, status {ended.returncode if ended else None}"] += 1
        lines = (ended.stderr or ended.stdout).splitlines() if ended else []
        firsts[re.sub(r"`[^`]*`|\d+", "_", lines[0] if lines else "")] += 1
        if why:
            faults += 1
            print(f"{number} {kind.__name__}: {why}: {words!r}: {ended and (ended.stderr + ended.stdout)[:300]!r}", flush=True)
    for name, count in [*sorted(kinds.items()), *firsts.most_common()]:
        print(f"{count:6} {ascii(name[:150])}")
    print(f"{given.count} runs, {faults} faults")
    raise SystemExit(faults > 0)


main()
