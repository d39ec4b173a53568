"""Rounding keeps the points of a settled cycle apart; that is no way to a shorter period.

Strobes in SI units may be small where the motion between them is large. Their rounding then lies
far above one unit in the last place, and does not contract however long the motion goes on.
"""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from analysis.test_periods_while_settling import spirals
from nonsmooth.analysis.statistics.periodicity import settled_periods

NONE = np.zeros(2, bool)


def noisy_cycles(count, p, kept, noise, rng, length=101):
    """Settled motions near cycles of p different points, with an error made anew at each strobe of
    which a part ``kept`` is left at the next one.

    shape: (count, length, 2)
    """
    cycle = rng.uniform(-1.0, 1.0, (count, p, 2))
    cycle /= np.abs(cycle).max(axis=1, keepdims=True)
    error = np.zeros((count, length + 2000, 2))
    made = noise * rng.uniform(-1.0, 1.0, error.shape)
    for before, k in pairwise(range(error.shape[1])):
        error[:, k] = kept * error[:, before] + made[:, k]
    return cycle[:, np.arange(length) % p] + error[:, -length:]


@pytest.mark.few(8)
@pytest.mark.parametrize("p", [2, 3, 7, 24])
@pytest.mark.parametrize("kept", [0.0, 0.7, -0.7])
@pytest.mark.parametrize("noise", [1e-14, 3e-12, 1e-10])
def test_a_cycle_with_noise_has_its_period(p, kept, noise):
    points = noisy_cycles(300, p, kept, noise, np.random.default_rng(p))
    found = settled_periods(points, NONE, 1e-6)
    # with four periods in the record, chance may look like a way: rarely
    assert np.mean(found == p) > (0.99 if p < 24 else 0.95)
    assert set(np.unique(found)) <= {0, p}
    points[:, :, 1] += 0.7 * np.arange(points.shape[1])
    found = settled_periods(points, np.array([False, True]), 1e-6)
    assert np.mean(found == p) > (0.99 if p < 24 else 0.95)


@pytest.mark.parametrize("noise", [1e-12, 1e-10])
def test_noise_hides_no_slow_spiral(noise):
    points = 1.0 + spirals(20_000, 6)
    points += noise * np.random.default_rng(7).uniform(-1.0, 1.0, points.shape)
    assert set(np.unique(settled_periods(points, NONE, 1e-6))) == {0, 1}


def test_a_slow_oscillation_is_not_at_rest_at_its_turning_point():
    """Near its largest value a position hardly moves: the velocity tells that it does."""
    k = np.arange(101) - 50
    z = 1e-3 * np.exp(1j * (np.pi + 1e-6) * k)
    points = 1.0 + np.stack([z.real, z.imag], axis=1)
    assert settled_periods(points[None], NONE, 1e-6).tolist() == [0]


GEAR = {
    "m": 0.8, "c": 12.0, "k": 2.0e5, "half": 1.0e-4, "T": 30.0, "A": 45.0, "n": 39.45, "mu": 2.5,
}  # fmt: skip


def gear(**values):
    """A loaded pair of gears that rattles in its backlash, with dry friction, in SI units."""
    return ns.System(
        states=["u", "w"],
        parameters=GEAR | values,
        period="1/n",
        surfaces={"rub": ns.Surface("w")},
        equations={
            "u": "w",
            "w": "(T + A*cos(2*pi*n*t) - c*w - k*(u - clip(u, -half, half)) - mu*sign(rub))/m",
        },
    )


def strobes_by_quadrature(periods):
    """Strobes of the same gears by DOP853, from one smooth piece to the next."""
    m, c, k, half, load, a, n, mu = GEAR.values()
    t, y, sign, side, found = 0.0, np.array([8e-4, 1e-3]), 1.0, 1, []

    def force(t, u, side):
        return load + a * np.cos(2.0 * np.pi * n * t) - abs(side) * k * (u - side * half)

    def guards(sign, side):
        """Functions that fall through zero where the piece ends, what u or w is there, and what
        follows."""
        yield lambda t, y: sign * y[1], 1, 0.0, -sign, side
        if side:
            yield lambda t, y: side * y[0] - half, 0, side * half, sign, 0
        else:
            yield lambda t, y: half - y[0], 0, half, sign, 1
            yield lambda t, y: half + y[0], 0, -half, sign, -1

    for number in range(1, periods + 1):
        while t < number / n:
            ends = list(guards(sign, side))
            for guard, *_ in ends:
                guard.terminal, guard.direction = True, -1
            piece = solve_ivp(
                lambda t, y, sign=sign, side=side: [
                    y[1], (force(t, y[0], side) - c * y[1] - mu * sign) / m
                ],
                (t, number / n), y, "DOP853", rtol=1e-12, atol=1e-18, max_step=1e-3,
                events=[end[0] for end in ends],
            )  # fmt: skip
            t, y = piece.t[-1], piece.y[:, -1]
            for (_, which, value, *after), times in zip(ends, piece.t_events, strict=True):
                if times.size:
                    y[which] = value
                    sign, side = after
                    assert which == 0 or sign * force(t, y[0], side) > mu  # the teeth do not stick
        found.append(y)
    return np.array(found)


@pytest.mark.slow
def test_gears_in_si_units_have_their_period():
    points = strobes_by_quadrature(80)
    size = np.abs(points).max(axis=0)
    back = np.abs(points[-10:-2] - points[-8:]).max(axis=0) / size
    apart = np.abs(points[-10:-1] - points[-9:]).max(axis=0) / size
    assert back.max() < 1e-8 and apart.max() > 0.4
    found = ns.regime(gear())
    assert (found["regime"].item(), found["period"].item()) == ("periodic", 2)
    u = ns.stroboscopic_map(gear(), transient=500, record=2)["u"].values
    np.testing.assert_allclose(np.sort(u), np.sort(points[-2:, 0]), rtol=1e-8)


@pytest.mark.parametrize("transient", [600, 1000, 3000, 10_000])
def test_the_length_of_the_transient_changes_no_period(transient):
    """The cycle of 24 periods has the multiplier 0.66, so nothing is left of the way by then."""
    found = ns.bifurcation_diagram(gear(), "n", [37.5, 39.45], transient=transient)
    assert found["period"].values.ravel().tolist() == [24, 2]
