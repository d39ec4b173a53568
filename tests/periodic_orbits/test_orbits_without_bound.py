"""Branches of cycles that grow without bound: they say so, and at which parameter."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns


def circle(radius: str, turning: str, **parameters: float) -> ns.System:
    """x' = x r - y w, y' = y r + x w: in polar coordinates r' = r radius, angle' = turning."""
    return ns.System(
        states=["x", "y"],
        parameters=parameters,
        equations={
            "x": f"x*({radius}) - y*({turning})",
            "y": f"y*({radius}) + x*({turning})",
        },
    )


@pytest.mark.slow
def test_an_amplitude_without_bound():
    """The radius is 1/sqrt(mu), on which the flow turns once in 2 pi."""
    system = circle("1 - mu*(x**2 + y**2)", "1", mu=0.5)
    branch = ns.continue_orbit(system, "mu", (-0.5, 1.0), initial={"x": 1.2}, transient=20)
    assert branch.attrs["end_first"] == "unbounded"
    assert "the amplitude grows without bound" in branch.attrs["message"]
    mu = branch["mu"].values
    radius = np.hypot(branch["x"], branch["y"]).values * np.sqrt(mu)
    assert radius[mu > 1e-3] == pytest.approx(1.0, rel=1e-8)
    assert radius == pytest.approx(1.0, rel=1e-2)  # where mu itself is next to rounding
    assert 0.0 < branch["mu"].min().item() < 1e-11
    assert branch.attrs["end_last"] == "bound"


def saddle_node_on_a_circle(steps: int) -> xr.Dataset:
    """On the unit circle angle' = p - cos(angle), so a turn takes 2 pi/sqrt(p**2 - 1)."""
    return ns.continue_orbit(
        circle("1 - x**2 - y**2", "p - x/sqrt(x**2 + y**2)", p=1.5), "p", (0.5, 2.0),
        initial={"x": 1.0}, direction="down", steps=steps, largest_step=0.5, transient=20,
    )  # fmt: skip


@pytest.mark.slow
def test_a_period_without_bound():
    branch = saddle_node_on_a_circle(150)
    assert branch.attrs["end_first"] == "unbounded"
    assert "the period grows without bound" in branch.attrs["message"]
    p, length = branch["p"].values, branch["length"].values
    assert p.min() == pytest.approx(1.0, abs=2e-3)
    assert length == pytest.approx(2 * np.pi / np.sqrt(p**2 - 1), rel=1e-6)


def test_a_branch_whose_parameter_still_moves_has_taken_its_steps():
    """The period grows here too."""
    assert saddle_node_on_a_circle(10).attrs["end_first"] == "steps"
