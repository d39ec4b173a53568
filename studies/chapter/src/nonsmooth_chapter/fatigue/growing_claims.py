"""Claims on the growing crack of Fig. 30: the order of its responses, and when each comes.

The chapter gives neither s nor d. With s = 1 and d = 0 the whole of Fig. 30 is run from rest, with
the length frozen in each period (which decides) and growing within the flow; after a chaotic
stretch rounding chooses among attractors, so further starts show what may come then. A coarse scan
over s and d shows what depends on them; it proves nothing for all of them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nonsmooth_chapter.fatigue.beam_data import D_RANGE, S_RANGE, TAU_END, crack_at, tau_at
from nonsmooth_chapter.fatigue.growing import LATE_STARTS, growing_run
from nonsmooth_chapter.fatigue.growth_history import (
    LATE,
    MANY,
    SCANNED,
    convention_histories,
    first_loss,
    label_share,
    longest_retreat,
    scanned_histories,
    separators,
)
from nonsmooth_chapter.judgement import Check, Evidence, Finding, agrees

__all__ = ["CHECKS"]

_PERIOD_ONE_TO = 10.7  # mm
_NEAR = 0.02  # about: of the crack length
_AROUND = 500.0  # on either side of a printed time
_MOSTLY = 0.5  # of a span with a label
_BACK = 0.01  # of the range: a retreat that is none
_SHORT = 0.1  # of the time between the printed lengths

Row = Evidence
Predicate = Callable[[Row], bool]


def _told(predicate: Predicate, value: Callable[[Row], Any]) -> Callable[[], Evidence]:
    """Evidence: what a predicate and a value say of every run."""

    def compute() -> Evidence:
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

    return compute


def _judge(form: Callable[[Any], str]) -> Callable[[Evidence], Finding]:
    def judge(evidence: Evidence) -> Finding:
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

    return judge


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


def _local(claim: str, label: int, low: float, high: float, words: str) -> Check:
    value = _share_of(label, low, high)
    return Check(
        claim,
        f"{_PROTOCOL}; {words} (tau {low:.0f} to {high:.0f}); true when more than {_MOSTLY:.0%} of"
        " it has the label",
        _told(lambda row: value(row)["share"] > _MOSTLY, value),
        _judge(_shares_text),
    )


def _at(claim: str, label: int, tau: float) -> Check:
    words = f"within {_AROUND:g} of the printed time, {crack_at(tau):.2f} mm"
    return _local(claim, label, tau - _AROUND, tau + _AROUND, words)


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


_NAMES = {"frozen": "frozen per period", "flow": "within the flow"}
_RANGE = f"s {S_RANGE[0]:g} to {S_RANGE[1]:g}, d {D_RANGE[0]:.2f} to {D_RANGE[1]:.2f}"
_PROTOCOL = (
    f"a(tau) of the caption, tau 0 to {TAU_END:.0f}, from rest, s = 1, d = 0; frozen per period"
    " decides; local labels up to period 8 in windows of 64 strobes, exponent of every stretch"
    f" without a period; beside it {len(LATE_STARTS) - 1} starts at tau {LATE:.0f} and"
    f" {len(SCANNED['s'])} by {len(SCANNED['d'])} values of s and d from there"
)

CHECKS = (
    Check("F49", _PROTOCOL + "; short stretches that are not chaotic and lead from period one back"
          " to it are jumps", _told(_keeps_period_one, _loss), _judge(_loss_text)),
    Check("F50", _PROTOCOL + "; u or v never goes back, while below 10.7 mm, by more than"
          f" {_BACK:.0%} of its range", _retreats, _judge(_retreat_text)),
    Check("F51", _PROTOCOL + "; between 10.7 and 12 mm some stretch is chaotic, and chaos takes at"
          f" most {_SHORT:.0%} of the time",
          _told(lambda row: 0.0 < _chaos_between(row) <= _SHORT,
                _share_of(0, tau_at(_PERIOD_ONE_TO), tau_at(12.0))), _judge(_shares_text)),
    _local("F52", 2, tau_at(12.0 * (1 - _NEAR)), tau_at(12.0 * (1 + _NEAR)),
           "within 2 % of 12 mm"),
    _at("F53", 3, 915_662.0),
    _at("F54", 2, 928_100.0),
    _at("F55", 2, 936_903.0),
    Check("F56", f"{_PROTOCOL}; behind 10.7 mm, between neighbouring periodic stretches of {MANY}"
          " strobes at least, a chaotic one", _told(_separated, lambda row: separators(
              row, _PERIOD_ONE_TO)), _judge(_separators_text)),
)  # fmt: skip
