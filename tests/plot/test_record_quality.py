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


def test_wrong_use(flawed):
    found = ns.measured.check(flawed, channels="x")
    with pytest.raises(ns.OptionError, match="says nothing of y"):
        ns.plot.quality(flawed, found, "y")
    with pytest.raises(ns.OptionError, match="unknown variable"):
        ns.plot.quality(flawed, found, "z")
