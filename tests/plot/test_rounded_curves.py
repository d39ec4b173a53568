"""Curves between the points of a branch, against circles and parabolas that the points lie on."""

import numpy as np
import pytest

from nonsmooth.plot.rounded_curves import rounded


def test_points_on_a_circle_give_a_circle():
    angle = np.linspace(0.0, 1.5 * np.pi, 13)
    none, ways = np.zeros(13, bool), np.zeros(12, bool)
    x, y, point = rounded(np.cos(angle), np.sin(angle), none, ways)
    assert point.tolist() == [*np.repeat(np.arange(12), 8), 12]
    off = np.abs(np.hypot(x, y) - 1.0)
    inner = slice(8, -8)  # the ends have a neighbour on one side only
    # a chord of pi/8 is off by 1 - cos(pi/16) = 0.019, a cubic by the fourth power of the angle
    assert off[inner].max() < 1e-3 and off.max() < 5e-3
    assert np.all(x[::8] == np.cos(angle)) and np.all(y[::8] == np.sin(angle))


def test_corners_and_gaps_stay():
    x, y = np.array([0.0, 1.0, 2.0, 3.0, 4.0]), np.array([0.0, 0.2, 0.4, 0.2, 0.0])
    corner, apart = np.array([False, False, True, False, False]), np.zeros(4, bool)
    _, through, point = rounded(x, np.abs(y) ** 2, corner, apart)
    assert point.size > 5 and through[point == 2][0] == through.max() == 0.4**2
    straight = rounded(x, y**2, ~corner | corner, ~apart)
    assert straight[0].tolist() == x.tolist() and straight[1].tolist() == (y**2).tolist()


def test_a_straight_line_needs_no_more_points():
    x = np.linspace(0.0, 1.0, 5)
    assert rounded(x, 2.0 * x, np.zeros(5, bool), np.zeros(4, bool))[0].tolist() == x.tolist()


def test_units_do_not_matter():
    x = np.linspace(-1.0, 1.0, 9)
    none, ways = np.zeros(9, bool), np.zeros(8, bool)
    one, other = rounded(x, x**2, none, ways), rounded(1e3 * x, 1e-6 * x**2, none, ways)
    assert other[0] == pytest.approx(1e3 * one[0]) and other[1] == pytest.approx(1e-6 * one[1])
    inner = slice(8, -8)  # the chord is off by 1/64
    assert np.abs(one[1] - one[0] ** 2)[inner].max() < 0.5 / 64


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_curve_turns_back_only_where_its_points_do(sense):
    """Beside a steep way, long flat ones: the picture showed two folds that are none."""
    x = sense * np.array([0.0, 0.4, 0.6, 0.62, 0.8, 1.2])
    y = np.array([0.0, 0.02, 0.05, 0.4, 0.46, 0.5])
    nowhere = np.zeros(x.size, bool)
    across, up, _ = rounded(x, y, nowhere, nowhere[:-1])
    assert across.size > x.size
    assert np.all(sense * np.diff(across) > 0.0)
    assert up.min() > -0.01 and up.max() < 0.51


def test_a_curve_turns_back_at_a_fold():
    y = np.linspace(-1.0, 1.0, 16)
    nowhere = np.zeros(y.size, bool)
    across, up, _ = rounded(1.0 - y**2, y, nowhere, nowhere[:-1])
    inner = np.abs(up) < 0.5
    chord = (2.0 / 15.0) ** 2 / 4.0  # by which it is off in its middle
    assert np.abs(across - (1.0 - up**2))[inner].max() < 0.25 * chord
    assert across.max() > 1.0 - 0.25 * chord
