"""Claims on coexisting attractors of the mole and their basins: Fig. 12."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from nonsmooth_chapter.exponents import largest_exponent
from nonsmooth_chapter.judgement import Evidence, Finding
from nonsmooth_chapter.mole.basins import (
    DISTANCES,
    OMEGAS,
    SECTIONS,
    Section,
    by_recurrences,
    by_runs,
    exponent_on_grid,
    exponents_of_pairs,
    oscillator,
)

_PANELS = dict(zip(OMEGAS, "abcdef", strict=True))
_CLOSES = 1e-10  # residual of a cycle
_ERRORS = 3.0  # standard errors
_SAMPLES, _RUNS, _DROPPED = 1000, 2000, 4000
_TRIED = (
    "strobe phases 0, .25, .5, .75 with p -3..1, y -1..1, q = max(0, p - g); q = that + .5;"
    " p -6..2, y -2..2; all of (p, y, q) with q 0..1"
)


@cache
def _recurrences(omega: float, section: int, samples: int, seed: int) -> Evidence:
    """Found once for all claims on a panel."""
    return by_recurrences(omega, SECTIONS[section], samples, seed)


@cache
def _runs(omega: float, starts: int, dropped: int) -> Evidence:
    return by_runs(omega, starts, dropped)


def _coexisting(
    omega: float,
    samples: int = _SAMPLES,
    runs: int = _RUNS,
    dropped: int = _DROPPED,
    more: Sequence[Section] = (),
) -> Evidence:
    routes = [_recurrences(omega, k, samples, k) for k in range(len(SECTIONS))]
    routes += [by_recurrences(omega, section, samples) for section in more]
    return {"omega": omega, "routes": [*routes, _runs(omega, runs, dropped)]}


def _judge_count(evidence: Evidence, printed: int) -> Finding:
    routes = evidence["routes"]
    counts = sorted({len(route["attractors"]) for route in routes})
    residual = max(
        (each["residual"] for route in routes for each in route["attractors"] if each["period"]),
        default=0.0,
    )
    listed = "; ".join(f"{r['route']}, {r['section']}: {_named(r['attractors'])}" for r in routes)
    text = (
        f"omega {evidence['omega']:g}, printed {printed}, found"
        f" {' or '.join(map(str, counts))}: {listed}; cycles close to {residual:.1g};"
        f" {sum(route['unsettled'] for route in routes)} starts unsettled"
    )
    if len(counts) > 1 or residual > _CLOSES:
        return Finding(None, text)
    return Finding(counts == [printed], text, for_all=f"every section and window tried: {_TRIED}")


def _named(attractors: Sequence[Evidence]) -> str:
    return " + ".join(
        f"{'period ' + str(each['period']) if each['period'] else each['kind']}"
        f" ({100.0 * each['fraction']:.2g} %)"
        for each in attractors
    )


def _strange_and_four(
    omegas: Sequence[float] = OMEGAS, record: int = 20_000, samples: int = _SAMPLES
) -> Evidence:
    rows = []
    for omega in omegas:
        found = _recurrences(omega, 0, samples, 0)["attractors"]
        row = {
            "panel": _PANELS[omega],
            "omega": omega,
            "periods": [each["period"] for each in found],
            "exponent": None,
            "error": None,
        }
        on_set = [each["point"] for each in found if not each["period"]]
        if on_set:
            row["exponent"], row["error"] = largest_exponent(
                oscillator(omega), on_set[0], transient=100, record=record
            )
        rows.append(row)
    return {"record": record, "rows": rows}


def _judge_strange_and_four(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    strange = [
        0 in row["periods"] and bool(row["exponent"] > _ERRORS * row["error"]) for row in rows
    ]
    both = [chaos and 4 in row["periods"] for chaos, row in zip(strange, rows, strict=True)]
    where = ", ".join(row["panel"] for row, here in zip(rows, both, strict=True) if here)
    listed = "; ".join(
        f"({row['panel']}) periods {', '.join(str(n) for n in row['periods'] if n) or 'none'},"
        + (f" exponent per period {_law(row, 4)}" if 0 in row["periods"] else " no other motion")
        for row in rows
    )
    text = (
        f"a strange attractor in {sum(strange)} of {len(rows)} panels, with period four in:"
        f" {where or 'none'}; {listed}. The text names no panel: it says that both exist"
    )
    return Finding(any(both), text)


def _boundaries(
    omegas: Sequence[float] = OMEGAS,
    cells: int = 96,
    starts: int = 50,
    distances: Sequence[float] = DISTANCES,
) -> Evidence:
    rows = [
        {
            "panel": _PANELS[omega],
            "omega": omega,
            "grid": exponent_on_grid(omega, cells),
            "pairs": exponents_of_pairs(omega, starts, distances),
        }
        for omega in omegas
    ]
    return {"rows": rows}


def _judge_boundaries(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    measured = [each for row in rows for each in (row["grid"], row["pairs"][0])]
    below = [
        each["exponent"] is not None and each["exponent"] + _ERRORS * each["error"] < 1.0
        for each in measured
    ]
    listed = "; ".join(
        f"({row['panel']}) {_law(row['grid'])} near period {row['grid']['period']},"
        f" {_law(row['pairs'][0])} over the section, one basin against the rest: "
        + ", ".join(
            f"{'period ' + str(each['basin']) if each['basin'] else 'chaos'} {_law(each)}"
            for each in row["pairs"][1:]
        )
        for row in rows
    )
    text = (
        f"uncertainty exponents, 1 is a smooth boundary: {listed}; judged by panel, as the chapter"
        " speaks of cases, not by single basins"
    )
    return Finding(all(below), text)


def _law(found: Evidence, digits: int = 2) -> str:
    if found["exponent"] is None:
        return "too few pairs"
    return f"{found['exponent']:.{digits}f} +- {found['error']:.{digits}f}"
