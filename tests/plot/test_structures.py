"""Pictures of linear structures show what the datasets hold."""

import re

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth.structures import Beam, Bearing, campbell, natural_modes, root_locus, shaft


@pytest.fixture(scope="module")
def rotor():
    held = [Bearing([f"{i}x", f"{i}y"], [[2e7, 0.0], [0.0, 1e7]], 5e3) for i in (0, 4)]
    return shaft([Beam(0.25, 0.08)] * 4, bearings=held)


@pytest.fixture(scope="module")
def diagram(rotor):
    return campbell(rotor, np.linspace(0.0, 3000.0, 13), count=4, harmonics=(1.0, 2.0))


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


def curves(ax, colour):
    """Points of all lines of a colour."""
    found = [line.get_xydata() for line in ax.lines if line.get_color() == colour]
    return np.concatenate(found)


def has_point(points, x, y):
    return bool(np.isclose(points, [x, y]).all(axis=1).any())


@pytest.mark.parametrize(("units", "across", "up"), [("rad/s", 1.0, 1.0), ("rpm", 30.0, 0.5)])
def test_a_campbell_diagram_has_every_point_in_the_colour_of_its_whirl(diagram, units, across, up):
    across, up = (across / np.pi, up / np.pi) if units == "rpm" else (across, up)
    ax = ns.plot.campbell(diagram, units=units)
    points = {sense: curves(ax, ns.plot.PALETTE[colour])
              for sense, colour in (("forward", "blue"), ("backward", "vermilion"))}  # fmt: skip
    for i, speed in enumerate(diagram["speed"].values):
        for mode in range(diagram.sizes["mode"]):
            sense = diagram["direction"].values[i, mode]
            if sense in points:
                y = diagram["damped_frequency"].values[i, mode]
                assert has_point(points[sense], speed * across, y * up)
    circles = np.concatenate([each.get_xydata() for each in ax.lines if each.get_marker() == "o"])
    assert len(circles) == diagram.sizes["critical"] >= 4
    circles = circles[np.argsort(circles[:, 0], kind="stable")]
    np.testing.assert_allclose(circles[:, 0], diagram["critical_speed"] * across)
    np.testing.assert_allclose(
        circles[:, 1], diagram["critical_speed"] * diagram["critical_harmonic"] * up
    )
    assert {text.get_text() for text in ax.texts} == {"1X", "2X"}


def test_a_mode_shape_is_deflected_most_at_its_largest_entry(rotor):
    modes = natural_modes(rotor, 500.0, count=3)
    axes = ns.plot.mode_shapes(modes, [1, 3])
    for ax, number in zip(axes, (1, 3), strict=True):
        lines = [line for line in ax.lines if line.get_marker() == "."]
        assert [line.get_label() for line in lines] == ["x", "y"]
        drawn = np.abs([line.get_ydata() for line in lines])
        shape = np.abs(modes["shape"].sel(mode=number).values).reshape(5, 4)[:, :2]
        assert drawn.max() == pytest.approx(1.0)
        # straight along the shaft but for damping, so every node is where its amplitude says
        np.testing.assert_allclose(drawn, (shape / shape.max()).T, atol=0.1)
        assert ax.get_title(loc="left").startswith(f"mode {number}: ")


def test_forward_and_backward_whirl_look_different(rotor):
    """With gyroscopic moments and unequal bearings, modes of both senses are ellipses."""
    modes = natural_modes(rotor, 2000.0, count=4)
    senses = modes["direction"].values.tolist()
    assert {"forward", "backward"} <= set(senses)
    for ax, sense in zip(ns.plot.mode_shapes(modes), senses, strict=True):
        x, y = (line.get_ydata() for line in ax.lines if line.get_marker() == ".")
        k = np.argmax(np.abs(x))
        if sense in ("forward", "backward"):
            assert np.sign(x[k] * y[k]) == (1.0 if sense == "forward" else -1.0)


@pytest.mark.parametrize(
    ("y", "drawn"),
    [(-0.5j, 0.5), (0.5j, -0.5), (0.5, 0.5), (-0.5, -0.5), (-0.5 + 0.1j, -abs(-0.5 + 0.1j))],
)
def test_the_sign_of_a_shape_is_that_a_quarter_of_a_turn_later(rotor, y, drawn):
    """Forward whirl is x = cos t, y = sin t: the real part of (1, -i) exp(it)."""
    modes = natural_modes(rotor, 500.0, count=1).copy(deep=True)
    for turn in (1.0, np.exp(2.0j)):  # the phase of a shape means nothing
        modes["shape"][:] = 0.0
        modes["shape"].loc[{"coordinate": ["2x", "2y"]}] = turn * np.array([[1.0], [y]])
        (ax,) = ns.plot.mode_shapes(modes)
        lines = {line.get_label(): line.get_ydata()[2] for line in ax.lines[1:]}
        assert lines == pytest.approx({"x": 1.0, "y": drawn}, abs=1e-12)


def test_coordinates_without_directions_are_drawn_in_their_order():
    chain = ns.Structure(np.eye(3), 2 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1))
    (ax,) = ns.plot.mode_shapes(natural_modes(chain), 2)
    assert ax.get_xlabel() == "coordinate"
    values = next(line for line in ax.lines if line.get_marker() == ".").get_ydata()
    np.testing.assert_allclose(np.abs(values), [1.0, 0.0, 1.0], atol=1e-12)


def test_amplitude_and_phase_of_an_unbalance_response(rotor):
    found = ns.structures.unbalance_response(rotor, np.linspace(1.0, 900.0, 50), (2, 1e-3))
    above, below = ns.plot.unbalance_response(found, "2y")
    np.testing.assert_array_equal(
        above.lines[0].get_ydata(), found["amplitude"].sel(coordinate="2y")
    )
    phase = np.radians(below.lines[0].get_ydata())
    turned = np.exp(1j * phase) * found["amplitude"].sel(coordinate="2y").values
    np.testing.assert_allclose(turned, found["displacement"].sel(coordinate="2y"), rtol=1e-12)
    (polar,) = ns.plot.unbalance_response(found, "2y", kind="polar")
    path = next(line for line in polar.lines if line.get_label() == "2y").get_xydata()
    np.testing.assert_array_equal(path @ [1.0, 1.0j], found["displacement"].sel(coordinate="2y"))


@pytest.mark.parametrize("size", [1.05e-2, 1.05e-5, 1.0])
def test_both_axes_of_a_polar_plot_have_one_unit(size):
    """Numbers along x reach just beyond a power of ten, those along y do not."""
    speeds = np.linspace(19.0, 21.0, 40)
    path = size * (np.linspace(-1.0, 0.0, 40) - 0.1j * np.cos(speeds))
    found = xr.Dataset(
        {"displacement": (("speed", "coordinate"), path[:, None])},
        {"speed": ("speed", speeds, {"units": "rad/s"}), "coordinate": ["1x"]},
    )
    found["amplitude"] = abs(found["displacement"])
    (ax,) = ns.plot.unbalance_response(found, kind="polar")
    ax.figure.draw_without_rendering()
    units = [label[label.index("[") :] for label in (ax.get_xlabel(), ax.get_ylabel())]
    assert units[0] == units[1]
    power = re.search(r"\^\{(-?\d+)\}", units[0])
    factor = 10.0 ** int(power[1]) if power else 1.0
    for axis in (ax.xaxis, ax.yaxis):  # numbers times the power are the places
        texts = [t.get_text().replace("\N{MINUS SIGN}", "-") for t in axis.get_ticklabels()]
        np.testing.assert_allclose(
            [float(text) * factor for text in texts], axis.get_ticklocs(), atol=1e-6 * size
        )


def test_a_frequency_response_has_a_curve_for_each_pair(rotor):
    found = ns.structures.frequency_response(rotor, [10.0, 100.0, 1000.0], inputs=["1x", "2x"])
    above, _ = ns.plot.frequency_response(found, ["1x", "3x"], "2x")
    assert [line.get_label() for line in above.lines] == ["1x over 2x", "3x over 2x"]
    expected = found["amplitude"].sel(output="3x", input="2x")
    np.testing.assert_array_equal(above.lines[1].get_ydata(), expected)
    with pytest.raises(ns.OptionError, match="outputs: 6 pairs with inputs; at most 4"):
        ns.plot.frequency_response(found, ["1x", "2x", "3x"], ["1x", "2x"])


def test_a_root_locus_shows_every_path_and_the_border(rotor):
    found = root_locus(rotor, np.linspace(0.0, 900.0, 7), count=3)
    ax = ns.plot.root_locus(found)
    segments = np.array(ax.collections[0].get_segments())
    values = found["eigenvalue"].values
    assert len(segments) == 6 * 3
    assert has_point(segments[:, 0], values[2, 1].real, values[2, 1].imag)
    low, high = ax.get_xlim()
    assert low < 0.0 < high


@pytest.mark.parametrize("speeds", [0.0, [0.0, 200.0]])
def test_a_reduced_model_is_drawn_beside_the_full_one(rotor, speeds):
    small = ns.structures.reduce(rotor, ["2x", "2y"], frequency_range=(0.0, 3000.0), speeds=speeds)
    estimate = small.estimate
    ax = ns.plot.reduction(estimate, coordinate="2y")
    lines = [line.get_ydata() for line in ax.lines]
    assert len(lines) == 2 * estimate.sizes["speed"]
    assert ax.get_ylabel() == "receptance at 2y [m/N]"
    for i in range(estimate.sizes["speed"]):
        for name, line in zip(("full", "reduced"), lines[2 * i : 2 * i + 2], strict=True):
            assert np.array_equal(line, estimate[name].sel(coordinate="2y")[i])
    ax = ns.plot.reduction(estimate, show="error")
    assert np.array_equal(ax.lines[-1].get_ydata(), estimate["error"][-1])
    with pytest.raises(ns.OptionError, match="'5x' is not in the estimate: 2x, 2y"):
        ns.plot.reduction(estimate, coordinate="5x")
    with pytest.raises(ns.OptionError, match="it has no 'full'"):
        ns.plot.reduction(estimate.drop_vars("full"))


@pytest.mark.parametrize("highest", [30.0, 900.0])
def test_names_of_multiples_of_the_speed_do_not_overlap(highest):
    disc = ns.Structure([[2, 0], [0, 2]], [[800, 0], [0, 900]], coordinates=["1x", "1y"])
    speeds = np.linspace(0.0, highest, 11)
    orders = [0.48, 0.5, 1.0, 2.0, 3.0]
    ax = ns.plot.campbell(ns.structures.campbell(disc, speeds, harmonics=orders))
    ax.figure.canvas.draw()
    names = [text for text in ax.texts if text.get_text().endswith("X")]
    boxes = [text.get_window_extent() for text in names]
    assert len(boxes) == len(orders)
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])


def test_the_receptance_of_an_angle_has_its_own_unit(rotor):
    small = ns.structures.reduce(rotor, ["2y", "2rx"], frequency_range=(0.0, 3000.0))
    ax = ns.plot.reduction(small.estimate, coordinate="2rx")
    assert ax.get_ylabel() == "receptance at 2rx [rad/(N m)]"


@pytest.mark.parametrize("highest", [430.0, 900.0])
@pytest.mark.parametrize("units", ["rad/s", "rpm"])
def test_names_of_multiples_of_the_speed_do_not_lie_on_curves(highest, units):
    held = [Bearing([f"{i}x", f"{i}y"], [[2e7, 0.0], [0.0, 1e7]], 6e3) for i in (0, 12)]
    discs = [ns.structures.Disc.from_geometry(i, 0.07, 0.35) for i in (4, 8)]
    turning = shaft([Beam(0.1, 0.06)] * 12, discs=discs, bearings=held)
    found = campbell(turning, np.linspace(0.0, highest, 16), count=6, harmonics=[1.0, 2.0])
    ax = ns.plot.campbell(found, units=units)
    ax.figure.canvas.draw()
    boxes = [text.get_window_extent() for text in ax.texts]
    assert len(boxes) == 2
    for line in ax.lines:
        path = ax.transData.transform_path(line.get_path()).cleaned(remove_nans=True)
        assert not any(path.intersects_bbox(box, filled=False) for box in boxes)


def test_a_campbell_diagram_of_overdamped_motions_says_so():
    slow = ns.Structure([[1.0]], [[100.0]], damping=[[25.0]])
    with pytest.warns(ns.ResultWarning, match="no mode oscillates"):
        found = campbell(slow, [0.0, 50.0])
    ax = ns.plot.campbell(found)
    assert [text.get_text() for text in ax.texts] == ["no mode oscillates", "1X"]
    assert ax.get_ylim()[1] == 50.0
    assert ns.plot.root_locus(found).get_xlim()[0] < 0.0


@pytest.mark.parametrize("damping", [15.0, 25.0])
def test_a_root_locus_shows_overdamped_motions_on_the_real_axis(damping):
    """x'' + c x' + (100 - p) x = 0: two real eigenvalues, one of which crosses the border."""
    loads = np.linspace(0.0, 150.0, 16)
    found = root_locus(lambda p: ns.Structure([[1.0]], [[100.0 - p]], damping=[[damping]]), loads)
    ax = ns.plot.root_locus(found)
    ends = np.sort(next(line for line in ax.lines if line.get_marker() == "s").get_xdata())
    np.testing.assert_allclose(ends, np.sort(np.roots([1.0, damping, -50.0])), rtol=1e-12)
    assert ax.get_xlim()[1] > ends[1] > 0.0
    # both paths begin where the pair was last, if there was one
    segments = np.array(ax.collections[0].get_segments())
    heights = segments[:, :, 1]
    down = (heights[:, 0] > 0.0) & (heights[:, 1] == 0.0)
    assert down.sum() == (2 if damping == 15.0 else 0)


def test_critical_speeds_of_great_damping_are_pale():
    """One mode of a damping ratio of 0.05, and one of 0.5, whose damped frequency is lower."""
    both = ns.Structure(
        np.eye(2), np.diag([1e4, 4e4]), damping=np.diag([10.0, 200.0]), coordinates=["1x", "2x"]
    )
    found = campbell(both, [0.0, 150.0, 300.0])
    ax = ns.plot.campbell(found)
    marks = {line.get_label(): line for line in ax.lines if line.get_marker() == "o"}
    assert list(marks) == ["critical speed", "critical, damping ratio above 0.2"]
    for line, ratio in zip(marks.values(), (0.05, 0.5), strict=True):
        (at,) = np.flatnonzero(np.isclose(found["critical_damping_ratio"], ratio))
        assert line.get_xdata() == pytest.approx([found["critical_speed"].values[at]])
