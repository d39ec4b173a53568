"""Responses of large structures tell of every motion that grows, by numpy's eigenvalues."""

import numpy as np
import pytest
import scipy.sparse as sp

import nonsmooth as ns
from nonsmooth.structures import Beam, Bearing, eigenpairs, frequency_response, shaft


def first_order(structure, speed=0.0):
    """All eigenvalues of the dense first-order form."""
    m, c, k = (sp.csr_array(each).toarray() for each in structure.at_speed(speed))
    n, inverse = len(m), np.linalg.inv(m)
    return np.linalg.eigvals(
        np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ k, -inverse @ c]])
    )


def test_a_mode_that_grows_beyond_the_first_eight_is_told():
    """Damping a - p K drives the fastest mode first, of 120 masses between springs."""
    n, least = 120, 0.05
    stiffness = sp.diags_array([-np.ones(n - 1), 2 * np.ones(n), -np.ones(n - 1)],
                               offsets=[-1, 0, 1]).tocsc()  # fmt: skip
    onset = least / (4.0 * np.cos(np.pi / (2 * n + 2)) ** 2)

    def driven(p):
        damping = (least * sp.eye_array(n) - p * stiffness).tocsc()
        return ns.Structure(sp.eye_array(n).tocsc(), stiffness, damping=damping)

    frequency_response(driven(0.99 * onset), [0.1], inputs=0, outputs=0)  # no warning
    rate = -0.5 * (least - 1.01 * onset * 4.0 * np.cos(np.pi / (2 * n + 2)) ** 2)
    with pytest.warns(
        ns.ResultWarning, match=rf"mode of 2 rad/s, grows as exp\({rate:.3g} t\) at a speed of 0"
    ):
        frequency_response(driven(1.01 * onset), [0.1], inputs=0, outputs=0)


@pytest.mark.parametrize("cross", [1e3, 1e5])
def test_a_seal_without_damping_needs_few_modes(cross, monkeypatch):
    """What it feeds is little beside the energy of the modes that are not looked at."""
    held = [Bearing([f"{i}x", f"{i}y"], [[2e7, 0.0], [0.0, 1.5e7]], 6e3) for i in (0, 40)]
    seal = Bearing(["20x", "20y"], [[0.0, cross], [-cross, 0.0]])
    rotor = shaft([Beam(0.025, 0.05)] * 40, bearings=[*held, seal], sparse=True)
    values = first_order(rotor, 300.0)
    grows = bool((values.real > 1e-6 * np.abs(values)).any())
    assert grows == (cross > 1e4)

    def refused(pencil):
        raise AssertionError("all eigenvalues are asked for")

    monkeypatch.setattr(eigenpairs, "_by_decomposition", refused)
    if grows:
        with pytest.warns(ns.ResultWarning, match="grows as exp"):
            frequency_response(rotor, [50.0], inputs="20x", outputs="20x", speed=300.0)
    else:
        frequency_response(rotor, [50.0], inputs="20x", outputs="20x", speed=300.0)


def test_where_modes_are_too_many_to_tell_a_response_says_so(monkeypatch):
    n = 160
    stiffness = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    driven = ns.Structure(np.eye(n), stiffness, damping=0.05 * np.eye(n) - 0.02 * stiffness)
    monkeypatch.setattr(eigenpairs, "_LARGEST_DENSE", 80)
    with pytest.warns(ns.ResultWarning, match="only the 16 .* motions may leave this response"):
        frequency_response(driven, [0.1], inputs=0, outputs=0)
