"""Orbits of the soft impact and trilinear oscillators against Newton's method in 60 digits."""

import numpy as np
import pytest
from mpmath import mp, mpf

import nonsmooth as ns
from periodic_orbits.references.oscillators import (
    SoftImpact,
    Trilinear,
    soft_grazing_amplitude,
    soft_grazing_frequencies,
)
from periodic_orbits.references.turn import close, lasting
from periodic_orbits.sampler import soft_penetration
from periodic_orbits.systems import ORBITS, as_complex, assert_multipliers, assert_state

SOFT = {"omega": 0.85, "zeta": 0.01, "beta": 29.0, "e": 1.26}
FOLDED = {"omega": 0.6, "zeta": 0.02, "beta": 29.0, "e": 1.26}
WORD = "free contact free"


def truth(words: dict, a: float, kept: dict):
    """The reference orbit, guessed from a kept one."""
    with mp.workdps(60):
        course = SoftImpact(**words, a=a).course(WORD)
        return close(course, kept["free"], kept["durations"])


def state_of(orbit) -> dict[str, float]:
    return {"x": float(orbit.free[0]), "v": float(orbit.free[1])}


@pytest.mark.parametrize("beyond", [0.0, 1e-4, 1e-3, 3e-3])
def test_one_contact_per_period_near_a_flip(beyond):
    kept = ORBITS["soft_points"]["flip"]
    a = float(kept["value"]) + beyond
    exact = truth(SOFT, a, kept)
    orbit = ns.find_orbit(ns.models.soft_impact(**SOFT, a=a), state_of(exact), word=WORD)
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    assert_state(orbit, state_of(exact))
    assert_multipliers(orbit, exact.multipliers)
    log = -2 * SOFT["zeta"] * 2 * np.pi / SOFT["omega"]
    assert abs(float(orbit["log_determinant"]) - log) < 1e-12
    assert (
        np.abs(orbit["durations"].values - [float(d) for d in exact.turn.durations]).max() < 1e-10
    )
    deepest, joint = soft_penetration(orbit, **SOFT, a=a)
    assert deepest < 1e-12 and joint < 1e-11
    if beyond:
        assert not bool(orbit["stable"])


@pytest.mark.parametrize("shorter", [0.1, 0.01, 0.001])
def test_both_orbits_beside_the_fold(shorter):
    """Just beyond grazing two orbits with one contact meet where a multiplier is 1."""
    kept = ORBITS["soft_points"]["fold"]
    for factor in (1 - shorter, 1 + shorter):
        with mp.workdps(60):
            a, exact = lasting(
                lambda a: SoftImpact(**FOLDED, a=a).course(WORD),
                1,
                mpf(kept["durations"][1]) * factor,
                kept["value"],
                kept["free"],
                kept["durations"],
            )
            below = mpf(kept["value"]) - a
            exact = truth(FOLDED, float(a), {"free": exact.free, "durations": exact.turn.durations})
        assert 0 < below < 1e-4
        orbit = ns.find_orbit(
            ns.models.soft_impact(**FOLDED, a=float(a)), state_of(exact), word=WORD
        )
        assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
        # rounding moves the orbit by EPS over the distance of the multiplier from 1
        slack = 1e-10 + 1e-14 / abs(float(abs(exact.multipliers[0]) - 1))
        assert_state(orbit, state_of(exact), slack)
        # the longer contact is the unstable one
        assert bool(orbit["stable"]) == (factor < 1)
        assert bool(abs(exact.multipliers[0]) < 1) == (factor < 1)


@pytest.mark.slow
def test_beyond_the_fold_no_orbit_has_one_contact():
    kept = ORBITS["soft_points"]["fold"]
    start = {"x": float(kept["free"][0]), "v": float(kept["free"][1])}
    system = ns.models.soft_impact(**FOLDED, a=float(kept["value"]) * 1.01)
    orbit = ns.find_orbit(system, start, word=WORD)
    assert orbit.attrs["status"] != "completed" or not bool(
        np.isclose(float(orbit["x"]), start["x"], atol=0.05)
    )


def test_grazing_amplitude_and_frequency_agree():
    with mp.workdps(40):
        a = soft_grazing_amplitude(omega="0.85", zeta="0.01", e="1.26")
        frequencies = soft_grazing_frequencies(zeta="0.01", e="1.26", a=a)
        assert min(abs(f - mpf("0.85")) for f in frequencies) < mpf(10) ** -35


@pytest.mark.parametrize("share", [1 - 1e-3, 1 - 1e-9])
def test_no_contact_below_grazing(share):
    a = share * float(soft_grazing_amplitude(omega=0.85, zeta=0.01, e=1.26))
    drive = -1j * a * 0.85**2 / (1 - 0.85**2 + 2j * 0.01 * 0.85)
    start = {"x": drive.real, "v": (0.85j * drive).real}
    orbit = ns.find_orbit(ns.models.soft_impact(**SOFT, a=a), start)
    assert orbit["word"].item() == "free" and bool(orbit["admissible"])
    assert_state(orbit, start)


@pytest.mark.parametrize("name", ["upper", "lower"])
@pytest.mark.parametrize("off", [1e-6, -1e-6])
def test_the_trilinear_orbit_at_symmetry_breaking(name, off):
    """The half-turn has a multiplier of -1 there, the turn one of 1."""
    kept = ORBITS["trilinear_points"][name]
    omega = float(kept["value"]) + off
    with mp.workdps(60):
        course = Trilinear(omega=omega).course("upper free lower", half=True)
        half = close(course, kept["free"], kept["durations"])
    squares = [complex(m) ** 2 for m in half.multipliers]
    assert abs(squares[0] - 1) < 1e-3 and abs(half.multipliers[0] + 1) < 1e-3
    system = ns.models.trilinear(omega=omega)
    orbit = ns.find_orbit(system, state_of(half), word="upper free lower free upper")
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    # What rounding leaves of the residual moves the orbit by that over the distance of the
    # multiplier from 1, times the condition of the multiplier, which is below 20.
    left = 20.0 * float(orbit["residual"])
    assert_state(orbit, state_of(half), 1e-10 + left / abs(squares[0] - 1))
    assert abs(orbit["multipliers"].values - squares).max() < 1e-7
    assert bool(orbit["stable"]) == bool(abs(half.multipliers[0]) < 1)


@pytest.mark.few(1)
@pytest.mark.parametrize("omega", [1.5, 0.9, 0.6])
def test_the_trilinear_orbit_away_from_symmetry_breaking(omega):
    kept = ORBITS["trilinear_points"]["upper" if omega > 0.8 else "lower"]
    with mp.workdps(60):
        free, durations, value = kept["free"], kept["durations"], mpf(kept["value"])
        for k in range(1, 13):
            course = Trilinear(omega=value + (mpf(omega) - value) * k / 12).course(
                "upper free lower", half=True
            )
            half = close(course, free, durations)
            free, durations = half.free, half.turn.durations
    orbit = ns.find_orbit(
        ns.models.trilinear(omega=omega), state_of(half), word="upper free lower free upper"
    )
    assert_state(orbit, state_of(half))
    assert_multipliers(orbit, [m**2 for m in half.multipliers])
    assert bool(orbit["stable"]) == bool(abs(half.multipliers[0]) < 1)


def test_the_multipliers_at_the_points_are_what_they_should_be():
    flip, fold = ORBITS["soft_points"]["flip"], ORBITS["soft_points"]["fold"]
    assert as_complex(flip["multipliers"][0]) == -1 and as_complex(fold["multipliers"][0]) == 1
    # the product is that of the damping, which no difference quotient knew
    for kept, words in ((flip, SOFT), (fold, FOLDED)):
        product = np.prod([as_complex(m) for m in kept["multipliers"]])
        assert abs(product / np.exp(-4 * np.pi * words["zeta"] / words["omega"]) - 1) < 1e-12
