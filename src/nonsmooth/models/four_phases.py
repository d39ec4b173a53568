"""The chapter's construction: one period of the mole as exactly four phases in closed form."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.models.moling_phases import moling_solution

__all__ = ["FourPhases", "pass_four_phases"]

Floats = npt.NDArray[np.float64]
Values = Mapping[str, float]

_LOOKS = 250  # at a guard between two switches, on each of two scales
_SOONEST = 1e-7  # of a period: the first look


@dataclass(frozen=True)
class FourPhases:
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


_NONE = FourPhases(np.inf, np.nan, np.full(4, np.nan), (np.nan, np.nan), np.inf)


def pass_four_phases(values: Values, y_0: float, psi_0: float) -> FourPhases:
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
    >>> [round(float(each), 2) for each in pass_four_phases(values, 7.23, 1.165).durations]
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
        state = moling_solution(values, mode, state, times[-1], np.array([end]))[0]
        times.append(end)
    last = times[-1] + (period - times[-1]) * np.linspace(0.0, 1.0, _LOOKS)
    states = moling_solution(values, "contact", state, times[-1], last)
    force = (twice * states[:, 1] + states[:, 2])[1:-1]
    p, y, _, v = states[-1]
    return FourPhases(
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
    states = moling_solution(values, "contact", state, began, looks)
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
    found = guard(moling_solution(values, mode, state, began, began + looks))
    gone = np.flatnonzero(found <= 0.0)
    if not gone.size or gone[0] == 0:
        return None
    k = int(gone[0])

    def at(time: float) -> float:
        return float(guard(moling_solution(values, mode, state, began, np.array([time])))[0])

    return float(brentq(at, began + looks[k - 1], began + looks[k], xtol=1e-13, rtol=1e-14))
