"""Two ways to the first root of a hump."""

import numpy as np
import pytest

from .humps import T_END, draw_humps, first_root
from .linear import first_crossing


def as_linear_system(case):
    """-g = h . z with z = (line, 1, u0, v0, u1, v1, u2, v2)."""
    matrix = [[0.0] * 8 for _ in range(8)]
    matrix[0][1] = case.d
    start, guard = [case.c, 1.0], [-1.0, 0.0]
    for k, (a, w, p, q) in enumerate(case.parts):
        i = 2 + 2 * k
        matrix[i][i], matrix[i][i + 1], matrix[i + 1][i], matrix[i + 1][i + 1] = a, w, -w, a
        start += [p, q]
        guard += [-1.0, 0.0]
    return matrix, start, guard


@pytest.mark.few(1)
@pytest.mark.parametrize("gaps", [(1e-10, 1e-6), (1e-6, 1e-1)])
def test_first_root_is_that_of_the_linear_route(gaps):
    hits = 0
    for case in draw_humps(5, 12, gaps):
        found, rate = first_root(case)
        matrix, start, guard = as_linear_system(case)
        expected, depth = first_crossing(matrix, start, guard, T_END, digits=40)
        if expected is None:
            assert np.isinf(found)
        else:
            assert abs(found - float(expected)) <= 2 * np.spacing(found)
            assert rate > 0
        if case.gap > 1e-5:  # else rounding of c makes another hump of it
            hits += 1
            assert abs(float(depth) - case.bend * case.gap**2 / 8) < 0.2 * float(depth)
            assert abs(found - (case.top - case.gap / 2)) < 0.2 * case.gap
    assert hits > 2 or gaps[1] < 1e-5
