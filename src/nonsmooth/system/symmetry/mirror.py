"""A declared symmetry, checked: which mode and which exit is the image of which.

Orbits, branches and attractors ask it for their mirror images. A cell has an image where its rates,
relations, guards and resets map onto those of another cell; guards may differ by a positive factor.
What agrees at random points agrees everywhere, but for a set of measure zero.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from nonsmooth.engine.tables import FREE
from nonsmooth.errors import ModelError
from nonsmooth.system.compile.mode_forms import ModeForms
from nonsmooth.system.model.evaluated import EvaluatedSystem
from nonsmooth.system.symmetry.cell_exits import ENOUGH, is_empty, live_exits
from nonsmooth.system.symmetry.cell_match import CellMatch, Fault, Place, match, random_place
from nonsmooth.system.symmetry.cell_values import cell_values
from nonsmooth.system.symmetry.state_map import Floats, StateMap, read_state_map

__all__ = ["Mirror", "find_mirror"]

_SPAN = 5.0  # of time at which equations are compared where no period is declared
_MOST_SHOWN = 6  # states of a point in a message

_Matches = dict[tuple[int, int], CellMatch]
_CURE = "correct the map or the equation, or leave symmetry= out"


@dataclass(frozen=True)
class Mirror:
    """What a symmetry does to states, modes and exits.

    A motion x(t) has the image ``states(x(t - shift))``, ``shift`` being half a period or zero.
    """

    states: StateMap
    half_period: bool
    modes: tuple[int, ...]  # number of the image of each mode that runs; -1 where no point lies
    exits: tuple[tuple[int, ...], ...]  # likewise of each exit of it; -1 where none is passed
    targets: tuple[tuple[int, ...], ...]  # modes that exits lead to, -1 where they end the run
    settling: tuple[tuple[bool, ...], ...]  # whether an exit leads to another cell, and no more

    @property
    def text(self) -> str:
        """The symmetry in words."""
        return _in_words(self.states, self.half_period)

    @property
    def matrix(self) -> Floats:
        """Linear part of the map of states, (n, n)."""
        return self.states.matrix

    def path(self, mode: int, path: Sequence[int]) -> tuple[int, ...] | None:
        """Image of exits that are passed at one instant, from a mode on; None where it has none.

        Into which cell a mode is entered first does not matter, for cells settle at once. So the
        way between cells is made anew, to the image of the cell in which they settle.
        """
        images: list[int] = []
        place, left = self.modes[mode], list(path)
        while left:
            e = left.pop(0)
            f = self.exits[mode][e]
            if place < 0 or f < 0:
                return None
            images.append(f)
            mode, place = self.targets[mode][e], self.targets[place][f]
            while left and self.settling[mode][left[0]]:
                mode = self.targets[mode][left.pop(0)]
            between = self._settled(place, self.modes[mode]) if mode >= 0 else ()
            if between is None:
                return None
            images += between
            place = self.modes[mode]
        return tuple(images)

    def _settled(self, begin: int, end: int) -> tuple[int, ...] | None:
        """The shortest way from one cell of a mode to another one; None where there is none."""
        ways: dict[int, tuple[int, ...]] = {begin: ()}
        reached = [begin]
        for cell in reached:
            if cell == end:
                return ways[cell]
            for e, target in enumerate(self.targets[cell]):
                if self.settling[cell][e] and target not in ways:
                    ways[target] = (*ways[cell], e)
                    reached.append(target)
        return None


def find_mirror(system: EvaluatedSystem) -> Mirror | None:
    """The symmetry of a system for its present parameter values; None where none is declared.

    A system with a period that time drives has it half a period later, or, where that is not so,
    at the same time. `ModelError` where neither holds: it says which equation breaks it.
    """
    if not system.symmetry:
        return None
    mapped = read_state_map(system)
    fault: ModelError | None = None
    for half in (True, False) if _has_half_period(system) else (False,):
        try:
            return _Images(system, mapped, half).mirror()
        except ModelError as found:
            fault = fault or found
    assert fault is not None
    raise fault


def _in_words(mapped: StateMap, half_period: bool) -> str:
    return f"{mapped.text}{', half a period later' if half_period else ''}"


def _has_half_period(system: EvaluatedSystem) -> bool:
    """Whether time drives a system and all of it repeats."""
    return system.is_driven and system.period_value is not None and not system.unrepeated


class _Images:
    """Looks for the images of all cells, one way to shift time."""

    def __init__(self, system: EvaluatedSystem, mapped: StateMap, half: bool) -> None:
        self.system, self.mapped, self.half = system, mapped, half
        self.cells = cell_values(system.structure)
        self.forms: list[ModeForms] = [cell.forms for cell in self.cells]
        period = system.period_value
        self._shift = 0.5 * period if half and period is not None else 0.0
        names = system.parameter_values
        self._places: list[Place] = [
            random_place(cell, mapped, names, self._shift, period or _SPAN) for cell in self.cells
        ]
        self._check_points()
        looked = list(zip(self.forms, self._places, strict=True))
        self.empty = [is_empty(one, place.values, place.sizes) for one, place in looked]
        self.live = [
            live_exits(one, place.values, place.sizes, self.empty) for one, place in looked
        ]

    def _check_points(self) -> None:
        """Every mode has values at some points, by which it is compared."""
        for one, place in zip(self.forms, self._places, strict=True):
            if one.kind == FREE and np.count_nonzero(place.values.finite) < ENOUGH:
                raise ModelError(
                    f"symmetry: the equations of mode {one.name!r} have no values at random points,"
                    " so it cannot be checked: roots and logarithms of what is negative there, or"
                    " slaved states that were not found; scale the states to sizes of about one,"
                    " or leave symmetry= out"
                )

    def mirror(self) -> Mirror:
        """The symmetry, or an error that says where it fails."""
        found: _Matches = {}
        for i, place in enumerate(self._places):
            if self.empty[i]:
                continue
            live = self.live
            tried = {
                k: match(self.cells[i], self.cells[k], place, self.mapped, (live[i], live[k]))
                for k in self._of_one_kind(i)
            }
            good = {k: each for k, each in tried.items() if not each.faults}
            if not good:
                raise ModelError(self._refusal(i, tried))
            found |= {(i, k): each for k, each in good.items()}
        self._keep_consistent(found)
        modes = tuple(self._image(i, found) for i in range(len(self.cells)))
        exits = tuple(
            self._exits(i, k, found) if k >= 0 else (-1,) * len(self.forms[i].targets)
            for i, k in enumerate(modes)
        )
        targets = tuple(one.targets for one in self.forms)
        settling = tuple(
            tuple(self._settles(one, e) for e in range(len(one.targets))) for one in self.forms
        )
        return Mirror(self.mapped, self.half, modes, exits, targets, settling)

    def _settles(self, one: ModeForms, e: int) -> bool:
        """Whether an exit leads to another cell of the same mode and changes no state."""
        target = one.targets[e]
        same = target >= 0 and self.forms[target].parent == one.parent
        return same and e < one.n_searched and not one.equations.exits[e].reset

    def _of_one_kind(self, i: int) -> list[int]:
        """Cells that may be the image of one: as many exits, of the same kind, as the user says."""
        one, told = self.forms[i], self.mapped.modes
        return [
            k
            for k, other in enumerate(self.forms)
            if other.kind == one.kind
            and not self.empty[k]
            and len(self.live[k].numbers) == len(self.live[i].numbers)
            and len(self._places[k].values.relations) == len(self._places[i].values.relations)
            and told.get(one.declared, other.declared) == other.declared
            and told.get(other.declared, one.declared) == one.declared
        ]

    def _keep_consistent(self, found: _Matches) -> None:
        """Leave out images whose exits lead elsewhere, until all lead where they should."""
        before = -1
        while before != len(found):
            before = len(found)
            for pair in list(found):
                if (pair[1], pair[0]) not in found or not self._leads(pair, found):
                    del found[pair]

    def _leads(self, pair: tuple[int, int], found: _Matches) -> bool:
        """Whether each exit of a cell has an image that leads to an image of its target."""
        i, k = pair
        kept = {
            e: [f for f in images if self._may_lead(i, e, k, f, found)]
            for e, images in found[pair].exits.items()
        }
        found[pair].exits = kept
        return all(kept.values())

    def _may_lead(self, i: int, e: int, k: int, f: int, found: _Matches) -> bool:
        """Whether two exits lead to images; cells of the mode that they enter settle afterwards."""
        here, there = self.forms[i].targets[e], self.forms[k].targets[f]
        if min(here, there) < 0:
            return here == there
        if e >= self.forms[i].n_searched:
            return (here, there) in found
        modes = self.forms[here].parent, self.forms[there].parent
        return any((self.forms[a].parent, self.forms[b].parent) == modes for a, b in found)

    def _image(self, i: int, found: _Matches) -> int:
        """The image of a cell, which must be one."""
        if self.empty[i]:
            return -1
        images = [k for j, k in found if j == i]
        if len(images) == 1:
            return images[0]
        name = self.forms[i].declared
        if not images:
            raise ModelError(
                f"symmetry: {self._words()} takes the equations of mode {self.forms[i].name!r} to"
                " those of another mode, but their exits do not lead to images of each other;"
                f" {_CURE}"
            )
        others = list(dict.fromkeys(self.forms[k].declared for k in images))
        raise ModelError(
            f"symmetry: the image of mode {name!r} may be {' or '.join(map(repr, others))}, whose"
            f" equations are the same; say which, as in symmetry={{..., {name!r}: {others[0]!r}}}"
        )

    def _exits(self, i: int, k: int, found: _Matches) -> tuple[int, ...]:
        """Images of the exits of a cell, each taken once."""
        ours = self.forms[i]
        images = [-1] * len(ours.exit_names)
        for e, candidates in found[i, k].exits.items():
            free = [f for f in candidates if f not in images]
            beside = [f for f in free if self._lies_beside(i, k, images, e, f)]
            if not beside:
                raise ModelError(
                    f"symmetry: the exit {ours.exit_names[e]!r} of mode {ours.name!r} has no image"
                    f" of its own under {self._words()}; {_CURE}"
                )
            images[e] = beside[0]
        return tuple(images)

    def _lies_beside(self, i: int, k: int, images: Sequence[int], e: int, f: int) -> bool:
        """Whether an exit onto a surface belongs to the image of the exit through it."""
        ours, theirs = self.live[i].onto, self.live[k].onto
        return (theirs[f] == f) == (ours[e] == e) and all(
            (theirs[b] == f) == (ours[a] == e) and (theirs[f] == b) == (ours[e] == a)
            for a, b in enumerate(images[:e])
            if b >= 0
        )

    # ------------------------------------------------------------ refusals

    def _words(self) -> str:
        return _in_words(self.mapped, self.half)

    def _refusal(self, i: int, tried: Mapping[int, CellMatch]) -> str:
        """Why a cell has no image, by the cell that comes nearest to one."""
        name = self.forms[i].name
        if not tried:
            return (
                f"symmetry: mode {name!r} has no image: no mode that may be one has as many exits"
                f" and slaved states; {_CURE}"
            )
        nearest = min(tried, key=lambda k: (len(tried[k].faults), k != i))
        fault = tried[nearest].faults[0]
        return f"symmetry: {self._words()} does not hold: {self._told(i, fault)}; {_CURE}"

    def _told(self, i: int, fault: Fault) -> str:
        if not math.isfinite(fault.wanted):
            return f"{fault.where} is missing, or has no value"
        place, k = self._places[i], fault.point
        states = [
            f"{name} = {value:.6g}"
            for name, value in zip(self.system.states, place.states[:, k], strict=True)
        ]
        more = [*states[:_MOST_SHOWN], *(["..."] if len(states) > _MOST_SHOWN else [])]
        at = ", ".join([*more, f"t = {place.times[k]:.6g}"])
        return (
            f"at the image of {at}, {fault.where} is {fault.found:.6g} and should be"
            f" {fault.wanted:.6g}, {np.abs(fault.found - fault.wanted):.3g} apart"
        )
