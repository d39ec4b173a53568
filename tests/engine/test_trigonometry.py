"""Sine and cosine of the engine against mpmath: below one unit in the last place of 1."""

import mpmath
import numpy as np

from engine.native_shim import turn


def test_error_below_one_unit_in_the_last_place():
    rng = np.random.default_rng(3)
    arguments = np.concatenate(
        [
            rng.uniform(-10, 10, 300),
            rng.uniform(-1e6, 1e6, 300),
            np.arange(-40, 40) * (np.pi / 4),
            [0.0, 1e-300, 5e6, -3e9],
        ]
    )
    worst = 0.0
    with mpmath.workdps(40):
        for x, found in zip(arguments, turn(arguments), strict=True):
            exact = mpmath.mpf(float(x))
            errors = mpmath.cos(exact) - found.real, mpmath.sin(exact) - found.imag
            worst = max(worst, *(abs(float(error)) for error in errors))
    assert worst < 2.0**-52
