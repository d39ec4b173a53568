"""Compiling the kernels of periodic orbits ahead of time."""

from __future__ import annotations

import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np

from nonsmooth.periodic.equations import OrbitEquations, Turn
from nonsmooth.periodic.legs import Legs
from nonsmooth.periodic.multipliers import floquet
from nonsmooth.periodic.word import Word
from nonsmooth.simulation.warmup import warm_up, warm_up_loop
from nonsmooth.system.parts import Mode
from nonsmooth.system.system import System

__all__ = ["warm_up_all", "warm_up_orbits"]


def warm_up_all() -> float:
    """Compile every kernel, on two cores where there are two.

    Returns
    -------
    float
        Seconds; a few when the kernels were compiled already.
    """
    began = time.monotonic()
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as other:
        loop = other.submit(warm_up_loop)  # which is half of all
        warm_up_orbits()
        loop.result()
    warm_up()
    return time.monotonic() - began


def warm_up_orbits() -> float:
    """Compile what `find_orbit` and `continue_orbit` need, beside the kernels of runs.

    Returns
    -------
    float
        Seconds; some hundredths when the kernels were compiled already.
    """
    began = time.monotonic()
    driven = System(
        states=["x"],
        parameters={"k": 1.0},
        period="2*pi",
        modes={"decay": Mode({"x": "cos(t) - k*x"})},
    )
    legs = Legs(driven, ("k",))
    legs.set_values(driven.parameter_values)
    word, turn = Word((0,), ((),)), Turn(np.array([[0.5]]), np.array([0.0, 2.0 * np.pi]))
    equations = OrbitEquations(legs, word, period=1)
    equations.evaluate(equations.pack(turn))
    assert equations.results is not None
    floquet(equations, equations.results)
    legs.minima(word, turn.states, turn.instants)
    return time.monotonic() - began
