"""Bernstein rows of exp(z t) against 60 digits: margins of looks by signs rest on them.

A row holds exp(z t) - 1 - z t in Bernstein form of degree 15; places 0 and 1 have the value 1 and
the slope z/15. The truth is its Chebyshev series cut off there, in 60 digits; that of the Taylor
polynomial, which serves up to |z| = 1/2, differs from it by less than rounding.
"""

from functools import cache

import mpmath
import numpy as np
import pytest

from engine.native_shim import motion_rows

UNIT = 2.0**-52
DEGREE, NODES = 15, 48
# the margin allows for 32 units of the size in a row (look_rows.hpp); half of that is spare
MOST_UNITS = 16.0


def motions():
    """Motions of every kind: turning, fading, growing, damped, tiny."""
    rng = np.random.default_rng(5)
    radius = np.concatenate([8.0 * rng.uniform(0.0, 1.0, 40), 10.0 ** rng.uniform(-12, 0, 40)])
    z = radius * np.exp(1j * rng.uniform(-np.pi, np.pi, radius.size))
    z[::5] = 1j * z[::5].imag
    z[1::5] = z[1::5].real
    return np.concatenate([z, [0.0, 8.0j, -8.0j, 8.0, -8.0, 0.5, 0.5j, 2.0j, 1e-200]])


@cache
def bernstein_of_chebyshev(j):
    """Coefficients of T_j(2 t - 1), exact."""
    powers = [[1], [-1, 2]]
    while len(powers) <= j:
        a, b = powers[-1], powers[-2]
        made = [0] * (len(a) + 1)
        for k, v in enumerate(a):
            made[k] -= 2 * v
            made[k + 1] += 4 * v
        for k, v in enumerate(b):
            made[k] -= v
        powers.append(made)
    p = powers[j]
    return [
        sum(mpmath.binomial(i, k) / mpmath.binomial(DEGREE, k) * p[k] for k in range(min(i, j) + 1))
        for i in range(DEGREE + 1)
    ]


def chebyshev_coefficients(z):
    """Of exp(z t) on [0, 1], by the discrete cosine transform."""
    angles = [mpmath.pi * (2 * k + 1) / (2 * NODES) for k in range(NODES)]
    values = [mpmath.exp(z * (1 + mpmath.cos(a)) / 2) for a in angles]
    return [
        (2 if j else 1)
        * sum(v * mpmath.cos(j * a) for v, a in zip(values, angles, strict=True))
        / NODES
        for j in range(2 * DEGREE)
    ]


def reduced(b):
    """Less value and slope at the left end."""
    return [b[i] - b[0] - i * (b[1] - b[0]) for i in range(DEGREE + 1)]


@pytest.mark.slow
def test_rows_have_the_rounding_that_margins_allow_for():
    z = motions()
    rows, sizes, _ = motion_rows(z)
    with mpmath.workdps(60):
        for motion, row, size in zip(z, rows, sizes, strict=True):
            c = chebyshev_coefficients(mpmath.mpc(motion))
            rounding = max(UNIT * size, 1e-50)  # of the 60 digits
            for i in range(2, DEGREE + 1):
                b = sum(c[j] * reduced(bernstein_of_chebyshev(j))[i] for j in range(2, DEGREE + 1))
                found = mpmath.mpc(row[0, i], row[1, i])
                assert abs(found - b) <= MOST_UNITS * rounding, (motion, i)
            assert row[0, 0] == 1.0 and row[1, 0] == 0.0
            assert abs(complex(row[0, 1], row[1, 1]) - motion / DEGREE) <= UNIT * abs(motion)


@pytest.mark.slow
def test_what_rows_leave_out_is_below_its_bound():
    """By values of exp(z t) - 1 - z t beside those of the row, where it is above rounding."""
    z = [motion for motion in motions() if abs(motion) > 3.0]
    rows, sizes, left_out = motion_rows(z)
    with mpmath.workdps(40):
        for motion, row, size, bound in zip(z, rows, sizes, left_out, strict=True):
            for t in [mpmath.mpf(k) / 64 for k in range(1, 65)]:
                weights = [
                    mpmath.binomial(DEGREE, i) * t**i * (1 - t) ** (DEGREE - i)
                    for i in range(DEGREE + 1)
                ]
                exact = mpmath.exp(mpmath.mpc(motion) * t) - 1 - mpmath.mpc(motion) * t
                found = sum(w * mpmath.mpc(*row[:, i]) for i, w in enumerate(weights) if i >= 2)
                allowed = (bound + MOST_UNITS * UNIT * size) * sum(weights[2:])
                assert abs(found - exact) <= allowed, (motion, t)


def test_sizes_follow_the_square_of_small_motions():
    """What lets zeros of order two be told from rounding at short steps."""
    z = 10.0 ** np.arange(-9.0, 0.0) * 1j
    _, sizes, _ = motion_rows(z)
    assert np.all(sizes <= 1.1 * np.abs(z) ** 2)
