r"""Contacts of a machine with its surroundings, or of two of its parts: stops, springs, friction.

Each is a frozen value that knows where it acts. `machine` asks it for its equations.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from nonsmooth.errors import ModelError, quote
from nonsmooth.structures.contributions import (
    Attachment,
    Contribution,
    SumOfCoordinates,
    check_coordinates,
    check_name,
    check_side,
    check_text,
)
from nonsmooth.structures.state_names import velocity_name
from nonsmooth.system.parts import Exit, Text
from nonsmooth.system.surfaces import Surface

__all__ = ["DryFriction", "GapSpring", "Stop"]

_SIDES = ("above", "below", "both")
_AXES = {"above": 1.0, "below": -1.0}
_MOST_STATIC = 5  # static over kinetic friction; of known pairs of materials it is below 3


@dataclass(frozen=True)
class Stop:
    """A rigid stop, from which a coordinate rebounds at once.

    The impulse acts on the inertia that the model has at the coordinate; see the notes of
    `nonsmooth.structures.reduce`. Where rebounds accumulate, the coordinate rests at the stop until
    the reaction would pull.

    Parameters
    ----------
    coordinate : str, tuple of str or mapping of str to float
        The coordinate, two of which the second is subtracted, or factors of several.
    gap : float or str
        Distance of the stop from zero.
    restitution : float or str
        Speed after an impact over that before, from 0 to 1.
    side : {"above", "below", "both"}, optional
        Whether the stop is at ``gap``, at minus ``gap``, or there is one at both.
    offset : float or str, optional
        Displacement of the stop itself, a text of ``t`` and of parameters where it moves.
    rest : bool, optional
        Whether the coordinate may rest at the stop. Without it a run ends as ``event_limit`` where
        rebounds accumulate.
    name : str, optional
        What parameters and outputs begin with; ``stop1``, ``stop2``, ... by default.

    See Also
    --------
    GapSpring : a stop that gives way.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> mass = ns.Structure([[1.0]], [[1.0]], coordinates=["x"])
    >>> wall = ns.structures.Stop("x", gap=0.1, restitution=0.8)
    >>> machine = ns.structures.machine(
    ...     mass,
    ...     [wall],
    ...     [ns.structures.Force("x", "cos(omega*t)")],
    ...     parameters={"omega": 2.8},
    ...     period="2*pi/omega",
    ... )
    >>> dict(machine.parameters)
    {'omega': 2.8, 'stop1_gap': 0.1, 'stop1_restitution': 0.8}
    >>> ns.simulate(machine, periods=20).attrs["n_events"]
    21
    """

    coordinate: Any
    gap: Text
    restitution: Text
    side: str = field(default="above", kw_only=True)
    offset: Text | None = field(default=None, kw_only=True)
    rest: bool = field(default=True, kw_only=True)
    name: str = field(default="", kw_only=True)
    kind: ClassVar[str] = "stop"

    def __post_init__(self) -> None:
        check_name("Stop", self.name)
        check_coordinates("Stop", several=True, coordinate=self.coordinate)
        check_side("Stop", self.side, _SIDES)
        check_text("Stop", gap=self.gap, restitution=self.restitution)
        if not isinstance(self.rest, bool):
            raise ModelError(f"Stop: rest = {quote(self.rest)}: give True or False")
        if self.offset is not None:
            check_text("Stop", offset=self.offset)

    def _contribution(self, name: str, place: Attachment) -> Contribution:
        """What the stop adds to the equations of a machine."""
        made = Contribution()
        offset = made.offset(name, self.offset, moves=True)
        where = SumOfCoordinates.read(f"{name}: coordinate", self.coordinate, place, offset)
        gap = made.value(f"{name}_gap", self.gap, f"gap of {name} [{where.units[0]}]")
        r = made.value(
            f"{name}_restitution", self.restitution, f"coefficient of restitution of {name}",
            ">= 0", "a rebound leads away from the stop",
        )  # fmt: skip
        if not isinstance(self.restitution, str):
            made.require[f"{r} <= 1"] = "an impact adds no energy"
        resets = _rebounds(where, f"(1 + {r})", place)
        if len(where.factors) == 1 and len(resets) == 1 and not where.offset.text:
            resets = {each: f"-{r}*{each}" for each in resets}
        for side in ("above", "below") if self.side == "both" else (self.side,):
            called = f"{name}_{side}" if self.side == "both" else name
            sign = "-" if side == "above" else "+"
            made.exits.append(
                Exit(
                    f"{gap} {sign} ({where.text})",
                    reset=resets,
                    name=called,
                    sticks=f"{called}_rest" if self.rest else None,
                )
            )
        made.outputs[f"{name}_distance"] = (
            f"{gap} - abs({where.text})"
            if self.side == "both"
            else f"{gap} {'-' if self.side == 'above' else '+'} ({where.text})"
        )
        made.describe[f"{name}_distance"] = f"distance to {name} [{where.units[0]}]"
        return made


def _rebounds(where: SumOfCoordinates, factor: str, place: Attachment) -> dict[str, str]:
    """Velocities behind an impact, of the coordinates that are states and have another one."""
    states = place.form.states
    inertia = place.form.mass[: len(states), : len(states)]
    push = np.zeros(len(states))
    for coordinate, share in where.factors.items():
        push[states.index(coordinate)] = share
    moved = np.linalg.solve(inertia, push)
    moved /= push @ moved  # velocities by an impulse that takes the relative speed one
    moved[np.abs(moved) <= 1e-14 * np.abs(moved).max()] = 0.0
    resets = {}
    for coordinate, share in zip(states, moved.tolist(), strict=True):
        if share:
            velocity = velocity_name(coordinate)
            part = f"{factor}*({where.rate})"
            resets[velocity] = f"{velocity} - {part if share == 1.0 else f'{share!r}*{part}'}"
    return resets


@dataclass(frozen=True)
class GapSpring:
    r"""A spring beyond a gap, with a damper if wanted: an elastic stop, or a snubber.

    With the displacement x of the coordinate the force is :math:`k (x - g) + c \dot x` for
    x > g, and never pulls.

    Parameters
    ----------
    coordinate : str, tuple of str or mapping of str to float
        The coordinate x, or two of which the second is subtracted; the force then acts between
        them. Or factors of several: with ``{"pinion rz": 0.04, "wheel rz": -0.06}`` x is the
        deformation of a gear mesh with these radii, and the force acts as torques.
    gap : float or str
        Displacement at which the spring begins; may be negative, which is a preload, but with
        ``side="both"``: two springs that overlap are two contacts.
    stiffness : float or str
        Its stiffness.
    damping : float or str, optional
        Damping while in contact; none by default.
    side : {"above", "below", "both"}, optional
        Whether the spring is beyond ``gap``, below minus ``gap``, or there is one at both.
    offset : float or str, optional
        Displacement of what the spring is fixed on, which is subtracted from x: a text such as
        ``"e*cos(omega*t)"`` where a stop moves, or the transmission error of gears. With a
        damper it is a text of ``t`` and of parameters.
    name : str, optional
        What parameters and outputs begin with; ``spring1``, ``spring2``, ... by default.

    See Also
    --------
    Stop : a rigid stop.

    Notes
    -----
    The machine stays linear on both sides, so that it runs in closed form. With a damper, contact
    is lost where the force falls to zero, before x comes back to the gap; the spring is then
    relaxed at once.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> mass = ns.Structure([[1.0]], [[1.0]], coordinates=["x"])
    >>> spring = ns.structures.GapSpring("x", gap=0.5, stiffness=8.0, side="both")
    >>> machine = ns.structures.machine(mass, [spring])
    >>> run = ns.simulate(machine, {"x": 1.0}, t_end=10.0)
    >>> run.attrs["phase_word"].split()[:3]
    ['above', 'free', 'below']
    >>> float(run["spring1_force"][0])
    4.0
    """

    coordinate: Any
    gap: Text
    stiffness: Text
    damping: Text | None = None
    side: str = field(default="above", kw_only=True)
    offset: Text | None = field(default=None, kw_only=True)
    name: str = field(default="", kw_only=True)
    kind: ClassVar[str] = "spring"

    def __post_init__(self) -> None:
        check_name("GapSpring", self.name)
        check_coordinates("GapSpring", several=True, coordinate=self.coordinate)
        check_side("GapSpring", self.side, _SIDES)
        check_text("GapSpring", gap=self.gap, stiffness=self.stiffness)
        for key in ("damping", "offset"):
            if getattr(self, key) is not None:
                check_text("GapSpring", **{key: getattr(self, key)})

    def _contribution(self, name: str, place: Attachment) -> Contribution:
        """What the spring adds to the equations of a machine."""
        made = Contribution()
        offset = made.offset(name, self.offset, moves=self.damping is not None)
        where = SumOfCoordinates.read(f"{name}: coordinate", self.coordinate, place, offset)
        length, force_unit = where.units
        both = self.side == "both"
        gap = made.value(
            f"{name}_gap", self.gap, f"gap of {name} [{length}]", ">= 0" if both else "",
            "springs on both sides that overlap are two contacts: give one spring above, one below",
        )  # fmt: skip
        stiffness = made.value(
            f"{name}_stiffness", self.stiffness, f"stiffness of {name} [{force_unit}/{length}]",
            ">= 0", "a spring with a negative stiffness pulls",
        )  # fmt: skip
        damping = ""
        if self.damping is not None:
            damping = made.value(
                f"{name}_damping", self.damping, f"damping of {name} [{force_unit} s/{length}]",
                ">= 0", "negative damping would feed energy in",
            )  # fmt: skip
        force = "0"
        for side in ("below", "above") if self.side == "both" else (self.side,):
            sign = "" if side == "above" else "-"
            depth = f"{name}_{side}"
            made.surfaces[depth] = Surface(
                f"{sign}({where.text}) - {gap}",
                below=place.side(name, "inside" if force != "0" else "free"),
                above=place.side(name, side if self.side == "both" else "contact"),
            )
            push = f"{stiffness}*{depth}"
            if damping:
                press = f"{name}_press_{side}"
                made.surfaces[press] = Surface(
                    f"{push} + {damping}*{sign}({where.rate})",
                    below=place.side(name, "relaxed"),
                    above=place.side(name, "pressed"),
                )
                push = f"max({press}, 0)"
            push = push if side == "above" else f"-{push}"
            force = f"where({depth} > 0, {push}, {force})"
        cells = _CELLS[self.side == "both", bool(damping)]
        made.cells = {signs: place.side(name, cell) for signs, cell in cells.items()}
        made.definitions[f"{name}_push"] = force
        made.loads.append(
            (f"{name}_push", place.at({each: -sign for each, sign in where.factors.items()}))
        )
        made.outputs[f"{name}_force"] = f"{name}_push"
        made.describe[f"{name}_force"] = f"force of {name} [{force_unit}]"
        return made


# names of cells by the signs of their surfaces in the order in which they are declared, by whether
# there is a spring on both sides and whether it is damped
_CELLS = {
    (False, False): {"+": "contact", "-": "free"},
    (False, True): {"++": "contact", "+-": "relaxed", "-.": "free"},
    (True, False): {".+": "above", "--": "free", "+-": "below"},
    (True, True): {
        "..++": "above",
        "..+-": "relaxed",
        "++-.": "below",
        "+--.": "relaxed",
        "-.-.": "free",
    },
}


@dataclass(frozen=True)
class DryFriction:
    """Dry friction at a coordinate: the force opposes the slip, and holds where there is none.

    Parameters
    ----------
    coordinate : str, tuple of str or mapping of str to float
        The coordinate, two that rub on each other, or factors of several.
    force : float or str
        Kinetic friction; a text may depend on states, such as a coefficient times a contact force.
    static : float or str, optional
        Ratio of static to kinetic friction, 1 or more; 1 by default. It is no force.
    speed : float or str, optional
        Velocity of what the coordinate rubs on, such as a belt.
    name : str, optional
        What parameters and outputs begin with; ``friction1``, ... by default.

    Notes
    -----
    Motion at zero slip is Filippov's; see `nonsmooth.Surface`. Nothing is smoothed.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> mass = ns.Structure([[1.0]], [[1.0]], coordinates=["x"])
    >>> machine = ns.structures.machine(mass, [ns.structures.DryFriction("x", force=0.3)])
    >>> run = ns.simulate(machine, {"x": 1.0}, t_end=10.0)
    >>> ns.phase_word(run), round(float(run["x"][-1]), 12)
    (('back', 'forth', 'stick'), -0.2)
    """

    coordinate: Any
    force: Text
    static: Text | None = None
    speed: Text | None = None
    name: str = field(default="", kw_only=True)
    kind: ClassVar[str] = "friction"

    def __post_init__(self) -> None:
        check_name("DryFriction", self.name)
        check_coordinates("DryFriction", several=True, coordinate=self.coordinate)
        check_text("DryFriction", force=self.force)
        for key in ("static", "speed"):
            if getattr(self, key) is not None:
                check_text("DryFriction", **{key: getattr(self, key)})

    def _contribution(self, name: str, place: Attachment) -> Contribution:
        """What the friction adds to the equations of a machine."""
        made = Contribution()
        where = SumOfCoordinates.read(f"{name}: coordinate", self.coordinate, place)
        length, force_unit = where.units
        kinetic = made.value(
            f"{name}_kinetic", self.force, f"kinetic friction of {name} [{force_unit}]",
            ">= 0", "friction acts against the slip",
        )  # fmt: skip
        hold = None
        if self.static is not None:
            hold = made.value(
                f"{name}_static", self.static, f"static over kinetic friction of {name}",
                ">= 1", "what sticks holds at least what slips",
            )  # fmt: skip
            if not isinstance(self.static, str):
                made.require[f"{hold} <= {_MOST_STATIC}"] = (
                    "static is the ratio of static to kinetic friction, no force; give the static"
                    " force over force="
                )
        slip = where.rate
        if self.speed is not None:
            label = f"speed that {name} rubs on [{length}/s]"
            slip += f" - {made.value(f'{name}_speed', self.speed, label)}"
        made.surfaces[f"{name}_slip"] = Surface(
            slip,
            below=place.side(name, "back"),
            on=place.side(name, "stick"),
            above=place.side(name, "forth"),
            hold=hold,
        )
        made.definitions[f"{name}_drag"] = f"-{kinetic}*sign({name}_slip)"
        made.loads.append((f"{name}_drag", place.at(where.factors)))
        made.outputs[f"{name}_force"] = f"{name}_drag"
        made.describe[f"{name}_force"] = f"friction of {name} [{force_unit}]"
        return made
