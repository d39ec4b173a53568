"""Fracture and fatigue mechanics of a cracked beam, without any time stepping.

Lengths are in mm, loads in N, stress intensities in MPa sqrt(m), frequencies in Hz, times in s.
"""

from __future__ import annotations

from nonsmooth.fatigue.breathing import bilinear_frequency, breathing_frequency_ratio
from nonsmooth.fatigue.comparisons import compare_stiffness_laws, compare_stress_intensity
from nonsmooth.fatigue.crack_curve import CrackCurve
from nonsmooth.fatigue.sensor import Calibration, calibrate
from nonsmooth.fatigue.specimen import Specimen
from nonsmooth.fatigue.stiffness_laws import (
    cubic_stiffness,
    cubic_text,
    guinea_stiffness,
    guinea_text,
)
from nonsmooth.fatigue.tests_of_chapter import aluminium_2024_t351, chapter_tests

__all__ = [
    "Calibration",
    "CrackCurve",
    "Specimen",
    "aluminium_2024_t351",
    "bilinear_frequency",
    "breathing_frequency_ratio",
    "calibrate",
    "chapter_tests",
    "compare_stiffness_laws",
    "compare_stress_intensity",
    "cubic_stiffness",
    "cubic_text",
    "guinea_stiffness",
    "guinea_text",
]
