"""Scores of windows: how far their indicators lie from those of healthy windows."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.errors import OptionError
from nonsmooth.runs.options import finite_number

__all__ = ["Healthy", "Reference", "healthy_scores", "share_between", "windows_of"]

Floats = npt.NDArray[np.float64]

_TRAINING = 0.5  # of one healthy record


class Reference(NamedTuple):
    """Healthy windows that set the scale: mean, spread, and the inverse of the correlation."""

    mean: Floats
    spread: Floats
    inverse: Floats

    def standardised(self, values: Floats) -> Floats:
        """Deviations of each indicator from its mean, in its spread."""
        scaled: Floats = (values - self.mean) / self.spread
        return scaled

    def score(self, values: Floats) -> Floats:
        """Mahalanobis distance of each window."""
        z = self.standardised(values)
        distance: Floats = np.sqrt(np.einsum("ij,jk,ik->i", z, self.inverse, z))
        return distance


class Healthy(NamedTuple):
    """Reference for further windows, and scores of healthy windows that it does not know."""

    names: list[str]
    reference: Reference
    runs: list[Floats]  # in order of time, one for each record
    n_training: int


def healthy_scores(healthy: Any, training: float | None) -> Healthy:
    """Scores of held-out healthy windows: the rest of one record, or each record by the others."""
    sets = [healthy] if isinstance(healthy, xr.Dataset) else _several(healthy)
    names = _indicators(sets[0], "healthy")
    tables = [_table(one, names, "healthy") for one in sets]
    least = np.array([float(sets[0][name].attrs.get("resolution", 0.0)) for name in names])
    if len(tables) == 1:
        share = share_between("training", _TRAINING if training is None else training)
        (table,) = tables
        cut = int(share * table.shape[0])
        reference = _reference(table[:cut], names, least, "a larger training=")
        return Healthy(names, reference, [reference.score(table[cut:])], cut)
    if training is not None:
        raise OptionError(
            "training= is for one healthy record; of several, each is scored by all others"
        )
    whole = np.concatenate(tables)
    runs = []
    for k, table in enumerate(tables):
        others = np.concatenate(tables[:k] + tables[k + 1 :])
        runs.append(_reference(others, names, least, "more records").score(table))
    return Healthy(names, _reference(whole, names, least, "more records"), runs, whole.shape[0])


def _reference(values: Floats, names: list[str], least: Floats, more: str) -> Reference:
    """Mean, spread and correlation, the last shrunk by the share p / (n + p) of the identity.

    least: resolution of each indicator, below which no spread counts; 0 where it is not known
    """
    count, width = values.shape
    if count < width + 2:
        raise OptionError(
            f"healthy: {count} windows for mean and covariance are too few for {width} indicators;"
            f" give at least {width + 2} of them, or {more}"
        )
    mean, spread = values.mean(axis=0), values.std(axis=0, ddof=1)
    spread[np.ptp(values, axis=0) == 0.0] = 0.0  # without the rounding of the mean
    spread = np.maximum(spread, least)
    still = [name for name, one in zip(names, spread, strict=True) if one == 0.0]
    if still:
        raise OptionError(f"healthy: the indicator {still[0]} does not vary; leave it out")
    z = (values - mean) / spread
    share = width / (count + width)
    correlation = (1.0 - share) * (z.T @ z) / (count - 1)
    np.fill_diagonal(correlation, 1.0)  # also of what varies by less than its resolution
    return Reference(mean, spread, np.linalg.inv(correlation))


def windows_of(watched: Any, names: list[str], option: str) -> tuple[list[Floats], dict[str, Any]]:
    """Values of one dataset or of several in their order, and the coordinates that all have.

    Of several, ``record`` is the number of the dataset that a window comes from.
    """
    sets = [watched] if isinstance(watched, xr.Dataset) else _several(watched, option)
    tables = [_table(one, names, option) for one in sets]
    coords: dict[str, Any] = {}
    for name, values in sets[0].coords.items():
        if values.dims == ("window",) and all(name in one.coords for one in sets):
            whole = np.concatenate([one[name].values for one in sets])
            coords[str(name)] = "window", whole, dict(values.attrs)
    if len(sets) > 1:
        numbers = np.repeat(np.arange(len(sets)), [one.shape[0] for one in tables])
        coords["record"] = "window", numbers, {"long_name": "record, from 0"}
    return tables, coords


def share_between(name: str, value: Any) -> float:
    """A number between 0 and 1, without both."""
    number = finite_number(name, value)
    if not 0.0 < number < 1.0:
        raise OptionError(f"{name} = {number:g} must lie between 0 and 1")
    return number


def _several(healthy: Any, option: str = "healthy") -> list[Any]:
    sets = list(healthy) if isinstance(healthy, Iterable) and not isinstance(healthy, str) else []
    if not sets:
        raise OptionError(f"{option}: give a dataset over window, or a list of such datasets")
    return sets


def _indicators(data: Any, option: str) -> list[str]:
    """Variables over ``window``."""
    if not isinstance(data, xr.Dataset) or "window" not in data.dims:
        raise OptionError(f"{option}: give a dataset with indicators over window")
    if not data.sizes["window"]:
        raise OptionError(
            f"{option}: a dataset has no windows; give records that are longer than a window, or"
            " leave it out"
        )
    names = [str(name) for name, one in data.data_vars.items() if one.dims == ("window",)]
    if not names:
        raise OptionError(f"{option}: no variable of the dataset lies over window alone")
    return names


def _table(data: Any, names: list[str], option: str) -> Floats:
    """Values by window and indicator."""
    there = _indicators(data, option)
    missing = [name for name in names if name not in there]
    if missing:
        raise OptionError(f"{option}: the indicator {missing[0]} is missing; it has {there}")
    if any(data[name].dtype.kind not in "biuf" for name in names):
        raise OptionError(f"{option}: indicators must be real numbers")
    table = np.column_stack([data[name].values.astype(float) for name in names])
    if not np.isfinite(table).all():
        raise OptionError(f"{option}: an indicator is not finite; leave such windows out")
    return table
