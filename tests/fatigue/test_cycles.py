"""Cycles counted by hand, by the standard and by the library on the whole record."""

import numpy as np
import pytest
import rainflow
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from nonsmooth.errors import OptionError
from nonsmooth.fatigue import LoadBlock, count_cycles, reversals

STANDARD = [-2, 1, -3, 5, -1, 3, -4, 4, -2]  # ASTM E1049-85, Fig. 6: A to I


def test_the_example_of_the_standard_in_its_order():
    cycles = count_cycles(STANDARD)
    rows = [
        (3, 0.5, -0.5, 0, 1),  # A-B
        (4, 0.5, -1.0, 1, 2),  # B-C
        (4, 1.0, 1.0, 4, 5),  # E-F
        (8, 0.5, 1.0, 2, 3),  # C-D
        (9, 0.5, 0.5, 3, 6),  # D-G
        (8, 0.5, 0.0, 6, 7),  # G-H
        (6, 0.5, 1.0, 7, 8),  # H-I
    ]
    for name, column in zip(
        ("range", "count", "mean", "start", "end"), zip(*rows, strict=True), strict=True
    ):
        np.testing.assert_array_equal(cycles[name], column)
    assert cycles.attrs["n_cycles"] == 4.0


def test_the_example_repeated_has_whole_cycles_only():
    """Section 5.4.5, Fig. 7: D-G, H-C, E-F and A-B."""
    cycles = count_cycles(STANDARD, repeating=True)
    assert sorted(cycles["range"].values.tolist()) == [3, 4, 7, 9]
    np.testing.assert_array_equal(cycles["count"], 1.0)


@given(st.lists(st.integers(-5, 5), min_size=3, max_size=60))
def test_reduction_changes_nothing(values):
    """Equal neighbours, flat ends and all: the library on the whole record says the same."""
    cycles = count_cycles(values)
    whole = [row for row in rainflow.extract_cycles(values) if row[0] > 0]
    got = [cycles[name].values for name in ("range", "mean", "count", "end")]
    assert np.transpose(got).tolist() == [[r, m, c, end] for r, m, c, _, end in whole]


@given(st.lists(st.integers(-4, 4), min_size=2, max_size=40))
def test_a_block_repeated_thrice_has_three_times_its_cycles(values):
    """But for what is left open at both ends of the three."""
    block = [*values, values[0]]
    if min(block) == max(block):
        return
    once = count_cycles(block, repeating=True)
    thrice = count_cycles(values * 3 + values[:1], repeating=True)
    assert sorted(np.repeat(once["range"], 3)) == sorted(thrice["range"])


def test_a_harmonic_record_has_its_periods():
    t = np.arange(20 * 64 + 1) / 64.0
    cycles = count_cycles(100.0 + 50.0 * np.sin(2 * np.pi * t), t, repeating=True)
    assert cycles.sizes["cycle"] == 20 and cycles.attrs["duration"] == 20.0
    np.testing.assert_allclose(cycles["range"], 100.0, rtol=1e-13)
    np.testing.assert_allclose(cycles["mean"], 100.0, rtol=1e-13)


def test_refined_reversals():
    """Phase off the samples: 1 - cos(pi/n) at worst without, of fourth order with parabolas."""
    n = 40
    t = np.arange(50 * n + 1) / n
    load = np.sin(2 * np.pi * t + np.pi / n + np.pi / 2)
    plain = count_cycles(load, t, repeating=True)["range"].values
    better = count_cycles(load, t, repeating=True, refine=True)["range"].values
    worst = 2 * (1 - np.cos(np.pi / n))
    np.testing.assert_allclose(2 - plain, worst, rtol=1e-6)
    assert np.abs(2 - better).max() < 2 * (np.pi / n) ** 4


def test_times_and_units_come_with_a_data_array():
    run = xr.DataArray(
        [0.0, 2.0, -1.0, 2.0], {"time": [0.0, 0.1, 0.3, 0.7]}, "time", attrs={"units": "N"}
    )
    cycles = count_cycles(run)
    assert cycles["range"].attrs["units"] == "N" and cycles["end"].attrs["units"] == "s"
    np.testing.assert_array_equal(cycles["end"], [0.1, 0.3, 0.7])


def test_a_constant_record_has_no_cycle():
    assert count_cycles([3.0, 3.0, 3.0]).sizes["cycle"] == 0
    with pytest.raises(OptionError, match="never turns"):
        LoadBlock.from_record([3.0, 3.0, 3.0], [0.0, 1.0, 2.0])


@pytest.mark.parametrize(
    ("values", "times", "text"),
    [
        ([], None, "0 samples"),
        ([1.0], None, "1 samples"),
        ([1.0, np.nan, 2.0], None, "first at index 1"),
        ([1.0, 2.0, -np.inf], None, "first at index 2"),
        ([[1.0, 2.0]], None, "2 dimensions"),
        (["a", "b"], None, "as numbers"),
        ([1.0, 2.0, 3.0], [0.0, 1.0], "2 came for 3"),
        ([1.0, 2.0, 3.0], [0.0, 1.0, 1.0], "after index 1"),
    ],
)
def test_bad_records(values, times, text):
    with pytest.raises(OptionError, match=text):
        count_cycles(values, times)


def test_reversals_of_a_slope():
    assert reversals([0.0, 1.0, 2.0]).tolist() == [0, 2]
    assert reversals([1.0, 1.0]).tolist() == [0, 1]
