"""Data of a fatigue rig in SI units: from dimensionless parameters and back, and at rest."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from nonsmooth.errors import ModelError
from nonsmooth.models.fatigue_contact import GRAVITY

__all__ = ["check_at_rest", "data_of", "parameters_of"]


# parameters that each datum of a rig depends on, beside the mass, leaf springs and base amplitude
_NEEDS = {
    "contact_stiffness": ("eps",),
    "specimen_stiffness": ("theta",),
    "open_stiffness": ("theta", "open_stiffness"),
    "cylinder_stiffness_1": ("lambda1",),
    "cylinder_stiffness_2": ("lambda2",),
    "leaf_damping": ("xi_Ls",),
    "specimen_damping": ("theta", "xi_s"),
    "cylinder_damping_1": ("lambda1", "xi_p1"),
    "cylinder_damping_2": ("lambda2", "xi_p2"),
    "cylinder_force_1": ("f1",),
    "cylinder_force_2": ("f2",),
    "frequency": ("eta",),
}


def parameters_of(rig: Any) -> dict[str, float]:
    """Dimensionless parameters of a rig."""
    rate = math.sqrt(rig.leaf_stiffness / rig.mass)
    critical = 2.0 * rig.mass * rate
    force = 1e-3 * rig.leaf_stiffness * rig.base_amplitude
    weight = rig.mass * GRAVITY
    k = rig.leaf_stiffness
    theta = math.sqrt(rig.specimen_stiffness / k)
    lambdas = [math.sqrt(each / k) for each in (rig.cylinder_stiffness_1, rig.cylinder_stiffness_2)]
    dampings = (rig.cylinder_damping_1, rig.cylinder_damping_2)
    # a cylinder without stiffness has no damping ratio
    ratios = [c / (critical * x) if x else 0.0 for c, x in zip(dampings, lambdas, strict=True)]
    found = {
        "eta": 2.0 * math.pi * rig.frequency / rate,
        "lambda1": lambdas[0],
        "lambda2": lambdas[1],
        "theta": theta,
        "eps": k / rig.contact_stiffness,
        "f1": (rig.cylinder_force_1 + weight) / force,
        "f2": (rig.cylinder_force_2 - weight) / force,
        "xi_Ls": rig.leaf_damping / critical,
        "xi_s": rig.specimen_damping / (critical * theta),
        "xi_p1": ratios[0],
        "xi_p2": ratios[1],
    }
    if rig.open_stiffness is not None:
        found["open_stiffness"] = rig.open_stiffness / rig.specimen_stiffness
    return found


def data_of(
    p: Mapping[str, float], mass: float, leaf_stiffness: float, base_amplitude: float
) -> dict[str, float]:
    """Data of the rig that has these parameters; what needs a missing one is left out."""
    rate = math.sqrt(leaf_stiffness / mass)
    critical = 2.0 * mass * rate
    force, weight = 1e-3 * leaf_stiffness * base_amplitude, mass * GRAVITY
    rules = {
        "contact_stiffness": lambda: leaf_stiffness / p["eps"],
        "specimen_stiffness": lambda: leaf_stiffness * p["theta"] ** 2,
        "open_stiffness": lambda: leaf_stiffness * p["theta"] ** 2 * p["open_stiffness"],
        "cylinder_stiffness_1": lambda: leaf_stiffness * p["lambda1"] ** 2,
        "cylinder_stiffness_2": lambda: leaf_stiffness * p["lambda2"] ** 2,
        "leaf_damping": lambda: critical * p["xi_Ls"],
        "specimen_damping": lambda: critical * p["theta"] * p["xi_s"],
        "cylinder_damping_1": lambda: critical * p["lambda1"] * p["xi_p1"],
        "cylinder_damping_2": lambda: critical * p["lambda2"] * p["xi_p2"],
        "cylinder_force_1": lambda: force * p["f1"] - weight,
        "cylinder_force_2": lambda: force * p["f2"] + weight,
        "frequency": lambda: p["eta"] * rate / (2.0 * math.pi),
    }
    scales = {
        "mass": mass,
        "leaf_stiffness": leaf_stiffness,
        "base_amplitude": base_amplitude,
    }
    known = {name: rule() for name, rule in rules.items() if all(n in p for n in _NEEDS[name])}
    return scales | known


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
