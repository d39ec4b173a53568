import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth import OptionError
from nonsmooth.plot.period_colours import LONGER, NOT_SETTLED, PERIODS


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


def test_a_constant_but_for_rounding_has_numbers_that_can_be_read():
    """Texts of 16 digits told the rounding before; a span above it keeps its own numbers."""
    flat = diagram(10, 4)
    steps = np.arange(flat["x"].size).reshape(flat["x"].shape)
    flat["x"].values[:] = 0.7 + 1e-13 * steps
    ax = ns.plot.bifurcation(flat, "x")
    ax.get_figure().draw_without_rendering()
    assert max(len(each.get_text()) for each in ax.get_yticklabels()) <= 5
    low, high = ax.get_ylim()
    assert low == pytest.approx(0.665) and high == pytest.approx(0.735)
    flat["x"].values[:] = 0.7 + 1e-6 * steps
    low, high = ns.plot.bifurcation(flat, "x").get_ylim()
    assert high - low < 1e-4


def test_lanes_have_colours_and_a_legend():
    ax = ns.plot.bifurcation(diagram(10, 4, lanes=2), "period")
    assert len({line.get_color() for line in ax.lines}) == 2
    assert [text.get_text() for text in ax.get_legend().get_texts()] == [
        "initial state 1",
        "initial state 2",
    ]


@pytest.mark.slow
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


def coloured(ax):
    """Labels, colours, and parameters at which points are drawn, of each set of points."""
    return [
        (
            line.get_label() if not line.get_label().startswith("_") else "",
            line.get_color(),
            sorted(set(line.get_xdata()[np.isfinite(line.get_ydata())].tolist())),
        )
        for line in ax.lines
    ]


def test_colours_tell_periods():
    data = diagram(6, 4)
    data["period"][:, 0] = [1, 2, 2, 11, 0, 8]
    ax = ns.plot.bifurcation(data, "x", colour="period")
    assert coloured(ax) == [
        ("period 1", PERIODS[1], [0.0]),
        ("period 2", PERIODS[2], [1.0, 2.0]),
        ("period 8", PERIODS[8], [5.0]),
        ("period > 8", LONGER, [3.0]),
        ("no period found", NOT_SETTLED, [4.0]),
    ]
    assert [text.get_text() for text in ax.get_legend().get_texts()] == [
        "period 1",
        "period 2",
        "period 8",
        "period > 8",
        "no period found",
    ]


def test_verdicts_tell_chaos_from_what_has_not_settled():
    data = diagram(4, 4)
    data["period"][:, 0] = [1, 0, 0, 0]
    words = ["periodic", "chaotic", "unsettled", "periodic"]
    data["regime"] = (("parameter", "lane"), np.array(words)[:, None])
    assert coloured(ns.plot.bifurcation(data, "x", colour="period")) == [
        ("period 1", PERIODS[1], [0.0]),
        ("chaotic", "#000000", [1.0]),
        ("unsettled", NOT_SETTLED, [2.0]),
        ("no period found", NOT_SETTLED, [3.0]),
    ]
    data["regime"][0, 0] = "wild"
    with pytest.raises(OptionError, match="'wild'"):
        ns.plot.bifurcation(data, "x", colour="period")


def test_periods_of_several_initial_states_keep_their_marks():
    data = diagram(4, 2, lanes=2)
    data["period"][:, 1] = 2
    data["period"][3, 1] = 1
    ax = ns.plot.bifurcation(data, "x", colour="period")
    assert [(name, colour) for name, colour, _ in coloured(ax)] == [
        ("period 1", PERIODS[1]),
        ("", PERIODS[1]),
        ("period 2", PERIODS[2]),
    ]
    assert len({line.get_marker() for line in ax.lines}) == 2


def test_periods_of_quantities_of_columns_have_the_same_colours():
    data = diagram(3, 2)
    data["period"][:, 0] = [1, 2, 1]
    found = coloured(ns.plot.bifurcation(data, "period", colour="period"))
    assert [each[2] for each in found] == [[0.0, 2.0], [1.0]]


def test_other_colours_are_refused():
    with pytest.raises(OptionError, match="unknown choice 'lane'"):
        ns.plot.bifurcation(diagram(3, 2), "x", colour="lane")
    with pytest.raises(OptionError, match="no variable 'period'"):
        ns.plot.bifurcation(diagram(3, 2).drop_vars("period"), "x", colour="period")


def test_no_initial_state_hides_another_where_there_are_many_points():
    """Two clouds of points in the same place: each has about half of what is seen."""
    from matplotlib.colors import to_rgb

    rng = np.random.default_rng(0)
    diagram = xr.Dataset(
        {"x": (("parameter", "lane", "point"), rng.uniform(size=(400, 2, 100)))},
        {"parameter": ("parameter", np.linspace(0.0, 1.0, 400))},
    )
    ax = ns.plot.bifurcation(diagram, "x", legend=False)
    figure = ax.get_figure(root=True)
    figure.set_dpi(100)
    figure.canvas.draw()
    seen = np.asarray(figure.canvas.buffer_rgba())[..., :3] / 255.0
    colours = [to_rgb(colour) for colour in dict.fromkeys(line.get_color() for line in ax.lines)]
    shares = [np.count_nonzero(np.abs(seen - colour).max(axis=2) < 0.02) for colour in colours]
    assert len(shares) == 2 and min(shares) > 0.35 * sum(shares)
