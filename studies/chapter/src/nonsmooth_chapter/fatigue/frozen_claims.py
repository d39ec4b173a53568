"""Claim that a crack of fixed length answers as a growing one does when it has that length."""

from __future__ import annotations

from collections import Counter
from functools import lru_cache

import numpy as np

from nonsmooth_chapter.fatigue.beam_data import beam, tau_at
from nonsmooth_chapter.fatigue.crack_motions import BOX_STARTS, motions, motions_from
from nonsmooth_chapter.fatigue.growing import Growth
from nonsmooth_chapter.fatigue.growth_history import history
from nonsmooth_chapter.judgement import Check, Evidence, Finding

__all__ = ["CHECKS", "growing_label", "stations"]

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


CHECKS = (
    Check(
        "F57",
        f"s = 1, d = 0; lengths from {_FIRST:g} to {_LAST:g} mm in steps of {_STEP:g}; growing"
        " crack from rest at 5 mm, frozen per period, by local labels; fixed crack from rest, and"
        f" beside it all attractors of {BOX_STARTS} starts; true when growing and fixed crack have"
        " one label at every length",
        stations,
        _judge,
    ),
)
