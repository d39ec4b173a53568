"""`View`: what a page shows, as a plain value; two pages with equal views show the same.

Gestures make a new view of an old one, links and scripts are written from it, and everything that
a page computes is computed from it alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any

from nonsmooth.errors import OptionError, quote, unknown_name
from nonsmooth.models.ready_made import ready_made
from nonsmooth.system.system import System

__all__ = ["MOST", "PICTURES", "STARTS", "View", "diagram_variables", "system_of"]

STARTS = ("restart", "follow up", "follow down")
PICTURES = ("basins", "section")

# What one gesture may ask for. Work below these takes seconds for a usual machine.
MOST = {"length": 5_000.0, "leave_out": 20_000.0, "columns": 4_000, "transient": 5_000}
MOST |= {"record": 2_000, "cells": 400, "turn": 64}
_LONGEST_TEXT = 200_000  # characters of a typed system

Pairs = tuple[tuple[str, Any], ...]


@dataclass(frozen=True, kw_only=True)
class View:
    """What a page shows. Counts are in periods, or in iterates where there is a section."""

    model: str = ""  # a ready-made system, or else
    text: str = ""  # the TOML text of one
    values: Pairs = ()  # parameters that differ from those of the system, as they were typed
    initial: Pairs = ()  # where the motion begins; other states are at rest
    leave_out: float = 0.0  # of the motion before it is shown: periods, or units of time
    length: float = 20.0  # of the motion shown
    drawn: tuple[str, ...] = ()  # variables over time
    portrait: tuple[str, ...] = ()  # two variables
    over: str = ""  # parameter of the diagram
    between: tuple[float, ...] = ()  # its first and last value
    shown: str = ""  # variable of the diagram
    height: tuple[float, ...] = ()  # part of that variable; empty for all of it
    start: str = "restart"
    columns: int = 400
    transient: int = 100
    record: int = 40
    section: str = ""  # of diagram, basins and points; empty for strobes of the forcing
    picture: str = "basins"
    plane: tuple[str, ...] = ()  # two states of basins and points
    region: tuple[float, ...] = ()  # their ranges: two numbers each; empty for around the motion
    cells: int = 100  # on each side
    turn: int = 0  # periods of the orbit that is shown; 0 for none, -1 for those of the motion
    branch: bool = False  # whether the orbit is followed over the parameter
    event: int = -1  # row of the event log that is told; -1 for none

    @property
    def system(self) -> System:
        """The system, with the values of its parameters."""
        return system_of(self.model, self.text, self.values)

    @property
    def start_state(self) -> dict[str, float] | None:
        """Where the motion begins, as verbs take it."""
        return dict(self.initial) or None

    def check(self) -> System:
        """System of the view; an error names what cannot be shown of it."""
        for item in fields(self):
            _check_kind(item.name, getattr(self, item.name), item.default)
        system = self.system
        variables = [*system.states, *system.outputs]
        self._check_whole()
        _check_names("state", [name for name, _ in self.initial], system.states)
        _check_names("variable", [*self.drawn, *self.portrait], variables)
        _check_names("state", self.plane, system.states)
        _check_names("parameter", [self.over] if self.over else [], system.parameters)
        _check_names("variable", [self.shown] if self.shown else [], diagram_variables(system))
        for name, known in (("start", STARTS), ("picture", PICTURES)):
            if getattr(self, name) not in known:
                raise OptionError(unknown_name(name, getattr(self, name), known))
        for name, count in (("portrait", 2), ("plane", 2), ("between", 2), ("height", 2)):
            _check_count(name, getattr(self, name), count)
        _check_count("region", self.region, 4)
        for name, most in MOST.items():
            least = {"leave_out": 0, "transient": 0, "turn": -1}.get(name, 1e-9)
            if not least <= getattr(self, name) <= most:
                raise OptionError(
                    f"{name} = {getattr(self, name):g} is not from {max(least, 0):g} to {most:g},"
                    " which is what a page computes; take a script for more"
                )
        self.check_section()
        return system

    def _check_whole(self) -> None:
        """An error where a pane lacks what it needs to be drawn."""
        for name in ("drawn", "portrait"):
            if not getattr(self, name):
                raise OptionError(f"{name}: give at least one variable of the system")
        if self.over:
            if len(self.between) != 2:
                raise OptionError("between: give two numbers, the first and the last value")
            if not self.shown:
                raise OptionError("shown: give a variable for the diagram")
        elif self.branch:
            raise OptionError("branch: it needs a parameter, over, to be followed by")
        if len(set(self.plane)) < len(self.plane):
            raise OptionError("plane: give two different states")

    def check_section(self) -> None:
        """An error where the section is none of the system."""
        if self.section:
            _check_section(self.model, self.text, self.section)


def diagram_variables(system: System) -> list[str]:
    """What a diagram may show of a motion: variables, counts, and how far it comes in a period."""
    drifts = [f"{name}_per_period" for name in system.drift_states if system.period]
    return [*system.states, *system.outputs, "period", "events", "impacts", *drifts]


@lru_cache(maxsize=64)
def _check_section(model: str, text: str, section: str) -> None:
    """Names in a section do not depend on parameters, so a slider does not wait for this."""
    from nonsmooth.runs.poincare_map import PoincareMap

    PoincareMap(system_of(model, text), section)


def _check_kind(name: str, value: Any, default: Any) -> None:
    """A field has the type of its default, and numbers are finite."""
    kind = (int, float) if isinstance(default, float) else type(default)
    if not isinstance(value, kind) or isinstance(value, bool) != isinstance(default, bool):
        raise OptionError(f"{name} = {quote(value)} is not of the kind of {default!r}")
    numbers = [value] if isinstance(value, float) else value if isinstance(value, tuple) else ()
    for number in numbers:
        inner = number[1] if isinstance(number, tuple) else number
        if isinstance(inner, float) and not math.isfinite(inner):
            raise OptionError(f"{name}: {inner} is not a finite number")


def _check_names(kind: str, names: Any, known: Any) -> None:
    for name in names:
        if name not in known:
            raise OptionError(unknown_name(kind, name, known))


def _check_count(name: str, value: tuple[Any, ...], count: int) -> None:
    if len(value) not in (0, count):
        raise OptionError(f"{name}: {len(value)} entries, where {count} belong")


@lru_cache(maxsize=64)
def system_of(model: str, text: str, values: Pairs = ()) -> System:
    """System of a name or a TOML text, with some values of parameters.

    Values are numbers or constant expressions of the grammar; nothing is executed.
    """
    base = _base(model, text)
    if not values:
        return base
    return base.with_parameters(**{name: _number_or_text(value) for name, value in values})


@lru_cache(maxsize=64)
def _base(model: str, text: str) -> System:
    if text:
        if len(text) > _LONGEST_TEXT:
            raise OptionError(
                f"the text has {len(text):,} characters; a page takes {_LONGEST_TEXT:,}"
            )
        # text without a line break would name a file
        return System.from_toml(text if "\n" in text else text + "\n")
    known = ready_made()
    if model not in known:
        raise OptionError(unknown_name("model", model, known))
    return known[model]()


def _number_or_text(value: Any) -> float | str:
    try:
        return float(value)
    except ValueError:
        return str(value)
