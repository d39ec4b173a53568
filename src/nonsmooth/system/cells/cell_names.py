"""What cells are called in results: by the signs of their surfaces, or as the texts say."""

from __future__ import annotations

from collections.abc import Mapping

from nonsmooth.errors import ModelError, unknown_name
from nonsmooth.system.cells.cells import Cell, SplitMode
from nonsmooth.system.cells.pieces import Family
from nonsmooth.system.parts import Mode

__all__ = ["cell_labels"]


def cell_labels(modes: Mapping[str, Mode], families: Mapping[str, Family]) -> dict[int, str]:
    """Label of every cell by its id: ``contact[+-]``, or what `Mode` and `Surface` call it."""
    labels: dict[int, str] = {}
    for name, family in families.items():
        found = family.split
        given = {} if family.resting else dict(modes[name].cells or {})
        for cell in (*found.cells, *found.sliding):
            label = given.pop(found.signs_of(cell), None)
            labels[id(cell)] = label or _by_sides(found, cell, len(modes)) or found.name_of(cell)
            if label in families and label != name:
                raise ModelError(
                    f"modes[{name!r}].cells: {label!r} is the name of another mode; choose another"
                )
        if given:
            raise ModelError(_fault(name, found, next(iter(given))))
    return labels


def _by_sides(found: SplitMode, cell: Cell, n_modes: int) -> str:
    """Names of the sides of a cell, where each of its surfaces has one."""
    sides = []
    for key, sign in cell.signs.items():
        declared = found.declared.get(key)
        label = None if declared is None else declared.label(sign)
        if label is None:
            return ""
        sides.append(label)
    if not sides:
        return ""
    label = ",".join(sides)
    return (
        label
        if n_modes == 1 and found.equations.name == "flow"
        else (f"{found.equations.name}[{label}]")
    )


def _fault(name: str, found: SplitMode, signs: str) -> str:
    place = f"modes[{name!r}].cells"
    count = len(found.names)
    if count == 0:
        return f"{place}: nothing in this mode is piecewise, so it has no cells; leave cells= out"
    shown = ", ".join(f"{surface} at {found.text_of(surface)} = 0" for surface in found.nodes)
    known = [found.signs_of(cell) for cell in (*found.cells, *found.sliding)]
    if len(signs) != count:
        return (
            f"{place}: {signs!r} has {len(signs)} signs and the mode has {count} surfaces"
            f" ({shown}); its cells are {', '.join(known)}"
        )
    if "0" in signs:
        return (
            f"{place}: {signs!r} names a cell on a surface across which the field does not jump, so"
            f" nothing slides there; cells are {', '.join(known)} (surfaces: {shown})"
        )
    return f"{place}: {unknown_name('cell', signs, known)} (surfaces: {shown})"
