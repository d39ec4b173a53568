"""Claims on the motion of the ring, Fig. 38: where its velocity jumps, how far it goes."""

from __future__ import annotations

import numpy as np

from nonsmooth_chapter.judgement import Check, Evidence, Finding
from nonsmooth_chapter.rotor.ring_motion import PANELS, panel_system, ring_jumps, ring_run

__all__ = ["CHECKS"]

_HERE = 1e-3  # of the gap: a ring within it of a place is there
_JUMPS = 1e-4  # of the velocity's range, above which it jumps


def _panel(panel: str, periods: int = 24) -> Evidence:
    run = ring_run(panel_system(panel), periods=periods)
    name, delta, eta = PANELS[panel]
    reach = float(np.ptp(run["ring_vx"].values))
    jumps = ring_jumps(run)
    big = [row for row in jumps if abs(row["jump"]) > _JUMPS * reach]
    at_zero = [row for row in big if abs(row["sx"]) <= _HERE]
    beyond = [row for row in big if delta and abs(abs(row["sx"]) - delta) <= _HERE]
    crossed = [
        row for row in jumps if row["name"] == "spring" and abs(abs(row["sx"]) - delta) <= _HERE
    ]
    return {
        "panel": panel, "set": name, "delta": delta, "eta": eta, "range": reach,
        "hits": sum(row["name"] == "contact" for row in jumps),
        "hits_with_jump": sum(row["name"] == "contact" for row in at_zero),
        "at_zero": len(at_zero), "at_preload": len(beyond), "crossings_of_preload": len(crossed),
        "elsewhere": len(big) - len(at_zero) - len(beyond),
        "largest_at_zero": max((abs(row["jump"]) for row in at_zero), default=0.0),
        "largest_at_preload": max((abs(row["jump"]) for row in beyond), default=0.0),
        "extreme": float(np.abs(run["sx"].values).max()),
        "begun_anew": int(run.attrs["begun_anew"]),
    }  # fmt: skip


def _panels(letters: str) -> Evidence:
    return {"rows": [_panel(letter) for letter in letters]}


def _text(row: Evidence) -> str:
    return (
        f"({row['panel']}) set {row['set']}, Delta {row['delta']:g}: {row['hits_with_jump']} of"
        f" {row['hits']} hits with a jump at x_s = 0 (up to {row['largest_at_zero']:.3g}),"
        f" {row['at_preload']} jumps at |x_s| = Delta_x in {row['crossings_of_preload']} crossings"
        f" (up to {row['largest_at_preload']:.3g}), {row['elsewhere']} elsewhere"
    )


def _judge_zero(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    true = all(row["hits"] and row["hits_with_jump"] == row["hits"] for row in rows)
    return Finding(bool(true), "; ".join(_text(row) for row in rows))


def _judge_preload(evidence: Evidence) -> Finding:
    (row,) = evidence["rows"]
    true = row["crossings_of_preload"] and row["at_preload"] == row["crossings_of_preload"]
    return Finding(bool(true), _text(row))


def _judge_amplitude(evidence: Evidence) -> Finding:
    without, loaded = (row["extreme"] for row in evidence["rows"])
    return Finding(
        loaded < without, f"largest |x_s| {without:.4f} without and {loaded:.4f} with preload"
    )


_FROM_ZERO = (
    "from zero, 1000 periods dropped, 24 kept; where rounding ends the run it is begun anew a"
    " billionth aside"
)
_PROTOCOL = (
    f"{_FROM_ZERO}; velocities 1e-8 before and after every event; a jump"
    " is more than 1e-4 of the velocity's range"
)

CHECKS = (
    Check("R33", _PROTOCOL, lambda: _panels("ac"), _judge_zero),
    Check("R34", _PROTOCOL, lambda: _panels("b"), _judge_preload),
    Check("R35", _PROTOCOL, lambda: _panels("d"), _judge_preload),
    Check("R36", _FROM_ZERO, lambda: _panels("ab"),
          _judge_amplitude),
    Check("R37", "the same", lambda: _panels("cd"), _judge_amplitude),
)  # fmt: skip
