"""The estimate of digits that rounding leaves, beside runs with many digits."""

import mpmath
import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, System


def tent():
    """Once a period x becomes 1 - 1.9 |x|, at sin(t) = 0 going down."""
    still = {"x": "0"}
    return System(
        states=["x"],
        period="2*pi",
        initial={"x": 0.3},
        modes={
            "first": Mode(still, exits=[Exit("sin(t)", to="second")]),
            "second": Mode(
                still, exits=[Exit("-sin(t)", to="first", reset={"x": "1 - 1.9*abs(x)"})]
            ),
        },
    )


def test_digits_of_chaos_beside_many_digits():
    """An error grows by 1.9 once a period, so 56 periods spend all digits.

    An estimate knows neither how large each rounding is, up to one in the last digit, nor how they
    add up over 40 periods: a digit and a half.
    """
    times = 2 * np.pi * (np.arange(81) + 0.25)  # between the resets
    run = ns.simulate(tent(), times=times, tangent=[])
    assert run.attrs["certified"] == 1
    x, own = mpmath.mpf(0.3), run["x"].values
    with mpmath.workdps(60):
        true = [x]
        for _ in range(len(own) - 1):
            true.append(1 - mpmath.mpf(1.9) * abs(true[-1]))
        error = np.array([float(abs(mpmath.mpf(a) - b)) for a, b in zip(own, true, strict=False)])
    digits = run["digits"].values
    assert digits[0] == pytest.approx(-np.log10(np.finfo(float).eps), abs=1e-12)
    with np.errstate(divide="ignore"):
        known = np.minimum(-np.log10(error[5:40]), digits[0])
    assert np.all(np.abs(known - digits[5:40]) < 1.5)
    assert np.all(digits[65:] < 1.5)
    assert error[60:].max() > 0.1


def test_digits_of_motion_that_contracts():
    run = ns.simulate(ns.models.soft_impact(omega=0.83), periods=60, tangent=[])
    assert run["digits"].values.min() > 13.0
    # a perturbation turns between the states, whose sizes differ, so a digit at most
    assert run["digits"].values[-1] == pytest.approx(-np.log10(np.finfo(float).eps), abs=1.0)


def test_digits_of_unstable_motion():
    """Of x'' = x errors of both states grow to exp(t) of themselves."""
    free = System(states=["x", "v"], equations={"x": "v", "v": "x"})
    times = np.linspace(0.0, 20.0, 5)
    run = ns.simulate(free, {"x": 1.0, "v": -1.0 + 1e-9}, times=times, tangent=[])
    size = np.abs([run["x"].values, run["v"].values]).max(axis=1)
    grown = np.cosh(times) + np.sinh(times) * max(size[1] / size[0], size[0] / size[1])
    expected = -np.log10(np.finfo(float).eps * grown)
    assert run["digits"].values == pytest.approx(expected, abs=1e-9)


def test_no_digits_are_told_without_derivatives():
    assert "digits" not in ns.simulate(tent(), periods=2)
