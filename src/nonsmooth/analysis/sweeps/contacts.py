"""Contacts of settled motions: visits to modes, numbers that tell them, and a dataset of these."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.sweeps.panels import Panels, fit_panels
from nonsmooth.analysis.sweeps.settled import SweptMotion
from nonsmooth.analysis.sweeps.sweep import (
    SweepProtocol,
    Swept,
    motion_periods,
    parameter_coordinate,
    stacked,
    statuses,
    sweep_attributes,
)
from nonsmooth.runs.labels import labels_of

__all__ = [
    "Asked",
    "ModeVisits",
    "contact_dataset",
    "contact_numbers",
    "visits_of",
]

Floats = npt.NDArray[np.float64]

_PER_PERIOD = 8  # panels to begin with
_TEXTS = {
    "mean": "mean of the {}",
    "rms": "root mean square of the {}",
    "in_contact": "mean of the {} in contact",
    "min": "least {}",
    "min_error": "error of the least {}",
    "max": "largest {}",
    "max_error": "error of the largest {}",
    "percentile": "{} not exceeded for a part of the time",
}


@dataclass(frozen=True)
class Asked:
    """What is to be found out."""

    contact: tuple[str, ...]
    modes: tuple[int, ...]  # that count as contact
    variables: tuple[str, ...]
    percentiles: Floats

    @property
    def options(self) -> dict[str, Any]:
        """What of it stands in a result."""
        return {"contact": " ".join(self.contact), "of": " ".join(self.variables)} | {
            "percentiles": str(self.percentiles.tolist())
        }


def contact_numbers(settled: SweptMotion, asked: Asked) -> dict[str, npt.NDArray[Any]]:
    """Counts, durations and statistics by the names that they have in a dataset."""
    duration = settled.duration
    at_first = settled.samples(np.zeros(1)).modes[0] in asked.modes
    events = settled.events
    inside = np.isin(events.after.modes, asked.modes)
    visits = visits_of(events.since, inside, bool(at_first), 0.0, duration)
    periods = duration / settled.period
    lasting = visits.durations
    numbers = {
        "contacts": np.count_nonzero(visits.begins_inside) / periods,
        "contact_share": float((visits.end - visits.begin).sum()) / duration,
        "contact_duration": lasting.mean() if lasting.size else np.nan,
        "shortest_contact": lasting.min(initial=np.inf) if lasting.size else np.nan,
        "longest_contact": lasting.max(initial=0.0) if lasting.size else np.nan,
    }
    found: dict[str, npt.NDArray[Any]] = {key: np.array(one) for key, one in numbers.items()}
    breaks = np.linspace(0.0, duration, max(1, round(_PER_PERIOD * periods)) + 1)
    breaks = np.unique(np.concatenate([breaks, np.clip(events.since, 0.0, duration)]))
    for name in asked.variables:
        panels = fit_panels(_values_of(settled, name), breaks, duration)
        found |= _statistics(name, panels, asked.percentiles, visits.begin, visits.end)
    return found


def _values_of(settled: SweptMotion, name: str) -> Any:
    def evaluate(since: Floats) -> Floats:
        return settled.values(name, settled.samples(since))

    return evaluate


def _statistics(
    name: str, panels: Panels, parts: Floats, begin: Floats, end: Floats
) -> dict[str, npt.NDArray[Any]]:
    """Statistics of one variable; contacts begin and end at edges of panels."""
    duration = float(panels.widths.sum())
    middle = panels.edges.mean(axis=1)
    place = np.searchsorted(begin, middle, side="right") - 1
    touching = (place >= 0) & (middle < end[np.maximum(place, 0)]) if begin.size else place >= 0
    contact = panels.take(touching)
    lasts = float(contact.widths.sum())
    (high, high_error), (low, low_error) = panels.highest(), panels.lowest()
    numbers = {
        "mean": panels.integral() / duration,
        "rms": np.sqrt(panels.integral_of_square() / duration),
        "in_contact": contact.integral() / lasts if lasts > 0.0 else np.nan,
        "min": low,
        "min_error": low_error,
        "max": high,
        "max_error": high_error,
        "percentile": panels.percentiles(parts),
    }
    return {f"{name}_{key}": np.asarray(value) for key, value in numbers.items()}


class ModeVisits(NamedTuple):
    """Visits in order; the first may have begun before the record, the last end after it."""

    begin: Floats
    end: Floats
    begins_inside: npt.NDArray[np.bool_]
    ends_inside: npt.NDArray[np.bool_]

    @property
    def durations(self) -> Floats:
        """Those of the visits that lie in the record as a whole."""
        whole = self.begins_inside & self.ends_inside
        return (self.end - self.begin)[whole]


def visits_of(
    times: Floats,
    inside: npt.NDArray[np.bool_],
    at_first: bool,
    first: float,
    last: float,
) -> ModeVisits:
    """Visits from changes: ``inside`` says where the motion is after each of the ``times``.

    Changes between two modes that are both meant do not end a visit.
    """
    before = np.concatenate([[at_first], inside])[:-1] if inside.size else inside
    enters, leaves = times[inside & ~before], times[before & ~inside]
    begins = np.concatenate([[first], enters]) if at_first else enters
    at_last = bool(inside[-1]) if inside.size else at_first
    ends = np.concatenate([leaves, [last]]) if at_last else leaves
    begins_inside, ends_inside = (np.ones(begins.size, bool) for _ in range(2))
    if at_first:
        begins_inside[0] = False
    if at_last:
        ends_inside[-1] = False
    return ModeVisits(begins, ends, begins_inside, ends_inside)


def contact_dataset(sweep: SweepProtocol, parameter: str, swept: Swept, asked: Asked) -> xr.Dataset:
    """Dataset of what was found at each value."""
    labels = labels_of(sweep.system)
    time = {key: text for key, text in labels.attributes("time").items() if key == "units"}
    texts: dict[str, dict[str, str]] = {
        "contacts": {"long_name": "contacts per period"},
        "contact_share": {"long_name": "part of the time in contact"},
        "contact_duration": {"long_name": "mean duration of a contact"} | time,
        "shortest_contact": {"long_name": "shortest contact"} | time,
        "longest_contact": {"long_name": "longest contact"} | time,
    }
    for name in asked.variables:
        own = labels.attributes(name)
        for key, text in _TEXTS.items():
            texts[f"{name}_{key}"] = own | {"long_name": text.format(own["long_name"])}
    variables: dict[str, Any] = {}
    for name, attributes in texts.items():
        over = name.endswith("_percentile")
        dims = ("parameter", "percentile") if over else ("parameter",)
        shape = asked.percentiles.shape if over else ()
        variables[name] = (dims, stacked(swept.found, name, shape), attributes)
    variables["motion_period"] = motion_periods(swept.found)
    variables["status"] = statuses(swept.found)
    coords = {
        "parameter": parameter_coordinate(sweep.system, parameter, swept.values),
        "percentile": (("percentile",), asked.percentiles, {"long_name": "part of the time in %"}),
    }
    options = {"parameter": parameter} | sweep.options | asked.options
    attributes = sweep_attributes(sweep, swept, options)
    return xr.Dataset(variables, coords, attributes)
