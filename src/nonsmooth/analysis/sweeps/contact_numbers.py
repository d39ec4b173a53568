"""Numbers that tell the contacts of one settled motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.sweeps.panels import Panels, fit_panels
from nonsmooth.analysis.sweeps.settled import SweptMotion
from nonsmooth.analysis.sweeps.visits import visits_of

__all__ = ["Asked", "contact_numbers"]

Floats = npt.NDArray[np.float64]

_PER_PERIOD = 8  # panels to begin with


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
