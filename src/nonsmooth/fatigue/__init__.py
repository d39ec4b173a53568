"""Fracture and fatigue mechanics of a cracked beam, cycles and lives, without any time stepping.

Lengths are in mm, loads in N, stress intensities in MPa sqrt(m), frequencies in Hz, times in s.
"""

from __future__ import annotations

from nonsmooth.fatigue.breathing import bilinear_frequency, breathing_frequency_ratio
from nonsmooth.fatigue.closure import NewmanClosure, effective_range
from nonsmooth.fatigue.compared_lives import compare_lives
from nonsmooth.fatigue.comparisons import compare_stiffness_laws, compare_stress_intensity
from nonsmooth.fatigue.crack_curve import CrackCurve
from nonsmooth.fatigue.cycles import count_cycles, reversals
from nonsmooth.fatigue.fitted_law import FittedLaw, fit_law
from nonsmooth.fatigue.growth_by_frequency import growth_by_frequency
from nonsmooth.fatigue.growth_laws import Forman, Paris, Walker
from nonsmooth.fatigue.life import life
from nonsmooth.fatigue.life_by_cycle import life_by_cycle
from nonsmooth.fatigue.life_ratio import life_ratio
from nonsmooth.fatigue.load_block import LoadBlock
from nonsmooth.fatigue.load_table import LoadTable
from nonsmooth.fatigue.published_laws import published_laws
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
    "FittedLaw",
    "Forman",
    "LoadBlock",
    "LoadTable",
    "NewmanClosure",
    "Paris",
    "Specimen",
    "Walker",
    "aluminium_2024_t351",
    "bilinear_frequency",
    "breathing_frequency_ratio",
    "calibrate",
    "chapter_tests",
    "compare_lives",
    "compare_stiffness_laws",
    "compare_stress_intensity",
    "count_cycles",
    "cubic_stiffness",
    "cubic_text",
    "effective_range",
    "fit_law",
    "growth_by_frequency",
    "guinea_stiffness",
    "guinea_text",
    "life",
    "life_by_cycle",
    "life_ratio",
    "published_laws",
    "reversals",
]


def __dir__() -> list[str]:
    return sorted(__all__)
