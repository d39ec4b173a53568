"""Boundaries (62)-(66): the regimes on both sides of each, and the equations as printed."""

import numpy as np
import pytest

from nonsmooth import ModelError, OptionError
from nonsmooth.models import snubber_boundaries, snubber_ring
from nonsmooth.models.snubber_tables import boundary_curve

PRELOADS = [(0.1, 0.1), (0.05, 0.3), (0.4, 0.02), (0.0, 0.2), (0.2, 0.0), (0.0, 0.0)]


def normals(x, y):
    """Unit normals of a curve at the middles of its pieces, and these middles."""
    dx, dy = np.diff(x), np.diff(y)
    length = np.hypot(dx, dy)
    return 0.5 * (x[1:] + x[:-1]), 0.5 * (y[1:] + y[:-1]), -dy / length, dx / length


@pytest.mark.parametrize(("delta_x", "delta_y"), PRELOADS)
def test_regimes_on_both_sides(delta_x, delta_y):
    """A step of 1e-6 to either side of each curve, the ends where others begin left out."""
    curves = snubber_boundaries(delta_x=delta_x, delta_y=delta_y, extent=3.0, points=20001)
    for number in range(curves.sizes["curve"]):
        curve = curves.isel(curve=number)
        x, y, across, up = (v[20:-20:50] for v in normals(curve["x"].values, curve["y"].values))
        found = [
            snubber_ring(
                x + sign * 1e-6 * across, y + sign * 1e-6 * up, delta_x=delta_x, delta_y=delta_y
            )["regime"].values
            for sign in (-1.0, 1.0)
        ]
        sides = {int(curve["inner"]), int(curve["outer"])}
        assert {int(v) for v in np.concatenate(found)} == sides, int(curve["equation"])
        assert all(len(set(side.tolist())) == 1 for side in found)


@pytest.mark.parametrize(("delta_x", "delta_y"), PRELOADS[:3])
def test_equations_as_printed(delta_x, delta_y):
    """In the first quadrant each curve obeys its equation; they end or begin at the corner."""
    curves = snubber_boundaries(delta_x=delta_x, delta_y=delta_y, extent=3.0)
    growth = 1.0 + 1.0 / np.hypot(delta_x, delta_y)
    corner = np.array([delta_x, delta_y]) * growth
    for number in range(curves.sizes["curve"]):
        curve = curves.isel(curve=number)
        equation = int(curve["equation"])
        x, y = curve["x"].values, curve["y"].values
        here = (x > 1e-12) & (y > 1e-12)
        if equation == 62:
            assert np.allclose(np.hypot(x, y), 1.0, rtol=1e-15)
            continue
        if not here.any():
            continue
        given, other = (x, y) if equation in (63, 66) else (y, x)
        expected = boundary_curve(equation, given[here], delta_x=delta_x, delta_y=delta_y)
        # where the curve meets its axis at a right angle the root of a rounded zero is left
        assert np.allclose(other[here], expected, atol=2e-7, rtol=1e-9)
        steep = other[here] > 0.3 * corner.min()
        assert np.allclose(other[here][steep], expected[steep], rtol=1e-10)
        assert np.hypot(x[here] - corner[0], y[here] - corner[1]).min() < 1e-14


def test_the_printed_equations_hold_on_one_side_of_the_corner_only():
    """Beyond the corner (63) goes on inside IV, where the springs in y have one side left."""
    corner = 0.1 * (1.0 + 1.0 / np.hypot(0.1, 0.1))
    x = corner - 0.05  # smaller x: y is beyond that of the corner
    y = float(boundary_curve(63, x))
    assert y > corner
    around = snubber_ring([x - 1e-6, x + 1e-6], [y, y])
    assert around["regime"].values.tolist() == [4, 4]


def test_number_and_names_of_curves():
    curves = snubber_boundaries(delta_x=0.1, delta_y=0.0)
    assert sorted(curves["equation"].values.tolist()) == [62, 66, 66, 66, 66]
    assert int(curves["outer"][0]) == 4  # contact begins with one spring in y
    assert curves["outer"].attrs["flag_meanings"] == "I II III IV V"
    assert curves["x"].attrs["units"] == "dimensionless"


def test_symmetric_in_the_plane():
    curves = snubber_boundaries(delta_x=0.05, delta_y=0.3)
    for equation in (63, 64, 65, 66):
        here = (curves["equation"] == equation).values
        points = {
            tuple(np.round(p, 12) + 0.0)
            for p in zip(
                curves["x"].values[here].ravel(), curves["y"].values[here].ravel(), strict=True
            )
        }
        assert points == {(-x + 0.0, y) for x, y in points} == {(x, -y + 0.0) for x, y in points}


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"delta_x": -0.1}, ModelError, "delta_x"),
        ({"extent": 1.1}, OptionError, "not be below 1.14142"),
        ({"extent": np.inf}, OptionError, "finite"),
        ({"points": 2}, OptionError, "points = 2"),
        ({"points": True}, OptionError, "points = True"),
    ],
)
def test_bad_input(options, error, message):
    with pytest.raises(error, match=message):
        snubber_boundaries(**options)
