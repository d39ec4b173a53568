"""Whether anything in the equations depends on a state: what `drift` declares of it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

from nonsmooth.system.algebra.linear import LinearForm, State
from nonsmooth.system.compile.structure import SystemStructure
from nonsmooth.system.text.expressions import ONE

__all__ = ["where_it_stands"]


@lru_cache(maxsize=128)  # a structure is shared by systems, and so is the answer
def where_it_stands(structure: SystemStructure, state: str) -> str:
    """The first place that depends on a state, "" where nothing does.

    The reset of the state itself may move it, by what does not depend on it.
    """
    return next((where for where, depends in _dependences(structure, state) if depends), "")


def _dependences(structure: SystemStructure, state: str) -> Iterator[tuple[str, bool]]:
    """Everything that may depend on a state, and whether it does."""
    for forms in structure.modes.values():
        if forms.taylor is not None:
            for where, node, own in forms.taylor.with_place(forms.name):
                yield where, forms.depends(node, state, own)
        elif forms.linear is not None:
            for where, form, own in forms.linear.with_place(forms.name):
                yield where, _form_depends(form, state, own)


def _form_depends(form: LinearForm, state: str, own: str) -> bool:
    if own != state:
        return State(state) in form.terms
    moved = {b: c for b, c in form.terms.items() if b != State(state)}
    stays = form.coefficient(State(state)) == ONE
    return not stays or any(isinstance(b, State) for b in moved)
