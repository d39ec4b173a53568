"""Run from a start in the first of its modes that admits it, or say why none does."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.tables import Tables, members
from nonsmooth.errors import OptionError
from nonsmooth.runs.runner import NoMode
from nonsmooth.runs.start import Start, begin
from nonsmooth.system.cells.pieces import RELEASE
from nonsmooth.system.compile.mode_forms import ModeForms
from nonsmooth.system.system import System

__all__ = ["explain_misfit", "in_first_mode"]

Result = TypeVar("Result")
Floats = npt.NDArray[np.float64]

_SHOWN = 6  # modes; those that come nearest, as a piecewise mode has dozens of cells
_DIGITS = (6, 10, 17)


def in_first_mode(
    system: System, tables: Tables, start: Start, run: Callable[..., Result]
) -> Result:
    """What ``run(mode=m)`` gives in the first mode of the start that it does not refuse.

    It refuses a mode with `NoMode`.

    Raises `OptionError` that tells what fails in each mode where none admits the start.
    """
    for mode in start.modes:
        try:
            return run(mode=mode)
        except NoMode as fault:
            misfit = fault
    raise OptionError(explain_misfit(system, tables, start, misfit.z))


def explain_misfit(system: System, tables: Tables, start: Start, z: Floats) -> str:
    """What fails in each mode for a start that no mode admits."""
    asked = start.modes if start.modes != (-1,) else range(len(system.structure.modes))
    names = system.mode_names
    faults = {m: _faults_of(system, tables, start, z, m) for m in asked}
    nearest = sorted(sorted(faults, key=lambda m: len(faults[m]))[:_SHOWN])
    lines = [f"  {names[m]}: {'; '.join(faults[m])}" for m in nearest]
    if len(faults) > len(nearest):
        more = len(faults) - len(nearest)
        modes = "mode" if more == 1 else "modes"
        lines.append(f"  and {more} other {modes}, with as many faults or more")
    given = ", ".join(f"{k} = {v:.6g}" for k, v in zip(system.states, z, strict=False))
    return (
        f"the initial state ({given}) fits no mode of {system.name!r}:\n"
        + "\n".join(lines)
        + "\nchange the state so that it lies inside one of the modes"
        "\n(a guard is positive inside its mode: check its sign too)"
    )


def _faults_of(system: System, tables: Tables, start: Start, z: Floats, m: int) -> list[str]:
    """Guards of a mode that are negative, and slaved states off their relations."""
    forms = list(system.structure.modes.values())[m]
    slaved = _slaved_faults(system, tables, start, z, m)
    derived = _derived_guards(system, forms)
    faults = []
    for e in range(int(tables.modes["n_exits"][m])):
        with np.errstate(invalid="ignore"):  # a guard may divide by zero there
            value = float(tables.guard_row(m, e) @ z)
        guard = forms.equations.exits[e].guard.text
        if e in derived:
            # a force that is asked for where the state is not on its surface says nothing
            if not slaved and not value >= 0.0:
                faults.append(derived[e])
        elif value < 0.0 and forms.is_surface(e):
            faults.append(_other_side(forms, e, value))
        elif value < 0.0:
            faults.append(f"guard {guard!r} is {value:.6g}, it must not be negative")
        elif not math.isfinite(value):
            faults.append(f"guard {guard!r} is not a finite number there")
    return faults + slaved


def _other_side(forms: ModeForms, e: int, value: float) -> str:
    """What is wrong where a start lies on the other side of a surface than a cell."""
    name = forms.equations.exits[e].name
    above = dict(forms.sides)[name] == "+"
    side = ">" if above else "<"
    there = value if above else -value
    return f"{name} ({forms.surfaces[name]}) is {there:.6g}, and this cell has {name} {side} 0"


def _derived_guards(system: System, forms: ModeForms) -> dict[int, str]:
    """What is wrong where a guard that nobody wrote is negative: of sliding, and of rest."""
    equations, family = forms.equations, system.structure.families[forms.family]
    names = [way.name for way in equations.exits]
    n_sliding = 2 * len(forms.cell.on)  # a surface lets motion off to either side
    found = {e: f"nothing holds the motion on {names[e]!r}" for e in range(n_sliding)}
    releases = [e for e, name in enumerate(names) if name == RELEASE]
    for e, i in zip(releases, family.resting, strict=False):
        wall = family.free.equations.exits[i].guard.text
        found[e] = f"nothing presses at {wall} = 0, so it would leave at once"
    return found


def _slaved_faults(system: System, tables: Tables, start: Start, z: Floats, m: int) -> list[str]:
    """Slaved states of a mode that are off their relations."""
    n, faults = len(system.states), []
    equations = list(system.structure.modes.values())[m].equations
    slaved = members(tables.modes["slaved"][m], n)
    implicit = members(tables.modes["implicit"][m], n)
    solution = _solution(system, tables, start, z[:n], m) if implicit.any() else z[:n]
    for i, state in enumerate(system.states):
        if not slaved[i]:
            continue
        text = equations.slaved[state].text
        wanted = float(tables.relation_row(m, i) @ z)
        if implicit[i]:
            wanted = float(solution[i])
        if math.isnan(wanted):
            faults.append(
                f"Newton's method does not solve {text!r} from {state} = {z[i]:.6g}"
                f" here; give {state} near a solution, if there is one"
            )
        elif wanted != z[i]:
            right, given = _told_apart(wanted, float(z[i]))
            faults.append(
                f"{state} is slaved here: give {state} = {right} by {text!r}, not {given}"
            )
    return faults


def _told_apart(one: float, other: float) -> tuple[str, str]:
    """Two numbers with as many digits as it takes to see that they differ."""
    for digits in _DIGITS:
        texts = f"{one:.{digits}g}", f"{other:.{digits}g}"
        if texts[0] != texts[1]:
            break
    return texts


def _solution(system: System, tables: Tables, start: Start, state: Floats, m: int) -> Floats:
    """State with its slaved ones solved for in a mode; nan where the mode does not take it."""
    left_out = members(tables.modes["slaved"][m], state.size)
    opened = np.where(left_out, np.nan, state)
    anchor = begin(tables, opened, start.instant, m)
    return np.where(left_out, anchor.state if anchor.mode >= 0 else np.nan, state)
