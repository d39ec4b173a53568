"""Chains of equal rates that a coupling eps closes: defective where eps is zero, or nearly so.

Their eigenvalues lie eps ** (1 / n) apart, and the motion does not care: |error| <= 1e-12
max(|y|, kappa) as in `test_flow_accuracy`, with the componentwise condition kappa of
`conditioning`. The truth is that of ball arithmetic, checked against mpmath with 40 digits.
"""

import mpmath
import numpy as np
import pytest

import nonsmooth as ns
from engine import conditioning
from engine.flow_survey import judge
from engine.spectra import Case

SMALL = [0.0, *(10.0**k for k in range(-20, -7))]
TIMES = (0.5, 3.0, 20.0, 40.0)


def chain(n, rate, eps):
    """x1' = rate x1 + x2, ..., xn' = rate xn + eps x1."""
    matrix = np.diag(np.full(n, rate)) + np.diag(np.ones(n - 1), 1)
    matrix[-1, 0] = eps
    return matrix


def two_oscillators(eps):
    """x'' = -x + y, y'' = -y + eps x."""
    return np.array([[0, 1, 0, 0], [-1, 0, 1, 0], [0, 0, 0, 1], [eps, 0, -1, 0]], float)


def case_of(matrix, time):
    n = len(matrix)
    none = np.zeros((n, 0))
    return Case(matrix, time, np.ones(n), np.zeros(0), none, none)


@pytest.mark.few(6)
@pytest.mark.parametrize("eps", SMALL)
@pytest.mark.parametrize("n", [2, 3, 4, 5])
def test_chain_of_decays(n, eps):
    for rate in (-0.3, -3.0):
        for time in TIMES:
            verdict = judge(case_of(chain(n, rate, eps), time))
            assert verdict.vector <= 1.0, (rate, time, verdict)


@pytest.mark.parametrize("eps", SMALL)
def test_two_oscillators_in_resonance(eps):
    for time in TIMES:
        verdict = judge(case_of(two_oscillators(eps), time))
        assert verdict.strict <= 1.0, (time, verdict)


@pytest.mark.parametrize("unit", [1e-8, 1e8])
def test_units_of_a_coordinate_do_not_matter(unit):
    for n in (2, 3, 5):
        units = np.ones(n)
        units[-1] = unit
        matrix = chain(n, -0.3, 1e-16) * units / units[:, None]
        for time in TIMES:
            verdict = judge(case_of(matrix, time))
            assert verdict.vector <= 1.0, (n, time, verdict)


@pytest.mark.parametrize("n", [3, 5])
def test_truth_agrees_with_mpmath(n):
    case = case_of(chain(n, -0.3, 1e-16), 40.0)
    found = conditioning.flow(case.augmented, case.augmented_start, case.time)
    with mpmath.workdps(40):
        full = mpmath.matrix(case.matrix.tolist()) * 40
        expected = mpmath.expm(full, method="taylor") * mpmath.matrix(case.start.tolist())
        for a, b in zip(found, expected, strict=True):
            assert abs(mpmath.mpf(a.mid().str(40, radius=False)) - b) <= mpmath.mpf("1e-25") * b


@pytest.mark.parametrize("seed", [2, 4, 5])
def test_integrators_beside_a_fast_decay_in_mixed_coordinates(seed):
    """Refinement leaves rounding below the diagonal of their cluster; it counts: 4e-11 without it.

    Errors are some units of rounding of the largest state, the margin of slots is 32 of them or
    7e-15, and the bound lies a factor of ten above that.
    """
    mixing = np.random.default_rng(seed).normal(size=(4, 4))
    plain = np.array([[0, 1, 0, 0], [0, 0, 1.5, 0], [0, 0, 0, 1], [0, 0, 0, -400]])
    matrix = mixing @ plain @ np.linalg.inv(mixing)
    names = ["a", "b", "c", "d"]
    flow = {
        name: " + ".join(f"({float(k)!r})*{other}" for k, other in zip(row, names, strict=True))
        for name, row in zip(names, matrix, strict=True)
    }
    system = ns.System(states=names, period="2*pi", modes={"all": ns.Mode(flow)})
    start = [0.3, -0.2, 0.5, 0.1]
    run = ns.simulate(system, dict(zip(names, start, strict=True)), periods=2)
    with mpmath.workdps(40):
        truth = mpmath.expm(mpmath.matrix(matrix.tolist()) * 2 * (2 * np.pi)) * mpmath.matrix(start)
    found = np.array([run[name].values[-1] for name in names])
    wanted = np.array([float(each) for each in truth])
    assert np.abs(found - wanted).max() <= 1e-13 * np.abs(wanted).max()
