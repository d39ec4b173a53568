"""Impacts per period: the mole's on a map, and balls in closed form."""

import pytest

import nonsmooth as ns


def test_a_map_tells_numbers_of_impacts_apart():
    plane = {"b": [0.15, 0.187], "g": [0.02, 0.021]}
    found = ns.regime_map(ns.models.moling(), plane, refine=1)
    assert found["impacts"].sel(b=0.15).values.tolist()[::2] == [1.0, 1.0]
    assert found["impacts"].sel(b=0.187).values.tolist()[::2] == [2.0, 2.0]


def two_balls():
    """Equal elastic balls between walls at 0 and 1: they exchange speeds, then hit the walls."""
    return ns.System(
        name="balls",
        states=["x", "v", "y", "w"],
        period="4",
        parameters={"speed": 0.25},
        initial={"x": 0.25, "v": "speed", "y": 0.75, "w": "-speed"},
        modes={
            "free": ns.Mode(
                {"x": "v", "v": "0", "y": "w", "w": "0"},
                exits=[
                    ns.Exit("x", reset={"v": "-v"}, name="left"),
                    ns.Exit("1 - y", reset={"w": "-w"}, name="right"),
                    ns.Exit("y - x", reset={"v": "w", "w": "v"}, name="clash"),
                ],
            )
        },
    )


@pytest.mark.parametrize("phase", [0.0, 0.25, 0.5, 0.75])
def test_impacts_at_one_instant_count_each(phase):
    """They clash at t = 1, and reach both walls at t = 3, a quarter further on at speed 1/4.

    Strobes may lie on either; the start of a run is no event.
    """
    balls = two_balls()
    for transient in (0, 2):
        column = ns.bifurcation_diagram(
            balls, "speed", [0.25], transient=transient, record=4, phase=phase
        ).squeeze()
        assert (column["impacts"].item(), column["events"].item()) == (3.0, 2.0)
    found = ns.regime(balls, phase=phase)
    assert (found["impacts"].item(), found["events"].item()) == (3.0, 2.0)
    spectrum = ns.lyapunov_spectrum(balls, transient=0, record=10)
    assert (spectrum.attrs["n_impacts"], spectrum.attrs["n_events"]) == (30, 20)
