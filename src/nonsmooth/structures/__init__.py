"""Linear structures of any size, such as finite-element shafts and frames, by their matrices.

Matrices in, datasets out: natural modes, Campbell diagrams, responses. Nothing here is non-smooth.
"""

from __future__ import annotations

from nonsmooth.structures.assembly import shaft
from nonsmooth.structures.beam import Beam, Disc
from nonsmooth.structures.bearing import Bearing
from nonsmooth.structures.critical_speeds import campbell
from nonsmooth.structures.locus import root_locus
from nonsmooth.structures.modes import natural_modes
from nonsmooth.structures.response import frequency_response, static_deflection
from nonsmooth.structures.structure import Structure
from nonsmooth.structures.unbalance import unbalance_response

__all__ = [
    "Beam",
    "Bearing",
    "Disc",
    "Structure",
    "campbell",
    "frequency_response",
    "natural_modes",
    "root_locus",
    "shaft",
    "static_deflection",
    "unbalance_response",
]
