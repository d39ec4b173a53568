"""Labels of columns and the windows that they make."""

import numpy as np
import pytest

import nonsmooth as ns
from neighbours import neighbour_exponent
from nonsmooth_chapter.judgement import agreed
from nonsmooth_chapter.mole.branch_claims import distinct_attractors
from nonsmooth_chapter.mole.sweeps import (
    CHAOTIC,
    PROTOCOLS,
    UNSETTLED,
    Sweep,
    at_the_end,
    even_forces,
    first_fifty,
    force_sweep,
    order_of_labels,
    settled_regime,
    stretches,
    widest,
)


def labelled(*labels):
    count = len(labels)
    return Sweep(np.arange(1.0, count + 1), np.array(labels), np.zeros(count), np.zeros(count))


def test_columns_that_have_not_settled_do_not_split_a_window():
    parts = stretches(labelled(0, 0, 4, UNSETTLED, 2, 1, 0, 3, 0))
    assert [(part["low"], part["high"], part["periods"]) for part in parts] == [
        (1.0, 2.0, []), (3.0, 6.0, [1, 2, 4]), (7.0, 7.0, []), (8.0, 8.0, [3]), (9.0, 9.0, []),
    ]  # fmt: skip
    assert widest(parts)["low"] == 3.0


def test_columns_that_have_not_settled_make_no_window_by_themselves():
    assert len(stretches(labelled(0, UNSETTLED, UNSETTLED, 0))) == 1


def test_order_tells_every_stretch_once():
    assert order_of_labels(labelled(4, 4, UNSETTLED, 2, 2, 1, 0, 0, 2)) == [4, 2, 1, 0, 2]


@pytest.mark.parametrize(
    ("b", "step", "at_end"),
    [(0.1, 0.01, True), (0.0981, 1e-4, True), (0.0979, 1e-4, False), (0.0979, 0.005, True)],
)
def test_end_of_a_window_is_two_percent_or_a_step_wide(b, step, at_end):
    assert at_the_end(b, {"high": 0.1}, step) == at_end


def test_protocols_that_disagree_decide_nothing():
    assert agreed([True, True, True]) is True
    assert agreed([False, False]) is False
    assert agreed([True, False]) is None


def test_forces_end_at_the_limit():
    forces = even_forces(0.3, 3)
    assert forces == pytest.approx((0.1, 0.2, 0.3), rel=1e-12)
    assert forces[-1] == 0.3


def test_labels_agree_with_neighbouring_runs():
    """Periods and chaos of Fig. 7, by runs that start a small distance apart."""
    forces = (0.05, 0.095, 0.1, 0.15)
    sweep = force_sweep(0.3, forces)
    for b, label, exponent, gain in zip(
        forces, sweep.labels, sweep.exponents, sweep.per_period, strict=True
    ):
        found = settled_regime(ns.models.moling(b=b))
        assert label == found["period"]
        if label == CHAOTIC:
            # both are averages over 60 to 150 periods of one chaotic motion
            expected, error = neighbour_exponent(ns.models.moling(b=b), 600, 400)
            assert exponent == pytest.approx(expected, abs=5 * error)
        else:
            assert np.isnan(exponent)
            assert gain == pytest.approx(found["per_period"], rel=1e-8)


def test_followed_sweeps_keep_a_motion_that_rest_does_not_reach():
    """Beyond the end of the window for a = 0.1 a motion of period one is left, seen upwards."""
    forces = (0.060, 0.062, 0.064, 0.066)
    found = {start: force_sweep(0.1, forces, start).labels[-1] for start in PROTOCOLS}
    assert found["follow up"] == 1
    assert found["restart"] == found["follow down"] == CHAOTIC


def test_progression_of_the_first_periods_is_that_of_one_run():
    run = ns.simulate(ns.models.moling(a=0.3, b=0.1), periods=50, samples_per_period=1)
    assert first_fifty(0.3, (0.1,))[0] == pytest.approx(float(run["v"][-1]), rel=1e-12)


def test_attractors_are_told_apart_by_their_points():
    starts = [{"p": -1.0}, {"p": -0.5, "y": 0.5}, {"p": -2.0, "y": -1.0}]
    same = ns.bifurcation_diagram(
        ns.models.moling(), "b", [0.1], initial=starts, transient=300, record=40
    )
    assert distinct_attractors(same) == [{"period": 2, "starts": 3}]
    other = same.copy(deep=True)
    other["y"][0, 0] += 1.0
    assert [each["starts"] for each in distinct_attractors(other)] == [2, 1]
