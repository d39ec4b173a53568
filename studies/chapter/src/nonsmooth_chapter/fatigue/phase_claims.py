"""Claims on the four phases of Fig. 24: which occur, in what order, and what moves in each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nonsmooth import simulate
from nonsmooth_chapter.fatigue.rig_data import (
    Stay,
    phase_of_samples,
    rig_system,
    start_up,
    stays,
    steady,
)
from nonsmooth_chapter.judgement import Check, Evidence, Finding

__all__ = ["CHECKS", "ORDER", "passages"]

ORDER = ("i", "iii", "iv", "ii")
_SHOWN = 20  # phases of the start-up that are listed
_RELAXED, _SHARE = 10.0, 0.1  # relaxation times, and the part of phase iv that they may take
_NEAR = 0.1  # of the distance of the mass that is away, and of its range


def _words(starts: int = 40, periods: int = 60) -> Evidence:
    system = rig_system()
    rng = np.random.default_rng(0)
    found: dict[str, int] = {}
    for _ in range(starts):
        state = dict(zip(("X1", "X4", "X2", "X5"), rng.uniform(-3.0, 3.0, 4), strict=True))
        word = _distinct(stays(simulate(system, state, periods=periods))[-6:])
        found[word] = found.get(word, 0) + 1
    return {
        "start_up": [row[0] for row in stays(start_up(system))][:_SHOWN],
        "steady": sorted({row[0] for row in stays(steady(system))}),
        "steady_word": str(steady(system).attrs["phase_word"]),
        "phases_from_random_starts": found,
    }


def _distinct(rows: Sequence[Stay]) -> str:
    return " ".join(sorted({row[0] for row in rows}))


def _judge_words(evidence: Evidence) -> Finding:
    late = ", ".join(
        f"{word} ({count})" for word, count in evidence["phases_from_random_starts"].items()
    )
    missing = sorted(set(ORDER) - set(evidence["steady"]))
    return Finding(
        set(evidence["start_up"]) == set(ORDER),
        f"from zero: {' '.join(evidence['start_up'])} ...; the steady motion has no"
        f" {', '.join(missing) or 'missing phase'}: in a period it passes"
        f" {evidence['steady_word']}; last phases from random starts: {late}",
    )


def passages(rows: Sequence[Stay]) -> list[Sequence[Stay]]:
    """Places at which the phases i, iii, iv, ii follow each other.

    Parameters
    ----------
    rows : sequence of (str, float, float)
        Result of `stays`.

    Returns
    -------
    list of sequence of (str, float, float)

    Examples
    --------
    >>> rows = [(name, float(k), k + 1.0) for k, name in enumerate("i iii iv ii iv".split())]
    >>> [[row[0] for row in each] for each in passages(rows)]
    [['i', 'iii', 'iv', 'ii']]
    """
    last = len(rows) - len(ORDER) + 1
    pieces = (rows[k : k + len(ORDER)] for k in range(last))
    return [piece for piece in pieces if tuple(row[0] for row in piece) == ORDER]


def _order() -> Evidence:
    system = rig_system()
    run = start_up(system)
    whole = stays(run)
    time, place = run["time"].values, run["X1"].values
    rows = []
    for piece in passages(whole):
        before = [name for name, _, end in whole if abs(end - piece[0][1]) < 1e-12]
        begin_iv = piece[2][1]
        rows.append(
            {
                "begin": piece[0][1],
                "before": before[0] if before else "",
                "durations": [end - begin for _, begin, end in piece],
                "mass_1": float(np.interp(begin_iv, time, place) / np.ptp(place)),
            }
        )
    late = stays(steady(system))
    return {
        "rows": rows,
        "period": float(run.attrs["period"]),
        "steady_passages": len(passages(late)),
        "steady": [[name, end - begin] for name, begin, end in late[1:5]],
    }


def _judge_order(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    period = evidence["period"]
    as_told = [row for row in rows if _as_told(row)]
    listed = "; ".join(
        f"from tau = {row['begin']:.3f}, after {_after(row)}: "
        + ", ".join(f"({n}) {d:.3f}" for n, d in zip(ORDER, row["durations"], strict=True))
        + f", mass 1 at {row['mass_1']:+.1%} of its range where (iv) begins"
        for row in rows
    )
    steady_text = ", ".join(f"({name}) {d:.3f}" for name, d in evidence["steady"])
    return Finding(
        bool(as_told),
        f"the order occurs {len(rows)} times in the start-up, as the text tells it in"
        f" {len(as_told)}: {listed} (period {period:.3f}); in steady motion"
        f" {evidence['steady_passages']} times: {steady_text}",
    )


def _as_told(row: Evidence) -> bool:
    """Mass 1 with the specimen hits mass 2, (i) is short, mass 1 is near rest where (iv) begins."""
    durations = row["durations"]
    return bool(
        row["before"] == "iii" and durations[0] == min(durations) and abs(row["mass_1"]) <= _NEAR
    )


def _after(row: Evidence) -> str:
    return f"({row['before']})" if row["before"] else "the start at rest"


def _at_rest() -> Evidence:
    system = rig_system()
    p = system.parameter_values
    rows = {}
    for name, run in (("start-up", start_up(system)), ("steady", steady(system))):
        whole = [end - begin for phase, begin, end in stays(run)[1:-1] if phase == "iv"]
        rows[name] = {"shortest": min(whole), "count": len(whole), "farthest": _late(run, "iv")}
    return {"relaxation": 2.0 * p["xi_s"] / p["theta"], "rows": rows}


def _late(run: Any, phase: str) -> float:
    """Largest deflection in the second half of the stays in a phase, by its largest in the run."""
    time, deflection = run["time"].values, np.abs(run["deflection"].values)
    most = 0.0
    for name, begin, end in stays(run)[1:-1]:
        if name == phase:
            inside = (time >= 0.5 * (begin + end)) & (time < end)
            most = max(most, float(deflection[inside].max(initial=0.0)))
    return most / float(deflection.max())


def _judge_at_rest(evidence: Evidence) -> Finding:
    rows, relaxation = evidence["rows"], evidence["relaxation"]
    rests = [
        _RELAXED * relaxation <= _SHARE * row["shortest"] and row["farthest"] < 1e-6
        for row in rows.values()
    ]
    listed = "; ".join(
        f"{name}: {row['count']} stays, the shortest {row['shortest'] / relaxation:.0f} of them,"
        f" deflection in their second half {row['farthest']:.0e} of the largest"
        for name, row in rows.items()
    )
    return Finding(
        all(rests),
        f"free of the masses the specimen relaxes with a time constant of {relaxation:.2e}"
        f"; phase (iv) in the {listed}",
    )


def _followers() -> Evidence:
    system = rig_system()
    rows = []
    for name, run in (("start-up", start_up(system)), ("steady", steady(system))):
        phases = phase_of_samples(run)
        for phase, follower, other in (("iii", "X1", "X4"), ("ii", "X4", "X1")):
            here = phases == phase
            moves = np.concatenate([run["X1"].values, run["X4"].values])
            place = run["X3"].values[here]
            rows.append(
                {
                    "motion": name,
                    "phase": phase,
                    "near": float(np.abs(run[follower].values[here] - place).max()),
                    "away": float(np.abs(run[other].values[here] - place).max()),
                    "range": float(np.ptp(moves)),
                    "correlation": float(np.corrcoef(run[follower].values[here], place)[0, 1]),
                }
            )
    return {"rows": rows}


def _judge_followers(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    listed = "; ".join(
        f"{row['motion']} ({row['phase']}): {row['near']:.3f} at most"
        f" ({row['near'] / row['range']:.1%} of the range of the masses, correlation"
        f" {row['correlation']:.4f}), the other mass up to {row['away']:.2f}"
        for row in rows
    )
    return Finding(
        all(row["near"] <= _NEAR * row["away"] for row in rows),
        f"distance from the specimen of the mass in contact: {listed}",
    )


_ZERO = (
    "Fig. 24 set from zero, as section 3.3 states of its integrations, 40 periods; steady: after"
    " 400 periods"
)
CHECKS = (
    Check("F24", f"{_ZERO}; the start-up decides; 40 random starts besides", _words, _judge_words),
    Check("F25", f"{_ZERO}; the start-up decides: at one place at least mass 1 with the specimen"
          " hits mass 2, so (iii) comes before, then (i), (iii), (iv), (ii) in turn with (i) the"
          f" shortest, and mass 1 within {_NEAR:.0%} of its range of zero where (iv) begins",
          _order, _judge_order),
    Check("F26", f"{_ZERO}; rests: {_RELAXED:g} time constants are at most {_SHARE:.0%} of the"
          " shortest phase (iv), in both motions", _at_rest, _judge_at_rest),
    Check("F27", f"{_ZERO}; follows: at most {_NEAR:.0%} as far from the specimen as the other mass"
          " gets in that phase, in both motions", _followers, _judge_followers),
)  # fmt: skip
