"""nonsmooth through its public function, the systems written as a user writes them."""

import numpy as np
from problems import CHAIN, MOLE, SOFT_IMPACT

import nonsmooth as ns
from nonsmooth import Exit, Mode, System, models, simulate

VERSION = getattr(ns, "__version__", "unknown")


def prepare(problem):
    """(run, read) as in `hand`."""
    system = SYSTEMS[problem.name](problem.parameters)

    def run(periods):
        return simulate(system, problem.rest, periods=periods, samples_per_period=1)

    def read(trajectory):
        status = trajectory.attrs["status"]
        assert status == "completed", status
        # The sample at tau = 0 comes first where it is recorded.
        sampled = trajectory.isel(time=trajectory["time"].values > 0.0)
        strobes = np.stack([sampled[name].values for name in problem.states], axis=1)
        events = int((trajectory["event_kind"].values != "start").sum())
        return strobes, events

    return run, read


def soft_impact(p):
    flow = {"x": "v", "v": "a*omega**2*sin(omega*t) - 2*zeta*v - x"}
    stopped = {"x": "v", "v": "a*omega**2*sin(omega*t) - 2*zeta*v - x - beta*(x - e)"}
    return System(
        name="soft impact",
        states=["x", "v"],
        period="2*pi/omega",
        parameters=p,
        modes={
            "free": Mode(flow, exits=[Exit("e - x", to="contact", name="impact")]),
            "contact": Mode(stopped, exits=[Exit("x - e", to="free", name="release")]),
        },
    )


def mole(p):
    return models.moling(a=p["a"], b=p["b"], xi=p["xi"], omega=p["omega"])


def chain(p):
    flow = {
        "x1": "v1",
        "x2": "v2",
        "x3": "v3",
        "v1": "(k*(x2 - 2*x1) + c*(v2 - 2*v1) + A*cos(omega*t))/m",
        "v2": "(k*(x1 - 2*x2 + x3) + c*(v1 - 2*v2 + v3))/m",
        "v3": "(k*(x2 - x3) + c*(v2 - v3))/m",
    }
    stopped = flow | {"v3": "(k*(x2 - x3) + c*(v2 - v3) - k_stop*(x3 - e))/m"}
    return System(
        name="chain",
        states=["x1", "x2", "x3", "v1", "v2", "v3"],
        period="2*pi/omega",
        parameters=p,
        modes={
            "free": Mode(flow, exits=[Exit("e - x3", to="contact", name="impact")]),
            "contact": Mode(stopped, exits=[Exit("x3 - e", to="free", name="release")]),
        },
    )


SYSTEMS = {SOFT_IMPACT.name: soft_impact, MOLE.name: mole, CHAIN.name: chain}
