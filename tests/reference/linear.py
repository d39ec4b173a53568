"""Truth for linear and piecewise-linear systems: what the tests import."""

from .crossing import Crossing, first_crossing
from .flow import exact_flow
from .hybrid import HybridEvent, HybridRun, LinearExit, LinearMode, hybrid_run

__all__ = [
    "Crossing",
    "HybridEvent",
    "HybridRun",
    "LinearExit",
    "LinearMode",
    "exact_flow",
    "first_crossing",
    "hybrid_run",
]
