"""Tori, and what only looks like one: beside closed forms, maps and integrations by scipy."""

import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth import Exit, Mode, System
from nonsmooth.analysis.regimes.closed_curves import (
    ClosedCurves,
    Rotation,
    closed_curves,
    told_rotation,
)
from nonsmooth.analysis.regimes.window import Growing, run_away, shrinks, strobe_test, travels

GOLDEN = 0.5 * (5**0.5 - 1)
UNSEEN = np.array([np.inf]), np.array([-np.inf])


def label(found) -> str:
    return found["regime"].item()


def told(found) -> tuple[float, float]:
    """Rotation number of a message, below one half, and its error."""
    words = re.search(r"rotation number ([0-9.]+) \+- ([0-9.]+)", found.attrs["message"])
    assert words is not None, found.attrs["message"]
    return min(float(words[1]), 1.0 - float(words[1])), float(words[2])


def folded(number: float) -> float:
    return min(number % 1.0, 1.0 - number % 1.0)


def iterated(step, start, count=1001, transient=5000):
    """Points of a map of the plane, behind a transient."""
    points = [np.array(start, float)]
    for _ in range(transient + count - 1):
        points.append(np.array(step(points[-1])))
    return np.array(points[transient:])


def turned(number: float, count: int = 1001) -> np.ndarray:
    angles = 2 * np.pi * number * np.arange(count)
    return np.column_stack([np.cos(angles), 3.0 * np.sin(angles + 0.4), np.cos(2 * angles)])


@pytest.mark.parametrize("number", [GOLDEN, 2**0.5 - 1, 0.05 * 2**0.5, 0.22336, np.pi - 3])
def test_a_rotation_is_found_to_many_digits(number):
    found = closed_curves(turned(number))
    assert isinstance(found, ClosedCurves)
    assert told_rotation(found) == pytest.approx(folded(number), abs=1e-8)
    assert np.array_equal(np.sort(found.places), np.arange(1001))


def test_curves_with_corners_and_jumps():
    phases = np.arange(1001) * GOLDEN % 1.0
    corners = np.column_stack([np.abs(phases - 0.5), np.where(phases < 0.3, phases, 0.3)])
    jumps = np.column_stack([phases, np.sign(phases - 0.7), np.sqrt(phases)])
    for points in (corners, jumps):
        found = closed_curves(points)
        assert isinstance(found, ClosedCurves)
        assert folded(told_rotation(found)) == pytest.approx(1 - GOLDEN, abs=1e-7)
    # a state that rises along the circle, and falls at its end, has the sense of the turn
    assert told_rotation(closed_curves(jumps)) == pytest.approx(GOLDEN, abs=1e-7)
    assert told_rotation(closed_curves(-jumps)) == pytest.approx(1 - GOLDEN, abs=1e-7)


@pytest.mark.parametrize("pieces", [2, 3, 8])
def test_several_curves_that_are_visited_in_turn(pieces):
    strobes = np.repeat(turned(GOLDEN, 1 + 1000 // pieces), pieces, axis=0)[:1000]
    strobes = 0.05 * strobes + np.cos(2 * np.pi * np.arange(1000) / pieces + 0.1)[:, None]
    found = closed_curves(strobes)
    assert isinstance(found, ClosedCurves)
    assert found.rotation.pieces == pieces
    assert found.rotation.number == pytest.approx(1 - GOLDEN, abs=1e-6)


@pytest.mark.parametrize("a", [2.01, 2.05, 2.1, 2.16])
def test_the_torus_of_the_delayed_logistic_map(a):
    """Born at a = 2 with the rotation number 1/6."""
    points = iterated(lambda z: [a * z[0] * (1 - z[1]), z[0]], [0.5, 0.5])
    found = closed_curves(points)
    assert isinstance(found, ClosedCurves)
    around = np.unwrap(np.arctan2(points[:, 1] - points[:, 1].mean(), points[:, 0] - 0.55))
    mean = abs(around[-1] - around[0]) / (2 * np.pi * 1000)
    assert found.rotation.number == pytest.approx(mean, abs=1e-3)
    if a == 2.01:
        assert found.rotation.number == pytest.approx(1 / 6, abs=2e-3)


@pytest.mark.parametrize(
    "points",
    [
        iterated(lambda z: [2.27 * z[0] * (1 - z[1]), z[0]], [0.5, 0.5]),  # the torus has broken
        iterated(lambda z: [1 - 1.4 * z[0] ** 2 + z[1], 0.3 * z[0]], [0.1, 0.1]),
        iterated(lambda z: [1 - 1.06 * z[0] ** 2 + z[1], 0.3 * z[0]], [0.1, 0.1]),  # in bands
        iterated(lambda z: [3.58 * z[0] * (1 - z[0]), z[0]], [0.3, 0.3]),  # in bands, as a shift
        np.random.default_rng(0).normal(size=(1001, 3)),
        np.column_stack([np.arange(1001.0), np.arange(1001.0) ** 2]),
        np.exp(-np.arange(1001.0) / 300)[:, None],
        np.exp(-1e-4 * np.arange(1001.0))[:, None] * turned(0.22336),  # a spiral
        np.arange(1001.0)[:, None] * turned(0.22336),
        turned(37 / 151),  # of a period
        turned(3 / 7) + 1e-6 * turned(GOLDEN),
        turned(2**0.5) + turned(3**0.5),  # a torus of three frequencies is no curve
    ],
    ids=["broken torus", "henon", "henon's bands", "logistic bands", "noise", "ramp", "decay",
         "spiral", "growth", "period 151", "near period 7", "two frequencies"],
)  # fmt: skip
def test_what_is_no_closed_curve(points):
    assert isinstance(closed_curves(points), Rotation)


@pytest.mark.parametrize("size", [1.0, 0.1, 0.01, 3e-3])
def test_chaos_that_a_clock_turns_is_no_curve(size):
    """The clock keeps its order whatever is beside it."""
    phases = np.arange(1001) * GOLDEN % 1.0
    chaos = iterated(lambda z: [4 * z[0] * (1 - z[0]), 0.0], [0.3, 0.0])[:, 0]
    points = np.column_stack([phases, np.sin(2 * np.pi * phases) + size * chaos])
    assert isinstance(closed_curves(points), Rotation)


def test_strobes_that_creep_say_how_many_close_the_curve():
    """Fifteen arcs of which each visit covers 15 times 2.3e-5."""
    found = closed_curves(turned(2 / 15 - 2.3e-5))
    assert isinstance(found, Rotation)
    assert found.lag == 15
    assert 1 / (15 * 2.3e-5) <= found.needed * 1.05 <= 3 / (15 * 2.3e-5)
    assert isinstance(closed_curves(turned(2 / 15 - 2.3e-5, found.needed)), ClosedCurves)


def test_the_same_curve_and_others():
    found = closed_curves(turned(GOLDEN))
    later = turned(GOLDEN, 12001)[11000:]
    assert found.away(later) < 0.01 < 0.1 < found.away(1.001 * later)
    assert found.meets(turned(GOLDEN)) < 1e-9 < 1e-3 < found.meets(later)
    assert found.nearing(later) == pytest.approx(1.0, rel=0.01)


def cycle_beside(cycle: dict[str, str], omega: float) -> System:
    """A cycle, and a state that is driven and meets it nowhere: a torus of two clocks."""
    return System(
        states=[*cycle, "y"],
        initial={"x": 1.0},
        period=f"2*pi/{omega}",
        equations={**cycle, "y": f"-y + cos({omega}*t)"},
    )


@pytest.mark.slow
@pytest.mark.parametrize(("mu", "omega"), [(3.0, 1.3), (5.0, 1.3), (4.0, 1.1)])
def test_neighbours_that_come_and_go_by_large_factors(mu, omega):
    """Stiff cycles of van der Pol: the strobe's part of their period, by scipy, is the turn."""
    run = solve_ivp(
        lambda t, z: [z[1], mu * (1 - z[0] ** 2) * z[1] - z[0]], (0, 400), [1.0, 0.0],
        method="LSODA", rtol=1e-10, atol=1e-12, events=lambda t, z: z[0],
    )  # fmt: skip
    passes = run.t_events[0][-21:]
    period = (passes[-1] - passes[0]) / 10
    found = ns.regime(cycle_beside({"x": "v", "v": f"{mu}*(1 - x**2)*v - x"}, omega))
    assert label(found) == "quasi-periodic"
    number, error = told(found)
    assert number == pytest.approx(folded(2 * np.pi / omega / period), abs=error)
    assert found["exponent_error"].item() > 1e-3  # of which nothing follows


@pytest.mark.parametrize(("belt", "omega"), [(0.5, 1.23), (0.3, 0.9), (1.0, 1.7)])
def test_stick_and_slip_beside_a_driven_state(belt, omega):
    """A block on a belt: it sticks for 2 d/v, and slips for 2 pi - 2 arctan(d/v)."""
    driven = {"y": f"-y + cos({omega}*t)"}
    system = System(
        states=["x", "v", "y"],
        parameters={"V": belt},
        period=f"2*pi/{omega}",
        initial={"x": 0.0, "v": belt},
        modes={
            "stick": Mode({"x": "V", "v": "0", **driven}, exits=[Exit("1 - x", to="slip")]),
            "slip": Mode(
                {"x": "v", "v": "0.6 - x", **driven},
                exits=[Exit("V - v", to="stick", reset={"v": "V"})],
            ),
        },
    )
    found = ns.regime(system, mode="stick")
    assert label(found) == "quasi-periodic", found.attrs["message"]
    period = 0.8 / belt + 2 * np.pi - 2 * np.arctan(0.4 / belt)
    number, error = told(found)
    assert number == pytest.approx(folded(2 * np.pi / omega / period), abs=error)


def clocked(a: float) -> System:
    """A clock of its own frequency, and once a period x becomes 1 - a x^2, a little of y."""
    flow = {"c": "turn/(2*pi)", "x": "0", "y": "-y + c + 1e-3*x"}
    back = Exit("1 - c", reset={"c": "0"}, name="back")
    mapped = Exit("-sin(t)", to="first", reset={"x": f"1 - {a}*x**2"})
    return System(
        states=["c", "x", "y"],
        parameters={"turn": GOLDEN},
        period="2*pi",
        initial={"c": 0.1, "x": 0.3},
        modes={
            "first": Mode(flow, exits=[Exit("sin(t)", to="second"), back]),
            "second": Mode(flow, exits=[mapped, back]),
        },
    )


def test_a_clock_beside_chaos_is_chaotic():
    """At a = 0.5 the map settles; at 1.5 and 1.9 it is chaotic."""
    found = ns.regime(clocked(0.5), phase=0.25)
    assert label(found) == "quasi-periodic"
    assert told(found)[0] == pytest.approx(1 - GOLDEN, abs=1e-3)
    for a in (1.5, 1.9):
        found = ns.regime(clocked(a), phase=0.25)
        assert label(found) == "chaotic"
        x, total = 0.3, 0.0
        for k in range(20_000):
            x = 1 - a * x * x
            total += np.log(abs(2 * a * x)) if k >= 1000 else 0.0
        assert found["exponent"].item() == pytest.approx(total / 19_000 / (2 * np.pi), abs=0.006)


@pytest.mark.parametrize("omega", [2.463, 2.466])
def test_chaos_of_a_driven_cycle_stays_chaotic(omega):
    """Parlitz and Lauterborn, Physical Review A 36 (1987): mu = d = 5, about omega = 2.466."""
    flow = {"x": "v", "v": f"5*(1 - x**2)*v - x + 5*cos({omega}*t)"}
    system = System(states=["x", "v"], period=f"2*pi/{omega}", initial={"x": 1.0}, equations=flow)
    assert label(ns.regime(system)) == "chaotic"


@pytest.mark.parametrize("zeta", [3e-5, 1e-5, 1e-6, 1e-7])
def test_a_decay_over_many_windows_is_no_torus(zeta):
    """exp(-2 pi zeta) of the way to the cycle is left after a period."""
    system = System(
        states=["x", "v"],
        parameters={"zeta": zeta},
        period="2*pi",
        initial={"x": 1.0},
        equations={"x": "v", "v": "-2.1*x - 2*zeta*v + cos(t)"},
    )
    found = ns.regime(system)
    assert label(found) == "unsettled"
    told_factor = re.search(r"by a factor ([0-9.]+) per period", found.attrs["message"])
    assert told_factor is not None
    assert 1 - float(told_factor[1]) == pytest.approx(2 * np.pi * zeta, rel=0.02, abs=5e-7)
    free = system.with_parameters(zeta=0.0)
    assert label(ns.regime(free)) == "quasi-periodic"
    assert told(ns.regime(free))[0] == pytest.approx(folded(2.1**0.5), abs=1e-3)


@pytest.mark.parametrize("off", [4e-4, 5e-4, 6e-4, 3e-3])
def test_a_beat_is_not_said_to_grow_or_settle(off):
    """x is as 1 - cos(2 pi off k) at strobes: beats of 300 to 2500 periods, for ever."""
    flow = {"x": "v", "v": f"-{1 + off}**2*x + cos(t)"}
    found = ns.regime(System(states=["x", "v"], period="2*pi", equations=flow))
    assert "without bound" not in found.attrs["message"]
    assert "every state shrinks" not in found.attrs["message"]
    assert label(found) in ("quasi-periodic", "unsettled")


def test_a_torus_whose_windows_reach_ever_farther():
    """A servo with a relay near a resonance of its cycle and its force."""
    flow = {"x": "v", "v": "-0.35*v - 0.4*x + 1.5*h + A*cos(w*t)", "h": "0"}
    servo = System(
        states=["x", "v", "h"],
        parameters={"A": 0.19, "w": 1.4},
        period="2*pi/w",
        initial={"h": 1.0},
        modes={
            "plus": Mode(flow, exits=[Exit("0.2 - x", to="minus", reset={"h": "-1"})]),
            "minus": Mode(flow, exits=[Exit("x + 0.2", to="plus", reset={"h": "1"})]),
        },
    )
    # growth was seen in the first two; K of 0.98, and errors that decide nothing, in the others
    for force, omega in [(0.19, 1.4), (0.91, 0.9), (0.37, 0.9), (0.28, 1.2), (0.28, 1.3)]:
        found = ns.regime(servo.with_parameters(A=force, w=omega), mode="plus")
        assert label(found) == "quasi-periodic", found.attrs["message"]
    creeping = servo.with_parameters(A=0.73, w=0.8)
    found = ns.regime(creeping, mode="plus")
    assert label(found) == "unsettled"
    cure = re.search(
        r"after 15 periods and creep .* evidence=([0-9]+) sees", found.attrs["message"]
    )
    assert cure is not None
    assert label(ns.regime(creeping, mode="plus", evidence=int(cure[1]))) == "quasi-periodic"


def test_growth_needs_to_leave_what_was_seen():
    k = np.arange(1001.0)[:, None]
    beat = 1.0 - np.cos(2 * np.pi * k / 8000)
    fine = np.cos(2 * np.pi * 0.244188 * k) * (1 + 1e-5 * k / 1000)  # finds its extremes better
    strobes = np.stack([beat, beat, fine, fine, 3.0 + k / 1000, 3.0 + k / 1000])
    seen = np.array([0, 1, 0, 1, 1, 1], bool)[:, None]
    low, high = np.where(seen, -1.0, np.inf), np.where(seen, 2.0, -np.inf)
    moving = np.array([1, 1, 1, 1, 1, 0], bool)[:, None]
    growing = Growing.of(strobes, moving, np.ones((6, 1)), (low, high))
    told = [growing.told(i, ("x",)) for i in range(6)]
    assert told[0].startswith("x grows from window to window, as a long beat may do")
    assert told[1] == told[2] == told[3] == told[5] == ""
    assert "without bound so far" in told[4]
    assert "moves on by the same amount" in told[4]


def test_bursts_and_beats_that_were_seen_before():
    quiet, burst = 0.01 * np.sin(np.arange(500.0))[:, None], np.sin(np.arange(500.0))[:, None]
    assert run_away(quiet, burst, UNSEEN, np.zeros(1))
    assert not run_away(quiet, burst, (np.array([-1.1]), np.array([1.1])), np.zeros(1))
    assert "x travels" in travels(quiet, 2.0 + quiet, ("x",), UNSEEN)
    assert travels(quiet, 2.0 + quiet, ("x",), (np.array([-3.0]), np.array([3.0]))) == ""


def test_a_part_of_a_beat_does_not_shrink():
    """Halves of one and a half turns spread as far, to rounding, and have other values."""
    k = np.arange(1000.0)
    turn = np.column_stack([np.cos(2 * np.pi * k / 333), np.sin(2 * np.pi * k / 333)])
    turn[500:] *= 1.0 - 1e-9
    assert not shrinks(turn[:500], turn[500:], np.zeros(2))
    assert shrinks(turn[:500], 0.4 * turn[500:], np.zeros(2))


@pytest.mark.parametrize("number", [0.2367888, 0.311155])
def test_a_near_period_is_left_in_a_torus(number):
    """Without it a beat with corners, longer than the series, is left: no regular one to K."""
    values = np.clip(np.sin(2 * np.pi * number * np.arange(1001)), -0.9, 0.3)
    assert strobe_test(values, asked=True, beats=True).k < 0.1
    assert strobe_test(values, asked=True, beats=False).k > 0.5
