r"""Rings around a shaft: one that is a spring and rubs, and the preloaded ring without mass."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from nonsmooth.errors import ModelError
from nonsmooth.models.rotors.matrices import ring_words
from nonsmooth.models.rotors.texts import RingNames, often_rides
from nonsmooth.structures.contributions import (
    Attachment,
    Contribution,
    RingModes,
    check_coordinates,
    check_name,
    check_text,
)
from nonsmooth.structures.state_names import state_name, velocity_name
from nonsmooth.system.parts import Mode, Text
from nonsmooth.system.surfaces import Surface

__all__ = ["RubRing", "SnubberRing"]


@dataclass(frozen=True)
class RubRing:
    r"""A ring that is a spring in every direction, with Coulomb friction on the turning shaft.

    Where the shaft is at r > gap from the centre of the ring, N = k (r - gap) presses it back, and
    friction f N acts at right angles to that, against the slip
    :math:`u = \Omega R + (x \dot y - y \dot x)/r` of its surface, as in
    `nonsmooth.models.rubbing_rotor`.

    Parameters
    ----------
    x, y : str
        Coordinates of the shaft at the ring.
    gap : float or str
        Radial clearance.
    stiffness : float or str
        Stiffness of the ring.
    friction : float or str, optional
        Coefficient of friction; none by default.
    radius : float or str, optional
        Radius of the shaft; required with friction.
    centre_x, centre_y : float or str, optional
        Centre of the ring.
    name : str, optional
        What parameters and outputs begin with; ``rub1``, ... by default.

    Notes
    -----
    In contact the machine is not linear and runs by Taylor series, with steps as short as its
    fastest natural mode requires; free of contact it runs in closed form. The moment of the
    friction about the axis is left out: the shaft keeps its speed.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> rotor = ns.Structure(
    ...     np.eye(2), np.eye(2), damping=0.2 * np.eye(2), coordinates=["1x", "1y"]
    ... )
    >>> ring = ns.structures.RubRing(
    ...     "1x", "1y", gap=1.0, stiffness=20.0, friction=0.05, radius=60.0
    ... )
    >>> load = ns.structures.Unbalance("1x", "1y", moment=0.7)
    >>> machine = ns.structures.machine(rotor, [ring], [load], Omega=1.5)
    >>> run = ns.simulate(machine, {"x1": 1.0, "vy1": 1.5}, periods=100)
    >>> round(float(run["rub1_radius_of_whirl"][-1]), 8)  # that of models.rubbing_rotor
    1.14649039
    """

    x: Any
    y: Any
    gap: Text
    stiffness: Text
    friction: Text | None = None
    radius: Text | None = None
    centre_x: Text = field(default=0.0, kw_only=True)
    centre_y: Text = field(default=0.0, kw_only=True)
    name: str = field(default="", kw_only=True)
    kind: ClassVar[str] = "rub"

    def __post_init__(self) -> None:
        check_name("RubRing", self.name)
        check_coordinates("RubRing", x=self.x, y=self.y)
        given: dict[str, Any] = {"gap": self.gap, "stiffness": self.stiffness}
        given |= {"centre_x": self.centre_x, "centre_y": self.centre_y}
        if self.friction is not None:
            check_text("RubRing", friction=self.friction)
            if self.radius is None:
                raise ModelError(
                    "RubRing: radius: friction acts on the surface of the shaft; with friction="
                    " give its radius there"
                )
        if self.radius is not None:
            given["radius"] = self.radius
        check_text("RubRing", **given)

    def _contribution(self, name: str, place: Attachment) -> Contribution:
        """What the ring adds to the equations of a machine."""
        made = Contribution()
        at_x, at_y = place.plane(name, self, kept=True)
        gap = made.value(
            f"{name}_gap", self.gap, f"radial clearance of {name} [m]",
            "> 0", "a ring without clearance is a bearing",
        )  # fmt: skip
        k = made.value(
            f"{name}_stiffness", self.stiffness, f"stiffness of {name} [N/m]",
            ">= 0", "the ring cannot pull",
        )  # fmt: skip
        _centre(made, name, self, state_name(at_x), state_name(at_y))
        x, y, touch, r = f"{name}_x", f"{name}_y", f"{name}_touch", f"{name}_radius_of_whirl"
        made.outputs[r] = f"sqrt({x}**2 + {y}**2)"
        made.describe[r] = f"distance of the shaft from the centre of {name} [m]"
        made.surfaces[touch] = Surface(
            f"{x}**2 + {y}**2 - {gap}**2",
            below=place.side(name, "free"),
            above=place.side(name, "contact"),
        )
        push = f"{k}*(1 - {gap}/{r})"
        along = {"x": f"-{push}*{x}", "y": f"-{push}*{y}"}
        drag = "0"
        if self.friction is not None:
            drag = self._friction(made, name, place, at_x, at_y)
            along = {
                "x": f"{along['x']} + {drag}*{push}*{y}",
                "y": f"{along['y']} - {drag}*{push}*{x}",
            }
        for axis, coordinate in (("x", at_x), ("y", at_y)):
            force = f"{name}_push_{axis}"
            made.definitions[force] = f"where({touch} > 0, {along[axis]}, 0)"
            made.loads.append((force, place.at({coordinate: 1.0})))
        made.outputs[f"{name}_force"] = f"where({touch} > 0, {k}*({r} - {gap}), 0)"
        made.describe[f"{name}_force"] = f"normal force of {name} [N]"
        if self.friction is not None:
            # on the shaft, positive in the sense of rotation
            made.outputs[f"{name}_friction"] = f"-{drag}*{name}_force"
            made.describe[f"{name}_friction"] = f"friction of {name} on the shaft [N]"
        return made

    def _friction(
        self, made: Contribution, name: str, place: Attachment, at_x: str, at_y: str
    ) -> str:
        """Text of the coefficient of friction with the sign of the slip."""
        made.turns = True
        f = made.value(
            f"{name}_friction_coefficient", self.friction or 0.0,
            f"coefficient of friction of {name}", ">= 0", "friction acts against the slip",
        )  # fmt: skip
        radius = made.value(
            f"{name}_radius", self.radius or 0.0, f"radius of the shaft at {name} [m]",
            "> 0", "the shaft touches with its surface",
        )  # fmt: skip
        x, y, r = f"{name}_x", f"{name}_y", f"{name}_radius_of_whirl"
        slip = f"{name}_slip"
        turning = f"({x}*{velocity_name(at_y)} - {y}*{velocity_name(at_x)})/{r}"
        made.surfaces[slip] = Surface(
            f"Omega*{radius} + {turning}",
            below=place.side(name, "backward_slip"),
            on=place.side(name, "rolling"),
            above=place.side(name, "forward_slip"),
        )
        return f"{f}*sign({slip})"


@dataclass(frozen=True)
class SnubberRing:
    """The preloaded ring without mass of `nonsmooth.models.rotor`, around any part of a shaft.

    Four springs with dampers hold the ring, each with a preload. In contact it stands where its
    elastic energy is least, one gap from the shaft; free of contact it relaxes.

    Parameters
    ----------
    x, y : str
        Coordinates of the shaft at the ring.
    gap : float or str
        Radial clearance.
    stiffness, damping : float or str
        Of each of the four springs and dampers.
    preload_x, preload_y : float or str, optional
        Preload of the springs, as a displacement.
    centre_x, centre_y : float or str, optional
        Centre of the ring.
    name : str, optional
        What parameters, outputs and the states of the ring begin with; ``ring1``, ... by default.

    See Also
    --------
    nonsmooth.models.MatrixRotor : one such ring, with the names of the model `rotor`.

    Notes
    -----
    In contact the machine runs by Taylor series, with steps as short as its fastest natural mode
    requires. Several rings make a mode for each set of rings in contact, and each ring has nine
    cells in each: three rings have 8 modes with 729 cells, which is too many, two have 324.

    Behind some releases with unequal preloads the ring rides on the shaft, as in `models.rotor`. A
    machine with several such rings has no modes for that, and its run ends as ``undecided`` there.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> rotor = ns.Structure(
    ...     np.eye(2), np.eye(2), damping=0.25 * np.eye(2), coordinates=["1x", "1y"]
    ... )
    >>> ring = ns.structures.SnubberRing(
    ...     "1x", "1y", 1.0, 30.0, 0.004, preload_x=0.1, preload_y=0.1, centre_x=-0.9
    ... )
    >>> load = ns.structures.Unbalance("1x", "1y", moment=0.119)
    >>> machine = ns.structures.machine(rotor, [ring], [load], Omega=2.442)
    >>> run = ns.simulate(machine, {"x1": -0.9}, periods=5)
    >>> same = ns.simulate(ns.models.rotor(), periods=5)
    >>> bool(abs(run["ring1_force"] - same["force"]).max() < 1e-10)
    True
    """

    x: Any
    y: Any
    gap: Text
    stiffness: Text
    damping: Text
    preload_x: Text = field(default=0.0, kw_only=True)
    preload_y: Text = field(default=0.0, kw_only=True)
    centre_x: Text = field(default=0.0, kw_only=True)
    centre_y: Text = field(default=0.0, kw_only=True)
    name: str = field(default="", kw_only=True)
    kind: ClassVar[str] = "ring"

    def __post_init__(self) -> None:
        check_name("SnubberRing", self.name)
        check_coordinates("SnubberRing", x=self.x, y=self.y)
        names = ("gap", "stiffness", "damping", "preload_x", "preload_y", "centre_x", "centre_y")
        check_text("SnubberRing", **{name: getattr(self, name) for name in names})

    def _contribution(self, name: str, place: Attachment) -> Contribution:
        """What the ring adds to the equations of a machine."""
        made = Contribution()
        at_x, at_y = place.plane(name, self, kept=True)
        for key, label, require, reason in _SNUBBER:
            made.value(f"{name}_{key}", getattr(self, key), label.format(name), require, reason)
        _centre(made, name, self, state_name(at_x), state_name(at_y))
        riding = place.one_ring and often_rides(self.preload_x, self.preload_y)
        # given names of their own below, as those of the texts
        ring = RingNames("k_s", "c_s", "gamma", "rotor_vx", "rotor_vy")
        words = ring_words(f"{name}_x", f"{name}_y", ring, rides=riding)
        del words["outputs"]["x"], words["outputs"]["y"]
        called = {key: f"{name}_{key}" for key in (*words["definitions"], "sx", "sy", "mu")}
        called |= {key: f"{name}_{new}" for key, new in _RENAMED.items()}
        called |= {"rotor_vx": velocity_name(at_x), "rotor_vy": velocity_name(at_y)}
        pattern = re.compile(r"\b(" + "|".join(called) + r")\b")

        def own(text: Any) -> str:
            return pattern.sub(lambda found: called[found[1]], str(text))

        def owned(texts: Any) -> dict[str, str]:
            return {called[key]: own(text) for key, text in texts.items()}

        made.definitions |= owned(words["definitions"])
        for key, text in words["outputs"].items():
            output = f"{name}_{_OUTPUTS.get(key, key)}"
            made.outputs[output] = own(text)
            made.describe[output] = _LABELS[key].format(name)
        for axis, coordinate in (("x", at_x), ("y", at_y)):
            made.loads.append((called[f"F{axis}"], place.at({coordinate: -1.0})))
        made.ring = RingModes(
            name,
            tuple(called[key] for key in ("sx", "sy", "mu")),
            {
                way: Mode(
                    owned(mode.flow),
                    [
                        replace(
                            each,
                            guard=own(each.guard),
                            reset=owned(each.reset),
                            name=place.side(name, each.name or ""),
                        )
                        for each in mode.exits
                    ],
                    owned(mode.slaved),
                    owned(mode.definitions),
                    mode.cells,
                )
                for way, mode in words["modes"].items()
            },
        )
        for key in ("sx", "sy", "mu"):
            made.describe[called[key]] = _LABELS[key].format(name)
        return made


_SNUBBER = (
    ("gap", "radial clearance of {} [m]", "> 0", "a ring without clearance is a bearing"),
    ("stiffness", "stiffness of a spring of {} [N/m]", "> 0", "the ring is held by springs"),
    (
        "damping", "damping of a damper of {} [N s/m]",
        "> 0", "an undamped ring would never come to rest",
    ),
    *(
        (
            f"preload_{axis}", f"preload in {axis} of {{}} [m]",
            ">= 0", "springs with a negative preload leave the ring loose",
        )
        for axis in ("x", "y")
    ),
)  # fmt: skip
_RENAMED = {
    "x": "x",
    "y": "y",
    "k_s": "stiffness",
    "c_s": "damping",
    "gamma": "gap",
    "delta_x": "preload_x",
    "delta_y": "preload_y",
    "preload_x": "side_x",  # the preload with the sign of the side that the ring is on
    "preload_y": "side_y",
}
_OUTPUTS = {"gap": "distance"}
_LABELS = {
    "sx": "displacement in x of {} [m]",
    "sy": "displacement in y of {} [m]",
    "mu": "multiplier of the contact with {} [N/m]",
    "ring_vx": "velocity in x of {} [m/s]",
    "ring_vy": "velocity in y of {} [m/s]",
    "force_x": "force in x of {} [N]",
    "force_y": "force in y of {} [N]",
    "force": "force of {} [N]",
    "contact_angle": "direction of the contact with {} [rad]",
    "gap": "gap between shaft and {} [m]",
    "energy": "elastic energy of {} [J]",
}


def _centre(made: Contribution, name: str, ring: Any, x: str, y: str) -> None:
    """Displacements of the shaft from the centre of a ring."""
    for axis, state in (("x", x), ("y", y)):
        given = getattr(ring, f"centre_{axis}")
        centre = made.value(f"{name}_centre_{axis}", given, f"centre of {name} in {axis} [m]")
        made.outputs[f"{name}_{axis}"] = f"{state} - {centre}"
        made.describe[f"{name}_{axis}"] = f"displacement from the centre of {name} in {axis} [m]"
