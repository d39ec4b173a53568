"""Fracture and fatigue mechanics of a cracked beam, without any time stepping.

Lengths are in mm, loads in N, stress intensities in MPa sqrt(m), frequencies in Hz, times in s.
"""

from __future__ import annotations

from nonsmooth.fatigue.specimen import Specimen
from nonsmooth.fatigue.stiffness_laws import (
    cubic_stiffness,
    cubic_text,
    guinea_stiffness,
    guinea_text,
)

__all__ = [
    "Specimen",
    "cubic_stiffness",
    "cubic_text",
    "guinea_stiffness",
    "guinea_text",
]
