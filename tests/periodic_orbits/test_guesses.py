"""Guesses of orbits: stretches of motions, leg by leg, and cycles of any speed."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.periodic_orbits.guess import cycle_guesses, driven_guess, guesses_in_motion
from nonsmooth.periodic_orbits.word import words_of_names
from periodic_orbits.kinds import relay, van_der_pol

MOLE = ns.models.moling()


def test_legs_of_a_motion_are_those_of_its_log():
    guess = driven_guess(MOLE, None, period=2, phase=0.0, transient=3, mode=None, tolerance=1e-12)
    run = ns.simulate(MOLE, periods=5)
    T = run.attrs["period"]
    late = run["event_time"].values > 3 * T
    np.testing.assert_allclose(
        guess.turn.instants[1:-1], run["event_time"].values[late] - 3 * T, atol=1e-10
    )
    assert guess.turn.instants[-1] == pytest.approx(2 * T, rel=1e-15)


@pytest.mark.few(1)
@pytest.mark.parametrize("speed", [0.05, 1.0, 40.0])
def test_a_smooth_cycle_of_any_speed(speed):
    found = list(
        cycle_guesses(
            van_der_pol(speed), {"x": 2.00861986}, period=1, transient=0, mode=None, tolerance=1e-12
        )
    )
    lengths = [float(guess.turn.instants[-1]) * speed for guess in found]
    assert any(length == pytest.approx(6.6632868, rel=2e-2) for length in lengths), lengths


def test_a_cycle_through_events():
    start = ns.find_orbit(relay(), {"x": 0.1, "v": 0.5}, mode="push", transient=5)
    guess = next(
        cycle_guesses(
            relay(), {"x": 0.1, "v": 0.5}, period=1, transient=5, mode="push", tolerance=1e-12
        )
    )
    assert len(guess.word) == 2
    assert float(guess.turn.instants[-1]) == pytest.approx(float(start["length"]), rel=1e-3)


def test_stretches_that_follow_a_word():
    names = ("progression", "contact", "no_contact", "contact", "progression")
    words = words_of_names(MOLE, names, autonomous=False)
    found = list(
        guesses_in_motion(MOLE, None, words, period=1, phase=0.0, periods=40, tolerance=1e-12)
    )
    assert found
    for guess in found:
        assert guess.word in words and np.all(guess.turn.durations > 0.0)
    first, last = found[0].turn, found[-1].turn  # the nearly closed ones first
    settled = ns.find_orbit(MOLE)["durations"].values
    assert np.abs(first.durations - settled).max() <= np.abs(last.durations - settled).max() + 1e-9
