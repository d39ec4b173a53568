"""Period-one orbits of the mole by the chapter's minimisation, Eqs. (18)-(23)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError
from nonsmooth.models.moling_phases import states_in_mode
from nonsmooth.real_numbers import finite_numbers
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["four_phase_misfit", "four_phase_orbit"]

Floats = npt.NDArray[np.float64]
Values = Mapping[str, float]

_NEEDED = ("a", "b", "xi", "omega", "g")
_VELOCITIES, _PHASES, _STARTS = 16, 24, 3
_FAR = 1e6  # in place of an infinite misfit, so that a simplex can be ordered
_SAME = 1e-6
_ZERO = 1e-9  # misfit of an orbit: rounding and the end of the search
_LOOKS = 250  # at a guard between two switches, on each of two scales
_SOONEST = 1e-7  # of a period: the first look


def four_phase_misfit(system: System, y_0: float, psi_0: float) -> float:
    r"""The chapter's function F of Eq. (23), zero for a periodic response of the mole.

    Parameters
    ----------
    system : System
        The mole, `models.moling`.
    y_0 : float
        Velocity of the mass at the start of progression; its displacement follows by Eq. (19).
    psi_0 : float
        Phase of the forcing there, Eq. (20).

    Returns
    -------
    float
        :math:`\sqrt{(x(T) - x(0) - \Delta)^2 + (y(T) - y(0))^2}` after progression, contact,
        flight and contact, as long as each lasts; infinite where one of them does not end within
        the period.

    Raises
    ------
    OptionError
        For another system.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> mole = ns.models.moling(b=0.15)
    >>> round(ns.models.four_phase_misfit(mole, 7.0, 1.2), 4)
    2.4923
    """
    return _pass_four_phases(_values(system), float(y_0), float(psi_0)).misfit


def four_phase_orbit(
    system: System, guess: tuple[float, float] | xr.Dataset | None = None
) -> xr.Dataset:
    """Minima of the chapter's function F, each a construction of four phases.

    The chapter finds periodic responses of the mole so: each period is taken to consist of
    progression, contact, flight and contact, and the velocity and phase at its beginning are
    varied until the period closes. Here the search is scipy's simplex of Nelder and Mead, from
    the lowest places of a grid.

    Parameters
    ----------
    system : System
        The mole, `models.moling`.
    guess : tuple of float or xarray.Dataset, optional
        ``y_0`` and ``psi_0`` near a minimum, or a dataset that has them, such as one of this
        function or of `progression_start` for neighbouring parameters; a grid without it.

    Returns
    -------
    xarray.Dataset
        Over ``minimum``, those that are motions first, then by F: ``F``, ``y_0``, ``psi_0``,
        ``x_0``, ``v_per_period``, ``closes`` (F is zero to rounding), ``admissible`` (it closes,
        and the force stays between zero and the friction limit inside the last phase); over
        ``phase`` too ``durations``. Attributes: ``status`` (``completed``, or ``no_orbit`` where
        none closes) and ``evaluations`` of F after the grid.

    Raises
    ------
    OptionError
        For another system, or a guess that is no pair of numbers.

    See Also
    --------
    nonsmooth.find_orbit : any sequence of phases, by Newton's method, with stability.

    Notes
    -----
    Nothing is said about stability, and orbits of other phases are not found.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> found = ns.models.four_phase_orbit(ns.models.moling(b=0.15), guess=(7.2, 1.2))
    >>> round(float(found["v_per_period"][0]), 6)
    31.34534
    >>> [round(float(each), 3) for each in found["durations"][0]]
    [8.459, 1.53, 52.806, 0.038]
    """
    values = _values(system)
    evaluations = 0

    def misfit(unknowns: Floats) -> float:
        nonlocal evaluations
        evaluations += 1
        return min(_pass_four_phases(values, float(unknowns[0]), float(unknowns[1])).misfit, _FAR)

    starts = _grid(values) if guess is None else [_pair(guess)]
    found: list[tuple[Floats, _FourPhases]] = []
    for start in starts:
        place = _descend(misfit, start)
        place[1] %= 2.0 * np.pi
        phases = _pass_four_phases(values, float(place[0]), float(place[1]))
        if np.isfinite(phases.misfit) and all(_apart(place, one) > _SAME for one, _ in found):
            found.append((place, phases))
    return _dataset(system, values, found, evaluations)


def _descend(misfit: Any, start: Floats) -> Floats:
    """Nelder and Mead's simplex, begun anew once: F has the shape of a cone at an orbit."""
    from scipy.optimize import minimize

    place, options = start, {"xatol": 1e-13, "fatol": 1e-13, "maxfev": 500}
    for size in (0.02, 1e-5):
        step = size * np.array([max(abs(place[0]), 0.1), 1.0])
        simplex = place + np.array([[0.0, 0.0], [step[0], 0.0], [0.0, step[1]]])
        place = minimize(
            misfit, place, method="Nelder-Mead", options={**options, "initial_simplex": simplex}
        ).x
    return np.asarray(place, float)


def _grid(values: Values) -> list[Floats]:
    """The lowest places of a grid, by F and by what a motion lacks where it next progresses.

    F alone has many minima in which the force passes the friction limit inside the last phase.
    """
    # the fastest that a flight of a whole period could make the mass
    fastest = 2.0 * (values["a"] + np.pi * values["b"]) / values["omega"]
    y = fastest * (np.arange(_VELOCITIES) + 0.5) / _VELOCITIES
    psi = 2.0 * np.pi * np.arange(_PHASES) / _PHASES
    passed = [[_pass_four_phases(values, u, w) for w in psi] for u in y]
    places = [
        *_lowest(np.array([[each.return_misfit for each in row] for row in passed])),
        *_lowest(np.array([[each.misfit for each in row] for row in passed])),
    ]
    return [np.array([y[i], psi[k]]) for i, k in dict.fromkeys(places)]


def _lowest(heights: Floats) -> list[tuple[int, int]]:
    """Places that are lower than all their neighbours; phases close to a circle."""
    wide = np.pad(heights, ((1, 1), (0, 0)), constant_values=np.inf)
    wide = np.pad(wide, ((0, 0), (1, 1)), "wrap")
    rows, columns = heights.shape
    shifted = [
        wide[1 + i : 1 + i + rows, 1 + k : 1 + k + columns]
        for i in (-1, 0, 1)
        for k in (-1, 0, 1)
        if i or k
    ]
    low = np.argwhere((heights <= np.min(shifted, axis=0)) & np.isfinite(heights))
    low = low[np.argsort(heights[tuple(low.T)])][:_STARTS]
    return [(int(i), int(k)) for i, k in low]


def _apart(place: Floats, other: Floats) -> float:
    turn = np.remainder(place[1] - other[1] + np.pi, 2.0 * np.pi) - np.pi
    return float(max(abs(place[0] - other[0]) / max(abs(other[0]), 1.0), abs(turn)))


def _dataset(
    system: System, values: Values, found: list[tuple[Floats, _FourPhases]], evaluations: int
) -> xr.Dataset:
    import xarray as xr

    def admissible(each: _FourPhases) -> bool:
        low, high = each.last_force
        return each.misfit <= _ZERO and low > 0.0 and high < 1.0

    found = sorted(found, key=lambda pair: (not admissible(pair[1]), pair[1].misfit))
    places = np.array([place for place, _ in found]).reshape(-1, 2)
    phases = [each for _, each in found]
    x = 1.0 + values["g"] - 2.0 * values["xi"] * places[:, 0]

    def over(numbers: Any, text: str) -> tuple[str, Any, dict[str, str]]:
        return "minimum", np.asarray(numbers), {"long_name": text}

    closes = np.array([each.misfit <= _ZERO for each in phases], bool)
    data = xr.Dataset(
        {
            "F": over([each.misfit for each in phases], "misfit, Eq. (23)"),
            "y_0": over(places[:, 0], "velocity of the mass where progression begins"),
            "psi_0": over(places[:, 1], "phase of the forcing there"),
            "x_0": over(x, "displacement of the mass there, Eq. (19)"),
            "v_per_period": over([e.progression for e in phases], "progression per period"),
            "closes": over(closes, "whether the period closes"),
            "admissible": over(
                np.array([admissible(each) for each in phases], bool), "whether it is a motion"
            ),
            "durations": (
                ("minimum", "phase"),
                np.array([each.durations for each in phases]).reshape(-1, 4),
                {"long_name": "durations of the phases"},
            ),
        },
        {"phase": ["I", "II", "III", "IV"]},
    )
    data.attrs = {
        "status": "completed" if closes.any() else "no_orbit",
        "evaluations": evaluations,
        "system_name": system.name,
    }
    return data


def _values(system: System) -> dict[str, float]:
    if system.name != "moling" or not set(_NEEDED) <= set(system.parameter_values):
        raise OptionError(
            f"the construction of four phases is for models.moling, not for {system.name!r};"
            " find_orbit takes any system"
        )
    return {name: float(system.parameter_values[name]) for name in _NEEDED}


def _pair(guess: tuple[float, float] | xr.Dataset) -> Floats:
    import xarray as xr

    if isinstance(guess, xr.Dataset):
        for name in ("y_0", "psi_0"):
            if name not in guess or guess[name].size == 0:
                raise OptionError(
                    f"guess: the dataset has no value of {name}; give one of four_phase_orbit or"
                    " progression_start that found a start of progression"
                )
        guess = tuple(np.ravel(guess[name].values)[0] for name in ("y_0", "psi_0"))
    return finite_numbers("guess", guess)


@dataclass(frozen=True)
class _FourPhases:
    """A period that begins with progression.

    Parameters
    ----------
    misfit : float
        F of Eq. (23); infinite where one of the phases does not end.
    progression : float
        Change of v.
    durations : numpy.ndarray
        Of phases I to IV.
    last_force : tuple of float
        Least and greatest force on the slider inside phase IV, in units of the friction limit.
    return_misfit : float
        What y, and the length of the turn, lack where progression next begins.
    """

    misfit: float
    progression: float
    durations: Floats
    last_force: tuple[float, float]
    return_misfit: float


_NONE = _FourPhases(np.inf, np.nan, np.full(4, np.nan), (np.nan, np.nan), np.inf)


def _pass_four_phases(values: Values, y_0: float, psi_0: float) -> _FourPhases:
    """Progression, contact, flight and contact for one period from the start of progression.

    Each of the first three phases ends where its guard first vanishes, the last one with the
    period, whatever the force on the slider does in it.

    Parameters
    ----------
    values : mapping of str to float
        Parameters a, b, xi, omega, g.
    y_0, psi_0 : float
        Velocity of the mass and phase of the forcing.

    Returns
    -------
    FourPhases

    Examples
    --------
    >>> values = {"a": 0.3, "b": 0.15, "xi": 0.05, "omega": 0.1, "g": 0.02}
    >>> [round(float(each), 2) for each in _pass_four_phases(values, 7.23, 1.165).durations]
    [8.46, 1.53, 52.8, 0.04]
    """
    values = {**values, "phi": psi_0}  # time begins with progression
    g, twice, period = values["g"], 2.0 * values["xi"], 2.0 * np.pi / values["omega"]
    q_0 = 1.0 - twice * y_0  # Eq. (19)
    begin = np.array([q_0 + g, y_0, q_0, 0.0])
    guards: tuple[tuple[str, Callable[[Floats], Floats]], ...] = (
        ("progression", lambda s: twice * s[:, 1] + s[:, 2] - 1.0),
        ("contact", lambda s: twice * s[:, 1] + s[:, 2]),
        ("no_contact", lambda s: s[:, 2] + g - s[:, 0]),
    )
    state, times = begin, [0.0]
    for mode, guard in guards:
        end = _first_root(values, mode, guard, state, times[-1], period)
        if end is None:
            return _NONE
        state = states_in_mode(values, mode, state, times[-1], np.array([end]))[0]
        times.append(end)
    last = times[-1] + (period - times[-1]) * np.linspace(0.0, 1.0, _LOOKS)
    states = states_in_mode(values, "contact", state, times[-1], last)
    force = (twice * states[:, 1] + states[:, 2])[1:-1]
    p, y, _, v = states[-1]
    return _FourPhases(
        # x(T) - x(0) - Delta, with Delta the change of v, is the change of p = x - v
        misfit=float(np.hypot(p - begin[0], y - begin[1])),
        progression=float(v),
        durations=np.diff([*times, period]),
        last_force=(float(force.min()), float(force.max())),
        return_misfit=_return_misfit(values, state, times[-1], y_0, period),
    )


def _return_misfit(values: Values, state: Floats, began: float, y_0: float, period: float) -> float:
    """Distance from the start, in velocity and time, where the force next reaches the limit."""
    looks = began + np.geomspace(_SOONEST, 1.0, _LOOKS) * period
    states = states_in_mode(values, "contact", state, began, looks)
    force = 2.0 * values["xi"] * states[:, 1] + states[:, 2]
    if force[0] >= 1.0:
        return np.inf
    over = np.flatnonzero((force >= 1.0) | (force < 0.0))
    if not over.size or force[over[0]] < 0.0:
        return np.inf
    k = int(over[0])
    return float(np.hypot(states[k, 1] - y_0, looks[k] - period))


def _first_root(
    values: Values,
    mode: str,
    guard: Callable[[Floats], Floats],
    state: Floats,
    began: float,
    period: float,
) -> float | None:
    """Time at which a guard that is positive at first vanishes, or None within the period."""
    from scipy.optimize import brentq

    left = period - began
    looks = np.union1d(
        np.geomspace(_SOONEST * period, left, _LOOKS), np.linspace(0.0, left, _LOOKS)[1:]
    )
    found = guard(states_in_mode(values, mode, state, began, began + looks))
    gone = np.flatnonzero(found <= 0.0)
    if not gone.size or gone[0] == 0:
        return None
    k = int(gone[0])

    def at(time: float) -> float:
        return float(guard(states_in_mode(values, mode, state, began, np.array([time])))[0])

    return float(brentq(at, began + looks[k - 1], began + looks[k], xtol=1e-13, rtol=1e-14))
