"""Whether records and their model can be in one unit of time.

Times in ms beside a model in s ask for motions with many oscillations from sample to sample. No
data speak of them, and a fit would spend minutes on them. So the spacing of the samples, and the
time that they last, are put beside the time scales of the model before the fit: the period of what
drives it, and its natural motions in all linear modes and about the start, in the middle and at
both ends of the bounds.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.tables import EXACT
from nonsmooth.fitting.channels import Range
from nonsmooth.fitting.cuts import Cut, GivenRecord
from nonsmooth.fitting.flights import Flights
from nonsmooth.fitting.units import units_of_times
from nonsmooth.runs.labels import labels_of
from nonsmooth.system.model.motions import natural_motions
from nonsmooth.system.system import System

__all__ = ["TimeScales", "said_of_times", "time_scales"]

Floats = npt.NDArray[np.float64]

_TOLERANCE = 1e-12  # of a start
_SHORTEST = -14  # powers of ten, of a period, of the first short motion about a start
_CHANGE = 1e-5  # of a motion: beside it neither rounding nor what is not linear counts
_PART = 0.05  # of the shortest motion: a record that lasts no longer shows hardly any of it


class TimeScales(NamedTuple):
    """How long the fastest and the slowest motion of a model take to repeat, or to die out."""

    shortest: float
    longest: float


def time_scales(
    system: System, free: Mapping[str, Range], state: Floats, begin: float = 0.0
) -> TimeScales | None:
    """Time scales of a model within bounds; None where it has none, as a straight line."""
    found = [each for each in _scales(system, free, state, begin) if np.isfinite(each)]
    return TimeScales(min(found), max(found)) if found else None


def _scales(
    system: System, free: Mapping[str, Range], state: Floats, begin: float
) -> Iterator[float]:
    flights = Flights(system, (), _TOLERANCE)
    for end in ("guess", "low", "high"):
        changed = {name: float(getattr(each, end)) for name, each in free.items()}
        if not flights.set_up(changed):  # a bound may lie on the border of what is allowed
            continue
        if system.is_driven and flights.tables.clock["is_period"]:
            yield flights.window
        for matrix in _rates_by_states(flights, state, begin):
            yield from (
                2.0 * np.pi / abs(each.rate) for each in natural_motions(matrix) if each.rate
            )


def _rates_by_states(flights: Flights, state: Floats, begin: float) -> list[Floats]:
    """Derivatives of the rates by the states: of linear modes, and at a start in another one."""
    tables, n = flights.tables, flights.n
    linear = tables.kinds == EXACT
    found = list(tables.generator[linear, :n, :n])
    for exponent in () if linear.all() else range(_SHORTEST, 0):
        time = 10.0**exponent * flights.window
        flight = flights.fly(state, begin, np.array([begin + time]))
        change = None if flight is None else flight.columns[-1][:, :n] - np.eye(n)
        if change is not None and np.abs(change).max() > _CHANGE:
            return [*found, change / time]
    return found


def said_of_times(
    records: Sequence[GivenRecord],
    datasets: Sequence[Any],
    cuts: Sequence[Cut],
    free: Mapping[str, Range],
    state: Floats,
) -> list[str]:
    """What is said of records whose times are far from those of the model.

    Of a steady motion any phase of the cycle may be sampled by a few samples in each.
    """
    told = []
    for record, data, cut in zip(records, datasets, cuts, strict=True):
        if record.times.size < 2:
            continue
        step, lasts = float(np.median(np.diff(record.times))), float(np.ptp(record.times))
        scales = time_scales(record.system, free, state, float(record.times[0]))
        if scales is None:
            continue
        where = f"record {record.label!r}" if record.label else "record"
        if step > scales.longest and cut.cycle is None:
            told.append(
                f"{where}: its samples are {step:.4g} apart, and no motion of the model within"
                f" free= lasts longer than {scales.longest:.4g}, of its forcing and of its natural"
                f" motions; {_units(record, data)}"
            )
        elif lasts < _PART * scales.shortest:
            told.append(
                f"{where}: it lasts {lasts:.4g}, and the shortest motion of the model within free="
                f" {scales.shortest:.4g}, of its forcing and of its natural motions;"
                f" {_units(record, data)}"
            )
    return told


def _units(record: GivenRecord, data: Any) -> str:
    ours = units_of_times(data)
    theirs = labels_of(record.system).attributes("time").get("units", "")
    if not ours:
        return "give both in one unit of time"
    return (
        f"its times are in {ours}, and those of the model in {theirs or 'a unit that is not told'}:"
        " give both in one unit of time"
    )
