"""The mole by a general adaptive integrator with event functions, for comparison.

Written by hand from the chapter's Eqs. (25)-(27); nothing of it is shared with the exact
engine. Events come from scipy, which looks for them at the ends of its steps, so the steps
are kept short.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

__all__ = ["AdaptiveRun", "adaptive_mole_run"]

Values = Mapping[str, float]
Function = Callable[[float, np.ndarray], float]


class AdaptiveRun(NamedTuple):
    """States (time, state) at the times asked for, the switches, and the work that it took."""

    states: np.ndarray
    switch_times: list[float]
    switch_modes: list[str]
    n_steps: int
    n_evaluations: int


def adaptive_mole_run(
    values: Values, times: np.ndarray, *, tolerance: float = 1e-12, longest_step: float = 0.25
) -> AdaptiveRun:
    """Run of the mole from rest with DOP853.

    Parameters
    ----------
    values : mapping of str to float
        Parameters a, b, xi, omega, g, phi.
    times : numpy.ndarray
        Times to give the states at, rising from zero.
    tolerance : float, optional
        Relative and absolute tolerance of a step.
    longest_step : float, optional
        Largest step; two events within one can hide each other.

    Returns
    -------
    AdaptiveRun
        States p, y, q, v; times of the switches and the modes entered; numbers of steps and of
        evaluations of the rates.

    Examples
    --------
    >>> import numpy as np
    >>> values = {"a": 0.3, "b": 0.15, "xi": 0.05, "omega": 0.1, "g": 0.02, "phi": np.pi / 2}
    >>> run = adaptive_mole_run(values, np.array([0.0, 20.0]))
    >>> run.switch_modes
    ['contact', 'no_contact']
    """
    from scipy.integrate import solve_ivp

    rates, guards = _equations(values)
    mode, state, now = "no_contact", np.zeros(4), float(times[0])
    states = np.zeros((len(times), 4))
    run = AdaptiveRun(states, [], [], 0, 0)
    while now < times[-1]:
        ahead = times[times > now]
        part = solve_ivp(
            rates[mode],
            (now, times[-1]),
            state,
            method="DOP853",
            t_eval=ahead,
            events=[guard for guard, _ in guards[mode]],
            rtol=tolerance,
            atol=tolerance,
            max_step=longest_step,
            dense_output=True,
        )
        if len(part.t):
            states[np.isin(times, part.t)] = part.y.T
        run = run._replace(
            n_steps=run.n_steps + len(part.sol.ts) - 1,
            n_evaluations=run.n_evaluations + part.nfev,
        )
        if part.status != 1:
            return run
        fired = next(i for i, found in enumerate(part.t_events) if len(found))
        now, state = float(part.t_events[fired][-1]), part.y_events[fired][-1].copy()
        mode = _entered(guards[mode][fired][1], state, values)
        if mode != "no_contact":
            state[0] = state[2] + values["g"]
        run.switch_times.append(now)
        run.switch_modes.append(mode)
    return run


def _entered(mode: str, state: np.ndarray, values: Values) -> str:
    """Mode in force after a switch: an impact above the friction limit progresses at once."""
    if mode == "impact":
        return "progression" if 2.0 * values["xi"] * state[1] + state[2] >= 1.0 else "contact"
    return mode


def _equations(
    values: Values,
) -> tuple[dict[str, Callable], dict[str, list[tuple[Function, str]]]]:
    """Right-hand sides, and terminal event functions with the modes they lead to."""
    a, b, xi, omega, g, phi = (values[name] for name in ("a", "b", "xi", "omega", "g", "phi"))

    def forcing(t: float) -> float:
        return b + a * np.cos(omega * t + phi)

    def force(s: np.ndarray) -> float:
        return 2.0 * xi * s[1] + s[2]

    def slip(s: np.ndarray) -> float:
        return (1.0 - s[2]) / (2.0 * xi)

    rates = {
        "no_contact": lambda t, s: [s[1], forcing(t), -s[2] / (2.0 * xi), 0.0],
        "contact": lambda t, s: [s[1], forcing(t) - force(s), s[1], 0.0],
        "progression": lambda t, s: [slip(s), forcing(t) - 1.0, slip(s), s[1] - slip(s)],
    }
    guards = {
        "no_contact": [(_terminal(lambda t, s: s[0] - s[2] - g, 1.0), "impact")],
        "contact": [
            (_terminal(lambda t, s: force(s), -1.0), "no_contact"),
            (_terminal(lambda t, s: force(s) - 1.0, 1.0), "progression"),
        ],
        "progression": [(_terminal(lambda t, s: force(s) - 1.0, -1.0), "contact")],
    }
    return rates, guards


def _terminal(guard: Function, direction: float) -> Function:
    """Event function of scipy that ends the integration at a crossing in one direction."""
    # scipy reads its options from attributes of the function, which typing cannot express
    guard.terminal, guard.direction = True, direction  # type: ignore[attr-defined]
    return guard
