"""Branches of cycles that are small beside the states that they lie at, beside closed forms.

Their place counts by the sizes of the states, and their shape by how much they vary.
"""

from __future__ import annotations

import numpy as np

import nonsmooth as ns


def test_a_tank_that_is_filled_by_a_clock():
    """x = a/(1 - exp(-k)) behind a shot of a: the ripple is a hundredth of it."""
    k = 0.01
    shot = ns.Exit("1 - tau", reset={"tau": "0", "x": "x + a"}, name="shot")
    tank = ns.System(
        states=["x", "tau"],
        parameters={"a": 1.0, "k": k},
        initial={"x": 100.0},
        modes={"m": ns.Mode({"x": "-k*x", "tau": "1"}, exits=[shot])},
    )
    branch = ns.continue_orbit(tank, "a", (0.5, 1.5))
    assert branch.attrs["end_first"] == branch.attrs["end_last"] == "bound"
    assert branch.sizes["point"] < 60
    np.testing.assert_allclose(branch["x"], branch["a"] / -np.expm1(-k), rtol=1e-11)
    np.testing.assert_allclose(branch["multipliers"].max("multiplier"), np.exp(-k), rtol=1e-11)


def test_a_thermostat_with_a_narrow_band():
    """x' = u - x between r - h and r + h."""
    h = 1e-3
    heater = ns.System(
        states=["x"],
        parameters={"r": 0.5, "h": h},
        initial={"x": 0.5},
        modes={
            "on": ns.Mode({"x": "1 - x"}, exits=[ns.Exit("r + h - x", to="off", name="warm")]),
            "off": ns.Mode({"x": "-x"}, exits=[ns.Exit("x - r + h", to="on", name="cold")]),
        },
    )
    branch = ns.continue_orbit(heater, "r", (0.4, 0.7), mode="on")
    assert branch.attrs["end_first"] == branch.attrs["end_last"] == "bound"
    assert branch.sizes["point"] < 60
    r = branch["r"].values
    exact = np.log((1 - r + h) / (1 - r - h)) + np.log((r + h) / (r - h))
    np.testing.assert_allclose(branch["length"], exact, rtol=1e-11)


def test_a_cycle_without_events_that_moves_far_and_shrinks_to_a_point():
    """A circle of radius 0.01 sqrt(1 - p) about x = 5 + 3 p: its plane goes along with it."""
    growth = 0.1
    circle = ns.System(
        states=["x", "y"],
        parameters={"p": 0.5},
        definitions={"X": "x - 5 - 3*p", "g": f"{growth}*(1 - p - (X**2 + y**2)/1e-4)"},
        equations={"x": "g*X - y", "y": "g*y + X"},
        initial={"x": 6.5 + 0.01 * np.sqrt(0.5)},
    )
    branch = ns.continue_orbit(circle, "p", (0.0, 1.5))
    assert branch.attrs["end_first"] == "bound" and branch.attrs["end_last"] == "hopf"
    assert branch.sizes["point"] < 100
    # 1 - p is as many roundings of x as there are in the radius
    assert abs(float(branch["p"][-1]) - 1.0) < 1e-12
    # a radius is known to roundings of x, over the part of it that fades in a turn
    inner = branch.isel(point=branch["p"].values < 0.99)
    p = inner["p"].values
    away = np.hypot(inner["x"].values - 5 - 3 * p, inner["y"].values)
    np.testing.assert_allclose(away, 0.01 * np.sqrt(1 - p), rtol=1e-8)
    sizes = np.abs(inner["multipliers"].values[:, 0])
    np.testing.assert_allclose(sizes, np.exp(-4 * np.pi * growth * (1 - p)), rtol=1e-8)
