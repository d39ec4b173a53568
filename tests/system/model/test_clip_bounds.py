"""Bounds of ``clip`` that parameters give are looked at with their values, one or many at once."""

import warnings

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.system.model.value_checks import sure_values

BOUNDS = [
    ("f", "g", r"equations\['v'\]: clip from f = 1 to g = -1 for the parameters given"),
    ("2*f", "f", r"clip from 2\*f = 2 to f = 1 for"),
    ("most", "f", r"clip from 3\*f = 3 to f = 1 for"),
    ("2", "f", "clip from 2 to f = 1 for the parameters given; the lower bound stands first"),
]


def slider(low, high, **values):
    return ns.System(
        states=["x", "v"],
        parameters={"f": 1.0, "g": -1.0} | values,
        definitions={"most": "3*f"},
        equations={"x": "v", "v": f"-clip(x, {low}, {high})"},
    )


@pytest.mark.parametrize(("low", "high", "words"), BOUNDS)
def test_a_lower_bound_above_the_upper_one_is_refused(low, high, words):
    with pytest.raises(ns.ModelError, match=words):
        slider(low, high)


@pytest.mark.parametrize(("low", "high"), [("g", "f"), ("-f", "f"), ("f", "f"), ("v - 1", "v")])
def test_bounds_in_order_are_taken(low, high):
    slider(low, high)


def test_other_values_are_looked_at_too():
    system = slider("-f", "f")
    with pytest.raises(ns.ModelError, match="clip from -f = 2 to f = -2"):
        system.with_parameters(f=-2.0)
    sure = sure_values(system, {"f": np.array([-1.0, 0.0, 1.0])})
    assert sure.tolist() == [False, True, True]


def test_outputs_and_resets_are_looked_at():
    where = {"outputs": r"outputs\['y'\]", "reset": r"exits\[0\].reset\['v'\]"}
    for place, words in where.items():
        text = "clip(v, f, -f)"
        reset = {"v": text if place == "reset" else "-v"}
        with pytest.raises(ns.ModelError, match=words), warnings.catch_warnings():
            warnings.simplefilter("error")
            ns.System(
                states=["x", "v"],
                parameters={"f": 1.0},
                outputs={"y": text} if place == "outputs" else {},
                modes={"m": ns.Mode({"x": "v", "v": "-x"}, exits=[ns.Exit("1 - x", reset=reset)])},
            )
