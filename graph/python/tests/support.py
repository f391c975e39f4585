"""What the tests share: a generated image, the program, and readers of files that are not ours."""

import os
import subprocess
import tempfile
import unittest

import numpy as np
import OpenEXR
import png

PROGRAM = os.environ.get("AFTERIMAGE_PROGRAM", "afterimage")


def scene(width=96, height=54, kind=np.float16, shift=0.0):
    """Light over twelve stops, with a sun, colors outside of Rec.709 and an edge; the same in all runs."""
    y, x = np.mgrid[0:height, 0:width] / (height, width)[0]
    light = np.exp2(8 * x / x.max() - 6 + shift)
    colors = np.stack([1 + 0.5 * np.sin(9 * y), 0.7 + 0.3 * np.cos(7 * x * y), 0.4 + 0.4 * y], axis=-1)
    image = light[..., np.newaxis] * colors
    image[height // 3 : height // 3 + 3, width // 5 : width // 5 + 3] = 900.0
    image[: height // 6, width // 2 :, 2] = -0.01
    image[height // 2 :, : width // 4] *= 0.05
    return image.astype(kind)


def read_exr(path):
    """The channels of an EXR file, by OpenEXR."""
    with OpenEXR.File(path, separate_channels=True) as file:
        channels = file.channels()
        return np.stack([channels[name].pixels for name in "RGBA" if name in channels], axis=-1)


def write_exr(path, image):
    """Writes an EXR file by OpenEXR."""
    channels = dict(zip("RGBA", np.moveaxis(np.ascontiguousarray(image), -1, 0)))
    channels = {name: np.ascontiguousarray(channel) for name, channel in channels.items()}
    with OpenEXR.File({"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION}, channels) as file:
        file.write(path)


def read_png(path):
    """The codes of a PNG file, by pypng."""
    with open(path, "rb") as file:
        width, height, rows, info = png.Reader(file=file).read()
        codes = np.vstack([np.asarray(row) for row in rows]).reshape(height, width, info["planes"])
    return codes.astype(np.uint16 if info["bitdepth"] == 16 else np.uint8)


class TestCase(unittest.TestCase):
    """A test with a folder of its own."""

    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(lambda: subprocess.run(["rm", "-r", self.folder], check=True))

    def path(self, name):
        return os.path.join(self.folder, name)

    def program(self, *arguments):
        """Runs the program; images alone have baked LUTs, as those of a pipeline object."""
        if arguments[0] == "render":
            arguments += ("--plan", "bake=still")
        done = subprocess.run([PROGRAM, *arguments], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, f"{arguments}: {done.stderr}")
        return done.stdout

    def assert_same(self, found, wanted, what=""):
        """Equal bit by bit, apart from the sign of 0."""
        self.assertEqual((found.shape, found.dtype), (wanted.shape, wanted.dtype), what)
        different = np.count_nonzero(np.asarray(found) != wanted)
        self.assertEqual(different, 0, f"{what}: {different} of {wanted.size} numbers differ")
