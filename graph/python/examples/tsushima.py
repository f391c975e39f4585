"""The picture of Afterimage's README: the built-in scene through tsushima.ron.

python tsushima.py [OUT.png [WIDTH HEIGHT]]
"""

import sys

import afterimage as ai

SCENE = """Pipeline(
    inputs: {},
    nodes: { "scene": DemoScene() },
    outputs: { "scene": "scene" },
)"""


def main(out: str = "tsushima.png", width: str = "960", height: str = "540") -> None:
    scene = ai.Pipeline(SCENE)(size=(int(width), int(height)))  # (H, W, 4), float16, linear Rec.709
    look = ai.Pipeline("tsushima")
    picture, values = look(scene, values=["metered"])  # (H, W, 3), uint8
    ai.write(out, picture)
    stops, luminance, lux, _ = values["metered"]
    print(f"{out}: {stops:+.2f} stops at {lux:.1f} lux; the bloom has {look['lit.strength']} of the light")


if __name__ == "__main__":
    main(*sys.argv[1:])
