"""Equilibrium of the rotor at rest: least energy of rotor and ring together."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from nonsmooth import ModelError, OptionError
from nonsmooth.models import static_contact

CASES = [
    {"eps_x": 1.5, "eps_y": 0.2},
    {"eps_x": -1.02, "eps_y": 0.01, "delta_x": 0.3, "delta_y": 0.02},
    {"eps_x": 2.0, "eps_y": -4.0, "delta_x": 0.01, "delta_y": 0.0, "K": 3.0},
    {"eps_x": 0.3, "eps_y": -9.0, "delta_x": 0.05, "delta_y": 0.02},
    {"eps_x": 9.0, "eps_y": 0.1, "delta_x": 0.0, "delta_y": 0.0},
]


def spring(s, delta):
    s = abs(s)
    inner = min(s, delta)
    return inner**2 + (s - inner) * (s + 3.0 * delta) / 2.0


@pytest.mark.parametrize("case", CASES)
def test_least_energy(case):
    """scipy moves the rotor and turns the normal; the energy of the springs of (55)-(58)."""
    options = {"K": 30.0, "delta_x": 0.1, "delta_y": 0.1} | case

    def energy(p):
        x, y, angle = p
        ring = spring(x - np.cos(angle), options["delta_x"])
        ring += spring(y - np.sin(angle), options["delta_y"])
        return 0.5 * ((x - case["eps_x"]) ** 2 + (y - case["eps_y"]) ** 2) + options["K"] * ring

    turn = np.arctan2(case["eps_y"], case["eps_x"])
    best = minimize(
        energy, [np.cos(turn), np.sin(turn), turn], method="Nelder-Mead",
        options={"xatol": 1e-12, "fatol": 1e-18, "maxiter": 20000, "maxfev": 20000},
    )  # fmt: skip
    rest = static_contact(**case)
    assert bool(rest["contact"])
    found = [float(rest["x"]), float(rest["y"])]
    assert np.allclose(found, best.x[:2], atol=1e-7)


size = st.floats(-20.0, 20.0)
preload = st.sampled_from([0.0, 0.01, 0.1, 2.0])


@given(size, size, preload, preload, st.sampled_from([0.1, 30.0, 1e4]))
def test_forces_balance(eps_x, eps_y, delta_x, delta_y, K):
    """The force of the ring holds the rotor's spring; no contact within the gap."""
    rest = static_contact(eps_x=eps_x, eps_y=eps_y, delta_x=delta_x, delta_y=delta_y, K=K)
    pull = [eps_x - float(rest["x"]), eps_y - float(rest["y"])]
    assert bool(rest["contact"]) == (np.hypot(eps_x, eps_y) >= 1.0)
    if not rest["contact"]:
        assert pull == [0.0, 0.0]
        assert float(rest["force"]) == 0.0
        return
    force = [float(rest["force_x"]), float(rest["force_y"])]
    assert np.allclose(pull, force, rtol=1e-12, atol=1e-13 * (K + np.hypot(eps_x, eps_y)))


def test_straight_push_by_hand():
    """Along x within the preload: springs 1 and 2 K in series."""
    rest = static_contact(eps_x=1.5, eps_y=0.0, delta_x=0.1, delta_y=0.1, K=30.0)
    assert float(rest["force"]) == pytest.approx(0.5 * 60.0 / 61.0, rel=1e-13)
    assert float(rest["sx"]) == pytest.approx(0.5 / 61.0, rel=1e-12)


def test_bad_input():
    with pytest.raises(ModelError, match="delta_y"):
        static_contact(delta_y=-0.1)
    with pytest.raises(ModelError, match="K = 0"):
        static_contact(K=0.0)
    with pytest.raises(OptionError, match="not a finite number"):
        static_contact(eps_x=np.nan)
