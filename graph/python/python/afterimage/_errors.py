"""The exceptions of the package. Each text says what is wrong and, where it is known, what to do."""

from __future__ import annotations

import json
from typing import Any


class Error(Exception):
    """The base of all exceptions here."""

    diagnostics: list[dict[str, Any]]
    """For errors in pipelines: `code`, `severity`, `message`, `labels` and, if there is a hint, `help`. A label has
    `file`, `line`, `column`, `end_line`, `end_column` (from 1, columns in characters), `start`, `end` (bytes from 0),
    `primary` and `text`."""

    def __init__(self, text: str, diagnostics: str = "[]") -> None:
        super().__init__(text)
        self.diagnostics = json.loads(diagnostics)

    def __str__(self) -> str:
        return str(self.args[0])


class PipelineError(Error, ValueError):
    """A pipeline is not valid, or cannot be planned for these images."""


class ParameterError(PipelineError, KeyError):
    """There is no parameter, output, value or fact of that name, or it cannot have that value."""


class ImageError(Error, ValueError):
    """An image, a camera or a size that the pipeline cannot take."""


class FileError(Error, OSError):
    """A file cannot be read or written."""


class DeviceError(Error, RuntimeError):
    """There is no graphics device, or it is lost or out of memory."""


class PipelineWarning(UserWarning):
    """Something in a pipeline is probably not what is meant."""


class RepairWarning(UserWarning):
    """An image has pixels that are not finite. The pipeline repairs them."""
