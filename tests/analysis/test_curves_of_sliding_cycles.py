"""Curves of the points at which cycles of a harvested population change how they slide.

Predators y of prey x are harvested above a threshold Th. Where the rate of y is zero beside the
surface, x is known in closed form for either side, and each kind of point is one condition on one
leg of the cycle, which scipy passes at its tightest tolerance.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns

R, K, A, B, M = 1.0, 2.2, 0.3, 2.2, 0.4
_LEAVES = 1e-3  # time in which an orbit is clear of the surface that it leaves at a tangent
# of x: solve_ivp at 1e-13 passes a leg of up to 30 units, on which errors grow at most 10 times,
# and a tangency leaves the square root of nothing, since legs come back steeply
_BY_SCIPY = 1e-11


def harvested(threshold: float) -> ns.System:
    return ns.System(
        states=["x", "y"],
        parameters={"r": R, "K": K, "a": A, "b": B, "m": M, "h": 0.35, "Th": threshold},
        initial={"x": 0.5, "y": 0.5},
        equations={
            "x": "r*x*(1 - x/K) - x*y/(a + x)",
            "y": "b*x*y/(a + x)/2 - m*y - h*y*heaviside(th)",
        },
        surfaces={"th": ns.Surface("y - Th", below="spare", on="edge", above="fish")},
    )


def rests_at(h: float) -> float:
    """Prey for which the number of predators is at rest, where they are harvested by h."""
    return A * (M + h) / (B / 2 - M - h)


def comes_back(h: float, x: float, threshold: float, up: bool) -> float:
    """Prey where an orbit that leaves the threshold at x comes back to it, by scipy."""

    def rates(t, z):
        meal = z[0] * z[1] / (A + z[0])
        return [R * z[0] * (1 - z[0] / K) - meal, B * meal / 2 - M * z[1] - h * z[1]]

    def reaches(t, z):
        return z[1] - threshold

    reaches.direction, reaches.terminal = (1 if up else -1), True
    fine = {"rtol": 1e-13, "atol": 1e-14, "method": "DOP853"}
    begun = solve_ivp(rates, (0.0, _LEAVES), [x, threshold], **fine).y[:, -1]
    return float(solve_ivp(rates, (0.0, 100.0), begun, events=reaches, **fine).y_events[0][0, 0])


def curve_from(start: float, between, way: str, kind: str, **options):
    """The branch over the threshold from a cycle that has more legs than behind its one change."""
    branch = ns.continue_orbit(harvested(start), "Th", between, transient=10, direction=way,
                               steps=6, largest_step=0.01)  # fmt: skip
    kinds = branch["special_kind"].values.tolist()
    return ns.continue_special(branch, kinds.index(kind), "h", (0.3, 0.4), **options)


@pytest.mark.slow
def test_switching_sliding_found_from_the_side_of_more_legs():
    """The cycle comes from below just where predators rest under harvest."""
    curve = curve_from(1.98, (1.8, 2.1), "up", "switching_sliding", direction="up", steps=3)
    assert curve["h"].values[0] == pytest.approx(0.35, abs=1e-12)
    assert curve.sizes["point"] == 4
    assert bool(curve["admissible"].all())
    ends = [comes_back(0.0, rests_at(0.0), float(th), up=True) for th in curve["Th"]]
    assert ends == pytest.approx([rests_at(float(h)) for h in curve["h"]], abs=_BY_SCIPY)


@pytest.mark.slow
def test_crossing_sliding_found_from_the_side_of_more_legs():
    """The cycle comes from above just where predators rest without harvest."""
    curve = curve_from(0.512, (0.45, 0.56), "down", "crossing_sliding", steps=5)
    assert np.ptp(curve["h"].values) > 2e-3
    assert bool(curve["admissible"].all())
    ends = [
        comes_back(float(h), rests_at(float(h)), float(th), up=False)
        for h, th in zip(curve["h"], curve["Th"], strict=True)
    ]
    assert ends == pytest.approx([rests_at(0.0)] * len(ends), abs=_BY_SCIPY)
