"""Tangencies of straight manifolds: a pendulum that falls against a rigid wall, in closed form.

x'' = k x + e cos(w t) falls away from x = 0. Beside its saddle, whose motion is the real part of
c exp(i w t) with c = -e/(w^2 + k), the manifolds are the lines v - u' = +-sqrt(k) (x - u), until
the wall at x = 1 turns the unstable one back: v becomes -r v there. It comes back on the stable one
where (1 - r) sqrt(k) = Re[((1 + r) i w + (1 - r) sqrt(k)) c exp(i w t)] for some t. Both touch
where the size of what is multiplied by the exponential is the left side (Shaw and Rand, Int. J.
Non-Linear Mechanics 24, 41-56, 1989). For larger k they do not meet at all.
"""

import numpy as np
import pytest
from scipy.optimize import brentq

import nonsmooth as ns

W, R = 2.0, 0.8


def pendulum(e: float, k: float) -> ns.System:
    return ns.System(
        states=["x", "v"],
        period="2*pi/w",
        parameters={"e": e, "w": W, "r": R, "k": k},
        modes={
            "falls": ns.Mode(
                {"x": "v", "v": "k*x + e*cos(w*t)"},
                exits=[ns.Exit("1 - x", reset={"v": "-r*v"}, sticks="leans", name="wall")],
            )
        },
    )


def exact(e: float) -> float:
    """The value of k at which the manifolds touch."""

    def left(k: float) -> float:
        c = -e / (W**2 + k)
        return (1 - R) * np.sqrt(k) - abs((1 + R) * 1j * W * c + (1 - R) * np.sqrt(k) * c)

    return float(brentq(left, 0.1, 3.0, xtol=1e-14))


def touching(e, between, **options):
    system = pendulum(e, between[0])
    saddle = ns.find_orbit(system, {"x": -e / (W**2 + between[0])})
    return ns.homoclinic_tangency(
        system, "k", between, saddle, length=12.0, largest_step=0.3, **options
    )


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("options", "between"), [({"side": "+", "bumps": 1}, (0.9, 1.3)), ({}, (0.95, 2.0))]
)
def test_a_direction_turns_on_the_way(options, between):
    """At k = 1 both entries of a direction are as large: which is larger says nothing of a side."""
    found = touching(0.3, between, **options)
    np.testing.assert_allclose(found["k"].values, [exact(0.3)], rtol=1e-10)
    assert found.attrs["crossings"] == "2 0"


@pytest.mark.slow
@pytest.mark.parametrize("between", [(0.4, 1.4), (0.4, 0.65), (0.55, 0.9)])
def test_no_other_value_is_a_tangency(between):
    """A bump that is not followed any more has no value at which it vanishes."""
    found = touching(0.2, between)
    np.testing.assert_allclose(found["k"].values, [exact(0.2)], rtol=1e-10)


@pytest.mark.slow
def test_no_pair_is_followed_from_far_away():
    """Two walls and a damper: from twice the force no pair of crossings leads to the tangency."""
    damping = 0.15
    system = ns.System(
        states=["x", "v"],
        period="2*pi/w",
        parameters={"e": 0.1, "w": W, "r": R, "d": damping},
        modes={
            "falls": ns.Mode(
                {"x": "v", "v": "x - d*v + e*cos(w*t)"},
                exits=[
                    ns.Exit("1 - x", reset={"v": "-r*v"}, sticks="leans", name="right"),
                    ns.Exit("x + 1", reset={"v": "-r*v"}, sticks="lies", name="left"),
                ],
            )
        },
    )
    stable, unstable = np.sort(np.roots([1.0, damping, -1.0]))
    c = 1.0 / (-(W**2) + 1j * damping * W - 1.0)
    turned = R * unstable + stable
    value = abs(turned) / abs(-(1.0 + R) * 1j * W * c + turned * c)
    saddle = ns.find_orbit(system, {"x": 0.0})
    found = ns.homoclinic_tangency(
        system, "e", (0.5 * value, 2.0 * value), saddle, side="+", length=25.0
    )
    np.testing.assert_allclose(found["e"].values, [value], rtol=1e-10)
