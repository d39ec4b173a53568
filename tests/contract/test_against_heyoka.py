"""Nonlinear flows beside heyoka's Taylor integrator, compiled for each system.

Both work to the last bit, so they differ by rounding: 1e-11 times the growth of the tangent.
heyoka comes with the extra ``benchmark``.
"""

import numpy as np
import pytest

hy = pytest.importorskip("heyoka", reason="comes with the extra 'benchmark'")

# after the skip, since these import heyoka themselves
import nonsmooth as ns  # noqa: E402
from contract.growth import growth  # noqa: E402
from contract.smooth_problems import FUNCTIONS, PROBLEMS, Problem  # noqa: E402
from contract.tangent_systems import RUNS, rotor, start_of  # noqa: E402

TOLERANCE = 1e-11
SAMPLES = 41


def compare(run, expected, sizes):
    for k, name in enumerate(run["state"].values):
        error = np.abs(run[name].values - expected[:, k]) / np.maximum(1.0, np.abs(expected[:, k]))
        assert (error < TOLERANCE * sizes).all(), (name, (error / sizes).max())


@pytest.mark.few(1)
@pytest.mark.parametrize("name", PROBLEMS)
def test_states(name):
    problem = PROBLEMS[name]
    times = np.linspace(0.0, problem.t_end, SAMPLES)
    peer = hy.taylor_adaptive(problem.expressions(), list(problem.start.values()))
    expected = peer.propagate_grid(times)[-1]
    system = problem.system()
    run = ns.simulate(system, problem.start, times=times)
    assert run.attrs["status"] == "completed"
    sizes = growth(system, problem.start, times)
    assert sizes[-1] < 1e8, "too chaotic for this long a run"
    compare(run, expected, sizes)


@pytest.mark.few(2)
@pytest.mark.parametrize("text", FUNCTIONS)
def test_functions(text):
    """The integral of the function along a pendulum that swings up to 70 degrees."""
    flow = {"x": "v", "v": "-sin(x)", "s": text}

    def peer(x, v, s):
        return [v, -hy.sin(x), FUNCTIONS[text](x, v)]

    problem = Problem(flow, {}, {"x": 0.3, "v": 1.1, "s": 0.0}, 20.0, peer)
    times = np.linspace(0.0, problem.t_end, SAMPLES)
    expected = hy.taylor_adaptive(problem.expressions(), [0.3, 1.1, 0.0]).propagate_grid(times)[-1]
    system = problem.system()
    run = ns.simulate(system, problem.start, times=times)
    assert run.attrs["status"] == "completed"
    compare(run, expected, growth(system, problem.start, times))


@pytest.mark.few(3)
@pytest.mark.parametrize("text", FUNCTIONS)
def test_tangents_of_functions(text):
    """Against heyoka's variational equations."""
    flow = {"x": "v", "v": "-k*sin(x)", "s": text}

    def peer(x, v, s):
        return [v, -hy.par[0] * hy.sin(x), FUNCTIONS[text](x, v)]

    start = {"x": 0.3, "v": 1.1, "s": 0.0}
    variables = hy.make_vars(*flow)
    rates = list(zip(variables, peer(*variables), strict=True))
    arguments = [*variables, hy.par[0]]
    equations = hy.var_ode_sys(rates, arguments, order=1)
    integrator = hy.taylor_adaptive(equations, list(start.values()), pars=[1.0], compact_mode=True)
    integrator.propagate_until(10.0)
    columns = np.array(integrator.state[3:]).reshape(3, 4)
    system = ns.System(states=list(flow), parameters={"k": 1.0}, modes={"m": ns.Mode(flow)})
    run = ns.simulate(system, start, times=[10.0], tangent=True)
    size = np.abs(columns).max()
    assert np.abs(run["tangent"].values[0] - columns[:, :3]).max() < 1e-11 * size
    assert np.abs(run["sensitivity"].values[0, :, 0] - columns[:, 3]).max() < 1e-11 * size


def test_rotor_with_contacts():
    """The contact stiffness is a parameter that a terminal event sets."""
    p, times = RUNS["rotor"]["parameters"], np.linspace(0.0, 30.0, 61)
    x, y, u, w = hy.make_vars("x", "y", "u", "w")
    load = p["rho"] * p["omega"] ** 2
    k = hy.par[0] * (1.0 - 1.0 / hy.sqrt(x * x + y * y))
    phase = p["omega"] * hy.time
    passed = []

    def cross(integrator, direction):
        passed.append(float(integrator.time))
        integrator.pars[0] = p["kappa"] if direction > 0 else 0.0
        return True

    peer = hy.taylor_adaptive(
        [
            (x, u),
            (y, w),
            (u, load * hy.cos(phase) - 2.0 * p["zeta"] * u - x - k * x),
            (w, load * hy.sin(phase) - 2.0 * p["zeta"] * w - y - k * y),
        ],
        list(start_of("rotor").values()),
        pars=[0.0],
        t_events=[hy.t_event(x * x + y * y - 1.0, callback=cross)],
    )
    expected = peer.propagate_grid(times)[-1]
    run = ns.simulate(rotor(p), start_of("rotor"), times=times)
    assert run.attrs["status"] == "completed"
    sizes = growth(rotor(p), start_of("rotor"), times)
    compare(run, expected, sizes)
    events = run["event_time"].values[run["event_kind"].values != "start"]
    assert len(events) == len(passed) >= 15
    assert np.abs(events - passed).max() < TOLERANCE * sizes[-1]
