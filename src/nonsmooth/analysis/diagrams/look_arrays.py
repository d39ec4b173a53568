"""Columns of a bifurcation diagram as arrays by name and back, for files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.columns import Look
from nonsmooth.engine.status import Status

__all__ = ["pack_looks", "unpack_looks"]

Arrays = dict[str, npt.NDArray[Any]]


def pack_looks(looks: Sequence[Look]) -> Arrays:
    """Arrays of looks, which may have any number of points each."""
    return {
        f"{i}.{field.name}": np.asarray(getattr(look, field.name))
        for i, look in enumerate(looks)
        for field in fields(Look)
    }


def unpack_looks(arrays: Mapping[str, npt.NDArray[Any]]) -> list[Look]:
    """The looks of arrays that `pack_looks` made."""
    names = [field.name for field in fields(Look)]
    return [
        Look(**{name: _value(name, arrays[f"{i}.{name}"]) for name in names})
        for i in range(len(arrays) // len(names))
    ]


def _value(name: str, array: npt.NDArray[Any]) -> Any:
    if array.ndim:
        return array
    return Status(array.item()) if name == "status" else array.item()
