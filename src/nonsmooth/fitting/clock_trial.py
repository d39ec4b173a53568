"""Whether another phase of the forcing would explain a record that a fit does not.

The clock of a record begins when somebody starts the recorder. A fit takes the forcing to have the
phase that the equations say, and without ``shift=`` a record of another phase makes it fail, or
explain next to nothing. Then the phases of a period are tried: those at which single segments fit
best, each in a fit with the shift of the clock free about it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from nonsmooth.fitting.channels import Range
from nonsmooth.fitting.cuts import GivenRecord
from nonsmooth.fitting.gain_trial import MOST, explains
from nonsmooth.fitting.report import Search
from nonsmooth.fitting.shooting import Shooting
from nonsmooth.fitting.solver import misfit_of_start

__all__ = ["explaining_shift", "said_of_shift"]

Floats = npt.NDArray[np.float64]

_PHASES = 12  # of a period that are looked at
_TRIED = 3  # of them in a fit of their own


def explaining_shift(
    records: Sequence[GivenRecord],
    failed: Search,
    initial: Floats,
    begin: Callable[[Range], Shooting],
    search: Callable[[Range], Search],
) -> tuple[float, float] | None:
    """Bounds of a shift of the clock, in s, with which a fit explains its records.

    None where no shift does, or where nothing with a period drives the model. ``begin`` makes the
    equations for a shift, and ``search`` looks for their minimum from one start.
    """
    periods = [
        float(each.system.period_value)
        for each in records
        if each.system.is_driven and each.system.period_value is not None
    ]
    if len(periods) < len(records):
        return None
    period = max(periods)
    noise = np.array([channel.noise.guess for channel in failed.shooting.channels])
    looked = []
    for k in range(1, _PHASES):
        value = period * (k / _PHASES - 0.5)
        misfit = misfit_of_start(begin(Range(value, value, value)), initial, noise, 0)
        looked.append((misfit, value))
    for misfit, value in sorted(looked)[:_TRIED]:
        if not np.isfinite(misfit):
            break
        ends = value - period / _PHASES, value + period / _PHASES
        found = search(Range(*ends, value))
        if found.best.closed and explains(found, MOST):
            return ends
    return None


def said_of_shift(ends: tuple[float, float] | None) -> str:
    """What a shift that explains a record says, in words; empty without any."""
    if ends is None:
        return ""
    return (
        "another phase of the forcing would explain the record, whose clock need not begin with"
        f" it: give shift=({ends[0]:.4g}, {ends[1]:.4g})"
    )
