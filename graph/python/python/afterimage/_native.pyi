"""The native half."""

from collections.abc import Sequence
from os import PathLike
from typing import Any

import numpy as np
import numpy.typing as npt

class Color:
    """What the numbers of an image mean: primaries, transfer function, white."""

class Plan:
    """What a pipeline does on a typical GPU. Notebooks draw it."""

    def text(self) -> str:
        """Passes, batches, barriers and memory as text."""

    def json(self) -> str:
        """The same as JSON."""

    def svg(self) -> str:
        """The same as a drawing."""

    def _repr_html_(self) -> str: ...

_Columns = Sequence[Sequence[float]]
_Camera = tuple[str, _Columns, _Columns, _Columns, _Columns, Sequence[float], Sequence[float]]
_Output = tuple[str, npt.NDArray[Any], list[int], str, str, Color]

class Pipeline:
    def __new__(cls, source: str, opening: dict[str, Any]) -> Pipeline: ...
    def warnings(self) -> str: ...
    def describe(self) -> str: ...
    def parameters(self) -> str: ...
    def get(self, name: str) -> Any: ...
    def set(self, name: str, value: Any) -> None: ...
    def unset(self, name: str) -> None: ...
    def set_tier(self, tier: str | None) -> None: ...
    def govern(self, ms: float | None, tiers: Sequence[str], min_jod: float | None, display: str | None) -> None: ...
    def report_frame_time(self, ms: float, dt: float) -> str | None: ...
    def shortfall(self) -> str | None: ...
    def set_fact(self, name: str, number: float, is_flag: bool) -> None: ...
    def render(
        self,
        images: Sequence[tuple[str, npt.NDArray[np.uint8], tuple[int, int, int], int, str]],
        cameras: Sequence[_Camera],
        size: tuple[int, int],
        moment: dict[str, Any],
        values: Sequence[str],
    ) -> tuple[list[_Output], list[tuple[float, float, float, float] | None]]: ...
    def plan(self, size: tuple[int, int]) -> Plan: ...
    def measure(self, images: Sequence[str], tiers_only: bool, frames: int) -> str: ...
    def adapter(self) -> str: ...

def built_in() -> list[tuple[str, str]]: ...
def read(path: str | PathLike[str], layer: str | None) -> tuple[npt.NDArray[Any], int, int, str, list[str]]: ...
def write_exr(
    path: str | PathLike[str],
    numbers: npt.NDArray[np.uint8],
    size: tuple[int, int],
    ty: str,
    state: str,
    color: Color | None,
) -> None: ...
def write_png(
    path: str | PathLike[str] | None,
    codes: npt.NDArray[np.uint16],
    size: tuple[int, int],
    channels: int,
    bits: int,
    color: Color | None,
) -> bytes: ...
