"""Pipelines on arrays."""

from __future__ import annotations

import json
import math
import os
import tempfile
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _native
from ._errors import ImageError, ParameterError, PipelineWarning, RepairWarning
from ._image import Image, as_bytes, with_alpha, write

Output = Image | dict[str, Image]
"""The image of a frame; with several outputs, images by their names."""
Values = dict[str, tuple[float, float, float, float] | None]
"""Four numbers of each value, by its name; None where the frame has none, as that of a node that is skipped."""
Camera = Mapping[str, Any] | str | os.PathLike[str]
"""`view` and `projection` as rows of four numbers; `previous_view`, `previous_projection`, `jitter` and
`previous_jitter` may follow. Or the path of a JSON file with these, as the program reads it."""


@dataclass(frozen=True)
class Parameter:
    """A parameter of a node."""

    name: str
    """`node.parameter`."""
    kind: str
    """The kind of the node."""
    doc: str
    type: str
    """The type in words."""
    unit: str
    """Empty for pure numbers."""
    domain: tuple[float, float] | None
    """The smallest and the largest allowed number of each component."""
    usual: tuple[float, float] | None
    """The range of a slider."""
    choices: dict[str, str]
    """The names that a choice can have, and their meanings."""
    value: Any
    """The present value."""


@dataclass(frozen=True)
class Claim:
    """What was measured of a quality level, as the pipeline's file states it."""

    on: str
    """What it was measured on: a device, a size, images."""
    ms: float | None
    """The milliseconds of a frame."""
    jod: float | None
    """The quality in JOD on `display`: 10 for no visible difference."""
    p999: float | None
    """The error that one pixel in a thousand exceeds, in codes of 8 bits."""
    flip: float | None
    """The visible difference FLIP, from 0 to 1."""
    display: str | None
    """The display that `jod` is for."""


class Pipeline:
    """A pipeline: a built-in one by its name, a `.ron` file by its path, or the text of one.

    `tier` is one of its quality levels. `facts` states what its `when` conditions ask for. `outputs` names the outputs
    that are rendered: one is returned as an array, a list of them as a dict. `dtype` is that of outputs for a display:
    None for the codes of the program's PNG files, which are uint8, and uint16 for PQ and HLG; float16 and float32 are
    numbers from 0 to 1 that are not rounded. `dither` adds noise to codes of 8 bits. `adapter` is a part of the name of
    a graphics adapter. `nodes` are folders of node kinds, or of one; those beside a file are known. A file may name
    files of its own folder and below, and of the folders of `allow`.

    Outputs of light and of data have the numbers that the pipeline stores: float16 or float32, with four channels, or
    one or two for data.
    """

    def __init__(
        self,
        source: str | os.PathLike[str],
        tier: str | None = None,
        *,
        facts: Mapping[str, bool | float] | None = None,
        outputs: str | Sequence[str] | None = None,
        dtype: npt.DTypeLike | None = None,
        dither: bool = True,
        adapter: str | None = None,
        nodes: Sequence[str | os.PathLike[str]] = (),
        allow: Sequence[str | os.PathLike[str]] = (),
    ) -> None:
        stated = [(name, float(fact), isinstance(fact, (bool, np.bool_))) for name, fact in (facts or {}).items()]
        opening = {
            "tier": tier,
            "facts": stated,
            "outputs": [outputs] if isinstance(outputs, str) else list(outputs or []),
            "encoding": None if dtype is None else str(np.dtype(dtype)),
            "dither": dither,
            "adapter": adapter,
            "nodes": [os.fspath(folder) for folder in nodes],
            "allow": [os.fspath(folder) for folder in allow],
        }
        self._native = _native.Pipeline(os.fspath(source), opening)
        self._about: dict[str, Any] = json.loads(self._native.describe())
        self._is_alone = isinstance(outputs, str) or outputs is None and len(self._about["outputs"]) == 1
        self._last: tuple[int, float] | None = None
        self._cameras: dict[str, dict[str, Any]] = {}
        if warning := self._native.warnings():
            warnings.warn(warning, PipelineWarning, stacklevel=2)

    def __call__(
        self,
        image: Any = None,
        *,
        dt: float | None = None,
        frame: int | None = None,
        time: float | None = None,
        size: tuple[int, int] | None = None,
        values: Sequence[str] | None = None,
        inputs: Mapping[str, Any] | None = None,
        **named: Any,
    ) -> Any:
        """Renders a frame.

        `image` is for the first input: (H, W, 3) or (H, W, 4), float16 or float32, linear Rec.709, as NumPy arrays or
        what NumPy takes by DLPack or the buffer protocol. Four contiguous channels are not copied. Further inputs have
        their names, here or in `inputs`; data may be (H, W), volumes are (D, H, W, C), cameras are dicts. `size` is
        (width, height) for a pipeline without images.

        Without `dt` it is a single image: nothing of earlier calls has an effect. With `dt`, the seconds since the last
        call, it is the next frame of a sequence: histories and adaptation go on, until `reset`. `frame` is its number,
        from which noise is made; it counts from 0. `time` is in seconds since the start; without it, it is the sum of
        `dt`, or `frame` times `dt`.

        Four dimensions (N, H, W, C) are a batch of N images, or N frames of a sequence with `dt`.

        Returns an `Image`, or a dict of them by their names; with `values`, a tuple of that and of the values of these
        nodes, such as the exposure of a meter: stops, log2 of the metered luminance, lux, and 1 once it is valid.
        """
        given = {**(inputs or {}), **named}
        if image is not None:
            first = next((one["name"] for one in self._pictures() if one["name"] not in given), None)
            if first is None:
                raise ImageError("the pipeline takes no further image")
            given = {first: image, **given}
        unknown = [name for name in given if name not in self.inputs]
        if unknown:
            raise ImageError(f"the pipeline has no input `{unknown[0]}`; it has {_list(self.inputs)}")
        for one in self._about["inputs"]:
            if not one["optional"] and given.get(one["name"]) is None:
                what = "a camera" if one["camera"] else "an image"
                raise ImageError(f"the pipeline needs {what} for its input `{one['name']}`")
        arrays = {name: value for name, value in given.items() if value is not None}
        count = self._batch(arrays)
        if count is None:
            return self._frame(arrays, dt, frame, time, size, values)
        frames = []
        for index in range(count):
            pictures = [one["name"] for one in self._pictures()]
            of_frame = {name: value[index] if name in pictures else value for name, value in arrays.items()}
            number = None if frame is None else frame + index
            moment = None if time is None else time + index * (dt or 0.0)
            frames.append(self._frame(of_frame, dt, number, moment, size, values))
        return _stack(frames, values is not None)

    def _pictures(self) -> Iterator[dict[str, Any]]:
        return (one for one in self._about["inputs"] if not one["block"] and not one["volume"])

    def _batch(self, given: dict[str, Any]) -> int | None:
        """The number of images; None for a single frame."""
        counts = set()
        for one in self._pictures():
            if one["name"] in given:
                array = given[one["name"]] = _array(one["name"], given[one["name"]])
                counts.add(array.shape[0] if array.ndim == 4 else None)
        if len(counts) > 1:
            raise ImageError(f"batches have equal numbers of images for all inputs, not {counts}")
        return counts.pop() if counts else None

    def _frame(
        self,
        given: dict[str, Any],
        dt: float | None,
        frame: int | None,
        time: float | None,
        size: tuple[int, int] | None,
        values: Sequence[str] | None,
    ) -> Any:
        if dt is not None and not 0 <= dt < math.inf:
            raise ImageError(f"`dt` is a number of seconds, 0 or more, not {dt}")
        last = self._last if dt is not None else None
        number = frame if frame is not None else 0 if last is None else last[0] + 1
        if time is None:
            time = number * (dt or 0.0) if frame is not None or last is None else last[1] + (dt or 0.0)
        if not math.isfinite(time) or not 0 <= number <= 0xFFFFFFFF:
            raise ImageError(f"no frame has the number {number} and the time {time}")
        step = 0.0 if last is None else dt
        images, cameras, files = [], [], {}
        for one in self._about["inputs"]:
            name = one["name"]
            if name not in given:
                continue
            if one["camera"]:
                files[name] = _camera_file(name, given[name])
                cameras.append(_camera(name, files[name], self._cameras.get(name) if last is not None else None))
            else:
                images.append(_given(one, given[name]))
        if size is not None and any(not depth for _, _, (_, _, depth), _, _ in images):
            raise ImageError("`size` is for pipelines without an image; here the output has the size of the input")
        size = size or (1920, 1080)
        if min(size) < 1 or max(size) > 0xFFFFFFFF:
            raise ImageError(f"`size` is (width, height) of at least one pixel, not {size}")
        moment = {"time": time, "dt": step, "reset": last is None, "number": number}
        rendered, read = self._native.render(images, cameras, size, moment, list(values or []))
        if dt is not None:
            self._last, self._cameras = (number, time), files
        outputs = {}
        for name, numbers, shape, kind, state, color in rendered:
            output = numbers.view(kind).reshape(shape).view(Image)
            output.state, output.color = state, color
            outputs[name] = output
        result: Output = next(iter(outputs.values())) if self._is_alone else outputs
        if values is None:
            return result
        return result, {name: value and tuple(value) for name, value in zip(values, read)}

    def reset(self) -> None:
        """The next frame of a sequence is a first one: histories and adaptation begin anew."""
        self._last, self._cameras = None, {}

    def __getitem__(self, name: str) -> Any:
        """The value of `node.parameter`, or whether a node is on."""
        return self._native.get(name)

    def __setitem__(self, name: str, value: Any) -> None:
        """Sets `node.parameter`, or switches a node on or off, from the next frame on."""
        try:
            self._native.set(name, value.tolist() if isinstance(value, np.ndarray) else value)
        except ParameterError:
            raise
        except ValueError as error:
            raise ParameterError(str(error), json.dumps(getattr(error, "diagnostics", []))) from None
        except TypeError as error:
            raise ParameterError(f"`{name}` cannot be {value!r}: {error}") from None

    def __delitem__(self, name: str) -> None:
        """Makes a parameter or a node what it is in the pipeline's file again."""
        self._native.unset(name)

    @property
    def parameters(self) -> dict[str, Parameter]:
        """All parameters, by their names, `node.parameter`."""
        found = {}
        for one in json.loads(self._native.parameters()):
            domain, usual = (tuple(one[key]) if one[key] else None for key in ("domain", "usual"))
            more = {"domain": domain, "usual": usual, "choices": dict(one["choices"]), "value": self[one["name"]]}
            found[one["name"]] = Parameter(**{**one, **more})
        return found

    @property
    def tier(self) -> str | None:
        """The quality level; None is the pipeline as it is written. It can be set."""
        tier: str | None = json.loads(self._native.describe())["tier"]
        return tier

    @tier.setter
    def tier(self, tier: str | None) -> None:
        self._native.set_tier(tier)

    @property
    def tiers(self) -> dict[str, Claim | None]:
        """The quality levels by their names, with what the file claims of them."""
        return {one["name"]: one["claim"] and Claim(**one["claim"]) for one in self._about["tiers"]}

    def govern(
        self, ms: float | None, tiers: Sequence[str] = (), *, min_jod: float | None = None, display: str | None = None
    ) -> None:
        """Holds a budget of milliseconds from the next frame on, by the times that `report_frame_time` gets.

        `tiers` are those that may be chosen, from the worst picture to the best. A tier that claims less than
        `min_jod`, or nothing, is not chosen; 10 is no visible difference. `display` is that whose claims count, as the
        program's `measure --display` names it; None is any. No `ms` keeps the present tier from now on, as does setting
        `tier`.
        """
        self._native.govern(ms, list(tiers), min_jod, display)

    def report_frame_time(self, ms: float, dt: float) -> str | None:
        """Reports the milliseconds of the last frame, and the seconds since the frame before. The next frame may have
        another tier: returns the reason of that change."""
        return self._native.report_frame_time(ms, dt)

    @property
    def shortfall(self) -> str | None:
        """The reason why the limits of `govern` are not held at present; None if they are."""
        return self._native.shortfall()

    @property
    def facts(self) -> list[str]:
        """The names of the facts that `when` conditions ask for."""
        return list(self._about["facts"])

    def state(self, fact: str, value: bool | float) -> None:
        """States a fact, from the next frame on."""
        self._native.set_fact(fact, float(value), isinstance(value, (bool, np.bool_)))

    @property
    def inputs(self) -> list[str]:
        """The names of the inputs."""
        return [one["name"] for one in self._about["inputs"]]

    @property
    def outputs(self) -> list[str]:
        """The names of the outputs that are rendered."""
        return [one["name"] for one in self._about["outputs"]]

    @property
    def adapter(self) -> str:
        """The name of the graphics adapter. Opens it."""
        return self._native.adapter()

    def plan(self, size: tuple[int, int] = (1920, 1080)) -> _native.Plan:
        """What the pipeline does for half-float images of (width, height) on a typical GPU."""
        if min(size) < 1:
            raise ImageError(f"`size` is (width, height) of at least one pixel, not {size}")
        return self._native.plan(size)

    def measure(self, images: Sequence[Any] = (), *, tiers: bool = False, frames: int = 4) -> dict[str, Any]:
        """Time against error for each tier and each quality switch, or for tiers only: the report of the program's
        `measure --json`. `images` are paths or arrays; without any it is the built-in scene. `frames` is how often an
        image is shown to a pipeline with histories."""
        with tempfile.TemporaryDirectory() as folder:
            files = []
            for index, image in enumerate(images):
                if not isinstance(image, (str, os.PathLike)):
                    file = os.path.join(folder, f"image-{index}.exr")
                    write(file, _array("image", image))
                    image = file
                files.append(os.fspath(image))
            report: dict[str, Any] = json.loads(self._native.measure(files, tiers, max(frames, 1)))
            return report

    def __repr__(self) -> str:
        tier = f", tier={self.tier!r}" if self.tier else ""
        return f"Pipeline({self._about['name']!r}{tier}): {_list(self.inputs)} to {_list(self.outputs)}"

    def _repr_html_(self) -> str:
        return self.plan()._repr_html_()


def _list(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names) or "none"


def _array(name: str, value: Any) -> npt.NDArray[Any]:
    """The array of an input, without a copy where that is possible."""
    if not isinstance(value, np.ndarray):
        try:
            value = np.from_dlpack(value) if hasattr(value, "__dlpack__") else np.asarray(value)
        except (TypeError, ValueError, BufferError, RuntimeError) as error:
            raise ImageError(f"`{name}` is no array in the memory of the processor: {error}") from None
    if value.dtype.type not in (np.float16, np.float32):
        hint = "`astype(numpy.float32)`" if value.dtype.kind == "f" else "linear light; `afterimage.read` decodes files"
        raise ImageError(f"`{name}` has float16 or float32 numbers, not {value.dtype}: give {hint}")
    array: npt.NDArray[Any] = value
    return array


def _given(one: dict[str, Any], value: Any) -> tuple[str, npt.NDArray[np.uint8], tuple[int, int, int], int, str]:
    """An image as the native half takes it."""
    name, array = one["name"], _array(one["name"], value)
    if one["block"] or one["multisampled"]:
        raise ImageError(f"`{name}`: blocks other than cameras, and multisampled images, come from renderers only")
    is_data = one["state"] in ("Data", "LogLuminance")
    sides, shape = (3, "(D, H, W") if one["volume"] else (2, "(H, W")
    least = max(one["channels"], 1 if is_data else 3)
    channels = array.shape[sides] if array.ndim == sides + 1 else 1 if array.ndim == sides else 0
    if not least <= channels <= 4:
        wanted = " or ".join(str(count) for count in range(least, 5))
        raise ImageError(f"`{name}` has the shape {shape}, {wanted}), not {array.shape}")
    if array.size == 0:
        raise ImageError(f"`{name}` has no pixels: its shape is {array.shape}")
    finite = np.isfinite(array)
    if not finite.all():
        pixels = finite if array.ndim == sides else finite.all(axis=-1)
        count = int(pixels.size - np.count_nonzero(pixels))
        warnings.warn(f"`{name}`: pixels that are not finite are repaired: {count}", RepairWarning, stacklevel=4)
    kind = array.dtype.type.__name__
    if channels == 3 or channels == 2 and kind == "float32":
        array, channels = with_alpha(array), 4
    *depth, height, width = array.shape[:sides]
    return name, as_bytes(array), (width, height, depth[0] if depth else 0), channels, kind


def _camera_file(name: str, camera: Camera) -> dict[str, Any]:
    if isinstance(camera, Mapping):
        return dict(camera)
    try:
        with open(camera, encoding="utf-8") as file:
            return dict(json.load(file))
    except (OSError, TypeError, ValueError) as error:
        raise ImageError(f"`{name}` is no camera: {error}") from None


def _camera(name: str, camera: dict[str, Any], before: dict[str, Any] | None) -> _native._Camera:
    """The columns of a camera. What it does not state of the frame before is that of the last call."""
    before = before or camera

    def matrix(key: str, source: dict[str, Any]) -> list[list[float]]:
        rows = np.asarray(source[key], np.float32)
        if rows.shape != (4, 4):
            raise ImageError(f"`{name}`: `{key}` has four rows of four numbers, not the shape {rows.shape}")
        columns: list[list[float]] = rows.T.tolist()
        return columns

    def jitter(key: str, source: dict[str, Any]) -> list[float]:
        return [float(number) for number in source.get(key) or (0.0, 0.0)]

    try:
        has = {key for key, value in camera.items() if value is not None}
        return (
            name,
            matrix("view", camera),
            matrix("projection", camera),
            matrix("previous_view", camera) if "previous_view" in has else matrix("view", before),
            matrix("previous_projection", camera) if "previous_projection" in has else matrix("projection", before),
            jitter("jitter", camera),
            jitter("previous_jitter", camera) if "previous_jitter" in has else jitter("jitter", before),
        )
    except (KeyError, TypeError) as error:
        raise ImageError(f"`{name}` is no camera: it lacks {error}") from None


def _stack(frames: list[Any], has_values: bool) -> Any:
    """The frames of a batch in one array for each output, and the values of each frame."""
    if has_values:
        return _stack([output for output, _ in frames], False), [values for _, values in frames]
    if not frames:
        raise ImageError("the batch has no images")
    if isinstance(frames[0], dict):
        return {name: _stack([frame[name] for frame in frames], False) for name in frames[0]}
    stacked = np.stack(frames).view(Image)
    stacked.state, stacked.color = frames[0].state, frames[0].color
    return stacked
