"""All periodic orbits of systems whose orbits are known."""

import re
from collections import Counter
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.progress import Progress
from periodic_orbits.references import cycles
from periodic_orbits.references.rigid_wall import RigidWall
from periodic_orbits.sampler import mole_penetration
from periodic_orbits.systems import clock, rigid_wall

A = Fraction(2, 5)  # peak of the tent
UNIT = {"x": (0, 1)}


def driven_tent() -> ns.System:
    """x -> x/a below a, (1 - x)/(1 - a) above, half way through every period."""
    tick, late = "sin(2*pi*t)", "-sin(2*pi*t)"
    return ns.System(
        name="driven_tent",
        states=["x"],
        period=1.0,
        parameters={"a": float(A)},
        modes={
            "low": ns.Mode(
                {"x": "0"},
                exits=[ns.Exit("a - x", to="high"), ns.Exit(tick, to="wait", reset={"x": "x/a"})],
            ),
            "high": ns.Mode(
                {"x": "0"},
                exits=[
                    ns.Exit("x - a", to="low"),
                    ns.Exit(tick, to="wait", reset={"x": "(1 - x)/(1 - a)"}),
                ],
            ),
            "wait": ns.Mode({"x": "0"}, exits=[ns.Exit(late, to="low")]),
        },
        initial={"x": 0.31},
    )


def ticking_tent() -> ns.System:
    """The same whenever a clock of its own has come to one: nothing drives it."""
    rates = {"x": "0", "s": "1"}
    return ns.System(
        name="ticking_tent",
        states=["x", "s"],
        parameters={"a": float(A)},
        modes={
            "low": ns.Mode(
                rates,
                exits=[
                    ns.Exit("a - x", to="high"),
                    ns.Exit("1 - s", reset={"x": "x/a", "s": "0"}),
                ],
            ),
            "high": ns.Mode(
                rates,
                exits=[
                    ns.Exit("x - a", to="low"),
                    ns.Exit("1 - s", reset={"x": "(1 - x)/(1 - a)", "s": "0"}),
                ],
            ),
        },
        initial={"x": 0.31},
    )


def tent_orbits(lengths) -> list[tuple[str, Fraction]]:
    """Primitive orbits of the tent as words of L and H, each with its smallest point.

    Every word of L and H is that of one orbit: a composition of two expanding branches.
    """
    found = []
    for n in lengths:
        for letters in product("HL", repeat=n):
            word = "".join(letters)
            turned = [word[k:] + word[:k] for k in range(n)]
            if word == min(turned) and len(set(turned)) == n:
                found.append((word, min(_point(each) for each in turned)))
    return found


def _point(word: str) -> Fraction:
    """x = slope x + rest after all branches."""
    slope, rest = Fraction(1), Fraction(0)
    for letter in word:
        if letter == "L":
            slope, rest = slope / A, rest / A
        else:
            slope, rest = -slope / (1 - A), (1 - rest) / (1 - A)
    return rest / (1 - slope)


def most_returns(word: str) -> int:
    """How often an orbit passes the event that it passes most often."""
    return max(Counter(zip(word, word[1:] + word[:1], strict=True)).values())


@pytest.mark.slow
def test_every_orbit_of_a_driven_tent():
    """2, 1, 2, 3, 6 orbits of the periods 1 to 5, at rational points."""
    found = ns.orbits(driven_tent(), UNIT, longest=5, phase=0.25)
    exact = tent_orbits(range(1, 6))
    assert np.bincount(found["period"])[1:].tolist() == [2, 1, 2, 3, 6]
    assert np.all(found["length"] == found["period"]) and np.all(found["primitive_parts"] == 1)
    assert np.all(found["admissible"]) and not np.any(found["stable"])
    assert np.all(found["found"] >= 1) and found.attrs["status"] == "completed"
    for k in range(found.sizes["orbit"]):
        orbit = found.isel(orbit=k)
        # points behind each tick, which stand until the next one
        points = orbit["leg_states"].values[orbit["leg_mode"].values == 2]
        matches = [
            word for word, x in exact
            if len(word) == int(orbit["period"]) and abs(points.min() - float(x)) < 1e-12
        ]  # fmt: skip
        assert len(matches) == 1
        slopes = [float(1 / A) if each == "L" else -float(1 / (1 - A)) for each in matches[0]]
        assert abs(orbit["multipliers"].values[0] / np.prod(slopes) - 1) < 1e-12


@pytest.mark.slow
def test_every_orbit_of_a_ticking_tent():
    """Where nothing drives a system, periods are returns to the event that is passed most often."""
    found = ns.orbits(ticking_tent(), UNIT | {"s": (0, 1)}, longest=2, guesses=400)
    exact = [(word, x) for word, x in tent_orbits(range(1, 9)) if most_returns(word) <= 2]
    assert found.sizes["orbit"] == len(exact)
    for word, x in exact:
        alike = found.isel(orbit=np.abs(found["length"].values - len(word)) < 1e-9)
        starts = np.nanmin(alike["leg_states"].sel(state="x").values, axis=1)
        one = alike.isel(orbit=np.abs(starts - float(x)) < 1e-9)
        assert one.sizes["orbit"] == 1
        assert one["period"].item() == most_returns(word)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("b", "counts"), [pytest.param(0.19, [3, 3, 6], marks=pytest.mark.slow), (0.095, [1, 1, 0])]
)
def test_orbits_of_the_mole(b, counts):
    """All of period one lie on the branch; no orbit goes through the slider."""
    mole = ns.models.moling(a=0.3, b=0.15, xi=0.05, omega=0.1)
    found = ns.orbits(mole, longest=3, parameters={"b": b})
    assert np.bincount(found["period"], minlength=4)[1:].tolist() == counts
    branch = ns.continue_orbit(mole, "b", (0.09, 0.2))
    values = branch["b"].values
    speeds = found["v_per_period"].values[found["period"].values == 1]
    crossed = np.flatnonzero((values[:-1] - b) * (values[1:] - b) < 0.0)
    assert len(crossed) == counts[0]
    for k in crossed:
        near = ns.find_orbit(mole, branch.isel(point=int(k)), parameters={"b": b})
        assert np.abs(speeds - float(near["v_per_period"])).min() < 1e-10
    for k in range(found.sizes["orbit"]):
        orbit = found.isel(orbit=k)
        orbit = orbit.isel(leg=np.flatnonzero(orbit["leg_mode"].values >= 0))
        deepest, joint = mole_penetration(orbit, a=0.3, b=b, xi=0.05, omega=0.1)
        assert deepest < 1e-9 and joint < 1e-8


@pytest.mark.slow
def test_orbits_with_one_impact_at_a_rigid_wall():
    words = {"omega": 2.8, "zeta": 0.02, "sigma": 0.1, "r": 0.8}
    found = ns.orbits(rigid_wall(**words), longest=2)
    for n in (1, 2):
        exact = RigidWall.of(**words, n=n)
        ones = found.isel(orbit=found["period"].values == n)
        ones = ones.isel(orbit=(ones["leg_mode"].values >= 0).sum(axis=1) == 2)
        speeds = -ones["leg_states"].sel(state="v")[:, 1].values / words["r"]
        for speed in speeds:
            assert min(abs(speed - float(v)) for v in exact.speeds(1)) < 1e-10
        assert n == 2 or len(speeds) == 1


def test_cycles():
    """A cycle that no motion from rest comes to is found from a region."""
    assert ns.orbits(clock(0.05, 0.1), samples=4).attrs["status"] == "no_orbit"
    found = ns.orbits(clock(0.05, 0.1), {"x": (-1, 1), "v": (-1, 1)}, samples=20)
    assert found["period"].values.tolist() == [1] and found["stable"].item()
    assert (
        abs(found["length"].item() / float(cycles.clock(zeta=0.05, energy=0.1).period) - 1) < 1e-10
    )


def test_a_smooth_cycle():
    equations = {"x": "x - y - x*(x**2 + y**2)", "y": "x + y - y*(x**2 + y**2)"}
    plane = ns.System(states=["x", "y"], equations=equations)
    found = ns.orbits(plane, {"x": (-2, 2), "y": (-2, 2)}, samples=8, record=4)
    assert found.sizes["orbit"] == 1 and found["found"].item() > 4
    assert abs(found["length"].item() / (2 * np.pi) - 1) < 1e-10


def test_one_of_many_is_an_orbit_for_other_verbs():
    mole = ns.models.moling(a=0.3, b=0.095, xi=0.05, omega=0.1)
    found = ns.orbits(mole, longest=2, samples=20, guesses=20)
    double = found.isel(orbit=1)
    again = ns.find_orbit(mole, double)
    assert again.attrs["period"] == 2 and again["primitive_parts"].item() == 1
    assert abs(float(again["v_per_period"] - double["v_per_period"])) < 1e-11
    branch = ns.continue_orbit(mole, "b", (0.0945, 0.0955), initial=double)
    assert branch.attrs["period"] == 2
    run = ns.simulate(mole, double, periods=2)
    assert abs(float(run["y"][-1] - double["y"])) < 1e-9
    same = ns.orbits(mole, longest=2, samples=20, guesses=20)
    assert same.identical(found)


def test_an_orbit_from_which_all_motions_go():
    """x' = x + 3 + cos(2 pi t) has one, at -3 - 1/(1 + 4 pi^2), with the multiplier e."""
    away = ns.System(states=["x"], period=1.0, equations={"x": "x + 3 + cos(2*pi*t)"})
    found = ns.orbits(away, samples=8, record=5)
    assert found.sizes["orbit"] == 1
    assert abs(found["x"].item() + 3 + 1 / (1 + 4 * np.pi**2)) < 1e-12
    assert abs(found["multipliers"].item() - np.e) < 1e-12


def test_no_orbit_is_a_result():
    """A mass that moves away for ever."""
    free = ns.System(states=["x"], period=1.0, equations={"x": "1 + cos(2*pi*t)"})
    found = ns.orbits(free, {"x": (0, 1)}, samples=4, record=5)
    assert found.sizes["orbit"] == 0 and found.attrs["status"] == "no_orbit"
    assert "region=" in found.attrs["message"]


def test_an_interruption_keeps_what_was_found(monkeypatch):
    mole = ns.models.moling(a=0.3, b=0.095, xi=0.05, omega=0.1)
    calls = []

    def update(self, done):
        if self.label == "looking for orbits":
            calls.append(done)
            if len(calls) == 20 + 30:
                raise KeyboardInterrupt

    monkeypatch.setattr(Progress, "update", update)
    found = ns.orbits(mole, longest=4, samples=20, guesses=20)
    assert found.attrs["status"] == "interrupted"
    assert found.sizes["orbit"] in (1, 2)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"longest": 0}, "longest"),
        ({"longest": 2000}, "at most 1000"),
        ({"seed": -1}, "seed = -1"),
        ({"match": 2.0}, "match = 2"),
        ({"samples": 1.5}, "samples"),
        ({"region": {"z": (0, 1)}}, "unknown state 'z'"),
        ({"completion": {"x": 0.0}}, "give region= with it"),
        ({"inadmissible": "yes"}, "inadmissible"),
    ],
)
def test_refusals(options, message):
    with pytest.raises(ns.OptionError, match=message):
        ns.orbits(rigid_wall(), **options)


def test_a_map_of_several_periods_is_refused():
    with pytest.raises(ns.OptionError, match="every=1"):
        ns.orbits(ns.StroboscopicMap(rigid_wall(), every=2))


@pytest.mark.slow
def test_without_a_region_it_says_from_where_starts_were_drawn():
    """Between two stops the motion from rest strikes neither; two orbits that strike lie beyond."""
    stops = ns.System(
        states=["x", "v"], period="2*pi/w",
        parameters={"F": 0.9, "w": 2.0, "z": 0.06, "al": 0.3, "gap": 0.9, "gm": 1.4, "r": 0.7},
        modes={
            "free": ns.Mode(
                {"x": "v", "v": "F*cos(w*t) - 2*z*v - x - al*x**3"},
                exits=[
                    ns.Exit("gap - x", reset={"v": "-r*v"}, name="right"),
                    ns.Exit("x + gm", reset={"v": "-r*v"}, name="left"),
                ],
            )
        },
    )  # fmt: skip
    narrow = ns.orbits(stops, longest=2)
    told = re.search(
        r"initial= \(x (\S+) to (\S+), v (\S+) to (\S+)\): a wider region=",
        narrow.attrs["message"],
    )
    assert told is not None
    wide = ns.orbits(stops, {"x": (-1.4, 0.9), "v": (-3, 3)}, longest=2)
    assert "wider region=" not in wide.attrs["message"]
    assert wide.sizes["orbit"] > narrow.sizes["orbit"]
    # the range of strobes of the motion from rest, and half of it on either side
    run = ns.simulate(stops, periods=500, samples_per_period=1)
    for name, ends in zip(("x", "v"), (told.groups()[:2], told.groups()[2:]), strict=True):
        low, high = float(run[name].min()), float(run[name].max())
        wider = 0.5 * (high - low)
        found = [float(end) for end in ends]
        assert found == pytest.approx([low - wider, high + wider], rel=6e-3)  # three digits
