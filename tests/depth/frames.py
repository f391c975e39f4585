"""Frames of Blender's Cycles as files: reading, and what has to be written in other units for Afterimage."""
import glob, json, os, re

import numpy as np
import OpenEXR

NEAR, FAR = 0.1, 60.0  # of the sun's depth map


def channels(path, part, names):
    """Channels of a part, one after the other; `part` may be the end of its name."""
    for found in OpenEXR.File(path, separate_channels=True).parts:
        if part is None or found.name().endswith(part):
            every = {name.split(".")[-1]: np.array(value.pixels, np.float32) for name, value in found.channels.items()}
            return np.stack([every[name] for name in names], -1)
    raise SystemExit(f"{path} has no part {part}")


def write(path, planes):
    """An image of floats, with zeros for channels that are not given."""
    zeros = np.zeros_like(planes[0])
    rgb = dict(zip("RGB", [np.ascontiguousarray(plane, np.float32) for plane in (*planes, zeros, zeros)]))
    OpenEXR.File({"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION}, rgb).write(path)


def numbers(folder, name):
    """The frames of a sequence, in order."""
    found = glob.glob(os.path.join(folder, f"{name}.*.exr"))
    return sorted(int(re.search(r"\.(\d+)\.exr$", path)[1]) for path in found)


def at(folder, name, frame, extension="exr"):
    return os.path.join(folder, f"{name}.{frame:04d}.{extension}")


def camera(folder, frame):
    with open(at(folder, "camera", frame, "json")) as file:
        return json.load(file)


def write_cameras(folder, out, frame):
    """`steady`, `jittered` for aliased frames, and the sun's `light`. Jitter is downwards, depth from 0 to 1."""
    data, before = camera(folder, frame), camera(folder, max(frame - 1, 1))
    matrices = {name: data[name] for name in ("view", "projection")}
    matrices |= {"previous_view": before["view"], "previous_projection": before["projection"]}
    jitter = {name: [of["jitter"][0], -of["jitter"][1]] for name, of in [("jitter", data), ("previous_jitter", before)]}
    scale, depth = 2 / data["light_scale"], FAR - NEAR
    light = [[scale, 0, 0, 0], [0, scale, 0, 0], [0, 0, -1 / depth, -NEAR / depth], [0, 0, 0, 1]]
    lamp = {"view": data["light_view"], "projection": light}
    for name, content in [("steady", matrices), ("jittered", matrices | jitter), ("light", lamp)]:
        with open(at(out, name, frame, "json"), "w") as file:
            json.dump(content, file)


def prepare(folder, out):
    """Writes what is in other units: motion in pixels downwards since the frame before, the depth map from 0 to 1."""
    for frame in numbers(folder, "beauty"):
        write_cameras(folder, out, frame)
        way = channels(at(folder, "beauty", frame), "Vector", "XY")  # to the frame before, upwards
        write(at(out, "motion", frame), [-way[..., 0], way[..., 1]])
    for frame in numbers(folder, "light"):
        distance = channels(at(folder, "light", frame), "Depth", "Z")[..., 0]
        write(at(out, "map", frame), [np.clip((distance - NEAR) / (FAR - NEAR), 0, 1)])
