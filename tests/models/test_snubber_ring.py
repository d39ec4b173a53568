"""The snubber ring against quartics to thirty digits, energy minimisation, invariants."""

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from models import ring_truth
from nonsmooth import NonsmoothError, OptionError
from nonsmooth.models import snubber_boundaries, snubber_ring

PRELOADS = [(0.1, 0.1), (0.05, 0.3), (0.4, 0.02), (0.0, 0.2), (0.0, 0.0)]
K, NU2 = 30.0, 0.002


def positions(count, delta_x, delta_y, seed):
    """Half of them anywhere, half of them near the corner, where all regimes meet."""
    rng = np.random.default_rng(seed)
    radius, angle = rng.uniform(0.9, 2.5, count), rng.uniform(0.0, 2.0 * np.pi, count)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    preload = np.hypot(delta_x, delta_y)
    if preload > 0.0:
        half = slice(count // 2)
        signs = rng.choice([-1.0, 1.0], (2, count // 2))
        growth = 1.0 + 1.0 / preload
        x[half] = signs[0] * (delta_x * growth + rng.uniform(-0.3, 0.3, count // 2))
        y[half] = signs[1] * (delta_y * growth + rng.uniform(-0.3, 0.3, count // 2))
    return x, y, *rng.uniform(-3.0, 3.0, (2, count))


@pytest.mark.slow
@pytest.mark.parametrize(("delta_x", "delta_y"), PRELOADS)
def test_against_quartics_to_thirty_digits(delta_x, delta_y):
    """2000 random positions with velocities for each preload, 10,000 in all."""
    x, y, vx, vy = positions(2000, delta_x, delta_y, seed=6)
    ring = snubber_ring(x, y, vx, vy, K=K, nu2=NU2, delta_x=delta_x, delta_y=delta_y)
    names = ("sx", "sy", "ring_vx", "ring_vy", "force_x", "force_y", "energy")
    found = np.stack([ring[name].values for name in names], axis=1)
    worst, seen = 0.0, set()
    for i in range(x.size):
        truth = ring_truth.ring(x[i], y[i], delta_x, delta_y, vx[i], vy[i])
        if ring_truth.to_boundary(x[i], y[i], delta_x, delta_y, truth) <= 1e-9:
            continue
        assert truth.regime == ring["regime"].values[i], (x[i], y[i])
        force = ring_truth.force(truth, K, NU2, delta_x, delta_y)
        energy = ring_truth.energy(truth, K, delta_x, delta_y)
        expected = (truth.sx, truth.sy, truth.vx, truth.vy, *force, energy)
        assert max(float(value.rad()) for value in expected) < 1e-28
        errors = [
            abs(float(a - ring_truth.number(b))) for a, b in zip(expected, found[i], strict=True)
        ]
        worst = max(worst, *errors)
        seen.add(truth.regime)
    assert worst < 1e-12
    contact = {(True, True): {2, 3, 4, 5}, (False, True): {3, 5}, (False, False): {5}}
    assert seen == {1} | contact[delta_x > 0, delta_y > 0]


@pytest.mark.parametrize(("delta_x", "delta_y"), PRELOADS)
def test_energy_is_the_least(delta_x, delta_y):
    """scipy turns the normal until the springs of Eqs. (55)-(60) hold the least energy."""

    def energy(angle, x, y):
        s = np.abs([x - np.cos(angle), y - np.sin(angle)])
        delta = np.array([delta_x, delta_y])
        inner = np.minimum(s, delta)
        return K * np.sum(inner**2 + (s - inner) * (s + 3.0 * delta) / 2.0)

    x, y, _, _ = positions(60, delta_x, delta_y, seed=1)
    ring = snubber_ring(x, y, K=K, delta_x=delta_x, delta_y=delta_y)
    for i in np.flatnonzero(np.hypot(x, y) > 1.0):
        start = np.arctan2(y[i], x[i])
        best = minimize(
            lambda p, i=i: energy(p[0], x[i], y[i]), [start], method="Nelder-Mead",
            options={"xatol": 1e-11, "fatol": 1e-16},
        )  # fmt: skip
        assert abs(best.fun - float(ring["energy"][i])) < 1e-7
        angle = float(ring["contact_angle"][i])
        # a minimum is flat: its place is known to the root of the rounding of the energy
        assert abs(np.exp(1j * angle) - np.exp(1j * best.x[0])) < 1e-7


coordinate = st.floats(-5.0, 5.0)
preload = st.sampled_from([0.0, 1e-3, 0.1, 0.7])


@given(coordinate, coordinate, coordinate, coordinate, preload, preload)
def test_symmetries(x, y, vx, vy, delta_x, delta_y):
    """Reflections and an exchange of the axes turn the ring with the rotor, to the last digit."""
    ring = snubber_ring(x, y, vx, vy, delta_x=delta_x, delta_y=delta_y)
    turned = snubber_ring(-x, y, -vx, vy, delta_x=delta_x, delta_y=delta_y)
    swapped = snubber_ring(y, x, vy, vx, delta_x=delta_y, delta_y=delta_x)
    for name in ("sx", "force_x", "ring_vx"):
        assert ring[name] == -turned[name]
        assert float(ring[name]) == pytest.approx(float(swapped[name.replace("x", "y")]), abs=1e-12)
    for name in ("sy", "force_y", "energy", "regime", "mu"):
        assert ring[name] == turned[name]
    assert int(swapped["regime"]) == [1, 2, 4, 3, 5][int(ring["regime"]) - 1]


@given(coordinate, coordinate, coordinate, coordinate, preload, preload)
def test_distance_stays_the_gap(x, y, vx, vy, delta_x, delta_y):
    """|r - s| = 1 and (r - s).(v - s') = 0 in contact; the ring never comes before the rotor."""
    ring = snubber_ring(x, y, vx, vy, delta_x=delta_x, delta_y=delta_y)
    dx, dy = x - float(ring["sx"]), y - float(ring["sy"])
    if ring["regime"] == 1:
        assert np.hypot(x, y) < 1.0
        names = ("sx", "sy", "mu", "force", "energy", "ring_vx", "ring_vy")
        assert all(float(ring[name]) == 0.0 for name in names)
        return
    assert np.hypot(dx, dy) == pytest.approx(1.0, abs=4e-16 * (1.0 + abs(x) + abs(y)))
    apart = dx * (vx - float(ring["ring_vx"])) + dy * (vy - float(ring["ring_vy"]))
    assert abs(apart) < 1e-14 * (1.0 + abs(vx) + abs(vy)) * (1.0 + abs(x) + abs(y))
    assert abs(float(ring["sx"])) <= abs(x)
    assert abs(float(ring["sy"])) <= abs(y)
    assert float(ring["mu"]) >= 0.0


@pytest.mark.parametrize(("delta_x", "delta_y"), PRELOADS)
def test_continuous_across_boundaries(delta_x, delta_y):
    """Positions 1e-9 apart on both sides have rings 1e-9 apart; velocities may jump."""
    curves = snubber_boundaries(delta_x=delta_x, delta_y=delta_y, extent=3.0, points=31)
    x, y = curves["x"].values.ravel(), curves["y"].values.ravel()
    step = 5e-10
    for turn in (0.3, 1.9):
        sides = [
            snubber_ring(
                x + sign * step * np.cos(turn), y + sign * step * np.sin(turn),
                delta_x=delta_x, delta_y=delta_y,
            )
            for sign in (-1.0, 1.0)
        ]  # fmt: skip
        for name, scale in (("sx", 1.0), ("sy", 1.0), ("force", 4 * K), ("energy", 8 * K)):
            jump = np.abs(sides[0][name] - sides[1][name]).max()
            assert float(jump) < 3e-9 * scale, name


def test_static_force_is_along_the_normal():
    x, y, _, _ = positions(500, 0.05, 0.3, seed=2)
    ring = snubber_ring(x, y, K=7.0, delta_x=0.05, delta_y=0.3)
    assert np.allclose(ring["normal_force"], ring["force"], rtol=1e-14)
    assert np.allclose(ring["force"], 7.0 * ring["mu"], rtol=1e-14)


def test_a_rotor_that_leaves_is_told_by_the_normal_force():
    """Just in contact and fast outwards: the dampers would have to pull the rotor."""
    ring = snubber_ring([1.0001, 1.0001], [0.0, 0.0], [-50.0, 50.0], [0.0, 0.0])
    assert ring["normal_force"][0] < 0.0 < ring["normal_force"][1]
    assert float(ring["ring_vx"][0]) == pytest.approx(-50.0, rel=1e-15)
    # both dampers act within the preload: 2 K s + 4 nu2 v
    assert float(ring["force_x"][1]) == pytest.approx(60 * 1e-4 + 0.008 * 50.0, rel=1e-11)


def test_shapes_labels_and_flags(tmp_path):
    grid = snubber_ring(np.linspace(-2, 2, 5)[:, None], np.linspace(-2, 2, 7))
    assert grid["sx"].dims == ("axis_0", "axis_1")
    assert grid["x"].shape == (5, 7)
    assert grid["regime"].attrs["flag_meanings"] == "I II III IV V"
    assert grid["force"].attrs["units"] == "dimensionless"
    assert all(variable.attrs.get("long_name") for variable in grid.variables.values())
    grid.to_netcdf(tmp_path / "ring.nc")
    assert snubber_ring(1.5, 0.2)["sx"].dims == ()


def test_data_arrays_keep_their_dimensions():
    x = xr.DataArray([1.2, 1.3], dims="time", coords={"time": [0.0, 0.5]}, name="x")
    y = xr.DataArray([0.1, 0.2, 0.3], dims="lane", name="y")
    ring = snubber_ring(x, y)
    assert ring["sx"].dims == ("time", "lane")
    assert list(ring["time"]) == [0.0, 0.5]
    plain = snubber_ring(x.values[:, None], y.values)
    assert np.array_equal(ring["force"], plain["force"])


def test_far_away_and_close_to_touching():
    """Newton's method ends far out too, and the force begins at zero."""
    far = snubber_ring(1e8, 1e8, delta_x=0.1, delta_y=2e8)
    assert int(far["regime"]) == 3
    dx, dy = 1e8 - float(far["sx"]), 1e8 - float(far["sy"])
    assert np.hypot(dx, dy) == pytest.approx(1.0, abs=3e-8)
    assert float(snubber_ring(1.0, 0.0)["force"]) == 0.0
    assert int(snubber_ring(1.0, 0.0)["regime"]) == 2
    assert int(snubber_ring(np.nextafter(1.0, 0.0), 0.0)["regime"]) == 1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"delta_x": -0.1}, "delta_x = -0.1 must not be negative"),
        ({"delta_y": float("nan")}, "delta_y = nan is not a finite number"),
        ({"K": 0.0}, "K = 0 must be positive"),
        ({"K": "stiff"}, "K = 'stiff' is not a finite number"),
        ({"nu2": -1.0}, "nu2 = -1 must not be negative"),
    ],
)
def test_rings_that_do_not_exist(options, message):
    with pytest.raises(NonsmoothError, match=message):
        snubber_ring(1.5, 0.0, **options)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([1.0, np.nan], 0.0), "x = nan is not a finite number"),
        ((1.0, "a"), "y = 'a' is not a finite number"),
        ((1.0 + 1j, 0.0), r"x = \(1\+1j\) is a complex number"),
        (([1.0, 2.0], [1.0, 2.0, 3.0]), r"shapes cannot be broadcast: x \(2,\), y \(3,\)"),
        ((1.0, 0.0, 1.0), "one velocity only"),
        ((xr.DataArray([1.0], dims="t"), [1.0, 2.0]), "has no dimensions"),
        ((xr.DataArray([1.0], dims="x"), 1.0), "would have the names of the positions"),
    ],
)
def test_positions_that_cannot_be(arguments, message):
    with pytest.raises(OptionError, match=message):
        snubber_ring(*arguments)
