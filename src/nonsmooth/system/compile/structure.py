"""What the texts of a system mean, before any parameter has a value.

A `SystemStructure` holds the parsed equations and, for each mode, what they come to. It does not
depend on parameter values, so all systems with the same texts share one, whether they come from
``with_parameters`` or from a model that is called again with other numbers.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from threading import Lock
from typing import Any, NamedTuple

from nonsmooth.errors import ModelError, quote
from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.algebra.linear import Harmonic, LinearForm, Power
from nonsmooth.system.algebra.value_tape import ValueTape
from nonsmooth.system.cells.cell_names import cell_labels
from nonsmooth.system.cells.cells import MOST_MODES
from nonsmooth.system.cells.exclusions import Inequality, inequality_of
from nonsmooth.system.cells.pieces import families_of, pieces_of
from nonsmooth.system.compile.mode_forms import ModeForms
from nonsmooth.system.compile.taylor_code import write_code
from nonsmooth.system.compile.taylor_instructions import TaylorCode
from nonsmooth.system.data import SystemData
from nonsmooth.system.equations.equation import Equation, check_references
from nonsmooth.system.equations.mode_equations import ModeEquations, check_guards, read_mode
from nonsmooth.system.equations.resolve import Resolver
from nonsmooth.system.equations.switching import Declared, switching_function
from nonsmooth.system.parts import Text
from nonsmooth.system.surfaces import Surface
from nonsmooth.system.text.expressions import Call, Expression, name_set, walk
from nonsmooth.system.text.grammar import parse_condition

__all__ = ["SystemStructure", "structure_of"]

_MOST_EXITS = 60  # of a cell: results have six bits for each exit of a path


class SystemStructure:
    """Parsed texts of a system and what they come to in each of its modes."""

    def __init__(self, system: SystemData) -> None:
        self.states = tuple(system.states)
        self.parameters = tuple(system.parameters)
        self.declared = tuple(system.modes)
        self.drift = tuple(system.drift)
        self.signals = system.signals
        self.graph = Graph(self.states, tuple(self.signals))
        self._known = {*self.states, *self.parameters, *self.signals, "t", "pi"}
        self._known |= {*system.definitions, *system.surfaces}
        every = self._known | set(system.outputs)
        self.definitions = {
            key: Equation.read(text, f"definitions[{key!r}]", every)
            for key, text in system.definitions.items()
        }
        self.definitions |= {
            key: Equation.read(surface.function, f"surfaces[{key!r}]", every)
            for key, surface in system.surfaces.items()
        }
        self.outputs = {
            key: Equation.read(text, f"outputs[{key!r}]", every)
            for key, text in system.outputs.items()
        }
        self.initial = {
            key: self._static(text, f"initial[{key!r}]") for key, text in system.initial.items()
        }
        self.period = None if system.period is None else self._static(system.period, "period")
        modes = self._equations(system, every)
        self.surfaces = {
            equations.name: self._declared(system, equations, every) for equations in modes
        }
        self.clips = tuple(_clips(self.graph, modes))
        self.families = families_of(self.graph, modes, self.surfaces, _facts(system))
        self._check_used(system.surfaces)
        self.modes = self._running(cell_labels(system.modes, self.families))
        self.slow = _slow(
            self.graph,
            modes[0],
            {**self.outputs, **self.definitions},
            self.parameters,
            system.slow,
        )

    def _static(self, text: Any, where: str) -> Equation:
        # what a user gave may be anything; reading refuses what is no text
        return Equation.read(text, where, self._known)

    def _equations(self, system: SystemData, known: set[str]) -> list[ModeEquations]:
        shared = {**self.outputs, **self.definitions}
        moving = {*self.states, *self.signals, *system.slow, "t"}
        found = []
        for name, mode in system.modes.items():
            equations = read_mode(
                name,
                mode,
                "equations" if system.equations is not None else f"modes[{name!r}]",
                states=self.states,
                modes=self.declared,
                known=known,
                definitions=shared,
            )
            check_references(equations.definitions, (*self.states, *self.signals))
            for equation in equations.all():
                check_references({equation.where: equation}, (*self.states, *self.signals))
            check_guards(equations, moving)
            found.append(equations)
        return found

    def _declared(
        self, system: SystemData, equations: ModeEquations, known: set[str]
    ) -> dict[str, Declared]:
        """Declared surfaces as a mode meets them, by name."""
        found: dict[str, Declared] = {}
        for name, surface in system.surfaces.items():
            resolver = Resolver(self.graph, equations, {}, strict=False)
            node = resolver.tree(equations.definitions[name])
            switch = switching_function(self.graph, node)
            if switch.surface is None:
                continue
            for other, known_before in found.items():
                if known_before.surface.key == switch.surface.key:
                    raise ModelError(
                        f"surfaces[{name!r}]: {surface.function} = 0 is the surface {other!r};"
                        " keep one of them"
                    )
            hold = None
            if surface.hold is not None:
                where = f"surfaces[{name!r}].hold"
                hold = resolver.tree(Equation.read(surface.hold, where, known))
                if self.graph.moves(hold):
                    raise ModelError(
                        f"{where}: states and time cannot appear here, only parameters"
                    )
            found[name] = Declared(name, switch.surface, switch.sign < 0.0, hold, surface)
        return found

    def _running(self, labels: Mapping[int, str]) -> dict[str, ModeForms]:
        """Forms of every cell, by its name; a smooth mode is its own cell."""
        pieces = list(pieces_of(self.graph, self.families))
        if len(pieces) > MOST_MODES:
            raise ModelError(
                f"modes: with the cells of piecewise texts there are {len(pieces)} modes; at most"
                f" {MOST_MODES} are supported: write the system with fewer surfaces"
            )
        numbers = {id(piece.cell): i for i, piece in enumerate(pieces)}
        running = {}
        for piece in pieces:
            name = piece.family.split.name_of(piece.cell)
            assert name not in running, f"two cells are called {name}"  # targets are numbers
            if len(piece.equations.exits) > _MOST_EXITS:
                raise ModelError(
                    f"modes: {name} has {len(piece.equations.exits)} exits with those through its"
                    f" surfaces and onto them; at most {_MOST_EXITS} are supported"
                )
            running[name] = ModeForms(
                self.graph, piece, numbers, name=name, label=labels[id(piece.cell)]
            )
        return running

    def _check_used(self, surfaces: Mapping[str, Surface]) -> None:
        """Every declared surface is one of some mode, and holds only where something slides."""
        splits = [family.split for family in self.families.values()]
        for name, surface in surfaces.items():
            where = f"surfaces[{name!r}]"
            if not any(name in split.names.values() for split in splits):
                raise ModelError(
                    f"{where}: no mode switches at {surface.function} = 0; write sign({name}),"
                    f" max({name}, 0) or another piecewise function of it in a flow, or leave it"
                    " out (an expression that only needs a name is one of definitions=)"
                )
            slides = (cell.on for split in splits for cell in split.sliding)
            keys = {key for split in splits for key, given in split.names.items() if given == name}
            if surface.hold is not None and not any(keys.intersection(on) for on in slides):
                raise ModelError(
                    f"{where}.hold: nothing slides at {surface.function} = 0, for no text jumps"
                    " there so that both sides can point at it; leave hold= out"
                )

    @cached_property
    def running(self) -> tuple[ModeForms, ...]:
        """Modes and cells by the number that the engine gives them."""
        return tuple(self.modes.values())

    @property
    def family_numbers(self) -> tuple[int, ...]:
        """Number of the mode of each cell that runs: the same for all cells of one mode."""
        names = list(self.families)
        return tuple(names.index(forms.family) for forms in self.running)

    @cached_property
    def codes(self) -> dict[str, TaylorCode]:
        """Instructions of the modes that are not linear."""
        return {
            name: write_code(self.graph, forms.taylor, name)
            for name, forms in self.modes.items()
            if forms.taylor is not None
        }

    @cached_property
    def coefficients(self) -> tuple[tuple[str, Expression], ...]:
        """Where each coefficient of the equations stands, and its expression of parameters."""
        found: list[tuple[str, Expression]] = []
        for name, forms in self.modes.items():
            if forms.linear is not None:
                for where, form, _ in forms.linear.with_place(name):
                    found += [(where, coefficient) for coefficient in form.terms.values()]
            if forms.taylor is not None:
                found += self.codes[name].constants
        return tuple(found)

    @cached_property
    def coefficient_values(self) -> ValueTape:
        """Instructions for the values of all coefficients."""
        return ValueTape(coefficient for _, coefficient in self.coefficients)

    @cached_property
    def frequencies(self) -> tuple[Expression, ...]:
        """Angular frequencies of all harmonics, in order of appearance."""
        found: dict[Expression, None] = {}
        for name, forms in self.modes.items():
            for form in forms.all_forms:
                for basis in form.terms:
                    if isinstance(basis, Harmonic):
                        found.setdefault(basis.frequency)
            if name in self.codes:
                found |= dict.fromkeys(self.codes[name].frequencies)
        return tuple(found)

    @cached_property
    def time_order(self) -> int:
        """Highest power of time among the coordinates."""
        orders = [b.order for form in self.all_forms for b in form.terms if isinstance(b, Power)]
        orders += [1 for code in self.codes.values() if code.uses_time]
        return max(orders, default=0)

    @cached_property
    def all_forms(self) -> tuple[LinearForm, ...]:
        """Every linear form of every mode."""
        return tuple(form for mode in self.modes.values() for form in mode.all_forms)

    @property
    def period_nodes(self) -> tuple[Expression, ...]:
        """Expression of the period by parameters, where there is one."""
        return () if self.period is None else (self.static_form.form(self.period).constant_part,)

    @property
    def static_form(self) -> ModeForms:
        """Names resolved where no mode matters: parameters and their definitions."""
        return next(iter(self.modes.values()))


def _slow(
    graph: Graph,
    equations: ModeEquations,
    definitions: Mapping[str, Equation],
    parameters: tuple[str, ...],
    texts: Mapping[str, Text],
) -> dict[str, Expression]:
    """Nodes of the texts of slow parameters; ``t`` and constant parameters may stand in them."""
    known = {*parameters, *definitions, "t", "pi"}
    resolver = Resolver(graph, replace(equations, definitions=definitions), {}, strict=False)
    nodes = {}
    for name, text in texts.items():
        where = f"slow[{name!r}]"
        equation = Equation.read(text, where, known)
        check_references({where: equation}, ())
        nodes[name] = resolver.tree(equation)
        names = name_set(nodes[name])
        for other in (*graph.states, *graph.signals):
            if other in names:
                raise ModelError(
                    f"{where}: {quote(str(text))} depends on {other!r}; a slow parameter depends on"
                    " t and on other parameters"
                )
        for other in texts:
            if other in names:
                raise ModelError(
                    f"{where}: {quote(str(text))} depends on {other!r}, which is slow itself; write"
                    " out what it stands for, or give the constant part a parameter of its own"
                )
    return nodes


class ClipBounds(NamedTuple):
    """Bounds of a ``clip`` that parameters alone give, and where it stands."""

    where: str
    low: Expression
    high: Expression


def _clips(graph: Graph, modes: Iterable[ModeEquations]) -> Iterator[ClipBounds]:
    """Bounds of all calls of ``clip`` that do not move, each pair of them once."""
    seen = set()
    for equations in modes:
        resolver = Resolver(graph, equations, {}, strict=False)
        for equation in (*equations.definitions.values(), *equations.all()):
            for node in walk(equation.tree):
                if not isinstance(node, Call) or node.function != "clip":
                    continue
                bounds = [resolver.tree(replace(equation, tree=b)) for b in node.arguments[1:]]
                if any(map(graph.moves, bounds)) or tuple(bounds) in seen:
                    continue
                seen.add(tuple(bounds))
                yield ClipBounds(equation.where, *bounds)


def _facts(system: SystemData) -> tuple[Inequality, ...]:
    """What the system requires of its parameters, as far as it is a comparison of sums."""
    conditions = [parse_condition(text, where=f"require[{text!r}]") for text in system.require]
    found = [inequality_of(condition) for condition in conditions]
    return tuple(each for each in found if each is not None)


_MOST_KNOWN = 32  # structures that are remembered; one of a rotor in a ring takes a second to make
_known: OrderedDict[Hashable, SystemStructure] = OrderedDict()  # the one asked for last stands last
_lock = Lock()


def structure_of(system: SystemData) -> SystemStructure:
    """The structure of a system; those of the last few texts are remembered."""
    texts = (
        system.states, tuple(system.parameters), system.modes, system.definitions, system.outputs,
        system.period, system.drift, system.initial, system.equations, system.surfaces, system.slow,
        tuple(system.require),
    )  # fmt: skip
    try:  # as texts: 1, 1.0 and True are equal, but not for who reads them
        key = repr(texts), tuple(system.signals.items())
    except ValueError:  # a whole number too long to be written; it is refused where it stands
        return SystemStructure(system)
    with _lock:
        if key in _known:
            _known.move_to_end(key)
            return _known[key]
    made = SystemStructure(system)
    with _lock:
        _known[key] = made
        if len(_known) > _MOST_KNOWN:
            _known.popitem(last=False)
    return made
