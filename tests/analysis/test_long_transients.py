"""Motions that are chaotic for thousands of periods and then settle."""

import re

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, System


def leaking(width: float) -> System:
    """Once a period x becomes 1 - 2 x^2, until it falls into a hole around 0.3; then it rests at 3.

    The density of the chaos is 1/(pi sqrt(1 - x^2)), so a period leaves it with the probability
    0.67 width: of a width of 0.001 motions are chaotic for 1500 periods in the mean. Two of a
    million last for 20000.
    """
    rule = f"where(x > 2, 3 + (x - 3)/2, where(abs(x - 0.3) < {width}, 4 + x, 1 - 2*x**2))"
    still = {"x": "0"}
    return System(
        name="leaking",
        states=["x"],
        parameters={"none": 0.0},
        period="2*pi",
        initial={"x": 0.2},
        modes={
            "first": Mode(still, exits=[Exit("sin(t)", to="second")]),
            "second": Mode(still, exits=[Exit("-sin(t)", to="first", reset={"x": rule})]),
        },
    )


def held_until(system: System) -> int:
    """Periods that the motion stays in the chaos, from its strobes."""
    points = ns.stroboscopic_map(system, record=10000, phase=0.25)
    return int(np.argmax(points["x"].values > 2))


def test_the_example_leaves_late():
    """Later than the windows of a regime and the record of exponents, and before 10000 periods."""
    assert 1700 < held_until(leaking(1e-3)) < 9000


def test_a_regime_runs_on():
    trusting = ns.regime(leaking(1e-3), phase=0.25, confirm=0)
    assert trusting["regime"].item() == "chaotic"
    found = ns.regime(leaking(1e-3), phase=0.25)
    assert (found["regime"].item(), found["period"].item()) == ("periodic", 1)
    assert found["multiplier_modulus"].values == pytest.approx([0.5], abs=1e-12)
    assert found["transient_used"].item() > held_until(leaking(1e-3))


def test_a_regime_that_stays_says_for_how_long():
    found = ns.regime(leaking(0.0), phase=0.25, confirm=3000)
    assert found["regime"].item() == "chaotic"
    # two windows of evidence, `confirm`, and again two windows of 100, a turn of 100, and the first
    # window of evidence: those of 500 are chaotic
    seen = 2 * 500 + 3000 + 2 * 100 + 100 + 500
    assert found["chaotic_for"].item() == seen
    assert f"chaotic for at least {seen} periods" in found.attrs["message"]


def test_a_map_runs_on():
    plane = {"none": [0.0, 1.0], "other": [0.0, 1.0]}
    system = leaking(1e-3)
    both = System(
        name="leaking", states=["x"], parameters={"none": 0.0, "other": 0.0}, period="2*pi",
        initial={"x": 0.2}, modes=dict(system.modes),
    )  # fmt: skip
    for confirm, label in ((0, "chaotic"), (10_000, "periodic")):
        found = ns.regime_map(both, plane, phase=0.25, confirm=confirm)
        names = found["regime"].attrs["flag_meanings"].split()
        assert {names[code] for code in found["regime"].values.ravel()} == {label}


def test_a_cracked_beam_that_settles_late():
    """Its strobes repeat after two periods, but only after 1900 periods of chaos."""
    beam = ns.models.breathing_crack(crack=14.8)
    start = {"u": 0.2739233746429086, "v": -0.4604265724722594}
    assert ns.regime(beam, start, confirm=0)["regime"].item() == "chaotic"
    found = ns.regime(beam, start)
    assert (found["regime"].item(), found["period"].item()) == ("periodic", 2)
    with pytest.warns(ns.ResultWarning, match="repeats with period 2"):
        spectrum = ns.lyapunov_spectrum(beam, start)
    assert spectrum.attrs["settled"] == 0
    assert "repeats with period 2" in spectrum.attrs["message"]


def test_exponents_of_a_transient_say_so():
    with pytest.warns(
        ns.ResultWarning, match="leaking.* exponents of a transient, .*; raise transient="
    ):
        found = ns.lyapunov_spectrum(leaking(1e-3))
    assert found.attrs["status"] == "completed"
    assert found.attrs["settled"] == 0
    assert "repeats with period 1" in found.attrs["message"]
    late = ns.lyapunov_spectrum(leaking(1e-3), transient=9000)
    assert (late.attrs["settled"], late.attrs["message"]) == (1, "completed")
    assert float(late["lyapunov_exponent"][0]) == pytest.approx(-np.log(2) / (2 * np.pi), abs=1e-12)
    assert late.attrs["chaotic_for"] == 0 and np.isnan(late.attrs["escape_rate_below"])
    stays = ns.lyapunov_spectrum(leaking(0.0))
    assert stays.attrs["settled"] == 1
    # the record, `confirm` with 200 strobes to look for a period, and a quarter of half a record
    seen = 1000 + 10_000 + 200 + 125
    assert stays.attrs["chaotic_for"] == pytest.approx(seen, rel=1e-12)
    assert f"chaotic for at least {seen} periods" in stays.attrs["message"]


def test_halves_of_a_record_that_differ():
    """The motion leaves the chaos amid the record: ln 2 per period before, minus ln 2 behind."""
    until = held_until(leaking(1e-3))
    with pytest.warns(ns.ResultWarning, match="had not settled"):
        found = ns.lyapunov_spectrum(leaking(1e-3), transient=until - 500, record=1000, confirm=0)
    assert found.attrs["settled"] == 0
    told = re.search(
        r"is (\S+) in the first half .* and (\S+) in the second", found.attrs["message"]
    )
    assert told is not None
    # ln |4 x| scatters by pi/sqrt(12) about its mean, over 500 periods
    scatter = 3 * np.pi / np.sqrt(12 * 500) / (2 * np.pi)
    assert float(told[1]) == pytest.approx(np.log(2) / (2 * np.pi), abs=scatter)
    assert float(told[2]) == pytest.approx(-np.log(2) / (2 * np.pi), abs=5e-4)  # digits of a text


@pytest.mark.parametrize("chaotic", [60, 120, 250])
def test_a_half_in_which_the_chaos_ends_differs_too(chaotic):
    """Its own error is large, since rates of both kinds are in it."""
    until = held_until(leaking(1e-3))
    with pytest.warns(ns.ResultWarning, match="had not settled"):
        found = ns.lyapunov_spectrum(
            leaking(1e-3), transient=until - chaotic, record=1000, confirm=0
        )
    assert found.attrs["settled"] == 0


def test_a_diagram_counts_motions_without_a_period():
    found = ns.bifurcation_diagram(leaking(1e-3), "none", [0.0, 1.0], record=20)
    assert found["period"].values.tolist() == [[0], [0]]
    assert found.attrs["message"].startswith(
        "completed; 2 of 2 motions have not settled to a period of at most 10 within 220 periods"
    )
    late = ns.bifurcation_diagram(leaking(1e-3), "none", [0.0, 1.0], transient=9000, record=20)
    assert late.attrs["message"] == "completed"
