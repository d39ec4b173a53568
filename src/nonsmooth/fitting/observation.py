"""Observed quantities on samples of a motion, and their partial derivatives.

The engine differentiates motions. An observed quantity is an explicit formula of a state, the
parameters and time, smooth within a mode, so central differences of the formula alone lose nothing
that a fit could see: about ten digits are left.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError, OptionError, quote
from nonsmooth.runs.outputs import SweptClock, output_values
from nonsmooth.system.system import System

__all__ = ["MotionSamples", "Observation", "Observed"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_ROUNDING = 1e-12  # of a quantity, that its change over a turn may differ by
_STEP = 6e-6  # cube root of the rounding unit: errors of rounding and of the step are alike


class MotionSamples(NamedTuple):
    """States of a motion at K instants, each in a mode."""

    number: Integers  # (K,)
    phase: Floats  # (K,)
    modes: Integers  # (K,)
    states: Floats  # (K, n)


class Observed(NamedTuple):
    """C quantities at K samples, with derivatives by states, parameters and time."""

    values: Floats  # (C, K)
    by_state: Floats  # (C, K, n)
    by_parameter: Floats  # (C, K, p)
    in_time: Floats  # (C, K): rate along the motion; nan where it was not asked for


class Observation:
    """Values of expressions on samples of motions of a system."""

    def __init__(
        self, system: System, texts: Mapping[str, str], chosen: Sequence[str], *, rates: bool
    ) -> None:
        self.chosen, self.rates = tuple(chosen), rates
        taken = {*system.states, *system.outputs, *system.definitions, *system.parameters}
        self.names = [_new_name(f"observed_{k}", taken) for k in range(len(texts))]
        outputs = dict(zip(self.names, texts.values(), strict=True))
        self.rate_names = [_new_name(f"rate_of_{state}", taken) for state in system.states]
        if rates:
            pairs = zip(self.rate_names, system.states, strict=True)
            outputs |= {name: f"rate({state})" for name, state in pairs}
        self.system = _with_outputs(system, outputs, texts)

    def look(
        self, samples: MotionSamples, window: float, values: Mapping[str, float], step: float
    ) -> Observed:
        """Quantities and their derivatives; ``step`` is a short time."""
        n, p, count = samples.states.shape[1], len(self.chosen), samples.modes.size
        sizes = np.abs(samples.states).max(axis=0, initial=0.0)
        steps = [_STEP * (size or 1.0) for size in sizes]
        steps += [_STEP * max(abs(values[name]), 1e-3) for name in self.chosen]
        if self.rates:
            steps.append(_STEP**0.5 * step)
        variants = 1 + 2 * len(steps)
        states = np.tile(samples.states.T[:, None, :], (1, variants, 1))
        phase = np.tile(samples.phase, (variants, 1))
        parameters = {name: np.full((variants, count), value) for name, value in values.items()}
        for j, size in enumerate(steps):
            for row, change in ((1 + 2 * j, size), (2 + 2 * j, -size)):
                if j < n:
                    states[j, row] += change
                elif j < n + p:
                    parameters[self.chosen[j - n]][row] += change
                else:
                    phase[row] += change
        clock = SweptClock(
            np.tile(samples.number, variants), phase.ravel(), np.full(phase.size, window),
            {name: each.ravel() for name, each in parameters.items()},
        )  # fmt: skip
        found = output_values(
            self.system, clock, states.reshape(n, -1), np.tile(samples.modes, variants)
        )
        shaped = np.stack([found[name].reshape(variants, count) for name in self.names])
        by = [
            (shaped[:, 1 + 2 * j] - shaped[:, 2 + 2 * j]) / (2.0 * size)
            for j, size in enumerate(steps)
        ]
        of = shaped.shape[0]
        by_state = np.stack(by[:n], axis=-1)
        by_parameter = np.stack(by[n : n + p], axis=-1) if p else np.zeros((of, count, 0))
        in_time = np.full((of, count), np.nan)
        if self.rates:
            rates = np.stack([found[name][:count] for name in self.rate_names], axis=-1)
            in_time = by[-1] + np.einsum("ckn,kn->ck", by_state, rates)
        return Observed(shaped[:, 0], by_state, by_parameter, in_time)

    def turns(
        self, samples: MotionSamples, window: float, values: Mapping[str, float], periods: Floats
    ) -> Floats:
        """How far each quantity goes while an angle goes on by its period, (C,).

        Zero where it comes back, as a sine does, and where that depends on the state. Of several
        angles the shortest way counts.

        shapes: periods (n,), zero of states that are no angles
        """
        found = np.zeros(len(self.names))
        for i in np.flatnonzero(periods).tolist():
            states = np.concatenate(
                [samples.states, samples.states + periods * np.eye(periods.size)[i]]
            )
            number, modes = np.tile(samples.number, 2), np.tile(samples.modes, 2)
            phase = np.tile(samples.phase, 2)
            constants = {name: np.full(phase.size, value) for name, value in values.items()}
            clock = SweptClock(number, phase, np.full(phase.size, window), constants)
            seen = output_values(self.system, clock, states.T, modes)
            here, there = np.split(np.stack([seen[name] for name in self.names]), 2, axis=1)
            change, size = there - here, np.abs(here).max(axis=1) + np.abs(there).max(axis=1)
            way = np.abs(change.mean(axis=1))
            steady = np.ptp(change, axis=1) <= _ROUNDING * size
            way = np.where(steady & (way > _ROUNDING * size), way, 0.0)
            found = np.where((found == 0.0) | ((way > 0.0) & (way < found)), way, found)
        return found


def _new_name(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "_"
    return name


def _with_outputs(system: System, outputs: Mapping[str, str], texts: Mapping[str, str]) -> System:
    """The system with more outputs, whose modes must stay what they are."""
    for channel, text in texts.items():
        own = next(iter(outputs))
        try:
            replace(system, outputs={**system.outputs, own: text})
        except ModelError as fault:
            told = str(fault).removeprefix(f"outputs[{own!r}]: ").replace(f" {own},", "")
            raise OptionError(
                f"observe[{channel!r}] = {quote(text)} is no expression of states, outputs,"
                f" parameters and rates of states: {told}"
            ) from None
    found = replace(system, outputs={**system.outputs, **outputs})
    if found.mode_names != system.mode_names:
        raise OptionError(
            "observe: an expression has a switch of its own, which splits the modes of the system;"
            " declare it as an output of the system"
        )
    return found
