"""Data of a fatigue rig in SI units: from dimensionless parameters and back, and at rest."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from nonsmooth.models.fatigue_contact import GRAVITY

__all__ = ["data_of", "parameters_of"]


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
