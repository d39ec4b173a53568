"""Claims on motions of the rig: records of its masses, and the phases of a period."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nonsmooth import simulate
from nonsmooth_chapter.fatigue.records import (
    FREQUENCY,
    RIGS,
    base_amplitude,
    chaotic,
    chaotic_shaking,
    harmonic,
)
from nonsmooth_chapter.fatigue.rig import (
    Stay,
    phase_of_samples,
    rig_system,
    start_up,
    stays,
    steady,
)
from nonsmooth_chapter.judgement import Evidence, Finding

__all__ = ["ORDER", "passages"]


# Claims on the measured records: broken symmetry (Fig. 16), likeness to the shaking (Fig. 17).

_CRACKS = (6.4, 8.0, 10.0, 12.0, 14.0, 16.0)
_BROKEN = 0.01  # even harmonics beside the first
_ALIKE = 0.9
_DROP = 4.0  # s


def _asymmetry(cracks: Sequence[float] = _CRACKS, mean: float = 100.0) -> Evidence:
    rows = []
    for name in RIGS:
        for crack in cracks:
            run = harmonic(name, crack, mean)
            row = {
                "rig": name,
                "crack": crack,
                "phases": sorted({stay[0] for stay in stays(run)}),
                "least_load": float(run["load"].min()),
                "largest_load": float(run["load"].max()),
                "deflection": float(run["deflection"].values[:-1].mean()),
                "swing": 0.5 * float(np.ptp(run["deflection"].values)),
            }
            for what in ("absolute1", "X3"):
                lines = np.abs(np.fft.rfft(run[what].values[:-1])) / (run.sizes["time"] - 1)
                first = 2.0 * lines[1]
                row[f"{what}_even"] = float(2.0 * np.sqrt(np.sum(lines[2:20:2] ** 2)) / first)
                row[f"{what}_mean"] = float(np.mean(run[what].values[:-1]) / first)
            rows.append(row)
    return {
        "rows": rows,
        "mean_load": mean,
        "base_amplitude": {name: base_amplitude(name, mean) for name in RIGS},
    }


def _judge_asymmetry(evidence: Evidence) -> Finding:
    parts, broken = [], []
    for name in RIGS:
        rows = [row for row in evidence["rows"] if row["rig"] == name]
        both = [min(row["absolute1_even"], row["X3_even"]) for row in rows]
        broken.append(max(both) > _BROKEN and both[-1] > both[0])
        listed = ", ".join(
            f"{row['crack']:g} mm {row['X3_even']:.1%} and {row['absolute1_even']:.1%}"
            for row in rows
        )
        parts.append(
            f"{name} rig, even harmonics of displacement and acceleration: {listed} (least load"
            f" {rows[0]['least_load']:.1f} N at {rows[0]['crack']:g} mm,"
            f" {rows[-1]['least_load']:.1f} N at {rows[-1]['crack']:g} mm); mean deflection from"
            f" {rows[0]['deflection']:.3f} to {rows[-1]['deflection']:.3f} mm, amplitude from"
            f" {rows[0]['swing']:.3f} to {rows[-1]['swing']:.3f} mm"
        )
    return Finding(
        all(broken) if len(set(broken)) == 1 else None,
        "; ".join(parts) + "; the crack breathes, and breaks the symmetry, only where its growth"
        " drives the load below zero, which hangs on the rig",
    )


def _likeness(cracks: Sequence[float] = (6.4, 10.0, 14.0), mean: float = 0.0) -> Evidence:
    rows = []
    for name in RIGS:
        record = chaotic_shaking(name, mean)
        for crack in cracks:
            run = chaotic(name, crack, mean, record, _DROP)
            step = float(run["time"][1] - run["time"][0])
            row = {"rig": name, "crack": crack, "phases": run.attrs["phases"]}
            for what in ("absolute1", "X3", "pneumatic1"):
                best, lag = _best_lag(run["base"].values, run[what].values)
                row[what] = best
                row[f"{what}_lag"] = 1e3 * lag * step
            rows.append(row)
    return {"rows": rows, "mean_load": mean}


def _best_lag(first: np.ndarray, second: np.ndarray) -> tuple[float, int]:
    """Correlation of largest size of a record with an earlier or later one, and the lag."""
    most = int(1.0 / FREQUENCY / 2.0 * 640.0)  # half a period of 20 Hz
    found = []
    for lag in range(-most, most + 1):
        a = first[most : first.size - most]
        b = second[most + lag : second.size - most + lag]
        found.append(float(np.corrcoef(a, b)[0, 1]))
    best = int(np.argmax(np.abs(found)))
    return found[best], best - most


def _judge_likeness(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    listed = "; ".join(
        f"{row['rig']} rig, crack {row['crack']:g} mm (phases {row['phases']}): acceleration of"
        f" mass 1 {row['absolute1']:+.3f} at {row['absolute1_lag']:.1f} ms, displacement"
        f" {row['X3']:+.3f}, force of cylinder 1 {row['pneumatic1']:+.3f}"
        for row in rows
    )
    return Finding(
        all(abs(row["absolute1"]) >= _ALIKE for row in rows),
        f"correlation with the base acceleration at the best lag, {listed}",
    )


# Claims on the four phases of Fig. 24: which occur, in what order, and what moves in each.

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
