"""Bad input is an error that names it and says what to do."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.continuation import branch_directions, follow, two_parameter


def line(u, p):
    return u - p


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"step": 0.0}, "step = 0 must be positive"),
        ({"step": 1.0}, "largest_step = 0.2: each must be at most the next"),
        ({"largest_step": math.nan}, "largest_step = nan is not a finite number"),
        ({"bounds": (1, 0)}, r"bounds = \(1, 0\): the first must be below"),
        ({"bounds": (1, 2)}, "start 0 is outside of bounds"),
        ({"bounds": 3}, "two numbers"),
        ({"bounds": (math.nan, 2)}, "the first must be below"),
        ({"steps": 2.5}, "steps = 2.5: a whole number"),
        ({"steps": -1}, "steps = -1: a whole number, 0 or more"),
        ({"max_newton": 1}, "max_newton = 1: a whole number, 2 or more"),
        ({"tolerance": 1.0}, "tolerance = 1: from 1e-15"),
        ({"tests": 3}, "tests = 3 is no function"),
        ({"accept": 3}, "accept = 3 is no function"),
        ({"tests": lambda point: 3}, "mapping of names to numbers"),
        ({"tests": lambda point: {"fold": 1.0}}, "'fold'; names are texts"),
        ({"tests": lambda point: {"x": point.u}, "u": [0.0, 0.0]}, "one real number"),
        ({"direction": 2}, "direction = 2: 1 for a parameter that grows"),
        ({"direction": ([1.0, 2.0], 0.0)}, "with 1 numbers and one"),
        ({"direction": ([0.0], 0.0)}, "no finite length above zero"),
        ({"scale": -1.0}, "scale = -1.0: one positive number"),
        ({"scale": [1.0, 1.0]}, "one for each of the 1 unknowns"),
        ({"parameter_scale": 0.0}, "parameter_scale = 0 must be positive"),
        ({"u": "one"}, "u = 'one' must be real numbers"),
        ({"u": [[1.0], [2.0]]}, r"shape \(2, 1\); give the unknowns in one row"),
        ({"u": [0.0, math.nan]}, r"u\[1\] = nan is not finite"),
        ({"u": 1j}, "must be real numbers"),
        ({"p": math.inf}, "p = inf is not a finite number"),
        ({"p": "a"}, "p = 'a' is not a finite number"),
    ],
)
def test_options(options, message):
    given = {"u": 0.0, "p": 0.0} | options
    with pytest.raises(ns.OptionError, match=message):
        list(follow(line, given.pop("u"), given.pop("p"), **given))


@pytest.mark.parametrize(
    ("residual", "message"),
    [
        (3, "residual = 3 is no function"),
        (lambda u, p: [0.0, 0.0], r"shape \(2,\) where u has 1"),
        (lambda u, p: "zero", "not real numbers"),
        (lambda u, p: None, "not real numbers"),
        (lambda u, p: u + 1j, "not real numbers"),
        (lambda u, p: (u, [1.0, 2.0], 1.0), "derivative J_u has the shape"),
        (lambda u, p: (u, 1.0, [1.0, 2.0]), "derivative J_p has the shape"),
    ],
)
def test_residuals(residual, message):
    with pytest.raises(ns.OptionError, match=message):
        follow(residual, 0.0, 0.0)


def test_starts_that_lead_nowhere():
    with pytest.raises(ns.RunError, match="better u") as caught:
        follow(lambda u, p: u**2 + 1 + p**2, 3.0, 0.0)
    assert caught.value.status == "no_convergence"
    with pytest.raises(ns.RunError, match="start inside its domain") as caught:
        follow(lambda u, p: np.log(u), -1.0, 0.0)
    assert caught.value.status == "domain"


def test_of_the_others():
    with pytest.raises(ns.OptionError, match="residual = 3 is no function"):
        branch_directions(3, 0.0, 0.0)
    with pytest.raises(ns.OptionError, match="or the word 'fold'"):
        two_parameter(lambda u, p, q: u, "flip", 0.0, 0.0, 0.0)
    with pytest.raises(ns.OptionError, match="q = nan"):
        two_parameter(lambda u, p, q: u, "fold", 0.0, 0.0, math.nan)
    with pytest.raises(ns.OptionError, match="the test returned 2 values"):
        two_parameter(lambda u, p, q: (u - p, 1.0, -1.0), lambda u, p, q: (1.0, 2.0), 0.0, 0.0, 0.0)
    with pytest.raises(ns.OptionError, match="start 0 is outside of bounds"):
        two_parameter(lambda u, p, q: u - p, "fold", 0.0, 0.0, 0.0, bounds=(1, 2))
