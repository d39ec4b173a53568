"""Claim on the period halvings of Fig. 7: on which side of each flip the doubled orbit lies."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise

import numpy as np
import xarray as xr

from nonsmooth import continue_orbit, simulate
from nonsmooth.models import moling
from nonsmooth_chapter.judgement import Check, Evidence, Finding

__all__ = ["CHECKS", "cascade"]

_RANGE = (0.09, 0.2)
_NEAR = 1e-3  # of b, from the flip, within which the doubled orbit tells


@lru_cache(maxsize=1)
def cascade(doublings: int = 2) -> tuple[xr.Dataset, ...]:
    """Branches of period one, two, ... over b for the other parameters of Fig. 7.

    Parameters
    ----------
    doublings : int, optional
        How many times to change to the doubled orbit.

    Returns
    -------
    tuple of xarray.Dataset

    Examples
    --------
    >>> [branch.attrs["period"] for branch in cascade()]
    [1, 2, 4]
    """
    mole = moling(a=0.3, b=0.15, xi=0.05, omega=0.1)
    branches = [continue_orbit(mole, "b", _RANGE)]
    for _ in range(doublings):
        last = branches[-1]
        flip = int(np.flatnonzero(last["special_kind"].values == "flip")[0])
        branches.append(continue_orbit(mole, "b", _RANGE, initial=last, special=flip))
    return tuple(branches)


def _flips(reach: float = 2e-3, points: int = 17) -> Evidence:
    branches = cascade()
    rows = []
    for single, double in pairwise(branches):
        k = int(np.flatnonzero(single["special_kind"].values == "flip")[0])
        flip, place = float(single["special_value"][k]), int(single["special_point"][k])
        near = np.abs(double["b"].values - flip) < _NEAR
        near &= np.abs(double["b"].values - flip) > 1e-9  # not the flip itself
        rows.append(
            {
                "period": int(single.attrs["period"]),
                "b": flip,
                "doubled_points": int(near.sum()),
                "doubled_below": int((double["b"].values[near] < flip).sum()),
                "doubled_stable": int(double["stable"].values[near].sum()),
                "single_stable": _beside(single, place, flip),
                **_normal_form(single.isel(point=place), flip, reach, points),
            }
        )
    return {"rows": rows}


def _beside(branch: xr.Dataset, place: int, flip: float) -> dict[str, bool]:
    """Whether the orbits next to a flip are stable, below and above it."""
    sides = {}
    for k in (place - 1, place + 1):
        side = "below" if float(branch["b"][k]) < flip else "above"
        sides[side] = bool(branch["stable"][k])
    return sides


def _normal_form(orbit: xr.Dataset, b: float, reach: float, points: int) -> Evidence:
    """Derivatives of the return map along its one direction, by a polynomial through motions.

    The phases of a turn contract all other directions to nothing, so that from the first return
    on motions lie on a curve, and the map is one of the velocity alone.
    """
    mole = moling(b=b)
    turns = round(float(orbit["length"]) / (2.0 * np.pi / mole.parameter_values["omega"]))
    middle = {name: float(orbit[name]) for name in "pyq"}
    steps = reach * np.cos(np.pi * (np.arange(points) + 0.5) / points)
    before, behind = [], []
    for step in steps:
        start = {**middle, "y": middle["y"] + step}
        run = simulate(
            mole, start, periods=2 * turns, samples_per_period=1, events=False, mode=_mode(orbit)
        )
        before.append(float(run["y"][turns]))
        behind.append(float(run["y"][2 * turns]))
    away = np.array(before) - middle["y"]
    scale = np.abs(away).max()
    fit = np.polynomial.Polynomial.fit(away / scale, np.array(behind) - middle["y"], 6)
    first, second, third = (float(fit.deriv(n)(0.0)) / scale**n for n in (1, 2, 3))
    return {"slope": float(first), "coefficient": float(0.5 * second**2 + third / 3.0)}


def _mode(orbit: xr.Dataset) -> str:
    names = orbit["leg_mode"].attrs["flag_meanings"].split()
    return str(names[int(orbit["leg_mode"].values[0])])


def _judge_flips(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    by_branch = [row["doubled_stable"] == 0 for row in rows]  # subcritical: unstable
    by_form = [row["coefficient"] < 0.0 for row in rows]
    listed = "; ".join(
        f"{2 * row['period']} to {row['period']} at b = {row['b']:.9f}: the orbit of twice the"
        f" period lies below it at {row['doubled_below']} of {row['doubled_points']} places and is"
        f" stable at {row['doubled_stable']}, the single one is unstable"
        f" {' and '.join(side for side, stable in row['single_stable'].items() if not stable)};"
        " slope of the return map"
        f" {row['slope']:.4f}, coefficient {row['coefficient']:+.3g}"
        for row in rows
    )
    true = all(by_branch) and all(by_form)
    text = "" if true else "; supercritical: read with b falling, stable orbits of twice the period"
    return Finding(true, listed + text)


CHECKS = (
    Check(
        "M14",
        "a .3, xi .05, omega .1; branches of periods one, two and four over b from .09, the doubled"
        " orbit within .001 of each flip; beside it the sign of f''^2/2 + f'''/3 for the return map"
        " of the velocity; subcritical: the doubled orbit is unstable, the coefficient negative",
        _flips,
        _judge_flips,
    ),
)
