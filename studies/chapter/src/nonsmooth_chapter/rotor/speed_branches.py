"""Branches of orbits of set A over eta, stable or not: the lines of Fig. 36."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import xarray as xr

from nonsmooth import System, continue_orbit, ensemble
from nonsmooth_chapter.rotor.data import set_a
from nonsmooth_chapter.rotor.speed_sweeps import last_strobe

__all__ = ["branches_at_strobes", "branches_of_set_a"]

_SPAN = (2.0, 5.0)
_SETTLED = 1500  # periods from zero
# Period, an eta at which zero leads to such an orbit, the range over which it is followed, and
# steps either way; period two from where period one flips, period three only around its stable
# parts, which lie on closed curves near eta = 2.2.
_STARTS = {
    0.0: ((1, 2.05, _SPAN, 60), (2, 3.05, _SPAN, 120), (3, 2.18, (2.0, 2.5), 30),
          (3, 4.5, (3.5, 5.0), 90)),
    0.1: ((1, 2.05, _SPAN, 60), (2, 3.05, _SPAN, 120), (3, 2.3, (2.0, 2.5), 50),
          (3, 4.7, (3.5, 5.0), 90)),
}  # fmt: skip
_STEP = 0.02
_BEHIND = 1e-6  # of eta, where the doubled orbit is told from the single one
_SHOWN = ("flip", "fold", "torus")
_CRITICAL = 1e-6  # of a multiplier from the unit circle; at a graze a branch may turn with others


@lru_cache(maxsize=4)
def branches_of_set_a(delta: float, longest: int = 3) -> dict[int, list[xr.Dataset]]:
    """Branches of the orbits of period one, two and three that set A settles to.

    Parameters
    ----------
    delta : float
        Preload along both axes, 0 or 0.1.
    longest : int, optional
        Longest period that is followed.

    Returns
    -------
    dict of int to list of xarray.Dataset
        By period, as from `continue_orbit`.

    Examples
    --------
    >>> branches = branches_of_set_a(0.1, longest=1)
    >>> kinds = branches[1][0]["special_kind"].values
    >>> [str(kind) for kind in kinds]
    ['bound', 'flip', 'bound']
    """
    found: dict[int, list[xr.Dataset]] = {}
    for period, eta, (low, high), steps in _STARTS[delta]:
        if period > longest:
            continue
        if period == 2:
            flips = found[1][0]["special_kind"].values == "flip"
            low = float(found[1][0]["special_value"].values[flips][0]) + _BEHIND
        system = set_a(delta, eta)
        branch = continue_orbit(
            system, "eta", (low, high), initial=last_strobe(system, _SETTLED), period=period,
            steps=steps, step=_STEP, largest_step=_STEP,
        )  # fmt: skip
        found.setdefault(period, []).append(branch)
    return found


def branches_at_strobes(system: System, branches: Sequence[xr.Dataset]) -> xr.Dataset:
    """One branch for plots with all strobes of some branches of one period.

    Parameters
    ----------
    system : System
        The rotor.
    branches : sequence of xarray.Dataset
        As from `continue_orbit`.

    Returns
    -------
    xarray.Dataset
        ``x`` and ``stable`` over ``point``, strobe after strobe with a gap (nan) between them;
        flips, folds and tori as special points.

    Examples
    --------
    >>> from nonsmooth import continue_orbit
    >>> system = set_a(0.1, eta=2.05)
    >>> branch = continue_orbit(system, "eta", (2.0, 2.1), transient=300)
    >>> branches_at_strobes(system, [branch]).sizes["point"] == branch.sizes["point"] + 1
    True
    """
    parts: dict[str, list[np.ndarray]] = {name: [] for name in ("eta", "x", "stable")}
    marks: dict[str, list[np.ndarray]] = {name: [] for name in ("kind", "value", "point")}
    done = 0
    for branch in branches:
        period, eta = int(branch.attrs["period"]), branch["eta"].values
        strobes = ensemble(
            system, {name: branch[name].values.tolist() for name in system.states},
            parameters={"eta": eta.tolist()}, combine="pairs", record=period,
        )["x"].transpose("lane", "point").values  # fmt: skip
        shown = _shown(branch)
        number = np.arange(eta.size)
        for x in strobes.T:
            there = np.isfinite(x)  # a start where two events coincide may be refused
            x = np.interp(number, number[there], x[there])
            for name, values in (("eta", eta), ("x", x), ("stable", branch["stable"].values)):
                parts[name] += [values, np.array([0.0 if name == "stable" else np.nan])]
            marks["kind"].append(branch["special_kind"].values[shown])
            marks["value"].append(branch["special_value"].values[shown])
            marks["point"].append(done + branch["special_point"].values[shown])
            done += eta.size + 1
    variables = {name: ("point", np.concatenate(each)) for name, each in parts.items()}
    variables |= {f"special_{k}": ("special", np.concatenate(v)) for k, v in marks.items()}
    variables["stable"] = ("point", variables["stable"][1].astype(bool))
    return xr.Dataset(variables, attrs={"parameter": "eta"})


def _shown(branch: xr.Dataset) -> np.ndarray:
    kind, value = branch["special_kind"].values, branch["special_multiplier"].values
    return np.isin(kind, _SHOWN) & (np.abs(np.abs(value) - 1.0) < _CRITICAL)
