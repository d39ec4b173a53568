"""No period is told of a motion that may yet settle to a shorter one.

The response of a linear oscillator has the period of its forcing, whatever the damping. While it
settles, it turns by nearly 2 pi/p per strobe at many frequencies, and seems to repeat after p.
"""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.statistics.periodicity import primitive_period, scales, settled_periods

NONE = np.zeros(2, bool)


def linear(z):
    """x'' + 2 z x' + x = cos(omega t)."""
    return ns.System(
        states=["x", "v"],
        parameters={"omega": 3.0, "z": z},
        period="2*pi/omega",
        equations={"x": "v", "v": "cos(omega*t) - x - 2*z*v"},
    )


@pytest.mark.parametrize(("z", "transient"), [(0.02, 355), (0.035, 200), (0.035, 240), (0.1, 60)])
def test_a_linear_oscillator_has_period_one_or_none_yet(z, transient):
    grid = np.linspace(1.9, 3.4, 301)
    found = ns.bifurcation_diagram(linear(z), "omega", grid, transient=transient)
    assert set(np.unique(found["period"])) <= {0, 1}
    open_yet = int((found["period"] == 0).sum())
    assert 0 < open_yet < grid.size
    assert f"{open_yet} of 301 motions have not settled" in found.attrs["message"]
    settled = ns.bifurcation_diagram(linear(z), "omega", grid[::20], transient=round(40 / z))
    assert np.all(settled["period"] == 1)


def spirals(count, seed):
    """Strobes of linear oscillators in closed form, most near a multiplier exp(2 pi i j/p), from
    their steady states.

    shape: (count, 101, 2)
    """
    rng = np.random.default_rng(seed)
    p = rng.integers(1, 12, count)
    turns = rng.integers(0, p + 1) / p
    turns += rng.normal(size=count) * 10.0 ** rng.uniform(-7.0, -1.5, count)
    decay = 10.0 ** rng.uniform(-3.5, -0.3, count)
    size = 10.0 ** rng.uniform(-9.0, -1.0, count)
    k = np.arange(101)
    z = size[:, None] * np.exp((2j * np.pi * turns - decay)[:, None] * k)
    z *= np.exp(2j * np.pi * rng.uniform(size=(count, 1)))
    # position and velocity of different sizes
    return np.stack([z.real, z.imag * rng.uniform(0.3, 3.0, (count, 1))], axis=2)


def test_spirals_near_every_root_of_unity():
    points = 1.0 + spirals(20_000, 1)
    assert set(np.unique(settled_periods(points, NONE, 1e-6))) == {0, 1}
    # the same points do repeat to the accuracy asked for: that alone is no period
    alone = [primitive_period(one, NONE, scales(one, NONE), 1e-6) for one in points[:2000]]
    assert np.count_nonzero(np.array(alone) > 1) > 40


def test_two_modes_of_which_the_fast_one_hides_the_slow_one():
    rng = np.random.default_rng(5)
    turn = np.linalg.qr(rng.normal(size=(20_000, 4, 4)))[0]
    both = np.concatenate([spirals(20_000, 2), spirals(20_000, 3)], axis=2)
    points = 1.0 + np.einsum("mij,mkj->mki", turn, both)
    assert set(np.unique(settled_periods(points, np.zeros(4, bool), 1e-6))) == {0, 1}


def logistic(r, transient):
    x = np.empty(transient + 101)
    x[0] = 0.3
    for k in range(x.size - 1):
        x[k + 1] = r * x[k] * (1.0 - x[k])
    return x[transient:]


@pytest.mark.parametrize(
    ("r", "period"),
    # R. M. May, Nature 261 (1976) 459: doublings at 3, 3.4495, 3.5441; period 3 from 3.8284
    [(2.9, 1), (3.05, 2), (3.2, 2), (3.4, 2), (3.46, 4), (3.5, 4), (3.55, 8), (3.83, 3), (3.9, 0)],
)
@pytest.mark.parametrize("drift", [0.0, 0.7])
def test_true_periods_keep_their_label(r, period, drift):
    x = logistic(r, 300)
    points = np.column_stack([x, drift * np.arange(x.size) + x])[None]
    drifting = np.array([False, drift > 0.0])
    assert settled_periods(points, drifting, 1e-6).tolist() == [period]


@pytest.mark.parametrize("transient", [4500, 9000])
def test_a_regime_is_not_told_from_a_motion_on_its_way(transient):
    """After 4500 strobes the spiral of omega = 3 repeats after three of them to 1e-6."""
    found = ns.regime(linear(0.001), transient=transient, longest=transient)
    assert (found["regime"].item(), found["period"].item()) == ("unsettled", 0)
    found = ns.regime(linear(0.001), transient=transient)
    assert (found["regime"].item(), found["period"].item()) == ("periodic", 1)
