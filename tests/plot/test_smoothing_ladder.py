"""Pictures of reports on smoothing: what they show is what the report says."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns


@pytest.fixture(scope="module")
def report():
    block = ns.System(states=["x", "v"], equations={"x": "v", "v": "0.3 - sign(v)"})
    return ns.smoothing_report(block, (1e-3, 1e-2, 1e-1), initial={"v": 0.5}, t_end=3.0)


def test_a_line_for_each_state_with_its_exponent(report):
    ax = ns.plot.smoothing(report)
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    exponents = report["error_exponent"].values
    assert texts == [f"{s}: exponent {e:.2f}" for s, e in zip("xv", exponents, strict=True)]
    points = [line for line in ax.get_lines() if line.get_linestyle() == "None"]
    for line, values in zip(points, report["error"].values.T, strict=True):
        assert line.get_xdata() == pytest.approx(report["epsilon"].values)
        assert line.get_ydata() == pytest.approx(values)


def test_the_line_is_the_power_law_through_the_points():
    widths = np.array([0.1, 0.2, 0.4])
    made = xr.Dataset(
        {
            "creep": (("epsilon", "surface"), 3 * widths[:, None] ** 2),
            "creep_exponent": ("surface", [2.0]),
        },
        {"epsilon": widths, "surface": ["slip"]},
    )
    (_, line) = ns.plot.smoothing(made, "creep").get_lines()
    assert line.get_ydata() == pytest.approx(3 * widths**2)


def test_zeros_are_left_out_and_one_point_has_no_exponent():
    made = xr.Dataset(
        {
            "special_shift": (("epsilon", "special"), [[0.0, np.nan], [-0.1, np.nan]]),
            "special_shift_exponent": ("special", [np.nan, np.nan]),
            "special_kind": ("special", ["flip", "fold"]),
            "special_value_exact": ("special", [0.5, 0.6]),
        },
        {"epsilon": [0.1, 0.2]},
    )
    ax = ns.plot.smoothing(made, "special_shift")
    (points,) = ax.get_lines()
    assert (points.get_xdata().tolist(), points.get_ydata().tolist()) == ([0.2], [0.1])
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["flip at 0.5"]


def test_bad_input(report):
    with pytest.raises(ns.OptionError, match="no report on smoothing"):
        ns.plot.smoothing(xr.Dataset())
    with pytest.raises(ns.OptionError, match="it has error, stick_time_error, creep"):
        ns.plot.smoothing(report, "special_shift")
