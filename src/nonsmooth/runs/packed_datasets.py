"""Datasets as arrays by name and back, to the bit: what a store keeps of them.

A netCDF file has no complex numbers and no numbers of one byte among its attributes, and HDF5 does
not survive a full disk; a store has neither trouble, see `nonsmooth.runs.store`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["pack_dataset", "unpack_dataset"]

_PLAN, _VALUES = "dataset", "values."  # names of arrays: all but the values, and those
_TYPE, _LIST = "numpy_type", "list"  # keys of a value of numpy among the attributes


def pack_dataset(data: xr.Dataset) -> dict[str, npt.NDArray[Any]]:
    """Arrays of a dataset; it has no other indices than those that its coordinates make."""
    plan = {
        "attrs": _plain(data.attrs),
        "coords": [str(name) for name in data.coords],
        "variables": {
            str(name): {"dims": list(each.dims), "attrs": _plain(each.attrs)}
            for name, each in data.variables.items()
        },
    }
    values = {f"{_VALUES}{name}": each.values for name, each in data.variables.items()}
    return {_PLAN: np.array(json.dumps(plan)), **values}


def unpack_dataset(arrays: Mapping[str, npt.NDArray[Any]]) -> xr.Dataset:
    """The dataset of arrays that `pack_dataset` made."""
    import xarray as xr

    plan = json.loads(arrays[_PLAN].item())
    variables = {
        name: (each["dims"], arrays[f"{_VALUES}{name}"], _restored(each["attrs"]))
        for name, each in plan["variables"].items()
    }
    coords = {name: variables.pop(name) for name in plan["coords"]}
    return xr.Dataset(variables, coords, _restored(plan["attrs"]))


def _plain(attrs: Mapping[Any, Any]) -> dict[str, Any]:
    """Attributes as JSON has them; floats keep all their digits there."""
    return {str(name): _plain_value(value) for name, value in attrs.items()}


def _plain_value(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        return {_TYPE: value.dtype.str, _LIST: value.tolist()}
    return value


def _restored(attrs: Mapping[str, Any]) -> dict[str, Any]:
    return {name: _restored_value(value) for name, value in attrs.items()}


def _restored_value(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    array = np.array(value[_LIST], np.dtype(value[_TYPE]))
    return array if array.ndim else array[()]
