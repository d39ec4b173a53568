import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth import OptionError


def diagram(columns, points, lanes=1):
    """A diagram of a curve, the later points of every other column missing."""
    x = np.sin(np.linspace(0, 3, columns))[:, None, None] + np.zeros((columns, lanes, points))
    x[::2, :, points // 2 :] = np.nan
    return xr.Dataset(
        {
            "x": (("parameter", "lane", "point"), x, {"long_name": "displacement", "units": "mm"}),
            "period": (("parameter", "lane"), np.ones((columns, lanes), int)),
            "word": (("parameter", "lane"), np.full((columns, lanes), "a b")),
        },
        {"parameter": ("parameter", np.arange(columns), {"long_name": "frequency"})},
    )


def test_points_and_labels():
    ax = ns.plot.bifurcation(diagram(10, 4), "x")
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("frequency", "displacement [mm]")
    (line,) = ax.lines
    assert np.count_nonzero(np.isfinite(line.get_ydata())) == 5 * 2 + 5 * 4
    assert ax.get_legend() is None


def test_lanes_have_colours_and_a_legend():
    ax = ns.plot.bifurcation(diagram(10, 4, lanes=2), "period")
    assert len({line.get_color() for line in ax.lines}) == 2
    assert [text.get_text() for text in ax.get_legend().get_texts()] == [
        "initial state 1",
        "initial state 2",
    ]


def test_many_points_stay_small(tmp_path):
    ax = ns.plot.bifurcation(diagram(1000, 1000), "x")
    ns.plot.save_figure(ax.figure, tmp_path / "a.pdf")
    assert (tmp_path / "a.pdf").stat().st_size < 500_000


@pytest.mark.parametrize("name", ["y", "word"])
def test_unknown_variables(name):
    with pytest.raises(OptionError, match="unknown variable"):
        ns.plot.bifurcation(diagram(3, 2), name)


def test_what_is_no_diagram():
    with pytest.raises(OptionError, match="no dimensions"):
        ns.plot.bifurcation(xr.Dataset({"x": ("time", [1.0])}), "x")
