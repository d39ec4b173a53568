"""Boundaries (62)-(66): the regimes on both sides of each."""

import numpy as np
import pytest

from nonsmooth import ModelError, OptionError
from nonsmooth.models import snubber_boundaries, snubber_ring

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
