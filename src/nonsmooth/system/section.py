"""A system that notices where an expression changes sign, and moves on as before.

Each mode becomes two, above and below the section, with the same equations and an exit
from one to the other where the expression vanishes. So the engine finds the crossings as it
finds any event, and no crossing changes what comes after it by more than rounding. In a
mode that stays where it is relative to the section, such as a sticking one, there is
nothing to find, and it stays one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError, OptionError, quote
from nonsmooth.system.algebra.differentiate import rate_of_change
from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.algebra.identities import is_rounding
from nonsmooth.system.compile.mode_forms import ModeForms
from nonsmooth.system.compile.structure import SystemStructure
from nonsmooth.system.equations.equation import Equation
from nonsmooth.system.equations.mode_equations import is_relation
from nonsmooth.system.equations.resolve import Resolver
from nonsmooth.system.equations.switching import Undecided
from nonsmooth.system.parts import STOP, Exit, Mode
from nonsmooth.system.system import System

__all__ = ["Section", "section_names", "with_section"]

_SIDES = ("above", "below")
_Words = Mapping[str, str]


@dataclass(frozen=True)
class Section:
    """A system with a section in it, and what its modes are in the system without.

    ``origin`` is the number of the mode in the system without, by the number in the one
    with; ``side`` the sign of the expression in it, zero where that does not change;
    ``gate`` the number of the exit through the section, -1 where there is none; ``value``
    the name of an output that is the expression.
    """

    system: System
    value: str
    origin: npt.NDArray[np.int64]
    side: npt.NDArray[np.int64]
    gate: npt.NDArray[np.int64]
    words: _Words

    def folded(self, text: str) -> str:
        """Message about the system with the section, in words of the system without."""
        for word in sorted(self.words, key=len, reverse=True):
            text = text.replace(word, self.words[word])
        return text


_KEPT = 8  # sections of one structure: large ones take megabytes
_known: WeakKeyDictionary[SystemStructure, dict[str, Section]] = WeakKeyDictionary()


def section_names(system: System) -> set[str]:
    """Names that may stand in the expression of a section."""
    return {
        *system.states, *system.parameters, *system.signals, *system.definitions,
        *system.outputs, "t", "pi",
    }  # fmt: skip


def with_section(system: System, text: str) -> Section:
    """System with a section where an expression vanishes, for its present parameters.

    Raises
    ------
    OptionError
        When the text is no expression, or does not change along the motion.
    """
    kept = _known.setdefault(system.structure, {})
    section = kept.pop(text, None) or _made(system, text)
    kept[text] = section
    for oldest in list(kept)[:-_KEPT]:
        kept.pop(oldest, None)
    return replace(section, system=section.system.with_parameters(**system.parameters))


def _made(system: System, text: str) -> Section:
    structure, place = system.structure, f"section = {quote(text)}"
    try:
        expression = _expression(text)
        equation = Equation.read(expression, "section", section_names(system))
        moving = [name for name in system.modes if _moves(structure, name, equation)]
    except ModelError as fault:
        raise OptionError(str(fault)) from None
    if not moving:
        raise OptionError(
            f"{place}: it does not change along the motion in any mode, so nothing crosses it;"
            " give an expression of states, such as"
            f" {system.states[0]!r}, that changes its sign"
        )
    names = _names(system, moving)
    value = _unused("section_value", {*section_names(system), *system.modes})
    try:
        split = _split(system, names, expression, value)
    except ModelError as fault:
        words = {made: name for name, pair in names.items() for made in pair}
        message = str(fault)
        for word, name in words.items():
            message = message.replace(word, name)
        raise OptionError(f"{place}: with it, {message}") from None
    return _section(structure, split, names, value)


def _expression(text: str) -> str:
    """Expression of a text that may be an equation, ``v = 0``."""
    if not is_relation(text):
        return text
    left, _, right = text.partition("=")
    return f"({left}) - ({right})"


def _unused(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "_"
    return name


def _names(system: System, moving: list[str]) -> dict[str, tuple[str, ...]]:
    """Names of the modes that each mode becomes."""
    taken = {*system.modes, *section_names(system)}
    names: dict[str, tuple[str, ...]] = {}
    for name in system.modes:
        pair = tuple(_unused(f"{name}__{side}", taken) for side in _SIDES)
        names[name] = pair if name in moving else (name,)
    return names


# ---------------------------------------------------------------- where there is a section


def _moves(structure: SystemStructure, name: str, equation: Equation) -> bool:
    """Whether an expression changes along the motion of a mode, in one of its cells."""
    running = [forms for forms in structure.running if forms.declared == name]
    return any(not _still(structure.graph, forms.resolver, equation) for forms in running)


def _still(graph: Graph, resolver: Resolver, equation: Equation) -> bool:
    """Whether an expression surely keeps its value along the motion."""
    try:
        change = rate_of_change(graph, resolver.tree(equation), resolver.rate)
    except Undecided:
        return False
    return is_rounding(change)


# ---------------------------------------------------------------- the system with it


def _split(system: System, names: Mapping[str, tuple[str, ...]], text: str, value: str) -> System:
    """System whose modes end at the section; a drift that the section reads is none there."""
    modes = {}
    gate = _unused("section", {way.name or "" for m in system.modes.values() for way in m.exits})
    for name, made in names.items():
        for side, new in enumerate(made):
            modes[new] = _half(system.modes[name], name, side, names, text, gate)
    changes: dict[str, Any] = {
        "modes": modes,
        "equations": None,
        "outputs": {**system.outputs, value: text},
        "symmetry": {},  # a section has two sides, which need not be images of each other
    }
    try:
        return replace(system, **changes)
    except ModelError as fault:
        if not str(fault).startswith(("drift:", "drift[")):
            raise
    return replace(system, **changes, drift=())


def _half(
    mode: Mode, name: str, side: int, names: Mapping[str, tuple[str, ...]], text: str, gate: str
) -> Mode:
    """One side of a mode: its exits lead to the same side of the modes that they enter."""
    exits = []
    for way in mode.exits:
        target = way.to or name
        entered = target if target == STOP else names[target][min(side, len(names[target]) - 1)]
        exits.append(replace(way, to=entered, name=way.name or target))
    if len(names[name]) > 1:
        # last, so that everything else happens in the order in which it did
        guard = f"({text})" if side == 0 else f"-({text})"
        exits.append(Exit(guard, to=names[name][1 - side], name=gate))
    return replace(mode, exits=exits, cells=None)


def _section(
    structure: SystemStructure, split: System, names: Mapping[str, tuple[str, ...]], value: str
) -> Section:
    parents = {new: (name, side) for name, made in names.items() for side, new in enumerate(made)}
    whole = list(structure.running)
    origin, sides, gates, words = [], [], [], {}
    equation = split.structure.outputs[value]
    for forms in split.structure.running:
        name, side = parents[forms.declared]
        number = _same(structure, whole, split.structure, forms, name)
        has_gate = len(names[name]) > 1
        still = _still(split.structure.graph, forms.resolver, equation)
        origin.append(number)
        sides.append(0 if still or not has_gate else (1, -1)[side])
        gates.append(forms.n_searched - 1 if has_gate else -1)
        words[forms.name] = whole[number].label
        words[forms.parent] = whole[number].parent
    return Section(split, value, np.array(origin), np.array(sides), np.array(gates), words)


def _same(
    structure: SystemStructure,
    whole: list[ModeForms],
    halves: SystemStructure,
    forms: ModeForms,
    name: str,
) -> int:
    """Number of the cell of the whole system that a cell of the halved one is part of."""
    resting = halves.families[forms.family].resting
    family = next(
        f for f in structure.families.values() if (f.declared, f.resting) == (name, resting)
    )
    cell = family.split.cell(forms.cell.signs)
    return next(i for i, each in enumerate(whole) if each.cell is cell)
