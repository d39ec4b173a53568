"""`erosion_profile`: two wells with a straight border, and an oscillator that runs away."""

import numpy as np
import pytest

import nonsmooth as ns

ROOT = np.sqrt(2.0)


def moving_border():
    """s = x + y goes to 1 above c and to -1 below it, and d = x - y to zero.

    So the border is the line x + y = c, and the attractors are at (1/2, 1/2) and its opposite.
    """
    return ns.System(
        name="moving",
        states=["x", "y"],
        parameters={"c": 0.0},
        period=1.0,
        definitions={"s": "x + y"},
        equations={"x": "(-s + sign(s - c))/2 - x + y", "y": "(-s + sign(s - c))/2 + x - y"},
        describe={"c": "place of the border [m]"},
    )


VALUES = np.array([-0.5, 0.03, 0.55, 0.85, 1.2])
AXES = {"x": np.linspace(-1.9, 1.9, 61), "y": np.linspace(-1.8, 1.8, 64)}


@pytest.fixture(scope="module")
def profile():
    return ns.erosion_profile(moving_border(), "c", VALUES, AXES, samples=40)


def test_distances_over_a_parameter(profile):
    """The distances are (1 -+ c)/sqrt(2); where c is above 1, one attractor is all there is."""
    assert profile["attractor"].values.tolist() == [1, 2]
    left, right = (profile.sel(attractor=k) for k in (1, 2))
    h = profile.attrs["half_diagonal"]
    assert h == pytest.approx(0.5 * np.hypot(3.8 / 60, 3.6 / 63))
    there = VALUES < 1.0
    assert np.all(right["local_integrity"].isnull().values == ~there)
    off = right["local_integrity"].values[there] - (1.0 - VALUES[there]) / ROOT
    assert np.abs(off).max() <= h
    assert right["kind"].values.tolist() == ["periodic"] * 4 + [""]
    # on the other side the end of the region may be nearer than the border
    room = 1.8 + 0.5 * 3.6 / 63 - 0.5
    truth = np.minimum((1.0 + VALUES[there]) / ROOT, room)
    assert np.abs(left["local_integrity"].values[there] - truth).max() <= h


def test_shares_are_those_of_triangles_and_the_rest(profile):
    """The share above the line, from a grid of points 30 times as fine in each direction."""
    x = (np.arange(1800) + 0.5) / 1800 * 2.0 - 1.0
    wide = [1.9 + 0.5 * 3.8 / 60, 1.8 + 0.5 * 3.6 / 63]
    plane = wide[0] * x[None, :] + wide[1] * x[:, None]
    for k, c in enumerate(VALUES[:4]):
        one = profile.isel(parameter=k).sel(attractor=2)
        error = float(one["global_error"])
        assert abs(float(one["global_integrity"]) - np.mean(plane > c)) <= error + 2e-3


def test_labels_have_the_numbers_of_the_profile(profile):
    """The cell in the corner belongs to the attractor beside it, at every value."""
    assert np.all(profile["label"].isel(x=0, y=0).values == 1)
    assert np.all(profile["label"].isel(x=-1, y=-1).values[:4] == 2)
    assert profile["parameter"].attrs["long_name"] == "place of the border [m]"


def test_one_safe_basin_against_escape():
    """x fades where it is less than c in size, and grows without end beyond."""
    system = ns.System(
        states=["x", "y"],
        parameters={"c": 1.0},
        period=1.0,
        equations={"x": "where(abs(x) < c, -x, 2*x)", "y": "-y"},
    )
    axes = {"x": np.linspace(-2.0, 2.0, 81), "y": np.linspace(-3.0, 3.0, 40)}
    values = [1.5, 1.0, 0.6]
    found = ns.erosion_profile(system, "c", values, axes, safe="all", samples=40)
    error = found["local_error"].sel(attractor=1).values
    assert np.all(np.abs(found["local_integrity"].sel(attractor=1).values - values) <= error)
    assert np.all(
        np.abs(found["integrity_factor"].sel(attractor=1) - values) <= found["factor_error"][0]
    )
    share = np.array(values) / (2.0 + 0.025)
    np.testing.assert_allclose(found["ended"], 1.0 - share, atol=0.03)


def test_several_threads_and_a_store_give_the_same(tmp_path, profile):
    store = tmp_path / "store"
    options = {"samples": 40, "threads": 1, "store": store}
    again = ns.erosion_profile(moving_border(), "c", VALUES, AXES, **options)
    assert len(list(store.iterdir())) == VALUES.size
    np.testing.assert_array_equal(again["label"], profile["label"])
    from_store = ns.erosion_profile(moving_border(), "c", VALUES, AXES, **options)
    np.testing.assert_array_equal(from_store["local_integrity"], again["local_integrity"])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"parameter": "k"}, "unknown parameter 'k'"),
        ({"values": []}, "values="),
        ({"region": {"x": (-1.0, 1.0), "y": (-1.0, 1.0)}}, "is a range"),
        ({"safe": "none"}, "safe = 'none'"),
        ({"scales": {"c": 1.0}}, "scales"),
        ({"parameters": {"c": 0.5}}, "counts for nothing"),
    ],
)
def test_wrong_use(change, message):
    given = {"parameter": "c", "values": [0.0, 0.1], "region": AXES} | change
    with pytest.raises(ns.OptionError, match=message):
        ns.erosion_profile(moving_border(), **given)
