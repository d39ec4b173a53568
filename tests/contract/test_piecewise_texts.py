"""A system as one right-hand side with `max`, `abs`, `where` is the automaton written by hand.

Both run the same flows, so they differ by the rounding of coefficients that are put together
in another order. That grows with the motion: times and states agree to 1e-11 of the growth.
"""

import numpy as np
import pytest

import nonsmooth as ns
from contract.rig import rig
from nonsmooth.models import chua, gear_pair, soft_impact, trilinear

SAME = 1e-11


SOFT = soft_impact(omega=0.8, zeta=0.05)
PULL = "a*omega**2*sin(omega*t) - 2*zeta*v - x"
STOPS = [
    "max(x - e, 0)",
    "where(x > e, x - e, 0)",
    "where(e >= x, 0, x - e)",
    "(x - e)*heaviside(x - e)",
    "(abs(x - e) + x - e)/2",
    "x - min(x, e)",
]

TRILINEAR = trilinear(omega=1.3, zeta=0.1)
GAPS = [
    "x - clip(x, -delta, delta)",
    "max(x - delta, 0) + min(x + delta, 0)",
    "(abs(x - delta) - abs(x + delta))/2 + x",
    "where(x > delta, x - delta, where(x < -delta, x + delta, 0))",
    "sign(x)*max(abs(x) - delta, 0)",
    "where(-delta < x < delta, 0, where(x > delta, x - delta, x + delta))",
]

GEAR = gear_pair(Omega=0.5, F_a=0.9, zeta=0.1)
MESHED = gear_pair(Omega=0.5, F_a=0.9, zeta=0.1, k=0.3, phi=0.4)
PUSH = "F_m + F_a*Omega**2*cos(Omega*t) - 2*zeta*v"
DEAD_ZONES = [
    "x - clip(x, -b, b)",
    "max(x - b, 0) - max(-x - b, 0)",
    "where(abs(x) > b, x - b*sign(x), 0)",
    "where(x > b or not x > -b, x - clip(x, -b, b), 0)",
]

CHUA = chua()
RESISTORS = [
    "m1*x + (m0 - m1)/2*(abs(x + 1) - abs(x - 1))",
    "m1*x + (m0 - m1)*clip(x, -1, 1)",
    "m1*x + (m0 - m1)*min(max(x, -1), 1)",
    "where(x > 1, m1*x + m0 - m1, where(x < -1, m1*x - m0 + m1, m0*x))",
]


def as_text(automaton, flow, **more):
    """System with the parameters of an automaton and one right-hand side."""
    words = {"states": automaton.states, "parameters": dict(automaton.parameters)}
    words |= {"period": automaton.period, "initial": dict(automaton.initial)}
    return ns.System(**(words | more), equations=flow)


def entered(run):
    """Names of the modes or cells that the events lead into."""
    return [run["event_to"].attrs["flag_meanings"].split()[int(m)] for m in run["event_to"]]


def without_centre(run):
    """A run without crossings of x = 0, which are events of a text with sign(x) in it only."""
    passing = np.abs(run["state_before"].values[:, 0]) < 1e-9
    passing[0] = False
    return run.isel(event=~passing)


def compare(automaton, text, initial, *, ends=lambda run: run, **length):
    """Two runs event by event: times, modes, states, derivatives and outputs."""
    one, two = (ends(ns.simulate(s, initial, tangent=True, **length)) for s in (automaton, text))
    growth = max(1.0, np.abs(one["tangent"].values).max())
    assert one.attrs["status"] == two.attrs["status"] == "completed"
    assert one.sizes["event"] == two.sizes["event"] > 8
    # every cell is one mode
    pairs = set(zip(entered(one), entered(two), strict=True))
    assert len(pairs) == len({cell for _, cell in pairs}) >= 2
    assert {mode for mode, _ in pairs} == set(entered(one))
    close(one["event_time"], two["event_time"], growth)
    for name in ("state_before", "state_after", *automaton.states, *text.outputs, "tangent"):
        close(one[name], two[name], growth * max(1.0, np.abs(one[name].values).max()))


def close(one, two, scale):
    assert np.abs(one.values - two.values).max() < SAME * scale, one.name


@pytest.mark.parametrize("text", STOPS)
def test_soft_impact(text):
    flow = {"x": "v", "v": f"{PULL} - beta*({text})"}
    outputs = {"stop_force": f"beta*({text})", "acceleration": "rate(v)"}
    compare(SOFT, as_text(SOFT, flow, outputs=outputs), {}, periods=20)


@pytest.mark.parametrize("text", GAPS)
def test_trilinear(text):
    flow = {"x": "v", "v": f"F*cos(omega*t) - 2*zeta*v - x - kappa*({text})"}
    outputs = {"stop_force": f"kappa*({text})", "acceleration": "rate(v)"}
    ends = without_centre if "sign" in text else lambda run: run
    text = as_text(TRILINEAR, flow, outputs=outputs)
    compare(TRILINEAR, text, {"x": 0.3}, ends=ends, periods=20)


@pytest.mark.parametrize("text", DEAD_ZONES)
@pytest.mark.parametrize("automaton", [GEAR, MESHED], ids=["constant", "varying"])
def test_gear_pair(automaton, text):
    mesh = "(1 + k*cos(Omega*t + phi))*" if automaton is MESHED else ""
    flow = {"x": "v", "v": f"{PUSH} - {mesh}({text})"}
    ends = without_centre if "sign" in text else lambda run: run
    system = as_text(automaton, flow, outputs={"mesh_force": f"{mesh}({text})"})
    compare(automaton, system, {"x": 0.2}, ends=ends, periods=10)


@pytest.mark.parametrize("text", RESISTORS)
def test_chua(text):
    flow = {"x": f"alpha*(y - x - ({text}))", "y": "x - y + z", "z": "-beta*y"}
    system = as_text(CHUA, flow, outputs={"resistor_current": text})
    compare(CHUA, system, {"x": 0.1}, t_end=25)


def test_fatigue_rig():
    """Stiff: the specimen relaxes at rates of 2e3 to 3.4e4."""
    automaton = rig()
    both = automaton.modes["both"]
    definitions = dict(automaton.definitions) | {"R1": "max(press_1, 0)", "R2": "max(press_2, 0)"}
    outputs = dict(automaton.outputs)
    text = as_text(automaton, dict(both.flow), definitions=definitions, outputs=outputs)
    assert len(text.mode_names) == 4
    compare(automaton, text, {}, periods=5)
