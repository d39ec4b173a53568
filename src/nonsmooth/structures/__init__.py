"""Linear structures of any size, such as finite-element shafts and frames, by their matrices.

Matrices in, datasets out: natural modes, Campbell diagrams, responses. `machine` makes of a
structure, of contacts and of loads a system for all other functions; `reduce` makes it small.
"""

from __future__ import annotations

from nonsmooth.structures.assembly import assemble, plane_beam, shaft, torsional_shaft
from nonsmooth.structures.beam import Beam, Disc, RectangularBeam
from nonsmooth.structures.bearing import Bearing
from nonsmooth.structures.contacts import DryFriction, GapSpring, Stop
from nonsmooth.structures.critical_speeds import campbell
from nonsmooth.structures.loads import BaseMotion, Force, Unbalance, Weight
from nonsmooth.structures.locus import root_locus
from nonsmooth.structures.machine import machine
from nonsmooth.structures.modes import natural_modes
from nonsmooth.structures.reduced_structure import ReducedStructure
from nonsmooth.structures.reduction import reduce
from nonsmooth.structures.response import frequency_response, static_deflection
from nonsmooth.structures.rings import RubRing, SnubberRing
from nonsmooth.structures.structure import Structure
from nonsmooth.structures.unbalance import unbalance_response

__all__ = [
    "BaseMotion",
    "Beam",
    "Bearing",
    "Disc",
    "DryFriction",
    "Force",
    "GapSpring",
    "RectangularBeam",
    "ReducedStructure",
    "RubRing",
    "SnubberRing",
    "Stop",
    "Structure",
    "Unbalance",
    "Weight",
    "assemble",
    "campbell",
    "frequency_response",
    "machine",
    "natural_modes",
    "plane_beam",
    "reduce",
    "root_locus",
    "shaft",
    "static_deflection",
    "torsional_shaft",
    "unbalance_response",
]


def __dir__() -> list[str]:
    return sorted(__all__)
