"""The entry that decides the sign of a vector is the same whatever rounding makes of it."""

import numpy as np
import pytest

from nonsmooth.leading_entry import leading_entry


@pytest.mark.parametrize("rounding", [-1e-15, 0.0, 1e-15, 4e-12])
def test_of_equal_entries_the_first_one_counts(rounding):
    vectors = np.array([[0.1, 1.0, 0.0], [-1.0, 0.3j, 0.0], [1.0 + rounding, 1j, 0.0]])
    assert leading_entry(vectors).tolist() == [1, 0, 0]
    assert leading_entry(vectors[:, 0]) == 1


def test_the_largest_one_counts_where_they_differ():
    assert leading_entry(np.array([1.0, -1.0 - 1e-8])) == 1
    assert leading_entry(np.array([1.0, -1.0 - 1e-8]), 1e-6) == 0
