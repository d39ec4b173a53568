"""Claims on the bifurcations of Fig. 36: where they are, what they lead to, what preload does.

Section 4.3 begins at zero for every eta; a change between two columns of such a diagram may be a
change of basin, with the orbit stable beyond it. So the orbits themselves are followed too.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from nonsmooth import regime
from nonsmooth_chapter.judgement import Check, Evidence, Finding, agrees
from nonsmooth_chapter.rotor.coexistence import DROPPED, STARTS, coexisting
from nonsmooth_chapter.rotor.data import set_a
from nonsmooth_chapter.rotor.diagrams import PRINTED_36
from nonsmooth_chapter.rotor.orbits import orbit_multipliers
from nonsmooth_chapter.rotor.speed_bifurcations import branch_end, orbit_at, transition
from nonsmooth_chapter.rotor.speed_sweeps import PROTOCOLS

__all__ = ["CHECKS"]

_QUASI = "3.107"
_JUST_ABOVE = 0.005  # of eta
_NEAR = 11  # columns around it
# Period below and above as printed, and the orbit that is followed: period, first and last eta.
_CHANGES = {
    0: (1, None, (1, 2.05, 2.6)),
    1: (4, 2, (2, 3.0, 2.4)),
    2: (2, 4, (2, 3.0, 4.8)),
}
_BRACKET = 1e-3  # of eta, one unit of the last printed digit
_BIFURCATIONS = ("flip", "fold", "torus", "halving")
_NAMES = {0: "end of period one", 1: "four to two", 2: "end of period two"}


@lru_cache(maxsize=8)
def _change(delta: float, number: int) -> Evidence:
    """One of the three changes that Fig. 36 marks, by every route."""
    before, after, (period, begin, to) = _CHANGES[number]
    printed = PRINTED_36[delta][number]
    wanted = after if number == 1 else None  # what period two ends in is asked, not given
    rows = [transition(delta, before, wanted, printed, start) for start in PROTOCOLS]
    return {
        "delta": delta,
        "printed": printed,
        "before": before,
        "after": after,
        "by_protocol": rows,
        "branch": branch_end(delta, period, begin, to) | {"period": period},
    }


def _judge_change(evidence: Evidence) -> Finding:
    """The protocol that section 4.3 states decides: every column from zero.

    Columns that bracket the change less closely than the printed digits give way to the orbit,
    where that bifurcates between them.
    """
    stated, branch = evidence["by_protocol"][0], evidence["branch"]
    if stated["last"] is None:
        return Finding(False, f"no such change from zero; {_branch(branch)}")
    place, means = _place(stated, branch)
    true = None if place is None else agrees(place, evidence["printed"])
    if evidence["after"] is not None and stated["becomes"] != evidence["after"]:
        true = False
    listed = "; ".join(
        f"{row['start']} none"
        if row["last"] is None
        else f"{row['start']} period {evidence['before']} to {row['last']:.5g}, then"
        f" {row['becomes'] or 'no period'} from {row['first']:.5g}"
        for row in evidence["by_protocol"]
    )
    off = "" if place is None else f" off by {place - float(evidence['printed']):+.4f}"
    again = ", ".join(
        f"{each['last']:.5g} (then {each['becomes'] or 'no period'})" for each in stated["others"]
    )
    return Finding(
        true,
        f"printed {evidence['printed']}, {means}{off}: {listed}"
        + f"; period {evidence['before']} comes again and ends at {again}" * bool(again)
        + f"; {_branch(branch)}",
    )


def _place(stated: Evidence, branch: Evidence) -> tuple[float | None, str]:
    """Where a change is, and what tells so."""
    low, high = stated["last"], stated["first"]
    if high - low <= _BRACKET:
        return 0.5 * (low + high), "from zero"
    if branch["kind"] in _BIFURCATIONS and low <= branch["eta"] <= high:
        return branch["eta"], f"by the orbit, as columns from {low:.5g} to {high:.5g} tell no more,"
    return None, f"columns from {low:.5g} to {high:.5g} tell no more, nor does the orbit"


def _branch(branch: Evidence) -> str:
    kinds = {
        "flip": "flips", "fold": "folds", "torus": "turns into a torus", "jump": "jumps",
        "none": "is stable", "halving": "merges with half its period", "lost": "is lost",
    }  # fmt: skip
    return (
        f"the orbit of period {branch['period']}, followed, {kinds.get(branch['kind'], 'is none')}"
        f" at {branch['eta']:.6f} (multiplier {branch['multiplier'][0]:.4f})"
    )


def _quasi(delta: float, eta: str = _QUASI, reach: float = 0.1) -> Evidence:
    """Multipliers of period two near an eta, and other motions there."""
    value = float(eta)
    orbit = orbit_at(delta, 2, 3.0)
    ends = [branch_end(delta, 2, 3.0, value + side * reach) | {"period": 2} for side in (-1, 1)]
    there = orbit_at(delta, 2, value)
    sizes = [] if there is None else orbit_multipliers(there)
    others = coexisting(set_a(delta, value))
    # where following an orbit jumps, columns of their own tell what the neighbourhood is like
    near = []
    for each in np.linspace(value - reach, value + reach, _NEAR):
        orbit_there = orbit_at(delta, 2, float(each))
        largest = None if orbit_there is None else abs(orbit_multipliers(orbit_there)[0])
        near.append({"eta": float(each), "largest": largest})
    return {
        "delta": delta,
        "eta": eta,
        "ends": ends,
        "near": near,
        "found": orbit is not None,
        "multipliers": [[m.real, m.imag] for m in sizes],
        "largest": abs(sizes[0]) if sizes else None,
        "motions": [_shown(row) for row in others],
    }


def _shown(row: Evidence) -> Evidence:
    kept = ("period", "share", "from_zero", "exponent", "error", "chaotic")
    return {name: row[name] for name in kept if name in row}


def _torus_near(evidence: Evidence) -> bool:
    torus = any(
        end["kind"] == "torus" and agrees(end["eta"], evidence["eta"], about=0.02)
        for end in evidence["ends"]
    )
    return torus or any(not row["period"] and not row["chaotic"] for row in evidence["motions"])


def _quasi_text(evidence: Evidence) -> str:
    motions = ", ".join(
        f"period {row['period']}" if row["period"] else f"none ({row['exponent']:.3f} per period)"
        for row in evidence["motions"]
    )
    size = evidence["largest"]
    size = "no orbit of period two from zero" if size is None else f"{size:.3f}"
    changes = [change for end in evidence["ends"] for change in end["changes"]]
    words = ", ".join(
        f"{each['kind']} at {each['eta']:.7g}, {each['detail'].split(';')[0]}" for each in changes
    )
    ends = ", ".join(f"{end['kind']} at {end['eta']:.4f}" for end in evidence["ends"])
    near = [row["largest"] for row in evidence["near"] if row["largest"] is not None]
    columns = f"{len(near)} of {len(evidence['near'])} columns" + (
        f", largest multipliers {min(near):.3f} to {max(near):.3f}" if near else ""
    )
    return (
        f"Delta {evidence['delta']:g}: largest multiplier of period two at {evidence['eta']}"
        f" {size}; followed 0.1 to either side: {ends} (none: stable to there); from zero 0.1 to"
        f" either side period two in {columns}; motions from"
        f" {STARTS + 1} starts at {evidence['eta']}: {motions}"
        + (
            f"; the word changes, and the orbit stays stable: {words} (s1, s2: the ring at its"
            " preload)"
            if words
            else ""
        )
    )


def _judge_quasi(evidence: Evidence) -> Finding:
    return Finding(_torus_near(evidence), _quasi_text(evidence))


def _judge_no_quasi(evidence: Evidence) -> Finding:
    stable = all(row["largest"] is not None and row["largest"] < 1.0 for row in evidence["near"])
    true = evidence["found"] and stable and not _torus_near(evidence)
    return Finding(true, _quasi_text(evidence))


def _shifts() -> Evidence:
    rows = []
    for number, name in _NAMES.items():
        without, loaded = (_change(delta, number) for delta in PRINTED_36)
        for k, start in enumerate(PROTOCOLS):
            both = [each["by_protocol"][k] for each in (without, loaded)]
            ends = [each["last"] for each in both]
            shift = None if None in ends else ends[1] - ends[0]
            kinds = [each["becomes"] for each in both]
            rows.append({"change": name, "route": start, "shift": shift, "kinds": kinds})
        shift = loaded["branch"]["eta"] - without["branch"]["eta"]
        kinds = [each["branch"]["kind"] for each in (without, loaded)]
        rows.append({"change": name, "route": "orbit", "shift": shift, "kinds": kinds})
    return {"rows": rows}


def _judge_shifts(evidence: Evidence) -> Finding:
    """What one period turns into must be the same with preload and without, by each route."""
    rows = [row for row in evidence["rows"] if row["shift"] is not None]
    alike = [row for row in rows if row["kinds"][0] == row["kinds"][1]]
    listed = "; ".join(
        f"{name}: "
        + ", ".join(
            f"{row['route']} {row['shift']:+.4f}"
            + ("" if row in alike else f" (unlike: to {row['kinds'][0]} and {row['kinds'][1]})")
            for row in rows
            if row["change"] == name
        )
        for name in _NAMES.values()
    )
    compared = {row["change"] for row in alike} == set(_NAMES.values())
    # a change that no route compares with its like is left open
    true = all(row["shift"] > 0.0 for row in alike)
    return Finding(
        None if true and not compared else true,
        f"shift of eta with preload: {listed} (0: no period); like with like on"
        f" {len(alike)} of {len(evidence['rows'])} routes",
    )


def _beyond(
    delta: float, steps: Sequence[float] = (0.001, 0.002, 0.003, 0.005, 0.01, 0.02, 0.03)
) -> Evidence:
    """Motions from zero just above the end of period one, and the orbit followed."""
    change = _change(delta, 0)
    stated = change["by_protocol"][0]
    end = stated["first"]
    rows = []
    for step in steps:
        found = regime(set_a(delta, end + step), transient=1000)
        rows.append(
            {
                "eta": end + step,
                "regime": found["regime"].item(),
                "period": int(found["period"]),
                "message": found.attrs["message"],
            }
        )
    return {
        "delta": delta, "end": end, "rows": rows, "branch": change["branch"],
        "again": stated["others"],
    }  # fmt: skip


def _beyond_text(evidence: Evidence) -> str:
    rows = ", ".join(
        f"{row['eta']:.4g} {row['regime']}" + (f" {row['period']}" if row["period"] else "")
        for row in evidence["rows"]
    )
    again = ", ".join(
        f"from {each['from']:.5g} to {each['last']:.5g}, then period {each['becomes'] or 'none'}"
        for each in evidence["again"]
    )
    return (
        f"from zero the first column without period one is {evidence['end']:.5g}; above it {rows}"
        f" ({evidence['rows'][0]['message']})"
        + f"; period one comes again {again}" * bool(again)
        + f"; {_branch(evidence['branch'])}"
    )


def _judge_three(evidence: Evidence) -> Finding:
    return Finding(all(row["period"] == 3 for row in evidence["rows"]), _beyond_text(evidence))


def _judge_to_quasi(evidence: Evidence) -> Finding:
    near = [row for row in evidence["rows"] if row["eta"] - evidence["end"] <= _JUST_ABOVE]
    true = all(row["regime"] == "quasi-periodic" for row in near)
    return Finding(true, _beyond_text(evidence))


def _printed_order() -> Evidence:
    sections = {0.0: "2.223", 0.1: "2.181"}
    return {
        "rows": [
            {"panel": panel, "section": sections[delta], "end": PRINTED_36[delta][0]}
            for panel, delta in zip("ab", PRINTED_36, strict=True)
        ]
    }


def _judge_order(evidence: Evidence) -> Finding:
    beyond = [float(row["section"]) > float(row["end"]) for row in evidence["rows"]]
    listed = ", ".join(
        f"37({row['panel']}) at {row['section']}, period one ends at {row['end']}:"
        f" {'beyond' if each else 'before'}"
        for row, each in zip(evidence["rows"], beyond, strict=True)
    )
    return Finding(all(beyond), f"{listed}; exchanged, both would lie beyond")


_SWEPT = (
    "set A, eta 2 to 5; the stated protocol, every column from zero (phi_0, which is not"
    " printed, too), decides: 600 columns, 300"
    " periods dropped, 150 kept, then 20 between the two with 3000 dropped; beside it followed up"
    " and down in 300 columns, and the orbit followed with its multipliers, which decides where"
    " the columns bracket a change less closely than that; one unit of the last printed digit"
)


def _change_check(claim: str, delta: float, number: int) -> Check:
    return Check(claim, _SWEPT, lambda: _change(delta, number), _judge_change)


CHECKS = (
    *(_change_check(f"R{16 + k}", 0.0, k) for k in range(3)),
    *(_change_check(f"R{19 + k}", 0.1, k) for k in range(3)),
    Check(
        "R22",
        "Delta .1; multipliers of period two at 3.107 and followed from 3.0 to 0.1 on either side"
        f" of it; motions from {STARTS} random starts and zero, up to {DROPPED} periods"
        " dropped; about: 2 %",
        lambda: _quasi(0.1),
        _judge_quasi,
    ),
    Check("R23", "the same with Delta 0; true when the orbit is there without such a change",
          lambda: _quasi(0.0), _judge_no_quasi),
    Check("R24", _SWEPT + "; like with like, by each route: the same period below and the same"
          " motion above; every route that compares so decides", _shifts, _judge_shifts),
    Check("R25", "regime from zero at seven places up to 0.03 above the end of period one that lies"
          " nearest to the printed one, 1000 periods dropped; true with period three at all of"
          " them", lambda: _beyond(0.0), _judge_three),
    Check("R26", f"the same with Delta .1; true where all up to {_JUST_ABOVE:g} above the end are"
          " quasi-periodic", lambda: _beyond(0.1), _judge_to_quasi),
    Check("R29", "printed numbers", _printed_order, _judge_order),
)  # fmt: skip
