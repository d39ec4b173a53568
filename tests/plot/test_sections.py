import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth.errors import OptionError


@pytest.fixture(scope="module")
def points():
    return ns.poincare_section(
        ns.models.soft_impact(), section="v", direction=0, transient=20, record=150
    )


def test_the_points_are_drawn(points, ax):
    ns.plot.section(points, "x", "v", ax=ax)
    (line,) = ax.lines
    np.testing.assert_array_equal(line.get_xdata(), points["x"])
    np.testing.assert_array_equal(line.get_ydata(), points["v"])
    assert line.get_linestyle() == "None" and line.get_marker() == "o"
    assert not line.get_rasterized()
    assert ax.get_xlabel() == "displacement of the mass"


def test_points_have_the_colour_of_their_mode(points, ax):
    ns.plot.section(points, "phase", "stop_force", ax=ax, phases=True)
    colours = ns.plot.mode_colours(points)
    drawn = {line.get_label(): line for line in ax.lines}
    assert set(drawn) == {"free", "contact"}
    for number, name in enumerate(("free", "contact")):
        here = points["mode"].values == number
        assert drawn[name].get_color() == colours[name]
        np.testing.assert_array_equal(drawn[name].get_xdata(), points["phase"][here])


def test_a_million_points_make_a_small_file(ax, tmp_path):
    rng = np.random.default_rng(3)
    cloud = xr.Dataset({name: ("point", rng.normal(size=1_000_000)) for name in ("x", "v")})
    ns.plot.section(cloud, "x", "v", ax=ax)
    assert ax.lines[0].get_rasterized()
    file = ns.plot.save_figure(ax.figure, tmp_path / "cloud.pdf")
    assert file.stat().st_size < 500_000  # 16 MB of coordinates


def test_many_points_are_small_unless_they_coincide(points, ax):
    rng = np.random.default_rng(3)
    cloud = xr.Dataset({name: ("point", rng.normal(size=3000)) for name in ("x", "v")})
    ns.plot.section(points.isel(point=slice(0, 100)), "x", "v", ax=ax)
    ns.plot.section(points.isel(point=np.arange(3000) % 100), "x", "v", ax=ax)
    ns.plot.section(cloud, "x", "v", ax=ax)
    ns.plot.section(cloud, "x", "v", ax=ax, size=5.0)
    few, repeated, many, given = (line.get_markersize() for line in ax.lines)
    assert few == repeated > 2 * many
    assert given == 5.0


def test_the_legend_is_legible(points, ax):
    ns.plot.section(points, "x", "v", ax=ax, phases=True, size=0.1)
    assert [h.get_markersize() for h in ax.get_legend().legend_handles] == [3.0, 3.0]
    assert ax.lines[0].get_markersize() == 0.1


def test_no_points_are_an_empty_picture(ax):
    with pytest.warns(ns.RunWarning):
        none = ns.poincare_section(ns.models.duffing(), section="x - 50", t_end=10.0)
    ns.plot.section(none, "x", "v", ax=ax)
    assert ax.get_ylabel()


def test_unknown_variables(points, ax):
    with pytest.raises(OptionError, match=r"unknown variable 'y'.*period_number"):
        ns.plot.section(points, "x", "y", ax=ax)
    grid = points.assign(other=("lane", np.zeros(3)))
    with pytest.raises(OptionError, match="over the same points"):
        ns.plot.section(grid, "x", "other", ax=ax)


def test_a_settled_section_has_numbers_that_can_be_read(ax):
    """Points of a cycle that differ by rounding alone, across and up."""
    noise = 3e-16 * np.arange(5.0)
    points = xr.Dataset({"x": ("point", -0.1975 + noise), "v": ("point", 2.0 + 4.0 * noise)})
    ns.plot.section(points, "x", "v", ax=ax)
    ax.figure.canvas.draw()
    texts = [text.get_text() for axis in (ax.xaxis, ax.yaxis) for text in axis.get_ticklabels()]
    assert max(map(len, texts)) < 8
    assert np.ptp(ax.get_xlim()) == pytest.approx(0.1 * 0.1975, rel=1e-6)
