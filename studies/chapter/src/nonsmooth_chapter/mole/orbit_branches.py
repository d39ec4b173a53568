"""Branches of the mole's period-one orbits with the four phases of Fig. 9: those of Fig. 10.

Stable or not, motions or not: the word is kept where the motion leaves it, as the chapter's
algorithm does. The turn is cut in the flight, halfway through the period of the forcing, which is
the longest phase.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import xarray as xr

from nonsmooth import continue_orbit, find_orbit
from nonsmooth.models import moling

__all__ = [
    "FOUR_PHASES",
    "best_stable",
    "branches_of_panel",
    "first_sheet",
    "four_phase_branch",
    "near_observed",
    "observed",
    "turn_word",
]

FOUR_PHASES = "progression contact no_contact contact"
_WORD, _PHASE = "no_contact contact progression contact no_contact", 0.5
_STEPS = 1000


@lru_cache(maxsize=64)
def four_phase_branch(
    parameter: str,
    between: tuple[float, float],
    *,
    a: float = 0.3,
    b: float = 0.15,
    xi: float = 0.01,
    omega: float = 0.1,
) -> xr.Dataset:
    """Period-one orbits of four phases over a parameter.

    Parameters
    ----------
    parameter : str
        ``"a"``, ``"b"`` or ``"omega"``.
    between : (float, float)
        Its range.
    a, b, xi, omega : float, optional
        Parameters; the branch over a or b begins where a = 2 b, whatever is given, and that over
        omega at the value given.

    Returns
    -------
    xarray.Dataset
        As from `continue_orbit`, inadmissible parts included.

    Examples
    --------
    >>> branch = four_phase_branch("b", (0.1, 0.2), xi=0.05)
    >>> [str(kind) for kind in branch["special_kind"].values if kind in ("flip", "fold")][:2]
    ['flip', 'fold']
    """
    values = {"a": a, "b": b, "xi": xi, "omega": omega}
    if parameter == "b":
        values["b"] = 0.5 * a
    elif parameter == "a":
        values["a"] = 2.0 * b
    start = _orbit(values)
    return continue_orbit(
        moling(**values), parameter, between, initial=start, word=_WORD, phase=_PHASE,
        inadmissible=True, steps=_STEPS,
    )  # fmt: skip


def _orbit(values: dict[str, float]) -> xr.Dataset:
    """Orbit of four phases, reached from where it is stable: a = 2 b."""
    easy = {**values, "a": 2.0 * values["b"]}
    start = find_orbit(moling(**easy), word=_WORD, phase=_PHASE)
    if values["a"] == easy["a"]:
        return start
    ends = (min(values["a"], easy["a"]), max(values["a"], easy["a"]))
    way = continue_orbit(
        moling(**easy), "a", ends, initial=start, word=_WORD, phase=_PHASE, inadmissible=True,
        direction="up" if values["a"] > easy["a"] else "down",
    )  # fmt: skip
    nearest = int(np.abs(way["a"].values - values["a"]).argmin())
    return find_orbit(moling(**values), way.isel(point=nearest), word=_WORD, phase=_PHASE)


def branches_of_panel(
    parameter: str, between: tuple[float, float], curve: str, values: tuple[float, ...]
) -> list[xr.Dataset]:
    """Branches of a panel of Fig. 10.

    Parameters
    ----------
    parameter, between : str, (float, float)
        As for `four_phase_branch`.
    curve : str
        Parameter that tells the curves apart.
    values : tuple of float
        Its values.

    Returns
    -------
    list of xarray.Dataset

    Examples
    --------
    >>> [branch.attrs["parameter"] for branch in branches_of_panel("b", (0.1, 0.2), "a", (0.3,))]
    ['b']
    """
    return [four_phase_branch(parameter, between, **{curve: value}) for value in values]


def turn_word(orbit: xr.Dataset) -> str:
    """Modes of one turn, from the start of progression on where there is one.

    Parameters
    ----------
    orbit : xarray.Dataset
        An orbit of the mole.

    Returns
    -------
    str

    Examples
    --------
    >>> from nonsmooth import find_orbit
    >>> turn_word(find_orbit(moling()))
    'progression contact no_contact contact'
    """
    modes = str(orbit["word"].item()).split()
    if len(modes) > 1:  # the section cuts one stay in two
        modes = modes[:-1]
    turns = [modes[k:] + modes[:k] for k in range(len(modes))]
    # the longest stretch before progression comes again would depend on the section: the first
    # in the alphabet does not
    begins = [turn for turn in turns if turn[0] == "progression"] or turns
    return " ".join(min(begins))


def observed(branch: xr.Dataset) -> np.ndarray:
    """Whether each orbit is a motion to which others settle: solid in Fig. 10.

    Parameters
    ----------
    branch : xarray.Dataset
        From `four_phase_branch`.

    Returns
    -------
    numpy.ndarray of bool

    Examples
    --------
    >>> branch = four_phase_branch("b", (0.1, 0.2), xi=0.05)
    >>> bool(observed(branch)[branch["b"].values > 0.12][0])
    True
    """
    return np.asarray(branch["stable"].values & branch["admissible"].values, bool)


def best_stable(branch: xr.Dataset, variable: str = "v_per_period") -> int:
    """Number of the point with the largest value among those that are observed, -1 without any.

    Parameters
    ----------
    branch : xarray.Dataset
        From `four_phase_branch`.
    variable : str, optional
        What is compared.

    Returns
    -------
    int

    Examples
    --------
    >>> branch = four_phase_branch("b", (0.1, 0.2), xi=0.05)
    >>> 0.16 < float(branch["b"][best_stable(branch)]) < 0.168
    True
    """
    solid = observed(branch)
    if not solid.any():
        return -1
    return int(np.where(solid, branch[variable].values, -np.inf).argmax())


def near_observed(branch: xr.Dataset) -> xr.Dataset:
    """A branch without what lies more than one fold behind the end of its observed part.

    Parameters
    ----------
    branch : xarray.Dataset
        From `four_phase_branch`.

    Returns
    -------
    xarray.Dataset
        The branch itself where nothing is observed; with folds and flips as special points.

    Examples
    --------
    >>> branch = four_phase_branch("b", (0.02, 0.2), xi=0.05)
    >>> near_observed(branch).sizes["point"] < branch.sizes["point"]
    True
    """
    solid = np.flatnonzero(observed(branch))
    kinds, places = branch["special_kind"].values, branch["special_point"].values
    low, high = 0, branch.sizes["point"]
    if solid.size:
        folds = places[kinds == "fold"]
        before, behind = folds[folds <= solid[0]], folds[folds >= solid[-1]]
        # the first fold ends the stable part, at the second one the unstable part turns back
        low = int(before[-2]) if before.size > 1 else low
        high = int(behind[1]) + 1 if behind.size > 1 else high
    shown = np.isin(kinds, ("fold", "flip")) & (places >= low) & (places < high)
    part = branch.isel(point=slice(low, high), special=shown)
    return part.assign(special_point=part["special_point"] - low)


def first_sheet(branch: xr.Dataset) -> xr.Dataset:
    """The part of a branch between the folds on both sides of where it began.

    Parameters
    ----------
    branch : xarray.Dataset
        From `four_phase_branch`.

    Returns
    -------
    xarray.Dataset
        Points on which the parameter rises or falls throughout.

    Examples
    --------
    >>> import numpy as np
    >>> branch = first_sheet(four_phase_branch("b", (0.02, 0.2), xi=0.05))
    >>> bool(np.all(np.diff(branch["b"]) > 0.0))
    True
    """
    began = int(np.abs(branch["arclength"].values).argmin())
    folds = branch["special_point"].values[branch["special_kind"].values == "fold"]
    low = int(max(folds[folds < began], default=0))
    high = int(min(folds[folds > began], default=branch.sizes["point"] - 1))
    return branch.isel(point=slice(low, high + 1))
