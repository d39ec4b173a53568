"""Measured motions of a forced machine with one mark per revolution, shaped like computed ones.

Displacements and marks in, the datasets of `simulate`, `stroboscopic_map` and
`bifurcation_diagram` out, so that pictures and analyses take them.
"""

from __future__ import annotations

from nonsmooth.measured.channel import Channel
from nonsmooth.measured.columns import read_columns
from nonsmooth.measured.differentiator import Differentiator
from nonsmooth.measured.integration import displacements
from nonsmooth.measured.monitoring.alarms import alarm
from nonsmooth.measured.monitoring.roc import roc
from nonsmooth.measured.monitoring.windows import indicators
from nonsmooth.measured.quality.checking import check, flagged
from nonsmooth.measured.reading import read_csv
from nonsmooth.measured.record import from_arrays
from nonsmooth.measured.resampling import synchronous
from nonsmooth.measured.scaling import dimensionless
from nonsmooth.measured.sections import section
from nonsmooth.measured.smoothing import low_pass
from nonsmooth.measured.speed_diagram import diagram
from nonsmooth.measured.velocity import velocities

__all__ = [
    "Channel",
    "Differentiator",
    "alarm",
    "check",
    "diagram",
    "dimensionless",
    "displacements",
    "flagged",
    "from_arrays",
    "indicators",
    "low_pass",
    "read_columns",
    "read_csv",
    "roc",
    "section",
    "synchronous",
    "velocities",
]


def __dir__() -> list[str]:
    return sorted(__all__)
