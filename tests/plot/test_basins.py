from itertools import pairwise

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex

import nonsmooth as ns
from nonsmooth import OptionError
from nonsmooth.plot.period_colours import NOT_SETTLED, PERIODS


def basins(label, across=None, up=None, points=(), periods=(), kinds=()):
    """A result with labels over y and p, and attractors with points in p, y and a drift."""
    label = np.asarray(label)
    rows, columns = label.shape
    width = max((len(each) for each in points), default=0)
    values = np.full((len(points), width, 3), np.nan)
    for k, each in enumerate(points):
        values[k, : len(each), :2] = each
    data = {
        "label": (("y", "p"), label.astype(np.int16)),
        "points": (("attractor", "point", "state"), values),
        "period": ("attractor", np.array(periods, int)),
        "kind": ("attractor", np.array(kinds, str)),
    }
    coords = {
        "p": ("p", np.arange(columns) if across is None else across, {"long_name": "place"}),
        "y": ("y", np.arange(rows) if up is None else up, {"units": "mm/s"}),
        "attractor": np.arange(1, len(points) + 1),
        "state": ["p", "y", "v"],
    }
    return xr.Dataset(data, coords)


LABEL = [[1, 1, 2, 2, -2], [1, 0, 2, -1, -2], [1, 1, 1, 2, -2]]


def example(**options):
    chaos = np.random.default_rng(0).uniform([2, 0], [3, 1], (30, 2))
    given = {
        "points": [[[0, 0], [1, 2]], chaos],
        "periods": [2, 0],
        "kinds": ["periodic", "chaotic"],
    }
    return basins(LABEL, **given | options)


def cell_colours(ax):
    """Colours of the cells as they are drawn."""
    (image,) = [*ax.images, *ax.collections]
    rgb = image.to_rgba(np.asarray(image.get_array()).reshape(-1))
    return np.array([to_hex(colour) for colour in rgb])


def key(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


@pytest.mark.parametrize("across", [None, [0.0, 1.0, 2.0, 4.0, 8.0]])
def test_every_cell_has_the_colour_of_its_label(across):
    ax = ns.plot.basins(example(across=across))
    colours = cell_colours(ax)
    labels = np.ravel(LABEL)
    assert len(set(colours)) == 5
    for label in np.unique(labels):
        assert len(set(colours[labels == label])) == 1
    assert set(colours[labels == 0]) == {"#ffffff"}


def test_cells_stand_around_their_starts():
    ax = ns.plot.basins(example(across=[1.0, 1.5, 2.0, 2.5, 3.0], up=[-1.0, 0.0, 1.0]))
    assert ax.images[0].get_extent() == pytest.approx([0.75, 3.25, -1.5, 1.5])
    assert ax.images[0].origin == "lower"
    assert (*ax.get_xlim(), *ax.get_ylim()) == pytest.approx((0.75, 3.25, -1.5, 1.5))
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("place", "y [mm/s]")


def test_attractors_stand_in_their_basins():
    data = example()
    ax = ns.plot.basins(data)
    first, second = ax.lines
    assert np.array_equal(first.get_xydata(), [[0, 0], [1, 2]])
    assert np.array_equal(second.get_xydata(), data["points"].values[1, :, :2])
    assert (first.get_marker(), second.get_marker()) == ("s", "o")
    assert first.get_markersize() > 2 * second.get_markersize()
    assert not ns.plot.basins(data, attractors=False).lines


def test_points_outside_the_region_do_not_widen_it():
    data = example(points=[[[50, 50], [1, 2]], [[0, 0]]])
    assert ns.plot.basins(data).get_xlim() == pytest.approx((-0.5, 4.5))


def test_the_key_says_kinds_and_fractions():
    texts = key(ns.plot.basins(example()))
    assert texts == [
        "1: period 2, 50.0 %",
        "2: chaotic, 33.3 %",
        "unsettled, 8.3 %",
        "ended early, 8.3 %",
        "inadmissible",
    ]
    given = example().assign(fraction=("attractor", [0.6, 0.004]))
    assert key(ns.plot.basins(given))[:2] == ["1: period 2, 60.0 %", "2: chaotic, 0.40 %"]
    assert ns.plot.basins(given, legend=False).get_legend() is None


def test_cells_left_out_by_an_interruption():
    data = basins([[1, 1, -3], [1, 2, -2]])
    ax = ns.plot.basins(data)
    assert key(ax) == ["1: 75.0 %", "2: 25.0 %", "inadmissible", "not computed"]
    assert len(set(cell_colours(ax))) == 4


@pytest.mark.slow
def test_a_result_as_it_comes():
    """Labels, attractors and measures of one computation agree."""
    system = ns.models.duffing()
    region = {"x": np.linspace(-2, 2, 16), "v": np.linspace(-1, 2, 18)}
    data = ns.basins_of_attraction(system, region, samples=30)
    ax = ns.plot.basins(data)
    assert ax.images[0].get_array().shape == data["label"].shape == (18, 16)
    assert ax.get_xlabel() == ns.plot.axis_label(data["x"])
    shares = ns.basin_fractions(data)
    numbers = data["attractor"].values
    assert shares["fraction"].sel(label=numbers).values == pytest.approx(data["fraction"].values)
    assert ns.uncertainty_exponent(data).attrs["system_name"] == "duffing"
    assert len(ns.plot.attractors(data, "x", "v").lines) == numbers.size


def test_labels_alone_are_enough():
    data = basins(LABEL).drop_dims(["attractor", "state"], errors="ignore")[["label"]]
    assert key(ns.plot.basins(data))[0] == "1: 50.0 %"


@pytest.mark.slow
def test_seven_hues_and_more():
    numbers = np.arange(1, 22).reshape(3, 7)
    assert len(set(cell_colours(ns.plot.basins(basins(numbers))))) == 21
    many = basins(np.arange(1, 121).reshape(10, 12))
    ax = ns.plot.basins(many)
    assert key(ax)[-1].endswith("more")
    ax.figure.canvas.draw()
    box = ax.get_window_extent().width / ax.get_window_extent().height
    assert 0.8 < box < 2.5  # the key makes the picture taller, and the axes no smaller


def test_the_key_fits_beside_other_axes():
    figure, axes = ns.plot.print_figure(1, 2, width=16.0)
    height = figure.get_figheight()
    ns.plot.basins(example(), ax=axes[0])
    figure.canvas.draw()
    assert figure.get_figheight() == height
    assert axes[0].get_legend().get_window_extent().x1 < axes[1].get_window_extent().x0


@pytest.mark.slow
def test_a_million_cells_stay_small(tmp_path):
    across = np.linspace(-1.5, 1.5, 1000)
    z = across[None, :] + 1j * across[:, None]
    for _ in range(12):
        z = z - (z**3 - 1) / (3 * z**2)
    root = 1 + np.abs(z[..., None] - np.exp(2j * np.pi * np.arange(3) / 3)).argmin(-1)
    ax = ns.plot.basins(basins(root, across, across))
    for name in ("a.pdf", "a.png"):
        ns.plot.save_figure(ax.figure, tmp_path / name)
        assert (tmp_path / name).stat().st_size < 300_000


def test_attractors_over_two_states():
    data = example()
    ax = ns.plot.attractors(data)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("place", "y [mm/s]")
    assert [line.get_label() for line in ax.lines] == key(ax) == ["1: period 2", "2: chaotic"]
    assert np.array_equal(ax.lines[0].get_xydata(), [[0, 0], [1, 2]])
    turned = ns.plot.attractors(data, "y", "p")
    assert np.array_equal(turned.lines[0].get_xydata(), [[0, 0], [2, 1]])
    shades = [
        [line.get_markerfacecolor() for line in draw(data).lines]
        for draw in (ns.plot.attractors, ns.plot.basins)
    ]
    assert shades[0] == shades[1]


def test_the_state_of_a_section_is_not_drawn():
    """Up to rounding it is the same in all points; x and z are drawn, not x and y."""
    points = np.random.default_rng(0).uniform(-1, 1, (1, 30, 3))
    points[:, :, 1] = 1e-13 * points[:, :, 1]
    data = xr.Dataset(
        {"points": (("attractor", "point", "state"), points), "period": ("attractor", [0])},
        {"attractor": [1], "state": ["x", "y", "z"]},
    )
    ax = ns.plot.attractors(data)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x", "z")
    ax = ns.plot.attractors(data.isel(point=[0]))  # one point: no state differs
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x", "y")


def test_labels_of_states_come_from_the_system():
    data = example().drop_vars(["p", "y"])
    data.attrs["system"] = ns.models.moling().to_toml()
    expected = ns.plot.axis_label(ns.simulate(ns.models.moling(), periods=1)["p"])
    assert ns.plot.attractors(data).get_xlabel().replace("\n", " ") == expected


def test_the_curve_of_an_exponent():
    label = np.ones((128, 128), int)
    label[:, 64:] = 2
    found = ns.uncertainty_exponent(label)
    ax = ns.plot.uncertainty(found)
    points, rest, line = ax.lines
    assert points.get_xdata().tolist() == found["distance"].values.tolist()
    assert points.get_ydata() == pytest.approx(found["uncertain_fraction"].values)
    assert len(rest.get_xdata()) == 0
    assert line.get_ydata() == pytest.approx(found["fit"].values)
    assert line.get_label().startswith(r"$\alpha$ = 1.000")


def test_curves_of_dimensions():
    points = np.random.default_rng(0).random((3000, 2))
    for verb, values in (
        (ns.box_dimension, "boxes"),
        (ns.correlation_dimension, "correlation_sum"),
    ):
        found = verb(points)
        ax = ns.plot.uncertainty(found)
        full, empty, _ = ax.lines
        fitted = found["fitted"].values
        assert full.get_ydata() == pytest.approx(found[values].values[fitted])
        assert len(empty.get_xdata()) == np.count_nonzero(~fitted & (found[values] > 0))


def test_one_outcome_gives_an_empty_curve():
    ax = ns.plot.uncertainty(ns.uncertainty_exponent(np.ones((32, 32), int)))
    ax.figure.canvas.draw()
    assert ax.get_legend() is None


def test_what_is_no_result():
    data = xr.Dataset({"x": ("time", [1.0])})
    for draw, message in (
        (ns.plot.basins, "no 'label'"),
        (ns.plot.attractors, "no points"),
        (ns.plot.uncertainty, "no curve"),
    ):
        with pytest.raises(OptionError, match=message):
            draw(data)
    with pytest.raises(OptionError, match="unknown state 'z'"):
        ns.plot.attractors(example(), "z")


@pytest.mark.few(1)
@pytest.mark.parametrize("side", [16, 40, 200, 1000])
def test_distances_are_written_out_and_do_not_collide(side):
    halves = np.ones((side, side), int)
    halves[:, side // 2 :] = 2
    ax = ns.plot.uncertainty(ns.uncertainty_exponent(halves))
    ax.figure.canvas.draw()
    labels = [label for label in ax.get_xticklabels() if label.get_text()]
    assert [label.get_text() for label in labels][:2] == ["1", "2"]
    assert not any(label.get_text() for label in ax.get_xticklabels(minor=True))
    boxes = [label.get_window_extent() for label in labels]
    assert len(boxes) >= 2
    assert all(a.x1 < b.x0 for a, b in pairwise(boxes))
    assert ("points only" in ax.get_legend().get_texts()[0].get_text()) == (side <= 40)


def test_colours_of_periods_are_those_of_the_map():
    """Two attractors of one period have one colour; without a period the kind decides."""
    data = basins(
        [[1, 2, 3, 4, 0]],
        points=[[(0, 0)], [(1, 0)], [(2, 0), (2.2, 0)], [(3, 0)]],
        periods=[1, 2, 2, 0],
        kinds=["periodic", "periodic", "periodic", "chaotic"],
    )
    ax = ns.plot.basins(data, colour="period")
    (image,) = ax.images
    shown = [to_hex(colour).upper() for colour in image.cmap(image.norm(image.get_array()))[0]]
    assert shown == [PERIODS[1], PERIODS[2], PERIODS[2], "#000000", NOT_SETTLED]
    with pytest.raises(OptionError, match="unknown choice 'kind'"):
        ns.plot.basins(data, colour="kind")


def test_basins_of_one_colour_have_a_border():
    data = basins(
        [[1, 1, 2], [1, 2, 2]], points=[[[0, 0]], [[2, 1]]], periods=[1, 1],
        kinds=["periodic", "periodic"],
    )  # fmt: skip

    def borders(ax):
        return [each for each in ax.collections if each.get_gid() == "borders within a colour"]

    (lines,) = borders(ns.plot.basins(data, colour="period"))
    drawn = {tuple(map(tuple, each.tolist())) for each in lines.get_segments()}
    assert drawn == {
        ((1.5, -0.5), (1.5, 0.5)), ((0.5, 0.5), (0.5, 1.5)), ((0.5, 0.5), (1.5, 0.5)),
    }  # fmt: skip
    assert not borders(ns.plot.basins(data))
