"""Ready-made systems, each a function with defaults for everything, and what they are used for."""

from __future__ import annotations

from nonsmooth.arguments import checked as _checked
from nonsmooth.errors import ModelError as _ModelError
from nonsmooth.models.belt_oscillator import belt_oscillator
from nonsmooth.models.bouncing_ball import bouncing_ball
from nonsmooth.models.brake_mode_coupling import brake_mode_coupling
from nonsmooth.models.breathing_crack import breathing_crack
from nonsmooth.models.chua import chua
from nonsmooth.models.clearance_rotor import clearance_rotor
from nonsmooth.models.drift_reconstruction import drift_reconstruction
from nonsmooth.models.duffing import duffing
from nonsmooth.models.fatigue_contact import check_contact
from nonsmooth.models.fatigue_preload import least_preload
from nonsmooth.models.fatigue_reduction import OneMass, one_mass, reduction_error
from nonsmooth.models.fatigue_rig import fatigue_rig
from nonsmooth.models.fatigue_rig_si import FatigueRig
from nonsmooth.models.four_phase_orbit import four_phase_misfit, four_phase_orbit
from nonsmooth.models.friction_oscillator import friction_oscillator
from nonsmooth.models.gear_pair import gear_pair
from nonsmooth.models.impact_oscillator import impact_oscillator
from nonsmooth.models.load_setting import set_load
from nonsmooth.models.massive_ring_rotor import massive_ring_rotor
from nonsmooth.models.matrix_rotor import MatrixRotor
from nonsmooth.models.metal_cutting import metal_cutting
from nonsmooth.models.moling import moling
from nonsmooth.models.moling_phases import moling_solution
from nonsmooth.models.moling_si import MolingRig
from nonsmooth.models.percussive_drilling import percussive_drilling
from nonsmooth.models.print_hammer import print_hammer
from nonsmooth.models.progression import progression
from nonsmooth.models.progression_start import progression_start
from nonsmooth.models.rotor import rotor
from nonsmooth.models.rotor_si import RotorRig
from nonsmooth.models.rubbing_rotor import rubbing_rotor
from nonsmooth.models.snubber_boundaries import snubber_boundaries
from nonsmooth.models.snubber_ring import snubber_ring
from nonsmooth.models.snubber_rub import snubber_rub
from nonsmooth.models.soft_impact import soft_impact
from nonsmooth.models.static_contact import static_contact
from nonsmooth.models.trilinear import trilinear

__all__ = [
    "FatigueRig",
    "MatrixRotor",
    "MolingRig",
    "OneMass",
    "RotorRig",
    "belt_oscillator",
    "bouncing_ball",
    "brake_mode_coupling",
    "breathing_crack",
    "check_contact",
    "chua",
    "clearance_rotor",
    "drift_reconstruction",
    "duffing",
    "fatigue_rig",
    "four_phase_misfit",
    "four_phase_orbit",
    "friction_oscillator",
    "gear_pair",
    "impact_oscillator",
    "least_preload",
    "massive_ring_rotor",
    "metal_cutting",
    "moling",
    "moling_solution",
    "one_mass",
    "percussive_drilling",
    "print_hammer",
    "progression",
    "progression_start",
    "reduction_error",
    "rotor",
    "rubbing_rotor",
    "set_load",
    "snubber_boundaries",
    "snubber_ring",
    "snubber_rub",
    "soft_impact",
    "static_contact",
    "trilinear",
]

# once for all of them, and not in each file
for _name in __all__:
    _made = globals()[_name]
    if isinstance(_made, type):
        # setattr: an assignment to __init__ of a class is an error for type checkers
        setattr(_made, "__init__", _checked(vars(_made)["__init__"], _ModelError))  # noqa: B010
    else:
        _makes_a_system = _made.__annotations__["return"] == "System"
        globals()[_name] = _checked(_made, _ModelError) if _makes_a_system else _checked(_made)
        globals()[_name].__module__ = __name__  # where pickle finds it


def __dir__() -> list[str]:
    return sorted(__all__)
