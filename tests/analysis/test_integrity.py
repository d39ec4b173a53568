"""Integrity of basins whose borders are lines and circles, and of two wells over a parameter."""

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import nonsmooth as ns

SIDE = 4.0


def labelled(inside, counts, point, low=(0.0, 0.0), spread=(SIDE, SIDE)):
    """Basins as `basins_of_attraction` gives them: label 1 where a function says so, else 2."""
    axes = [low[k] + spread[k] * (np.arange(count) + 0.5) / count for k, count in enumerate(counts)]
    x, y = np.meshgrid(*axes)
    return xr.Dataset(
        {
            "label": (("y", "x"), np.where(inside(x, y), 1, 2)),
            "points": (("attractor", "point", "state"), np.array([[point], [point]], float)),
            "period": ("attractor", [1, 1]),
            "kind": ("attractor", ["periodic", "periodic"]),
        },
        {"x": axes[0], "y": axes[1], "attractor": [1, 2], "state": ["x", "y"]},
    )


def region_room(point):
    """Distance of a point from the end of the square."""
    return min(*point, SIDE - point[0], SIDE - point[1])


@pytest.mark.slow
@given(
    st.floats(0.0, 2.0 * np.pi),
    st.floats(0.2, 2.0),
    st.floats(1.0, 3.0),
    st.floats(1.0, 3.0),
    st.integers(20, 60),
    st.integers(20, 60),
)
def test_a_straight_border_is_as_far_as_it_is(angle, far, x, y, across, up):
    """The ball around a point ends at the line or at the end of the square."""
    normal = np.array([np.cos(angle), np.sin(angle)])
    offset = normal @ [x, y] + far

    def inside(a, b):
        return normal[0] * a + normal[1] * b < offset

    basins = labelled(inside, (across, up), (x, y))
    found = ns.integrity(basins).sel(attractor=1)
    h = 0.5 * np.hypot(SIDE / across, SIDE / up)
    assert float(found["local_error"]) == pytest.approx(h)
    truth = min(far, region_room((x, y)))
    assert abs(float(found["local_integrity"]) - truth) <= h + 1e-12
    # the share of the half plane in the square, from a grid that is 20 times as fine
    fine = (np.arange(1200) + 0.5) / 1200 * SIDE
    share = inside(*np.meshgrid(fine, fine)).mean()
    error = float(found["global_error"])
    assert abs(float(found["global_integrity"]) - share) <= error + 4.0 / 1200


@pytest.mark.slow
@given(st.floats(0.5, 1.2), st.floats(1.6, 2.4), st.floats(1.6, 2.4), st.integers(30, 90))
def test_the_largest_ball_in_a_disc_is_the_disc(radius, x, y, count):
    point = (x + 0.3 * radius, y)
    basins = labelled(lambda a, b: np.hypot(a - x, b - y) < radius, (count, count + 3), point)
    found = ns.integrity(basins).sel(attractor=1)
    assert abs(float(found["integrity_factor"]) - radius) <= float(found["factor_error"])
    assert abs(float(found["local_integrity"]) - 0.7 * radius) <= float(found["local_error"])
    centre = found["factor_centre"].values
    # a ball that is smaller by the error may lie off the middle by as much
    assert np.hypot(*(centre - [x, y])) <= 2.0 * float(found["factor_error"])
    area = np.pi * radius**2 / SIDE**2
    assert abs(float(found["global_integrity"]) - area) <= float(found["global_error"])


def test_errors_shrink_with_the_cells():
    errors = []
    for count in (40, 80, 160, 320):
        basins = labelled(lambda a, b: a + b < 5.0, (count, count), (1.5, 1.5))
        found = ns.integrity(basins).sel(attractor=1)
        off = abs(float(found["local_integrity"]) - 2.0 / np.sqrt(2.0))
        assert off <= float(found["local_error"])
        errors.append(float(found["local_error"]))
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 2.0)


def test_scales_divide_states():
    """With y counted in tens, a border at y = 3 is a tenth as far as one at x = 3."""
    basins = labelled(lambda a, b: (a < 3.0) & (b < 3.0), (80, 80), (1.5, 1.5))
    plain = ns.integrity(basins).sel(attractor=1)
    assert float(plain["local_integrity"]) == pytest.approx(1.5, abs=float(plain["local_error"]))
    scaled = ns.integrity(basins, scales={"y": 10.0}).sel(attractor=1)
    error = float(scaled["local_error"])
    assert error == pytest.approx(0.5 * np.hypot(0.05, 0.005))
    assert float(scaled["local_integrity"]) == pytest.approx(0.15, abs=error)


def test_attractors_whose_basins_count_as_one():
    basins = labelled(lambda a, b: a < 2.0, (40, 40), (1.2, 2.0))
    alone, both = ns.integrity(basins), ns.integrity(basins, safe=[1, 2])
    assert float(both["global_integrity"][0]) == pytest.approx(1.0, abs=1e-12)
    assert float(alone["global_integrity"][0]) == pytest.approx(0.5, abs=1e-12)
    assert both["local_limit"].values.tolist() == ["region", "region"]
    assert alone["local_limit"].values.tolist()[0] == "border"
    # attractor 2 has the same point, which lies in the basin of attractor 1
    assert float(alone["local_integrity"][1]) == 0.0


def test_attractors_outside_the_region_and_sections():
    basins = labelled(lambda a, b: a < 2.0, (40, 40), (5.0, 2.0))
    found = ns.integrity(basins)
    assert np.isnan(found["local_integrity"]).all()
    assert set(found["local_limit"].values) == {"outside"}
    assert float(found["integrity_factor"][0]) == pytest.approx(1.0, abs=0.1)
    points = np.concatenate([basins["points"].values, np.zeros((2, 1, 1))], axis=2)
    more = basins.drop_vars(["points", "state"]).assign(
        points=(("attractor", "point", "state"), points)
    )
    more = more.assign_coords(state=["x", "y", "q"])
    assert "leaves out q" in ns.integrity(more).attrs["message"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"basins": np.ones((3, 3), int)}, "basins"),
        ({"safe": [3]}, "safe = "),
        ({"safe": 1}, "safe = "),
        ({"scales": {"z": 1.0}}, "scales"),
        ({"scales": {"x": 0.0}}, "must be positive"),
    ],
)
def test_wrong_use(change, message):
    basins = labelled(lambda a, b: a < 2.0, (20, 20), (1.0, 1.0))
    with pytest.raises(ns.OptionError, match=message):
        ns.integrity(**{"basins": basins} | change)


TURN = 2.0 * np.pi


def pendulum():
    return ns.System(
        states=["x", "y"],
        parameters={"T": 0.8, "m": 0.42},
        drift={"x": "2*pi"},
        period="2*pi/1.5",
        equations={"x": "y", "y": "T*cos(1.5*t) + m - 0.2*y - sin(x)"},
    )


@pytest.mark.parametrize("low", [-np.pi, 0.0, 2.5])
@pytest.mark.parametrize("turns", [-1, 0, 3])
def test_a_border_across_the_end_of_a_turn(low, turns):
    """A strip around 3 with straight borders at 2 and 4, wherever the cells of the turn begin."""
    point = (3.0 + TURN * turns, 1.0)
    basins = labelled(
        lambda x, y: np.cos(x - 3.0) > np.cos(1.0), (90, 60), point, (low, -1.0), (TURN, 4.0)
    ).assign_attrs(system=pendulum().to_toml())
    found = ns.integrity(basins).sel(attractor=1)
    assert found["local_limit"].item() == "border"
    assert abs(float(found["local_integrity"]) - 1.0) <= float(found["local_error"])
    assert abs(float(found["integrity_factor"]) - 1.0) <= float(found["factor_error"])
    assert abs(float(found["global_integrity"]) - 2.0 / TURN) <= float(found["global_error"])
    # two borders, each with a column of cells on either side, of which there are 90
    assert float(found["global_error"]) == pytest.approx(4.0 / 90)


def test_a_part_of_a_turn_has_an_end():
    basins = labelled(
        lambda x, y: np.cos(x - 3.0) > np.cos(1.0), (90, 60), (3.0 + TURN, 1.0), (0.0, -1.0),
        (3.5, 4.0),
    ).assign_attrs(system=pendulum().to_toml())  # fmt: skip
    found = ns.integrity(basins).sel(attractor=1)
    assert found["local_limit"].item() == "region"
    # the end is where it is, so the half diagonal that is taken off is all there is, to rounding
    assert abs(float(found["local_integrity"]) - 0.5) <= float(found["local_error"]) + 1e-12


@pytest.mark.slow
def test_profiles_do_not_depend_on_where_a_turn_begins():
    """The same cells, but for whole turns of some of them, and the same motions."""
    y = np.linspace(-2.0, 3.0, 8)
    found = []
    for first in (0, 5):
        x = -np.pi + TURN / 12 * (first + np.arange(12))
        found.append(ns.erosion_profile(pendulum(), "m", [0.40, 0.42], {"x": x, "y": y}))
    one, other = found
    assert np.isfinite(one["local_integrity"].values[:, :2]).all()
    for name in ("local_integrity", "local_error", "global_integrity", "integrity_factor"):
        assert np.allclose(one[name], other[name], rtol=0.0, atol=1e-12, equal_nan=True), name
