"""Regimes of the breathing crack by an integrator that shares nothing with the package.

A Runge-Kutta pair of order eight with its own events at u = 0, and the variational equations beside
it: the force is continuous where the crack closes, so derivatives pass the switch unchanged.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from nonsmooth_chapter.fatigue.crack_motions import beam, exponent_of_beam, motions

XI, ETA = 0.014, 1.1475
TURN = 2 * np.pi / ETA


def passes(t, y, *_):
    return y[0]


passes.terminal = True


def field(t, y, stiffness):
    return [y[1], ETA**2 * np.sin(ETA * t) - 2 * XI * y[1] - stiffness * y[0]]


def field_with_variation(t, y, stiffness):
    return [*field(t, y[:2], stiffness), y[3], -2 * XI * y[3] - stiffness * y[2]]


def one_period(crack, y, rates=field, tolerance=1e-11):
    """State after a period: from zero to zero of u, with the stiffness of the side."""
    sides = {1: 1 + 4.245e-3 * (20 - crack) ** 3, -1: 1 + 14.327}
    t, y = 0.0, np.array(y, float)
    while t < TURN:
        # a start on the surface goes where its first derivative that is not zero points; from
        # rest that is the third, eta**3 > 0
        side = int(np.sign(y[0] if abs(y[0]) > 1e-13 else y[1])) or 1
        far = t
        if abs(y[0]) <= 1e-13:
            far = min(t + 1e-3, TURN)  # off the surface, where the event would fire again
            part = solve_ivp(rates, (t, far), y, "DOP853", args=(sides[side],),
                             rtol=tolerance, atol=1e-14)  # fmt: skip
            t, y = far, part.y[:, -1]
        part = solve_ivp(rates, (t, TURN), y, "DOP853", args=(sides[side],), events=passes,
                         rtol=tolerance, atol=1e-14)  # fmt: skip
        t, y = part.t[-1], part.y[:, -1]
        if part.status == 1:
            y[0] = 0.0
    return y


@pytest.mark.parametrize(("crack", "period"), [(12.09, 5), (10.7, 2)])
def test_cycle_is_one_of_the_integrator_too(crack, period):
    """It comes back after so many periods and none before, and settles to what it left."""
    row = next(row for row in motions(beam(crack)) if row["period"] == period)
    y = np.array(row["point"])
    off = y + np.array([1e-3, -1e-3])
    returns, far = [], []
    for _ in range(8 * period):
        y, off = one_period(crack, y), one_period(crack, off)
        returns.append(np.abs(y - row["point"]).max())
        far.append(np.abs(off - y).max())
    back = [k + 1 for k, distance in enumerate(returns) if distance < 1e-8]
    assert back == [period * n for n in range(1, 9)]
    # seven cycles shrink a perturbation by the multipliers, two of one modulus, whatever the axes
    assert far[-1] / far[period - 1] < 3.0 * row["multiplier"] ** 7


@pytest.mark.slow
def test_from_rest_to_period_five():
    y, orbit = np.zeros(2), []
    for _ in range(120):
        y = one_period(12.09, y, tolerance=1e-9)
        orbit.append(y)
    row = next(row for row in motions(beam(12.09)) if row["period"] == 5)
    last = np.array(orbit[-5:])
    assert np.abs(last - row["point"]).max(axis=1).min() < 1e-4
    assert np.abs(np.array(orbit[-10:-5]) - last).max() < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("crack", [14.5])
def test_exponent_of_chaos(crack, periods=250):
    """The mean growth of a variation agrees with the package within errors of both."""
    y, growth = np.array([0.0, 0.0, 1.0, 0.0]), []
    for _ in range(periods):
        y = one_period(crack, y, field_with_variation, tolerance=1e-8)
        size = np.hypot(y[2], y[3])
        growth.append(np.log(size))
        y[2:] /= size
    blocks = np.array(growth[50:]).reshape(-1, 25).mean(axis=1)
    error = blocks.std(ddof=1) / np.sqrt(blocks.size)
    ours = exponent_of_beam(beam(crack), {"u": 0.0, "v": 0.0}, record=3000)
    assert ours["chaotic"] and blocks.mean() > 5 * error
    assert abs(blocks.mean() - ours["exponent"]) < 4 * np.hypot(error, ours["error"])
