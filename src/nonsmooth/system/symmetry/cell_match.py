"""Whether a symmetry takes the equations of one cell to those of another, at random points."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any
from zlib import crc32

import numpy as np
import numpy.typing as npt

from nonsmooth.system.compile.mode_forms import ModeForms
from nonsmooth.system.symmetry.cell_exits import ENOUGH, LiveExits
from nonsmooth.system.symmetry.cell_values import CellValues, ValuesAt
from nonsmooth.system.symmetry.state_map import StateMap

__all__ = ["CellMatch", "Fault", "Place", "match", "random_place"]

Floats = npt.NDArray[np.float64]

# Sizes of the states, in turn from point to point: beside large states a small constant force would
# be rounding, beside small ones a cubic.
_SCALES = np.tile([1.7, 0.17, 1.7e-2, 1.7e-4, 1.7e-6, 1.7e-8], 4)
# Of the sizes of the terms. Each operation rounds by 1.1e-16 of them and an angle of up to a
# thousand turns by as much of itself, so ten thousand operations stay below.
_TOLERANCE = 1e-9


@dataclass(frozen=True)
class Place:
    """K random points of a cell with their values, and their images under a symmetry."""

    states: Floats  # (n, K)
    times: Floats  # (K,)
    image: Mapping[str, Any]  # values by name
    values: ValuesAt
    sizes: ValuesAt


@dataclass(frozen=True)
class Fault:
    """An equation that a symmetry does not take to its image, at the point where it is worst."""

    where: str
    found: float
    wanted: float
    point: int


@dataclass
class CellMatch:
    """What becomes of the exits of a cell in another one, and the equations that differ."""

    exits: dict[int, list[int]] = field(default_factory=dict)  # candidates for each exit
    faults: list[Fault] = field(default_factory=list)


class _Point(dict[str, Any]):
    """Values by name; signals, which both sides read at one time, have random ones."""

    def __missing__(self, name: str) -> Floats:
        return _random(name)


def random_place(
    cell: CellValues, mapped: StateMap, names: Mapping[str, float], shift: float, span: float
) -> Place:
    """Points of a cell that lie on its relations, at times from 0 to ``span``.

    ``names`` are the parameters with their values. The images are ``shift`` later.
    """
    states = cell.forms.graph.states
    point = _Point(names)
    times = point["t"] = np.abs(_random("t")) * span
    point |= {state: _SCALES * _random(state) for state in states}
    cell.put_on_relations(point, _SCALES.size)
    there = np.array([point[state] for state in states])
    image = _Point(names)
    image |= {"t": times + shift} | dict(zip(states, mapped(there.T).T, strict=True))
    return Place(there, times, image, *cell.at(point, _SCALES.size))


@lru_cache(maxsize=1024)
def _random(name: str) -> Floats:
    """Values from -1 to 1, the same ones whenever a name is asked for."""
    return np.random.default_rng(crc32(name.encode())).uniform(-1.0, 1.0, _SCALES.size)


def match(
    cell: CellValues, other: CellValues, place: Place, mapped: StateMap,
    live: tuple[LiveExits, LiveExits],
) -> CellMatch:  # fmt: skip
    """Compare the image of one cell with another cell, equation by equation.

    ``live`` are the exits of both that can be passed.
    """
    values, sizes = other.at(place.image, _SCALES.size)
    able = place.values.finite & values.finite
    mode = other.forms.name
    if np.count_nonzero(able) < ENOUGH:
        where = f"a value of every equation of mode {mode!r} at {ENOUGH} points"
        return CellMatch(faults=[Fault(where, np.nan, np.nan, 0)])
    compare = _Comparison(able)
    found = CellMatch()
    slaved = [*other.relations.explicit, *other.relations.implicit]
    for gap, size, state in zip(values.relations, sizes.relations, slaved, strict=True):
        where = f"what is left of the slaved equation of {state!r} in mode {mode!r}"
        found.faults += compare.of(where, gap, np.zeros_like(gap), size)
    wanted = mapped.matrix @ place.values.rates
    allowed = np.abs(mapped.matrix) @ place.sizes.rates + sizes.rates
    for i, state in enumerate(other.forms.graph.states):
        where = f"the rate of {state!r} in mode {mode!r}"
        found.faults += compare.of(where, values.rates[i], wanted[i], allowed[i])
    theirs = {k: _Exit.of(values, sizes, k) for k in live[1].numbers}
    for e in live[0].numbers:
        wanted_exit = _Exit.of(place.values, place.sizes, e).mapped(mapped)
        alike = {k: theirs[k] for k in _of_one_sort(cell.forms, other.forms, e, live)}
        candidates, fault = _images_of_exit(wanted_exit, alike, other.forms, compare)
        found.exits[e] = candidates
        if fault is not None:
            name = cell.forms.exit_names[e]
            what = f"{fault.where}, the image of {name!r} of mode {cell.forms.name!r},"
            found.faults.append(Fault(what, fault.found, fault.wanted, fault.point))
    return found


class _Comparison:
    """Compares values at the points that have some."""

    def __init__(self, able: npt.NDArray[np.bool_]) -> None:
        self.able = able

    def of(self, where: str, value: Floats, wanted: Floats, sizes: Floats) -> Iterator[Fault]:
        """The fault of values that differ by more than rounding of terms of these sizes."""
        with np.errstate(all="ignore"):
            gap = np.where(self.able, np.abs(value - wanted), 0.0)
            beyond = np.where(self.able, gap > _TOLERANCE * sizes, False)
        if beyond.any():
            k = int(np.argmax(np.where(beyond, gap, -1.0)))
            yield Fault(where, float(value[k]), float(wanted[k]), k)

    def guards(self, where: str, one: _Exit, wanted: _Exit) -> Fault | None:
        """The fault of a guard that is not another one times a positive number."""
        k = int(np.argmax(np.where(self.able, np.abs(wanted.guard), -1.0)))
        factor = one.guard[k] / wanted.guard[k] if wanted.guard[k] != 0.0 else 1.0
        if not factor > 0.0:
            return Fault(where, float(one.guard[k]), float(wanted.guard[k]), k)
        sizes = one.guard_size + factor * wanted.guard_size
        return next(self.of(where, one.guard, factor * wanted.guard, sizes), None)


@dataclass(frozen=True)
class _Exit:
    """A guard and the state behind its exit at K points, with sizes of their terms."""

    guard: Floats  # (K,)
    guard_size: Floats
    behind: Floats  # (n, K)
    behind_size: Floats

    @classmethod
    def of(cls, values: ValuesAt, sizes: ValuesAt, e: int) -> _Exit:
        return cls(values.guards[e], sizes.guards[e], values.behind[e], sizes.behind[e])

    def mapped(self, by: StateMap) -> _Exit:
        """The same guard, and the image of the state behind it."""
        offset = by.offset[:, None]
        size = np.abs(by.matrix) @ self.behind_size + np.abs(offset)
        return _Exit(self.guard, self.guard_size, by.matrix @ self.behind + offset, size)


def _images_of_exit(
    wanted: _Exit, others: Mapping[int, _Exit], theirs: ModeForms, compare: _Comparison
) -> tuple[list[int], Fault | None]:
    """Exits of another cell that an exit may become, or the fault of the nearest where none may."""
    candidates: list[int] = []
    guard_fault = reset_fault = None
    for k, other in others.items():
        place = f"the exit {theirs.exit_names[k]!r} of mode {theirs.name!r}"
        fault = compare.guards(f"the guard of {place}", other, wanted)
        if fault is not None:
            guard_fault = guard_fault or fault
            continue
        for i, state in enumerate(theirs.graph.states):
            size = wanted.behind_size[i] + other.behind_size[i]
            where = f"{state!r} behind {place}"
            fault = next(compare.of(where, other.behind[i], wanted.behind[i], size), None)
            if fault is not None:
                reset_fault = reset_fault or fault
                break
        else:
            candidates.append(k)
    if candidates:
        return candidates, None
    missing = Fault(f"an exit of mode {theirs.name!r}", np.nan, np.nan, 0)
    return [], reset_fault or guard_fault or missing


def _of_one_sort(
    ours: ModeForms, theirs: ModeForms, e: int, live: tuple[LiveExits, LiveExits]
) -> list[int]:
    """Exits of another cell that the engine treats as it does one of these."""
    return [
        k
        for k in live[1].numbers
        if (k < theirs.n_searched) == (e < ours.n_searched)
        and theirs.choices[k] == ours.choices[e]
        and (live[1].onto[k] < 0) == (live[0].onto[e] < 0)
    ]
