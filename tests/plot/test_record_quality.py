"""A channel with its flaws: what is shaded, what has a mark, and where."""

import numpy as np
import pytest

import nonsmooth as ns


@pytest.fixture(scope="module")
def flawed():
    t = np.arange(4000) / 2000.0
    x = np.cos(100 * t) + np.random.default_rng(0).normal(0, 0.01, t.size)
    x[3000] += 0.4
    x = np.round(np.minimum(x, 0.9), 3)
    x[1000:1400] = x[1020]
    return ns.measured.from_arrays({"x": x, "y": 0 * t}, times=t, units="mm")


def test_flaws_are_where_they_were_found(flawed):
    found = ns.measured.check(flawed)
    ax = ns.plot.quality(flawed, found, "x")
    assert set(ax.get_legend_handles_labels()[1]) == {"frozen", "spike", "clipped"}
    shaded, marks = {}, {}
    for one in ax.collections:
        (shaded if one.get_label() == "frozen" else marks)[one.get_label()] = one
    (path,) = shaded["frozen"].get_paths()
    low, high = path.vertices[:, 0].min(), path.vertices[:, 0].max()
    assert (low, high) == pytest.approx((0.5, 0.7), abs=1e-3)
    assert marks["spike"].get_offsets()[0, 0] == pytest.approx(1.5)
    np.testing.assert_allclose(marks["clipped"].get_offsets()[:, 1], 0.9)


def test_a_note_on_the_whole_channel_stands_in_the_legend(flawed):
    ax = ns.plot.quality(flawed, ns.measured.check(flawed), "y", time_range=(0.2, 0.8))
    assert ax.get_legend_handles_labels()[1] == ["constant (0)"]
    assert ax.get_xlim() == (0.2, 0.8)


@pytest.mark.parametrize(
    ("shown", "named"),
    [((0.55, 0.6), {"frozen"}), ((1.4995, 1.5005), {"spike"}), ((0.02, 0.05), set())],
)
def test_the_legend_names_what_is_in_the_picture_only(flawed, shown, named):
    ax = ns.plot.quality(flawed, ns.measured.check(flawed), "x", time_range=shown)
    assert set(ax.get_legend_handles_labels()[1]) == named
    assert (ax.get_legend() is not None) == bool(named)
    assert len(ax.collections) == len(named)


def test_wrong_use(flawed):
    found = ns.measured.check(flawed, channels="x")
    with pytest.raises(ns.OptionError, match="says nothing of y"):
        ns.plot.quality(flawed, found, "y")
    with pytest.raises(ns.OptionError, match="unknown variable"):
        ns.plot.quality(flawed, found, "z")


@pytest.fixture(scope="module")
def spiked():
    """x has a spike at 1.5 s, where a revolution begins, and y has none."""
    t = np.arange(4000) / 2000.0
    rng = np.random.default_rng(1)
    x, y = (wave(100 * t) + rng.normal(0, 0.01, t.size) for wave in (np.cos, np.sin))
    x[3000] += 0.9
    marks = np.arange(1, 31) * np.pi / 50
    marks += 1.5 - marks[np.argmin(np.abs(marks - 1.5))]
    record = ns.measured.from_arrays({"x": x, "y": y}, times=t, marks=marks, units="mm")
    return ns.measured.flagged(record)


def crosses(ax):
    """What has the mark of flagged samples, and how often the legend says so."""
    marked = [line for line in ax.lines if line.get_marker() == "x"]
    points = np.concatenate([np.array(line.get_data()).T for line in marked] or [np.zeros((0, 2))])
    return points, ax.get_legend_handles_labels()[1].count("flagged")


def test_flagged_samples_have_crosses(spiked):
    x, y = (float(spiked[name][3000]) for name in "xy")
    for ax, points in (
        (ns.plot.time_history(spiked, "x"), [[1.5, x]]),
        (ns.plot.time_history(spiked, ["x", "y"]), [[1.5, x]]),
        (ns.plot.phase_portrait(spiked, "x", "y"), [[x, y]]),
    ):
        found, said = crosses(ax)
        np.testing.assert_array_equal(found, points)
        assert said == 1 and ax.get_legend() is not None
    for ax in (
        ns.plot.time_history(spiked, "y"),
        ns.plot.time_history(spiked, "x", time_range=(0.1, 1.4)),
        ns.plot.phase_portrait(spiked, "x", "y", time_range=(0.1, 1.4)),
    ):
        found, said = crosses(ax)
        assert not len(found) and said == 0


def test_points_that_were_made_of_flagged_samples_have_crosses(spiked):
    """Four samples about a mark make a point; the points of the spike are no dots as well."""
    points = ns.measured.section(spiked)
    bad = points["x_quality"].values != 0
    assert bad.sum() == 1
    ax = ns.plot.section(points, "x", "y")
    found, said = crosses(ax)
    np.testing.assert_array_equal(found, [[points["x"].values[bad][0], points["y"].values[bad][0]]])
    assert said == 1 and ax.lines[0].get_xdata().size == points.sizes["point"] - 1

    clean = ns.measured.section(spiked.drop_vars(["x_quality", "y_quality"]))
    diagram = ns.measured.diagram([points, clean], values=[2.0, 1.0])
    flags = diagram["x_quality"].values[:, 0]
    np.testing.assert_array_equal(flags, [np.zeros(bad.size), points["x_quality"].values])
    found, said = crosses(ns.plot.bifurcation(diagram, "x"))
    np.testing.assert_array_equal(found, [[2.0, points["x"].values[bad][0]]])
    assert said == 1
    assert crosses(ns.plot.bifurcation(diagram, "y"))[1] == 0
    assert crosses(ns.plot.bifurcation(diagram, "speed"))[1] == 0
