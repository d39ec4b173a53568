"""Pictures can be read at print size: legends, numbers along the axes, marks, colours."""

from itertools import combinations, pairwise

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth.errors import OptionError
from nonsmooth.plot.period_colours import LONGER, PERIODS, REGIME_COLOURS

KINDS = ["fold", "flip", "torus", "symmetry_breaking", "branch_point", "grazing", "corner"]

# G. M. Machado et al., A physiologically-based model for simulation of color vision deficiency,
# 2009: linear red, green and blue as they are seen without one kind of cones
SIGHTS = (
    np.eye(3),
    [[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]],
    [[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]],
    [[1.256, -0.077, -0.179], [-0.078, 0.931, 0.148], [0.005, 0.691, 0.304]],
)


def orbits(shift=0.0, kinds=KINDS):
    """A branch with special points of many kinds."""
    p = np.linspace(0.0, 1.0, 101)
    at = np.linspace(0.1, 0.9, len(kinds))
    return xr.Dataset(
        {
            "p": ("point", p),
            "x": ("point", np.sin(3.0 * p) + shift),
            "stable": ("point", p < 0.5),
            "special_kind": ("special", kinds),
            "special_value": ("special", at),
            "special_point": ("special", (100 * at).astype(int)),
        },
        attrs={"parameter": "p"},
    )


def portrait(unit, scale=1.0):
    angle = np.linspace(0.0, 6.0, 50)
    attrs = {"units": unit}
    return xr.Dataset(
        {
            "x": ("time", scale * np.cos(angle), {"long_name": "displacement"} | attrs),
            "v": ("time", scale * np.sin(angle), {"long_name": "velocity"} | attrs),
        }
    )


def basins(count=2, points=None):
    """Basins in stripes, with one point of each attractor in its stripe."""
    label = np.repeat(np.arange(1, count + 1), 4) * np.ones((8, 1), int)
    if points is None:
        points = np.stack([2.0 + 4.0 * np.arange(count), np.full(count, 4.0)], axis=1)[:, None]
    return xr.Dataset(
        {
            "label": (("y", "p"), label),
            "points": (("attractor", "point", "state"), points),
            "period": ("attractor", np.arange(count) + 1),
        },
        {
            "p": np.arange(4.0 * count), "y": np.arange(8.0), "attractor": np.arange(count) + 1,
            "state": ["p", "y"],
        },
    )  # fmt: skip


def legend_texts(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


@pytest.mark.few(1)
@pytest.mark.parametrize(("rows", "columns", "width"), [(1, 1, 8.5), (2, 2, 17.0), (2, 2, 8.5)])
def test_long_legends_leave_room_and_stay_inside(rows, columns, width):
    figure, axes = ns.plot.print_figure(rows, columns, width=width)
    for ax in axes:
        ns.plot.branch({f"period {k}": orbits(k) for k in range(1, 7)}, "x", ax=ax)
    figure.draw_without_rendering()
    for ax in axes:
        legend, inside = ax.get_legend().get_window_extent(), ax.get_window_extent()
        assert legend.y0 >= inside.y1 - 1.0 and legend.y1 <= figure.bbox.y1 + 1.0
        assert legend.x1 <= inside.x1 + 0.05 * inside.width
        assert inside.height > legend.height


def test_a_figure_of_our_own_grows_for_all_entries():
    ax = ns.plot.branch({f"period {k}, with {k} impacts": orbits(k) for k in range(1, 8)}, "x")
    ax.figure.draw_without_rendering()
    assert len(legend_texts(ax)) == 2 + 7 + len(KINDS)
    assert ax.get_window_extent().height > ax.get_legend().get_window_extent().height
    ax = ns.plot.basins(basins(12))
    assert len(legend_texts(ax)) == 12


@pytest.mark.few(3)
@pytest.mark.parametrize("scale", [1.0, 0.0123, 1.23e-4, 1.23e-6, 12345.0, 1e9])
@pytest.mark.parametrize("width", [4.5, 8.5, 17.0])
def test_numbers_along_axes_do_not_touch_each_other_or_the_label(scale, width):
    figure, (ax,) = ns.plot.print_figure(width=width, height=5.0)
    ns.plot.section(portrait("m", scale), "x", "v", ax=ax)
    figure.draw_without_rendering()
    low, high = ax.get_xlim()
    shown = [t for t in ax.xaxis.get_major_ticks() if low <= t.get_loc() <= high]
    boxes = [tick.label1.get_window_extent() for tick in shown]
    assert len(boxes) >= 2
    assert all(a.x1 < b.x0 for a, b in pairwise(boxes))
    assert all(len(tick.label1.get_text()) <= 6 for tick in shown)
    assert ax.xaxis.get_offset_text().get_text() == ""


def test_a_power_of_ten_is_written_once_and_follows_the_range():
    figure, (ax,) = ns.plot.print_figure()
    ns.plot.section(portrait("m", 1e-6), "x", "v", ax=ax)
    for _ in range(2):
        figure.draw_without_rendering()
    assert ax.get_xlabel() == "displacement [$10^{-6}$ m]"
    ax.set_xlim(0.0, 1.0)
    figure.draw_without_rendering()
    assert ax.get_xlabel() == "displacement [m]"
    ax.set_xlabel("x")
    ax.set_xlim(0.0, 1e-9)
    figure.draw_without_rendering()
    assert ax.get_xlabel() == "x [$10^{-9}$]"


def test_attractors_outside_the_picture_are_noted():
    points = np.array([[[2.0, 4.0], [90.0, 4.0]], [[50.0, 4.0], [60.0, 4.0]]])
    texts = [text.replace("\n", " ") for text in legend_texts(ns.plot.basins(basins(2, points)))]
    assert [text.partition(" %, ")[2] for text in texts] == ["partly outside", "outside"]
    assert not any("outside" in text for text in legend_texts(ns.plot.basins(basins())))


def test_a_shape_means_one_period():
    lines = ns.plot.basins(basins(12)).lines
    assert len({str(line.get_marker()) for line in lines}) == 12


def test_marks_close_to_each_other_are_smaller():
    far = ns.plot.basins(basins()).lines[0].get_markersize()
    points = np.array([[[4.0, 4.0]], [[4.1, 4.0]]])
    near = ns.plot.basins(basins(2, points)).lines[0].get_markersize()
    assert 2.0 < near < far


def test_special_points_in_one_place_are_all_seen():
    both = orbits(kinds=["fold", "grazing"])
    both["special_value"][:], both["special_point"][:] = 0.5, 50
    ax = ns.plot.branch(both, "x")
    sizes = [line.get_markersize() for line in ax.lines if "special" in str(line.get_gid())]
    assert sizes[1] < 0.8 * sizes[0]


def test_folds_of_constructions_that_are_no_motions_do_not_look_real():
    some = orbits(kinds=["fold", "fold"])
    some["admissible"] = some["p"] < 0.5
    ax = ns.plot.branch(some, "x")
    marks = {str(line.get_gid()): line for line in ax.lines if "special" in str(line.get_gid())}
    assert list(marks) == ["special fold", "special fold, inadmissible"]
    faces = [line.get_markerfacecolor() for line in marks.values()]
    assert faces[1] == "0.85" != faces[0]
    assert "fold, inadmissible" in legend_texts(ax)


def apart(one, other):
    """Distance of two colours in OKLab for the sight that tells them least."""
    return min(np.linalg.norm(oklab(one, sight) - oklab(other, sight)) for sight in SIGHTS)


def test_a_longer_period_is_darker_with_every_kind_of_colour_vision():
    scale = [*PERIODS.values(), LONGER]
    for sight in SIGHTS:
        lightness = [oklab(colour, sight)[0] for colour in scale]
        assert all(after < before - 0.02 for before, after in pairwise(lightness))


def test_regimes_are_told_apart_with_every_kind_of_colour_vision():
    """Two hundredths in OKLab are seen side by side; the bounds are more than twice that.

    A scale from light to dark has a length, which its colours share: neighbours are nearer to each
    other than colours of any order would be, and steps of doubled periods the longest.
    """
    doubled = {frozenset((f"period {n}", f"period {2 * n}")) for n in range(1, 5)}
    regimes = {name for name in REGIME_COLOURS if not name.startswith("period")}
    for one, other in combinations(REGIME_COLOURS, 2):
        found = apart(REGIME_COLOURS[one], REGIME_COLOURS[other])
        if "chaotic" in (one, other):
            assert found > 0.34, (one, other)
        elif frozenset((one, other)) in doubled:
            assert found > 0.12, (one, other)
        elif {one, other} & regimes:
            assert found > 0.07, (one, other)
        else:
            assert found > 0.05, (one, other)
    settled = [name for name in REGIME_COLOURS if name not in ("unsettled", "chaotic")]
    assert min(apart(REGIME_COLOURS["unsettled"], REGIME_COLOURS[k]) for k in settled) > 0.09
    assert min(apart(colour, "#FFFFFF") for colour in REGIME_COLOURS.values()) > 0.1


def oklab(colour, sight):
    """B. Ottosson, A perceptual color space for image processing, 2020."""
    rgb = np.array([int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)])
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    cones = np.array([[0.412, 0.536, 0.051], [0.212, 0.681, 0.107], [0.088, 0.282, 0.630]])
    axes = [[0.210, 0.794, -0.004], [1.978, -2.429, 0.451], [0.026, 0.783, -0.809]]
    return axes @ np.cbrt(cones @ np.clip(sight @ linear, 0.0, 1.0))


def columns_of_legend(legend):
    """Texts of each column, from left to right."""
    legend.figure.draw_without_rendering()
    places = {}
    for text in legend.get_texts():
        places.setdefault(round(text.get_window_extent().x0), []).append(text.get_text())
    return [places[x] for x in sorted(places)]


def test_entries_of_one_sort_have_columns_of_their_own():
    _, (ax,) = ns.plot.print_figure(width=12.0)
    some = orbits(kinds=["fold", "flip", "fold"])
    some["admissible"] = some["p"] < 0.7
    ns.plot.branch({f"a = 0.{k}": some for k in range(1, 5)}, "x", ax=ax)
    assert columns_of_legend(ax.get_legend()) == [
        ["stable", "unstable", "inadmissible"],
        ["a = 0.1", "a = 0.2", "a = 0.3", "a = 0.4"],
        ["fold", "flip", "fold, inadmissible"],
    ]


def test_negative_numbers_in_legends_have_the_sign_of_those_along_the_axes():
    _, (ax,) = ns.plot.print_figure()
    for label in ("-0.05 ± 0.01", "F = -2 N", "stick-slip", "b -c", "$-1$"):
        ax.plot([0.0, 1.0], label=label)
    ns.plot.place_legend(ax)
    found = [text.replace("\N{MINUS SIGN}", "minus ") for text in legend_texts(ax)]
    assert found == ["minus 0.05 ± 0.01", "F = minus 2 N", "stick-slip", "b -c", "$-1$"]


def test_lines_of_spectra_are_seen_below_the_marks_of_the_harmonics():
    """Most of each line lies in the gaps between the dashes."""
    spectra = ns.waterfall(
        ns.models.soft_impact(), "omega", [0.7, 0.8], "x", transient=50, record=16
    )
    for kind in ("cascade", "map"):
        _, (ax,) = ns.plot.print_figure()
        ns.plot.waterfall(spectra, kind=kind, over="harmonic", ax=ax)
        marks = [line for line in ax.lines if line.get_linestyle() == "--"]
        assert len(marks) == 5
        for line in marks:
            _, (dash, gap) = line._unscaled_dash_pattern
            assert gap >= 2.0 * dash


def test_a_long_legend_is_broad_and_not_high():
    kinds = ["fold", "flip", "torus", "symmetry_breaking", "grazing", "crossing_sliding",
             "grazing_sliding", "switching_sliding", "sliding", "bound"]  # fmt: skip
    ax = ns.plot.branch(orbits(kinds=kinds), "x")
    assert max(map(len, columns_of_legend(ax.get_legend()))) <= 6
    legend, inside = ax.get_legend().get_window_extent(), ax.get_window_extent()
    assert legend.height < 0.5 * inside.height


def test_a_legend_of_a_figure_names_each_thing_once():
    figure, axes = ns.plot.print_figure(1, 2, width=17.0)
    for ax in axes:
        ns.plot.branch(orbits(), "x", ax=ax, legend=False)
    ns.plot.place_legend(figure)
    (legend,) = figure.legends
    words = [kind.replace("_", " ") for kind in KINDS]
    assert [text for column in columns_of_legend(legend) for text in column] == [
        "stable",
        "unstable",
        *words,
    ]
    top = max(ax.get_window_extent().y1 for ax in axes)
    assert legend.get_window_extent().y0 >= top - 1.0


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["a rather long name of what stands on this axis", "n_" * 30])
@pytest.mark.parametrize(("rows", "width"), [(1, 8.0), (2, 17.0)])
def test_labels_of_axes_are_not_cut(name, rows, width):
    figure, axes = ns.plot.print_figure(rows, rows, width=width)
    data = portrait("m")
    for variable in ("x", "v"):
        data[variable].attrs["long_name"] = name
    for ax in axes:
        ns.plot.section(data, "x", "v", ax=ax)
    figure.draw_without_rendering()
    for ax in axes:
        across, up = ax.xaxis.label.get_window_extent(), ax.yaxis.label.get_window_extent()
        assert across.x0 >= 0.0 and across.x1 <= figure.bbox.x1
        assert up.y0 >= 0.0 and up.y1 <= figure.bbox.y1


@pytest.mark.parametrize(
    ("units", "shown"),
    [("A_b", "$A_{b}$"), ("1/omega_Ls", r"1/$\omega_{Ls}$"), ("mm/s", "mm/s")],
)
def test_units_with_an_index(units, shown):
    assert ns.plot.section(portrait(units), "x", "v").get_xlabel() == f"displacement [{shown}]"


def test_axes_without_a_number_say_so():
    data = portrait("m")
    assert not ns.plot.section(data, "x", "v").texts
    (text,) = ns.plot.section(data * np.nan, "x", "v").texts
    assert text.get_text() == "no finite values to draw"


def test_curves_of_a_caller_are_told_apart_with_every_kind_of_colour_vision():
    _, (ax,) = ns.plot.print_figure()
    colours = [ax.plot([0.0, 1.0])[0].get_color() for _ in range(6)]
    for one, other in combinations(colours, 2):
        apart = [np.linalg.norm(oklab(one, sight) - oklab(other, sight)) for sight in SIGHTS]
        assert min(apart) > 0.06, (one, other)


def test_no_cells_are_refused():
    with pytest.raises(OptionError, match="no cells to draw"):
        ns.plot.basins(basins().isel(p=slice(0, 0)))


@pytest.mark.parametrize("name", ["displacement [mm]", "displacement of the outer ring [mm]"])
def test_the_label_of_a_bar_of_colours_is_not_cut(name):
    """In figures of a column's width, whose axes are lower than the label is long."""
    spring = ns.System(
        states=["x", "v"],
        parameters={"w": 1.5},
        period="2*pi/w",
        equations={"x": "v", "v": "cos(w*t) - 0.5*v - x"},
        describe={"x": name},
    )
    spectra = ns.waterfall(spring, "w", [0.8, 1.2], "x", transient=30, record=8)
    ax = ns.plot.waterfall(spectra, kind="map", over="harmonic")
    figure = ax.get_figure()
    bar = figure.axes[1]
    figure.canvas.draw()
    label = bar.yaxis.label.get_window_extent()
    assert figure.bbox.y0 <= label.y0 and label.y1 <= figure.bbox.y1
    assert label.x1 <= figure.bbox.x1
    assert bar.get_ylabel().replace("\n", " ") == f"amplitude of the {name}"
