"""Marks of a record: those given or told from a pulse, with what is to be known of them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.errors import OptionError
from nonsmooth.measured.clock import Clock, numbers
from nonsmooth.measured.gaps import check_finite
from nonsmooth.measured.marks import check_marks, find_edges, given_marks
from nonsmooth.measured.places import Places
from nonsmooth.measured.speeds import speed_attributes

__all__ = ["Marking", "check_marked", "marks_of"]

Floats = npt.NDArray[np.float64]


class Marking(NamedTuple):
    """What the caller says of marks; neither ``marks`` nor ``pulse`` where there are none."""

    marks: Any = None
    pulse: Any = None
    threshold: Any = None
    hysteresis: Any = None
    edge: Any = "rising"
    bad_marks: Any = "refuse"


def marks_of(given: Marking, clock: Clock, places: Places) -> tuple[Floats, dict[str, Any]] | None:
    """Marks within a record and the attributes they give it; None without any."""
    start, step, first, last = clock.start, clock.step, clock.first, clock.last
    if given.marks is not None and given.pulse is not None:
        raise OptionError("give the marks of revolutions by either marks= or pulse=")
    if given.marks is not None:
        found, error = given_marks(given.marks), 0.0
        found = found[(found >= start) & (found <= start + (last - first - 1) * step)]
    elif given.pulse is not None:
        signal = numbers(places.pulse, given.pulse)
        if signal.size < last:
            raise OptionError(
                f"{places.pulse}: {signal.size} samples came, and displacements have more"
            )
        signal = signal[first:last]
        check_finite({places.pulse: signal}, start, step, first, places)
        edges = find_edges(signal, given.threshold, given.hysteresis, given.edge)
        found, error = start + step * edges.places, step * edges.error
    else:
        _check_unused(given)
        return None
    kept, repaired = check_marks(found, given.bad_marks)
    return kept, {**speed_attributes(kept), "mark_error": error, "n_repaired": repaired}


def check_marked(record: xr.Dataset, what: str) -> None:
    """Refuse a record without marks where they are needed, and say how to give them."""
    if "mark_time" not in record.coords:
        raise OptionError(
            f"the record has no marks of revolutions, and {what} needs them; read it with mark=,"
            " the column of a pulse per revolution (pulse= in from_arrays), or with marks=, their"
            " times, such as multiples of the period of the forcing"
        )


def _check_unused(given: Marking) -> None:
    """Refuse options about marks that are not there: they would be passed over in silence."""
    for name, default in Marking._field_defaults.items():
        if getattr(given, name) != default:
            raise OptionError(
                f"{name}= is about marks of revolutions, and none came; give the column mark= of a"
                " file, the signal pulse= of arrays, or the times marks= of either"
            )
