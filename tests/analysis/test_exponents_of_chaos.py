"""Exponents of chaotic motion against a route that shares nothing with the library."""

import numpy as np
import pytest

import nonsmooth as ns
from analysis import exponent_truth


def within_three_errors(spectrum, truth) -> bool:
    values, errors = truth
    away = np.abs(spectrum["lyapunov_exponent"].values - values)
    return bool(np.all(away < 3 * np.hypot(spectrum["standard_error"].values, errors)))


@pytest.mark.slow  # the chaos of the circuit below has its exponents from another route, too
@pytest.mark.parametrize("omega", [0.905])
def test_soft_impact(omega):
    system = ns.models.soft_impact(omega=omega)
    spectrum = ns.lyapunov_spectrum(system, transient=500, record=6000)
    truth = exponent_truth.soft_impact(omega, 0.01, 29.0, 1.26, 0.7, periods=1200, skipped=500)
    assert within_three_errors(spectrum, truth)
    assert spectrum["lyapunov_exponent"][0] > 10 * spectrum["standard_error"][0]


@pytest.mark.slow
def test_chua():
    spectrum = ns.lyapunov_spectrum(ns.models.chua(), record=4000)
    truth = exponent_truth.chua(steps=60_000, skipped=4_000)
    assert within_three_errors(spectrum, truth)
    first, neutral, _ = spectrum["lyapunov_exponent"].values
    assert first > 0.25 and abs(neutral) < 3 * spectrum["standard_error"][1]
    assert 2.1 < float(spectrum["kaplan_yorke_dimension"]) < 2.2


@pytest.mark.slow
def test_errors_are_those_of_repetition():
    """Runs from other starts scatter by the standard error that one of them tells of."""
    runs = [
        ns.lyapunov_spectrum(ns.models.duffing(), {"x": 0.1 * k}, transient=100, record=400, seed=k)
        for k in range(16)
    ]
    values = np.array([run["lyapunov_exponent"][0] for run in runs])
    errors = np.array([run["standard_error"][0] for run in runs])
    assert 0.6 < values.std(ddof=1) / errors.mean() < 1.6
