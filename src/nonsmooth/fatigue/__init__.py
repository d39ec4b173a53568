"""Fatigue without time stepping: cycles of a load, laws of crack growth, lives.

Lengths are in mm, loads in N, stress intensities in MPa sqrt(m), times in s.
"""

from __future__ import annotations

from nonsmooth.fatigue.closure import NewmanClosure, effective_range
from nonsmooth.fatigue.compared_lives import compare_lives
from nonsmooth.fatigue.cycles import count_cycles
from nonsmooth.fatigue.fitted_law import FittedLaw, fit_law
from nonsmooth.fatigue.growth_by_frequency import growth_by_frequency
from nonsmooth.fatigue.growth_laws import Forman, Paris, Walker
from nonsmooth.fatigue.life import life
from nonsmooth.fatigue.life_by_cycle import life_by_cycle
from nonsmooth.fatigue.life_ratio import life_ratio
from nonsmooth.fatigue.load_block import LoadBlock
from nonsmooth.fatigue.load_table import LoadTable
from nonsmooth.fatigue.published_laws import published_laws
from nonsmooth.fatigue.reversals import reversals

__all__ = [
    "FittedLaw",
    "Forman",
    "LoadBlock",
    "LoadTable",
    "NewmanClosure",
    "Paris",
    "Walker",
    "compare_lives",
    "count_cycles",
    "effective_range",
    "fit_law",
    "growth_by_frequency",
    "life",
    "life_by_cycle",
    "life_ratio",
    "published_laws",
    "reversals",
]
