"""The hand-written kernels behind the common interface."""

import numpy as np
from hand_kernels import chain, mole, soft_impact
from problems import CHAIN, MOLE, SOFT_IMPACT


def prepare(problem):
    """(run, read): run(periods) is timed, read(its result) gives strobes and event count."""
    kernel, arguments = KERNELS[problem.name](problem.parameters)

    def run(periods):
        strobes = np.empty((periods, len(problem.states)))
        events, _ = kernel(strobes, *arguments)
        return strobes, events

    return run, lambda result: result


def soft_impact_call(p):
    return soft_impact.simulate, (p["zeta"], p["e"], p["beta"], p["a"], p["omega"], 0.0, 0.0)


def mole_call(p):
    rest = (0.0, 0.0, 0.0, 0.0)
    return mole.simulate, (p["a"], p["b"], p["xi"], p["omega"], p["g"], *rest)


def chain_call(p):
    constants = chain.constants(**p)
    return chain.simulate, (*constants, p["e"], p["omega"], np.zeros(6))


KERNELS = {SOFT_IMPACT.name: soft_impact_call, MOLE.name: mole_call, CHAIN.name: chain_call}
