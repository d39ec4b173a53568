"""Pictures of slowly changing motions: what is drawn is what the data says."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth.errors import OptionError

COUNT = 600


@pytest.fixture
def drifting():
    """Two branches that drift apart in known directions, after one that stays in its place."""
    k = np.arange(COUNT)
    u = np.where(k < 200, 0.0, np.where(k % 2, 1.0 + 1e-3 * (k - 200), -1.0))
    v = np.where(k < 200, 0.0, np.where(k % 2, 0.0, 2e-3 * (k - 200)))
    return xr.Dataset(
        {"u": ("time", u), "v": ("time", v), "crack": ("time", 5.0 + 0.01 * k)},
        {"time": ("time", 2.0 * k, {"long_name": "time", "units": "s"})},
    )


def arrows(ax) -> list[np.ndarray]:
    """From tail to tip, in units of the data."""
    return [np.subtract(text.xy, text.xyann) for text in ax.texts]


def test_a_transient_section_has_colours_of_time_and_an_arrow_per_branch(drifting, ax):
    labels = ns.local_regimes(drifting, window=48, variables=["u", "v"])
    np.testing.assert_array_equal(labels["stretch_period"], [1, 2])
    ns.plot.transient_section(drifting, "u", "v", labels=labels, ax=ax)
    (points,) = ax.collections
    np.testing.assert_array_equal(points.get_offsets()[:, 0], drifting["u"])
    np.testing.assert_array_equal(points.get_array(), drifting["time"])
    bar = next(other for other in ax.figure.axes if other is not ax)
    assert bar.get_ylabel() == "time [s]"
    found = sorted(arrows(ax), key=lambda way: way[0])  # none for the one that stays
    assert len(found) == 2
    up, right = found
    assert up[1] > 0 and abs(up[0]) < 1e-6
    assert right[0] > 0 and abs(right[1]) < 1e-6


def test_short_branches_get_no_arrow_and_arrows_do_not_pile_up(ax):
    """Two bows side by side cross the axes; two other branches are shorter than an arrow."""
    k = np.arange(6000)
    far = 10.0 * k / k[-1]
    bow = 0.2 * far * (10.0 - far)
    u = np.select([k % 4 == 0, k % 4 == 1, k % 4 == 2], [far, far, 5.0], 0.03 * far)
    v = np.select([k % 4 == 0, k % 4 == 1, k % 4 == 2], [bow, bow + 0.05, 0.03 * far], 3.0)
    points = xr.Dataset({"u": ("time", u), "v": ("time", v)}, {"time": ("time", 1.0 * k)})
    labels = ns.local_regimes(points)
    np.testing.assert_array_equal(labels["stretch_period"], [4])
    ns.plot.transient_section(points, "u", "v", labels=labels, ax=ax)
    (way,) = arrows(ax)
    assert way[0] > 0
    tip = ax.texts[0].xy
    assert tip[1] > 0.2 * tip[0] * (10.0 - tip[0])  # above the bows


def test_part_of_a_run_takes_the_labels_of_all_of_it(drifting, ax):
    labels = ns.local_regimes(drifting, window=48, variables=["u", "v"])
    part = drifting.isel(time=slice(201, None, 2))
    ns.plot.transient_section(part, "u", "v", labels=labels, colour="crack", ax=ax, bar=False)
    assert len(ax.figure.axes) == 1
    np.testing.assert_array_equal(ax.collections[0].get_array(), part["crack"])


def test_labels_of_another_run_are_refused(drifting, ax):
    labels = ns.local_regimes(drifting, window=48, variables=["u", "v"])
    later = drifting.assign_coords(time=drifting["time"] + 1.0)
    with pytest.raises(OptionError, match="no label at some times"):
        ns.plot.transient_section(later, "u", "v", labels=labels, ax=ax)
    with pytest.raises(OptionError, match="result of local_regimes"):
        ns.plot.transient_section(drifting, "u", "v", labels=drifting, ax=ax)
    with pytest.raises(OptionError, match=r"known|did you mean"):
        ns.plot.transient_section(drifting, "u", "w", ax=ax)


@pytest.fixture(scope="module")
def orbits():
    return {
        crack: ns.simulate(ns.models.breathing_crack(crack=crack), {"v": 0.1}, periods=30)
        for crack in (10.0, 6.4)
    }


def test_orbits_stand_at_their_values(orbits):
    ax = ns.plot.phase_portrait_3d(orbits, "u", "v", label="crack length [mm]", periods=2)
    assert len(ax.lines) == 4
    for line, value in zip(ax.lines, (6.4, 10.0), strict=False):
        u, there, v = line.get_data_3d()
        assert np.all(there == value)
        run = orbits[value]
        last = run["time"] >= run["time"][-1] - 2 * run.attrs["period"]
        assert u.max() >= run["u"].where(last).max() and np.ptp(v) > 0
    assert ax.get_ylabel() == "crack length [mm]"
    low, high = ax.get_ylim()
    assert low < 6.4 and high > 10.0


def test_orbits_in_axes_of_the_caller(orbits, ax):
    own = ax.figure.add_subplot(projection="3d")
    assert ns.plot.phase_portrait_3d(orbits, "u", "v", ax=own, shadows=False) is own
    assert len(own.lines) == 2
    with pytest.raises(OptionError, match="three dimensions"):
        ns.plot.phase_portrait_3d(orbits, "u", "v", ax=ax)
    with pytest.raises(OptionError, match="mapping such as"):
        ns.plot.phase_portrait_3d({}, "u", "v")
    without = {1.0: orbits[6.4].assign_attrs(period=0.0).copy()}
    del without[1.0].attrs["period"]
    with pytest.raises(OptionError, match="periods=None"):
        ns.plot.phase_portrait_3d(without, "u", "v")


def test_sections_are_tied_to_where_the_curve_reaches_them(drifting, ax):
    points = {
        a: drifting.isel(time=slice(0, 50)).drop_vars("time").rename(time="point")
        for a in (9.0, 6.005, 10.99)
    }
    ns.plot.growth_curve(drifting, points, ax=ax)
    assert [inset.get_title() for inset in ax.child_axes] == ["6.005 mm", "9 mm", "10.99 mm"]
    spots = [line.get_xydata()[0] for line in ax.lines[1:]]
    np.testing.assert_allclose(spots, [[201, 6.005], [800, 9], [1198, 10.99]])
    np.testing.assert_allclose([text.xy for text in ax.texts], spots)
    assert len({inset.get_xlim() for inset in ax.child_axes}) == 1


@pytest.mark.slow
def test_insets_do_not_overlap(drifting, ax):
    """For any number of them, and each has room for its title."""
    for count in range(1, 10):
        ax.clear()
        points = {5.5 + 0.5 * k: drifting.isel(time=slice(0, 9)) for k in range(count)}
        ns.plot.growth_curve(drifting, points, ax=ax)
        ax.figure.draw_without_rendering()
        boxes = [inset.get_tightbbox().padded(-1) for inset in ax.child_axes]
        for k, box in enumerate(boxes):
            assert box.count_overlaps(boxes[:k]) == 0, count
            assert ax.get_window_extent().padded(2).count_contains(box.corners()) == 4


def test_what_the_curve_does_not_reach_is_refused(drifting, ax):
    some = drifting.isel(time=slice(0, 9))
    with pytest.raises(OptionError, match=r"crack = 19 is not reached; it goes from 5 to 10\.99"):
        ns.plot.growth_curve(drifting, {19.0: some}, ax=ax)
    with pytest.raises(OptionError, match="0 places for 1 sections"):
        ns.plot.growth_curve(drifting, {6.0: some}, ax=ax, places=[])
    with pytest.raises(OptionError, match="growing"):
        ns.plot.growth_curve(drifting, growing="length", ax=ax)


def test_a_run_of_one_sample_is_a_point_of_the_stack():
    run = ns.simulate(ns.models.soft_impact(), periods=2, samples_per_period=8)
    ax = ns.plot.phase_portrait_3d({1.0: run.isel(time=slice(1)), 2.0: run}, "x", "v")
    ax.figure.draw_without_rendering()
