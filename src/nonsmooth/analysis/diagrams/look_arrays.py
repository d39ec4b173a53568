"""Columns of a bifurcation diagram as arrays by name and back, for files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.chain_links import End, pack_end, take_end
from nonsmooth.analysis.diagrams.columns import Look
from nonsmooth.engine.status import Status

__all__ = ["pack_looks", "unpack_looks"]

Arrays = dict[str, npt.NDArray[Any]]


def pack_looks(found: tuple[Sequence[Look], End | None]) -> Arrays:
    """Arrays of looks, with any number of points each, and of where the last one has ended."""
    looks, end = found
    return pack_end(end) | {
        f"{i}.{field.name}": np.asarray(getattr(look, field.name))
        for i, look in enumerate(looks)
        for field in fields(Look)
    }


def unpack_looks(arrays: Mapping[str, npt.NDArray[Any]]) -> tuple[list[Look], End | None]:
    """The looks and the end of arrays that `pack_looks` made."""
    end, arrays = take_end(arrays)
    names = [field.name for field in fields(Look)]
    return [
        Look(**{name: _value(name, arrays[f"{i}.{name}"]) for name in names})
        for i in range(len(arrays) // len(names))
    ], end


def _value(name: str, array: npt.NDArray[Any]) -> Any:
    if array.ndim:
        return array
    return Status(array.item()) if name == "status" else array.item()
