"""Parameters that follow others change nothing but how they are named."""

import numpy as np
import pytest

import nonsmooth as ns

TIES = {"delta_x": "delta", "delta_y": "delta/2"}


def tied():
    return ns.tie_parameters(ns.models.rotor(), TIES, delta=0.1)


@pytest.mark.slow
def test_the_same_motion():
    run = ns.simulate(tied().with_parameters(delta=0.06), periods=60)
    wanted = ns.simulate(ns.models.rotor(delta_x=0.06, delta_y=0.03), periods=60)
    for name in ("x", "y", "force", "mode"):
        np.testing.assert_array_equal(run[name], wanted[name])


@pytest.mark.slow
def test_the_same_diagram():
    values = np.array([0.0, 0.04, 0.1])
    found = ns.bifurcation_diagram(tied(), "delta", values, transient=50, record=20)
    for k, delta in enumerate(values):
        wanted = ns.bifurcation_diagram(
            ns.models.rotor(delta_x=delta, delta_y=delta / 2), "eta", [2.442],
            transient=50, record=20,
        )  # fmt: skip
        np.testing.assert_array_equal(found["x"][k], wanted["x"][0])


@pytest.mark.slow
def test_requirements_hold_for_what_is_tied():
    with pytest.raises(ns.ModelError, match="negative preload"):
        tied().with_parameters(delta=-0.1)


def test_it_round_trips():
    assert ns.System.from_toml(tied().to_toml()) == tied()


def test_a_map_over_both():
    grid = ns.regime_map(
        tied(), {"eta": [2.1, 3.0], "delta": [0.05, 0.1]}, transient=60, record=20, evidence=200
    )
    assert grid["period"].values.tolist() == [[1, 2], [1, 2]]


@pytest.mark.parametrize(
    ("ties", "values", "text"),
    [
        ({}, {}, "give a mapping"),
        ({"delta": "delta_x"}, {}, "ties: unknown parameter 'delta'"),
        ({"delta_x": "delta_y"}, {"eta": 2.0}, "with_parameters"),
    ],
)
def test_wrong_options(ties, values, text):
    with pytest.raises(ns.OptionError, match=text):
        ns.tie_parameters(ns.models.rotor(), ties, **values)


def test_wrong_expressions():
    with pytest.raises(ns.ModelError, match="delta"):
        ns.tie_parameters(ns.models.rotor(), {"delta_x": "delta"})
