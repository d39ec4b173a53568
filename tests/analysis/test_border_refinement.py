"""Grids that are refined where labels differ, beside grids that are computed as a whole."""

import numpy as np
import pytest

from nonsmooth.analysis.regimes.border_refinement import UNKNOWN, refine_borders, refined_values


def refined(label, shape, levels):
    """Keys of a label given as a function of both places, and how many were computed."""
    size = tuple((n - 1) * 2**levels + 1 for n in shape)
    keys = np.full(size, UNKNOWN, np.int64)
    asked = []

    def compute(places):
        asked.extend(map(tuple, places))
        for i, j in places:
            keys[i, j] = label(i / size[0], j / size[1])
        return True

    filled = refine_borders(keys, levels, compute)
    whole = np.array([[label(i / size[0], j / size[1]) for j in range(size[1])]
                      for i in range(size[0])])  # fmt: skip
    return keys, whole, asked, filled


def disc(x, y):
    return 1 + ((x - 0.47) ** 2 + (y - 0.52) ** 2 < 0.09)


def stripes(x, y):
    return 1 + (x + 0.6 * y > 0.71) + 2 * (x - y > 0.33)


@pytest.mark.parametrize("label", [disc, stripes, lambda x, y: 1])
@pytest.mark.parametrize("levels", [1, 3])
def test_the_whole_map_comes_out(label, levels):
    keys, whole, asked, filled = refined(label, (9, 11), levels)
    assert np.array_equal(keys, whole)
    assert len(set(asked)) == len(asked)
    assert len(asked) + len(filled) == keys.size
    assert not set(asked) & set(map(tuple, filled))


def test_borders_cost_a_line_and_not_an_area():
    keys, _, asked, _ = refined(disc, (17, 17), 4)
    assert keys.size == 257 * 257
    # the circle is 484 cells of the finest grid long
    assert len(asked) < 17 * 17 + 12 * 484


def test_no_refinement_computes_everything_once():
    _, whole, asked, filled = refined(stripes, (5, 4), 0)
    assert len(asked) == whole.size
    assert len(filled) == 0


@pytest.mark.parametrize("shape", [(1, 9), (9, 1), (1, 1)])
def test_a_single_value(shape):
    keys, whole, asked, _ = refined(lambda x, y: 1 + (x + y > 0.4), shape, 3)
    assert np.array_equal(keys, whole)
    assert keys.size == 1 or len(asked) < keys.size / 2


def test_a_tongue_that_enters_through_an_edge():
    """All corners of a cell agree, and its edge does not: the neighbour tells."""

    def tongue(x, y):
        return 1 + (abs(x - 0.43) < 0.11 * (0.8 - y))

    keys, whole, _, _ = refined(tongue, (9, 9), 3)
    assert np.array_equal(keys, whole)


def test_an_interruption_leaves_the_rest_unknown():
    keys = np.full((9, 9), UNKNOWN, np.int64)
    calls = []

    def compute(places):
        calls.append(len(places))
        if len(calls) == 2:
            return False
        for i, j in places:
            keys[i, j] = 1 + (i > 4)
        return True

    filled = refine_borders(keys, 2, compute)
    assert len(filled) == 0
    assert np.count_nonzero(keys) == calls[0] == 9


def test_given_values_stay_as_they_are():
    given = np.array([0.1, 0.3, 0.7])
    found = refined_values(given, 2)
    assert found[::4].tolist() == given.tolist()
    assert found == pytest.approx([0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7])
    assert refined_values(np.array([2.0]), 3).tolist() == [2.0]
