"""Branches that leave their last impact, and what is kept where the library itself fails."""

import numpy as np
import pytest
from scipy.optimize import brentq

import nonsmooth as ns
from nonsmooth.periodic_orbits import stretch_walk

STOP = 0.35


def two_masses() -> ns.System:
    """A driven mass with a smaller one on it, which hits a stop at a distance or rests on it."""
    return ns.System(
        states=["x", "v", "y", "w"],
        period="2*pi/omega",
        parameters={
            "M": 1.0, "m": 0.15, "k": 1.0, "c": 0.04, "k2": 0.12, "c2": 0.01, "d": STOP, "r": 0.65,
            "F": 0.12, "omega": 0.95,
        },
        definitions={"coupling": "k2*(y - x) + c2*(w - v)", "closing": "w - v"},
        modes={
            "free": ns.Mode(
                {"x": "v", "v": "(F*cos(omega*t) - k*x - c*v + coupling)/M",
                 "y": "w", "w": "-coupling/m"},
                exits=[
                    ns.Exit(
                        "d - (y - x)",
                        reset={"v": "v + m*(1+r)/(M+m)*closing", "w": "w - M*(1+r)/(M+m)*closing"},
                        sticks="together",
                        name="hit",
                    )
                ],
            )
        },
    )  # fmt: skip


def distance(omega: float) -> float:
    """How far the masses come apart without any impact, from the linear equations."""
    springs = np.array([[1.12, -0.12], [-0.12, 0.12]])
    dampers = np.array([[0.05, -0.01], [-0.01, 0.01]])
    matrix = springs + 1j * omega * dampers - omega**2 * np.diag([1.0, 0.15])
    x, y = np.linalg.solve(matrix, [0.12, 0.0])
    return float(abs(y - x))


@pytest.mark.slow
def test_an_orbit_without_impacts_goes_on_behind_the_graze():
    branch = ns.continue_orbit(two_masses(), "omega", (0.6, 1.3))
    assert (branch.attrs["end_first"], branch.attrs["end_last"]) == ("bound", "bound")
    graze = branch.isel(special=1)
    assert graze["special_kind"].item() == "grazing"
    expected = brentq(lambda omega: distance(omega) - STOP, 0.65, 0.68, xtol=1e-15)
    # the distance is known to 1e-15 or so and grows by 4 per unit of omega
    assert float(graze["special_value"]) == pytest.approx(expected, abs=1e-12)
    beyond = branch.isel(point=branch["omega"].values < expected - 1e-9)
    assert set(beyond["word"].values) == {"free"}
    assert np.all(np.isnan(beyond["durations"].values[:, 1:]))


def test_an_error_at_a_change_keeps_the_points(monkeypatch):
    def fails(*_):
        raise ValueError("on purpose")

    monkeypatch.setattr(stretch_walk, "change_at", fails)
    branch = ns.continue_orbit(two_masses(), "omega", (0.6, 1.3))
    assert "fault" in (branch.attrs["end_first"], branch.attrs["end_last"])
    assert "ValueError: on purpose" in branch.attrs["message"]
    assert branch.sizes["point"] > 10
