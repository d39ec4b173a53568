"""What a contact or a load adds to the equations of a machine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError, is_known
from nonsmooth.real_numbers import finite_real, shown
from nonsmooth.structures.coordinates import is_rotation, place_of
from nonsmooth.structures.generalized_form import GeneralizedForm
from nonsmooth.structures.state_names import state_name, velocity_name
from nonsmooth.structures.structure import Structure
from nonsmooth.system.parts import Exit, Text
from nonsmooth.system.surfaces import Surface
from nonsmooth.system.text.grammar import is_name, parse, why_no_name

__all__ = [
    "Attachment",
    "Contribution",
    "RingModes",
    "SumOfCoordinates",
    "check_coordinates",
    "check_name",
    "check_side",
    "check_text",
]  # fmt: skip

Floats = npt.NDArray[np.float64]


@dataclass
class RingModes:
    """A body without mass that is free in one mode and slaved in another."""

    name: str
    states: tuple[str, ...]
    free_flow: Mapping[str, str]
    free_slaved: Mapping[str, str]
    free_definitions: Mapping[str, str]
    free_exit: Exit
    contact_slaved: Mapping[str, str]
    contact_exit: Exit
    cells: Mapping[str, str]


@dataclass
class Contribution:
    """Texts that one contact or load adds; `Attachment` gives the names in them."""

    parameters: dict[str, Text] = field(default_factory=dict)
    definitions: dict[str, Text] = field(default_factory=dict)
    outputs: dict[str, str] = field(default_factory=dict)
    describe: dict[str, str] = field(default_factory=dict)
    require: dict[str, str] = field(default_factory=dict)
    surfaces: dict[str, Surface] = field(default_factory=dict)
    exits: list[Exit] = field(default_factory=list)
    loads: list[tuple[str, Floats]] = field(default_factory=list)
    """Text of a force, and how much of it acts on each generalized coordinate."""
    cells: dict[str, str] = field(default_factory=dict)
    """Names of cells by the signs of its surfaces, where nothing else has surfaces."""
    ring: RingModes | None = None
    turns: bool = False
    """Whether the speed Omega of the shaft stands in the texts."""
    driven: bool = False
    """Whether it repeats with the revolution of the shaft."""

    def value(self, name: str, given: Text, label: str, require: str = "", reason: str = "") -> str:
        """Name for a value: a number becomes a parameter, a text a definition.

        What is required, such as ``>= 0``, holds for numbers; a text is left to who wrote it.
        """
        if isinstance(given, str):
            self.definitions[name] = given
        else:
            self.parameters[name] = given
            self.describe[name] = label
            if require:
                self.require[f"{name} {require}"] = reason
        return name


@dataclass(frozen=True)
class Attachment:
    """Where contacts and loads are attached: a reduced structure, in the states of a machine."""

    structure: Structure
    keep: tuple[str, ...]
    form: GeneralizedForm
    alone: bool
    """Whether the machine has one contact, so that its sides need no name of their own."""

    def side(self, name: str, side: str) -> str:
        """Name of a side of a surface for phase words."""
        return side if self.alone else f"{name}_{side}"

    def named(self, where: str, coordinate: Any) -> str:
        """Name of a coordinate that a load acts on."""
        names = self.structure.coordinates
        return names[place_of(coordinate, names, where)]

    def kept(self, where: str, coordinate: Any) -> str:
        """Name of a coordinate that a contact acts on."""
        name = self.named(where, coordinate)
        if name not in self.keep:
            raise ModelError(
                f"{where}: the reduction does not keep the coordinate {name!r}, only"
                f" {', '.join(self.keep)}; give it in keep= of reduce"
            )
        return name

    def at(self, factors: Mapping[str, float]) -> Floats:
        """Generalized forces of forces on some coordinates, by their names."""
        rows = [self.form.basis[self.structure.index(name)] for name in factors]
        return np.asarray(np.array(list(factors.values())) @ np.array(rows))

    def shares(self, force: Floats) -> Floats:
        """Generalized forces of a force on the full model."""
        return np.asarray(self.form.basis.T @ force, dtype=float)


@dataclass(frozen=True)
class SumOfCoordinates:
    """A displacement that contacts look at: one coordinate, or one minus another."""

    factors: Mapping[str, float]

    @classmethod
    def read(cls, where: str, given: Any, place: Attachment) -> SumOfCoordinates:
        """From the name of a coordinate, or a pair of them."""
        pair = given if isinstance(given, tuple | list) else (given,)
        names = [place.kept(where, each) for each in pair]
        if len(set(names)) < len(names):
            raise ModelError(f"{where}: both coordinates are {names[0]!r}; give two")
        return cls(dict(zip(names, (1.0, -1.0), strict=False)))

    @property
    def text(self) -> str:
        """The displacement."""
        return " - ".join(state_name(name) for name in self.factors)

    @property
    def rate(self) -> str:
        """Its velocity."""
        return " - ".join(velocity_name(name) for name in self.factors)

    @property
    def units(self) -> tuple[str, str]:
        """Units of the displacement and of a force along it, which is a moment along an angle."""
        turns = all(is_rotation(name) for name in self.factors)
        return ("rad", "N m") if turns else ("m", "N")


def check_coordinates(kind: str, *, pair: bool = False, **values: Any) -> None:
    """Refuse what is no coordinate: neither a name nor a number, nor a pair of these if allowed."""
    for name, value in values.items():
        listed = value if pair and isinstance(value, tuple | list) else (value,)
        fits = [isinstance(each, str | int | np.integer) for each in listed]
        if len(fits) not in (1, 2) or not all(fits) or any(isinstance(x, bool) for x in listed):
            more = ", or two of which the second is subtracted" if pair else ""
            raise ModelError(
                f"{kind}: {name} = {shown(value)}: give the name or number of a coordinate{more}"
            )


def check_name(kind: str, name: Any) -> None:
    """Refuse what cannot begin the names of parameters and outputs."""
    if not isinstance(name, str) or (name and not is_name(name)):
        raise ModelError(
            f"{kind}: name={shown(name)} is not a name; use ASCII letters, digits and _, not a"
            f" reserved word{why_no_name(str(name))}"
        )


def check_text(kind: str, **values: Any) -> None:
    """Refuse values that are neither a finite number nor a text of the grammar."""
    for name, value in values.items():
        if isinstance(value, str):
            parse(value, where=f"{kind}: {name}")
        else:
            finite_real(f"{kind}: {name}", value, ModelError, "a finite number or a text")


def check_side(kind: str, side: Any, known: Sequence[str]) -> None:
    """Refuse a side that does not exist."""
    if not is_known(side, known):
        raise ModelError(f"{kind}: side={shown(side)} is not known; give {' or '.join(known)}")
