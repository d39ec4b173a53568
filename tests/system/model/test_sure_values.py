"""Values of a parameter that are checked all at once, against the check of one system."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.errors import ModelError
from nonsmooth.system.model.value_checks import rests_alike, sure_values

VALUES = np.array([-3.0, -1.0, -0.5, 0.0, 1e-9, 0.3, 0.85, 1.0, 2.0, 7.0, 1e200, -1e200])


def forced(**words):
    return ns.System(
        states=["x", "v"],
        parameters={"a": 1.0, "w": 1.0, "k": 4.0},
        period="2*pi/w",
        equations={"x": "v", "v": "-k*x - 0.1*v + a*cos(w*t)"},
        **words,
    )


def held():
    return ns.System(
        states=["x", "v"],
        parameters={"v_b": 0.3, "F_k": 0.4, "F_s": 0.6},
        equations={"x": "v", "v": "-x - F_k*sign(slip)"},
        surfaces={"slip": ns.Surface("v - v_b", hold="F_s/F_k")},
    )


def taken(system, name, value):
    try:
        system.with_parameters(**{name: value})
    except ModelError:
        return False
    return True


@pytest.mark.parametrize(
    ("system", "name"),
    [
        (ns.models.soft_impact(), "omega"),
        (ns.models.soft_impact(), "beta"),
        (ns.models.moling(), "xi"),
        (ns.models.moling(), "g"),
        (ns.models.duffing(), "omega"),
        (forced(require={"a < k": "weak", "1/a > 0": "not zero"}), "a"),
        (forced(initial={"x": "1/k"}), "k"),
        (held(), "F_s"),
        (forced(drift={}, definitions={"unused": "1/a"}), "a"),
    ],
)
def test_the_check_of_all_agrees_with_the_check_of_one(system, name):
    found = sure_values(system, {name: VALUES})
    expected = [taken(system, name, float(value)) for value in VALUES]
    assert found.tolist() == expected
    assert True in expected


def test_a_rest_state_that_depends_on_the_parameter():
    system = forced(initial={"x": "1/k"})
    assert not rests_alike(system, ["a", "k"])
    assert rests_alike(system, ["a"])
