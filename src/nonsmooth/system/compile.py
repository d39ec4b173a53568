"""A system's structure to the arrays that the engine runs.

Coefficients of all linear forms become one tape of instructions on parameters, so that a
new parameter value needs no Python: the engine runs the tape and builds its tables.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nonsmooth.engine import layout, opcodes
from nonsmooth.engine.layout import Program
from nonsmooth.system.expressions import Call, Expression, Name, Number
from nonsmooth.system.functions import lookup
from nonsmooth.system.linear import Basis, Harmonic, LinearForm, Power, State
from nonsmooth.system.structure import Structure

__all__ = ["Compiled", "compile_structure"]


@dataclass(frozen=True)
class Compiled:
    """Engine arrays of a system and the names that its numbers stand for."""

    program: Program
    exit_names: tuple[tuple[str, ...], ...]


class _Tape:
    """Collects instructions; equal expressions share a slot."""

    def __init__(self, parameters: tuple[str, ...]) -> None:
        self.slots: dict[Expression, int] = {Name(p): i for i, p in enumerate(parameters)}
        self.n_parameters = len(parameters)
        self.literals: dict[float, int] = {}

    def collect_literals(self, expression: Expression) -> None:
        """Literals come before instructions, so all of them are collected first."""
        stack = [expression]
        while stack:
            node = stack.pop()
            if isinstance(node, Number):
                self.literals.setdefault(node.value, len(self.literals))
            elif isinstance(node, Name) and node.name == "pi":
                self.literals.setdefault(np.pi, len(self.literals))
            elif isinstance(node, Call):
                stack.extend(node.arguments)

    def finish_literals(self) -> None:
        """Fix the slots of the literals; instructions follow."""
        self.rows: list[tuple[int, int, int, int]] = []
        self.base = self.n_parameters + len(self.literals)

    def slot(self, node: Expression) -> int:
        """Slot that will hold the value of an expression."""
        if isinstance(node, Number):
            return self.n_parameters + self.literals[node.value]
        if isinstance(node, Name) and node.name == "pi":
            return self.n_parameters + self.literals[np.pi]
        if node in self.slots:
            return self.slots[node]
        assert isinstance(node, Call)  # names other than parameters were resolved before
        arguments = [self.slot(argument) for argument in node.arguments]
        self.slots[node] = place = self._lower(node, arguments)
        return place

    def _lower(self, node: Call, arguments: list[int]) -> int:
        if node.function == "where":
            return self._emit(opcodes.SELECT, *arguments)
        if node.function == "clip":
            raised = self._emit(opcodes.MAXIMUM, arguments[0], arguments[1])
            return self._emit(opcodes.MINIMUM, raised, arguments[2])
        code = lookup(node.function).opcode
        assert code is not None
        if len(arguments) <= 2:
            return self._emit(code, *arguments)
        place = arguments[0]
        for argument in arguments[1:]:  # sums, products, min and max of many
            place = self._emit(code, place, argument)
        return place

    def _emit(self, code: int, first: int, second: int = 0, third: int = 0) -> int:
        self.rows.append((code, first, second, third))
        return self.base + len(self.rows) - 1


class _Entries:
    """Coefficients of forms: where each belongs and which slot holds it."""

    def __init__(self, width: int) -> None:
        self.places: list[tuple[tuple[int, ...], int, Expression]] = []
        self.width = width

    def put(self, place: tuple[int, ...], form: LinearForm, columns: dict[Basis, int]) -> None:
        for basis, value in form.terms.items():
            self.places.append((place, columns[basis], value))

    def array(self, tape: _Tape) -> np.ndarray:
        rows = [(*place, column, tape.slot(value)) for place, column, value in self.places]
        return np.array(rows, dtype=np.int64).reshape(-1, self.width)


def compile_structure(structure: Structure) -> Compiled:
    """Arrays of a system, independent of parameter values."""
    states = structure.states
    modes = list(structure.modes.values())
    columns = _columns(structure)
    most = max(1, *(len(mode.exits) for mode in modes))
    flow, relations, guards, resets = _Entries(4), _Entries(4), _Entries(4), _Entries(5)
    wiring = np.zeros((len(modes), 1 + most, 2 + most), np.int64)
    for i_mode, mode in enumerate(modes):
        wiring[i_mode, 0, layout.N_EXITS] = len(mode.exits)
        for i_state, state in enumerate(states):
            if state in mode.slaved:
                wiring[i_mode, 0, layout.SLAVED] |= 1 << i_state
                relations.put((i_mode, i_state), mode.slaved[state], columns)
            else:
                flow.put((i_mode, i_state), mode.rates[state], columns)
        for i_exit, way in enumerate(mode.exits):
            wiring[i_mode, 1 + i_exit, layout.TARGET] = way.target
            guards.put((i_mode, i_exit), way.guard, columns)
            for state, form in way.reset.items():
                i_state = states.index(state)
                wiring[i_mode, 1 + i_exit, layout.RESETTING] |= 1 << i_state
                resets.put((i_mode, i_exit, i_state), form, columns)
    tape = _Tape(structure.parameters)
    period = _period_expression(structure)
    entries = (flow, relations, guards, resets)
    for value in [*structure.frequencies, *([period] if period is not None else [])]:
        tape.collect_literals(value)
    for group in entries:
        for _, _, value in group.places:
            tape.collect_literals(value)
    tape.finish_literals()
    arrays = [group.array(tape) for group in entries]
    frequency_slots = np.array([tape.slot(f) for f in structure.frequencies], np.int64)
    period_slot = -1 if period is None else tape.slot(period)
    sizes = [len(states), structure.time_order, len(frequency_slots), len(structure.parameters)]
    program = Program(
        sizes=np.array([*sizes, len(modes), most, 0], np.int64),
        constants=np.array(list(tape.literals), dtype=float),
        tape=np.array(tape.rows, np.int64).reshape(-1, 4),
        period_slot=period_slot,
        frequency_slots=frequency_slots,
        flow=arrays[0],
        relations=arrays[1],
        guards=arrays[2],
        resets=arrays[3],
        wiring=wiring,
        drifting=sum(1 << i for i, state in enumerate(states) if state in structure.drift),
        kinds=np.zeros(len(modes), np.int64),
        code=np.zeros((0, 5), np.int64),
        code_rows=np.zeros((len(modes), 3), np.int64),
        outlets=np.full((len(modes), len(states) * (1 + most) + most), -1, np.int64),
        rest_slots=np.full(len(states), -1, np.int64),
    )
    return Compiled(program, tuple(tuple(way.name for way in mode.exits) for mode in modes))


def _period_expression(structure: Structure) -> Expression | None:
    if structure.period is None:
        return None
    return structure.static_form.form(structure.period).constant_part


def _columns(structure: Structure) -> dict[Basis, int]:
    """Column of each basis function among the augmented coordinates."""
    columns: dict[Basis, int] = {State(state): i for i, state in enumerate(structure.states)}
    for order in range(structure.time_order + 1):
        columns[Power(order)] = len(columns)
    for frequency in structure.frequencies:
        columns[Harmonic("cos", frequency)] = len(columns)
        columns[Harmonic("sin", frequency)] = len(columns)
    return columns
