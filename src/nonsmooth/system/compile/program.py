"""A system's structure to the arrays that the engine runs.

Coefficients of all linear forms, and the constants of all other modes, become one tape of
instructions on parameters, so that a new parameter value needs no Python: the engine runs
the tape and builds its tables.
"""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass
from functools import lru_cache
from operator import itemgetter

import numpy as np

from nonsmooth.engine import opcodes
from nonsmooth.engine.record import Rows, rows_of, zeros
from nonsmooth.engine.tables import EXACT, TAYLOR, Program, Sizes, choose_kernels, fill_set
from nonsmooth.system.algebra.linear import Basis, Harmonic, Input, LinearForm, Power, State
from nonsmooth.system.compile.mode_forms import Forms
from nonsmooth.system.compile.structure import SystemStructure
from nonsmooth.system.compile.taylor_instructions import Instruction, Operand, TaylorCode
from nonsmooth.system.signals import LAST_DERIVATIVE, signal_arrays
from nonsmooth.system.text.expressions import Call, Expression, Name, Number
from nonsmooth.system.text.functions import lookup

__all__ = ["Compiled", "compile_structure"]


@dataclass(frozen=True)
class Compiled:
    """Engine arrays of a system and the names that its numbers stand for."""

    program: Program
    exit_names: tuple[tuple[str, ...], ...]


@lru_cache(maxsize=32)  # a structure is shared by systems, and so are its arrays
def compile_structure(structure: SystemStructure) -> Compiled:
    """Arrays of a system, independent of parameter values."""
    states = tuple(structure.states)
    modes = list(structure.modes.values())
    columns = _columns(structure)
    most = max(1, *(len(mode.exit_names) for mode in modes))
    linear = _LinearRows(columns)
    taylor = _TaylorRows(columns, len(states), len(modes), most)
    for i_mode, mode in enumerate(modes):
        if mode.linear is not None:
            linear.put(i_mode, mode.linear, states)
        if mode.taylor is not None:
            taylor.put(i_mode, structure.codes[mode.name], states)
    tape = _ParameterTape(structure.parameters)
    period = _static_expression(structure, "period")
    rest = [_static_expression(structure, state) for state in states]
    _collect(tape, structure, linear, taylor, [period, *rest])
    arrays = [group.array(tape) for group in linear.groups]
    frequency_slots = np.array([tape.slot(f) for f in structure.frequencies], np.int64)
    period_slot = -1 if period is None else tape.slot(period)
    code, terms = taylor.array(tape), taylor.array_of_terms(tape)
    rest_slots = np.array([-1 if r is None else tape.slot(r) for r in rest], np.int64)
    signals, knots, spacing = signal_arrays(structure.signals.values())
    product_rows = zeros(Program.struct, product_rows=(len(modes), most))["product_rows"]
    for place, rows in linear.product_rows.items():
        product_rows[place] = rows
    wired, exits = _wiring(structure, most)
    drifting = zeros(Program.struct, drifting=(1,))["drifting"]
    fill_set(drifting[0], _places(structure, structure.drift))
    program = Program(
        sizes=Sizes(
            states=len(states),
            powers=structure.time_order,
            frequencies=len(frequency_slots),
            parameters=len(structure.parameters),
            modes=len(modes),
            exits=most,
            registers=taylor.n_registers,
            signals=len(structure.signals),
            factors=linear.most_factors,
        ),
        constants=np.array(list(tape.literals), dtype=float),
        tape=rows_of("TapeRow", tape.rows),
        period_slot=period_slot,
        frequency_slots=frequency_slots,
        flow=arrays[0],
        relations=arrays[1],
        guards=arrays[2],
        resets=arrays[3],
        factors=arrays[4],
        products=rows_of("Product", linear.products),
        product_rows=product_rows,
        modes=wired,
        exits=exits,
        drifting=drifting,
        families=np.array(structure.family_numbers, np.int64),
        kinds=np.array([EXACT if mode.linear else TAYLOR for mode in modes], np.int64),
        code=code,
        terms=terms,
        **choose_kernels(code, terms),
        code_rows=taylor.code_rows,
        outlets=taylor.outlets,
        rest_slots=rest_slots,
        signals=signals,
        knots=knots,
        spacing=spacing,
    )
    return Compiled(program, tuple(mode.exit_names for mode in modes))


def _collect(
    tape: _ParameterTape,
    structure: SystemStructure,
    linear: _LinearRows,
    taylor: _TaylorRows,
    others: list[Expression | None],
) -> None:
    """Literals of everything that gets a slot."""
    for value in [*structure.frequencies, *others[:1]]:
        if value is not None:
            tape.collect_literals(value)
    for group in linear.groups:
        for _, _, value in group.places:
            tape.collect_literals(value)
    for value in [*taylor.constants, *others[1:]]:
        if value is not None:
            tape.collect_literals(value)
    tape.finish_literals()


def _wiring(structure: SystemStructure, most: int) -> tuple[Rows, Rows]:
    """Rows of the modes and of their exits: targets, slaved states and states that are reset."""
    count = len(structure.modes)
    made = zeros(Program.struct, modes=(count,), exits=(count, most))
    modes, exits = made["modes"], made["exits"]
    exits["onto"] = -1
    for i_mode, mode in enumerate(structure.modes.values()):
        implicit = () if mode.taylor is None else mode.taylor.implicit
        row = modes[i_mode]
        row["n_exits"], row["n_ways"], row["kind"] = mode.n_searched, len(mode.targets), mode.kind
        fill_set(row["slaved"], _places(structure, mode.equations.slaved))
        fill_set(row["implicit"], _places(structure, implicit))
        for i_exit, (target, way) in enumerate(
            zip(mode.targets, mode.equations.exits, strict=True)
        ):
            row = exits[i_mode, i_exit]
            row["target"] = target
            row["onto"], row["choice"] = mode.onto[i_exit], mode.choices[i_exit]
            fill_set(row["resetting"], _places(structure, way.reset))
    return modes, exits


def _places(structure: SystemStructure, names: Container[str]) -> list[int]:
    """Numbers of the states that are in a set."""
    return [i for i, state in enumerate(structure.states) if state in names]


def _static_expression(structure: SystemStructure, name: str) -> Expression | None:
    """Expression of the period, or of a state at rest where it is not zero."""
    equation = structure.period if name == "period" else structure.initial.get(name)
    if equation is None:
        return None
    value = structure.static_form.form(equation).constant_part
    return None if name != "period" and value == Number(0.0) else value


def _columns(structure: SystemStructure) -> dict[Basis, int]:
    """Column of each basis function among the augmented coordinates."""
    columns: dict[Basis, int] = {State(state): i for i, state in enumerate(structure.states)}
    for order in range(structure.time_order + 1):
        columns[Power(order)] = len(columns)
    for frequency in structure.frequencies:
        columns[Harmonic("cos", frequency)] = len(columns)
        columns[Harmonic("sin", frequency)] = len(columns)
    for name in structure.signals:
        for order in range(LAST_DERIVATIVE + 1):
            columns[Input(name, order)] = len(columns)
    return columns


# ---------------------------------------------------------------- rows of linear modes


class _Entries:
    """Coefficients of forms: where each belongs and which slot holds it."""

    def __init__(self, row: str) -> None:
        self.places: list[tuple[tuple[int, ...], int, Expression]] = []
        self.row = row

    def put(self, place: tuple[int, ...], form: LinearForm, columns: dict[Basis, int]) -> None:
        for basis, value in form.terms.items():
            self.places.append((place, columns[basis], value))

    def array(self, tape: _ParameterTape) -> Rows:
        rows = [(*place, column, tape.slot(value)) for place, column, value in self.places]
        return rows_of(self.row, rows)


class _LinearRows:
    """Coefficients of the modes that are linear."""

    def __init__(self, columns: dict[Basis, int]) -> None:
        self.columns = columns
        self.flow, self.relations = _Entries("FlowTerm"), _Entries("FlowTerm")
        self.guards, self.resets = _Entries("GuardTerm"), _Entries("ResetTerm")
        self.factors = _Entries("FactorTerm")
        self.groups = (self.flow, self.relations, self.guards, self.resets, self.factors)
        self.products: list[tuple[int, int]] = []
        self.product_rows: dict[tuple[int, int], tuple[int, int]] = {}
        self.most_factors = 0

    def put(self, i_mode: int, forms: Forms[LinearForm], states: tuple[str, ...]) -> None:
        """Enter the forms of a mode."""
        columns = self.columns
        known: list[LinearForm] = []  # factors of the mode so far
        for i_state, state in enumerate(states):
            if state in forms.slaved:
                self.relations.put((i_mode, i_state), forms.slaved[state], columns)
            else:
                self.flow.put((i_mode, i_state), forms.rates[state], columns)
        for i_exit, way in enumerate(forms.exits):
            self.guards.put((i_mode, i_exit), way.guard, columns)
            if way.products:
                n_products = len(self.products)
                self.products += [
                    (self._factor(known, i_mode, left), self._factor(known, i_mode, right))
                    for left, right in way.products
                ]
                self.product_rows[i_mode, i_exit] = n_products, len(self.products)
            for state, form in way.reset.items():
                self.resets.put((i_mode, i_exit, states.index(state)), form, columns)

    def _factor(self, known: list[LinearForm], i_mode: int, form: LinearForm) -> int:
        """Number of a factor in its mode; a square has one."""
        for number, other in enumerate(known):
            if other.terms == form.terms:
                return number
        known.append(form)
        self.most_factors = max(self.most_factors, len(known))
        self.factors.put((i_mode, len(known) - 1), form, self.columns)
        return len(known) - 1


# ---------------------------------------------------------------- rows of Taylor modes


class _TaylorRows:
    """Code of all Taylor modes, one after the other."""

    def __init__(self, columns: Mapping[Basis, int], n: int, n_modes: int, most: int) -> None:
        self.columns = columns
        self.n = n
        self.most = most
        self.n_registers = 0
        self.rows: list[tuple[int, int, int, int | Expression, int]] = []
        self.terms: list[tuple[int, int, Expression]] = []
        self.code_rows = zeros("Program", code_rows=(n_modes,))["code_rows"]
        self.outlets = np.full((n_modes, 2 * n + most + most * n), -1, np.int64)

    @property
    def constants(self) -> list[Expression]:
        """Expressions that need a slot."""
        of_rows = [row[3] for row in self.rows if not isinstance(row[3], int)]
        return [*of_rows, *(factor for *_, factor in self.terms)]

    def put(self, i_mode: int, code: TaylorCode, states: tuple[str, ...]) -> None:
        """Enter the code of a mode."""
        first, width = len(self.rows), len(self.columns)
        for i, each in enumerate(code.instructions):
            a, c = self._register(each.a), self._register(each.c)
            b = self._register(each.b) if each.slot is None else each.slot
            if each.terms or each.products:
                a, c, b = self._put_terms(each)
            self.rows.append((each.opcode, width + i, a, b, c))
        self.code_rows[i_mode] = first, first + code.middle, len(self.rows)
        self.n_registers = max(self.n_registers, width + len(code.instructions))
        for (kind, *place), operand in code.results.items():
            self.outlets[i_mode, self._outlet(kind, place, states)] = self._register(operand)

    def _put_terms(self, each: Instruction) -> tuple[int, int, int]:
        """First term, first product and end of a sum; what is computed last is added last."""
        first = len(self.terms)
        terms = [(self._register(x), 0, factor) for x, factor in each.terms]
        self.terms += sorted(terms, key=itemgetter(0))
        middle = len(self.terms)
        products = [(self._register(x), self._register(y), c) for x, y, c in each.products]
        self.terms += sorted(products, key=lambda row: max(row[:2]))
        return first, middle, len(self.terms)

    def array_of_terms(self, tape: _ParameterTape) -> Rows:
        """Rows (register, slot, other register)."""
        rows = [(register, tape.slot(factor), other) for register, other, factor in self.terms]
        return rows_of("Term", rows)

    def array(self, tape: _ParameterTape) -> Rows:
        """Rows (opcode, target, a, b, c)."""
        rows = [
            (code, target, a, b if isinstance(b, int) else tape.slot(b), c)
            for code, target, a, b, c in self.rows
        ]
        return rows_of("Instruction", rows)

    def _outlet(self, kind: object, place: list[object], states: tuple[str, ...]) -> int:
        if kind == "rate":
            return states.index(str(place[0]))
        if kind == "vanishing":
            return self.n + self.most + self.most * self.n + states.index(str(place[0]))
        exit_number = place[0]
        assert isinstance(exit_number, int)
        if kind == "guard":
            return self.n + exit_number
        return self.n + self.most + exit_number * self.n + states.index(str(place[1]))

    def _register(self, operand: Operand | None) -> int:
        if operand is None:
            return 0
        if isinstance(operand, int):
            return len(self.columns) + operand
        return self.columns[operand]


# ---------------------------------------------------------------- the tape of parameters


class _ParameterTape:
    """Collects instructions; equal expressions share a slot.

    Parameters come first, then literals, then one slot for each instruction.
    """

    def __init__(self, parameters: tuple[str, ...]) -> None:
        self.slots: dict[tuple[object, ...], int] = {(p,): i for i, p in enumerate(parameters)}
        self.n_parameters = len(parameters)
        self.literals: dict[float, int] = {}
        self.rows: list[tuple[int, int, int, int]] = []
        self.base = 0
        self._seen: dict[int, Expression] = {}
        self._placed: dict[int, int] = {}

    def collect_literals(self, expression: Expression) -> None:
        """Literals come before instructions, so all of them are collected first."""
        stack = [expression]
        while stack:
            node = stack.pop()
            if isinstance(node, Number):
                self.literals.setdefault(node.value, len(self.literals))
            elif isinstance(node, Name) and node.name == "pi":
                self.literals.setdefault(np.pi, len(self.literals))
            elif isinstance(node, Call) and id(node) not in self._seen:
                self._seen[id(node)] = node  # kept, so that its number stays its own
                stack.extend(node.arguments)

    def finish_literals(self) -> None:
        """Fix the slots of the literals; instructions follow."""
        self.base = self.n_parameters + len(self.literals)

    def slot(self, node: Expression) -> int:
        """Slot that will hold the value of an expression."""
        if isinstance(node, Number):
            return self.n_parameters + self.literals[node.value]
        if isinstance(node, Name):
            if node.name == "pi":
                return self.n_parameters + self.literals[np.pi]
            return self.slots[(node.name,)]  # other names were resolved before
        if id(node) not in self._placed:
            assert id(node) in self._seen  # its literals were collected
            arguments = [self.slot(argument) for argument in node.arguments]
            key = (node.function, *arguments)
            if key not in self.slots:
                self.slots[key] = self._lower(node, arguments)
            self._placed[id(node)] = self.slots[key]
        return self._placed[id(node)]

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
