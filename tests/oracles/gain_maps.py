"""Lets libultrahdr decode JPEGs with gain maps, and compares the light with that of the PNG of the HDR output:
gain_maps.py PROGRAM FOLDER SCENE..."""

import os

import imagecodecs
import numpy
import PIL.Image

from judge import check, run, start

# By the quality of the JPEG: stops between two lights, of all channels on average, and of 999 in 1000.
LIMITS = {92: (0.035, 0.5), 100: (0.025, 0.13)}
# SDR white, which both lights are divided by, and the offset of the comparison, as of the map.
WHITE, OFFSET = 203.0, 1 / 64
# From Rec.2020, by chromaticities with the white D65.
MATRICES = {
    "Rec709": [[1.660491, -0.587641, -0.072850], [-0.124550, 1.132900, -0.008349], [-0.018151, -0.100579, 1.118730]],
    "DisplayP3": [[1.343578, -0.282180, -0.061399], [-0.065297, 1.075788, -0.010490], [0.002822, -0.019598, 1.016777]],
}


def pq_light(codes):
    """cd/m2 by SMPTE ST 2084."""
    power = (codes / 65535.0) ** (32 / 2523)
    return 10000 * (numpy.maximum(power - 3424 / 4096, 0) / (2413 / 128 - 2392 / 128 * power)) ** (16384 / 2610)


def read(name):
    with open(name, "rb") as file:
        return file.read()


def main(program, *scenes):
    for scene in scenes:
        for primaries, quality in [("Rec709", 92), ("Rec709", 100), ("DisplayP3", 100)]:
            words = [program, "render", "hdr", scene, f"--quality={quality}", f"--set=sdr-encoded.primaries={primaries}"]
            run(*words, "-o", "photo.jpg", "--gain-map", "hdr")
            run(*words, "-o", "plain.jpg", "--output", "hdr=hdr.png")
            photo = read("photo.jpg")
            what = f"{os.path.basename(scene)} {primaries} {quality}"
            equal = numpy.array_equal(imagecodecs.jpeg_decode(photo), imagecodecs.jpeg_decode(read("plain.jpg")))
            check(f"{what}: a reader of JPEG sees the SDR output", equal)
            with PIL.Image.open("photo.jpg") as picture:
                base, second = picture._getmp()[0xB002]
                start = picture.info["mpoffset"] + second["DataOffset"]
            is_whole = base["Size"] == start and second["Size"] == len(photo) - start
            check(f"{what}: Pillow finds the second picture", is_whole and photo[start:].startswith(b"\xff\xd8"))
            found = imagecodecs.ultrahdr_decode(photo)[..., :3].astype("float64")
            wanted = pq_light(imagecodecs.png_decode(read("hdr.png"))[..., :3].astype("float64")) / WHITE
            wanted = numpy.maximum(wanted @ numpy.array(MATRICES[primaries]).T, 0)
            errors = numpy.abs(numpy.log2((found + OFFSET) / (wanted + OFFSET)))
            mean, most = errors.mean(), numpy.quantile(errors, 0.999)
            limits = LIMITS[quality]
            text = f"{what}: libultrahdr's light to {found.max():.2f}, of {wanted.max():.2f}, is {mean:.4f} and {most:.3f} stops away"
            check(f"{text}, in {len(photo)} bytes of {os.path.getsize('plain.jpg')}", mean < limits[0] and most < limits[1])


start(main)
