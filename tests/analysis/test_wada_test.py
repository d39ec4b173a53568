"""The Wada property where it is known."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import OptionError


def newton(power, side):
    """Basins of Newton's method for roots of one; all share the Julia set as their boundary."""
    across = np.linspace(-1.6, 1.6, side)
    z = across[None, :] + 1j * across[:, None]
    for _ in range(80):
        z = z - (z**power - 1) / (power * z ** (power - 1))
    roots = np.exp(2j * np.pi * np.arange(power) / power)
    return 1 + np.abs(z[..., None] - roots).argmin(axis=-1)


@pytest.mark.parametrize("side", [150, 300, 600])
def test_newtons_basins_are_wada_at_every_resolution(side):
    found = ns.wada_test(newton(3, side))
    assert bool(found["wada"])
    assert float(found["largest_distance"]) <= 5
    assert np.all(found["fraction_within"] == 1)


@pytest.mark.slow
def test_four_basins_need_more_cells():
    """Some petals of the four are so thin that a grid shows one or two of them only."""
    found = ns.wada_test(newton(4, 600), fatten=10)
    assert bool(found["wada"])
    assert float(ns.wada_test(newton(4, 600))["fraction_within"].min()) > 0.999


def test_a_basin_of_its_own_shares_nothing():
    """Label 4 is a square in the corner, so the others' boundary is far from it."""
    labels = newton(3, 300)
    labels[:60, :60] = 4
    found = ns.wada_test(labels)
    assert not bool(found["wada"])
    assert float(found["distance"].sel(label=1, other=4)) > 200
    # without it nothing is left of the square
    assert bool(ns.wada_test(labels, leave_out=(0, -2, 4))["wada"])


@pytest.mark.parametrize("width", [4, 11])
def test_distances_of_stripes(width):
    """The cells at the two boundaries of the middle stripe are as far apart as it is wide."""
    stripes = np.repeat([1, 2, 3], [20, width, 20]) * np.ones((30, 1), int)
    found = ns.wada_test(stripes, fatten=5)
    distance = found["distance"].values
    assert distance.tolist() == [[0, 0, width], [width, 0, width], [width, 0, 0]]
    assert bool(found["wada"]) == (width <= 5)
    assert found["fraction_within"].values[1, 0] == (1 if width <= 5 else 0.5)


def test_three_dimensions():
    stripes = np.repeat([1, 2, 3], 10)[:, None, None] * np.ones((1, 6, 7), int)
    assert float(ns.wada_test(stripes)["largest_distance"]) == 10


@pytest.mark.parametrize(
    ("labels", "options", "message"),
    [
        (np.repeat([1, 2], 10), {}, "there are 2"),
        (np.repeat([1, 2, 0, 3], 10), {}, "label 3 has no boundary"),
        (np.repeat([1, 2, 3], 10), {"fatten": 0}, "fatten"),
    ],
)
def test_wrong_use(labels, options, message):
    with pytest.raises(OptionError, match=message):
        ns.wada_test(labels, **options)
