"""Reads files of every format and label with OpenEXR, libpng and LittleCMS, and compares what they say with the
primaries and curves in the files' names. Prints a line for each kind of check, and each file that fails."""

import ctypes
import glob
import io
import os
import sys

import numpy
import OpenEXR
import PIL
from PIL import Image, ImageCms

D65 = (0.3127, 0.3290)
ACES = (0.32168, 0.33767)
SPACES = {
    "Rec709": ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06), D65),
    "DisplayP3": ((0.68, 0.32), (0.265, 0.69), (0.15, 0.06), D65),
    "Rec2020": ((0.708, 0.292), (0.17, 0.797), (0.131, 0.046), D65),
    "AcesCg": ((0.713, 0.293), (0.165, 0.83), (0.128, 0.044), ACES),
    "AcesAp0": ((0.7347, 0.2653), (0.0, 1.0), (0.0001, -0.077), ACES),
}
BRADFORD = numpy.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
D50 = numpy.array([0.9642, 1.0, 0.8249])


def light(curve, signal):
    if curve == "Srgb":
        return numpy.where(signal <= 0.04045, signal / 12.92, ((signal + 0.055) / 1.055) ** 2.4)
    return signal if curve == "Linear" else signal ** float(curve.removeprefix("Gamma"))


def xyz(xy):
    return numpy.array([xy[0] / xy[1], 1.0, (1.0 - xy[0] - xy[1]) / xy[1]])


IDS = {"Rec709": "rec709", "DisplayP3": "p3d65", "Rec2020": "rec2020", "AcesCg": "ap1", "AcesAp0": "ap0"}


def from_rec709(space):
    """Linear Rec.709 to a space: the matrix for columns."""
    def to_xyz(name):
        *primaries, white = SPACES[name]
        columns = numpy.stack([numpy.array([x, y, 1.0 - x - y]) for x, y in primaries], axis=1)
        return columns * numpy.linalg.solve(columns, xyz(white))

    cones = [BRADFORD @ xyz(SPACES[name][3]) for name in ("Rec709", space)]
    adapt = numpy.linalg.inv(BRADFORD) @ numpy.diag(cones[1] / cones[0]) @ BRADFORD
    return numpy.linalg.inv(to_xyz(space)) @ adapt @ to_xyz("Rec709")


def lab(space, curve, signal):
    """CIE L*a*b* of signals for a reader that is adapted to D50, and which of them are colors that 8 bits can hold."""
    *primaries, white = SPACES[space]
    columns = numpy.stack([numpy.array([x, y, 1.0 - x - y]) for x, y in primaries], axis=1)
    matrix = columns * numpy.linalg.solve(columns, xyz(white))
    cones = BRADFORD @ D50 / (BRADFORD @ xyz(white))
    adapted = numpy.linalg.inv(BRADFORD) @ numpy.diag(cones) @ BRADFORD @ matrix
    ratio = light(curve, signal) @ adapted.T / D50
    f = numpy.where(ratio > 216 / 24389, numpy.cbrt(ratio), (24389 / 27 * ratio + 16) / 116)
    found = numpy.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1)
    return found, (ratio.min(axis=1) >= 0) & (numpy.abs(found[:, 1:]).max(axis=1) < 120)


def profile_fault(profile, space, curve, codes):
    """LittleCMS opens the profile and takes codes to the colors of the name."""
    try:
        transform = ImageCms.buildTransform(
            ImageCms.ImageCmsProfile(io.BytesIO(profile)), ImageCms.createProfile("LAB"), "RGB", "LAB",
            renderingIntent=ImageCms.Intent.RELATIVE_COLORIMETRIC,
        )
    except ImageCms.PyCMSError as error:
        return f"LittleCMS: {error}"
    picture = Image.fromarray(codes[None].astype(numpy.uint8), "RGB")
    found = numpy.asarray(ImageCms.applyTransform(picture, transform))[0].astype(float)
    found[:, 0] *= 100 / 255
    found[:, 1:] = (found[:, 1:] + 128) % 256 - 128
    wanted, inside = lab(space, curve, codes / 255)
    off = numpy.abs(found - wanted)[inside].max()
    return None if off < 1.2 else f"LittleCMS: {off:.2f} of L*a*b* off"


def png_header(path):
    """What libpng warns of in the chunks before the pixels, and the profile that it accepts."""
    library = ctypes.CDLL(glob.glob(os.path.join(os.path.dirname(PIL.__file__), "../pillow.libs/libpng16*"))[0])
    for name in ("png_create_read_struct", "png_create_info_struct", "png_get_io_ptr"):
        getattr(library, name).restype = ctypes.c_void_p
    message = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_char_p)
    reading = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.POINTER(ctypes.c_char), ctypes.c_size_t)
    warnings, file = [], open(path, "rb")

    def stop(_, text):
        # libpng must not go on after an error.
        print(f"{path}: libpng: {text.decode()}", flush=True)
        os._exit(1)

    def read(_, buffer, length):
        ctypes.memmove(buffer, file.read(length), length)

    callbacks = message(stop), message(lambda _, text: warnings.append(text.decode())), reading(read)
    library.png_get_libpng_ver.restype = ctypes.c_char_p
    version = library.png_get_libpng_ver(None)
    png = ctypes.c_void_p(library.png_create_read_struct(version, None, callbacks[0], callbacks[1]))
    info = ctypes.c_void_p(library.png_create_info_struct(png))
    library.png_set_read_fn(png, None, callbacks[2])
    library.png_read_info(png, info)
    name, data = ctypes.c_char_p(), ctypes.POINTER(ctypes.c_char)()
    kind, length = ctypes.c_int(), ctypes.c_uint32()
    library.png_get_iCCP(png, info, ctypes.byref(name), ctypes.byref(kind), ctypes.byref(data), ctypes.byref(length))
    profile = ctypes.string_at(data, length.value) if length.value else None
    return version.decode(), warnings, profile


def png_faults(path, space, curve, codes):
    _, warnings, profile = png_header(path)
    yield from (f"libpng: {warning}" for warning in warnings)
    stored = open(path, "rb").read()
    if (b"iCCP" in stored) != (profile is not None):
        yield "libpng: the profile is dropped"
    if profile is not None:
        yield profile_fault(profile, space, curve, codes)


def jpeg_faults(path, space, curve, codes):
    profile = Image.open(path).info.get("icc_profile")
    yield "no profile" if profile is None else profile_fault(profile, space, curve, codes)


def exr_faults(path, space, curve, codes):
    with OpenEXR.File(path, separate_channels=True) as file:
        header, channels = file.header(), file.channels()
        stated = numpy.array(header["chromaticities"]).reshape(4, 2)
        if numpy.abs(stated - numpy.array(SPACES[space])).max() > 1e-6:
            yield f"OpenEXR: chromaticities {stated.tolist()}"
        if abs(header["whiteLuminance"] - 203) > 1e-3 or header["screenWindowWidth"] < 0:
            yield f"OpenEXR: {header['whiteLuminance']} cd/m2, a window of {header['screenWindowWidth']}"
        pixels = numpy.stack([channels[name].pixels[0] for name in "RGB"], axis=1).astype(float)
        wanted = codes / 255
        if curve == "Converted":
            wanted = wanted @ from_rec709(space).T
            if header.get("colorInteropID") != f"lin_{IDS[space]}_scene":
                yield f"OpenEXR: colorInteropID {header.get('colorInteropID')}"
        if numpy.abs(pixels - wanted).max() > (1e-6 if curve == "Converted" else 5e-4):
            yield "OpenEXR: other pixels"


def main(folder):
    codes = numpy.array(open(f"{folder}/codes.txt").read().split(), dtype=float).reshape(-1, 4)[:, :3]
    checks = {".png": png_faults, ".jpg": jpeg_faults, ".exr": exr_faults}
    counts, faults = dict.fromkeys(checks, 0), 0
    for name in open(f"{folder}/files.txt").read().split():
        stem, ending = os.path.splitext(name)
        space, curve = stem.split("-")[:2]
        counts[ending] += 1
        for fault in checks[ending](f"{folder}/{name}", space, curve, codes):
            if fault is not None:
                faults += 1
                print(f"{name}: {fault}")
    version = png_header(f"{folder}/Rec709-Srgb-8.png")[0]
    print(f"OpenEXR {OpenEXR.__version__}, libpng {version}, LittleCMS {ImageCms.core.littlecms_version}")
    print(", ".join(f"{count} {ending} files" for ending, count in counts.items()) + f": {faults} faults")
    sys.exit(faults > 0)


main(sys.argv[1])
