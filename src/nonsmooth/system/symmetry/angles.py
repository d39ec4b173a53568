"""Whether the equations repeat with the period of an angle on which they depend.

It is the same question as that of a symmetry: does the map that adds one period to the angle take
the equations of each cell to themselves? It is answered in the same way, at random points.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.engine.tables import FREE
from nonsmooth.errors import ModelError
from nonsmooth.system.model.evaluated import EvaluatedSystem
from nonsmooth.system.symmetry.cell_exits import ENOUGH, is_empty, live_exits
from nonsmooth.system.symmetry.cell_match import Fault, Place, match, random_place
from nonsmooth.system.symmetry.cell_values import CellValues, cell_values
from nonsmooth.system.symmetry.state_map import StateMap

__all__ = ["check_angles"]

_SPAN = 5.0  # of time at which equations are compared where no period is declared


def check_angles(system: EvaluatedSystem) -> None:
    """Refuse an angle on which the equations depend, but not with its period."""
    for name, period in system.angles.items():
        offset = np.zeros(len(system.states))
        offset[system.states.index(name)] = period
        shifted = StateMap(np.eye(offset.size), offset, {}, f"{name} -> {name} + {period:g}", False)
        _check_shift(system, name, period, shifted)


def _check_shift(system: EvaluatedSystem, name: str, period: float, shifted: StateMap) -> None:
    cells, values = cell_values(system.structure), system.parameter_values
    span = system.period_value or _SPAN
    places = [random_place(cell, shifted, values, 0.0, span) for cell in cells]
    pairs = list(zip(cells, places, strict=True))
    for cell, place in pairs:
        if cell.forms.kind == FREE and np.count_nonzero(place.values.finite) < ENOUGH:
            raise ModelError(
                f"drift[{name!r}]: the equations of mode {cell.forms.name!r} have no values at"
                " random points, so it cannot be checked that they repeat with this angle: roots"
                " and logarithms of what is negative there; scale the states to sizes of about one"
            )
    empty = [is_empty(cell.forms, place.values, place.sizes) for cell, place in pairs]
    live = [live_exits(cell.forms, place.values, place.sizes, empty) for cell, place in pairs]
    for i, (cell, place) in enumerate(pairs):
        if empty[i]:
            continue
        # a cell comes to itself, or to another one of its mode, as those of abs(sin(q)) after pi
        others = [k for k, other in enumerate(cells) if k != i and _alike(other, cell)]
        faults = []
        for k in (i, *others):
            found = match(cell, cells[k], place, shifted, (live[i], live[k])).faults
            faults.append(found)
            if not found:
                break
        if faults[-1]:
            raise ModelError(
                f"drift[{name!r}] = {period:g}: the equations do not repeat when {name!r} grows by"
                f" {period:g}: {_told(system, name, faults[0][0], place)}; correct the period or"
                f" the equation, or leave {name!r} out of drift="
            )


def _alike(one: CellValues, other: CellValues) -> bool:
    """Whether two cells are of one mode and one kind."""
    return (one.forms.parent, one.forms.kind) == (other.forms.parent, other.forms.kind)


def _told(system: EvaluatedSystem, name: str, fault: Fault, place: Place) -> str:
    """What differs, at the point where it differs most."""
    if not np.isfinite(fault.wanted):
        return f"{fault.where} is missing, or has no value"
    here = place.states[system.states.index(name), fault.point]
    return (
        f"one period on from {name} = {here:.6g}, {fault.where} is {fault.found:.6g} and should be"
        f" {fault.wanted:.6g}"
    )
