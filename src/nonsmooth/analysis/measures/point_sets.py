"""A set of points out of whatever holds one: an array, points of a map, an attractor."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.statistics.sizes_by_rates import AT_REST, sizes_by_rates
from nonsmooth.errors import OptionError, quote, unknown_name
from nonsmooth.runs.options import whole_number
from nonsmooth.system.system import System
from nonsmooth.version import __version__

__all__ = ["Points", "points_of", "scaled"]

_CONSTANT = 1e-9  # of the size of a coordinate, an extent that is rounding

Points = npt.NDArray[np.float64]


def points_of(
    data: Any, attractor: int | None, states: Sequence[str] | None
) -> tuple[Points, dict[str, Any]]:
    """Points (K, n) that are finite, in order of time, and attributes that say whence."""
    attrs: dict[str, Any] = {"nonsmooth_version": __version__}
    if isinstance(data, xr.Dataset):
        attrs |= {key: data.attrs[key] for key in ("system", "system_name") if key in data.attrs}
        if "points" in data:
            values = _of_attractor(data, attractor, states)
        else:
            values = _of_states(data, states)
    elif states is not None or attractor is not None:
        raise OptionError("states= and attractor= choose from a dataset; leave them out")
    else:
        values = data.values if isinstance(data, xr.DataArray) else data
    try:
        numbers = np.asarray(values, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise OptionError(f"points = {quote(data)}: give a dataset or an array (K, n)") from None
    if numbers.ndim == 1:
        numbers = numbers[:, None]
    if numbers.ndim != 2 or numbers.size == 0:
        raise OptionError(
            f"points: an array of {numbers.ndim} dimensions with {numbers.size} values came; one"
            " row per point is needed"
        )
    return _finite(numbers, padded=isinstance(data, xr.Dataset)), attrs


def _finite(numbers: Points, padded: bool) -> Points:
    """The points, where all are finite; nan after the points of a dataset is left out."""
    if padded:
        numbers = numbers[:, ~np.isnan(numbers).all(axis=0)]
        numbers = numbers[~np.isnan(numbers).any(axis=1)]
    wrong = np.flatnonzero(~np.isfinite(numbers).all(axis=1))
    if wrong.size:
        raise OptionError(
            f"points: {wrong.size} of {len(numbers)} have a coordinate that is nan or infinite,"
            f" the first one in row {wrong[0]}; leave them out, or see why the motion diverged"
        )
    if numbers.size == 0:
        raise OptionError("points: all of them are nan; simulate the motion to see why")
    return numbers


def scaled(points: Points) -> Points:
    """Points with every coordinate from 0 to 1; those that are constant are left out."""
    low, extent = points.min(axis=0), np.ptp(points, axis=0)
    varies = extent > _CONSTANT * np.abs(points).max(axis=0)
    result: Points = (points[:, varies] - low[varies]) / extent[varies]
    return result


def _of_attractor(data: xr.Dataset, attractor: int | None, states: Any) -> Any:
    known = data["attractor"].values.tolist()
    if attractor is None:
        if len(known) != 1:
            raise OptionError(f"attractor= is needed; the dataset has {len(known)} of them")
        attractor = known[0]
    if whole_number("attractor", attractor) not in known:
        raise OptionError(
            f"attractor = {attractor}: the dataset has {', '.join(map(str, known)) or 'none'}"
        )
    chosen = data["points"].sel(attractor=attractor).transpose("point", "state")
    names = [str(name) for name in chosen["state"].values]
    if states is not None:
        return chosen.sel(state=_check_names(states, names)).values
    values = dict(zip(names, chosen.values.T, strict=True))
    has_modes = "mode" in data
    modes = data["mode"].sel(attractor=attractor).values if has_modes else None
    return _that_move(data, values, modes)


def _of_states(data: xr.Dataset, states: Any) -> Any:
    known = [
        str(name)
        for name, values in data.data_vars.items()
        if values.ndim == 1 and values.dtype.kind == "f"
    ]
    if not known:
        raise OptionError("the dataset holds no points: no variable has one dimension")
    names = _states_among(data, known) if states is None else _check_names(states, known)
    dims = {data[name].dims for name in names}
    if len(dims) != 1:
        raise OptionError(f"states = {quote(names)} are not over the same points")
    values = {name: data[name].values for name in names}
    if states is None:
        has_modes = "mode" in data and data["mode"].dims in dims
        return _that_move(data, values, data["mode"].values if has_modes else None)
    return np.stack(list(values.values()), axis=1)


def _states_among(data: xr.Dataset, names: list[str]) -> list[str]:
    """States among the names, where any are known: outputs tell nothing new."""
    if "system" not in data.attrs:
        return names
    return [name for name in System.from_toml(data.attrs["system"]).states if name in names]


def _that_move(data: xr.Dataset, values: dict[str, Points], modes: Any) -> Any:
    """Points (K, n) of the states that move; a drift has no end, and one at rest is rounding.

    modes: (K,), None where they are not known
    """
    points = np.stack(list(values.values()), axis=1)
    if "system" not in data.attrs:
        return points
    system = System.from_toml(data.attrs["system"])
    moving = ~np.isin(list(values), system.drift_states)
    here = np.flatnonzero(np.all(np.isfinite(points), axis=1))
    if modes is not None and list(values) == list(system.states) and here.size:
        natural = sizes_by_rates(system, points[here], int(modes[here[-1]]))
        moves = moving & (np.ptp(points[here], axis=0) > AT_REST * natural)
        moving = moves if np.any(moves) else moving
    return points[:, moving]


def _check_names(states: Any, known: list[str]) -> list[str]:
    names = [states] if isinstance(states, str) else states
    if not isinstance(names, Iterable):
        raise OptionError(
            f"states = {quote(states)}: give a name or a list of names out of {', '.join(known)}"
        )
    names = list(names)
    for name in names:
        if name not in known:
            raise OptionError(f"states: {unknown_name('state', name, known)}")
    if not names:
        raise OptionError(f"states= is empty; name some of {', '.join(known)}")
    return names
