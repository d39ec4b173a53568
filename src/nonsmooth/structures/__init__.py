"""Linear structures of any size, such as finite-element shafts and frames, by their matrices.

Matrices in, datasets out: natural modes, Campbell diagrams, responses. Nothing here is non-smooth.
"""

from __future__ import annotations

from nonsmooth.structures.bearing import Bearing
from nonsmooth.structures.structure import Structure

__all__ = [
    "Bearing",
    "Structure",
]
