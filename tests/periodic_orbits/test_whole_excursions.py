"""Excursions of several legs that vanish at once: a contact that may only push, or a cable pull.

A mass hangs on a cable whose other end is shaken; the cable is elastic and damped, and goes slack
where it would push. It is pulled taut for an instant once in a period besides: at a graze.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import nonsmooth as ns

M, K, C, G, W = 500.0, 4e5, 2e3, 9.81, 9.0
PERIOD = 2.0 * np.pi / W
EQUATIONS = {"z": "v", "v": "-g + where(e > 0, max(k*e + c*ed, 0), 0)/m"}
FLOOR = ns.Exit("z + 10", reset={"v": "-0.2*v"}, name="landing")  # which it never reaches


def hoist(*, floor: bool) -> ns.System:
    flight = (
        {"modes": {"fly": ns.Mode(EQUATIONS, exits=[FLOOR])}} if floor else {"equations": EQUATIONS}
    )
    return ns.System(
        states=["z", "v"],
        parameters={"m": M, "k": K, "c": C, "g": G, "A": 0.2, "w": W},
        period="2*pi/w",
        definitions={"e": "A*sin(w*t) - z", "ed": "A*w*cos(w*t) - v"},
        **flight,
    )


def flown(A: float, z: float, v: float) -> tuple[np.ndarray, list[float]]:
    """State after a period by DOP853, and the elongation at its peaks while the cable is slack."""

    def force(t, y):
        return K * (A * np.sin(W * t) - y[0]) + C * (A * W * np.cos(W * t) - y[1])

    def slack(t, y):
        return [y[1], -G]

    def taut(t, y):
        return [y[1], -G + force(t, y) / M]

    def elongation(t, y):
        return A * np.sin(W * t) - y[0]

    def turns(t, y):
        return A * W * np.cos(W * t) - y[1]

    def lets_go(t, y):
        return force(t, y)

    elongation.terminal = lets_go.terminal = True
    elongation.direction, turns.direction, lets_go.direction = 1, -1, -1
    t, y, peaks, exact = 0.0, [z, v], [], {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
    while t < PERIOD:
        run = solve_ivp(slack, (t, PERIOD), y, events=[elongation, turns], max_step=0.01, **exact)
        peaks += [elongation(s, x) for s, x in zip(run.t_events[1], run.y_events[1], strict=True)]
        t, y = run.t[-1], run.y[:, -1]
        if t < PERIOD:
            run = solve_ivp(taut, (t, PERIOD), y, events=lets_go, **exact)
            t, y = run.t[-1], run.y[:, -1]
    return y, [peak for peak in peaks if peak < 1e-6]


@pytest.mark.few(1)
@pytest.mark.parametrize("floor", [False, True])
def test_a_cable_that_is_just_not_pulled_taut(floor):
    system = hoist(floor=floor)
    start = ns.find_orbit(system, {"z": 0.0474204638, "v": 1.814754029}, transient=0)
    branch = ns.continue_orbit(system, "A", (0.19, 0.21), initial=start, direction="up", steps=40)
    kinds = branch["special_kind"].values.tolist()
    assert kinds[:2] == ["grazing", "fold"]
    place = int(branch["special_point"].values[0])
    graze = float(branch["special_value"].values[0])
    at = branch.isel(point=place)
    state, peaks = flown(graze, float(at["z"]), float(at["v"]))
    assert state == pytest.approx([float(at["z"]), float(at["v"])], abs=1e-8)  # unstable
    assert min(map(abs, peaks)) < 1e-9
    # and back, where the excursion goes
    beyond = branch.isel(point=place + 2)
    assert len(beyond["word"].item().split()) > len(at["word"].item().split())
    back = ns.continue_orbit(
        system, "A", (0.19, 0.21), initial=beyond, parameters={"A": float(beyond["A"])}, steps=15
    )
    found = dict(zip(back["special_kind"].values, back["special_value"].values, strict=True))
    assert found["grazing"] == pytest.approx(graze, rel=1e-10)
    assert start["word"].item() in back["word"].values


@pytest.mark.slow
def test_a_contact_that_only_pushes_is_left_from_either_side():
    """The free response of three masses touches a gap where its amplitude is as wide."""
    masses = np.diag([12.0, 8.0, 40.0])
    springs = np.array([[9e4, 0, -9e4], [0, 7e4, -7e4], [-9e4, -7e4, 3.6e5]])
    dampers = 1e-4 * springs + 0.2 * masses
    frame = ns.Structure(masses, springs, damping=dampers, coordinates=["a", "b", "c"])
    snubber = ns.structures.GapSpring("c", gap=4e-4, stiffness=3e6, damping=200.0, name="snub")
    loads = [
        ns.structures.Force("a", "0.01*Omega**2*cos(Omega*t)"),
        ns.structures.Force("b", "0.006*Omega**2*cos(Omega*t + 0.7)"),
    ]
    machine = ns.structures.machine(
        frame, contacts=[snubber], loads=loads, parameters={"Omega": 70.0}, period="2*pi/Omega"
    )

    def beyond(speed: float) -> float:
        stiffness = springs - speed**2 * masses + 1j * speed * dampers
        force = speed**2 * np.array([0.01, 0.006 * np.exp(0.7j), 0.0])
        return abs(np.linalg.solve(stiffness, force)[2]) - 4e-4

    branch = ns.continue_orbit(machine, "Omega", (30.0, 160.0))
    grazes = branch["special_value"].values[branch["special_kind"].values == "grazing"]
    for between in ((40.0, 43.0), (150.0, 152.0)):
        exact = brentq(beyond, *between, xtol=1e-13)
        assert np.abs(grazes - exact).min() < 1e-9
    assert "sliding" not in branch["special_kind"].values


@pytest.mark.slow
def test_rest_leaves_nothing_of_what_a_slow_impact_makes_large():
    """A seat on rigid stops, on which it rests once in a turn."""
    hits = {"reset": {"v": "-0.3*v"}}
    ride = ns.Mode(
        {"z": "v", "v": "-(4000*z + 180*v)/75 - a*sin(3.2*pi*t)"},
        exits=[
            ns.Exit("0.04 - z", sticks="top", name="up", **hits),
            ns.Exit("z + 0.05", sticks="bottom", name="down", **hits),
        ],
    )
    seat = ns.System(states=["z", "v"], parameters={"a": 3.0}, period="1/1.6", modes={"ride": ride})
    branch = ns.continue_orbit(seat, "a", (0.5, 15.0), direction="up", steps=4000)
    assert branch.attrs["end_last"] == "bound"
    assert "no special point was found" not in branch.attrs["message"]
