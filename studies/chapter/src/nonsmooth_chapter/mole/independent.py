"""The mole without the engine: by scipy, in absolute displacements, and stitched."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from math import pi
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from nonsmooth import Exit, Mode, System
from nonsmooth.models import moling_solution

if TYPE_CHECKING:
    from nonsmooth.models import MolingRig

__all__ = [
    "AdaptiveRun",
    "absolute_mole",
    "adaptive_mole_run",
    "guard_value",
    "solve_switching_times",
    "stitched_states",
    "unit_mole",
]


# The mole by a general adaptive integrator with event functions, for comparison.
#
# Written by hand from the chapter's Eqs. (25)-(27); nothing of it is shared with the exact
# engine. Events come from scipy, which looks for them at the ends of its steps, so the steps
# are kept short.

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


# The mole as the chapter first writes it: absolute displacements, SI units, Eqs. (2)-(4).
#
# No scaling and no split into bounded motion and drift: this is the other side of the
# comparisons that test both.


def absolute_mole(rig: MolingRig, *, apart: bool = False) -> System:
    """Mole with absolute displacements in m: mass, slider top and slider bottom.

    Parameters
    ----------
    rig : MolingRig
        Its data.
    apart : bool, optional
        Whether mass and slider top are integrated apart in contact too, each by its own rate;
        by default the mass is placed at the gap from the slider top.

    Returns
    -------
    System
        States ``X_m Y_m X_t X_b``; at rest all displacements are zero and the gap is open.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> rig = ns.models.MolingRig(
    ...     mass=2.0, stiffness=5e4, damping=31.6, static_force=30.0, dynamic_force=60.0,
    ...     friction_force=200.0, angular_frequency=15.8, gap=8e-5,
    ... )  # fmt: skip
    >>> run = ns.simulate(absolute_mole(rig), periods=20)
    >>> round(1e3 * float(run["X_b"][-1]))
    2457
    """
    rate = {"X_m": "Y_m"} if apart else {}
    place = {} if apart else {"X_m": "X_t + gap"}
    return System(
        name="mole in absolute displacements",
        states=["X_m", "Y_m", "X_t", "X_b"],
        parameters=asdict(rig),
        period="2*pi/angular_frequency",
        definitions={
            "load": "static_force + dynamic_force*cos(angular_frequency*t + phase)",
            "spring": "stiffness*(X_t - X_b)",
            "resistance": "damping*Y_m + spring",
        },
        modes={
            "no_contact": Mode(
                {"X_m": "Y_m", "Y_m": "load/mass", "X_t": "-spring/damping", "X_b": "0"},
                exits=[Exit("X_t + gap - X_m", to="contact", name="impact")],
            ),
            "contact": Mode(
                {**rate, "Y_m": "(load - resistance)/mass", "X_t": "Y_m", "X_b": "0"},
                slaved=place,
                exits=[
                    Exit("resistance", to="no_contact", name="release"),
                    Exit("friction_force - resistance", to="progression"),
                ],
            ),
            "progression": Mode(
                {
                    **rate,
                    "Y_m": "(load - friction_force)/mass",
                    "X_t": "Y_m",
                    "X_b": "Y_m - (friction_force - spring)/damping",
                },
                slaved=place,
                exits=[Exit("resistance - friction_force", to="contact")],
            ),
        },
    )


def unit_mole(b: float, *, apart: bool = False) -> System:
    """Mole of Fig. 7 in absolute displacements, with units in which its data are dimensionless.

    Parameters
    ----------
    b : float
        Static force.
    apart : bool, optional
        As for `absolute_mole`.

    Returns
    -------
    System

    Examples
    --------
    >>> import nonsmooth as ns
    >>> round(float(ns.simulate(unit_mole(0.15), periods=50)["X_b"][-1]))
    1554
    """
    from nonsmooth.models import MolingRig

    rig = MolingRig(
        mass=1.0, stiffness=1.0, damping=2.0 * 0.05, static_force=b, dynamic_force=0.3,
        friction_force=1.0, angular_frequency=0.1, gap=0.02, phase=0.5 * pi,
    )  # fmt: skip
    return absolute_mole(rig, apart=apart)


# The mole's global solution, stitched from closed forms: switching times are the unknowns.
#
# Between switches each state is an explicit function of time, so once the order of the modes
# is known, a run is the solution of as many algebraic equations as it has switches: at each,
# one guard is zero.

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
