"""The legs of an orbit for one set of parameter values: where they lead, and all derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.derivatives import allocate_rates, allocate_scratch, set_up_rates
from nonsmooth.engine.lanes import allocate_segment, allocate_tangent
from nonsmooth.engine.orbits import (
    LegResults,
    WordLegs,
    allocate_leg_results,
    fill_minima,
    pass_legs,
)
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import allocate_tables, set_up
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.system.model.value_checks import first_unmet
from nonsmooth.system.system import System

__all__ = ["LegError", "Legs", "Minima", "balanced_units"]

Floats = npt.NDArray[np.float64]

_MOST_UNIT = 2.0**60  # of a state; farther apart are states that a motion hardly couples
_PARTS = (0.139, 0.382, 0.618)  # of a leg, few whole or half turns of which are such too
_NEAR = 0.25  # of the way to an end of a leg, within which a minimum is near to where it was
_CLOSER = 14  # halvings of a leg towards its ends, where minima are looked for closely


class LegError(ArithmeticError):
    """Legs that cannot be passed: a parameter, a relation or a series fails there."""


class Minima(NamedTuple):
    """Lowest interior minima of guards, nan where there is none."""

    values: Floats
    places: Floats  # time since the leg began


class Legs:
    """Passes the legs of words of one system, with derivatives by some parameters.

    Arrays are made once; what a pass returns is overwritten by the next one.
    """

    def __init__(self, system: System, chosen: Sequence[str] = ()) -> None:
        program = system.compiled.program
        names = list(system.parameters)
        numbers = np.array([names.index(name) for name in chosen], np.int64)
        self.system, self.chosen = system, tuple(chosen)
        self.n, self.n_rates = len(system.states), len(self.chosen)
        self.tables = allocate_tables(program)
        self.rates = allocate_rates(program, numbers)
        self._program, self._stack = program, self.tables.as_lanes
        self._scratch = allocate_scratch(program, numbers)
        self._segment = allocate_segment(program.sizes, self.n_rates)
        self._tangent = allocate_tangent(program.sizes, self.n_rates, 1)
        self._no_tangent = allocate_tangent(program.sizes, -1, 0)
        self._results: dict[int, LegResults] = {}
        self._names = names
        self._values, self._is_set_up = np.zeros((1, len(names))), False

    @property
    def values(self) -> Floats:
        """Values of all parameters for which the tables stand."""
        return self._values[0]

    def set_values(self, values: Mapping[str, float] | Floats) -> None:
        """Set up the tables for other values of the parameters; `LegError` where that fails."""
        given = values if isinstance(values, np.ndarray) else [values[name] for name in self._names]
        new = np.asarray(given, float)[None]
        if self._is_set_up and np.array_equal(new, self._values):
            return
        self._is_set_up = False
        code, _, _ = set_up(self._program, new, self._stack)
        if code == Status.COMPLETED:
            code, _ = set_up_rates(self._program, new[0], self.tables, self.rates)
        if code != Status.COMPLETED:
            raise LegError("the coefficients are not finite for these parameters")
        self._values[:] = new
        self._is_set_up = True

    def require(self, values: Floats) -> None:
        """Do nothing where the system takes values of its parameters; `LegError` elsewhere."""
        required = self.system.require
        unmet = required and first_unmet(
            required, dict(zip(self._names, values.tolist(), strict=True))
        )
        if unmet:
            raise LegError(unmet)

    @property
    def window(self) -> float:
        """Period of the forcing, or the window of a system without one."""
        return self.tables.window

    @property
    def period_rates(self) -> Floats:
        """Derivatives of the period by the chosen parameters, zero without a period."""
        slot = self._program.period_slot
        return self.rates.slot_rates[slot] if slot >= 0 else np.zeros(self.n_rates)

    def follow(self, word: Word, states: Floats, instants: Floats) -> LegResults:
        """Pass all legs of a word, each from its own start.

        shapes: states (L, n), instants (L + 1,)
        """
        return self.follow_each(word, states, instants[:-1], instants[1:])

    def follow_each(self, word: Word, states: Floats, begins: Floats, ends: Floats) -> LegResults:
        """Pass legs that need not follow one another.

        shapes: states (L, n), begins and ends (L,)
        """
        results = self._room(len(word))
        self._pass(_legs_of(word, states, begins, ends), len(word), results)
        return results

    def coupling(self, word: Word, states: Floats, instants: Floats) -> Floats:
        """How much of each state parts of the legs make of a unit of each, in moduli, (n, n).

        A whole turn may make nothing of a state that it swings through. What the last pass
        returned is left as it is.
        """
        results = allocate_leg_results(self._program.sizes, self.n_rates, len(word))
        made = np.zeros((self.n, self.n))
        for part in _PARTS:
            ends = instants[:-1] + part * np.diff(instants)
            self._pass(_legs_of(word, states, instants[:-1], ends), len(word), results)
            made = np.maximum(made, np.abs(results.flow[:, : self.n]).max(axis=0).T)
        return made

    def minima(self, word: Word, states: Floats, instants: Floats) -> Minima:
        """Lowest interior minimum of each guard in each leg, and the time since the leg began.

        shapes: both (L, e), nan where there is none
        """
        shape = (len(word), self._program.sizes.exits)
        lowest, places = np.full(shape, np.nan), np.full(shape, np.nan)
        fill_minima(
            self.tables, self.rates, self._segment, self._no_tangent,
            _legs_of(word, states, instants[:-1], instants[1:]), lowest, places,
        )  # fmt: skip
        return Minima(lowest, places)

    def closer_minima(self, mode: int, state: Floats, begin: float, end: float) -> Minima:
        """The same of one leg, looked for close to its ends too.

        Behind a slow impact a guard rises and falls again before the search for minima has looked
        twice. Pieces of the leg become shorter towards its ends, each with a search of its own.
        """
        part = 0.5 ** np.arange(_CLOSER, 0, -1)
        cuts = begin + (end - begin) * np.concatenate([part, 1.0 - part[-2::-1]])
        whole = Word((mode,) * len(cuts), ((),) * len(cuts))
        states = np.tile(state, (len(cuts), 1))
        there = self.follow_each(whole, states, np.full(len(cuts), begin), cuts).ends
        pieces = Word((mode,) * (len(cuts) + 1), ((),) * (len(cuts) + 1))
        instants = np.concatenate([[begin], cuts, [end]])
        lowest, places = self.minima(pieces, np.vstack([state, there]), instants)
        places = places + (instants[:-1] - begin)[:, None]
        first = np.argmin(np.where(np.isnan(lowest), np.inf, lowest), axis=0)
        columns = np.arange(lowest.shape[1])
        return Minima(lowest[first, columns], places[first, columns])

    def minima_near(
        self, mode: int, state: Floats, begin: float, end: float, place: float
    ) -> Minima:
        """The same of one leg, near a time since it began.

        A guard may have a lower value elsewhere, as just behind the start, where it is zero itself.
        """
        width = _NEAR * min(place, end - begin - place)
        cuts = begin + place + np.array([-width, width])
        word = Word((mode,), ((),))
        there = self.follow_each(word, state[None], np.array([begin]), cuts[:1]).ends.copy()
        found = self.minima(word, there, cuts)
        return Minima(found.values[0], found.places[0] + place - width)

    def _pass(self, legs: WordLegs, count: int, results: LegResults) -> None:
        passed = pass_legs(
            self.tables, self.rates, self._scratch, self._segment, self._tangent, legs, results
        )
        if passed < count:
            raise LegError(f"leg {passed} of the orbit cannot be passed")

    def _room(self, count: int) -> LegResults:
        if count not in self._results:
            sizes = self._program.sizes
            self._results[count] = allocate_leg_results(sizes, self.n_rates, count)
        return self._results[count]


def _legs_of(word: Word, states: Floats, begins: Floats, ends: Floats) -> WordLegs:
    states, begins, ends = (np.ascontiguousarray(each, float) for each in (states, begins, ends))
    return WordLegs(word.mode_array, word.path_array, states, begins, ends)


def balanced_units(coupling: Floats) -> Floats:
    """Powers of two as units of the states, in which no part of a matrix drowns another.

    shapes: coupling (n, n), not negative; returns (n,)
    """
    from scipy.linalg.lapack import dgebal

    if len(coupling) == 0 or not np.all(np.isfinite(coupling)):
        return np.ones(len(coupling))
    _, _, _, units, _ = dgebal(coupling, scale=1, permute=0)
    return np.clip(units, 1.0 / _MOST_UNIT, _MOST_UNIT)
