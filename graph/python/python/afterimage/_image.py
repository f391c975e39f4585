"""Images that notebooks show, and files."""

from __future__ import annotations

import os
import warnings
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _native
from ._errors import ImageError


class Image(np.ndarray):
    """An array of an output, which notebooks show as a picture. It is an ordinary array otherwise.

    `state` is what the numbers mean: "Encoded" for codes and numbers of a display, "Scene", "Exposed" and
    "DisplayLinear" for light, "Data". `color` states the primaries and the transfer function.
    """

    state: str | None
    color: _native.Color | None

    def __array_finalize__(self, source: Any) -> None:
        self.state = getattr(source, "state", None)
        self.color = getattr(source, "color", None)

    def _repr_png_(self) -> bytes | None:
        """A PNG. Light is shown with white at 1, as sRGB."""
        if self.ndim not in (2, 3) or self.size == 0 or (self.ndim == 3 and self.shape[2] not in (3, 4)):
            return None
        return _png(None, _codes(self), self.color if self.state == "Encoded" else None)


def _codes(image: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Codes of 8 or 16 bits."""
    if image.dtype in (np.uint8, np.uint16):
        return np.asarray(image)
    numbers = np.nan_to_num(np.asarray(image, np.float32))
    if numbers.ndim == 2:
        numbers = np.repeat(numbers[..., np.newaxis], 3, axis=2)
    light = numbers[..., :3].clip(0, 1)
    if getattr(image, "state", None) != "Encoded":
        light = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return np.floor(light * 255 + 0.5).astype(np.uint8)


def _png(path: Any, codes: npt.NDArray[Any], color: _native.Color | None) -> bytes:
    if codes.ndim == 2:
        codes = np.repeat(codes[..., np.newaxis], 3, axis=2)
    height, width, channels = codes.shape
    bits = 8 * codes.dtype.itemsize
    row = np.ascontiguousarray(codes).reshape(-1).astype(np.uint16, copy=False)
    return _native.write_png(path, row, (width, height), channels, bits, color)


def read(path: str | os.PathLike[str], layer: str | None = None) -> Image:
    """An EXR, Radiance or PNG file as linear Rec.709, (H, W, 4): float16 where the file has halves, else float32.
    `layer` names a layer or a channel of an EXR file."""
    numbers, width, height, kind, notes = _native.read(os.fspath(path), layer)
    for note in notes:
        warnings.warn(f"{os.fspath(path)}: {note}", stacklevel=2)
    image = numbers.view(kind).reshape(height, width, 4).view(Image)
    image.state = "Scene"
    return image


def write(path: str | os.PathLike[str], image: npt.NDArray[Any]) -> None:
    """Writes uint8 and uint16 codes as `.png`, labeled with their colors, and float16 and float32 as `.exr`."""
    name = os.fspath(path)
    color, state = getattr(image, "color", None), getattr(image, "state", None) or "Scene"
    codes = image.dtype in (np.uint8, np.uint16)
    ending = ".png" if codes else ".exr"
    if not name.lower().endswith(ending):
        raise ImageError(f"{image.dtype} numbers are written as `{ending}`, not as {name!r}")
    if image.ndim != 3 or image.shape[2] not in (3, 4):
        raise ImageError(f"an image has the shape (H, W, 3 or 4), not {image.shape}")
    if codes:
        _png(name, np.asarray(image), color)
    else:
        rgba = with_alpha(np.asarray(image))
        height, width = rgba.shape[:2]
        _native.write_exr(name, as_bytes(rgba), (width, height), rgba.dtype.type.__name__, state, color)


def with_alpha(image: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The image with four channels: alpha is 1, and missing colors are 0."""
    channels = image.shape[-1]
    if channels == 4:
        return image
    whole = np.zeros((*image.shape[:-1], 4), image.dtype)
    whole[..., :channels] = image
    whole[..., 3] = 1
    return whole


def as_bytes(array: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
    """The bytes in a row: of the array itself, or of a copy if it has gaps or swapped bytes."""
    plain = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("="))
    return plain.reshape(-1).view(np.uint8)
