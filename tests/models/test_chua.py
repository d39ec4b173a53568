"""Chua's circuit: divergence, symmetry, equilibria, and matrix exponentials at 40 digits."""

import numpy as np
import pytest
from mpmath import mp
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.models import chua

EPS = np.finfo(float).eps
ALPHA, BETA, M0, M1 = 9.0, 100 / 7, -8 / 7, -5 / 7


def modes(run, name="event_to"):
    return [run[name].attrs["flag_meanings"].split()[int(m)] for m in run[name]]


def test_volumes_change_by_the_trace_over_the_time_in_each_region():
    run = ns.simulate(chua(), t_end=6.0, times=None, tangent=True)
    words, times = modes(run), [*run["event_time"].values, 6.0]
    spent = {name: 0.0 for name in ("inner", "right", "left")}
    for name, begin, end in zip(words, times[:-1], times[1:], strict=True):
        spent[name] += end - begin
    trace = {name: -ALPHA * (1 + (M0 if name == "inner" else M1)) - 1 for name in spent}
    exact = np.exp(sum(trace[name] * spent[name] for name in spent))
    tangent = run["tangent"].values[-1]
    assert min(spent["inner"], spent["right"] + spent["left"]) > 0.5
    # a sum of products of three entries, each off by some roundings
    assert abs(np.linalg.det(tangent) - exact) < 500 * EPS * np.abs(tangent).max() ** 3


@pytest.mark.parametrize(("alpha", "beta"), [(ALPHA, BETA), (15.6, 28.0)])
def test_first_leg_is_the_matrix_exponential(alpha, beta):
    start = {"x": 0.1, "y": 0.05, "z": -0.2}
    run = ns.simulate(chua(alpha=alpha, beta=beta), start, t_end=8)
    end = float(run["event_time"][1])
    rows = [[-alpha * (1 + M0), alpha, 0], [1, -1, 1], [0, -beta, 0]]
    with mp.workdps(40):
        m0 = mp.mpf(M0)
        matrix = mp.matrix(rows)
        matrix[0, 0] = -mp.mpf(alpha) * (1 + m0)
        state = mp.matrix([mp.mpf(value) for value in start.values()])
        root = mp.findroot(lambda t: abs((mp.expm(matrix * t) * state)[0]) - 1, end)
        state = mp.expm(matrix * root) * state
    # the growth over the leg times some roundings
    bound = 32 * EPS * np.exp(end * np.linalg.eigvals(rows).real.max())
    assert abs(float(root) - end) < bound
    assert np.abs(run["state_before"].values[1] - [float(x) for x in state]).max() < bound


@pytest.mark.parametrize("resistor", ["piecewise", "cubic"])
def test_mirrored_start_gives_the_mirrored_motion(resistor):
    start = {"x": 0.3, "y": -0.1, "z": 0.7}
    system = chua(resistor=resistor)
    one = ns.simulate(system, start, t_end=10)
    two = ns.simulate(system, {name: -value for name, value in start.items()}, t_end=10)
    for name in "xyz":
        # every operation has a mirrored one with the same rounding
        assert np.abs(one[name].values + two[name].values).max() < 1e-13
    mirrored = {"left": "right", "right": "left", "inner": "inner", "flow": "flow"}
    assert [mirrored[name] for name in modes(one)] == modes(two)


@pytest.mark.parametrize("resistor", ["piecewise", "cubic"])
@pytest.mark.parametrize("sign", [1.0, 0.0, -1.0])
def test_equilibria(resistor, sign):
    """x + f(x) = 0: with these slopes at x = 0 and at x = (m1 - m0)/(1 + m1) = 3/2."""
    x = sign * (M1 - M0) / (1 + M1)
    run = ns.simulate(chua(resistor=resistor), {"x": x, "y": 0.0, "z": -x}, t_end=5, tangent=True)
    growth = np.abs(run["tangent"].values).max()
    assert run.attrs["n_events"] == 0
    for name, value in (("x", x), ("y", 0.0), ("z", -x)):
        assert np.abs(run[name].values - value).max() < 32 * EPS * growth
    assert float(run["resistor_current"][0]) == pytest.approx(-x, abs=4 * EPS)


def test_cubic_against_scipy():
    def field(_, s):
        x, y, z = s
        return [ALPHA * (y - x - (M0 * x + 4 / 63 * x**3)), x - y + z, -BETA * y]

    found = solve_ivp(field, (0, 8), [0.1, 0, 0], method="DOP853", rtol=1e-13, atol=1e-15)
    run = ns.simulate(chua(resistor="cubic"), t_end=8, tangent=True)
    growth = np.abs(run["tangent"].values).max()
    assert np.abs(run["end_state"].values - found.y[:, -1]).max() < 1e-12 * growth


def test_double_scroll_visits_both_sides_and_stays_bounded():
    run = ns.simulate(chua(), t_end=1000)
    assert set(modes(run)) == {"inner", "left", "right"}
    assert 2.0 < float(np.abs(run["x"]).max()) < 3.0


def test_unknown_resistor_and_cubic_without_equilibria():
    with pytest.raises(ns.ModelError, match="'piecewise' or 'cubic'"):
        chua(resistor="linear")
    with pytest.raises(ns.ModelError, match="pair of equilibria"):
        chua(resistor="cubic", m0=-0.5, m1=-0.5)
