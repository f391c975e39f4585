"""Afterimage for Python: post-processing pipelines on NumPy arrays.

    import afterimage as ai

    look = ai.Pipeline("tsushima", tier="high")
    look["lit.strength"] = 0.02
    picture = look(image)  # (H, W, 3 or 4), float16 or float32, linear Rec.709
"""

from ._errors import (
    DeviceError,
    Error,
    FileError,
    ImageError,
    ParameterError,
    PipelineError,
    PipelineWarning,
    RepairWarning,
)
from ._image import Image, read, write
from ._native import Plan, built_in as _built_in
from ._pipeline import Claim, Parameter, Pipeline

__all__ = [
    "PIPELINES",
    "Claim",
    "DeviceError",
    "Error",
    "FileError",
    "Image",
    "ImageError",
    "Parameter",
    "ParameterError",
    "Pipeline",
    "PipelineError",
    "PipelineWarning",
    "Plan",
    "RepairWarning",
    "read",
    "write",
]

PIPELINES: dict[str, str] = dict(_built_in())
"""The built-in pipelines: their names and their texts."""
