"""Claims on the rotor over its speed: bifurcations and sections."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from scipy.spatial import cKDTree

from nonsmooth import bifurcation_diagram, correlation_dimension, regime, stroboscopic_map
from nonsmooth_chapter.judgement import Evidence, Finding, agrees
from nonsmooth_chapter.rotor.diagram_figures import PANELS, PRINTED_36
from nonsmooth_chapter.rotor.motions import STARTS, coexisting, orbit_multipliers, set_a
from nonsmooth_chapter.rotor.speed_sweeps import (
    PROTOCOLS,
    branch_end,
    even_values,
    orbit_at,
    transition,
)

# Claims on the bifurcations of Fig. 36: where they are, what they lead to, what preload does.
#
# Section 4.3 begins at zero for every eta; a change between two columns of such a diagram may be a
# change of basin, with the orbit stable beyond it. So the orbits themselves are followed too.

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


# Claims on the sections of Fig. 37 and on settling: regimes, coexistence, shape of attractors.

_EXCHANGED = {"a": 2.181, "b": 2.223}
_APART = 3.0  # distance of two attractors beside that of two samples of one
_SETTLED = 1e-3  # of the displacement: less than a point of the picture


def _motion(delta: float, eta: float) -> Evidence:
    found = regime(set_a(delta, eta), transient=1000)
    length = float(set_a(delta, eta).period_value or 0.0)
    row: Evidence = {
        "delta": delta,
        "eta": eta,
        "regime": found["regime"].item(),
        "period": int(found["period"]),
        "message": found.attrs["message"],
        "others": [
            {name: each[name] for name in ("period", "share", "from_zero")}
            for each in coexisting(set_a(delta, eta))
        ],
    }
    if not row["period"]:
        row |= {
            "exponent": float(found["exponent"]) * length,
            "error": float(found["exponent_error"]) * length,
        }
    return row


def _panel(panel: str) -> Evidence:
    delta, eta = PANELS[panel]
    rows = [_motion(delta, eta)]
    if panel in _EXCHANGED:
        rows.append(_motion(delta, _EXCHANGED[panel]))
    return {"panel": panel, "rows": rows}


def _text(evidence: Evidence) -> str:
    parts = []
    for row in evidence["rows"]:
        others = ", ".join(
            f"{'period ' + str(each['period']) if each['period'] else 'no period'}"
            f" ({each['share']:.0%})"
            for each in row["others"]
        )
        part = f"eta {row['eta']:g}: {row['regime']}"
        part += f", period {row['period']}" if row["period"] else ""
        if "exponent" in row:
            part += f", exponent per period {row['exponent']:.3f} +- {row['error']:.3f}"
        parts.append(f"{part} from zero; {STARTS + 1} starts lead to {others}")
    tail = "; the second eta is that printed for the other panel" if len(parts) > 1 else ""
    return f"Delta {evidence['rows'][0]['delta']:g}: " + "; ".join(parts) + tail


def _judge_three_section(evidence: Evidence) -> Finding:
    return Finding(evidence["rows"][0]["period"] == 3, _text(evidence))


def _judge_quasi_section(evidence: Evidence) -> Finding:
    return Finding(evidence["rows"][0]["regime"] == "quasi-periodic", _text(evidence))


def _judge_chaos(evidence: Evidence) -> Finding:
    row = evidence["rows"][0]
    chaos = row["regime"] == "chaotic" and row["exponent"] > 3.0 * row["error"]
    return Finding(bool(chaos), _text(evidence))


def _structure(eta: float = 2.442, record: int = 6000) -> Evidence:
    """Distances between two samples of each attractor, and between the attractors."""
    clouds, dimensions = {}, []
    for delta in (0.0, 0.1):
        found = stroboscopic_map(set_a(delta, eta), transient=1000, record=2 * record)
        points = np.stack([found[name].values for name in ("x", "y", "vx", "vy")], axis=1)
        clouds[delta] = (points[:record], points[record:])
        fit = correlation_dimension(found, states=["x", "y", "vx", "vy"])
        dimensions.append([float(fit["correlation_dimension"]), float(fit["standard_error"])])
    size = float(np.ptp(clouds[0.0][0], axis=0).max())
    own = [_mean_distance(*pair) / size for pair in clouds.values()]
    across = _mean_distance(clouds[0.0][0], clouds[0.1][0]) / size
    return {"eta": eta, "own": own, "across": across, "dimensions": dimensions}


def _mean_distance(one: np.ndarray, other: np.ndarray) -> float:
    """Mean distance from points of each set to the nearest of the other, the larger of the two."""
    ways = ((one, other), (other, one))
    return max(float(cKDTree(b).query(a)[0].mean()) for a, b in ways)


def _judge_structure(evidence: Evidence) -> Finding:
    own, across = max(evidence["own"]), evidence["across"]
    dimensions = ", ".join(f"{d:.2f} +- {error:.2f}" for d, error in evidence["dimensions"])
    text = (
        f"mean distance between the attractors {across:.2%} of their size, between two samples of"
        f" one {own:.2%} at most; correlation dimensions without and with preload {dimensions};"
        f" changed means {_APART:g} times as far apart"
    )
    return Finding(bool(across > _APART * own), text)


def _settling(
    columns: int = 100, dropped: int = 300, record: int = 150, later: int = 2500
) -> Evidence:
    """Which periodic columns still move, or have not found their motion, after the transient."""
    rows = []
    for delta in (0.0, 0.1):
        etas = even_values(2.0, 5.0, columns)
        first, last = (
            bifurcation_diagram(set_a(delta), "eta", etas, transient=n, record=record).isel(lane=0)
            for n in (dropped, later)
        )
        periodic = last["period"].values > 0
        early, late = first["x"].values[periodic], last["x"].values[periodic]
        apart = np.array(
            [np.abs(a[:, None] - b).min(axis=1).max() for a, b in zip(early, late, strict=True)]
        )
        rows.append(
            {
                "delta": delta,
                "columns": len(etas),
                "periodic": int(periodic.sum()),
                "unsettled": int(np.sum(apart > _SETTLED)),
                "worst": float(apart.max()),
                "where": last["parameter"].values[periodic][apart > _SETTLED].tolist(),
            }
        )
    return {"dropped": dropped, "later": later, "rows": rows}


def _judge_settling(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    listed = "; ".join(
        f"Delta {row['delta']:g}: {row['unsettled']} of {row['columns']} columns"
        f" ({row['periodic']} periodic in the end) show points off their final motion, by up to"
        f" {row['worst']:.2g}" + (f", at eta {', '.join(f'{e:.3g}' for e in row['where'])}"
                                  if row["where"] else "")
        for row in rows
    )  # fmt: skip
    return Finding(all(not row["unsettled"] for row in rows), listed)
