"""Time per step of the Taylor flow beside heyoka, and what tangents cost beside the plain run.

python benchmarks/bench_taylor.py [--periods N]

Both integrators take steps of order 20 to the same accuracy; heyoka compiles machine code for
each system, the Taylor flow runs a tape. The states after the first period are compared with
heyoka, and those of tangents with differences; the command fails where they disagree.
"""

# ruff: noqa: E402 - One thread each, decided before any library reads its environment.
import os

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import argparse
import gc
import sys
from time import process_time

import heyoka as hy
import numpy as np

import nonsmooth as ns
from nonsmooth.runs.clock import plan_run
from nonsmooth.runs.runner import build_derivatives, build_tables, run_plan
from nonsmooth.runs.start import resolve_start

ROUNDS = 25
BOUND = 1e-12  # relative difference after a period
DIFFERENCE = 1e-6  # of the tangent, which differences of this step leave undecided
RATIO = 3.0  # time per step over heyoka, and tangent over plain: the aims


def rotor():
    """A rotor that rubs for ever, so that only steps are compared."""
    p = {"zeta": 0.05, "kappa": 30.0, "e": 1.5, "omega": 2.7}
    force = {"x": "rho*cos(omega*t)", "y": "rho*sin(omega*t)"}
    rates = {}
    for x, u in (("x", "u"), ("y", "v")):
        rates |= {x: u, u: f"{force[x]} - 2*zeta*{u} - {x} - f*{x}"}
    guard = "1e3 - x**2 - y**2"
    system = ns.System(
        name="rotor",
        states=["x", "u", "y", "v"],
        parameters=p,
        period="2*pi/omega",
        definitions={"f": "kappa*(1 - 1/sqrt(x**2 + y**2))", "rho": "e*omega**2"},
        modes={"rub": ns.Mode(rates, exits=[ns.Exit(guard, to="stop")])},
    )
    x, u, y, v, c, s = hy.make_vars("x", "u", "y", "v", "c", "s")
    w, rho = p["omega"], p["e"] * p["omega"] ** 2
    f = p["kappa"] * (1.0 - 1.0 / hy.sqrt(x**2 + y**2))
    equations = [
        (x, u), (u, rho * c - 2 * p["zeta"] * u - x - f * x),
        (y, v), (v, rho * s - 2 * p["zeta"] * v - y - f * y),
        (c, -w * s), (s, w * c),
    ]  # fmt: skip
    return system, equations, [1.5, 0.2, 0.1, 0.0], 1e3 - x**2 - y**2


def duffing():
    """x'' = x - x^3 - d x' + a cos(w t), without events."""
    system = ns.System(
        name="duffing",
        states=["x", "v"],
        parameters={"a": 0.3, "omega": 1.0, "d": 0.2},
        period="2*pi/omega",
        equations={"x": "v", "v": "x - x**3 - d*v + a*cos(omega*t)"},
    )
    x, v, c, s = hy.make_vars("x", "v", "c", "s")
    equations = [(x, v), (v, x - x**3 - 0.2 * v + 0.3 * c), (c, -s), (s, c)]
    return system, equations, [0.1, 0.3], None


PROBLEMS = {"rotor": rotor, "duffing": duffing}


def time_ours(system, start, periods, chosen):
    """Best time of a run, steps that it takes, and its last state."""
    tables = build_tables(system)
    initial = dict(zip(system.states, start, strict=True))
    begin = resolve_start(system, tables, initial, None, None, False)
    plan = plan_run(
        tables.window, True, begin.instant,
        periods=periods, t_end=None, times=None, samples_per_period=1,
    )  # fmt: skip
    derivatives = build_derivatives(system, tables, chosen)
    best = np.inf
    for _ in range(ROUNDS):
        t = process_time()
        outcome = run_plan(
            tables, plan, 1e-12,
            state=begin.state, begin=begin.instant, derivatives=derivatives,
        )  # fmt: skip
        best = min(best, process_time() - t)
    return best, int(outcome.records.counters["segments"]), outcome.records.end_state.copy()


def time_heyoka(equations, start, event, t_end):
    """The same of heyoka; an event that never comes is watched as ours is."""
    events = [] if event is None else [hy.t_event(event)]
    peer = hy.taylor_adaptive(equations, [*start, 1.0, 0.0], t_events=events)
    best = np.inf
    for _ in range(ROUNDS):
        peer.time = 0.0
        peer.state[:] = [*start, 1.0, 0.0]
        t = process_time()
        steps = peer.propagate_until(t_end)[3]
        best = min(best, process_time() - t)
    return best, steps, peer.state[: len(start)].copy()


def tangent_error(system, start):
    """Largest relative difference of the tangent after a period from central differences."""
    initial = dict(zip(system.states, start, strict=True))
    run = ns.simulate(system, initial, periods=1, samples_per_period=1, tangent=[])
    tangent = run["tangent"].values[-1]
    step, columns = 1e-5, []
    for name in system.states:
        ends = [
            ns.simulate(system, initial | {name: initial[name] + h}, periods=1)["end_state"].values
            for h in (step, -step)
        ]
        columns.append((ends[0] - ends[1]) / (2 * step))
    return np.abs(np.array(columns).T - tangent).max() / np.abs(tangent).max()


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--periods", type=int, default=200)
    periods = parser.parse_args(arguments).periods
    gc.disable()
    print(
        f"{'problem':<9} {'ours':>9} {'heyoka':>9} {'ratio':>6}  us per step; error after a period"
    )
    faults = []
    for name, make in PROBLEMS.items():
        system, equations, start, event = make()
        period = system.period_value
        one = time_ours(system, start, 1, None)[2]
        other = time_heyoka(equations, start, event, period)[2]
        error = np.abs(one - other).max() / np.abs(other).max()
        ours, steps, _ = time_ours(system, start, periods, None)
        peer, peer_steps, _ = time_heyoka(equations, start, event, periods * period)
        ours_us, peer_us = ours / steps * 1e6, peer / peer_steps * 1e6
        print(f"{name:<9} {ours_us:9.3f} {peer_us:9.3f} {ours_us / peer_us:6.2f}  {error:.1e}")
        print(f"          steps {steps}, heyoka {peer_steps}")
        if error > BOUND:
            faults.append(f"{name}: states differ by {error:.1e}")
    print(f"\n{'tangents':<12} {'plain':>8} {'states':>7} {'all':>6}  us per period, ratios; error")
    for name, (system, start) in tangent_problems().items():
        plain = time_ours(system, start, periods, None)[0]
        states = time_ours(system, start, periods, ())[0]
        everything = time_ours(system, start, periods, tuple(system.parameters))[0]
        error = tangent_error(system, start)
        print(
            f"{name:<12} {plain / periods * 1e6:8.2f} {states / plain:7.2f}"
            f" {everything / plain:6.2f}  {error:.1e}"
        )
        if error > DIFFERENCE:
            faults.append(f"{name}: tangent differs by {error:.1e}")
    print(f"aims: {RATIO:g} times heyoka per step, {RATIO:g} times the plain run with tangents")
    for fault in faults:
        print(fault, file=sys.stderr)
    return 1 if faults else 0


def tangent_problems():
    """Systems of both flows with a start."""
    return {
        "soft impact": (ns.models.soft_impact(), [0.0, 0.0]),
        "trilinear": (ns.models.trilinear(), [0.1, 0.0]),
        "mole": (ns.models.moling(omega=1.0), [-0.3, 0.1, 0.05, 0.0]),
        "duffing": duffing()[::2],
        "rotor": rotor()[::2],
    }


if __name__ == "__main__":
    sys.exit(main())
