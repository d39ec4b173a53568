"""Columns of derivatives against exponentials of twice the size.

Unit of error: the largest component or the condition of the column, whichever is larger: what
roundings of the coefficients do to it at best. Allowed is 1e-10, which is 4e5 of these
roundings. The closed form divides by a gap of eigenvalues once more than the motion does, where
the gap is felt by a 32nd at least: chains of three lose a factor of 32**3, and vectors of
motions that are nearly the same lose ten more. Where no eigenvalues are close nothing of that
is lost and 1e-13 is asked for.
"""

from pathlib import Path

import mpmath
import numpy as np
import pytest

import nonsmooth as ns
from engine.doubled_systems import Prepared
from engine.flow_survey import coefficients, template
from engine.native_shim import advance_columns
from engine.spectra import CLASSES, draw, jordan
from nonsmooth.engine.derivatives import allocate_rates, set_up_rates
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import DERIVATIVES, EXACT, TAYLOR

ALLOWED, SIMPLE = 1e-10, 1e-13
EXAMPLES = Path(__file__).parents[2] / "examples"


def oscillator(k=1.0, zeta=0.1, a=1.0, omega=2.8, b=0.2):
    return ns.System(
        states=["x", "v"],
        parameters={"k": k, "zeta": zeta, "a": a, "omega": omega, "b": b},
        modes={"m": ns.Mode({"x": "v", "v": "-k*x - 2*zeta*v + a*cos(omega*t + 0.3) + b"})},
    )


def worst(system, s, time=0.7, seed=1):
    """Largest error of all columns by parameters in all modes, in units of what is allowed."""
    found = 0.0
    case, rng = Prepared(system), np.random.default_rng(seed)
    assert case.status == (0, 0)
    for m in range(len(system.modes)):
        length = min(s, case.longest(m))
        state, columns = rng.normal(size=case.n), rng.normal(size=(len(case.chosen), case.n))
        z, columns = case.start(state, time, columns)
        out = case.advance(m, z, length, columns)
        for p in range(len(case.chosen)):
            found = max(found, case.error(m, p, out[p], z, columns[p], length))
    return found


@pytest.mark.parametrize("s", [1e-6, 0.03, 1.3, 4.0])
def test_forced_oscillator_by_all_parameters(s):
    assert worst(oscillator(), s) < SIMPLE
    assert worst(oscillator(zeta=0.0), s) < SIMPLE
    # by the frequency, the forcing columns are as large as the time
    assert worst(oscillator(), s, time=1234.5) < 10 * SIMPLE


@pytest.mark.parametrize("distance", [0.0, 1e-9, 1e-5, 1e-3, 4e-3, 1e-2, 3e-2, 0.1])
@pytest.mark.parametrize("s", [1e-3, 1.3, 4.0])
def test_critical_damping_and_resonance_and_their_neighbours(distance, s):
    assert worst(oscillator(zeta=1.0 + distance), s) < ALLOWED
    assert worst(oscillator(zeta=0.0, omega=1.0 + distance), 3 * s) < ALLOWED


def test_parameters_that_are_zero():
    # a force that is not there resonates as soon as it is
    assert worst(oscillator(zeta=0.0, a=0.0, omega=1.0, b=0.0), 10.0) < SIMPLE
    # two equal oscillators, and a coupling that is not there; a slow one beside a constant
    flow = {"x": "v", "v": "-k*x + c*y", "y": "w", "w": "-k*y + c*x - d*v"}
    parameters = {"k": 4.0, "c": 0.0, "d": 0.0}
    pair = ns.System(states=["x", "v", "y", "w"], parameters=parameters, modes={"m": ns.Mode(flow)})
    assert worst(pair, 20.0) < SIMPLE
    free = {"x": "v", "v": "a*cos(omega*t) - k*x - d*v + g*t"}
    parameters = {"a": 0.0, "omega": 2.0, "k": 0.0, "d": 0.0, "g": 0.0}
    mass = ns.System(states=["x", "v"], parameters=parameters, modes={"m": ns.Mode(free)})
    assert worst(mass, 5.0) < SIMPLE


@pytest.mark.parametrize("s", [1e-3, 2.0, 20.0, 1e4])
def test_forcing_slow_beside_relaxation_and_a_free_mass(s):
    # windows last 3e5 here; over a short segment constants and harmonics are all one
    assert worst(oscillator(k=0.0, zeta=1.0, omega=1e-4), s) < ALLOWED
    assert worst(oscillator(k=0.0, zeta=0.1, omega=1e-4), s) < ALLOWED


@pytest.mark.slow
@pytest.mark.parametrize("s", [1e-4, 0.5, 30.0])
def test_models(s):
    # flight, contact and progression of the mole: rigid, slaved and relaxing motions
    assert worst(ns.models.moling(), s) < ALLOWED
    # relaxation ten thousand times as fast as the forcing
    assert worst(ns.System.from_toml(EXAMPLES / "fatigue_rig.toml"), s) < ALLOWED


def test_powers_of_time():
    flow = {"x": "v", "v": "g*t**2 - d*v + h*t", "y": "c*x*1.5 - y"}
    parameters = {"g": 0.3, "d": 0.2, "h": -1.0, "c": 2.0}
    system = ns.System(states=["x", "v", "y"], parameters=parameters, modes={"m": ns.Mode(flow)})
    assert worst(system, 2.0, time=30.0) < ALLOWED


@pytest.mark.few(4)
@pytest.mark.parametrize(
    ("value", "size"),
    [
        pytest.param(value, size, marks=[pytest.mark.slow] * (size == 4 and value.imag != 0.0))
        for size in (2, 3, 4)
        for value in (0.0, -0.5, complex(-0.1, 2.0))
    ],
)
def test_jordan_chains_by_every_entry(value, size):
    matrix = jordan(value, size)
    n = len(matrix)
    case = Prepared(template(n, 0).with_parameters(**entries(matrix)))
    z, columns = case.start(np.arange(1.0, n + 1), 0.0, np.zeros((n * n, n)))
    out = case.advance(0, z, 1.7, columns)
    # the closed form splits a chain by the gap that rounding gives it; entries above are exact
    for p in range(n * n):
        assert case.error(0, p, out[p], z, columns[p], 1.7) < ALLOWED


def entries(matrix):
    n = len(matrix)
    return {f"a{i}_{j}": float(matrix[i, j]) for i in range(n) for j in range(n)}


def judge(name, seed):
    """Largest error of some columns of a random case; zero where set-up refuses it."""
    drawn = draw(name, seed)
    values = coefficients(drawn)
    rng = np.random.default_rng(seed)
    names = list(rng.choice(list(values), min(3, len(values)), replace=False))
    names[:1] = ["w0"] if drawn.frequencies.size else names[:1]
    system = template(len(drawn.start), drawn.frequencies.size).with_parameters(**values)
    case = Prepared(system, names)
    z, columns = case.start(drawn.start, 0.0, np.zeros((len(names), case.n)))
    s = min(drawn.time, case.longest(0))
    out = case.advance(0, z, s, columns)
    return max(case.error(0, p, out[p], z, columns[p], s) for p in range(len(names)))


@pytest.mark.few(2)
@pytest.mark.parametrize("name", CLASSES)
def test_random_systems_of_each_class(name):
    errors = {seed: judge(name, seed) for seed in range(3)}
    assert max(errors.values()) < ALLOWED, errors


@pytest.mark.slow
@pytest.mark.parametrize("name", CLASSES)
def test_a_hundred_random_systems_of_each_class(name):
    errors = {seed: judge(name, seed) for seed in range(3, 103)}
    assert max(errors.values()) < ALLOWED, errors


def test_columns_of_states_are_columns_of_the_exponential():
    case = Prepared(oscillator(), [])
    z, columns = case.start([0.3, -0.2], 0.0, np.eye(2))
    out = case.advance(0, z, 1.3, columns)
    with mpmath.workdps(50):
        exact = mpmath.expm(mpmath.matrix([[0, 1], [-1, mpmath.mpf(-2 * 0.1)]]) * mpmath.mpf(1.3))
    assert np.abs(out.T - np.array(exact.tolist(), float)).max() < 1e-15


def test_truth_agrees_with_mpmath():
    case = Prepared(oscillator(), ["omega"])
    z, columns = case.start([0.3, -0.2], 0.7, [[0.1, 0.4]])
    matrix, rows = case.doubled(0, 0)
    with mpmath.workdps(50):
        flow = mpmath.expm(mpmath.matrix(matrix.tolist()) * mpmath.mpf(1.3), method="taylor")
        end = flow * mpmath.matrix(np.concatenate([z, columns[0]]).tolist())
        true = np.array((mpmath.matrix(rows.tolist()) * end).tolist(), float)[:, 0]
    assert np.abs(case.advance(0, z, 1.3, columns)[0] - true).max() < 1e-14


def test_columns_may_be_their_own_output():
    case = Prepared(ns.models.moling())
    z, columns = case.start(np.ones(4), 0.4, np.ones((10, 4)))
    for m, s in ((0, 1.1), (1, 1e-3), (1, 1.1), (2, 0.5)):
        apart = case.advance(m, z, s, columns)
        same = columns.copy()
        advance_columns(case.tables, case.rates, case.scratch, m, z, s, same, same)
        assert (same[:, :4] == apart).all()


def test_rates_of_guards_relations_and_resets():
    system = ns.System(
        states=["x", "v"],
        parameters={"r": 0.8, "s": 0.5},
        modes={
            "free": ns.Mode(
                {"x": "v", "v": "-x"}, exits=[ns.Exit("s**2 - x", reset={"v": "-r*v + s"})]
            ),
            "held": ns.Mode({"v": "-v"}, slaved={"x": "r*s*v + s"}),
        },
    )
    affine = Prepared(system).rates.affine
    # rows of a mode: one guard with its derivatives, relations of x and v, resets of x and v
    relation, reset = DERIVATIVES, DERIVATIVES + 2
    assert affine[1, 0, 0].tolist() == [0.0, 0.0, 1.0]
    assert affine[0, 0, reset + 1].tolist() == [0.0, -1.0, 0.0]
    assert affine[1, 0, reset + 1].tolist() == [0.0, 0.0, 1.0]
    assert affine[1, 1, relation].tolist() == [0.0, 0.8, 1.0]


def test_modes_that_are_not_exact_are_left_alone():
    case = Prepared(ns.models.moling())
    kinds = np.array([EXACT, TAYLOR, EXACT])
    rates = allocate_rates(case.program, case.chosen)
    set_up_rates(case.program.replace(kinds=kinds), case.values, case.tables, rates)
    assert not rates.growth[1].any()
    assert not rates.frame[:, :, 1].any()
    assert np.array_equal(rates.frame[:, :, 2], case.rates.frame[:, :, 2])


def test_a_derivative_that_is_infinite_is_named():
    flow = {"x": "-sqrt(p)*x - sqrt(q)"}
    system = ns.System(states=["x"], parameters={"q": 1.0, "p": 0.0}, modes={"m": ns.Mode(flow)})
    assert Prepared(system).status == (Status.NOT_FINITE, 1)
    assert Prepared(system, ["q"]).status == (0, 0)
