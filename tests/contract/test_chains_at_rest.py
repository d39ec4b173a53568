"""Chains of which only the first element moves at the start: the k-th one begins with t^k."""

import math

import numpy as np
import pytest

import nonsmooth as ns


@pytest.mark.parametrize("n", [10, 18, 19, 20, 21, 25])
def test_a_chain_of_which_the_first_moves(n):
    """Of z_k' = z_(k-1) - z_k the solution is t^k exp(-t)/k!; here z = sinh(x).

    The series of the last element begins with the order n - 1, near the end of all that is known.
    """
    flow = {"x0": "-tanh(x0)"}
    flow |= {f"x{k}": f"sinh(x{k - 1})/cosh(x{k}) - tanh(x{k})" for k in range(1, n)}
    times = np.array([0.0, 0.5, 1.0, 2.0, 5.0, 20.0])
    run = ns.simulate(ns.System(states=[*flow], equations=flow), {"x0": math.asinh(1)}, times=times)
    assert run.attrs["status"] == "completed"
    for k in range(n):
        expected = np.arcsinh(times**k * np.exp(-times) / math.factorial(k))
        # some tens of units of rounding of the first elements, which are of size 1, come along
        assert np.abs(run[f"x{k}"].values - expected).max() < 1e-14, k
