"""Points in order out of whatever holds them: one a period of a run, a section, a list."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.statistics.sizes_by_rates import sizes_by_rates
from nonsmooth.errors import OptionError, quote, unknown_name
from nonsmooth.runs.whole_turns import cuts_of, folded, periods_of
from nonsmooth.system.system import System

__all__ = ["StrobePoints", "strobe_points"]

_SAME_PHASE = 1e-9  # of a period
_SAME_STEP = 1e-6  # of a step, between samples that count as equidistant

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class StrobePoints:
    """Points, their dataset without other samples, and which variables they are."""

    values: Floats  # (K, d)
    names: tuple[str, ...]
    dim: str = "point"
    data: xr.Dataset = field(default_factory=xr.Dataset)
    slow: tuple[str, ...] = ()  # parameters of the dataset that vary from point to point
    natural: Floats = field(default_factory=lambda: np.zeros(0))  # (d,): natural sizes, or zero


def strobe_points(data: Any, variables: Any) -> StrobePoints:
    """Points of a run with one sample per period, of a map or section, or of an array."""
    if not isinstance(data, xr.Dataset):
        return _of_array(data, variables)
    dims = [dim for dim in ("time", "point") if dim in data.dims]
    if not dims:
        raise OptionError(
            f"data: a dataset over {', '.join(map(str, data.dims)) or 'nothing'}; give a run or"
            " the result of stroboscopic_map, over time or point"
        )
    dim = dims[0]
    system = System.from_toml(data.attrs["system"]) if "system" in data.attrs else None
    data = _one_per_period(data, dim)
    known = [str(n) for n, v in data.data_vars.items() if v.dims == (dim,) and v.dtype.kind == "f"]
    slow = tuple(n for n in (system.slow if system else ()) if n in known)
    if variables is None:
        drifting = system.drift_states if system else ()
        states = system.states if system else [n for n in known if n not in slow]
        names = [n for n in states if n in known and n not in drifting]
    else:
        names = [variables] if isinstance(variables, str) else _listed(variables)
    for name in names:
        if name not in known:
            raise OptionError(f"variables: {unknown_name('variable', name, known)}")
    if not names:
        raise OptionError(f"variables: name some of {', '.join(known)}")
    if data.sizes[dim] == 0:
        raise OptionError(f"data: there are no points over {dim}; give a run that has samples")
    values = np.stack([data[name].values.astype(float) for name in names], axis=1)
    natural = _natural_sizes(data, names, system)
    values = _within_turns(_finite(values, names), names, system)
    return StrobePoints(values, tuple(names), dim, data, slow, natural)


def _natural_sizes(data: xr.Dataset, names: list[str], system: System | None) -> Floats:
    """Natural sizes of some variables, zero where none is known, as of outputs."""
    if system is None or not {*system.states, "mode"}.issubset(data):
        return np.zeros(len(names))
    states = np.stack([data[name].values.astype(float) for name in system.states], axis=1)
    if not np.all(np.isfinite(states)):
        return np.zeros(len(names))
    sizes = sizes_by_rates(system, states, int(data["mode"].values[-1]))
    known = dict(zip(system.states, sizes.tolist(), strict=True))
    return np.array([known.get(name, 0.0) for name in names])


def _within_turns(values: Floats, names: list[str], system: System | None) -> Floats:
    """Values whose angles lie within one turn, cut open where no points are: what turns repeats."""
    if system is None:
        return values
    periods = periods_of(system, names)
    return folded(values, cuts_of(values, periods), periods)


def _listed(variables: Any) -> list[str]:
    if not isinstance(variables, Iterable):
        raise OptionError(f"variables = {quote(variables)}: give a name, or a list of names")
    return [str(name) for name in variables]


def _of_array(data: Any, variables: Any) -> StrobePoints:
    if variables is not None:
        raise OptionError(f"variables = {quote(variables)}: data without names; leave it out")
    try:
        values = np.asarray(data, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise OptionError(f"data = {quote(data)}: give a run, or an array of points") from None
    if values.ndim not in (1, 2):
        raise OptionError(
            f"data: an array over {values.ndim} dimensions; give numbers in order, or points as"
            " rows of an array"
        )
    if values.size == 0:
        raise OptionError("data: an array without points; give numbers in order, or points as rows")
    values = values.reshape(len(values), -1)
    names = tuple(f"column {k}" for k in range(values.shape[1]))
    return StrobePoints(_finite(values, list(names)), names, natural=np.zeros(len(names)))


def _finite(values: Floats, names: list[str]) -> Floats:
    bad = np.argwhere(~np.isfinite(values))
    if bad.size:
        row, column = bad[0]
        raise OptionError(
            f"data: {names[column]} is {values[row, column]:g} at point {row}; give a part of it"
            " in which all numbers are finite"
        )
    return values


def _one_per_period(data: xr.Dataset, dim: str) -> xr.Dataset:
    """The samples at the phase of the last one; without phases, samples in equal steps."""
    if dim == "point":
        return data
    period = data.attrs.get("period")
    if "phase" in data and period is not None and data.sizes[dim]:
        phase = data["phase"].values
        window = float(data.attrs.get("window", period))
        if data.attrs.get("slow_values"):  # periods that change have phases of their own
            parts = int(data.attrs.get("samples_per_period", 1))
            return data if parts == 1 else data.isel({dim: phase == 0.0})
        away = np.abs(phase - phase[-1])
        return data.isel({dim: np.minimum(away, window - away) < _SAME_PHASE * window})
    steps = np.diff(data["time"].values)
    if steps.size and steps.max() - steps.min() > _SAME_STEP * steps.mean():
        raise OptionError(
            "the samples are not equidistant; simulate with samples_per_period=1, or with times="
            " at multiples of the period of the forcing"
        )
    return data
