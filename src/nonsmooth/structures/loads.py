r"""Loads of a machine: unbalance, weight, motion of the base, and forces of any text."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError, is_known, quote
from nonsmooth.real_numbers import finite_real
from nonsmooth.structures.contributions import (
    Attachment,
    Contribution,
    check_coordinates,
    check_name,
    check_text,
)
from nonsmooth.structures.coordinates import in_direction, is_rotation, place_of
from nonsmooth.system.parts import Text

__all__ = ["BaseMotion", "Force", "Unbalance", "Weight"]

_DIRECTIONS = ("x", "y", "z")
_ALLOWED = (
    "'x', 'y' or 'z' where names of coordinates end so, or a mapping of coordinates to their"
    " displacement as the whole structure moves by one"
)


@dataclass(frozen=True)
class Force:
    """A force at one coordinate: a number, or a text of time, parameters, signals and states.

    Parameters
    ----------
    coordinate : str
        Any coordinate of the structure; it need not be kept. Give it in ``driven=`` of `reduce`,
        so that the estimate of the error counts it.
    force : float or str
        The force, such as ``"F*cos(omega*t)"`` or the name of a measured signal.
    name : str, optional
        What parameters and outputs begin with; ``force1``, ``force2``, ... by default.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> mass = ns.Structure([[2.0]], [[8.0]], coordinates=["x"])
    >>> machine = ns.structures.machine(mass, loads=[ns.structures.Force("x", 4.0)])
    >>> run = ns.simulate(machine, {"x": 0.5}, t_end=5)  # the equilibrium
    >>> float(run["x"].max())
    0.5
    """

    coordinate: str | int
    force: Text
    name: str = field(default="", kw_only=True)
    kind: ClassVar[str] = "force"

    def __post_init__(self) -> None:
        check_name("Force", self.name)
        check_coordinates("Force", coordinate=self.coordinate)
        check_text("Force", force=self.force)

    def _contribution(self, name: str, place: Attachment) -> Contribution:
        """What the force adds to the equations of a machine."""
        made = Contribution()
        coordinate = place.named(f"{name}: coordinate", self.coordinate)
        kind, unit = ("moment", "N m") if is_rotation(coordinate) else ("force", "N")
        made.value(name, self.force, f"{kind} at {coordinate} [{unit}]")
        made.loads.append((name, place.at({coordinate: 1.0})))
        return made


@dataclass(frozen=True)
class Unbalance:
    r"""An unbalance that turns with the shaft at its speed Omega, from x to y.

    The force is :math:`u \Omega^2 (\cos(\Omega t + \varphi), \sin(\Omega t + \varphi))`. The period
    of the machine is one revolution.

    Parameters
    ----------
    x, y : str
        Coordinates on which it acts; they need not be kept, but given in ``driven=`` of `reduce`.
    moment : float or str
        Mass times eccentricity.
    phase : float or str, optional
        Its angle at time zero, in rad.
    name : str, optional
        What parameters begin with; ``unbalance1``, ... by default.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> rotor = ns.Structure(np.eye(2), np.eye(2), coordinates=["1x", "1y"])
    >>> load = ns.structures.Unbalance("1x", "1y", moment=0.1)
    >>> machine = ns.structures.machine(rotor, loads=[load], Omega=0.6)
    >>> orbit = ns.find_orbit(machine, {"x1": 0.03})
    >>> float(orbit["x1"].round(12))  # u Omega^2/(1 - Omega^2)
    0.05625
    """

    x: str | int
    y: str | int
    moment: Text
    phase: Text = 0.0
    name: str = field(default="", kw_only=True)
    kind: ClassVar[str] = "unbalance"

    def __post_init__(self) -> None:
        check_name("Unbalance", self.name)
        check_coordinates("Unbalance", x=self.x, y=self.y)
        check_text("Unbalance", moment=self.moment, phase=self.phase)

    def _contribution(self, name: str, place: Attachment) -> Contribution:
        """What the unbalance adds to the equations of a machine."""
        made = Contribution(turns=True, driven=True)
        moment = made.value(
            f"{name}_moment", self.moment, f"mass times eccentricity of {name} [kg m]"
        )
        phase = made.value(f"{name}_phase", self.phase, f"angle of {name} [rad]")
        at = place.plane(name, self, kept=False)
        for wave, axis, coordinate in zip(("cos", "sin"), ("x", "y"), at, strict=True):
            force = f"{name}_{axis}"
            made.definitions[force] = f"{moment}*Omega**2*{wave}(Omega*t + {phase})"
            made.loads.append((force, place.at({coordinate: 1.0})))
        return made


@dataclass(frozen=True)
class Weight:
    """The weight of the whole structure, by its mass matrix.

    Parameters
    ----------
    direction : {"x", "y", "z"} or mapping of str to float
        Direction along which the acceleration acts, from the names of the coordinates; or the
        displacement of each coordinate in a unit displacement of the whole structure.
    acceleration : float or str, optional
        The acceleration, -9.81 by default, which is downward in m/s^2.
    name : str, optional
        What the parameter is called; ``weight1`` by default.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> rotor = ns.Structure(np.eye(2), 981 * np.eye(2), coordinates=["1x", "1y"])
    >>> machine = ns.structures.machine(rotor, loads=[ns.structures.Weight("y")])
    >>> run = ns.simulate(machine, {"y1": -0.01}, t_end=1)
    >>> round(float(run["y1"].max()), 12)
    -0.01
    """

    direction: Any
    acceleration: Text = -9.81
    name: str = field(default="", kw_only=True)
    kind: ClassVar[str] = "weight"

    def __post_init__(self) -> None:
        check_name("Weight", self.name)
        _check_direction("Weight", self.direction)
        check_text("Weight", acceleration=self.acceleration)

    def _contribution(self, name: str, place: Attachment) -> Contribution:
        """What the weight adds to the equations of a machine."""
        made = Contribution()
        made.value(name, self.acceleration, "acceleration of the weight [m/s^2]")
        made.loads.append((name, _inertia_forces(name, self.direction, place)))
        return made


@dataclass(frozen=True)
class BaseMotion:
    """Motion of the base along one direction, by its acceleration.

    Displacements are then relative to the base, on which all contacts are fixed.

    Parameters
    ----------
    direction : {"x", "y", "z"} or mapping of str to float
        As in `Weight`.
    acceleration : float or str
        Acceleration of the base: a text of time, or the name of a measured signal.
    name : str, optional
        What the definition is called; ``base1`` by default.

    Examples
    --------
    A base that moves as sin(2 t):

    >>> import nonsmooth as ns
    >>> mass = ns.Structure([[1.0]], [[1.0]], coordinates=["1x"])
    >>> shaking = ns.structures.BaseMotion("x", "-4*sin(2*t)")
    >>> machine = ns.structures.machine(mass, loads=[shaking], period="pi")
    >>> orbit = ns.find_orbit(machine)
    >>> float(orbit["vx1"].round(12))  # x = -4/3 sin(2 t)
    -2.666666666667
    """

    direction: Any
    acceleration: Text
    name: str = field(default="", kw_only=True)
    kind: ClassVar[str] = "base"

    def __post_init__(self) -> None:
        check_name("BaseMotion", self.name)
        _check_direction("BaseMotion", self.direction)
        check_text("BaseMotion", acceleration=self.acceleration)

    def _contribution(self, name: str, place: Attachment) -> Contribution:
        """What the motion of the base adds to the equations of a machine."""
        made = Contribution()
        made.value(name, self.acceleration, "acceleration of the base [m/s^2]")
        made.loads.append((name, -_inertia_forces(name, self.direction, place)))
        return made


def _check_direction(kind: str, direction: Any) -> None:
    if isinstance(direction, Mapping):
        for coordinate, factor in direction.items():
            check_coordinates(kind, **{"a key of direction": coordinate})
            finite_real(f"{kind}: direction[{quote(coordinate)}]", factor, ModelError)
    elif not is_known(direction, _DIRECTIONS):
        raise ModelError(f"{kind}: direction = {quote(direction)}: give {_ALLOWED}")


def _inertia_forces(name: str, direction: Any, place: Attachment) -> npt.NDArray[np.float64]:
    """Generalized forces of a unit acceleration of all masses along a direction."""
    structure = place.structure
    along = np.zeros(structure.size)
    if isinstance(direction, Mapping):
        for coordinate, factor in direction.items():
            if coordinate in _DIRECTIONS and coordinate not in structure.coordinates:
                raise ModelError(
                    f"{name}: direction: no coordinate is called {coordinate!r}; for all that moves"
                    f" along it give direction={coordinate!r}, and the size as acceleration="
                )
            at = place_of(coordinate, structure.coordinates, f"{name}: direction")
            along[at] = factor
    else:
        along[in_direction(direction, structure.coordinates)] = 1.0
    if not along.any():
        raise ModelError(
            f"{name}: direction = {quote(direction)}: no coordinate moves so; give {_ALLOWED}"
        )
    return place.shares(structure.mass @ along)
