"""`Mode` and `Exit`: the words in which a user writes a piecewise-smooth system.

They hold texts exactly as given; `System` gives them meaning and checks them together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NoReturn, TypeVar

from nonsmooth.errors import ModelError, quote
from nonsmooth.system.text.grammar import is_name, why_no_name

__all__ = ["STOP", "Exit", "FrozenDict", "Mode", "Text", "items_of"]

K = TypeVar("K")
V = TypeVar("V")


class FrozenDict(dict[K, V]):
    """A dict whose methods of change raise TypeError."""

    def _refuse(self, *arguments: Any, **named: Any) -> NoReturn:
        raise TypeError("a system is a value and cannot be changed; make a new one")

    __setitem__ = __delitem__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse
    __ior__ = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return FrozenDict, (dict(self),)


Text = str | float | int
STOP = "stop"


def items_of(value: Any, wanted: str) -> tuple[Any, ...]:
    """What stands in a list, or an error that says what is wanted."""
    try:
        if not isinstance(value, str | bytes | set | frozenset | Mapping):
            return tuple(value)
    except TypeError:  # nothing to go through, whatever the type promises
        pass
    raise ModelError(f"{wanted}, not {quote(value)}")


@dataclass(frozen=True, slots=True)
class Exit:
    """A way out of a mode.

    The guard is positive inside the mode. The exit fires when the guard is negative, or
    zero with its first non-zero derivative, up to the fifth, negative; a guard that stays
    zero holds.

    Parameters
    ----------
    guard : str
        Expression that is positive inside the mode.
    to : str, optional
        Mode entered, or ``"stop"`` to end the run; the same mode by default.
    reset : mapping of str to str, optional
        New values of some states from the values just before, all at once.
    name : str, optional
        Name of the event; the target's name by default.
    sticks : str, optional
        Name of the mode in which the guard rests at zero: entered when rebounds accumulate, at
        a start at rest and behind a reset that takes all speed. The reaction acts along the
        jump of the reset, and the mode ends when it would have to pull. For exits that lead
        back to their own mode. Every set of them that may be at rest together is a mode.

    Examples
    --------
    >>> from nonsmooth import Exit
    >>> Exit("sigma - x", reset={"v": "-r*v"}, name="impact").name
    'impact'
    """

    guard: Text
    to: str | None = None
    reset: Mapping[str, Text] = field(default_factory=dict)
    name: str | None = None
    sticks: str | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.reset, Mapping):
            raise ModelError(
                f"Exit: reset maps state names to expressions, not {quote(self.reset)}"
            )
        object.__setattr__(self, "reset", FrozenDict(self.reset))
        for label, value in (("to", self.to), ("name", self.name), ("sticks", self.sticks)):
            if value is not None and not (isinstance(value, str) and is_name(value)):
                raise ModelError(
                    f"Exit: {label}={quote(value)} is not a name; use ASCII letters, digits and _,"
                    f" not a reserved word{why_no_name(value)}"
                )


@dataclass(frozen=True, slots=True)
class Mode:
    """One piece of a system: flow, exits and relations that hold in it.

    Where flow and slaved states are linear in the states, and guards at most quadratic, the
    mode runs in closed form, whatever its resets; any other text makes it run by Taylor
    series.

    Where a text is piecewise in the states or in time, the mode runs as several cells. Each
    distinct switching function, up to a numeric factor, is a surface, numbered ``s1 s2 ...``
    in order of appearance, and its leading state counts as positive: ``1 - x`` and
    ``2*x - 2`` are the surface ``x - 1``. A cell is named by the signs of the surfaces, as
    in ``contact[+-]``, with ``.`` for a surface that does not exist there and ``0`` for a cell on
    it, where motion slides. Exits belong to the mode and hold in all of its cells.

    Parameters
    ----------
    flow : mapping of str to str
        Rate of change of each state that is not slaved.
    exits : sequence of Exit, optional
        Ways out, in the order in which they are tried when several fire at one instant.
    slaved : mapping of str to str, optional
        States given by an equation instead of a flow: by an expression, or by a relation
        with ``=``. Relations are solved together, those that are not linear by Newton's
        method from the present values; of these at most six may depend on each other.
    definitions : mapping of str to str, optional
        Intermediate expressions that differ from the system's in this mode.
    cells : mapping of str to str, optional
        Names of cells by their signs, ``{"++": "both"}``; several may share one.

    Examples
    --------
    >>> from nonsmooth import Exit, Mode
    >>> mode = Mode({"x": "v", "v": "-x"}, exits=[Exit("x", reset={"v": "-v"})])
    >>> sorted(mode.flow)
    ['v', 'x']
    """

    flow: Mapping[str, Text]
    exits: Sequence[Exit] = ()
    slaved: Mapping[str, Text] = field(default_factory=dict)
    definitions: Mapping[str, Text] = field(default_factory=dict)
    cells: Mapping[str, str] | None = None

    def __post_init__(self) -> None:
        for label in ("flow", "slaved", "definitions"):
            value = getattr(self, label)
            if not isinstance(value, Mapping):
                raise ModelError(f"Mode: {label} maps names to expressions, not {quote(value)}")
            object.__setattr__(self, label, FrozenDict(value))
        exits = (
            (self.exits,)
            if isinstance(self.exits, Exit)
            else items_of(self.exits, "Mode: exits is a list of Exit")
        )
        for position, way in enumerate(exits):
            if not isinstance(way, Exit):
                raise ModelError(
                    f"Mode: exits[{position}] is {quote(way)}; write Exit(guard, to=...)"
                )
        object.__setattr__(self, "exits", exits)
        if self.cells is not None:
            if not isinstance(self.cells, Mapping):
                raise ModelError(f"Mode: cells maps signs to names, not {quote(self.cells)}")
            for signs, name in self.cells.items():
                if not isinstance(signs, str) or not isinstance(name, str) or not is_name(name):
                    raise ModelError(
                        f"Mode: cells[{quote(signs)}] = {quote(name)}: give names by signs, such as"
                        " {'+-': 'left'}; a name has ASCII letters, digits and _"
                    )
            object.__setattr__(self, "cells", FrozenDict(self.cells) or None)
