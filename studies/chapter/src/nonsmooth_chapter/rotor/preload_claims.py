"""Claims on what preload does to chaos, and on coexisting motions without it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from nonsmooth import System, ensemble
from nonsmooth_chapter.judgement import Evidence, Finding
from nonsmooth_chapter.rotor.motions import (
    DELTA_40,
    DELTA_41,
    EPS_40,
    EPS_41,
    coexisting,
    random_starts,
    rig,
    set_a,
    set_b,
)
from nonsmooth_chapter.rotor.speed_sweeps import (
    CHAOTIC,
    PROTOCOLS,
    even_values,
    speed_sweeps,
    with_exponents,
)

_LADDER = (0.0, 0.02, 0.05, 0.1, 0.2)
_SETS = {"A": set_a, "B": set_b}
_STATED = "restart"
_ERRORS = 3.0  # standard errors of a difference of shares


@lru_cache(maxsize=32)
def _share(name: str, delta: float, columns: int, starts: tuple[str, ...]) -> dict[str, float]:
    """Part of eta from 2 to 5 with chaos, by protocol."""
    system = _SETS[name](delta)
    found = speed_sweeps(system, even_values(2.0, 5.0, columns), starts, record=100)
    return {sweep.start: with_exponents(system, sweep).share(CHAOTIC) for sweep in found}


def _error(first: float, second: float, columns: int) -> float:
    """Standard error of a difference of shares, columns taken as drawn at random."""
    return float(np.sqrt((first * (1.0 - first) + second * (1.0 - second)) / columns))


def _wider(columns: int = 200) -> Evidence:
    shares = [_share("A", delta, columns, PROTOCOLS) for delta in (0.0, 0.1)]
    return {"shares": shares, "columns": columns + 1}


def _judge_wider(evidence: Evidence) -> Finding:
    without, loaded = evidence["shares"]
    gains = {
        start: (loaded[start] - without[start], _error(*pair, evidence["columns"]))
        for start in without
        if (pair := (without[start], loaded[start]))
    }
    listed = ", ".join(
        f"{start} {without[start]:.1%} and {loaded[start]:.1%} ({gain:+.1%} +- {error:.1%})"
        for start, (gain, error) in gains.items()
    )
    gain, error = gains[_STATED]
    return Finding(
        gain > _ERRORS * error,
        f"share of chaotic eta from 2 to 5 without and with preload: {listed}; wider: by more than"
        f" {_ERRORS:g} standard errors of the sampling",
    )


def _ladder(columns: int = 100, deltas: Sequence[float] = _LADDER) -> Evidence:
    rows = [
        {"set": name, "delta": delta, "share": _share(name, delta, columns, (_STATED,))[_STATED]}
        for name in _SETS
        for delta in deltas
    ]
    return {"rows": rows, "columns": columns + 1}


def _judge_ladder(evidence: Evidence) -> Finding:
    """Preload can stabilise: in one set at least some preload leaves clearly less chaos than none.

    Eight shares are compared, so that chance alone passes three standard errors in one of a
    hundred ladders.
    """
    clear, listed = [], []
    for name in _SETS:
        rows = [row for row in evidence["rows"] if row["set"] == name]
        none = next(row["share"] for row in rows if row["delta"] == 0.0)
        for row in rows:
            error = _error(none, row["share"], evidence["columns"])
            if none - row["share"] > _ERRORS * error:
                clear.append(f"set {name}, Delta {row['delta']:g}")
        listed.append(
            f"set {name}: "
            + ", ".join(
                f"Delta {r['delta']:g} {r['share']:.1%} +-"
                f" {_error(r['share'], 0.0, evidence['columns']):.1%}"
                for r in rows
            )
        )
    text = (
        f"share of chaotic eta from 2 to 5, with its sampling error: {'; '.join(listed)}; less"
        f" chaos than without preload by more than {_ERRORS:g} standard errors:"
        f" {'; '.join(clear) or 'nowhere'}; section 4.5 states more chaos with preload (R54)"
    )
    return Finding(bool(clear), text)


def _attractors(
    etas: Sequence[float] = (2.18, 2.5, 3.0, 3.83, 4.0, 4.5), eta: float = 3.83, starts: int = 600
) -> Evidence:
    rows = [
        {
            "eta": each,
            "periods": [row["period"] for row in coexisting(set_a(0.0, each))],
            "shares": [row["share"] for row in coexisting(set_a(0.0, each))],
        }
        for each in etas
    ]
    return {"rows": rows, "eta": eta, **_uncertain(set_a(0.0, eta), starts)}


def _uncertain(
    system: System, starts: int, distances: Sequence[float] = (1e-1, 1e-2, 1e-3), dropped: int = 250
) -> Evidence:
    """Exponent of the pairs of starts, displaced in x, that end in motions of another period."""
    near = random_starts(starts, seed=1)
    near["x"], near["y"] = 0.85 * near["x"], 0.85 * near["y"]
    labels = []
    for distance in (0.0, *distances):
        moved = near | {"x": near["x"] + distance}
        runs = ensemble(system, moved, transient=dropped, record=33)
        x = runs["x"].values
        period = np.zeros(starts, int)
        for n in range(16, 0, -1):
            period[np.abs(x[:, n:] - x[:, :-n]).max(axis=1) < 1e-3] = n
        labels.append(period)
    shares = [float(np.mean(labels[0] != label)) for label in labels[1:]]
    used = [
        (np.log(d), np.log(s)) for d, s in zip(distances, shares, strict=True) if s * starts >= 8
    ]
    exponent = (
        float(np.polyfit([a for a, _ in used], [b for _, b in used], 1)[0])
        if len(used) > 1
        else None
    )
    return {"distances": list(distances), "uncertain": shares, "exponent": exponent}


def _judge_attractors(evidence: Evidence) -> Finding:
    listed = "; ".join(
        f"eta {row['eta']:g}: "
        + ", ".join(
            f"{'period ' + str(n) if n else 'no period'} ({share:.0%})"
            for n, share in zip(row["periods"], row["shares"], strict=True)
        )
        for row in evidence["rows"]
    )
    exponent = evidence["exponent"]
    value = "too few uncertain pairs" if exponent is None else f"{exponent:.2f}"
    several = any(len(row["periods"]) > 1 for row in evidence["rows"])
    fractal = exponent is not None and exponent < 0.9
    shares = ", ".join(f"{s:.1%}" for s in evidence["uncertain"])
    text = (
        f"{listed}; pairs of starts that end differently at eta {evidence['eta']:g}, 0.1, 0.01 and"
        f" 0.001 apart: {shares}, exponent {value} (1: smooth boundary)"
    )
    return Finding(several and fractal, text)


def _without_regimes(columns: int = 60) -> Evidence:
    rows = []
    for name, eps, delta, last in (("40", EPS_40, DELTA_40, 50.0), ("41", EPS_41, DELTA_41, 30.0)):
        hertz = rig().natural_frequency
        etas = even_values(7.0 / hertz, last / hertz, columns)
        labels, places = [], []
        for preload in (delta, 0.0):
            system = rig(eps, preload).system()
            (sweep,) = speed_sweeps(system, etas, ("follow up",), transient=400, record=64)
            labels.append(np.maximum(sweep.labels, 0))
            places.append(sweep.data["x"].values)
        moved = np.abs(places[0].mean(axis=1) - places[1].mean(axis=1))
        rows.append(
            {"figure": name, "other_label": float(np.mean(labels[0] != labels[1])),
             "moved": float(np.median(moved))}
        )  # fmt: skip
    return {"rows": rows}


def _judge_without(evidence: Evidence) -> Finding:
    listed = "; ".join(
        f"Fig. {row['figure']} set: another period in {row['other_label']:.0%} of the columns, mean"
        f" displacement moved by {row['moved']:.3f} gaps (median)"
        for row in evidence["rows"]
    )
    return Finding(
        None,
        f"the model with one spring a side in contact (no preload) against that with: {listed};"
        " the measured diagrams behind Figs. 40(b) and 41(b), as numbers, would decide which of"
        " both lies nearer to them",
    )
