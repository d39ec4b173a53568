"""Steps that would land on another branch are refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nonsmooth.continuation import follow


@pytest.mark.slow
@given(st.floats(1e-3, 0.5), st.floats(0.5, 4), st.floats(0.05, 1.0), st.booleans())
def test_parallel_branches(gap, waves, step, above):
    """Two waves side by side; big steps predict the wrong one."""

    def two(u, p):
        x, slope = u - np.sin(waves * p), waves * np.cos(waves * p)
        return x * (x - gap), 2 * x - gap, -slope * (2 * x - gap)

    start = gap if above else 0.0
    branch = follow(
        two, start, 0.0, bounds=(0, 6), parameter_scale=1.0, step=step, largest_step=1.0
    )
    for point in branch:
        assert point.u[0] - np.sin(waves * point.p) == pytest.approx(start, abs=1e-9)
        assert point.special != "branch_point"


def follow_first_of_three(gap, waves, **steps):
    """Distance of the points from the first of three parallel waves."""

    def three(u, p):
        x = u - np.sin(waves * p)
        factors = x - gap * np.arange(3)
        by_x = factors[[1, 2]].prod() + factors[[0, 2]].prod() + factors[[0, 1]].prod()
        return factors.prod(), by_x, -waves * np.cos(waves * p) * by_x

    branch = follow(three, 0.0, 0.0, bounds=(0, 6), parameter_scale=1.0, **steps)
    return max(abs(point.u[0] - np.sin(waves * point.p)) for point in branch)


@pytest.mark.slow
@given(st.floats(0.01, 0.3), st.floats(1, 4), st.floats(0.01, 0.2))
def test_next_but_one_of_three_branches(gap, waves, step):
    """It has the orientation of the first, so only the shape of the step tells."""
    assert follow_first_of_three(gap, waves, step=step) < 1e-8


@pytest.mark.parametrize(
    ("gap", "waves", "step"), [(0.042, 1.768, 0.95), (0.078, 1.561, 0.731), (0.059, 1.98, 0.974)]
)
def test_jumps_that_do_not_turn(gap, waves, step):
    """Steps whose tangents agree and whose chord does not."""
    assert follow_first_of_three(gap, waves, step=step, largest_step=1.0) < 1e-8


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9])
def test_imperfect_pitchfork(gap):
    """Two branches that nearly touch: the one from the left turns up, whatever the gap."""

    def imperfect(u, p):
        return p * u - u**3 + gap, p - 3 * u**2, u

    branch = follow(imperfect, gap, -1.0, bounds=(-1, 1))
    points = list(branch)
    assert branch.ended == "bound" and not any(p.special == "branch_point" for p in points)
    assert points[-1].p == 1.0
    assert points[-1].u[0] == pytest.approx(np.roots([-1, 0, 1, gap]).real.max(), abs=1e-12)


def test_other_sheet_of_a_closed_curve_is_not_its_start():
    """A spiral that comes near its start goes on."""

    def spiral(u, p):
        """Radius 1 + angle/1000 in the plane of u[0] and p; u[1] is the angle."""
        return np.array(
            [u[0] - (1 + u[1] / 1000) * np.cos(u[1]), p - (1 + u[1] / 1000) * np.sin(u[1])]
        )

    branch = follow(spiral, [1.0, 0.0], 0.0, steps=300, scale=[1.0, 100.0])
    assert branch.ended == "" and [point.u[1] for point in branch][-1] > 10
    assert branch.ended == "steps"
