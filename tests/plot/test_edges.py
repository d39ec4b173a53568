"""Pictures of the motion on a border of basins."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns


@pytest.fixture(scope="module")
def edge():
    wells = ns.System(
        states=["x", "v"],
        period=1.0,
        equations={"x": "v", "v": "where(abs(x) < 1, x, 2*sign(x) - x) - 0.2*v"},
        describe={"x": "displacement [mm]"},
    )
    return ns.edge_state(wells, {"x": -1.7}, {"x": 2.3})


def test_starts_track_and_saddle(edge):
    ax = ns.plot.edge_state(edge)
    starts, track, saddle = ax.lines
    assert starts.get_xdata().tolist() == [-1.7, 2.3]
    np.testing.assert_array_equal(track.get_ydata(), edge["track"].sel(state="v"))
    assert saddle.get_marker() == "D" and abs(saddle.get_xdata()[0]) < 1e-12
    assert ax.get_xlabel() == "displacement [mm]"
    plt.close(ax.figure)


def test_the_saddle_alone_and_the_axes_of_others(edge):
    _, (axes,) = ns.plot.print_figure()
    axes.plot([0.0, 1.0], [0.0, 1.0], label="before")
    ns.plot.edge_state(edge, "v", "x", ax=axes, track=False)
    assert [text.get_text() for text in axes.get_legend().get_texts()] == [
        "before", "saddle, period 1",
    ]  # fmt: skip
    assert axes.get_ylabel() == "displacement [mm]"
    plt.close(axes.figure)


def test_a_profile_with_bands_and_ends_of_the_region():
    shape = ("parameter", "attractor")
    profile = xr.Dataset(
        {
            "local_integrity": (shape, [[2.0, np.nan], [1.0, 0.5], [0.5, 0.7]]),
            "local_error": (shape, [[0.1, np.nan], [0.1, 0.1], [0.1, 0.1]]),
            "local_limit": (shape, [["region", ""], ["border", "border"], ["border", "border"]]),
            "period": (shape, [[1, 0], [1, 2], [1, 2]]),
        },
        {"parameter": ("parameter", [1.0, 2.0, 3.0], {"long_name": "force"}), "attractor": [1, 2]},
    )
    ax = ns.plot.erosion_profile(profile)
    one, two, ends = ax.lines
    np.testing.assert_array_equal(one.get_ydata(), [2.0, 1.0, 0.5])
    assert ends.get_xdata().tolist() == [1.0] and two.get_label() == "attractor 2"
    entries = [text.get_text() for text in ax.get_legend().get_texts()]
    assert entries == ["attractor 1", "attractor 2", "ball ended by the region"]
    assert len(ax.collections) == 2 and ax.get_ylim()[0] == 0.0 and ax.get_xlabel() == "force"
    relative = ns.plot.erosion_profile(profile, relative=True)
    np.testing.assert_allclose(relative.lines[0].get_ydata(), [1.0, 0.5, 0.25])
    for each in (ax, relative):
        plt.close(each.figure)


def profile_of(shares, unsettled, **attrs):
    """Profile with the same numbers for all measures, nan where there is no attractor."""
    shares, over = np.array(shares), ("parameter", "attractor")
    names = ("local_integrity", "global_integrity", "integrity_factor")
    names += ("local_error", "global_error", "factor_error")
    return xr.Dataset(
        {name: (over, 0.0 * shares if "error" in name else shares) for name in names}
        | {"unsettled": ("parameter", unsettled)},
        {"parameter": np.arange(len(shares)) + 1.0, "attractor": np.arange(shares.shape[1]) + 1},
        attrs={"half_diagonal": 0.1, **attrs},
    )


NAN = np.nan


def test_a_safe_basin_is_one_curve_to_the_value_at_which_it_is_gone():
    """Also where its attractors have other numbers; where starts are unsettled it is not known."""
    shares = [[0.5, NAN, NAN], [NAN, 0.4, 0.3], [NAN] * 3, [NAN] * 3]
    profile = profile_of(shares, [0.0, 0.1, 0.0, 0.1], safe="all")
    ax = ns.plot.erosion_profile(profile, "factor")
    (line,) = ax.lines
    np.testing.assert_array_equal(line.get_ydata(), [0.5, 0.3, 0.0, NAN])
    assert line.get_label() == "safe basin"
    assert ax.get_xlim()[0] <= 1.0 and ax.get_xlim()[1] >= 4.0
    band = ax.collections[0].get_paths()[0].vertices
    assert band[band[:, 0] == 3.0, 1].max() == pytest.approx(0.15)  # less than a cell is not seen
    plt.close(ax.figure)


def test_a_basin_that_is_gone_is_zero_but_where_its_attractor_may_have_another_number():
    shares = [[0.5, NAN, NAN], [0.4, NAN, NAN], [NAN, 0.3, NAN], [NAN, 0.2, 0.1], [NAN] * 3]
    ax = ns.plot.erosion_profile(profile_of(shares, [0.0] * 5, safe="each"))
    np.testing.assert_array_equal(
        [line.get_ydata() for line in ax.lines],
        [[0.5, 0.4, NAN, NAN, NAN], [NAN, NAN, 0.3, 0.2, 0.0], [NAN, NAN, 0.0, 0.1, 0.0]],
    )
    plt.close(ax.figure)
