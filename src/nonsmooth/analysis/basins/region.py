"""Regions of initial states: a box to draw starts from, or a grid of cells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.stats import qmc

from nonsmooth.analysis.options import completion_rule
from nonsmooth.errors import OptionError, quote, unknown_name
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.options import finite_number
from nonsmooth.runs.runner import build_tables
from nonsmooth.runs.start import complete_state
from nonsmooth.system.system import System
from nonsmooth.system.text.evaluate import evaluate
from nonsmooth.system.text.expressions import Expression

__all__ = ["Box", "Grid", "admissible_starts", "read_box", "read_grid"]

Floats = npt.NDArray[np.float64]

_MOST_CELLS = 5e7  # some tens of bytes each

_MOST_DRAWN = 50  # times as many as are wanted


@dataclass(frozen=True)
class Completion:
    """What the states outside a region are: functions of those inside, and of parameters."""

    system: System
    given: tuple[str, ...]  # states of the region
    rules: Mapping[str, Expression | float]  # of the others
    texts: Mapping[str, str]  # as they were written

    def states(self, values: Floats) -> Floats:
        """Whole states for values of those in the region.

        shapes: values (N, d), returns (N, n)
        """
        known: dict[str, Any] = {
            **self.system.parameter_values,
            **{name: values[:, k] for k, name in enumerate(self.given)},
        }
        for name, rule in self.rules.items():
            value = rule if isinstance(rule, float) else evaluate(rule, known)
            known[name] = np.broadcast_to(np.asarray(value, float), len(values))
        whole = np.column_stack([known[name] for name in self.system.states])
        # nan stands for a state whose place follows from the others when the run begins
        follows = np.isnan([self.system.open_state[name] for name in self.system.states])
        follows &= [name not in (*self.given, *self.texts) for name in self.system.states]
        if not np.all(np.isfinite(whole) | follows):
            row, column = np.argwhere(~(np.isfinite(whole) | follows))[0]
            name = self.system.states[column]
            given = ", ".join(f"{n} = {v:g}" for n, v in zip(self.given, values[row], strict=True))
            raise OptionError(
                f"completion[{name!r}] = {quote(self.texts.get(name))} is {whole[row, column]} at"
                f" {given}; write it so that it is finite in the whole region"
            )
        return whole


@dataclass(frozen=True)
class Box:
    """Intervals from which starts are drawn."""

    low: Floats  # (d,)
    high: Floats
    completion: Completion

    def states(self, unit: Floats) -> Floats:
        """States for points of the unit cube; shapes: unit (N, d), returns (N, n)."""
        return self.completion.states(self.low + unit * (self.high - self.low))


@dataclass(frozen=True)
class Grid:
    """Values of some states, each combination a cell; the last state varies slowest."""

    axes: tuple[Floats, ...]
    completion: Completion

    @property
    def shape(self) -> tuple[int, ...]:
        """Cells along each axis, the first one last, as pictures have it."""
        return tuple(axis.size for axis in reversed(self.axes))

    @property
    def size(self) -> int:
        """Number of cells."""
        return int(np.prod(self.shape))

    @property
    def lower_ends(self) -> list[float]:
        """Where the first cells along each axis begin, half a cell before their centres."""
        return [float(1.5 * axis[0] - 0.5 * axis[1]) for axis in self.axes]

    def values(self, cells: npt.NDArray[np.int64]) -> Floats:
        """Values at the centres of cells given by number; returns (N, d)."""
        places = np.unravel_index(cells, self.shape)
        return np.column_stack([a[i] for a, i in zip(self.axes, reversed(places), strict=True)])

    def inner_states(self, cells: npt.NDArray[np.int64], side: int) -> Floats:
        """States at points spread evenly within cells, so many along each side; (N, P, n)."""
        places = reversed(np.unravel_index(cells, self.shape))
        along = []
        for axis, place in zip(self.axes, places, strict=True):
            middle = (axis[1:] + axis[:-1]) / 2.0
            border = np.concatenate(
                [[2 * axis[0] - middle[0]], middle, [2 * axis[-1] - middle[-1]]]
            )
            part = (np.arange(side) + 0.5) / side
            along.append(border[place, None] + part * (border[place + 1] - border[place])[:, None])
        number = np.indices((side,) * len(along)).reshape(len(along), -1)
        values = np.stack([a[:, i] for a, i in zip(along, number, strict=True)], axis=2)
        whole = self.completion.states(values.reshape(-1, len(along)))
        return whole.reshape(len(cells), -1, whole.shape[1])

    def cells(self, values: Floats) -> npt.NDArray[np.int64]:
        """Numbers of the cells in which values lie, -1 outside; shapes: values (N, d).

        Borders lie half way between centres; the outermost cells are as wide as their neighbours.
        """
        places, inside = [], np.ones(len(values), bool)
        for axis, column in zip(self.axes, values.T, strict=True):
            middle = (axis[1:] + axis[:-1]) / 2.0
            place = np.searchsorted(middle, column, side="right")
            inside &= (column >= 2.0 * axis[0] - middle[0]) & (column < 2.0 * axis[-1] - middle[-1])
            places.append(np.where(inside, place, 0))
        numbers = np.ravel_multi_index(tuple(reversed(places)), self.shape)
        return np.where(inside, numbers, -1).astype(np.int64)

    def states(self, cells: npt.NDArray[np.int64]) -> Floats:
        """States at the centres of cells given by number; returns (N, n)."""
        return self.completion.states(self.values(cells))


def read_completion(system: System, given: tuple[str, ...], texts: Any) -> Completion:
    """Rules for the states that a region leaves open; those without one are at rest."""
    if texts is not None and not isinstance(texts, Mapping):
        raise OptionError(
            f"completion = {quote(texts)}: give a mapping of states to numbers or expressions, such"
            f" as {{{system.states[-1]!r}: 0.0}}"
        )
    rules: dict[str, Expression | float] = {}
    known = [*system.parameter_values, *given]
    for name, text in (texts or {}).items():
        if name not in system.states:
            raise OptionError(f"completion: {unknown_name('state', name, system.states)}")
        if name in given:
            raise OptionError(f"completion: {name!r} is in the region already; leave one out")
        rules[name] = _rule(name, text, known)
        known.append(name)
    for name in system.states:
        if name not in given and name not in rules:
            rules[name] = system.open_state[name]
    return Completion(system, given, rules, {k: str(v) for k, v in (texts or {}).items()})


def _rule(name: str, text: Any, known: list[str]) -> Expression | float:
    place = f"completion[{name!r}]"
    if not isinstance(text, str):
        return finite_number(place, text)
    return completion_rule(place, text, known, "states of the region")


def _check_names(system: System, region: Any, least: int) -> tuple[str, ...]:
    if not isinstance(region, Mapping) or len(region) < least:
        what = "one state" if least == 1 else "two states"
        raise OptionError(
            f"region = {quote(region)}: give a mapping of at least {what} to ranges, such as"
            f" {{{system.states[0]!r}: (-1.0, 1.0)}}"
        )
    for name in region:
        if name not in system.states:
            raise OptionError(f"region: {unknown_name('state', name, system.states)}")
    return tuple(region)


def read_box(system: System, region: Any, completion: Any) -> Box:
    """Box of starts from a mapping of states to ranges, or to rising values whose ends count."""
    names = _check_names(system, region, least=1)
    ends = [_ends(name, region[name]) for name in names]
    low, high = np.array(ends, float).T
    return Box(low, high, read_completion(system, names, completion))


def _ends(name: str, given: Any) -> tuple[float, float]:
    values = _numbers(name, given)
    if isinstance(given, tuple) and values.size != 2:
        raise OptionError(
            f"region[{name!r}] = {quote(given)}: give two numbers, the lower one first, or fix the"
            " state by completion="
        )
    low, high = float(values[0]), float(values[-1])
    if values.size < 2 or np.any(np.diff(values) < 0.0) or low == high:
        raise OptionError(
            f"region[{name!r}] = {quote(given)} is empty or not in order; give two numbers, the"
            " lower one first, or fix the state by completion="
        )
    return low, high


def read_grid(system: System, region: Any, completion: Any, least: int = 2) -> Grid:
    """Grid of cells from a mapping of states to increasing values."""
    names = _check_names(system, region, least)
    axes = []
    for name in names:
        values = _numbers(name, region[name])
        if isinstance(region[name], tuple) and _is_range(region[name]):
            count = region[name][2] if values.size > 2 else 200
            raise OptionError(
                f"region[{name!r}] = {quote(region[name])} is a range, and a grid needs the value"
                f" of each row of cells, such as np.linspace({values[0]:g}, {values[1]:g}, {count})"
            )
        if values.size < 2 or np.any(np.diff(values) <= 0.0):
            raise OptionError(
                f"region[{name!r}]: give at least two increasing values, one for each row of cells,"
                " such as np.linspace(-1, 1, 200)"
            )
        axes.append(values)
    count = np.prod([float(axis.size) for axis in axes])
    if count > _MOST_CELLS:
        raise OptionError(
            f"region: {' x '.join(str(axis.size) for axis in axes)} are {count:.3g} cells; at most"
            f" {_MOST_CELLS:.0e} fit; take fewer values, or a part of the region"
        )
    return Grid(tuple(axes), read_completion(system, names, completion))


def _is_range(given: tuple[Any, ...]) -> bool:
    """Whether a tuple is meant as two ends, or as two ends and a number of rows."""
    if len(given) == 3:
        return (
            isinstance(given[2], int)
            and given[2] > 1
            and given[2] - given[1] != given[1] - given[0]
        )
    return len(given) == 2


def _numbers(name: str, given: Any) -> Floats:
    try:
        values = np.asarray(given, dtype=float)
    except (TypeError, ValueError, OverflowError):
        values = np.array(np.nan)
    if values.ndim != 1 or values.size == 0 or not np.all(np.isfinite(values)):
        raise OptionError(
            f"region[{name!r}] = {quote(given)}: give a range of finite numbers, such as"
            " (-1.0, 1.0), or a list of values"
        )
    return values


def admissible_starts(
    runner: Any, box: Box, count: int, seed: int
) -> tuple[npt.NDArray[np.float64], int]:
    """Starts from a scrambled Sobol sequence, and how many were drawn for them.

    Such points fill a box more evenly than random ones, so that what is larger than a few of
    their gaps is not missed.

    returns: states (count, n), number drawn
    """
    sequence = qmc.Sobol(len(box.low), rng=np.random.default_rng(seed))
    found, n_found, drawn = [], 0, 0
    while n_found < count and drawn < _MOST_DRAWN * count:
        # powers of two keep the balance of the sequence
        batch = box.states(sequence.random(2 ** max(6, int(np.ceil(np.log2(count))))))
        batch = _completed(runner, box, batch)
        admitted = runner.admits(batch)
        found.append(batch[admitted][: count - n_found])
        n_found += len(found[-1])
        last = np.flatnonzero(admitted)[len(found[-1]) - 1] if n_found >= count else len(batch) - 1
        drawn += int(last) + 1
    if n_found == 0:
        raise OptionError(
            f"no mode admits any of {drawn} starts in the region; choose another region, or"
            " complete the other states so that starts are admissible, as in"
            " completion={'q': 'max(0, p - g)'}"
        )
    return np.concatenate(found), drawn


def _completed(runner: Any, box: Box, states: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """States with those that were left to the equations of a mode, given as nan, solved for."""
    if not np.any(np.isnan(states)):
        return states
    system = box.completion.system
    tables, begin = build_tables(system), getattr(runner, "begin", Instant(0, 0.0))
    return np.array([complete_state(system, tables, state, begin) for state in states])
