"""Orbits of the ground mole, of any word, against Newton's method in 90 digits."""

import json
import math

import numpy as np
import pytest
from mpmath import mp, mpf

import nonsmooth as ns
from periodic_orbits.references import make_orbits
from periodic_orbits.references.mole import certify, mole_course
from periodic_orbits.references.mole_cases import CASES
from periodic_orbits.references.turn import close, lasting
from periodic_orbits.sampler import legs_of, mole_penetration
from periodic_orbits.systems import ORBITS, as_complex, assert_multipliers, assert_state

KEPT = ORBITS["mole_orbits"]
POINTS = ORBITS["mole_points"]
DEFAULTS = {"a": 0.3, "b": 0.15, "xi": 0.05, "omega": 0.1}
LONG = "thirty_two_periods"


def numbers(name: str) -> dict[str, float]:
    return DEFAULTS | {key: float(value) for key, value in CASES[name].parameters.items()}


def start_of(kept: dict) -> dict[str, float]:
    return dict(zip("pyq", map(float, kept["state"][:3]), strict=True))


def assert_orbit(orbit, name: str) -> None:
    kept, case = KEPT[name], CASES[name]
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    assert [mode for mode, *_ in legs_of(orbit)] == case.word.split()
    assert bool(orbit["admissible"])
    assert_state(orbit, start_of(kept), 1e-10)
    durations = [float(d) for d in kept["durations"]]
    assert np.abs(orbit["durations"].values - durations).max() < 1e-9 * max(durations)
    multipliers = [as_complex(each) for each in kept["multipliers"]]
    assert_multipliers(orbit, multipliers)
    assert bool(orbit["stable"]) == (abs(multipliers[0]) < 1)
    # y is of order a / omega, and v its integral over a period
    scale = max(1.0, numbers(name)["a"] / numbers(name)["omega"] ** 2)
    assert abs(float(orbit["v_per_period"]) - float(kept["progression"])) < 1e-10 * scale
    span = case.periods * 2 * math.pi / numbers(name)["omega"]
    assert abs(float(orbit["length"]) / span - 1) < 1e-14


@pytest.mark.parametrize("name", [name for name in CASES if name != LONG])
def test_from_its_state(name):
    system = ns.models.moling(**numbers(name))
    orbit = ns.find_orbit(system, start_of(KEPT[name]), period=CASES[name].periods)
    assert_orbit(orbit, name)
    deepest, joint = mole_penetration(orbit, **numbers(name))
    scale = max(1.0, numbers(name)["a"] / numbers(name)["omega"] ** 2)
    assert deepest < 1e-12 * scale and joint < 1e-10 * scale


STABLE = [name for name in CASES if name != LONG and "passed" not in name and "behind" not in name]


@pytest.mark.parametrize("name", STABLE)
def test_from_rest(name):
    """The motion from rest settles on it, for these parameters; the call is always the same."""
    orbit = ns.find_orbit(
        ns.models.moling(**numbers(name)), period=CASES[name].periods, transient=600
    )
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    # an orbit of several periods may be reported at any of its points: what they share
    assert abs(float(orbit["v_per_period"]) - float(KEPT[name]["progression"])) < 1e-8
    expected = as_complex(KEPT[name]["multipliers"][0])
    found = orbit["multipliers"].values
    assert min(abs(found - expected)) < 1e-9


@pytest.mark.parametrize("name", ["two_impacts", "no_last_contact", "three_impacts", "flip_passed"])
def test_from_a_word_alone(name):
    """Without a motion that follows it: the word and a rough start."""
    kept, case = KEPT[name], CASES[name]
    start = {key: round(value, 2) for key, value in start_of(kept).items()}
    if case.letters[0] != "N":
        start["p"] = start["q"] + 0.02
    orbit = ns.find_orbit(ns.models.moling(**numbers(name)), start, word=case.word)
    assert_orbit(orbit, name)


def test_a_word_of_129_legs():
    """The cascade's orbit of period 32, its multipliers and progression."""
    kept = KEPT[LONG]
    orbit = ns.find_orbit(ns.models.moling(**numbers(LONG)), start_of(kept), period=32)
    assert orbit.sizes["leg"] == 129 == len(kept["durations"])
    assert_orbit(orbit, LONG)


def test_permanent_contact_has_the_multipliers_of_its_oscillator():
    """And no reference is needed: exp((-xi +- i sqrt(1 - xi^2)) period)."""
    values = numbers("always_contact")
    orbit = ns.find_orbit(ns.models.moling(**values))
    root = complex(-values["xi"], math.sqrt(1 - values["xi"] ** 2))
    expected = np.exp(root * 2 * math.pi / values["omega"])
    assert_multipliers(orbit, [expected, expected.conjugate()])
    assert float(orbit["v_per_period"]) == 0.0


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("periods", [1, 2, 4])
def test_stability_changes_at_the_flips(periods, side):
    """A millionth to either side of the reference's flip."""
    kept = POINTS[f"flip_{periods}"]
    b = float(kept["value"]) + side * 1e-6
    system = ns.models.moling(**DEFAULTS | {"b": b})
    orbit = ns.find_orbit(system, start_of(kept), period=periods)
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    assert bool(orbit["stable"]) == (side > 0)
    # 1e-6 of b moves the multiplier by some 1e-5 to 1e-3
    assert 1e-6 < abs(orbit["multipliers"].values[0] + 1) < 1e-2


@pytest.mark.parametrize("longer", [0.05, 0.005, -0.005, -0.05])
def test_both_orbits_beside_the_fold(longer):
    """The progression after phase 0 lasts longer on the stable side of the upper end of b."""
    kept = POINTS["fold"]
    word = CASES["four_phases"].word
    with mp.workdps(60):
        b, near = lasting(
            lambda b: mole_course(word, b=b),
            0,
            mpf(kept["durations"][0]) + longer,
            kept["value"],
            kept["free"],
            kept["durations"],
        )
        exact = close(mole_course(word, b=float(b)), near.free, near.turn.durations)
    assert 0 < mpf(kept["value"]) - b < 1e-5
    start = dict(zip("pyq", map(float, exact.turn.states[0]), strict=False))
    orbit = ns.find_orbit(ns.models.moling(**DEFAULTS | {"b": float(b)}), start)
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    assert bool(orbit["stable"]) == (longer > 0) == bool(exact.multipliers[0] < 1)
    # rounding moves the orbit by EPS over the distance of the multiplier from 1
    near_one = abs(float(exact.multipliers[0]) - 1)
    assert_state(orbit, start, 1e-10 + 1e-13 / near_one)
    assert abs(orbit["multipliers"].values[0] - float(exact.multipliers[0])) < 1e-9 / near_one


@pytest.mark.slow
def test_beyond_the_fold_there_is_none_of_this_word():
    kept = POINTS["fold"]
    beyond = ns.models.moling(**DEFAULTS | {"b": float(kept["value"]) + 1e-3})
    lost = ns.find_orbit(beyond, start_of(kept), word=CASES["four_phases"].word)
    # the equations of a word may have solutions that are no motion
    assert lost.attrs["status"] in ("no_orbit", "singular", "inadmissible")
    assert not bool(lost["admissible"]) and len(lost.attrs["message"]) > 20


def test_doubled_orbits_are_on_the_side_where_the_old_ones_are_unstable():
    """Every flip of the cascade is supercritical, towards small b: judged from both orbits."""
    for periods in (1, 2, 4, 8, 16):
        kept = POINTS[f"flip_{periods}"]
        assert kept["supercritical"] and float(kept["curvature"]) < 0
    values = [float(POINTS[f"flip_{n}"]["value"]) for n in (1, 2, 4, 8, 16)]
    ratios = [(values[k] - values[k + 1]) / (values[k + 1] - values[k + 2]) for k in range(3)]
    # towards Feigenbaum's 4.6692 from above or below, as the cascade begins far from its limit
    assert abs(ratios[-1] - 4.6692) < abs(ratios[0] - 4.6692)
    assert abs(ratios[-1] - 4.6692) < 0.1


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["four_phases", "two_impacts", "no_last_contact", "three_periods"])
def test_the_reference_again(name):
    """From eight digits of what is kept; and through the certified reference of the mole."""
    case, kept = CASES[name], KEPT[name]
    with mp.workdps(60):
        course = mole_course(case.word, periods=case.periods, **case.parameters)
        orbit = close(course, *make_orbits.guess(kept))
        assert certify(case, orbit)
        for found, text in zip(orbit.free, kept["free"], strict=True):
            assert abs(found - mpf(text)) < mpf(10) ** -22 * max(1, abs(found))


@pytest.mark.slow
def test_all_references_again():
    """PYTHONPATH=tests python -m periodic.references.make_orbits"""
    made = make_orbits.make(json.loads(make_orbits.FILE.read_text(encoding="utf-8")))
    for part in ("mole_orbits", "mole_points", "soft_points", "trilinear_points"):
        for name, row in made[part].items():
            kept = ORBITS[part][name]
            for key in ("free", "durations"):
                for found, text in zip(row[key], kept[key], strict=True):
                    assert abs(mpf(found) - mpf(text)) < 1e-20 * max(1, abs(mpf(text))), name
            if "value" in row:
                assert abs(mpf(row["value"]) - mpf(kept["value"])) < 1e-22, name
    assert made["long_wall"]["multipliers"] == ORBITS["long_wall"]["multipliers"]
