"""Motions that nothing drives and that settle slowly: no torus, however small the rate is.

A linear oscillator that is kicked once per tick of a clock has the multiplier exp(-zeta w) of one
tick, and its strobes spiral to a point: the decay rate per period is known exactly.
"""

from __future__ import annotations

import re

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, System
from nonsmooth.analysis.regimes.slow_decay import KEPT, MotionTube, steady_rate

GOLDEN = 0.5 * (5.0**0.5 - 1.0)


def kicked(zeta: float) -> System:
    flow = {"x": "v", "v": "-2*z*w*v - w**2*x", "tau": "1"}
    kick = Exit("1 - tau", reset={"tau": "0", "v": "v + 0.3"}, name="kick")
    return System(
        states=["x", "v", "tau"], parameters={"z": zeta, "w": 1.7}, initial={"x": 1.0},
        period=1.0, modes={"m": Mode(flow, exits=[kick])},
    )  # fmt: skip


def beside(cycle: dict[str, str], zeta: float) -> System:
    """A cycle that shakes an oscillator a little."""
    flow = {"x": "v", "v": f"-2*{zeta}*1.7*v - 1.7**2*x + 0.1*y"} | cycle
    return System(states=list(flow), initial={"x": 1.0, "y": 1.0}, equations=flow)


def relay(zeta: float) -> System:
    """A two-point controller whose output shakes an oscillator."""
    flow = {"x": "v", "v": f"-2*{zeta}*1.7*v - 1.7**2*x + 0.2*q"}
    return System(
        states=["x", "v", "q"], initial={"x": 1.0, "q": 0.1},
        modes={
            "up": Mode(flow | {"q": "1 - q"}, exits=[Exit("0.7 - q", to="down", name="hi")]),
            "down": Mode(flow | {"q": "-q"}, exits=[Exit("q - 0.3", to="up", name="lo")]),
        },
    )  # fmt: skip


VAN_DER_POL = {"y": "u", "u": "(1 - y**2)*u - y"}


def label(found) -> str:
    return found["regime"].item()


def told_factor(found) -> float:
    told = re.search(r"by a factor ([0-9.]+) per period", found.attrs["message"])
    assert told is not None, found.attrs["message"]
    return float(told[1])


@pytest.mark.parametrize("zeta", [0.004, 0.0013])
def test_a_kicked_oscillator_is_periodic(zeta):
    found = ns.regime(kicked(zeta))
    assert (label(found), found["period"].item()) == ("periodic", 1)
    # along the flow an autonomous motion has a multiplier of one, which is left out
    assert found["multiplier_modulus"].values[0] == pytest.approx(np.exp(-1.7 * zeta), abs=1e-6)


@pytest.mark.parametrize("zeta", [3e-4, 1e-5])
@pytest.mark.parametrize("confirm", [10_000, 0])
def test_a_kicked_oscillator_settles_too_slowly(zeta, confirm):
    """Its rate is 1.7 zeta per period; the area across it shrinks by up to twice that at first."""
    found = ns.regime(kicked(zeta), confirm=confirm)
    assert label(found) == "unsettled"
    assert 1.0 - told_factor(found) == pytest.approx(1.7 * zeta, rel=0.1, abs=1e-6)


def test_without_damping_it_is_a_torus():
    """And it turns by 1.7/(2 pi) of a turn per tick for ever."""
    for confirm in (10_000, 0):
        assert label(ns.regime(kicked(0.0), confirm=confirm)) == "quasi-periodic"


def test_a_map_of_slow_decays_has_no_torus():
    found = ns.regime_map(kicked(0.1), {"z": [5e-4, 1e-3], "w": [1.5, 1.8]}, refine=0)
    assert np.all(found["period"].values == 1)


def test_a_feedback_that_lets_an_oscillator_grow_is_no_torus():
    """A force that is held from tick to tick has half a tick's delay, and feeds the oscillator."""
    flow = {"x": "v", "v": "-1.7**2*x + h", "h": "0", "tau": "1"}
    hold = Exit("1 - tau", reset={"tau": "0", "h": "0.3 - 0.001*x"}, name="sample")
    system = System(
        states=["x", "v", "h", "tau"], initial={"x": 1.0}, period=1.0,
        modes={"m": Mode(flow, exits=[hold])},
    )  # fmt: skip
    found = ns.regime(system)
    assert label(found) == "unsettled"
    assert "grows slowly" in found.attrs["message"]


@pytest.mark.parametrize("zeta", [0.002, 3e-4])
def test_an_oscillator_beside_a_cycle_settles_to_a_cycle(zeta):
    """The exponent is -1.7 zeta, which windows of 500 do not tell from zero."""
    found = ns.regime(beside(VAN_DER_POL, zeta), period=1.0)
    assert label(found) == "limit-cycle"
    error = found["exponent_error"].item()
    assert abs(found["exponent"].item() + 1.7 * zeta) <= 3.0 * error < 0.5 * 1.7 * zeta


@pytest.mark.parametrize("zeta", [0.002, 5e-4])
def test_an_oscillator_beside_a_relay_settles_to_a_cycle(zeta):
    found = ns.regime(relay(zeta), period=1.0)
    assert label(found) == "limit-cycle"
    assert found["exponent"].item() == pytest.approx(-1.7 * zeta, rel=0.02)


def test_an_undamped_oscillator_beside_a_relay_is_a_torus():
    assert label(ns.regime(relay(0.0), period=1.0)) == "quasi-periodic"


@pytest.mark.slow
@pytest.mark.parametrize("mu", [0.3, 0.003])
@pytest.mark.parametrize("period", [1.0, 2.3])
def test_two_cycles_that_hardly_feel_each_other_are_a_torus(mu, period):
    """Neighbours approach it by mu per unit time, also where that is next to nothing."""
    system = System(
        states=["x", "v", "y", "w"],
        initial={"x": 1.0, "y": 0.5},
        equations={
            "x": "v", "v": f"{mu}*(1 - x**2)*v - x + 0.02*(y - x)",
            "y": "w", "w": f"{mu}*(1 - y**2)*w - 1.7*y + 0.02*(x - y)",
        },
    )  # fmt: skip
    found = ns.regime(system, period=period, transient=int(20 / mu))
    assert label(found) == "quasi-periodic"


def test_a_steady_rate_stands_out_of_what_comes_and_goes():
    """Steps of a smooth function of the phases of a torus, of a size of three."""
    k = np.arange(1001)
    wave = 3.0 * np.sin(2 * np.pi * GOLDEN * k) + np.cos(2 * np.pi * (GOLDEN + 2**0.5) * k)
    still = steady_rate(np.diff(wave))
    assert abs(still.rate) < still.error < 1e-6
    assert not still.decays
    for rate in (1e-5, 1e-3):
        found = steady_rate(np.diff(wave) - rate)
        assert found.decays
        assert found.rate == pytest.approx(-rate, abs=found.error)
    chaos = np.random.default_rng(0).normal(-1e-4, 1.0, 1000)
    assert not steady_rate(chaos).decays
    assert not steady_rate(np.diff(np.log(100.0 + k))).decays  # neighbours part linearly
    assert not steady_rate(np.full(1000, -np.inf)).decays


def tube(width: float) -> np.ndarray:
    k = np.arange(1000.0)
    around, across = 2 * np.pi * GOLDEN * k, 2 * np.pi * 2**0.5 * k
    out = 1.0 + width * np.cos(across)
    points = [out * np.cos(around), out * np.sin(around), width * np.sin(across)]
    return np.stack(points, axis=1)


def test_a_tube_and_a_line():
    unit = np.array([2.0, 2.0, 1.0])
    thick, thinner, line = (MotionTube.of(tube(width), unit) for width in (0.3, 0.15, 1e-5))
    assert thinner.width < KEPT * thick.width
    assert not thick.is_line
    assert line.is_line
    assert MotionTube.of(tube(0.3)[::-1], unit).width == pytest.approx(thick.width)
    assert MotionTube.of(tube(0.3)[:, :1], unit[:1]).is_line
