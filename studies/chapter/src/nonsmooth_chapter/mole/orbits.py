"""Periodic orbits of the mole: branches, and the four stages of a period."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from nonsmooth import continue_orbit, find_orbit, simulate
from nonsmooth.models import moling, progression_start
from nonsmooth.plot import phases, print_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "FOUR_PHASES",
    "best_stable",
    "branches_of_panel",
    "fig9",
    "first_sheet",
    "four_phase_branch",
    "near_observed",
    "observed",
    "stages",
    "turn_word",
]


# Branches of the mole's period-one orbits with the four phases of Fig. 9: those of Fig. 10.
#
# Stable or not, motions or not: the word is kept where the motion leaves it, as the chapter's
# algorithm does. The turn is cut in the flight, halfway through the period of the forcing, which is
# the longest phase.

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


# Four stages of a period-one orbit: Fig. 9, from the equations of the orbit.
#
# The chapter prints no parameters for the figure; those of Fig. 7(d) are taken.

_NAMES = {"x": "mass, x", "z": "slider top, z", "v": "slider bottom, v"}
_NUMERALS = ("I", "II", "III", "IV")
_MODES = ("progression", "contact", "no_contact", "contact")
_TEXT = 8  # points, as in the rest of the figure


def stages(
    a: float = 0.3, b: float = 0.15, xi: float = 0.05, omega: float = 0.1
) -> tuple[xr.Dataset, xr.Dataset]:
    """An orbit of the mole that begins with progression, and its start.

    Parameters
    ----------
    a, b, xi, omega : float, optional
        Parameters; those of Fig. 7(d) by default.

    Returns
    -------
    orbit : xarray.Dataset
        From `find_orbit`, the turn cut just where progression begins.
    start : xarray.Dataset
        From `progression_start`.

    Examples
    --------
    >>> orbit, start = stages()
    >>> [round(float(each), 3) for each in orbit["durations"]]
    [8.459, 1.53, 52.806, 0.038]
    """
    system = moling(a=a, b=b, xi=xi, omega=omega)
    orbit = find_orbit(system)
    start = progression_start(orbit)
    # legs on both sides of the section are one
    first = int(np.flatnonzero(orbit["leg_time"].values == start["tau_0"].values[0])[0])
    durations = np.roll(orbit["durations"].values, -first)
    modes = np.roll(orbit["leg_mode"].values, -first)
    if orbit["leg_exit"].values[-1] == "" and durations.size > 1:
        cut = durations.size - 1 - first  # the leg before the section
        durations[cut] += durations[cut + 1]
        durations, modes = np.delete(durations, cut + 1), np.delete(modes, cut + 1)
    flags = orbit["leg_mode"].attrs
    turned = xr.Dataset(
        {
            "durations": ("stage", durations, {"long_name": "duration of each stage"}),
            "stage_mode": ("stage", modes, {**flags, "long_name": "mode of each stage"}),
            "v_per_period": orbit["v_per_period"],
        },
        attrs={**orbit.attrs, "stable": int(orbit["stable"]), "word": orbit["word"].item()},
    )
    return turned, start


def fig9() -> tuple[Figure, xr.Dataset]:
    """Fig. 9: four stages of a periodic response, with the beginning and the end enlarged.

    Returns
    -------
    figure : matplotlib.figure.Figure
        One period from the start of progression, and both of its ends.
    data : xarray.Dataset
        The period over ``time``, ``durations`` of the stages I to IV, and ``psi_0``, ``x_0`` and
        ``y_0`` of Eqs. (18)-(20).

    Examples
    --------
    >>> figure, data = fig9()
    >>> data.attrs["phases"]
    'progression contact no_contact contact'
    """
    orbit, start = stages()
    run = _along(orbit, start)
    switches = np.concatenate([[0.0], np.cumsum(orbit["durations"].values)])
    figure, axes = print_figure(3, 1, width=12.0, height=18.0)
    period = float(switches[-1])
    panels = (
        (f"(a) one period; durations {_told(orbit['durations'].values)}", (0.0, period)),
        ("(b) its beginning: progression and release", (0.0, 1.6 * switches[2])),
        ("(c) its end: impact and progression", (period - 4.0 * (period - switches[3]), period)),
    )
    for ax, (title, window) in zip(axes, panels, strict=True):
        ax.set_xlabel(r"time since progression began, $\tau - \tau_0$")
        ax.set_ylabel("displacement")
        phases(run, list(_NAMES), ax=ax, time_range=window, labels=_NAMES, legend=False)
        ax.set_title(title, loc="left", fontsize=_TEXT)
        _number(ax, switches, window)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside upper center", ncols=2, frameon=False, fontsize=_TEXT
    )
    data = run.assign({name: start[name][0] for name in ("psi_0", "x_0", "y_0")})
    data = data.assign(durations=orbit["durations"])
    data.attrs |= {
        "phases": " ".join(_MODES),
        "note": "parameters of Fig. 7(d); the chapter prints none for Fig. 9",
    }
    return figure, data


def _along(orbit: xr.Dataset, start: xr.Dataset) -> xr.Dataset:
    """The motion along the orbit from the start of progression, where time and v are zero."""
    values = moling().parameter_values
    x, y = float(start["x_0"][0]), float(start["y_0"][0])
    system = moling().with_parameters(phi=float(start["psi_0"][0]))
    state = {"p": x, "y": y, "q": x - values["g"]}
    switches = np.concatenate([[0.0], np.cumsum(orbit["durations"].values)])
    # two contacts last a hundredth of a period or less: samples stand closer round them
    times = [np.linspace(0.0, switches[-1], 1001)]
    times += [np.clip(np.linspace(t - 0.3, t + 0.3, 801), 0.0, switches[-1]) for t in switches]
    return simulate(system, state, mode="progression", times=np.unique(np.concatenate(times)))


def _number(ax: Axes, switches: np.ndarray, window: tuple[float, float]) -> None:
    """Roman numerals of the chapter in the stages that are wide enough to hold them."""
    for numeral, start, end in zip(_NUMERALS, switches[:-1], switches[1:], strict=True):
        low, high = max(start, window[0]), min(end, window[1])
        if high - low > 0.03 * (window[1] - window[0]):
            ax.text(
                0.5 * (low + high), 0.05, numeral, transform=ax.get_xaxis_transform(),
                ha="center", va="bottom", fontsize=_TEXT,
            )  # fmt: skip


def _told(durations: np.ndarray) -> str:
    return ", ".join(f"{n} {d:.4g}" for n, d in zip(_NUMERALS, durations, strict=True))
