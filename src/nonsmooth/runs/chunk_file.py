"""Arrays in one file, as numpy's ``.npz``: there whole or not at all, and checked when read."""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.files import replacing

__all__ = ["Damaged", "read_arrays", "write_arrays"]

_SUFFIX = ".npy"  # of the arrays within the file, as `numpy.load` expects it
_DIGITS = 64  # of a checksum over all that stands before it, the comment at the end of the file


class Damaged(Exception):
    """A file that does not hold what was written; says what is wrong with it."""


def write_arrays(path: Path, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
    """Write arrays by name; nothing in them needs pickle."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, array in arrays.items():
            with archive.open(name + _SUFFIX, "w", force_zip64=True) as file:
                np.lib.format.write_array(file, np.asarray(array), allow_pickle=False)
        archive.comment = b"0" * _DIGITS
    content = buffer.getbuffer()
    content[-_DIGITS:] = _checksum(content[:-_DIGITS])
    with replacing(path) as draft:
        draft.write_bytes(content)


def read_arrays(path: Path) -> dict[str, npt.NDArray[Any]]:
    """Arrays of a file by name; `Damaged` where a single bit of it has changed."""
    try:
        content = memoryview(path.read_bytes())
    except OSError as fault:
        raise Damaged(fault.strerror) from None
    if len(content) < _DIGITS or content[-_DIGITS:] != _checksum(content[:-_DIGITS]):
        raise Damaged("its checksum is wrong")
    with np.load(io.BytesIO(content), allow_pickle=False) as archive:
        return dict(archive.items())


def _checksum(content: memoryview) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()
