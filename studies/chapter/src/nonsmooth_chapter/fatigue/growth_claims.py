"""Claims on the growth curve of Figs. 29 and 30: where it is when, and how it grows."""

from __future__ import annotations

import numpy as np

from nonsmooth_chapter.fatigue.beam_data import (
    GROWTH,
    NOTCH,
    RATE,
    TAU_END,
    crack_at,
    tau_at,
)
from nonsmooth_chapter.fatigue.onset import onset_along_growth
from nonsmooth_chapter.judgement import Check, Evidence, Finding, agrees

__all__ = ["CHECKS"]

_LONG = 0.5  # of the record: more than that is a long time
_LINEAR = 0.05  # of the growth of a stretch: a line that is closer describes it


def _reached(printed: str = "10.7", tau: float = 900_514.0) -> Evidence:
    then = tau_at(float(printed))
    return {"tau": tau, "crack": crack_at(tau), "printed": printed, "tau_of_printed": then}


def _judge_reached(evidence: Evidence) -> Finding:
    true = agrees(evidence["crack"], evidence["printed"])
    return Finding(true, f"a({evidence['tau']:.0f}) = {evidence['crack']:.4f} mm; "
                   f"{evidence['printed']} mm at tau {evidence['tau_of_printed']:.0f}")  # fmt: skip


def _passed(crack: float = 12.0, about: float = 0.02, before: float = 915_662.0) -> Evidence:
    return {
        "tau": [tau_at(crack * (1.0 + side * about)) for side in (-1, 0, 1)],
        "crack": crack,
        "before": before,
        "crack_then": crack_at(before),
    }


def _judge_passed(evidence: Evidence) -> Finding:
    low, middle, high = evidence["tau"]
    return Finding(
        high < evidence["before"],
        f"{evidence['crack']:g} mm at tau {middle:.0f} ({low:.0f} to {high:.0f} for 2 % less or"
        f" more); a({evidence['before']:.0f}) = {evidence['crack_then']:.3f} mm",
    )


def _waiting(end: float = TAU_END, share: float = 0.01) -> Evidence:
    """Share of the record before the crack has grown by 1 %, of its length and of its growth."""
    total = crack_at(end) - NOTCH
    return {
        "end": end,
        "of_length": tau_at(NOTCH * (1.0 + share)) / end,
        "of_growth": tau_at(NOTCH + share * total) / end,
        "times_e": end / RATE,
    }


def _judge_waiting(evidence: Evidence) -> Finding:
    shares = (evidence["of_length"], evidence["of_growth"])
    return Finding(
        min(shares) > _LONG,
        f"1 % of the length at {shares[0]:.1%} of the record, 1 % of the final growth at"
        f" {shares[1]:.1%}; the law has no threshold: over {evidence['times_e']:.1f} times its"
        " time constant every exponential looks so",
    )


def _growth_law(end: float = TAU_END, columns: int = 120) -> Evidence:
    """Departure from a line up to every possible critical size, and the onset of chaos."""
    rows = []
    for crack in np.geomspace(1e-3, crack_at(end) - NOTCH, columns) + NOTCH:
        rows.append({"crack": float(crack), "departure": _departure(0.0, tau_at(float(crack)))})
    onset = onset_along_growth()
    last = None if onset["crack"] is None else tau_at(onset["crack"])
    return {
        "rows": rows,
        "onset": onset,
        "before": None if last is None else _departure(0.0, last),
        "share_of_time": None if last is None else last / end,
    }


def _departure(begin: float, end: float, points: int = 2000) -> float:
    """Largest distance from the best line, beside the growth of the stretch."""
    tau = np.linspace(begin, end, points)
    growth = np.exp(tau / RATE - end / RATE)  # the scale does not matter
    line = np.polyval(np.polyfit(tau, growth, 1), tau)
    return float(np.abs(growth - line).max() / np.ptp(growth))


def _judge_growth_law(evidence: Evidence) -> Finding:
    least = min(evidence["rows"], key=lambda row: row["departure"])
    linear = [row["crack"] for row in evidence["rows"] if row["departure"] < _LINEAR]
    onset = evidence["onset"]
    here = (
        "no chaos up to the end"
        if onset["crack"] is None
        else f"chaos from {onset['crack']:.2f} mm, at {evidence['share_of_time']:.1%} of the"
        f" record, where the growth so far departs from a line by {evidence['before']:.0%}"
    )
    at_onset = evidence["before"] is not None and evidence["before"] < _LINEAR
    return Finding(
        bool(linear) and at_onset,
        f"{GROWTH} is exponential throughout: up to no size above {NOTCH:g} mm is the growth closer"
        f" than {least['departure']:.0%} of itself to a line (linear: {_LINEAR:.0%}); with s = 1,"
        f" d = 0 {here}",
    )


CHECKS = (
    Check("F42", "a(tau) of the caption; one unit of the last printed digit", _reached,
          _judge_reached),
    Check("F43", "a(tau) of the caption; about: 2 %, all of which must lie before", _passed,
          _judge_passed),
    Check("F44", f"a(tau) of the caption up to {TAU_END:.0f}; 1 % of the length and 1 % of the"
          f" final growth; long: more than {_LONG:.0%} of the record, by both", _waiting,
          _judge_waiting),
    Check("F58", f"best line from tau = 0 up to each size; linear where it is closer than"
          f" {_LINEAR:.0%} of the growth; onset of chaos followed up from rest at 5 mm, s = 1,"
          " d = 0", _growth_law, _judge_growth_law),
)  # fmt: skip
