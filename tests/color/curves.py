#!/usr/bin/env python3
"""Compares tone curves, run by the program, with the GLSL of published packages. Optional: no test needs it.

    python3 -m venv v && v/bin/pip install wgpu numpy openexr colour-science opencolorio scipy opencv-python-headless
    npm pack glsl-tone-map@2.0.1 three@0.180.0
    cargo build --release
    v/bin/python tests/color/curves.py target/release/afterimage FOLDER_OF_THE_PACKAGES

The GLSL runs by wgpu. Differences are absolute, of display-linear light from 0 to 1, for light from 2^-9 to 2^5 per
channel. Both sides compute in 32 bits. AgX is compared on grays, where the matrices of three.js, which are for Rec.2020, have no effect.
"""

import re
import sys
import tarfile
from pathlib import Path

import numpy as np
import operators
import wgpu

SHADER = """#version 450
layout(local_size_x = 64) in;
layout(set = 0, binding = 0) buffer Colors {{ vec4 colors[]; }};
{functions}
void main() {{
    uint i = gl_GlobalInvocationID.x;
    colors[i] = vec4({call}, 1.0);
}}
"""


def member(folder, package, path):
    """A file of a package."""
    (archive,) = folder.glob(f"{package}-*.tgz")
    with tarfile.open(archive) as files:
        return files.extractfile(f"package/{path}").read().decode()


def functions(text, *names):
    """The GLSL functions on vectors with these names, in their order in the text."""
    found = re.findall(r"^vec3 (\w+)\([^)]*\) \{.*?^\}", text, re.M | re.S)
    bodies = re.finditer(r"^vec3 (\w+)\([^)]*\) \{.*?^\}", text, re.M | re.S)
    missing = set(names) - set(found)
    assert not missing, missing
    return "\n".join(body.group(0) for body in bodies if body.group(1) in names)


def evaluated(source, call, pixels):
    """What GLSL makes of colors."""
    device = wgpu.gpu.request_adapter_sync().request_device_sync()
    code = SHADER.format(functions=source, call=call)
    module = device.create_shader_module(label="comp", code=code)
    data = np.concatenate([pixels, np.ones((len(pixels), 1))], axis=1).astype(np.float32)
    usage = wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC
    buffer = device.create_buffer_with_data(data=data.tobytes(), usage=usage)
    pipeline = device.create_compute_pipeline(layout="auto", compute={"module": module, "entry_point": "main"})
    group = device.create_bind_group(
        layout=pipeline.get_bind_group_layout(0), entries=[{"binding": 0, "resource": {"buffer": buffer}}]
    )
    encoder = device.create_command_encoder()
    compute = encoder.begin_compute_pass()
    compute.set_pipeline(pipeline)
    compute.set_bind_group(0, group)
    compute.dispatch_workgroups(len(pixels) // 64)
    compute.end()
    device.queue.submit([encoder.finish()])
    return np.frombuffer(device.queue.read_buffer(buffer), np.float32).reshape(-1, 4)[:, :3].astype(float)


def cases(folder):
    """Curve, package, GLSL, its call, and whether only grays are compared."""
    for curve, name in [
        ("Reinhard", "reinhard"),
        ("ReinhardExtended", "reinhard2"),
        ("AcesNarkowicz", "aces"),
        ("Uchimura", "uchimura"),
        ("Hable", "uncharted2"),
    ]:
        text = member(folder, "glsl-tone-map", f"{name}.glsl")
        names = {"uncharted2": ("uncharted2Tonemap", "uncharted2")}.get(name, (name,))
        yield curve, "glsl-tone-map 2.0.1", functions(text, *names), f"min({name}(colors[i].rgb), vec3(1.0))", False
    text = member(folder, "three", "src/renderers/shaders/ShaderChunk/tonemapping_pars_fragment.glsl.js")
    text = text.replace("toneMappingExposure", "1.0")
    hill = "#define saturate(a) clamp(a, 0.0, 1.0)\n" + functions(text, "RRTAndODTFit", "ACESFilmicToneMapping")
    # three.js divides the light by 0.6.
    yield "AcesHill", "three.js 0.180", hill, "ACESFilmicToneMapping(0.6 * colors[i].rgb)", False
    neutral = functions(text, "NeutralToneMapping")
    yield "KhronosNeutral", "three.js 0.180", neutral, "NeutralToneMapping(colors[i].rgb)", False
    constants = "\n".join(re.findall(r"^const mat3 LINEAR_\w+ = mat3\(.*?^\);", text, re.M | re.S))
    agx = constants + "\n" + functions(text, "agxDefaultContrastApprox", "AgXToneMapping")
    call = "clamp(AgXToneMapping(colors[i].rgb), 0.0, 1.0)"
    yield "AgX", "three.js 0.180, a polynomial", agx, call, True


def main(folder):
    space = {"AcesHill", "KhronosNeutral", "AgX"}
    print("| operator | reference | largest difference |\n|---|---|---|")
    for curve, package, source, call, is_gray in cases(folder):
        pixels = operators.grays() if is_gray else operators.light(-9, 5)
        rest = "" if curve in space else ", space: Rec709"
        node = f"ToneMap(curve: {curve}{rest}, middle_gray: Native, keep_hue: 0.0, gamut: Clip)"
        off = np.abs(operators.run("Exposed", node, pixels) - evaluated(source, call, pixels)).max()
        grays = ", grays" if is_gray else ""
        print(f"| `ToneMap(curve: {curve})`{grays} | {package} | {off:.1e} |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    operators.PROGRAM = str(Path(sys.argv[1]).resolve())
    main(Path(sys.argv[2]))
