"""What the package promises about calls, arrays and errors."""

import threading
import unittest
import warnings
import xml.etree.ElementTree

import afterimage as ai
import numpy as np
import png
from afterimage._image import as_bytes
from support import TestCase, scene

GAIN = """Pipeline(
    inputs: {{ "scene": Color }},
    nodes: {{ "lit": Exposure(source: "scene", stops: {}) }},
    outputs: {{ "light": "lit" }},
)"""


class Arrays(TestCase):
    def test_a_stop_doubles_light_in_both_types(self):
        for kind in (np.float16, np.float32):
            image = np.abs(scene(kind=kind))
            light = ai.Pipeline(GAIN.format("1.0"))(image)
            self.assertEqual((light.shape, light.state), ((54, 96, 4), "Exposed"))
            np.testing.assert_allclose(light[..., :3].astype(np.float64), 2.0 * image.astype(np.float64), rtol=1e-3)
            self.assertTrue((light[..., 3] == 1).all())

    def test_strides_and_byte_orders_and_locks_change_nothing(self):
        look, image = ai.Pipeline(GAIN.format("0.5")), np.abs(scene(kind=np.float32))
        wanted = look(image)
        big = np.zeros((108, 192, 5), np.float32)
        big[::2, ::2, 1:4] = image
        locked = image.copy()
        locked.flags.writeable = False
        swapped = image.astype(">f4")
        rgba = np.dstack([image, np.ones((54, 96), np.float32)])
        turned = np.asfortranarray(image)
        flipped = image[::-1, ::-1].copy()[::-1, ::-1]
        for other in (big[::2, ::2, 1:4], locked, swapped, rgba, turned, flipped, memoryview(image)):
            self.assert_same(look(other), wanted)

    def test_contiguous_images_are_not_copied(self):
        rgba = np.ones((4, 4, 4), np.float16)
        self.assertTrue(np.shares_memory(as_bytes(rgba), rgba))
        self.assertFalse(np.shares_memory(as_bytes(rgba[:, ::2]), rgba))

    def test_dlpack(self):
        class Tensor:
            """An array of another library."""

            def __init__(self, array):
                self.array = array

            def __dlpack__(self, **options):
                return self.array.__dlpack__(**options)

            def __dlpack_device__(self):
                return self.array.__dlpack_device__()

        image = scene()
        look = ai.Pipeline("lynx")
        self.assert_same(look(Tensor(image)), np.asarray(look(image)))

    def test_batches(self):
        look = ai.Pipeline("exposure")
        shots = np.stack([scene(shift=shift) for shift in (0.0, 3.0)])
        alone = np.stack([look(shot) for shot in shots])
        self.assert_same(look(shots), alone)
        sequence, values = look(shots, dt=0.1, values=["meter"])
        self.assert_same(sequence[0], alone[0])
        self.assertTrue((sequence[1] != alone[1]).any())
        self.assertEqual(len(values), 2)

    def test_volumes(self):
        text = """Pipeline(inputs: { "table": Color(volume: true), "scene": Color },
            nodes: { "lit": Exposure(source: "scene", stops: 0.0) }, outputs: { "light": "lit" })"""
        with self.assertWarnsRegex(ai.PipelineWarning, "nothing reads the input `table`"):
            look = ai.Pipeline(text)
        image = np.abs(scene())
        self.assert_same(look(image, table=np.ones((3, 4, 5, 4), np.float16))[..., :3], image)
        with self.assertRaisesRegex(ai.ImageError, r"`table` has the shape \(D, H, W, 3 or 4\)"):
            look(image, table=np.ones((4, 5, 4), np.float16))


class State(TestCase):
    def test_images_are_independent_and_frames_are_not(self):
        look = ai.Pipeline("exposure")
        dark, bright = scene(shift=-3.0), scene(shift=3.0)
        first, _, again = look(dark), look(bright), look(dark)
        self.assert_same(again, np.asarray(first))
        look(dark, dt=0.1)
        following = look(bright, dt=0.1)
        self.assertTrue((following != look(bright)).any())
        # The single image in between is no frame of the sequence.
        look.reset()
        self.assert_same(look(bright, dt=0.1), np.asarray(look(bright)))

    def test_parameters(self):
        look = ai.Pipeline("tsushima")
        strength = look.parameters["lit.strength"]
        self.assertEqual((strength.name, strength.kind, strength.type), ("lit.strength", "Composite", "a number"))
        self.assertTrue(strength.doc)
        self.assertLessEqual(strength.domain[0], strength.value)
        written = look["lit.strength"]
        look["lit.strength"] = np.float32(0.5)
        self.assertEqual(look.parameters["lit.strength"].value, 0.5)
        del look["lit.strength"]
        self.assertEqual(look["lit.strength"], written)
        choice = next(one for one in look.parameters.values() if one.choices)
        look[choice.name] = list(choice.choices)[-1]
        self.assertEqual(look[choice.name], list(choice.choices)[-1])

    def test_other_threads_run_during_a_frame(self):
        look, image = ai.Pipeline("tsushima"), scene(384, 216)
        counted, done = [0], threading.Event()

        def count():
            while not done.is_set():
                counted[0] += 1

        thread = threading.Thread(target=count)
        thread.start()
        try:
            before = counted[0]
            look(image)
            self.assertGreater(counted[0] - before, 1000)
        finally:
            done.set()
            thread.join()

    def test_threads_with_pipelines_of_their_own(self):
        image = scene()
        wanted = {name: np.asarray(ai.Pipeline(name)(image)) for name in ("lynx", "caracal", "glare")}
        found = {}

        def run(name):
            found[name] = ai.Pipeline(name)(image)

        threads = [threading.Thread(target=run, args=(name,)) for name in wanted]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for name, picture in wanted.items():
            self.assert_same(found[name], picture, name)


class Governors(TestCase):
    TEXT = """Pipeline(
        inputs: { "scene": Color },
        nodes: { "lit": Exposure(source: "scene", stops: 0.0) },
        outputs: { "light": "lit" },
        tiers: { "low": { "lit.stops": 1.0 }, "high": { "lit.stops": 2.0 }, "best": { "lit.stops": 3.0 } },
        claims: {
            "low": Claim(ms: 1.0, jod: 8.0, for: "desk", on: "nothing"),
            "high": Claim(ms: 2.0, jod: 9.5, for: "desk", on: "nothing"),
            "best": Claim(ms: 3.0, jod: 9.9, for: "phone", on: "nothing"),
        },
    )"""
    TIERS = ["low", "high", "best"]

    def frames(self, look, ms):
        """Four seconds of frames that all take so many milliseconds; the reasons of changes."""
        return [reason for _ in range(400) if (reason := look.report_frame_time(ms, 0.01))]

    def test_the_floor_comes_before_the_budget(self):
        look = ai.Pipeline(self.TEXT)
        look.govern(4.0, self.TIERS)
        self.assertEqual((look.tier, look.shortfall), ("low", None))
        # The claim of `best` is for a phone, and that of `low` too small.
        look.govern(4.0, self.TIERS, min_jod=9.0, display="desk")
        self.assertEqual((look.tier, self.frames(look, 1.0), look.shortfall), ("high", [], None))
        self.assertEqual((self.frames(look, 20.0), look.tier), ([], "high"))
        self.assertIn("over 4.00, and no cheaper tier claims 9.00 JOD", look.shortfall)
        look.govern(4.0, self.TIERS, min_jod=9.0)
        (reason,) = self.frames(look, 1.0)
        self.assertRegex(reason, "^high to best: .*, at least 9.00$")
        look.govern(4.0, self.TIERS, min_jod=9.95)
        self.assertEqual(look.tier, "best")
        self.assertIn("the budget of 4.00 ms is not held", look.shortfall)

    def test_a_budget_ends(self):
        look = ai.Pipeline(self.TEXT)
        for end in (lambda: look.govern(None), lambda: setattr(look, "tier", "low")):
            look.govern(4.0, self.TIERS, min_jod=11.0)
            self.assertIsNotNone(look.shortfall)
            end()
            self.assertEqual((look.shortfall, self.frames(look, 1.0)), (None, []))

    def test_wrong_tiers(self):
        look = ai.Pipeline(self.TEXT, tier="high")
        for tiers, text in (([], "tier"), (["lov"], "low")):
            with self.assertRaisesRegex(ai.Error, text):
                look.govern(4.0, tiers)
        self.assertEqual(look.tier, "high")


class Notebooks(TestCase):
    def test_pictures(self):
        picture = ai.Pipeline("lynx")(scene())
        _, _, rows, info = png.Reader(bytes=picture._repr_png_()).read()
        self.assertEqual((np.vstack([np.asarray(row) for row in rows]) == picture.reshape(54, -1)).all(), True)
        self.assertIsNone(picture[0, 0]._repr_png_())
        light = ai.Pipeline(GAIN.format("0.0"))(np.full((2, 3, 3), 0.5, np.float32))
        width, height, rows, info = png.Reader(bytes=light._repr_png_()).read()
        # IEC 61966-2-1: a half of white's light is code 188.
        self.assertEqual((width, height, set(np.vstack([np.asarray(row) for row in rows]).flat)), (3, 2, {188}))

    def test_plans(self):
        look = ai.Pipeline("tsushima")
        plan = look.plan(size=(640, 360))
        root = xml.etree.ElementTree.fromstring(plan.svg())
        self.assertTrue(root.tag.endswith("svg"))
        self.assertEqual(plan._repr_html_(), plan.svg())
        self.assertIn("640x360", plan.text())

    def test_measurements(self):
        report = ai.Pipeline("lynx").measure([scene(48, 27)], tiers=True)
        names = [row["variant"] for row in report["rows"]]
        self.assertEqual(names[0], "reference")
        self.assertIn("tier low", names)


class Faults(TestCase):
    def fails(self, error, pattern, call):
        with self.assertRaisesRegex(error, pattern) as raised:
            call()
        return raised.exception

    def test_pipelines(self):
        nodes = '{ "lit": Exposre(source: "scene") }'
        text = f'Pipeline(\n inputs: {{ "scene": Color }},\n nodes: {nodes},\n outputs: {{ "a": "lit" }},\n)'
        error = self.fails(ai.PipelineError, "Exposure", lambda: ai.Pipeline(text))
        label = error.diagnostics[0]["labels"][0]
        self.assertEqual((label["line"], text[label["start"] : label["end"]]), (3, "Exposre"))
        self.assertIsInstance(error, ValueError)
        self.fails(ai.PipelineError, "<text>", lambda: ai.Pipeline("Pipeline(inputs: {"))
        self.fails(ai.FileError, "tsushima", lambda: ai.Pipeline("tsushma"))
        self.fails(ai.PipelineError, "low", lambda: ai.Pipeline("tsushima", tier="lov"))
        with open(self.path("out.ron"), "w") as file:
            file.write('Pipeline(extends: "../../etc/passwd")')
        self.fails(ai.PipelineError, "folder|no such", lambda: ai.Pipeline(self.path("out.ron")))

    def test_names(self):
        look = ai.Pipeline("tsushima")
        self.fails(ai.ParameterError, "strength", lambda: look["lit.strenth"])
        self.fails(KeyError, "lit", lambda: look["lits.strength"])
        for name, value, pattern in [
            ("lit.strenth", 0.1, "strength"),
            ("lit.strength", -1.0, "0"),
            ("lit.strength", "much", "number"),
            ("lit.strength", float("nan"), "finite"),
            ("lit.strength", object(), "object"),
        ]:
            self.fails(ai.ParameterError, pattern, lambda: look.__setitem__(name, value))
        written = ai.Pipeline("tsushima")["lit.strength"]
        self.assertEqual(look["lit.strength"], written)
        self.fails(ai.ParameterError, "sdr", lambda: ai.Pipeline("hdr", outputs="sdrr"))
        self.fails(ai.ParameterError, "emissive", lambda: ai.Pipeline("tsushima", facts={"emisive": True}))
        self.fails(ai.ParameterError, "metered", lambda: look(scene(), values=["meterd"]))

    def test_images(self):
        look, image = ai.Pipeline("lynx"), scene()
        for wrong, pattern in [
            (image.astype(np.float64), "float64.*astype"),
            ((image * 10).astype(np.uint8), "uint8.*read"),
            (image[..., :2], "3 or 4"),
            (image[..., 0], "3 or 4"),
            (np.zeros((0, 8, 3), np.float32), "no pixels"),
            (np.zeros((1, 1, 2, 2, 3), np.float32), "3 or 4"),
            (np.zeros((1, 20000, 3), np.float16), "20000"),
            ("scene.exr", "<U9"),
        ]:
            self.fails(ai.ImageError, pattern, lambda: look(wrong))
        self.fails(ai.ImageError, "`scene`", lambda: look())
        self.fails(ai.ImageError, "no input `seen`", lambda: look(image, seen=image))
        self.fails(ai.ImageError, "size", lambda: look(image, size=(8, 8)))
        self.fails(ai.ImageError, "dt", lambda: look(image, dt=float("nan")))
        self.fails(ai.ImageError, "size", lambda: ai.Pipeline("lynx").plan(size=(0, 8)))
        self.fails(ai.ImageError, "uint32", lambda: ai.Pipeline("lynx", dtype=np.uint32))
        self.fails(ai.ImageError, "camera", lambda: ai.Pipeline("cinematic")(image, camera={"view": np.eye(4)}))
        # After all of these it renders.
        self.assertEqual(look(image).shape, (54, 96, 3))

    def test_pixels_that_are_not_finite_are_repaired_with_a_warning(self):
        look, image = ai.Pipeline("lynx"), scene()
        image[3, 4, 1], image[5, 6] = np.nan, np.inf
        with self.assertWarnsRegex(ai.RepairWarning, "2"):
            picture = look(image)
        self.assertEqual(picture.dtype, np.uint8)
        with warnings.catch_warnings():
            warnings.simplefilter("error", ai.RepairWarning)
            self.fails(ai.RepairWarning, "`scene`", lambda: look(image))
        light = None
        with self.assertWarns(ai.RepairWarning):
            light = ai.Pipeline(GAIN.format("1.0"))(image)
        self.assertTrue(np.isfinite(light).all())

    def test_files_and_devices(self):
        self.fails(ai.FileError, "no such file", lambda: ai.read(self.path("none.exr")))
        self.fails(OSError, "no such file", lambda: ai.read(self.path("none.exr")))
        self.fails(ai.ImageError, ".exr", lambda: ai.write(self.path("light.png"), scene()))
        look = ai.Pipeline("lynx", adapter="no such adapter")
        self.fails(ai.DeviceError, "no such adapter", lambda: look(scene()))


if __name__ == "__main__":
    unittest.main()
