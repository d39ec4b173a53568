"""Branches of cycles that grow without bound: they say so, and at which parameter."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth.periodic_orbits.guess import cycle_guesses
from nonsmooth.periodic_orbits.unbounded import LastOrbits


def circle(radius: str, turning: str, **parameters: float) -> ns.System:
    """x' = x r - y w, y' = y r + x w: in polar coordinates r' = r radius, angle' = turning."""
    return ns.System(
        states=["x", "y"],
        parameters=parameters,
        equations={
            "x": f"x*({radius}) - y*({turning})",
            "y": f"y*({radius}) + x*({turning})",
        },
    )


@pytest.mark.slow
def test_an_amplitude_without_bound():
    """The radius is 1/sqrt(mu), on which the flow turns once in 2 pi."""
    system = circle("1 - mu*(x**2 + y**2)", "1", mu=0.5)
    branch = ns.continue_orbit(system, "mu", (-0.5, 1.0), initial={"x": 1.2}, transient=20)
    assert branch.attrs["end_first"] == "unbounded"
    assert "the amplitude grows without bound" in branch.attrs["message"]
    mu = branch["mu"].values
    radius = np.hypot(branch["x"], branch["y"]).values * np.sqrt(mu)
    assert radius[mu > 1e-3] == pytest.approx(1.0, rel=1e-8)
    assert radius == pytest.approx(1.0, rel=1e-2)  # where mu itself is next to rounding
    assert 0.0 < branch["mu"].min().item() < 1e-11
    assert branch.attrs["end_last"] == "bound"


def saddle_node_on_a_circle(steps: int) -> xr.Dataset:
    """On the unit circle angle' = p - cos(angle), so a turn takes 2 pi/sqrt(p**2 - 1)."""
    return ns.continue_orbit(
        circle("1 - x**2 - y**2", "p - x/sqrt(x**2 + y**2)", p=1.5), "p", (0.5, 2.0),
        initial={"x": 1.0}, direction="down", steps=steps, largest_step=0.5, transient=20,
    )  # fmt: skip


@pytest.mark.slow
def test_a_period_without_bound():
    branch = saddle_node_on_a_circle(150)
    assert branch.attrs["end_first"] == "unbounded"
    assert "the period grows without bound" in branch.attrs["message"]
    p, length = branch["p"].values, branch["length"].values
    assert p.min() == pytest.approx(1.0, abs=2e-3)
    assert length == pytest.approx(2 * np.pi / np.sqrt(p**2 - 1), rel=1e-6)


def test_a_branch_whose_parameter_still_moves_has_taken_its_steps():
    """The period grows here too."""
    assert saddle_node_on_a_circle(10).attrs["end_first"] == "steps"


def first_far(p: np.ndarray, period: np.ndarray) -> int:
    """Number of the orbit after which nothing else is expected, -1 for none."""
    last = LastOrbits(SimpleNamespace(bounds=(0.0, 2.0), parameter="p"))
    for k, (value, length) in enumerate(zip(p, period, strict=True)):
        turn = SimpleNamespace(states=np.ones((1, 1)), instants=np.array([0.0, length]))
        last.add(SimpleNamespace(value=float(value), looked=SimpleNamespace(turn=turn)))
        if last.are_far:
            return k
    return -1


def test_where_the_parameter_is_at_its_limit_to_rounding():
    k = np.arange(80)
    steps = 0.5 * 0.6**k  # of the parameter, as at a saddle, which is passed in 1, 2, 3 ... units
    far = first_far(1.0 - steps, 5.0 + k)
    assert 0.4 * steps[far - 1] <= 1e3 * 2.0 * np.finfo(float).eps < 0.4 * steps[far - 2]
    assert first_far(1.0 - steps, 5.0 - 0.6**k) == -1  # the period has a limit too
    assert first_far(np.ones(80), 5.0 + k) == -1  # all cycles are at one value
    assert first_far(0.5 + 1e-6 * k, 5.0 + k) == -1  # the parameter goes on


def test_a_period_without_bound_where_steps_become_short():
    """Three genes that switch each other off; their levels k/g fall to the threshold at g = k/th.

    There the period goes as a logarithm, and rounding of the states is much of what is left.
    """
    names = "abc"
    ring = ns.System(
        states=list(names),
        parameters={"k": 2.0, "g": 2.7, "th": 0.7},
        initial={"a": 0.702, "b": 0.3, "c": 0.1},
        equations={
            name: f"k*heaviside(th - {before}) - g*{name}"
            for name, before in zip(names, "cab", strict=True)
        },
    )
    branch = ns.continue_orbit(ring, "g", (0.3, 3.0), direction="up", transient=5)
    assert branch.attrs["end_last"] == "unbounded"
    assert "the period grows without bound" in branch.attrs["message"]
    assert branch["g"].values[-1] == pytest.approx(2.0 / 0.7, abs=1e-7)
    assert branch.sizes["special"] == 0  # no change of the word by rounding
    assert np.all(np.diff(branch["length"].values) > 0.0)


def test_steps_grow_with_the_period():
    """A heater whose power just reaches the upper limit: k (U - upper) is what is left of it."""
    on = ns.Mode({"T": "-k*(T - Ta) + k*U"}, exits=[ns.Exit("s + h - T", to="off", name="hot")])
    off = ns.Mode({"T": "-k*(T - Ta)"}, exits=[ns.Exit("T - s + h", to="on", name="cold")])
    heater = ns.System(
        states=["T"],
        parameters={"h": 0.5, "U": 30.0, "k": 0.1, "Ta": 10.0, "s": 20.0},
        initial={"T": 15.0},
        modes={"on": on, "off": off},
    )
    branch = ns.continue_orbit(heater, "U", (5.0, 60.0), transient=5)
    assert (branch.attrs["end_first"], branch.attrs["end_last"]) == ("unbounded", "bound")
    power = branch["U"].values
    assert power[0] == pytest.approx(10.5, abs=1e-10)  # in 20 percent of the steps that are allowed
    cycles = 10.0 * np.log((power - 9.5) / (power - 10.5) * 10.5 / 9.5)
    clear = power > 10.5 + 1e-6
    assert branch["length"].values[clear] == pytest.approx(cycles[clear], rel=1e-8)


def test_a_word_that_rounding_changes_where_the_period_has_no_bound():
    """McKean's neuron: its rest reaches a knee at I = 3/8 and 7/8, where w = 2 v."""
    neuron = ns.System(
        states=["v", "w"],
        parameters={"I": 0.5, "eps": 0.05, "c": 0.5, "a": 0.25},
        initial={"v": 0.3},
        equations={
            "v": "where(v < a/2, -v, where(v < (1 + a)/2, v - a, 1 - v)) - w + I",
            "w": "eps*(v - c*w)",
        },
    )
    branch = ns.continue_orbit(neuron, "I", (0.0, 1.5), transient=10)
    assert (branch.attrs["end_first"], branch.attrs["end_last"]) == ("unbounded", "unbounded")
    assert branch["I"].values[[0, -1]] == pytest.approx([0.375, 0.875], abs=1e-7)
    assert branch.sizes["special"] == 0


def harvest(lo: float) -> ns.System:
    """A stock that is fished from 0.6 down to lo."""
    return ns.System(
        states=["x"],
        parameters={"lo": lo},
        initial={"x": 0.5995},
        modes={
            "rest": ns.Mode({"x": "x*(1 - x)"}, exits=[ns.Exit("0.6 - x", to="fish")]),
            "fish": ns.Mode({"x": "x*(1 - x) - 0.8*x"}, exits=[ns.Exit("x - lo", to="rest")]),
        },
    )


@pytest.mark.slow
def test_thresholds_that_meet_end_a_branch_soon():
    """Beyond, the motion would switch without end, and a log of it would fill the memory."""
    branch = ns.continue_orbit(
        harvest(0.599), "lo", (0.5, 0.6), direction="up", transient=1, largest_step=0.1
    )
    assert branch.attrs["end_last"] == "pseudo_hopf"
    assert branch["special_value"].values[-1] == pytest.approx(0.6, abs=1e-9)


def test_a_motion_that_passes_events_without_end_is_no_guess(monkeypatch):
    monkeypatch.setattr(cycle_guesses, "__kwdefaults__", {"most_events": 10_000})
    orbit = ns.find_orbit(harvest(0.6 - 1e-7))
    assert "has passed 10,000 events at t = " in orbit.attrs["message"]


@pytest.mark.slow
def test_a_word_that_rounding_changes_where_a_cycle_shrinks():
    """A relay with hysteresis h and an overdamped mass: period and speeds go as the root of h."""
    latch = ns.System(
        states=["x", "v"],
        parameters={"h": 0.01},
        initial={"x": 0.0},
        modes={
            "up": ns.Mode({"x": "v", "v": "1 - x - 1.5*v"}, exits=[ns.Exit("h - x", to="down")]),
            "down": ns.Mode({"x": "v", "v": "-1 - x - 1.5*v"}, exits=[ns.Exit("x + h", to="up")]),
        },
    )
    branch = ns.continue_orbit(latch, "h", (0.0, 1.0), direction="down", transient=10)
    assert branch["special_kind"].values.tolist() == ["pseudo_hopf"]
    assert branch["special_value"].values == pytest.approx([0.0], abs=1e-13)


def servo(r: float) -> ns.System:
    """A motor under PID control with a static friction of r times 8 mN m: it hunts."""
    torque = "(-0.09*e - 1.2e-3*w - 0.35*z - 1e-5*w - 8e-3*sign(s))/2.3e-5"
    return ns.System(
        states=["e", "w", "z"], parameters={"r": r}, initial={"e": 0.05},
        equations={"e": "w", "w": torque, "z": "e"},
        surfaces={"s": ns.Surface("w", below="back", on="stick", above="forth", hold="r")},
    )  # fmt: skip


def test_slips_between_long_rests_do_not_vanish():
    """Modes are linear: rest places go as r - 1, slips last the same, and rests go as 1/(r - 1)."""
    branch = ns.continue_orbit(servo(1.6), "r", (1.01, 2.0), direction="down")
    assert branch["special_kind"].values.tolist() == ["bound"]
    r = branch["r"].values
    legs = np.sort(branch["durations"].values, axis=1)
    assert legs[:, :2] == pytest.approx(legs[0, 0], rel=1e-12)
    # its integral of the error makes up for what is linear in r, at an error that goes as r - 1
    rests = legs[:, 2] * (r - 1.0)
    assert rests == pytest.approx(np.polyval(np.polyfit(r, rests, 1), r), rel=1e-9)


@pytest.mark.slow
def test_rests_without_bound():
    branch = ns.continue_orbit(servo(1.6), "r", (1.0, 2.0), direction="down")
    assert branch.attrs["end_first"] == "unbounded"
    assert branch["r"].values[0] == pytest.approx(1.0, abs=1e-4)
