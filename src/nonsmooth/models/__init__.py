"""Ready-made systems, each a function with defaults for everything, and what they are used for."""

from __future__ import annotations

from nonsmooth.models.breathing_crack import breathing_crack
from nonsmooth.models.chua import chua
from nonsmooth.models.clearance_rotor import clearance_rotor
from nonsmooth.models.drift_reconstruction import drift_reconstruction
from nonsmooth.models.duffing import duffing
from nonsmooth.models.fatigue_rig import fatigue_rig
from nonsmooth.models.gear_pair import gear_pair
from nonsmooth.models.massive_ring_rotor import massive_ring_rotor
from nonsmooth.models.matrix_rotor import MatrixRotor
from nonsmooth.models.moling import moling
from nonsmooth.models.moling_si import MolingRig
from nonsmooth.models.percussive_drilling import percussive_drilling
from nonsmooth.models.progression import progression
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
    "MatrixRotor",
    "MolingRig",
    "RotorRig",
    "breathing_crack",
    "chua",
    "clearance_rotor",
    "drift_reconstruction",
    "duffing",
    "fatigue_rig",
    "gear_pair",
    "massive_ring_rotor",
    "moling",
    "percussive_drilling",
    "progression",
    "rotor",
    "rubbing_rotor",
    "snubber_boundaries",
    "snubber_ring",
    "snubber_rub",
    "soft_impact",
    "static_contact",
    "trilinear",
]
