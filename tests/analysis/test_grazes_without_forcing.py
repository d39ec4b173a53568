"""Cycles of a mass on a belt that meet a rigid stop, against shooting with DOP853.

Friction falls with the slip, so that the mass sticks and slips, or slips all the time. Nothing
drives it, and its motion is in a plane: a perturbation is a shift in time, or one across the flow.
The latter is all that multipliers tell. By Liouville's theorem a cycle without sticking has the
multiplier exp(D), D being the divergence summed over a turn, times r**2 for each impact of
restitution r: so it stays finite where the impact has no speed, though the matrix of the impact
does not. A cycle that sticks loses all perturbations, at a graze too.
"""

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import nonsmooth as ns

Z, FK, FS, VS, R = 0.02, 0.5, 1.0, 0.25, 0.6
STOP = 1.35


def belt(**parameters) -> ns.System:
    """The mass; its stop is at g, and the belt has the speed vb."""
    return ns.System(
        states=["x", "v"],
        parameters={"z": Z, "Fk": FK, "Fs": FS, "vs": VS, "vb": 0.4, "g": STOP, "r": R}
        | parameters,
        modes={
            "run": ns.Mode(
                {"x": "v", "v": "-x - 2*z*v - sign(s)*(Fk + (Fs - Fk)*exp(-abs(s)/vs))"},
                exits=[ns.Exit("g - x", reset={"v": "-r*v"}, name="stop")],
            )
        },
        surfaces={"s": ns.Surface("v - vb", below="lag", on="stick", above="lead")},
    )


def slip(x: float, v: float, vb: float, event, until: float = 20.0):
    """State and summed divergence where the slipping mass first passes an event after a while."""

    def rates(_t, y):
        force = (FS - FK) * np.exp((y[1] - vb) / VS)
        return [y[1], -y[0] - 2.0 * Z * y[1] + FK + force, force / VS - 2.0 * Z]

    found = solve_ivp(
        rates, (0.0, until), [x, v, 0.0], method="DOP853", rtol=1e-13, atol=1e-14, events=event
    )
    later = found.t_events[0] > 0.1
    return found.y_events[0][later][0]


def turns_back(_t, y):
    return y[1]


turns_back.direction = -1


def at_stop(_t, y):
    return y[0] - STOP


at_stop.direction = 1


@cache
def touching() -> tuple[float, float]:
    """Belt speed at which a cycle that slips all the time just touches the stop; its multiplier."""
    vb = brentq(lambda vb: slip(STOP, 0.0, vb, turns_back)[0] - STOP, 1.25, 1.27, xtol=1e-14)
    return vb, float(np.exp(slip(STOP, 0.0, vb, turns_back)[2]))


def specials(branch) -> list[tuple[str, float]]:
    values = branch["special_value"].values.tolist()
    return list(zip(branch["special_kind"].values.tolist(), values, strict=True))


@pytest.mark.slow
def test_a_cycle_that_slips_goes_on_with_impacts_and_has_finite_multipliers():
    system = belt(vb=1.1)
    orbit = ns.find_orbit(system, {"x": 0.0, "v": 0.0}, transient=0)
    branch = ns.continue_orbit(system, "vb", (1.05, 1.3), initial=orbit, direction="up")
    kinds = [kind for kind, _ in specials(branch)]
    assert kinds[:3] == ["grazing", "fold", "grazing_sliding"]
    vb, multiplier = touching()
    assert specials(branch)[0][1] == pytest.approx(vb, abs=1e-11)
    assert branch["special_multiplier"].values[0] == pytest.approx(multiplier, rel=1e-9)
    assert "turns back" in branch["special_detail"].values[0]
    assert "tells why" not in branch.attrs["message"]
    impacts = np.flatnonzero(branch["word"].values == "run[lag] run[lag]")
    checked = 0
    for k in impacts[:: max(1, len(impacts) // 6)]:
        one = branch.isel(point=int(k))
        before = float(one["leg_states"].values[0, 1])  # behind the stop
        if before > -1e-6:  # too slow for the event of scipy
            continue
        end = slip(STOP, before, float(one["vb"]), at_stop)
        assert -R * end[1] == pytest.approx(before, abs=1e-10)
        (found,) = one["multipliers"].values
        assert found == pytest.approx(R**2 * np.exp(end[2]), rel=1e-8)
        checked += 1
    assert checked >= 4


@pytest.mark.slow
def test_a_cycle_with_impacts_goes_on_without_them():
    """It comes to the stop with less and less speed; without it, it shrinks to its rest."""
    system = belt()
    branch = ns.continue_orbit(system, "vb", (0.3, 1.5), initial=ns.find_orbit(system, transient=5))
    kinds, values = zip(*specials(branch), strict=True)
    assert kinds == ("bound", "grazing", "grazing_sliding", "fold", "grazing", "hopf")
    vb, multiplier = touching()
    assert values[4] == pytest.approx(vb, abs=1e-11)
    # the limit from this side, on which each turn has an impact
    at = branch["special_multiplier"].values[4]
    assert at == pytest.approx(R**2 * multiplier, rel=1e-9)
    assert branch["multipliers"].values[int(branch["special_point"][4]), 0] == at
    assert values[5] == pytest.approx(VS * np.log((FS - FK) / (VS * 2.0 * Z)), rel=1e-13)
    assert "tells why" not in branch.attrs["message"]


def farthest_of_sticking(vb: float) -> float:
    """How far a mass comes that slips from where the belt can hold it no more."""
    return float(slip(FS - 2.0 * Z * vb, vb, vb, turns_back)[0])


@pytest.mark.parametrize("g", [1.35, 1.2])
def test_a_cycle_that_sticks_loses_perturbations_at_its_graze_too(g):
    system = belt(g=g)
    orbit = ns.find_orbit(system, transient=5)
    branch = ns.continue_orbit(system, "g", (1.1, 1.5), initial=orbit)
    (place,) = [k for k, (kind, _) in enumerate(specials(branch)) if kind != "bound"]
    kind, value = specials(branch)[place]
    assert kind == "grazing"
    assert value == pytest.approx(farthest_of_sticking(0.4), abs=1e-11)
    assert branch["special_multiplier"].values[place] == 0.0
    assert not branch["multipliers"].values.any()
    assert branch["stable"].values.all()
    # beyond the graze the stop does nothing, and g runs on
    assert "goes on" in branch["special_detail"].values[place]
    assert "tells why" not in branch.attrs["message"]
    g = branch["g"].values
    length = branch["length"].values
    assert np.ptp(length[g > value + 1e-9]) <= 1e-10
    assert np.all(np.diff(length[g < value - 1e-9]) * np.diff(g[g < value - 1e-9]) > 0.0)


def length_with_impact(g: float) -> float:
    """Length of the cycle at vb = 0.4 whose impact comes while the belt still holds the mass."""

    def catches(_t, y):
        return y[1] - 0.4

    catches.direction = 1
    found = solve_ivp(
        lambda _t, y: [y[1], -y[0] - 2 * Z * y[1] + FK + (FS - FK) * np.exp((y[1] - 0.4) / VS)],
        (0.0, 20.0), [g, -R * 0.4], method="DOP853", rtol=1e-13, atol=1e-14, events=catches,
    )  # fmt: skip
    t, (x, _) = found.t_events[0][0], found.y_events[0][0]
    return float(t + (g - x) / 0.4)


@pytest.mark.few(1)
@pytest.mark.parametrize("g", [1.1, 0.95])
def test_the_stop_is_met_before_the_belt_lets_go(g):
    """From where the belt lets go, at Fs - 2 z vb, the stop is met while the mass still sticks."""
    system = belt(g=g)
    orbit = ns.find_orbit(system, transient=5)
    branch = ns.continue_orbit(system, "g", (0.8, 1.2), initial=orbit)
    assert [kind for kind, _ in specials(branch)] == ["bound", "corner", "bound"]
    change = FS - 2.0 * Z * 0.4
    # guards count as zero within 500 roundings of their terms
    assert specials(branch)[1][1] == pytest.approx(change, abs=500 * 2.3e-16 * 3.0)
    below = branch["g"].values < change
    assert below.any() and (~below).any()
    for k in np.flatnonzero(below):
        there = float(branch["g"][k])
        assert float(branch["length"][k]) == pytest.approx(length_with_impact(there), abs=1e-10)
