"""What a contact or a load adds to the equations of a machine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError, is_known, quote
from nonsmooth.real_numbers import finite_real
from nonsmooth.structures.coordinates import is_rotation, place_of
from nonsmooth.structures.generalized_form import GeneralizedForm
from nonsmooth.structures.state_names import state_name, velocity_name, weighted_sum
from nonsmooth.structures.structure import Structure
from nonsmooth.system.algebra.differentiate import rate_of_change
from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.parts import Exit, Mode, Text
from nonsmooth.system.surfaces import Surface
from nonsmooth.system.text.expressions import name_set, to_text
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


class Offset(NamedTuple):
    """Texts of a displacement that is imposed, and of its rate; without a text there is none."""

    text: str
    rate: str = "0"


_FIXED = Offset("")


@dataclass
class RingModes:
    """A body without mass, with a mode by name for each way in which it moves."""

    name: str
    states: tuple[str, ...]
    modes: Mapping[str, Mode]


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
    constants: dict[str, str] = field(default_factory=dict)
    """Names that have to be parameters, and the text that they stand in."""
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

    def offset(self, name: str, given: Text | None, *, moves: bool) -> Offset:
        """Displacement of what a contact is fixed on; with its rate where that is needed."""
        if given is None:
            return _FIXED
        called = f"{name}_offset"
        self.value(called, given, f"displacement of what {name} is fixed on [m]")
        if not moves or not isinstance(given, str):
            return Offset(called)
        self.constants |= dict.fromkeys(sorted(name_set(parse(given)) - {"t", "pi"}), called)
        return Offset(called, rate_of_text(given))


@dataclass(frozen=True)
class Attachment:
    """Where contacts and loads are attached: a reduced structure, in the states of a machine."""

    structure: Structure
    keep: tuple[str, ...]
    form: GeneralizedForm
    alone: bool
    """Whether the machine has one contact, so that its sides need no name of their own."""
    one_ring: bool = False
    """Whether it has one ring without mass: the modes of several multiply."""

    def side(self, name: str, side: str) -> str:
        """Name of a side of a surface for phase words."""
        return side if self.alone else f"{name}_{side}"

    def named(self, where: str, coordinate: Any) -> str:
        """Name of a coordinate that a load acts on."""
        names = self.structure.coordinates
        return names[place_of(coordinate, names, where)]

    def plane(self, name: str, part: Any, *, kept: bool) -> tuple[str, str]:
        """Names of the two coordinates x and y of a ring or an unbalance."""
        found = self.kept if kept else self.named
        x, y = (found(f"{name}: {axis}", getattr(part, axis)) for axis in ("x", "y"))
        if x == y:
            raise ModelError(
                f"{name}: x and y are both {x!r}; give the two coordinates of the shaft there"
            )
        return x, y

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
    """A displacement that contacts look at: coordinates by their factors, less an offset."""

    factors: Mapping[str, float]
    weighted: bool = False
    """Whether the factors were given."""
    offset: Offset = _FIXED
    """Of what the contact is fixed on."""

    @classmethod
    def read(
        cls, where: str, given: Any, place: Attachment, offset: Offset = _FIXED
    ) -> SumOfCoordinates:
        """From the name of a coordinate, a pair of them, or a factor for each of several."""
        weighted = isinstance(given, Mapping)
        listed = given if isinstance(given, Mapping | tuple | list) else (given,)
        shares = given.values() if weighted else (1.0, -1.0)
        names = [place.kept(where, each) for each in listed]
        if len(set(names)) < len(names):
            twice = next(name for i, name in enumerate(names) if name in names[:i])
            raise ModelError(f"{where}: the coordinate {twice!r} stands twice; give it once")
        pairs = zip(names, shares, strict=False)
        factors = {name: float(share) for name, share in pairs if share}
        return cls(factors, weighted, offset)

    @property
    def text(self) -> str:
        """The displacement."""
        total = weighted_sum((factor, state_name(name)) for name, factor in self.factors.items())
        return f"{total} - {self.offset.text}" if self.offset.text else total

    @property
    def rate(self) -> str:
        """Its velocity."""
        pairs = self.factors.items()
        total = weighted_sum((factor, velocity_name(name)) for name, factor in pairs)
        return total if self.offset.rate == "0" else f"{total} - ({self.offset.rate})"

    @property
    def units(self) -> tuple[str, str]:
        """Units of the displacement and of a force along it, which is a moment along an angle.

        Factors of angles are radii.
        """
        turns = not self.weighted and all(is_rotation(name) for name in self.factors)
        return ("rad", "N m") if turns else ("m", "N")


def check_coordinates(kind: str, *, several: bool = False, **values: Any) -> None:
    """Refuse what is no coordinate: neither a name nor a number, nor several of these if allowed.

    Several are two, of which the second is subtracted, or a mapping to factors.
    """
    for name, value in values.items():
        weighted = several and isinstance(value, Mapping)
        listed = value if weighted or (several and isinstance(value, tuple | list)) else (value,)
        fits = [isinstance(each, str | int | np.integer) for each in listed]
        many = not fits or (len(fits) > 2 and not weighted)
        if many or not all(fits) or any(isinstance(each, bool) for each in listed):
            more = (
                ", two of which the second is subtracted, or a mapping of coordinates to factors"
                if several
                else ""
            )
            raise ModelError(
                f"{kind}: {name} = {quote(value)}: give the name or number of a coordinate{more}"
            )
        if weighted:
            factors = [
                finite_real(f"{kind}: {name}[{quote(each)}]", factor, ModelError)
                for each, factor in value.items()
            ]
            if not any(factors):
                raise ModelError(f"{kind}: {name} = {quote(value)}: give a factor that is not zero")


def rate_of_text(text: str) -> str:
    """Rate of change in time of a text in which everything but ``t`` is constant."""
    graph = Graph(())
    rate = rate_of_change(graph, graph.imported(parse(text)), graph.name)
    return "0" if rate is graph.zero else to_text(rate)


def check_name(kind: str, name: Any) -> None:
    """Refuse what cannot begin the names of parameters and outputs."""
    if not isinstance(name, str) or (name and not is_name(name)):
        raise ModelError(
            f"{kind}: name={quote(name)} is not a name; use ASCII letters, digits and _, not a"
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
        raise ModelError(f"{kind}: side={quote(side)} is not known; give {' or '.join(known)}")
