"""What cells are called in results: by the signs of their surfaces, or as the mode says."""

from __future__ import annotations

from collections.abc import Mapping

from nonsmooth.errors import ModelError, unknown_name
from nonsmooth.system.cells import SplitMode
from nonsmooth.system.parts import Mode

__all__ = ["cell_labels"]


def cell_labels(modes: Mapping[str, Mode], splits: Mapping[str, SplitMode]) -> dict[str, str]:
    """Label of every cell by its name, such as ``contact[+-]``."""
    labels: dict[str, str] = {}
    for name, found in splits.items():
        given = dict(modes[name].cells or {})
        for cell in found.cells:
            label = given.pop(found.signs_of(cell), None)
            labels[found.name_of(cell)] = label or found.name_of(cell)
            if label in splits and label != name:
                raise ModelError(
                    f"modes[{name!r}].cells: {label!r} is the name of another mode; choose another"
                )
        if given:
            raise ModelError(_fault(name, found, next(iter(given))))
    return labels


def _fault(name: str, found: SplitMode, signs: str) -> str:
    place = f"modes[{name!r}].cells"
    count = len(found.names)
    if count == 0:
        return f"{place}: nothing in this mode is piecewise, so it has no cells; leave cells= out"
    shown = ", ".join(f"{surface} at {found.text_of(surface)} = 0" for surface in found.nodes)
    if "0" in signs:
        return (
            f"{place}: {signs!r} names a cell on a surface, where motion slides; sliding is not"
            f" supported in this version (surfaces: {shown})"
        )
    known = [found.signs_of(cell) for cell in found.cells]
    if len(signs) != count:
        return (
            f"{place}: {signs!r} has {len(signs)} signs and the mode has {count} surfaces"
            f" ({shown}); its cells are {', '.join(known)}"
        )
    return f"{place}: {unknown_name('cell', signs, known)} (surfaces: {shown})"
