"""A stop that takes all speed and holds while the force presses: where landings begin to be held.

The mass leaves the stop at F cos(w t0) = g with no speed and flies as a linear oscillator until it
lands. Where the force is g again at the landing, it is held from there on one side of that
frequency, and makes a short flight first on the other side.
"""

import numpy as np
import pytest
from scipy.optimize import brentq

import nonsmooth as ns

F, GAP, DAMPING = 0.9, 0.6, 0.2
BRACKETS = ((0.2805, 0.2815), (0.356, 0.357))


def force_at_landing(w: float) -> float:
    """Force on the mass as it lands, less what the spring takes."""
    forced = F / (1.0 - w * w + 1j * DAMPING * w)
    fast, t0 = np.sqrt(1.0 - 0.25 * DAMPING**2), np.arccos(GAP / F) / w

    def steady(t):
        return (forced * np.exp(1j * w * t)).real

    a = GAP - steady(t0)
    b = (-(1j * w * forced * np.exp(1j * w * t0)).real + 0.5 * DAMPING * a) / fast

    def gap(t):
        decay = np.exp(-0.5 * DAMPING * (t - t0))
        return decay * (a * np.cos(fast * (t - t0)) + b * np.sin(fast * (t - t0))) + steady(t) - GAP

    t = t0 + 1e-2
    while gap(t) < 0.0:
        t += 1e-3
    return F * np.cos(w * brentq(gap, t - 1e-3, t, xtol=1e-15)) - GAP


def system() -> ns.System:
    return ns.System(
        states=["x", "v"], parameters={"g": GAP, "F": F, "w": 0.4}, period="2*pi/w",
        modes={
            "free": ns.Mode(
                {"x": "v", "v": "F*cos(w*t) - 0.2*v - x"},
                exits=[ns.Exit("g - x", reset={"v": "0"}, name="stop", sticks="held")],
            )
        },
    )  # fmt: skip


@pytest.mark.few(1)
@pytest.mark.parametrize("phase", [0.3, 0.0, 0.6])
def test_places_do_not_depend_on_the_strobe(phase):
    stop = system()
    start = ns.find_orbit(stop, transient=100, phase=phase)
    branch = ns.continue_orbit(stop, "w", (0.27, 0.42), initial=start, phase=phase)
    assert {branch.attrs["end_first"], branch.attrs["end_last"]} == {"bound"}
    assert bool(branch["admissible"].all())
    inner = branch["special_kind"].values != "bound"
    assert set(branch["special_kind"].values[inner]) == {"switching_sliding"}
    places = branch["special_value"].values[inner]
    for low, high in BRACKETS:
        expected = brentq(force_at_landing, low, high, xtol=1e-15)
        assert np.abs(places - expected).min() < 1e-12


def test_rebounds_that_pass_the_strobe_where_not_all_is_at_rest():
    """A hammer on a pile: both move on together, and only the pile stops once in a turn."""
    pile = ns.System(
        states=["d", "vh", "vp", "xp"], period="2*pi/omega", drift=["xp"], initial={"d": 1.0},
        parameters={"M": 2.0, "m": 1.0, "F": 3.95, "omega": 1.4, "g": 1.0, "R": 4.5, "r": 0.4},
        modes={
            "fly": ns.Mode(
                {"d": "vp - vh", "vh": "F/M*cos(omega*t) + g", "vp": "g - R/m*sign(vp)",
                 "xp": "vp"},
                exits=[ns.Exit("d", reset={
                    "vh": "vh - (1+r)*m/(M+m)*(vh-vp)", "vp": "vp + (1+r)*M/(M+m)*(vh-vp)",
                }, name="blow", sticks="together")],
            )
        },
    )  # fmt: skip
    branches = [
        ns.continue_orbit(pile, "F", (3.9, 4.1), phase=phase, direction="up")
        for phase in (0.0, 0.6)
    ]
    for branch in branches:
        assert branch.attrs["end_last"] == "bound", branch.attrs["message"]
    depths = [float(branch["xp_per_period"][-1]) for branch in branches]
    assert depths[0] == pytest.approx(depths[1], rel=1e-9)
