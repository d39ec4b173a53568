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
