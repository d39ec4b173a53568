"""Near misses of a guard along Taylor flows: right, or flagged.

The same guard is posed in three ways, none of which is recognised as linear. A hump of height
bend gap^2 / 8 is hidden by rounding from a gap of about 1e-6 downwards; there a flag is right,
a wrong answer without a flag never is.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from reference.humps import T_END, draw_humps, first_root

FEW, MANY = 300, 3000
COUNTS = [FEW, pytest.param(MANY, marks=pytest.mark.slow)]
GAPS = (1e-6, 1e-1)
HIDDEN = (1e-10, 1e-6)
RESOLVED = 1e-4  # gaps above this leave no doubt in double precision


def _parameters(names):
    return dict.fromkeys(names.split(), 1.0) | {"tiny": 0.0}


def _stop(guard):
    return [ns.Exit(f"-({guard})", to="stop", name="touch")]


def cartesian():
    """Damped parts as oscillators, the harmonic and the line as functions of time."""
    flow = {}
    for k in (0, 1):
        flow[f"u{k}"] = f"a{k}*u{k} + w{k}*v{k} + tiny*u{k}*v{k}"
        flow[f"v{k}"] = f"a{k}*v{k} - w{k}*u{k}"
    guard = "c + d*t + u0 + u1 + p2*cos(w2*t) + q2*sin(w2*t)"
    parameters = _parameters("c d a0 w0 a1 w1 w2 p2 q2")
    modes = {"m": ns.Mode(flow, exits=_stop(guard))}
    return ns.System(states=list(flow), parameters=parameters, modes=modes)


def polar():
    """Damped parts as amplitude and angle, the harmonic as an angle, the line as a state."""
    flow = {"e0": "a0*e0", "f0": "w0", "e1": "a1*e1", "f1": "w1", "f2": "w2", "line": "d"}
    parts = [f"(p{k}*cos(f{k}) + q{k}*sin(f{k}))" for k in range(3)]
    guard = f"line + e0*{parts[0]} + e1*{parts[1]} + {parts[2]}"
    parameters = _parameters("d a0 w0 p0 q0 a1 w1 p1 q1 w2 p2 q2")
    modes = {"m": ns.Mode(flow, exits=_stop(guard))}
    return ns.System(states=list(flow), parameters=parameters, modes=modes)


def bent():
    """The Cartesian form with a guard that has the same roots, g (2 + g^2)."""
    words = cartesian()
    mode = words.modes["m"]
    guard = mode.exits[0].guard
    modes = {"m": ns.Mode(mode.flow, exits=_stop("-g*(2 + g**2)"))}
    return ns.System(
        states=words.states,
        parameters=dict(words.parameters),
        definitions={"g": guard},
        modes=modes,
    )


FORMS = {"cartesian": cartesian(), "polar": polar(), "bent": bent()}


def run_of(case, form):
    names = FORMS[form].parameters
    values = {"c": case.c, "d": case.d}
    for k, part in enumerate(case.parts):
        values |= {f"{name}{k}": x for name, x in part._asdict().items()}
    if form == "polar":
        start = {"e0": 1.0, "e1": 1.0, "line": case.c}
    else:
        start = {f"{x}{k}": y for k in (0, 1) for x, y in zip("uv", case.parts[k][2:], strict=True)}
    chosen = {name: x for name, x in values.items() if name in names}
    return ns.simulate(FORMS[form], start, parameters=chosen, times=[0.0, T_END])


class Verdict(NamedTuple):
    """What came out, how far from the truth in units of what rounding explains, and the case."""

    right: bool
    flagged: bool
    error: float
    gap: float
    form: str
    number: int


@cache
def verdicts(count, gaps=GAPS):
    return [
        judge(case, form, number)
        for number, case in enumerate(draw_humps(20 + count, count, gaps))
        for form in [list(FORMS)[number % len(FORMS)]]
    ]


def judge(case, form, number):
    """Right: no crossing where there is none, else one whose error some roundings explain.

    An error of 100 roundings of the size of g moves a root by that over its rate.
    """
    run = run_of(case, form)
    assert run.attrs["status"] in ("completed", "stopped")
    stopped = run.attrs["status"] == "stopped"
    found = float(run["event_time"][-1]) if stopped else np.inf
    true, rate = first_root(case)
    flagged = run.attrs["n_uncertain"] > 0
    if not stopped or np.isinf(true):
        right, error = stopped == np.isfinite(true), 0.0
    else:
        error = abs(found - true) * rate / (100 * np.finfo(float).eps * case.size)
        right = error <= 1.0
    return Verdict(right, flagged, error, case.gap, form, number)


@pytest.mark.slow
@pytest.mark.parametrize("count", COUNTS)
def test_no_answer_is_wrong_without_a_flag(count):
    assert not [v for v in verdicts(count) if not (v.right or v.flagged)]


@pytest.mark.slow
@pytest.mark.parametrize("count", COUNTS)
def test_what_rounding_hides_is_flagged(count):
    found = verdicts(count, HIDDEN)
    assert not [v for v in found if not (v.right or v.flagged)]
    assert sum(v.flagged for v in found) > count / 2


@pytest.mark.parametrize("count", COUNTS)
def test_what_double_precision_resolves_is_right_and_certified(count):
    clear = [v for v in verdicts(count) if abs(v.gap) > RESOLVED]
    assert len(clear) > count / 3
    assert not [v for v in clear if v.flagged or not v.right]


@pytest.mark.parametrize("count", COUNTS)
def test_cases_reach_what_they_are_meant_for(count):
    """Hits and misses in every decade of the gap, in every form."""
    for form in FORMS:
        gaps = np.array([v.gap for v in verdicts(count) if v.form == form])
        for low in 10.0 ** np.arange(-6, -1):
            for sign in (-1.0, 1.0):
                assert ((low <= sign * gaps) & (sign * gaps < 10 * low)).sum() >= 3
