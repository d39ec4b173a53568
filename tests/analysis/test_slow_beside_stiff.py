"""Motions that are slow beside the unit of time of their system, and motions that never return.

A unit of time says nothing of a motion: a stiff cell that is never visited may have set it.
"""

import math

import numpy as np
import pytest

import nonsmooth as ns
from periodic_orbits.belts import cycle_of_belt, stiff_stop, stribeck

PART_OF_WAY = "does not come back in the record"


def thermostat(tau):
    """Heats and cools between 0.4 and 0.6; nothing oscillates, so the unit is 64."""
    return ns.System(
        name="thermostat",
        states=["T"],
        parameters={"tau": tau},
        modes={
            "off": ns.Mode({"T": "-T/tau"}, exits=[ns.Exit("T - 0.4", to="on")]),
            "on": ns.Mode({"T": "(1 - T)/tau"}, exits=[ns.Exit("0.6 - T", to="off")]),
        },
    )


@pytest.mark.parametrize("v_b", [0.6, 0.8, 2.0])
def test_the_cycle_on_a_fast_belt(v_b):
    """Six widths of the law and more from rest, where the unit was below a hundredth."""
    orbit = ns.find_orbit(stribeck(v_b), {"x": 0.6, "v": v_b})
    assert orbit.attrs["status"] == "completed"
    assert float(orbit["length"]) == pytest.approx(cycle_of_belt(v_b), rel=1e-9)


def test_a_branch_to_a_fast_belt():
    branch = ns.continue_orbit(stribeck(0.5), "v_b", (0.4, 2.0), direction="up")
    assert branch.attrs["end_last"] == "bound"
    assert float(branch["v_b"][-1]) == 2.0
    assert float(branch["length"][-1]) == pytest.approx(cycle_of_belt(2.0), rel=1e-9)


def test_a_section_and_a_diagram_of_a_fast_belt():
    system = stribeck(1.2)
    start = {"x": 0.6, "v": 1.2}
    points = ns.poincare_section(system, start, section="stick", record=5)
    assert points.attrs["status"] == "completed"
    np.testing.assert_allclose(np.diff(points["time"]), cycle_of_belt(1.2), rtol=1e-9)
    diagram = ns.bifurcation_diagram(
        ns.PoincareMap(system, "v", direction=1), "v_b", [1.2], initial=start, transient=5, record=5
    )
    assert diagram["period"].values.ravel().tolist() == [1]


@pytest.mark.parametrize("v_b", [0.3, 0.5, 0.7])
def test_a_rest_is_no_cycle_though_the_guess_begins_at_zero(v_b):
    """No cycle stays off the belt: the divergence, the slope of the law, has one sign there.

    From zero the motion turns round the rest state x = F_k + (F_s - F_k) exp(-v_b/v_s), v = 0.
    """
    orbit = ns.find_orbit(stribeck(v_b), {"x": 0.0})
    length = float(orbit["length"])
    assert math.isnan(length) or length == pytest.approx(cycle_of_belt(v_b), rel=1e-9)


@pytest.mark.parametrize("k", [1e4, 1e6, 1e8])
def test_a_cycle_far_from_a_stiff_stop(k):
    orbit = ns.find_orbit(stiff_stop(k), {"x": 0.0})
    assert orbit.attrs["status"] == "completed"
    # Newton's method ends at a residual of 1e-9, and the family leaves the time as undecided
    assert float(orbit["length"]) == pytest.approx(2 * math.pi, rel=1e-7)


def test_a_cycle_much_slower_than_any_unit():
    orbit = ns.find_orbit(thermostat(1e5), {"T": 0.5}, mode="on")
    assert float(orbit["length"]) == pytest.approx(2e5 * math.log(1.5), rel=1e-9)


def test_default_lengths_on_a_fast_belt():
    """The exponents of stick and slip: zero along the motion, and what stick wipes out."""
    spectrum = ns.lyapunov_spectrum(stribeck(0.6), {"x": 0.6, "v": 0.6})
    first, second = spectrum["lyapunov_exponent"].values
    assert abs(first) < 3e-4 and second == -math.inf
    assert spectrum.attrs["settled"] == 1
    assert 100 < spectrum.attrs["n_events"] / 2 < 2000  # cycles in the record
    assert 0.5 < spectrum.attrs["record"] / (1000 * cycle_of_belt(0.6)) < 2.0


@pytest.mark.parametrize("k", [1e6, 1e8])
def test_default_lengths_far_from_a_stiff_stop(k):
    spectrum = ns.lyapunov_spectrum(stiff_stop(k), {"x": 0.0}, transient=0)
    assert 0.5 < spectrum.attrs["record"] / (2000 * math.pi) < 2.0
    np.testing.assert_allclose(spectrum["lyapunov_exponent"], 0.0, atol=1e-9)
    assert spectrum.attrs["settled"] == 1


def test_a_record_in_which_nothing_returns_is_none_of_the_motion():
    with pytest.warns(ns.ResultWarning, match=PART_OF_WAY):
        spectrum = ns.lyapunov_spectrum(
            stribeck(0.6), {"x": 0.6, "v": 0.6}, transient=0.00076, record=0.0038
        )
    assert spectrum.attrs["settled"] == 0 and PART_OF_WAY in spectrum.attrs["message"]


@pytest.mark.parametrize("record", [3.0, 6.0])
def test_half_a_turn_is_no_return(record):
    circle = ns.System(states=["x", "v"], equations={"x": "v", "v": "-x"})
    with pytest.warns(ns.ResultWarning, match=PART_OF_WAY):
        ns.lyapunov_spectrum(circle, {"x": 1.0}, transient=0, record=record)


@pytest.mark.parametrize("start", [0.0, 1.0])
def test_a_motion_that_rests_or_dies_out_has_settled(start):
    damped = ns.System(states=["x", "v"], equations={"x": "v", "v": "-x - 3*v"})
    spectrum = ns.lyapunov_spectrum(damped, {"x": start}, transient=0, record=20)
    assert spectrum.attrs["settled"] == 1
    assert float(spectrum["exponent_sum"]) == pytest.approx(-3.0, abs=1e-9)


def test_a_state_that_only_grows_does_not_return():
    """Up through its mean once; its angle goes round, and is seen by whole turns where declared."""
    turning = {"states": ["q", "w"], "equations": {"q": "w", "w": "0.3 - 0.1*w + 0.1*sin(q)"}}
    spectrum = ns.lyapunov_spectrum(ns.System(**turning, drift={"q": "2*pi"}), {"w": 1.0})
    assert spectrum.attrs["settled"] == 1


def test_returns_that_differ_by_rounding_count_once():
    """From rest the first catch is none of the cycle, and all later ones are as far from it.

    The length is scipy's: DOP853 with events at rtol 1e-12, in micrometres and tenths of a
    millisecond.
    """
    slider = ns.System(
        name="slider",
        states=["x", "v"],
        parameters={"v_b": 1.5e-3},
        surfaces={"s": ns.Surface("v - v_b", below="lag", on="stick", above="lead")},
        equations={
            "x": "v",
            "v": "(-0.8*x - 2e-6*v - 4e-6*sign(s)*(0.25 + 0.2*exp(-abs(s)/3e-3)))/2e-9",
        },
    )
    orbit = ns.find_orbit(slider, {"x": 0.0, "v": 0.0})
    assert int(orbit["primitive_parts"]) == 1
    assert float(orbit["length"]) == pytest.approx(1.4713668121609708e-3, rel=1e-9)
