import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth import OptionError
from nonsmooth.analysis.regimes.labels import LABELS


def grid(codes, periods):
    """A map of some labels, by their words, and periods."""
    codes = np.array([[LABELS.index(word) for word in row] for row in codes], np.int8)
    flags = {"flag_values": np.arange(len(LABELS)), "flag_meanings": " ".join(LABELS)}
    return xr.Dataset(
        {"regime": (("b", "a"), codes, flags), "period": (("b", "a"), np.array(periods))},
        {
            "a": ("a", np.arange(codes.shape[1], dtype=float), {"long_name": "force"}),
            "b": ("b", np.arange(codes.shape[0]) ** 2.0, {"long_name": "speed"}),
        },
    )


def entries(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def test_legend_and_axes():
    ax = ns.plot.regime_map(
        grid(
            [["periodic", "periodic", "chaotic"], ["periodic", "absorbed", "unsettled"]],
            [[2, 12, 0], [1, 0, 0]],
        )
    )
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("force", "speed")
    assert entries(ax) == ["period 1", "period 2", "period > 8", "chaotic", "absorbed", "unsettled"]
    mesh = ax.collections[0]
    colours = mesh.cmap(mesh.norm(mesh.get_array()))
    assert len({tuple(colour) for row in colours for colour in row}) == 6
    assert ax.get_xlim() == (-0.5, 2.5)
    assert ns.plot.regime_map(grid([["chaotic"]], [[0]]), legend=False).get_legend() is None


def test_what_ended_early_is_hatched():
    words = ["diverged", "sliding", "refused", "interrupted", "periodic"]
    ax = ns.plot.regime_map(grid([words], [[0, 0, 0, 0, 1]]))
    assert entries(ax) == ["period 1", "ended early", "refused", "interrupted"]
    assert [len(patch.get_path().vertices) // 5 for patch in ax.patches] == [2, 1, 1]
    assert len({patch.get_hatch() for patch in ax.patches}) == 3


def test_every_entry_has_room():
    words = [*["periodic"] * 10, *LABELS]
    ax = ns.plot.regime_map(grid([words], [[*range(1, 11), *[3] * len(LABELS)]]))
    ax.figure.canvas.draw()
    box = ax.get_legend().get_window_extent()
    assert box.y0 >= 0.0
    assert box.x1 <= ax.figure.bbox.x1
    assert min(text.get_fontsize() for text in ax.get_legend().get_texts()) >= 5.5


def test_large_maps_stay_small(tmp_path):
    rows = [["periodic", "chaotic", "refused", "locked"] * 40] * 120
    ax = ns.plot.regime_map(grid(rows, [[1, 0, 0, 1] * 40] * 120))
    ns.plot.save_figure(ax.figure, tmp_path / "a.pdf")
    assert (tmp_path / "a.pdf").stat().st_size < 500_000


@pytest.mark.parametrize("broken", ["variable", "flags"])
def test_what_is_no_map(broken):
    data = grid([["chaotic"]], [[0]])
    if broken == "variable":
        data = data.drop_vars("regime")
    else:
        data["regime"].attrs = {}
    with pytest.raises(OptionError, match="regime"):
        ns.plot.regime_map(data)


def test_any_quantity_can_be_drawn():
    grid = ns.regime_map(
        ns.models.soft_impact(), {"omega": [0.78, 0.82, 0.86], "zeta": [0.02, 0.05]},
        transient=200, evidence=40,
    )  # fmt: skip
    ax = ns.plot.regime_map(grid, quantity="exponent")
    (mesh,) = ax.collections
    np.testing.assert_array_equal(mesh.get_array().ravel(), grid["exponent"].values.ravel())
    with pytest.raises(ns.OptionError, match="unknown quantity 'colour'"):
        ns.plot.regime_map(grid, quantity="colour")
