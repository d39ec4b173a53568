"""Attractors that are mirror images of each other under a declared symmetry."""

from dataclasses import replace

import numpy as np
import pytest

import nonsmooth as ns

BOX = {"x": (-2.0, 2.0), "v": (-2.0, 2.0)}


@pytest.mark.parametrize("phase", [0.0, 0.25, 0.7])
def test_motions_in_two_wells_are_a_pair(phase):
    """Minus the motion half a period later is that in the other well, at whatever phase."""
    wells = ns.StroboscopicMap(ns.models.duffing(gamma=0.2), phase=phase)
    found = ns.attractors(wells, BOX, samples=60)
    assert found["image"].values.tolist() == [2, 1]
    later = replace(wells, phase=(phase + 0.5) % 1.0)
    there = ns.attractors(later, BOX, samples=60)["points"].values[:, 0]
    np.testing.assert_allclose(found["points"].values[:, 0], -there[::-1], atol=1e-9)


def test_one_motion_is_its_own_image():
    spring = ns.models.duffing(alpha=1, delta=0.2, omega=1.0, gamma=1.0)
    found = ns.attractors(spring, BOX, samples=20)
    assert found["image"].values.tolist() == [1]
    x, v = found["points"].values[0, 0]
    turned = ns.simulate(spring, {"x": x, "v": v}, times=[0.0, np.pi])
    assert float(turned["x"][-1]) == pytest.approx(-x, abs=1e-9)


@pytest.mark.slow
def test_a_chaotic_set_is_its_own_image():
    found = ns.attractors(ns.models.duffing(), BOX, samples=20, record=3000)
    assert found["kind"].values.tolist() == ["chaotic"]
    assert found["image"].values.tolist() == [1]


def test_an_image_that_was_not_found_has_no_number():
    """Starts beside one equilibrium alone come to one motion of the pair."""
    found = ns.attractors(
        ns.models.duffing(gamma=0.05), {"x": (0.9, 1.1), "v": (-0.1, 0.1)}, samples=10
    )
    assert found["image"].values.tolist() == [0]


@pytest.mark.slow
def test_basins_name_the_pair_too():
    grid = {"x": np.linspace(-1.5, 1.5, 12), "v": np.linspace(-1.0, 1.0, 12)}
    found = ns.basins_of_attraction(ns.models.duffing(gamma=0.2), grid)
    assert found["image"].values.tolist() == [2, 1]


def test_without_a_symmetry_nothing_is_said():
    plain = replace(ns.models.duffing(gamma=0.2), symmetry={})
    assert "image" not in ns.attractors(plain, BOX, samples=20)
