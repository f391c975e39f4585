"""Runs a template of `afterimage job` as a farm does, and compares its files with those of one run.

run_job.py PROGRAM [--differs] WORDS... `OUT` in the words is the folder of the files.
"""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
import zlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from openjd.model import StepParameterSpaceIterator, create_job, decode_job_template

CHUNK = 7
WORKERS = 3
OPENJD = [str(Path(sys.executable).with_name("openjd"))]


def tasks_of(template):
    """The tasks of each step, in the order of steps: parameters by name."""
    document = json.loads(Path(template).read_text())
    decoded = decode_job_template(template=document, supported_extensions=["TASK_CHUNKING"])
    job = create_job(job_template=decoded, job_parameter_values={})
    steps = {}
    for step in job.steps:
        space = step.parameterSpace
        tasks = StepParameterSpaceIterator(space=space) if space else [{}]
        parameters = [{name: str(value.value) for name, value in task.items()} for task in tasks]
        steps[step.name] = ([needed.dependsOn for needed in step.dependencies or []], parameters)
    return steps


def command_of(template, step, parameters):
    words = [f"{name}={value}" for name, value in parameters.items()]
    given = [word for pair in words for word in ("-tp", pair)]
    return [*OPENJD, "run", template, "--step", step, *given]


def run(template, step, parameters):
    done = subprocess.run(command_of(template, step, parameters), capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{step} {parameters}\n{done.stdout}{done.stderr}")


def descendants(process):
    """The ids of the processes that this one has started, and that those have."""
    parents = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                parents[int(entry.name)] = int(entry.joinpath("stat").read_text().rsplit(")", 1)[1].split()[1])
            except OSError:
                continue
    found = [process]
    for known in found:
        found.extend(child for child, parent in parents.items() if parent == known)
    return found


def kill_midway(template, step, parameters):
    """Starts a task and kills all of its processes once it has written something. How many files it left."""
    out = Path("part")
    before = set(out.iterdir())
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen(command_of(template, step, parameters), **quiet)
    while process.poll() is None and set(out.iterdir()) == before:
        time.sleep(0.002)
    if process.poll() is not None:
        sys.exit(f"{step} {parameters} has ended before it was killed")
    for each in descendants(process.pid):
        os.kill(each, signal.SIGKILL)
    process.wait()
    return len(set(out.iterdir()) - before)


def run_all(template):
    """Runs all tasks as their dependencies allow, in random order. What was done, in words."""
    steps = tasks_of(template)
    order = random.Random(7)
    (done, killed, tasks) = (set(), None, 0)
    while len(done) < len(steps):
        ready = [name for name in steps if name not in done and set(steps[name][0]) <= done]
        batch = [(name, task) for name in ready for task in steps[name][1]]
        order.shuffle(batch)
        tasks += len(batch)
        (step, parameters) = batch[0]
        if killed is None and step != "Meter":
            killed = f"one of `{step}` killed after {kill_midway(template, step, parameters)} of its files"
        with ThreadPoolExecutor(WORKERS) as workers:
            list(workers.map(lambda task: run(template, *task), batch))
        done |= set(ready)
    return f"{len(steps)} steps, {tasks} tasks, {killed} and run again"


def pixels(path):
    """The bytes of a PNG without interlacing, and the number of those that are a channel."""
    data = path.read_bytes()
    (at, packed) = (8, b"")
    while at < len(data):
        (length, kind) = (int.from_bytes(data[at : at + 4], "big"), data[at + 4 : at + 8])
        body = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            (width, depth, channels) = (int.from_bytes(body[:4], "big"), body[8], {0: 1, 2: 3, 4: 2, 6: 4}[body[9]])
        packed += body if kind == b"IDAT" else b""
        at += 12 + length
    assert depth == 8
    (row, raw) = (width * channels, zlib.decompress(packed))
    (before, result) = (bytearray(row), bytearray())
    for start in range(0, len(raw), row + 1):
        (method, line) = (raw[start], bytearray(raw[start + 1 : start + 1 + row]))
        for i in range(row):
            left = line[i - channels] if i >= channels else 0
            corner = before[i - channels] if i >= channels else 0
            line[i] = (line[i] + predicted(method, left, before[i], corner)) & 255
        result += line
        before = line
    return result


def predicted(method, left, above, corner):
    if method < 4:
        return [0, left, above, (left + above) // 2][method]
    guess = left + above - corner
    return min((left, above, corner), key=lambda value: abs(guess - value))


def compare(differs):
    names = sorted(path.name for path in Path("whole").iterdir())
    unequal = [name for name in names if Path("whole", name).read_bytes() != Path("part", name).read_bytes()]
    if not unequal:
        return f"{len(names)} files equal byte for byte"
    if not differs:
        sys.exit(f"{len(unequal)} of {len(names)} files differ, {unequal[0]} first")
    (most, count, total) = (0, 0, 0)
    for name in names:
        pairs = zip(pixels(Path("whole", name)), pixels(Path("part", name)), strict=True)
        codes = [abs(a - b) for a, b in pairs]
        (most, count, total) = (max(most, *codes), count + sum(code > 0 for code in codes), total + len(codes))
    return f"{len(unequal)} of {len(names)} files differ, by {most} codes at most in {count} of {total} values"


def main():
    (program, *words) = sys.argv[1:]
    differs = words[0] == "--differs"
    words = words[differs:]
    for folder in ("whole", "part"):
        shutil.rmtree(folder, ignore_errors=True)
        os.mkdir(folder)
    (whole, part) = ([word.replace("OUT", folder) for word in words] for folder in ("whole", "part"))
    # The frames before a chunk are for tasks only.
    alone = whole[: whole.index("--preroll")] if differs else whole
    start = time.monotonic()
    subprocess.run([program, "render", *alone], check=True, capture_output=True)
    (single, start) = (time.monotonic() - start, time.monotonic())
    printed = subprocess.run([program, "job", *part, "--chunk", str(CHUNK)], check=True, capture_output=True, text=True)
    Path("job.json").write_text(printed.stdout)
    subprocess.run([*OPENJD, "check", "job.json"], check=True, capture_output=True)
    done = run_all("job.json")
    seconds = time.monotonic() - start
    extra = f" --preroll {words[-1]}" if differs else ""
    times = f"{single:.1f} s in one run, {seconds:.1f} s in tasks"
    print(f"{words[0]}{extra}: {done}: {compare(differs)}; {times}", flush=True)


main()
