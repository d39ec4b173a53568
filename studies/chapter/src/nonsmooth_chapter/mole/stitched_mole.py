"""The mole's global solution, stitched from closed forms: switching times are the unknowns.

Between switches each state is an explicit function of time, so once the order of the modes
is known, a run is the solution of as many algebraic equations as it has switches: at each,
one guard is zero.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from nonsmooth.models import moling_solution

__all__ = ["guard_value", "solve_switching_times", "stitched_states"]

Values = Mapping[str, float]
_BRACKET = 1e-3  # half width of the interval in which a switching time is looked for


def guard_value(values: Values, left: str, entered: str, state: np.ndarray) -> float:
    """Guard that is zero at a switch from one mode to another.

    Parameters
    ----------
    values : mapping of str to float
        Parameters.
    left, entered : str
        Mode left and mode entered.
    state : numpy.ndarray
        States p, y, q, v.

    Returns
    -------
    float
        The gap, the force on the slider, or its distance from the friction limit.

    Examples
    --------
    >>> import numpy as np
    >>> guard_value({"g": 0.02, "xi": 0.05}, "no_contact", "contact", np.zeros(4))
    0.02
    """
    if left == "no_contact":
        return float(state[2] + values["g"] - state[0])
    force = float(2.0 * values["xi"] * state[1] + state[2])
    return force if entered == "no_contact" else force - 1.0


def solve_switching_times(
    values: Values, modes: Sequence[str], guesses: Sequence[float]
) -> list[float]:
    """Switching times of a run from rest, each the root of one algebraic equation.

    Parameters
    ----------
    values : mapping of str to float
        Parameters.
    modes : sequence of str
        Modes entered, in order, after the flight at the start.
    guesses : sequence of float
        Rough times; roots are looked for within a thousandth of them.

    Returns
    -------
    list of float

    Examples
    --------
    >>> values = {"a": 0.0, "b": 1.0, "xi": 0.5, "omega": 1.0, "g": 0.5, "phi": 0.0}
    >>> [round(t, 12) for t in solve_switching_times(values, ["contact"], [0.9996])]
    [1.0]
    """
    from scipy.optimize import brentq

    mode, state, began = "no_contact", np.zeros(4), 0.0
    found: list[float] = []
    for entered, guess in zip(modes, guesses, strict=True):

        def equation(
            t: float,
            mode: str = mode,
            entered: str = entered,
            state: np.ndarray = state,
            began: float = began,
        ) -> float:
            return guard_value(
                values, mode, entered, moling_solution(values, mode, state, began, np.array([t]))[0]
            )

        low = max(guess - _BRACKET, 0.5 * (began + guess))
        time = float(brentq(equation, low, guess + _BRACKET, xtol=1e-14, rtol=1e-15))
        state = moling_solution(values, mode, state, began, np.array([time]))[0]
        mode, began = entered, time
        found.append(time)
    return found


def stitched_states(
    values: Values, modes: Sequence[str], switching_times: Sequence[float], times: np.ndarray
) -> np.ndarray:
    """States of a run from rest at any times, from its switching times alone.

    Parameters
    ----------
    values : mapping of str to float
        Parameters.
    modes : sequence of str
        Modes entered, in order.
    switching_times : sequence of float
        When they are entered.
    times : numpy.ndarray
        Times.

    Returns
    -------
    numpy.ndarray, shape (time, 4)

    Examples
    --------
    >>> import numpy as np
    >>> values = {"a": 0.0, "b": 1.0, "xi": 0.5, "omega": 1.0, "g": 0.5, "phi": 0.0}
    >>> float(stitched_states(values, ["contact"], [1.0], np.array([0.5]))[0, 0])
    0.125
    """
    states = np.zeros((len(times), 4))
    mode, state, began = "no_contact", np.zeros(4), 0.0
    ends = [*switching_times, np.inf]
    for entered, end in zip([*modes, ""], ends, strict=True):
        here = (times >= began) & (times < end)
        if np.any(here):
            states[here] = moling_solution(values, mode, state, began, times[here])
        if np.isfinite(end):
            state = moling_solution(values, mode, state, began, np.array([end]))[0]
            mode, began = entered, end
    return states
