"""Whether the cylinders of a fatigue rig press both masses onto the specimen at rest, in N."""

from __future__ import annotations

from typing import Any

from nonsmooth.errors import ModelError
from nonsmooth.models.fatigue_contact import GRAVITY

__all__ = ["check_at_rest"]


def check_at_rest(rig: Any) -> None:
    """Raise a ModelError that names the cylinder which lets its mass off, and its least force.

    With F the forces on the masses, weights included, the specimen bends by (F1 - F2)/(D k_Ls), and
    this share of the other force is what it puts on a mass: contact 1 has F1 - (F1 - F2)/D.
    """
    weight = rig.mass * GRAVITY
    closed, opened = (
        _leverage(rig, stiffness)
        for stiffness in (rig.specimen_stiffness, rig.open_stiffness or rig.specimen_stiffness)
    )
    one, two = rig.cylinder_force_1 + weight, rig.cylinder_force_2 - weight
    bent = (one - two) / ((opened if one > two else closed) + 1.0)
    if one > bent and two > -bent:
        return
    if one <= bent:
        # where mass 2 hangs on the specimen too, it is the one that asks for more
        number, least = 1, (-two / closed if two > 0.0 else -two * opened) - weight
    else:
        number, least = 2, -one / opened + weight
    other = 3 - number
    forces = {1: rig.cylinder_force_1, 2: rig.cylinder_force_2}
    raise ModelError(
        f"cylinder_force_{number} = {forces[number]:.6g} N does not press mass {number} on the"
        f" specimen at rest: beside cylinder_force_{other} = {forces[other]:.6g} N and weights of"
        f" {weight:.4g} N it must be more than {least:.6g} N; raise it"
    )


def _leverage(rig: Any, stiffness: float) -> float:
    """D - 1 with D = 2 + theta^2 (1 + eps)."""
    ratio = stiffness / rig.leaf_stiffness
    return float(1.0 + ratio * (1.0 + rig.leaf_stiffness / rig.contact_stiffness))
