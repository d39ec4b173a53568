"""The route of the rotor against its own equations: the ring by its energy, and other series."""

import json
from math import cos, hypot, pi, sin

import numpy as np
import pytest
from mpmath import mp, mpf

from reference.make_rotor_runs import FILE, RUNS
from reference.nonlinear import DIGITS, smooth_run
from reference.rotor import period, rotor_case

TRUTH = json.loads(FILE.read_text(encoding="utf-8"))


def energy(s, delta):
    """Of the two springs along one axis, over k_s, by (55) to (58)."""
    return s * s if abs(s) <= delta else (abs(s) + delta) ** 2 / 2 - delta * delta


@pytest.mark.parametrize("name", RUNS)
def test_ring_has_the_least_energy_in_contact(name):
    """Of all places that touch the rotor; where it is pulled along (mu < 0) only stationary."""
    p, checked = TRUTH[name]["parameters"], 0
    for row, regime in zip(TRUTH[name]["samples"], TRUTH[name]["regimes"], strict=True):
        x, y, _, _, sx, sy, mu = map(float, row)
        if regime == "I" or mu < 0:
            continue
        checked += 1
        assert hypot(x - sx, y - sy) == pytest.approx(1.0, abs=1e-14)
        angle = np.arctan2(y - sy, x - sx)
        own = energy(sx, p["delta_x"]) + energy(sy, p["delta_y"])
        for turn in (*np.linspace(-pi, pi, 50), 1e-3, -1e-3, 1e-4, -1e-4):
            ux, uy = x - cos(angle + turn), y - sin(angle + turn)
            assert energy(ux, p["delta_x"]) + energy(uy, p["delta_y"]) >= own - 1e-14
    assert checked or not any(r != "I" for r in TRUTH[name]["regimes"])


@pytest.mark.parametrize("name", ["set B", "slow ring"])
def test_other_series_agree(name):
    """Lower order, longer tolerance, other steps: the first two periods to 22 digits."""
    truth, parameters = TRUTH[name], RUNS[name][0]
    assert truth["parameters"] == parameters
    with mp.workdps(DIGITS):
        times = [period(parameters) * k / 4 for k in range(1, 9)]
    words = {"order": 36, "tolerance": mpf(10) ** -34}
    run = smooth_run(*rotor_case(parameters, [0.0] * 4, times), **words)
    with mp.workdps(DIGITS):
        for row, expected in zip(run.samples, truth["samples"][:8], strict=True):
            apart = [abs(a - mpf(b)) for a, b in zip(row[: len(expected)], expected, strict=True)]
            assert max(apart) < mpf(10) ** -22
