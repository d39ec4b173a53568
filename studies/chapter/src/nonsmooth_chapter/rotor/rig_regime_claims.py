"""Claims at the end of section 4.4: contacts, forces and amplitudes over the rig's speed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.stats import spearmanr

from nonsmooth_chapter.judgement import Check, Evidence, Finding
from nonsmooth_chapter.rotor.rig_sweeps import speed_scan
from nonsmooth_chapter.rotor.speed_sweeps import CHAOTIC

__all__ = ["CHECKS"]

_FIGURES = ("40", "41")


def _scans() -> Evidence:
    return {"rows": {figure: speed_scan(figure) for figure in _FIGURES}}


def _each(evidence: Evidence, judge: Callable[[list[Evidence]], tuple[bool, str]]) -> Finding:
    parts = {figure: judge(rows) for figure, rows in evidence["rows"].items()}
    listed = "; ".join(f"Fig. {figure} set: {text}" for figure, (_, text) in parts.items())
    return Finding(all(true for true, _ in parts.values()), listed)


def _low(rows: list[Evidence]) -> list[Evidence]:
    """Periodic speeds below the first one without a period."""
    first = next((k for k, row in enumerate(rows) if row["label"] <= 0), len(rows))
    return rows[:first]


def _high(rows: list[Evidence]) -> list[Evidence]:
    """Speeds above the last chaotic one."""
    chaos = [k for k, row in enumerate(rows) if row["label"] == CHAOTIC]
    return rows[chaos[-1] + 1 :] if chaos else []


def _contacts(rows: list[Evidence]) -> tuple[bool, str]:
    low = _low(rows)
    if not low:
        return False, f"no period at {rows[0]['speed']:.1f} Hz"
    true = all(row["contacts"] <= 1.0 for row in low)
    counts = sorted({round(row["contacts"], 2) for row in low})
    return true, (
        f"periodic from {low[0]['speed']:.1f} to {low[-1]['speed']:.1f} Hz with"
        f" {', '.join(f'{n:g}' for n in counts)} contacts per period"
    )


def _rank(rows: list[Evidence], name: str) -> float:
    """Rank correlation of the contact force with something else; 0 where one does not change."""
    pairs = np.array([[row[name], row["force"]] for row in rows])
    if np.any(np.ptp(pairs, axis=0) == 0.0):
        return 0.0
    return float(spearmanr(*pairs.T).statistic)


def _forces(rows: list[Evidence]) -> tuple[bool, str]:
    chaos = [k for k, row in enumerate(rows) if row["label"] == CHAOTIC]
    if not chaos:
        return False, "no chaos"
    rising = rows[: chaos[-1] + 1]
    rank, grows = (_rank(rising, name) for name in ("speed", "amplitude"))
    below = [row["force"] for row in _low(rows)]
    strong = [rows[k]["force"] for k in chaos]
    stronger = bool(below) and float(np.median(strong)) > max(below)
    text = (
        f"up to the last chaos rank correlation of the force with speed {rank:.2f}, with amplitude"
        f" {grows:.2f}; largest force in periodic motion at low speed"
        f" {max(below, default=0.0):.3g} N, median in chaos {np.median(strong):.3g} N"
    )
    return bool(rank > 0.5 and grows > 0.5 and stronger), text


def _widths(rows: list[Evidence]) -> tuple[bool, str]:
    high = _high(rows)
    chaos = [row for row in rows if row["label"] == CHAOTIC]
    if not high or not chaos:
        return False, "no speeds above chaos"
    periodic = sum(row["label"] > 0 for row in high) / len(high)
    wide = high[-1]["speed"] - high[0]["speed"]
    span = chaos[-1]["speed"] - chaos[0]["speed"]
    text = (
        f"above chaos {wide:.1f} Hz up to {high[-1]['speed']:.0f} Hz, {periodic:.0%} periodic;"
        f" chaos spans {span:.1f} Hz"
    )
    return bool(periodic > 0.9 and wide > 0.25 * (rows[-1]["speed"] - rows[0]["speed"])), text


def _amplitudes(rows: list[Evidence]) -> tuple[bool, str]:
    high = [row["amplitude"] for row in _high(rows) if row["label"] > 0]
    chaos = [row["amplitude"] for row in rows if row["label"] == CHAOTIC]
    if not high or not chaos:
        return False, "no speeds above chaos"
    text = (
        f"amplitude above chaos {min(high):.3f} to {max(high):.3f} mm, in chaos {min(chaos):.3f} to"
        f" {max(chaos):.3f} mm"
    )
    return max(high) < float(np.median(chaos)), text


_PROTOCOL = "diagrams as for R38, followed up; every third column run on for 48 periods; {}"

CHECKS = (
    Check("R50", _PROTOCOL.format("from 7 Hz to the first speed without a period"), _scans,
          lambda evidence: _each(evidence, _contacts)),
    Check("R51", _PROTOCOL.format("rank correlations above 0.5, and chaos with larger forces than"
                                  " any periodic motion at low speed"), _scans,
          lambda evidence: _each(evidence, _forces)),
    Check("R52", _PROTOCOL.format("above the last chaos, wide: a quarter of the diagram, 90 % of"
                                  " the columns periodic"), _scans,
          lambda evidence: _each(evidence, _widths)),
    Check("R53", _PROTOCOL.format("half the widest range of x or y; every periodic motion above the"
                                  " last chaos against the median in chaos"), _scans,
          lambda evidence: _each(evidence, _amplitudes)),
)  # fmt: skip
