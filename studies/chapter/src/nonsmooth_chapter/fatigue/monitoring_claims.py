"""Claim that the birth of the strange attractor marks a critical crack size for monitoring."""

from __future__ import annotations

from typing import Any

import numpy as np

from nonsmooth_chapter.fatigue.beam_data import ETA, TAU_END, XI, tau_at
from nonsmooth_chapter.fatigue.monitoring import NOISE, STROBES, THRESHOLD, alarm_rates
from nonsmooth_chapter.fatigue.onset import followed_periods, onset_along_growth, onset_from_starts
from nonsmooth_chapter.judgement import Check, Evidence, Finding

__all__ = ["CHECKS"]

_STEP, _STARTS_STEP = 0.05, 0.1  # mm
_SHIFT = 0.02  # of the crack length: a mark that moves less has a place
_RATE = 0.05  # of wrong alarms at 1 % of noise
_LASTING = 0.5  # of the lengths behind the onset that must be chaotic, or the alarm ends again
_VARIED: tuple[dict[str, float], ...] = (
    {"eta": 0.99 * ETA}, {"eta": 1.01 * ETA}, {"eta": 0.95 * ETA}, {"eta": 1.05 * ETA},
    {"xi": 0.5 * XI}, {"xi": 2.0 * XI}, {"d": -0.1}, {"d": 0.1}, {"d": -0.5}, {"d": 0.5},
    {"s": 0.11}, {"s": 0.43}, {"s": 0.9}, {"s": 1.1}, {"s": 2.0},
)  # fmt: skip
# what a rig may change between two tests; s belongs to the model
_FORCED = ("eta", "xi", "d")


def _onsets(varied: tuple[dict[str, float], ...] = _VARIED) -> Evidence:
    here = onset_along_growth(_STEP)
    rows = [
        {"changed": changed, "followed": onset_along_growth(_STEP, **changed)["crack"]}
        for changed in varied
    ]
    lasting = None
    if here["crack"] is not None:
        diagram = followed_periods(_STEP)
        behind = diagram["parameter"].values >= here["crack"]
        lasting = float(np.mean(diagram["period"].values[behind] == 0))
    return {
        "onset": here,
        "from_starts": onset_from_starts(_STARTS_STEP),
        "share_of_time": None if here["crack"] is None else tau_at(here["crack"]) / TAU_END,
        "aperiodic_behind": lasting,
        "rows": rows,
        "alarms": list(alarm_rates()),
    }


def _shift(row: Evidence, evidence: Evidence) -> float | None:
    first = evidence["onset"]["crack"]
    return None if None in (row["followed"], first) else row["followed"] - first


def _judge(evidence: Evidence) -> Finding:
    onset = evidence["onset"]["crack"]
    if onset is None:
        return Finding(False, "no chaos for s = 1, d = 0")
    forced = [row for row in evidence["rows"] if set(row["changed"]) & set(_FORCED)]
    shifts = [_shift(row, evidence) for row in forced]
    stays = all(shift is not None and abs(shift) <= _SHIFT * onset for shift in shifts)
    quiet = next(row for row in evidence["alarms"] if row["noise"] == 0.01)
    told = max(quiet["scatter"].values()) <= _RATE
    better = all(
        sum(row["scatter"].values()) < sum(row["amplitude"].values()) for row in evidence["alarms"]
    )
    lasts = evidence["aperiodic_behind"] > _LASTING
    return Finding(
        stays and told and better and lasts,
        f"s = 1, d = 0: followed, chaos begins at {onset:.2f} mm ({evidence['share_of_time']:.1%}"
        f" of the record), from any of six starts at {evidence['from_starts']['crack']:.1f} mm;"
        f" behind it {evidence['aperiodic_behind']:.0%} of the lengths are aperiodic; onset when"
        f" changed: {_changes(evidence)}; alarms: {_alarms(evidence)}",
    )


def _changes(evidence: Evidence) -> str:
    parts = []
    for row in evidence["rows"]:
        names = ", ".join(f"{name} {value:.4g}" for name, value in row["changed"].items())
        shift = _shift(row, evidence)
        parts.append(f"{names}: " + ("none" if shift is None else f"{shift:+.2f} mm"))
    return "; ".join(parts)


def _alarms(evidence: Evidence) -> str:
    def rates(row: Evidence, name: str) -> str:
        return f"{row[name]['false']:.0%} false, {row[name]['missed']:.0%} missed"

    rows: list[Any] = evidence["alarms"]
    counts = f"{rows[0]['periodic']} periodic and {rows[0]['chaotic']} chaotic records"
    listed = "; ".join(
        f"noise {row['noise']:.1%}: by scatter {rates(row, 'scatter')}, by the 0-1 test"
        f" {rates(row, 'zero_one')}, by the amplitude alone {rates(row, 'amplitude')}"
        for row in rows
    )
    return f"{counts}, {listed}"


_PROTOCOL = (
    "s = 1, d = 0; onset: first length with a chaotic motion followed up from rest at 5 mm in steps"
    f" of {_STEP:g} mm, beside it from six starts in steps of {_STARTS_STEP:g}; eta, xi, d and s"
    f" changed one at a time; records of {STROBES} strobes of u from rest, 1000 periods dropped,"
    f" with normal noise of {', '.join(f'{level:.1%}' for level in NOISE)} of the amplitude: alarm"
    f" by scatter about a cycle of at most 8 points above {THRESHOLD:.0%} of the amplitude, by"
    " K > 0.5 of the 0-1 test, and as a baseline by the amplitude alone, above the limit that errs"
    " least. True when for changed eta, xi and d the onset stays within"
    f" {_SHIFT:.0%}, alarms by scatter are wrong in {_RATE:.0%} at most at 1 % noise and less often"
    f" than the baseline at any, and more than {_LASTING:.0%} of the lengths behind the onset are"
    " aperiodic"
)

CHECKS = (Check("F59", _PROTOCOL, _onsets, _judge),)
