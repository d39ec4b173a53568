"""Multipliers: where they are, how they go on along a branch, and what is out of the picture."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.patches import Circle

import nonsmooth as ns
from nonsmooth.plot.multipliers import multiplier_paths, path_pieces


def along(values, special=()):
    """A branch of orbits with these multipliers."""
    points = len(values)
    return xr.Dataset(
        {
            "b": ("point", np.linspace(1.0, 2.0, points), {"long_name": "static force"}),
            "stable": ("point", np.abs(values).max(axis=1) < 1),
            "multipliers": (("point", "multiplier"), values.astype(complex)),
            "special_kind": ("special", np.array([kind for kind, _, _ in special], str)),
            "special_point": ("special", np.array([at for _, at, _ in special], int)),
            "special_multiplier": ("special", np.array([mu for _, _, mu in special], complex)),
        },
        attrs={"parameter": "b"},
    )


def circling(points=60):
    """A pair that turns through a third of a circle while a real one passes -1; in any order."""
    angle = np.linspace(0.5, 2.6, points)
    paths = np.stack(
        [0.8 * np.exp(1j * angle), 0.8 * np.exp(-1j * angle), np.linspace(-0.5, -1.5, points)],
        axis=1,
    )
    random = np.random.default_rng(1)
    return paths, np.stack([row[random.permutation(3)] for row in paths])


def test_paths_are_found_again_in_any_order():
    paths, mixed = circling()
    found = multiplier_paths(mixed)
    order = [int(np.argmin(np.abs(paths[0] - start))) for start in found[0]]
    np.testing.assert_array_equal(found, paths[:, order])


def test_paths_with_gaps():
    """Where an orbit has fewer multipliers, the paths of the others go on."""
    paths, mixed = circling(20)
    gone = (0, 2)
    for path in gone:
        mixed[7:9][np.isin(mixed[7:9], paths[7:9, path])] = np.nan
    found = multiplier_paths(mixed)
    order = [int(np.argmin(np.abs(paths[0] - start))) for start in found[0]]
    wanted = paths[:, order].copy()
    wanted[7:9, [order.index(path) for path in gone]] = np.nan
    np.testing.assert_array_equal(found, wanted)


def test_no_line_across_a_jump():
    values = np.array([[0.5], [0.55], [-3.0], [-3.05]])
    pieces, begin = path_pieces(along(values))
    assert begin.tolist() == [0, 1, 2]
    pieces, begin = path_pieces(along(values, [("grazing", 1, np.nan)]))
    assert begin.tolist() == [0, 2]
    np.testing.assert_array_equal(pieces[1], [[-3.0, 0.0], [-3.05, 0.0]])


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("back", [False, True])
def test_a_pair_meets_on_the_real_axis(sign, back):
    """Roots of z**2 - t z + d: with t**2 = 4 d both are t / 2, between two orbits."""
    d, t = 0.49, sign * np.array([1.0, 1.2, 1.3, 1.5, 1.7])
    values = np.array([np.roots([1.0, -trace, d]) for trace in (t[::-1] if back else t)])
    pieces, begin = path_pieces(along(values))
    assert np.bincount(begin).tolist() == ([2, 2, 4, 2] if not back else [2, 4, 2, 2])
    places = {(x, round(y, 12)) for x, y in pieces.reshape(-1, 2).round(12).tolist()}
    assert (round(sign * 0.7, 12), 0.0) in places
    assert {(x, -y) for x, y in places} == places  # one half of the picture mirrors the other


def test_marks_of_one_kind_in_one_place_are_large(ax):
    """Of real multipliers, and of several flips at -1; a mark in another one's place is nested."""
    _, mixed = circling()
    both = along(mixed, [("flip", 20, -1.0), ("flip", 29, -1.0)])
    ns.plot.multipliers(both, ax=ax)
    (marks,) = [line for line in ax.lines if line.get_gid()]
    assert marks.get_markersize() == 4.5
    assert len(marks.get_xdata()) == 2


def test_paths_fill_the_axes_and_the_circle_is_large():
    """A branch that leaves the picture far: the circle takes half of the width, all of it seen."""
    values = np.stack([np.linspace(-0.5, -30.0, 9), np.linspace(0.5, 20.0, 9)], axis=1)
    ax = ns.plot.multipliers(along(values))
    assert ax.get_xlim() == (-2.0, 2.0)
    ax.figure.draw_without_rendering()
    box, given = ax.get_position(), ax.get_position(original=True)
    assert box.height > 0.85 * given.height and box.width > 0.85 * given.width


@pytest.mark.parametrize("huge", [7.6e12, np.inf])
def test_no_line_to_a_multiplier_without_bound(huge):
    values = np.array([[0.5, 0.1], [0.5, 0.1], [huge, 0.0], [0.5, 0.1], [0.5, 0.1]])
    pieces, begin = path_pieces(along(values))
    assert np.abs(pieces).max() == 0.5
    assert sorted(begin.tolist()) == [0, 0, 1, 2, 3, 3]  # the small one goes on
    assert ns.plot.multipliers(along(values)).get_xlim()[1] == 1.25


def test_an_infinite_multiplier_is_told(ax):
    values = xr.Dataset({"multipliers": ("multiplier", [complex(-np.inf), 0.5 + 0j, np.nan])})
    ns.plot.multipliers(values, ax=ax)
    marks = {line.get_label(): line.get_xydata().tolist() for line in ax.lines}
    (edge,) = marks["beyond, up to inf"]
    assert edge == [ax.get_xlim()[0], 0.0]
    assert marks["inside"] == [[0.5, 0.0]]


def test_a_branch(ax):
    _, mixed = circling()
    flip = ("flip", 29, -1.0)
    torus = ("torus", 3, 0.6 + 0.8j)
    ns.plot.multipliers(along(mixed, [flip, torus, ("bound", 59, np.nan)]), ax=ax)
    (lines,) = ax.collections
    assert len(lines.get_segments()) == 3 * 59
    colours = np.asarray(lines.get_array())
    middles = np.linspace(1.0, 2.0, 60)[:-1] + 0.5 / 59
    np.testing.assert_allclose(np.unique(colours.round(12)), middles, atol=1e-12)
    assert lines.get_clim() == (1.0, 2.0)
    (bar,) = ax.child_axes
    assert bar.get_ylabel() == "static force"
    marks = {line.get_label(): line.get_xydata() for line in ax.lines if line.get_gid()}
    assert set(marks) == {"flip", "torus"}
    np.testing.assert_array_equal(marks["torus"], [[0.6, 0.8], [0.6, -0.8]])


def test_an_orbit(ax):
    """Fixed point of an oscillator with damping: the closed form of its multipliers."""
    system = ns.System(
        states=["x", "v"], period="2*pi/omega", parameters={"omega": 1.3},
        equations={"x": "v", "v": "cos(omega*t) - 0.2*v - x"},
    )  # fmt: skip
    values = np.linalg.eigvals(ns.StroboscopicMap(system).tangent({"x": 0.0}).values)
    ns.plot.multipliers(xr.Dataset({"multipliers": ("multiplier", values.astype(complex))}), ax=ax)
    wanted = np.exp((-0.1 + 1j * np.sqrt(1 - 0.01) * np.array([1, -1])) * 2 * np.pi / 1.3)
    (dots,) = [line for line in ax.lines if line.get_label() == "inside"]
    found = dots.get_xdata() + 1j * dots.get_ydata()
    assert sorted(found, key=np.imag) == pytest.approx(sorted(wanted, key=np.imag), abs=1e-12)
    (circle,) = [patch for patch in ax.patches if isinstance(patch, Circle)]
    assert circle.center == (0.0, 0.0) and circle.radius == 1.0
    assert ax.get_aspect() == 1.0 and ax.get_xlim() == (-1.25, 1.25)


def test_large_and_equal_multipliers(ax):
    """What is beyond the picture stands at its border; what lies on one place is counted."""
    values = np.array([40.0, -1.5, 0.0, 0.0, 0.0, 0.5])
    ns.plot.multipliers(xr.Dataset({"multipliers": ("multiplier", values + 0j)}), ax=ax)
    assert ax.get_xlim() == pytest.approx((-1.68, 3.0)) and ax.get_ylim() == (-1.25, 1.25)
    marks = {line.get_label(): line.get_xydata().tolist() for line in ax.lines}
    assert marks["beyond, up to 40"] == [[3.0, 0.0]]
    assert marks["outside"] == [[-1.5, 0.0]]
    (note,) = ax.texts
    assert (note.get_text(), note.xy) == ("3\N{MULTIPLICATION SIGN}", (0.0, 0.0))
    ns.plot.multipliers(xr.Dataset({"multipliers": ("multiplier", values + 0j)}), radius=50, ax=ax)
    assert ax.get_xlim() == (-50.0, 50.0)


@pytest.mark.parametrize(
    ("data", "options", "text"),
    [
        (xr.Dataset({"x": ("time", [1.0])}), {}, "give it a result of find_orbit"),
        (xr.Dataset({"multipliers": ("multiplier", [1j])}), {"radius": 1.0}, "must be more than 1"),
        (
            xr.Dataset({"multipliers": (("orbit", "multiplier"), [[1j]])}), {},
            r"choose one, such as data.isel\(orbit=0\)",
        ),
    ],
)  # fmt: skip
def test_wrong_options(data, options, text):
    with pytest.raises(ns.OptionError, match=text):
        ns.plot.multipliers(data, **options)


def many_tori(count=80):
    """A branch along which a pair goes round the unit circle, and a torus begins at each point."""
    angle = np.linspace(0.2, 2.9, count)
    pair = np.exp(1j * angle)[:, None] ** np.array([1.0, -1.0])
    return xr.Dataset(
        {
            "p": ("point", angle),
            "stable": ("point", np.ones(count, bool)),
            "multipliers": (("point", "multiplier"), pair),
            "special_kind": ("special", np.array(["torus"] * count)),
            "special_value": ("special", angle),
            "special_point": ("special", np.arange(count)),
            "special_multiplier": ("special", pair[:, 0]),
        },
        attrs={"parameter": "p"},
    )


def test_marks_of_many_tori_do_not_lie_on_each_other():
    ax = ns.plot.multipliers(many_tori())
    (marks,) = [line for line in ax.lines if line.get_gid() == "special torus"]
    figure = ax.figure
    figure.canvas.draw()
    places = ax.transData.transform(marks.get_xydata()) * 72.0 / figure.dpi
    apart = np.hypot(*(places[:, None] - places).transpose(2, 0, 1))
    nearest = apart[~np.eye(len(places), dtype=bool)].min()
    assert nearest > 4.5 and marks.get_markersize() >= 4.0
    # they still reach all around: no gap of more than three marks
    angles = np.sort(np.angle(marks.get_xdata() + 1j * marks.get_ydata()))
    angles = angles[angles > 0.0]
    assert angles[0] < 0.3 and angles[-1] > 2.7 and np.diff(angles).max() < 0.4
