"""Claims on the growing crack: its length, the order of its responses, monitoring."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from nonsmooth_chapter.fatigue.crack_motions import (
    D_RANGE,
    ETA,
    GROWTH,
    NOTCH,
    RATE,
    S_RANGE,
    TAU_END,
    XI,
    beam,
    crack_at,
    followed_periods,
    motions,
    motions_from,
    onset_along_growth,
    onset_from_starts,
    tau_at,
)
from nonsmooth_chapter.fatigue.growing_crack import (
    RATE_OF_ALARMS,
    Growth,
    alarm_rates,
    convention_histories,
    first_loss,
    growing_run,
    history,
    label_share,
    longest_retreat,
    scanned_histories,
    separators,
)
from nonsmooth_chapter.judgement import Evidence, Finding, agrees

__all__ = ["growing_label", "stations"]


# Claims on the growth curve of Figs. 29 and 30: where it is when, and how it grows.

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


# Claims on the growing crack of Fig. 30: the order of its responses, and when each comes.
#
# The chapter gives neither s nor d. With s = 1 and d = 0 the whole of Fig. 30 is run from rest,
# with the length frozen in each period (which decides) and growing within the flow; after a chaotic
# stretch rounding chooses among attractors, so further starts show what may come then. A coarse
# scan over s and d shows what depends on them; it proves nothing for all of them.

_PERIOD_ONE_TO = 10.7  # mm
_NEAR = 0.02  # about: of the crack length
_AROUND = 500.0  # on either side of a printed time
_MOSTLY = 0.5  # of a span with a label
_BACK = 0.01  # of the range: a retreat that is none
_SHORT = 0.1  # of the time between the printed lengths

Row = Evidence
Predicate = Callable[[Row], bool]


def _told(predicate: Predicate, value: Callable[[Row], Any]) -> Evidence:
    """What a predicate and a value say of every run."""
    rows = convention_histories()
    scan = scanned_histories()
    return {
        "runs": [
            {"grows": row["grows"], "start": row["start"], "first": row["first"],
             "true": bool(predicate(row)), "value": value(row)}
            for row in rows
        ],
        "scan": {"cases": len(scan), "true": sum(bool(predicate(row)) for row in scan)},
    }  # fmt: skip


def _finding(evidence: Evidence, form: Callable[[Any], str]) -> Finding:
    runs, scan = evidence["runs"], evidence["scan"]
    whole = "; ".join(
        f"{_NAMES[row['grows']]} {form(row['value'])}" for row in runs if not row["first"]
    )
    others = [row for row in runs if row["first"]]
    agree = sum(row["true"] for row in others)
    beside = f"in {agree} of {len(others)} runs from other starts, and " if others else ""
    return Finding(
        runs[0]["true"],
        f"s = 1, d = 0, from rest: {whole}; true {beside}in {scan['true']} of {scan['cases']}"
        f" pairs of s and d, {_RANGE}",
    )


def _period_one() -> Evidence:
    return _told(_keeps_period_one, _loss)


def _keeps_period_one(row: Row) -> bool:
    length = first_loss(row)[0]
    return length is None or length >= _PERIOD_ONE_TO


def _loss(row: Row) -> Evidence:
    length, other = first_loss(row)
    jumps = [
        each["from_crack"]
        for each in row["stretches"]
        if not each["period"] and each["from_crack"] < (length or 20.0)
    ]
    return {"length": length, "other": other, "jumps": jumps}


def _loss_text(value: Evidence) -> str:
    if value["length"] is None:
        return "period one throughout"
    jumps = ", ".join(f"{jump:.2f}" for jump in value["jumps"])
    jumps = f", with jumps to other such motions at {jumps} mm" if jumps else ""
    return (
        f"period one to {value['length']:.3f} mm (tau {tau_at(value['length']):.0f}; the printed"
        f" {_PERIOD_ONE_TO} mm {_beside_printed(value['length'])}), then {value['other']}{jumps}"
    )


def _judge_period_one(evidence: Evidence) -> Finding:
    return _finding(evidence, _loss_text)


def _beside_printed(length: float) -> str:
    off = length - float(_PERIOD_ONE_TO)
    agree = "agrees" if agrees(length, str(_PERIOD_ONE_TO)) else "does not agree"
    return f"{agree} to its last digit, {off:+.3f} mm"


def _chaos_between(row: Row) -> float:
    return label_share(row, tau_at(_PERIOD_ONE_TO), tau_at(12.0), "chaos")


def _share_of(label: int, low: float, high: float) -> Callable[[Row], Evidence]:
    def value(row: Row) -> Evidence:
        labels = {each["period"] for each in row["stretches"]}
        shares = {
            f"period {n}" if n else "no period": label_share(row, low, high, n) for n in labels
        }
        shares["chaos"] = label_share(row, low, high, "chaos")
        return {
            "share": label_share(row, low, high, label),
            "shares": {name: share for name, share in shares.items() if share > 0.0},
        }

    return value


def _shares_text(value: Evidence) -> str:
    return ", ".join(
        f"{name} {share:.0%}"
        for name, share in sorted(value["shares"].items(), key=lambda item: -item[1])
    ) or "nothing"  # fmt: skip


def _chaos_after_period_one() -> Evidence:
    return _told(
        lambda row: 0.0 < _chaos_between(row) <= _SHORT,
        _share_of(0, tau_at(_PERIOD_ONE_TO), tau_at(12.0)),
    )


def _label_near(label: int, crack: float) -> Evidence:
    return _label_within(label, tau_at(crack * (1 - _NEAR)), tau_at(crack * (1 + _NEAR)))


def _label_at(label: int, tau: float) -> Evidence:
    return _label_within(label, tau - _AROUND, tau + _AROUND)


def _label_within(label: int, low: float, high: float) -> Evidence:
    value = _share_of(label, low, high)
    return _told(lambda row: value(row)["share"] > _MOSTLY, value)


def _judge_shares(evidence: Evidence) -> Finding:
    return _finding(evidence, _shares_text)


def _chaos_between_periods() -> Evidence:
    return _told(_separated, lambda row: separators(row, _PERIOD_ONE_TO))


def _judge_separators(evidence: Evidence) -> Finding:
    return _finding(evidence, _separators_text)


def _separated(row: Row) -> bool:
    found = separators(row, _PERIOD_ONE_TO)
    return bool(found) and all(each["chaotic"] for each in found)


def _separators_text(value: list[Evidence]) -> str:
    return ", ".join(
        f"{each['before']} to {each['behind']} at {each['from_crack']:.2f} to"
        f" {each['to_crack']:.2f} mm {'by chaos' if each['chaotic'] else 'without chaos'}"
        for each in value
    ) or "no two periodic stretches"  # fmt: skip


def _retreats() -> Evidence:
    rows = []
    for row in convention_histories():
        if row["first"]:
            continue
        run = growing_run(row["grows"], tuple(row["start"]), row["first"])
        retreat = longest_retreat(run)
        rows.append(
            {"grows": row["grows"], "start": row["start"], "first": row["first"],
             "true": bool(min(retreat.values()) <= _BACK), "value": retreat}
        )  # fmt: skip
    scan = scanned_histories()
    true = sum(bool(min(row["retreat"].values()) <= _BACK) for row in scan)
    return {"runs": rows, "scan": {"cases": len(scan), "true": true}}


def _retreat_text(value: Evidence) -> str:
    return ", ".join(f"{name} goes back by {share:.0%}" for name, share in value.items())


def _judge_retreats(evidence: Evidence) -> Finding:
    return _finding(evidence, _retreat_text)


_NAMES = {"frozen": "frozen per period", "flow": "within the flow"}
_RANGE = f"s {S_RANGE[0]:g} to {S_RANGE[1]:g}, d {D_RANGE[0]:.2f} to {D_RANGE[1]:.2f}"


# Claim that a crack of fixed length answers as a growing one does when it has that length.

BETWEEN, CHAOS, LONG = "between", "chaos", "long period"
_LONGEST = 8  # period of a local label
_FIRST, _LAST, _STEP = 5.1, 16.7, 0.1  # mm


@lru_cache(maxsize=2)
def stations(step: float = _STEP) -> Evidence:
    """Labels of growing cracks and of fixed ones at lengths along the growth.

    Parameters
    ----------
    step : float, optional
        Between lengths [mm].

    Returns
    -------
    dict
        ``rows`` with ``crack``, labels ``frozen`` and ``flow`` of the growing crack, ``fixed``
        (of all attractors) and ``from_rest``.
    """
    rows = []
    for crack in np.arange(_FIRST, _LAST + 0.5 * step, step).round(6).tolist():
        system = beam(crack)
        start = motions_from(system, {"u": [0.0], "v": [0.0]}, transient=1000)[0]
        fixed = [_fixed_label(row["period"], row["kind"] == "chaotic") for row in motions(system)]
        rows.append(
            {
                "crack": crack,
                "frozen": growing_label("frozen", crack),
                "flow": growing_label("flow", crack),
                "fixed": sorted(set(fixed)),
                "from_rest": _fixed_label(start["period"], start.get("chaotic", False)),
            }
        )
    return {"rows": rows}


def growing_label(grows: Growth, crack: float) -> str:
    """What the growing beam does when its crack has a length.

    Parameters
    ----------
    grows : {"frozen", "flow"}
        As for `growing_run`.
    crack : float
        Length [mm].

    Returns
    -------
    str
        "period 2" and the like, "chaos", or "between" where it settles anew.
    """
    tau = tau_at(crack)
    for row in history(grows)["stretches"]:
        if row["from_tau"] <= tau <= row["to_tau"]:
            if row["period"]:
                return f"period {row['period']}"
            return CHAOS if row["chaotic"] else BETWEEN
    return BETWEEN


def _fixed_label(period: int, chaotic: bool) -> str:
    if period > _LONGEST:
        return LONG
    return f"period {period}" if period else CHAOS if chaotic else BETWEEN


def _by_chance(rows: list[Evidence]) -> float:
    """Share of equal labels that the same labels would have in any other order of the lengths."""
    growing, fixed = (Counter(row[name] for row in rows) for name in ("frozen", "from_rest"))
    return sum(growing[label] * fixed[label] for label in growing) / len(rows) ** 2


def _judge(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    among = [_is_among(row["frozen"], row["fixed"]) for row in rows]
    rest = float(np.mean([row["frozen"] == row["from_rest"] for row in rows]))
    ways = np.mean([row["frozen"] == row["flow"] for row in rows])
    failed = ", ".join(
        f"{row['crack']:g} mm {row['frozen']} (fixed: {', '.join(row['fixed'])})"
        for row, good in zip(rows, among, strict=True)
        if not good
    )
    seen = sorted({label for row in rows for label in row["fixed"]})
    shown = sorted({row["frozen"] for row in rows} - {BETWEEN})
    return Finding(
        rest == 1.0,
        f"growing and fixed cracks have one label at {rest:.0%} of {len(rows)} lengths, where the"
        f" same labels in any order would at {_by_chance(rows):.0%}; at {sum(among)} the growing"
        " crack does what some attractor of the fixed one does; frozen per period and"
        f" within the flow have one label at {ways:.0%}; not at {failed or 'none'}; growing:"
        f" {', '.join(shown)}; fixed: {', '.join(seen)}",
    )


def _is_among(label: str, fixed: list[str]) -> bool:
    return label in fixed or (label == CHAOS and LONG in fixed)


# Claim that the birth of the strange attractor marks a critical crack size for monitoring.

_STEP_MONITORING, _STARTS_STEP = 0.05, 0.1  # mm
_SHIFT = 0.02  # of the crack length: a mark that moves less has a place
_MISSED = 0.05  # of the chaotic records, at most, at 1 % of noise
_LASTING = 0.5  # of the lengths behind the onset that must be chaotic, or the alarm ends again
_VARIED: tuple[dict[str, float], ...] = (
    {"eta": 0.99 * ETA}, {"eta": 1.01 * ETA}, {"eta": 0.95 * ETA}, {"eta": 1.05 * ETA},
    {"xi": 0.5 * XI}, {"xi": 2.0 * XI}, {"d": -0.1}, {"d": 0.1}, {"d": -0.5}, {"d": 0.5},
    {"s": 0.11}, {"s": 0.43}, {"s": 0.9}, {"s": 1.1}, {"s": 2.0},
)  # fmt: skip
# what a rig may change between two tests; s belongs to the model
_FORCED = ("eta", "xi", "d")


def _onsets(varied: tuple[dict[str, float], ...] = _VARIED) -> Evidence:
    here = onset_along_growth(_STEP_MONITORING)
    rows = [
        {"changed": changed, "followed": onset_along_growth(_STEP_MONITORING, **changed)["crack"]}
        for changed in varied
    ]
    lasting = None
    if here["crack"] is not None:
        diagram = followed_periods(_STEP_MONITORING)
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


def _judge_monitoring(evidence: Evidence) -> Finding:
    onset = evidence["onset"]["crack"]
    if onset is None:
        return Finding(False, "no chaos for s = 1, d = 0")
    forced = [row for row in evidence["rows"] if set(row["changed"]) & set(_FORCED)]
    shifts = [_shift(row, evidence) for row in forced]
    stays = all(shift is not None and abs(shift) <= _SHIFT * onset for shift in shifts)
    quiet = next(row for row in evidence["alarms"] if row["noise"] == 0.01)
    found = quiet["scatter"]
    told = found["false"] <= found["high"] and found["missed"] <= _MISSED
    better = all(
        row["scatter"]["missed"] < row["amplitude"]["missed"] for row in evidence["alarms"]
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
        one = row[name]
        return (
            f"{one['false']:.0%} false (stated {one['low']:.0%} to {one['high']:.0%}),"
            f" {one['missed']:.0%} missed"
        )

    rows: list[Any] = evidence["alarms"]
    counts = (
        f"limits for {RATE_OF_ALARMS:.0%} of false alarms from other lengths; judged are"
        f" {rows[0]['healthy']} records before the onset and {rows[0]['chaotic']} chaotic ones, of"
        " which the strobes hold nothing but noise as long as the period is one"
    )
    listed = "; ".join(
        f"noise {row['noise']:.1%}: by scatter {rates(row, 'scatter')}, by the 0-1 test"
        f" {rates(row, 'zero_one')}, by the amplitude alone {rates(row, 'amplitude')}"
        for row in rows
    )
    return f"{counts}, {listed}"
