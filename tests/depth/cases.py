"""What is compared: for each case a reference of Cycles, and pipelines without the nodes and with them."""
from dataclasses import dataclass, field

COLOR = "ViewLayer.Combined"
# Colors are compared as a display shows them: the same exposure and curve for the reference and for the result.
VIEW = '"exposed": Exposure(source: "%s", stops: 0.0), "view": ToneMap(source: "exposed"),'
LENS = "amount: 3.33333, f_stop: 0.5, focal_length: 35.0, focus: 5.0, sensor: 20.25, largest: 0.1, blades: 6,"


@dataclass
class Case:
    title: str
    source: str  # the frames that the nodes get
    reference: str  # the frames that they should come to
    settings: dict  # the nodes, by a name for the table; the last node is named `made`
    files: dict = field(default_factory=dict)  # inputs by name: the type, and the file


def occlusion(more, kind="Gtao", radius="radius: 1.0, falloff: 0.3"):
    ports = 'source: "gray", depth: "depth", camera: "camera"'
    return f'"gray": DemoScene(), "made": {kind}({ports}, {more} {radius}),'


def points(more):
    return occlusion(more, "Ssao", "radius: 1.0")


def shadow(more):
    ports = 'source: "source", depth: "depth", camera: "camera", map: "map", light: "light",'
    return f'"made": ShadowMask({ports} {more}),'


def lens(more="", name="made"):
    return f'"{name}": DepthOfField(source: "source", depth: "depth", {LENS} {more}),'


def blur(source="source", more='motion: "motion", unit: Pixels,'):
    ports = f'source: "{source}", depth: "depth", camera: "camera"'
    return f'"made": MotionBlur({ports}, {more} shutter: 180.0, largest: 0.1),'


def over_time(more='motion: "motion", unit: Pixels,', name="made"):
    kept = '"linear": LinearDepth(depth: "depth", camera: "camera", encoding: Distance),'
    ports = 'source: "source", depth: "linear", camera: "camera", previous_depth: "linear@previous"'
    return f'{kept} "{name}": Taa({ports}, history: "{name}@previous", {more}),'


def shown(node):
    """A node that works on finished images."""
    return VIEW % "source" + node % "view"


DEPTH = {"depth": ("Depth", "{folder}/beauty.####.exr#ViewLayer.Depth")}
NORMAL = {"normal": ("Normals", "{folder}/beauty.####.exr#ViewLayer.Normal")}
MOTION = {"motion": ("Motion", "{out}/motion.####.exr")}
STEADY = {"camera": ("Camera", "{out}/steady.####.json")}
JITTERED = {"camera": ("Camera", "{out}/jittered.####.json")}
LIGHT = {"map": ("Depth", "{out}/map.####.exr"), "light": ("Camera", "{out}/light.####.json")}
WORLD = 'normal: "normal", space: World,'
WIDE = " angular_diameter: 6.0,"

CASES = [
    Case(
        "Gtao",
        None,
        "beauty",
        {
            "the defaults, with normals": occlusion(WORLD),
            "normals from the depth": occlusion(""),
            "4 slices, 8 steps": occlusion(WORLD + " slices: 4, steps: 8,"),
            "half of the size": occlusion(WORLD + " size: Half,"),
        },
        DEPTH | NORMAL | STEADY,
    ),
    Case(
        "Ssao",
        None,
        "beauty",
        {
            "the default: 16 points, with normals": points(WORLD),
            "64 points": points(WORLD + " samples: 64,"),
            "normals from the depth": points(""),
        },
        DEPTH | NORMAL | STEADY,
    ),
    Case(
        "ShadowMask",
        "open",
        "sun",
        {
            "the defaults, with normals": shadow(WORLD),
            "normals from the depth": shadow(""),
            "kernel 1": shadow(WORLD + " kernel: 1,"),
            "kernel 7": shadow(WORLD + " kernel: 7,"),
            "disc": shadow(WORLD + " pattern: Disc,"),
        },
        DEPTH | NORMAL | STEADY | LIGHT,
    ),
    Case(
        "ShadowMask of a wide sun",
        "open6",
        "sun6",
        {
            "the search, with normals": shadow(WORLD + WIDE),
            "normals from the depth": shadow(WIDE),
            "16 blocker_taps": shadow(WORLD + WIDE + " blocker_taps: 16,"),
            "8 blocker_taps": shadow(WORLD + WIDE + " blocker_taps: 8,"),
            "64 of both": shadow(WORLD + WIDE + " blocker_taps: 64, taps: 64,"),
            "no search, kernel 1": shadow(WORLD + " kernel: 1,"),
            "no search, kernel 3": shadow(WORLD),
            "no search, kernel 7": shadow(WORLD + " kernel: 7,"),
        },
        DEPTH | NORMAL | STEADY | LIGHT,
    ),
    Case(
        "DepthOfField",
        "beauty",
        "dof",
        {"12 rings": lens("rings: 12,"), "the default: 8": lens(), "5 rings": lens("rings: 5,")},
        DEPTH,
    ),
    Case(
        "MotionBlur",
        "beauty",
        "blur",
        {
            "with motion": blur(),
            "without depth": blur().replace('depth: "depth", ', ""),
            "the camera alone": blur(more=""),
        },
        DEPTH | STEADY | MOTION,
    ),
    Case(
        "DepthOfField and MotionBlur",
        "beauty",
        "both",
        {"one after the other": lens(name="focused") + blur("focused")},
        DEPTH | STEADY | MOTION,
    ),
    Case(
        "Taa",
        "aliased",
        "beauty",
        {
            "with motion": over_time(),
            "the camera alone": over_time(""),
            "and Cas": over_time(name="steady")
            + VIEW % "steady"
            + '"made": Cas(source: "view", sharpness: 0.3, amount: 0.5),',
        },
        DEPTH | JITTERED | MOTION,
    ),
    Case("Smaa", "aliased", "beauty", {"the defaults": shown('"made": Smaa(source: "%s"),')}),
    Case("Fxaa", "aliased", "beauty", {"the defaults": shown('"made": Fxaa(source: "%s"),')}),
]


def pipeline(case, nodes):
    """The text of a pipeline, and the files of its inputs. Without nodes it shows the source."""
    files = {name: file for name, file in case.files.items() if f'"{name}"' in nodes}
    if case.source:
        files = {"source": ("Color", "{folder}/" + f"{case.source}.####.exr#{COLOR}")} | files
    inputs = ", ".join(f'"{name}": {kind}' for name, (kind, _) in files.items())
    output = "made" if '"view"' in nodes else "view"
    nodes = nodes if output == "made" else nodes + VIEW % ("made" if nodes else "source")
    if case.source is None:
        nodes, output = nodes.split('"exposed"')[0], "made.occlusion"
    text = f'Pipeline(inputs: {{ {inputs} }}, nodes: {{ {nodes} }}, outputs: {{ "out": "{output}" }})'
    return text, {name: file for name, (_, file) in files.items()}
