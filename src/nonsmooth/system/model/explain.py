"""A readable account of a system for its present parameter values.

What is declared is repeated in short; what follows from it, the natural motions of each
mode and what the forcing meets there, is computed. Numbers are shown to four digits.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction

import numpy as np

from nonsmooth.system.algebra.frequencies import monomials
from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.algebra.linear import Harmonic, State
from nonsmooth.system.cells.cells import Cell, SplitMode
from nonsmooth.system.cells.exclusions import Inequality, excluded
from nonsmooth.system.columns import aligned, one_line
from nonsmooth.system.compile.mode_forms import ModeForms
from nonsmooth.system.equations.mode_equations import is_relation
from nonsmooth.system.model.evaluated import EvaluatedSystem
from nonsmooth.system.model.motions import Motion, natural_motions, reached
from nonsmooth.system.parts import STOP, Exit, Text
from nonsmooth.system.text.evaluate import constant_value
from nonsmooth.system.text.expressions import Expression, Number, to_text

__all__ = ["explanation"]

_Section = tuple[str, Sequence[Sequence[str]]]  # title, rows
_MOST_NAMED = 6  # states of one motion
_SIDES = {"+": "> 0", "0": "= 0", "-": "< 0", ".": "nowhere"}
_NEAR = 0.05  # of the natural frequency: closer than this, or than the damping ratio, resounds


def explanation(system: EvaluatedSystem, symmetry: str = "") -> str:
    """Account of a system, lines with aligned columns; ``symmetry`` is its map in words."""
    time_unit = _units(system.describe.get("time", ""))
    lines = [one_line(system.name) or "system", "  states", *aligned(list(_states(system)), 4)]
    if system.parameters:
        lines += ["  parameters", *aligned(list(_parameters(system)), 4)]
    if system.signals:
        lines += ["  signals", *aligned(list(_signals(system)), 4)]
    if system.slow:
        lines += ["  slow", *aligned([(k, f"= {text}") for k, text in system.slow.items()], 4)]
    lines += aligned([_period(system, time_unit)])
    if symmetry:
        lines += aligned([("symmetry", symmetry)])
    for name, family in system.structure.families.items():
        mode = system.modes[family.declared]
        cells = [forms for forms in system.structure.running if forms.parent == name]
        values = system.parameter_values
        shown = [
            c for c in cells if is_possible(system.structure.graph, family.split, c.cell, values)
        ]
        exits = [
            _exit(way, equation.name)
            for i, (way, equation) in enumerate(
                zip(mode.exits, family.free.equations.exits, strict=True)
            )
            if i not in family.resting
        ]
        exits += [_release(mode.exits[i]) for i in family.resting]
        slaved = [_slaved(state, text) for state, text in mode.slaved.items()]
        if not cells[0].sides:
            lines += ["", f"mode {name}: {_kind(cells[0])}"]
            sections = [("slaved", slaved), *_motion(system, cells[0], time_unit)]
            lines += _written([*sections, ("exits", exits)])
            continue
        without = len(cells) - len(shown)
        left_out = f", and {without} that cannot be with these values" if without else ""
        lines += ["", f"mode {name}: {len(shown)} cells{left_out}"]
        lines += _written([("slaved", slaved), *_cells(system, name, shown), ("exits", exits)])
        for (kind, *motion), names in _folded(system, shown, time_unit).items():
            lines += ["", f"{_these(names, len(shown))}: {kind}"]
            lines += motion
    return "\n".join(lines) + "\n"


def _written(sections: Iterable[_Section]) -> Iterator[str]:
    for title, rows in sections:
        if rows:
            yield f"  {title}"
            yield from aligned(rows, 4)


def _kind(forms: ModeForms) -> str:
    """How the flow of a mode is solved."""
    if forms.linear is None:
        return "Taylor series"
    return "exact linear" if forms.taylor is None else "exact linear, exits by products of states"


def _these(names: list[str], count: int) -> str:
    """Some of so many cells."""
    if len(names) == 1:
        return f"cell {names[0]}"
    return "every cell" if len(names) == count else f"cells {', '.join(names)}"


def _folded(
    system: EvaluatedSystem, cells: Sequence[ModeForms], time_unit: str
) -> dict[tuple[str, ...], list[str]]:
    """Names of cells by what is told of their motion, which several may share."""
    found: dict[tuple[str, ...], list[str]] = {}
    for forms in cells:
        told = (_kind(forms), *_written(_motion(system, forms, time_unit)))
        found.setdefault(told, []).append(forms.name)
    return found


def _motion(system: EvaluatedSystem, forms: ModeForms, time_unit: str) -> Iterator[_Section]:
    """What is known of the motion in a mode or in one of its cells."""
    if forms.linear is None:
        yield "nonlinear", [(forms.reason,)]
    else:
        yield from _behaviour(system, forms, time_unit)


def _cells(system: EvaluatedSystem, mode: str, cells: Sequence[ModeForms]) -> Iterator[_Section]:
    """Switching functions of a mode, and the signs of its cells."""
    found = system.structure.families[mode].split
    yield "surfaces", [(name, f"{found.text_of(name)} = 0") for name in found.nodes]
    unused = _unused_names(found)
    if unused and any(forms.label == forms.name for forms in cells):
        yield "names", [(unused,)]
    rows = []
    for forms in cells:
        sides = ", ".join(f"{name} {_SIDES[sign]}" for name, sign in forms.sides)
        rows.append((forms.name, sides, forms.label if forms.label != forms.name else ""))
    yield "cells", rows


def _unused_names(found: SplitMode) -> str:
    """Why cells are called by signs although sides of a surface have names; empty else."""
    named: list[str] = []
    others: list[str] = []
    for key, name in found.names.items():
        declared = found.declared.get(key)
        has = declared is not None and any(declared.label(sign) for sign in (-1, 0, 1))
        (named if has else others).append(name)
    if not (named and others):
        return ""
    return (
        f"cells go by signs, not by the sides of {', '.join(named)}: name those of"
        f" {', '.join(others)} too, or the cells"
    )


def _states(system: EvaluatedSystem) -> Iterator[tuple[str, str]]:
    for name in system.states:
        notes = [system.describe.get(name, "")]
        if isinstance(system.drift, Mapping) and name in system.drift:
            drifts = "" if name in system.angles else ", on which nothing depends: it drifts"
            notes.append(f"an angle of period {system.drift[name]}{drifts}")
        elif name in system.drift:
            notes.append("drifts")
        if system.rest_state[name] != 0.0:
            notes.append(f"{system.rest_state[name]:.4g} at rest")
        yield name, "; ".join(filter(None, notes))


def _parameters(system: EvaluatedSystem) -> Iterator[tuple[str, str, str]]:
    for name, value in system.parameter_values.items():
        yield name, f"= {value:.4g}", system.describe.get(name, "")


def _period(system: EvaluatedSystem, time_unit: str) -> tuple[str, str]:
    if system.period is None or system.period_value is None:
        return "period", "none declared"
    value = f"about {_quantity(system.period_value, time_unit)}"
    told = f"{system.period}, {value}" if isinstance(system.period, str) else value
    if system.is_driven:
        return "period", told
    return "period", f"{told}: the time between strobes alone, for nothing depends on time"


def _signals(system: EvaluatedSystem) -> Iterator[tuple[str, str, str]]:
    for name, signal in system.signals.items():
        low, high = signal.span
        knots = f"{signal.times.size} knots from t = {low:.4g} to {high:.4g}"
        yield name, f"{signal.method}, {knots}", system.describe.get(name, "")


def _slaved(state: str, text: Text) -> tuple[str, str]:
    return state, f"from {text}" if is_relation(text) else f"= {text}"


def _exit(way: Exit, name: str) -> tuple[str, str, str, str]:
    reset = ", ".join(f"{state} := {text}" for state, text in way.reset.items())
    target = {None: "to the same mode", STOP: "ends the run"}.get(way.to, f"to {way.to}")
    return name, f"when {way.guard} < 0", target, reset


def _release(way: Exit) -> tuple[str, str, str, str]:
    return "release", f"when nothing presses at {way.guard} = 0", "", ""


# ---------------------------------------------------------------- motions and forcing


def _behaviour(system: EvaluatedSystem, forms: ModeForms, time_unit: str) -> Iterator[_Section]:
    """Titles and rows: the natural motions of a mode, and the frequencies that drive it."""
    names, matrix = _flow_matrix(system, forms)
    try:
        motions = natural_motions(matrix)
    except np.linalg.LinAlgError:
        lost = "not found in double precision; choose units in which coefficients are nearer to 1"
        yield "natural motions", [(lost,)]
        return
    rows = [
        (_few(_with_slaved(system, forms, [names[i] for i in m.states])), _manner(m, time_unit))
        for m in motions
    ]
    yield "natural motions", rows
    driven: dict[Expression, set[int]] = {}
    for i, name in enumerate(names):
        for basis in forms.rates[name].terms:
            if isinstance(basis, Harmonic):
                driven.setdefault(basis.frequency, set()).add(i)
    forcing = []
    for frequency, states in driven.items():
        value = abs(constant_value(frequency, system.parameter_values))
        following = reached(matrix, states)
        notes = [
            _resonance(value, motion, _with_slaved(system, forms, excited))
            for motion in motions
            if (excited := [names[i] for i in motion.states if i in following])
        ]
        cells = [to_text(frequency), f"= {_angular(value, time_unit)}"]
        if isinstance(frequency, Number):
            cells = [_angular(value, time_unit), ""]
        forcing.append((*cells, "; ".join(filter(None, notes))))
    yield "forced at", forcing


def _with_slaved(system: EvaluatedSystem, forms: ModeForms, moving: list[str]) -> list[str]:
    """States of a motion and those that follow them, in the order of the system.

    Of two velocities that are one while bodies stick, either might be left out, so both are named.
    States that are declared as slaved have rows of their own.
    """
    values, declared = system.parameter_values, system.modes[forms.declared].slaved
    together = {*moving}
    for state, form in forms.slaved.items():
        if state not in declared and any(
            constant_value(form.coefficient(State(name)), values) for name in moving
        ):
            together.add(state)
    return [state for state in system.states if state in together]


def _flow_matrix(system: EvaluatedSystem, forms: ModeForms) -> tuple[list[str], np.ndarray]:
    """States that have a flow in a mode, and the matrix of their rates."""
    names = [state for state in system.states if state not in forms.slaved]
    values = system.parameter_values
    rows = [
        [constant_value(forms.rates[row].coefficient(State(column)), values) for column in names]
        for row in names
    ]
    return names, np.array(rows, dtype=float).reshape(len(names), len(names))


def _manner(motion: Motion, time_unit: str) -> str:
    """What a motion looks like, in words and numbers."""
    times = f" ({motion.count} nearly alike)" if motion.count > 1 else ""
    if motion.rate == 0.0:
        if motion.count == motion.chains:
            return "constant" if motion.count == 1 else f"constant, {motion.count} of them"
        how = "rigid-body motion: moves on without a force"
        return how if motion.chains == 1 else f"{how}, {motion.chains} of them"
    growth = ""
    if motion.rate.real > 0.0:
        growth = f"grows e-fold in about {_quantity(1.0 / motion.rate.real, time_unit)}"
    if not motion.rate.imag:
        if growth:
            return f"unstable: {growth}{times}"
        return f"decays, time constant about {_quantity(-1.0 / motion.rate.real, time_unit)}{times}"
    angular = _angular(motion.frequency, time_unit)
    if growth:
        return f"unstable: oscillates, angular frequency about {angular}, {growth}{times}"
    if motion.rate.real == 0.0:
        return f"oscillates without damping, angular frequency about {angular}{times}"
    return (
        f"oscillates, natural angular frequency about {angular},"
        f" damping ratio about {motion.damping:.4g}{times}"
    )


def _few(names: Sequence[str]) -> str:
    if len(names) <= _MOST_NAMED:
        return ", ".join(names)
    return f"{', '.join(names[: _MOST_NAMED - 2])} ... {names[-1]}"


def _resonance(value: float, motion: Motion, states: Sequence[str]) -> str:
    """Note when a forcing frequency is near that of a motion that it reaches, else empty."""
    if not motion.frequency:
        return ""
    ratio = value / motion.frequency
    if abs(ratio - 1.0) > max(_NEAR, abs(motion.damping)):
        return ""
    where = _few(states)
    if motion.rate.real == 0.0 and math.isclose(ratio, 1.0, rel_tol=1e-9):
        return f"resonance with {where}: without damping the amplitude grows without bound"
    return f"near resonance with {where}: {ratio:.4g} of the natural frequency"


def _quantity(value: float, unit: str) -> str:
    return f"{value:.4g} {unit}".rstrip()


def _angular(value: float, time_unit: str) -> str:
    if not time_unit:
        return f"{value:.4g}"
    per = time_unit if time_unit.isalpha() else f"({time_unit})"
    return f"{value:.4g} rad/{per}"


def _units(label: str) -> str:
    """Units in brackets at the end of a label."""
    return label[:-1].rpartition("[")[2].strip() if label.endswith("]") and "[" in label else ""


# ---------------------------------------------------------------- cells that are possible


def is_possible(graph: Graph, mode: SplitMode, cell: Cell, values: Mapping[str, float]) -> bool:
    """Whether linear arithmetic leaves a place for a cell; products of states count as unknown."""
    inequalities: list[Inequality] = []
    for key, sign in cell.signs.items():
        terms = _terms(graph, mode.nodes[mode.names[key]], values)
        if terms is None:
            return True
        if sign >= 0:
            inequalities.append(Inequality(terms, strict=sign > 0))
        if sign <= 0:
            turned = {factors: -value for factors, value in terms.items()}
            inequalities.append(Inequality(turned, strict=sign < 0))
    return not excluded(inequalities)


def _terms(
    graph: Graph, node: Expression, values: Mapping[str, float]
) -> dict[Hashable, Fraction] | None:
    """Products of what moves, and the number before each; None where that is no number."""
    terms: dict[Hashable, Fraction] = {}
    for product, number in monomials(node).items():
        factors = [graph.imported(factor) for factor in product]  # sums in them are made anew
        moving = tuple(factor for factor in factors if graph.moves(factor))
        fixed = [constant_value(each, values) for each in factors if not graph.moves(each)]
        value = math.prod(fixed, start=number)
        if not math.isfinite(value):
            return None
        terms[moving] = terms.get(moving, Fraction(0)) + Fraction(value)
    return terms
