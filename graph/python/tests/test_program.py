"""Numbers are those of the program, whose files are read by readers that are not ours."""

import json
import os
import unittest

import afterimage as ai
import numpy as np
from support import TestCase, read_exr, read_png, scene, write_exr

CAMERA = {
    "view": [[1, 0, 0, 0.5], [0, 1, 0, -1.5], [0, 0, 1, -4], [0, 0, 0, 1]],
    "projection": [[1.2, 0, 0, 0], [0, 2.1, 0, 0], [0, 0, 0, 0.1], [0, 0, -1, 0]],
    "jitter": [0.25, -0.25],
}


def depth(width=96, height=54):
    """Depth of a floor that recedes, nearer at the bottom: 0.1 divided by the distance."""
    y, x = np.mgrid[0:height, 0:width].astype(np.float32)
    return (0.1 / (30 - 28 * y / height + 0.5 * np.sin(x / 5))).astype(np.float32)


class Program(TestCase):
    def setUp(self):
        super().setUp()
        write_exr(self.path("scene.exr"), scene())

    def test_codes_of_all_built_in_pipelines_with_an_sdr_output(self):
        pipelines = [name for name in ai.PIPELINES if name != "hdr"]
        self.assertGreaterEqual(len(pipelines), 12)
        for name in pipelines:
            with self.subTest(name):
                self.program("render", name, "scene.exr", "-o", f"{name}.png")
                self.assert_same(ai.Pipeline(name)(scene()), read_png(self.path(f"{name}.png")), name)

    def test_two_outputs_of_8_and_16_bits(self):
        self.program("render", "hdr", "scene.exr", "--output", "sdr=sdr.png", "--output", "hdr=hdr.png")
        pictures = ai.Pipeline("hdr")(scene())
        self.assertEqual(list(pictures), ["sdr", "hdr"])
        for name, picture in pictures.items():
            self.assert_same(picture, read_png(self.path(f"{name}.png")), name)
        self.assertEqual((pictures["sdr"].dtype, pictures["hdr"].dtype), (np.uint8, np.uint16))
        self.program("render", "hdr", "scene.exr", "--output", "sdr", "-o", "alone.png")
        self.assert_same(ai.Pipeline("hdr", outputs="sdr")(scene()), read_png(self.path("alone.png")))

    def test_light_of_a_file_that_extends_another(self):
        self.program("pipelines", "tsushima", "--write", "tsushima.ron")
        for kind in (np.float16, np.float32):
            with open(self.path("lit.ron"), "w") as file:
                file.write('Pipeline(extends: "tsushima.ron", outputs: { "light": "lit" })')
            write_exr(self.path("scene.exr"), scene(kind=kind))
            self.program("render", "lit.ron", "scene.exr", "-o", "lit.exr")
            light = ai.Pipeline(self.path("lit.ron"), outputs="light")(scene(kind=kind))
            self.assertEqual(light.state, "Exposed")
            self.assert_same(light, read_exr(self.path("lit.exr")), str(kind))

    def test_node_folders_and_allowed_files(self):
        self.program("nodes", "--new", "SoftGlow")
        kind, own = self.path("soft_glow"), self.path("looks/own.ron")
        os.makedirs(self.path("looks"))
        with open(own, "w") as file:
            file.write('Pipeline(extends: "../soft_glow/soft_glow.ron")')
        folders = ("--nodes", "soft_glow", "--allow", "soft_glow")
        self.program("render", "looks/own.ron", "-o", "glow.png", "--size", "64x36", *folders)
        wanted = read_png(self.path("glow.png"))
        self.assert_same(ai.Pipeline(own, nodes=[kind], allow=[kind])(size=(64, 36)), wanted)
        with self.assertRaisesRegex(ai.PipelineError, "allow"):
            ai.Pipeline(own, nodes=[kind])
        with self.assertRaisesRegex(ai.PipelineError, "SoftGlow"):
            ai.Pipeline(own, allow=[kind])
        # The folders beside a file are known, whether they are named or not.
        os.rename(self.path("soft_glow/soft_glow.ron"), self.path("beside.ron"))
        for nodes in ([], [kind], [self.folder]):
            self.assert_same(ai.Pipeline(self.path("beside.ron"), nodes=nodes)(size=(64, 36)), wanted)

    def test_tiers_have_claims(self):
        tiers = ai.Pipeline("lynx").tiers
        self.assertEqual(list(tiers), ["ultra", "high", "low"])
        self.assertLess(tiers["low"].ms, tiers["ultra"].ms)
        self.assertLess(tiers["ultra"].p999, tiers["low"].p999)
        self.assertIn("NVIDIA", tiers["low"].on)
        own = ai.Pipeline('Pipeline(extends: "lynx.ron", tiers: { "own": {} })').tiers
        self.assertEqual((list(own)[-1], own["own"], own["low"]), ("own", None, None))

    def test_tiers_parameters_facts_and_no_dither(self):
        options = ["--tier", "low", "--set", "lit.strength=0.02", "--set", "bright=Off", "--fact", "emissive=false"]
        self.program("render", "tsushima", "scene.exr", "-o", "low.png", "--no-dither", *options)
        look = ai.Pipeline("tsushima", dither=False)
        before = look(scene())
        look.tier = "low"
        look["lit.strength"] = 0.02
        look["bright"] = False
        look.state("emissive", False)
        after = look(scene())
        self.assert_same(after, read_png(self.path("low.png")))
        self.assertTrue((before != after).any())
        self.assertEqual((look.tier, look["lit.strength"], look["bright"]), ("low", 0.02, False))
        fresh = ai.Pipeline("tsushima", "low", facts={"emissive": False}, dither=False)
        fresh["lit.strength"], fresh["bright"] = 0.02, False
        self.assert_same(fresh(scene()), np.asarray(after))

    def test_sixteen_bits_and_numbers_that_are_not_rounded(self):
        self.program("render", "lynx", "scene.exr", "-o", "deep.png", "--depth", "16")
        deep = ai.Pipeline("lynx", dtype="uint16")(scene())
        self.assert_same(deep, read_png(self.path("deep.png")))
        numbers = ai.Pipeline("lynx", dtype="float32")(scene())
        self.assertEqual((numbers.dtype, numbers.state), (np.float32, "Encoded"))
        self.assertLessEqual(np.abs(numbers[..., :3].clip(0, 1) * 65535 - deep).max(), 0.51)

    def test_depth_and_a_moving_camera(self):
        names = ("scene.#.exr", "depth.#.exr", "camera.#.json")
        frames = []
        for frame in range(1, 4):
            camera = json.loads(json.dumps(CAMERA))
            camera["view"][0][3] += 0.1 * frame
            frames.append((scene(shift=0.2 * frame), depth() * frame, camera))
            write_exr(self.path(f"scene.{frame}.exr"), frames[-1][0])
            write_exr(self.path(f"depth.{frame}.exr"), np.repeat(frames[-1][1][..., np.newaxis], 3, axis=2))
            with open(self.path(f"camera.{frame}.json"), "w") as file:
                json.dump(camera, file)
        self.program(
            *("render", "cinematic", names[0], "--input", f"depth={names[1]}", "--input", f"camera={names[2]}"),
            *("-o", "film.#.png", "--frames", "1-3"),
        )
        look = ai.Pipeline("cinematic")
        for frame, (image, far, camera) in enumerate(frames, 1):
            picture = look(image, depth=far, camera=camera, dt=1 / 24, frame=frame)
            self.assert_same(picture, read_png(self.path(f"film.{frame}.png")), f"frame {frame}")

    def test_adaptation_of_a_sequence_and_its_exposure(self):
        shots = [scene(shift=shift) for shift in (0.0, 2.0, 2.0, -2.0)]
        for frame, shot in enumerate(shots, 1):
            write_exr(self.path(f"shot.{frame}.exr"), shot)
        self.program(
            "render", "exposure", "shot.#.exr", "-o", "shot.#.png", "--frames", "1-4", "--json", "report.json"
        )
        with open(self.path("report.json")) as file:
            report = [frame["exposure"] for frame in json.load(file)["frames"]]
        look = ai.Pipeline("exposure")
        for frame, shot in enumerate(shots, 1):
            picture, values = look(shot, dt=1 / 24, frame=frame, values=["meter"])
            self.assert_same(picture, read_png(self.path(f"shot.{frame}.png")), f"frame {frame}")
            self.assertEqual(values["meter"][3], 1.0)
            self.assertAlmostEqual(values["meter"][0], report[frame - 1][0]["stops"], places=6)

    def test_files_are_read_and_written_as_the_program_does(self):
        image = ai.read(self.path("scene.exr"))
        self.assert_same(image[..., :3], scene())
        self.assertTrue((image[..., 3] == 1).all())
        ai.write(self.path("copy.exr"), image)
        self.assert_same(read_exr(self.path("copy.exr"))[..., :3], scene())
        picture = ai.Pipeline("lynx")(scene())
        ai.write(self.path("copy.png"), picture)
        self.assert_same(read_png(self.path("copy.png")), np.asarray(picture))


if __name__ == "__main__":
    unittest.main()
