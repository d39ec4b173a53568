"""`manifold`: what it refuses, and what an interruption leaves."""

import os
import signal

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.manifolds.local_map import LocalMap


def hill(**parameters):
    return ns.System(
        states=["x", "v"],
        parameters={"k": 1.0, "d": 0.0},
        equations={"x": "v", "v": "k*x - d*v + cos(t)"},
        period="2*pi",
        name="hill",
    ).with_parameters(**parameters)


@pytest.fixture(scope="module")
def orbit():
    return ns.find_orbit(hill(), {"x": -0.5})


def wells():
    """A Duffing oscillator, and its orbit near the top of the hill."""
    system = ns.models.duffing(gamma=0.2)
    top = -0.2 / (1.0 + 1.2**2 - 0.36j)
    return system, ns.find_orbit(system, {"x": top.real, "v": -1.2 * top.imag})


def refused(message, *args, **options):
    with pytest.raises(ns.OptionError, match=message):
        ns.manifold(*args, **options)


def test_orbits_that_are_no_saddle():
    well = hill(k=-2.0, d=0.1)
    stable = ns.find_orbit(well, {"x": 0.9})
    refused("it is stable, with the multipliers", well, stable)
    refused("its stable manifold is its basin", well, stable, which="stable")
    spiral = hill(k=-2.0, d=-0.1)
    refused("complex outside the unit circle", spiral, ns.find_orbit(spiral, {"x": 0.9}))
    node = hill(k=-0.01, d=-0.5)
    top = -1.0 / (1.0 - 0.01 + 0.5j)  # amplitude of the forced motion
    start = {"x": top.real, "v": -top.imag}
    refused("2 of its multipliers", node, ns.find_orbit(node, start))
    center = hill(k=-2.0)
    refused("on the unit circle", center, ns.find_orbit(center, {"x": 1.0}))


def test_orbits_of_something_else(orbit):
    refused("found at k = 1, and the map has k = 1.5", hill(k=1.5), orbit)
    refused("found at k = 1, and the map has k = 2", hill(), orbit, parameters={"k": 2.0})
    other = ns.System(states=["y"], equations={"y": "y + cos(t)"}, period="2*pi", name="other")
    refused("belongs to 'hill' with the states x, v", other, orbit)
    shifted = ns.System(
        states=["x", "v"], parameters={"k": 1.0, "d": 0.0}, period="2*pi",
        equations={"x": "v", "v": "k*x - d*v + cos(t) + 1"},
    )  # fmt: skip
    refused("does not come back", shifted, orbit)
    refused("give a result of find_orbit", hill(), {"x": 1.0})
    lost = orbit.copy()
    lost["x"] = np.nan
    refused("there is no orbit in this dataset", hill(), lost)
    many = ns.orbits(hill(), {"x": (-1.0, 0.0), "v": (-0.5, 0.5)}, samples=5)
    refused("orbits over 'orbit'", hill(), many)
    refused("inadmissible", hill(), orbit.assign(admissible=False))


def test_stable_manifolds_are_curves_of_maps_of_the_plane():
    three = ns.System(
        states=["x", "v", "w"], equations={"x": "v", "v": "x + cos(t)", "w": "x - w"},
        period="2*pi",
    )  # fmt: skip
    orbit = ns.find_orbit(three, {"x": -0.5, "w": 0.0})
    refused("needs a map of the plane", three, orbit, which="stable")
    curves = ns.manifold(three, orbit, length=1.0, side="+")
    x, v, w = (curves[name].values for name in ("x", "v", "w"))
    np.testing.assert_allclose(v, x + 0.5, atol=1e-12)
    # w' = x - w follows the growing part of x by a half of it
    np.testing.assert_allclose(w - w[0], 0.5 * (x + 0.5), atol=1e-12)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"which": "neither"}, "which = 'neither' must be 'unstable' or 'stable'"),
        ({"side": "left"}, "side = 'left' must be"),
        ({"length": 0.0}, "length = 0 must be positive"),
        ({"length": "far"}, "length = 'far'"),
        ({"largest_step": 20.0}, "must grow in this order"),
        ({"smallest_step": 1.0}, "must grow in this order"),
        ({"angle": 4.0}, "angle = 4 must be less"),
        ({"accuracy": -1.0}, "accuracy = -1 must be positive"),
        ({"scales": {"z": 1.0}}, "unknown state 'z'"),
        ({"scales": {"x": 0.0}}, r"scales\['x'\] = 0 must be positive"),
        ({"steps": 0}, "steps = 0"),
        ({"longest": 1.5}, "longest"),
    ],
)
def test_options(orbit, options, message):
    refused(message, hill(), orbit, **options)


def test_a_system_without_a_period_takes_a_section():
    free = ns.System(states=["x", "v"], equations={"x": "v", "v": "x"})
    refused("manifold", free, None)


def test_limits_end_a_curve(orbit):
    few = ns.manifold(hill(), orbit, length=5.0, steps=40, side="+")
    assert few["curve_end"].values.tolist() == ["points"] and few.sizes["point"] < 400
    assert "has as many points" in few.attrs["message"] and few.attrs["status"] == "completed"
    bent, top = wells()
    short = ns.manifold(bent, top, length=5.0, longest=1, side="+")
    assert short["curve_end"].values.tolist() == ["images"]


@pytest.mark.parametrize("which", ["unstable", "stable"])
def test_control_c_keeps_the_curve(monkeypatch, interrupts, which):
    calls = []
    look = LocalMap.after

    def interrupted(self, points, count=1):
        calls.append(count)
        if len(calls) == 30:
            os.kill(os.getpid(), signal.SIGINT)
        return look(self, points, count)

    itineraries = LocalMap.itineraries

    def counted(self, points, count=1):
        calls.append(count)
        if len(calls) == 30:
            os.kill(os.getpid(), signal.SIGINT)
        return itineraries(self, points, count)

    monkeypatch.setattr(LocalMap, "after", interrupted)
    monkeypatch.setattr(LocalMap, "itineraries", counted)
    bent, top = wells()
    curves = ns.manifold(bent, top, which=which, length=20.0)
    assert curves.attrs["status"] == "interrupted" and "interrupted" in curves.attrs["message"]
    assert curves.sizes["curve"] == 1 and curves.sizes["point"] >= 2
    assert curves["curve_end"].values.tolist() == ["interrupted"]
