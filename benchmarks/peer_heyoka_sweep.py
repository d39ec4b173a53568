"""Columns of the soft impact diagram by heyoka's ensembles, scalar or in batches.

Time is counted in phases of the forcing, so that all columns share one grid of strobes; omega and
the stiffness behind the stop are parameters of the compiled integrator. Terminal events with
Python callbacks change the stiffness. Compilation is outside the time, as for the C kernels.
"""

import heyoka as hy
import numpy as np

VERSION = hy.__version__


def equations(p):
    x, v = hy.make_vars("x", "v")
    omega, stiffness = hy.par[0], hy.par[1]
    drive = p["a"] * omega * omega * hy.sin(hy.time)
    pull = drive - 2.0 * p["zeta"] * v - x - stiffness * (x - p["e"])
    return [(x, v / omega), (v, pull / omega)], x - p["e"]


class Switch:
    """Callback at the stop, of a scalar integrator."""

    def __init__(self, beta):
        self.beta = beta

    def __call__(self, integrator, direction):
        integrator.pars[1] = self.beta if direction > 0 else 0.0
        return True


class BatchSwitch(Switch):
    def __call__(self, integrator, direction, lane):
        integrator.pars[1, lane] = self.beta if direction > 0 else 0.0
        return True


def scalar(p, omegas, periods):
    """run(threads) that gives the strobes of every column from the start on."""
    rates, guard = equations(p)
    event = hy.t_event(guard, callback=Switch(p["beta"]))
    integrator = hy.taylor_adaptive(
        rates, [0.0, 0.0], pars=[1.0, 0.0], t_events=[event], fast_math=True
    )
    grid = 2.0 * np.pi * np.arange(periods + 1)

    def begin(one, i):
        one.pars[0] = omegas[i]
        return one

    def run(threads):
        found = hy.ensemble_propagate_grid(
            integrator, grid, omegas.size, begin, max_workers=threads
        )
        return np.array([each[-1] for each in found])

    return run


def batch(p, omegas, periods):
    """The same with several columns in the lanes of a vector."""
    rates, guard = equations(p)
    size = hy.recommended_simd_size()
    event = hy.t_event_batch(guard, callback=BatchSwitch(p["beta"]))
    pars = np.zeros((2, size))
    pars[0] = 1.0
    integrator = hy.taylor_adaptive_batch(
        rates, np.zeros((2, size)), pars=pars, t_events=[event], fast_math=True
    )
    grid = 2.0 * np.pi * np.arange(periods + 1)
    padded = np.append(omegas, np.full(-omegas.size % size, omegas[-1])).reshape(-1, size)

    def begin(several, i):
        several.pars[0] = padded[i]
        return several

    def run(threads):
        found = hy.ensemble_propagate_grid_batch(
            integrator, grid, len(padded), begin, max_workers=threads
        )
        # (period, state, lane) of each batch
        strobes = np.stack([each[-1] for each in found])
        strobes = strobes.transpose(0, 3, 1, 2).reshape(padded.size, -1, 2)
        return strobes[: omegas.size]

    return run
