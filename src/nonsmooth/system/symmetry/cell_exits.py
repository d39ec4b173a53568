"""Exits of a cell that can be passed, told from those that only the splitting of a text has made.

The cells of ``clip(x, -1, 1)`` are those of a decision tree: beyond one of its ends both surfaces
are asked for, beyond the other one only one. So a cell may have a guard ``x + 1`` beside ``x - 1``,
which is never reached, and there may be cells in which no point lies.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.tables import FREE
from nonsmooth.system.compile.mode_forms import ModeForms
from nonsmooth.system.symmetry.cell_values import ValuesAt

__all__ = ["ENOUGH", "LiveExits", "is_empty", "live_exits"]

Floats = npt.NDArray[np.float64]

ENOUGH = 4  # points with values; there are none where a root is negative
_ROUNDING = 1e-9  # of the terms of guards


@dataclass(frozen=True)
class LiveExits:
    """Numbers of the exits that can be passed, and for each exit that onto its surface or -1."""

    numbers: tuple[int, ...]
    onto: tuple[int, ...]


def is_empty(forms: ModeForms, values: ValuesAt, sizes: ValuesAt) -> bool:
    """Whether no point lies in a cell: its guards contradict each other, or none was found.

    On meetings of surfaces the equations of slaved states may be singular; motion that comes there
    has no image.
    """
    if forms.kind != FREE and np.count_nonzero(values.finite) < ENOUGH:
        return True
    return any(
        offset < 0.0 and factor <= 0.0
        for _, _, factor, offset in _related(forms.n_searched, values, sizes)
    )


def live_exits(
    forms: ModeForms, values: ValuesAt, sizes: ValuesAt, empty: Sequence[bool]
) -> LiveExits:
    """Exits of a cell without those that are never passed; ``empty`` are cells without points."""
    if np.count_nonzero(values.finite) < ENOUGH:
        return LiveExits((), (-1,) * len(forms.targets))
    behind = {
        i
        for i, _, factor, offset in _related(forms.n_searched, values, sizes)
        if offset > 0.0 and factor >= 0.0
    }
    targets, count = forms.targets, len(forms.targets)
    gone = behind | {e for e in range(forms.n_searched, count) if empty[targets[e]]}
    gone |= {forms.onto[e] for e in behind if forms.onto[e] >= 0}
    onto = tuple(-1 if f in gone else f for f in forms.onto)
    return LiveExits(tuple(e for e in range(count) if e not in gone), onto)


def _related(count: int, values: ValuesAt, sizes: ValuesAt) -> list[tuple[int, int, float, float]]:
    """Guards i that are ``factor`` times guard j plus ``offset``, an offset beyond rounding."""
    able = values.finite
    guards, terms = values.guards[:count, able], sizes.guards[:count, able]
    rounding = _ROUNDING * terms
    found = []
    for i in range(count):
        # the states of a cell on a relation fulfil it to rounding, and so do guards that follow
        if np.all(np.abs(guards[i] - guards[i, 0]) <= rounding[i]):
            if np.abs(guards[i, 0]) > rounding[i].max():
                found.append((i, i, 0.0, float(guards[i, 0])))
            continue
        for j in range(count):
            a, b = int(np.argmax(guards[j])), int(np.argmin(guards[j]))
            run = guards[j, a] - guards[j, b]
            if i == j or run <= rounding[j].max():
                continue
            factor = (guards[i, a] - guards[i, b]) / run
            offset = guards[i, a] - factor * guards[j, a]
            size = rounding[i] + np.abs(factor) * rounding[j]
            gap = np.abs(guards[i] - factor * guards[j] - offset)
            if np.all(gap <= size) and np.abs(offset) > size.max():
                found.append((i, j, float(factor), float(offset)))
    return found
