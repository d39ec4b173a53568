"""Claims on the diagrams of the rig, Figs. 40 and 41, and on motions at single speeds.

Section 4.4 follows the motion from one speed to the next; the direction is not printed. Rising
speed decides here, as both diagrams are said to begin at 7 Hz; the others stand beside it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth.chapter.judgement import Check, Evidence, Finding, agrees
from nonsmooth.chapter.rotor.coexistence import DROPPED, STARTS, coexisting
from nonsmooth.chapter.rotor.data import DELTA_40, DELTA_41, EPS_40, EPS_41, rig
from nonsmooth.chapter.rotor.orbits import follow_orbit, orbit_near
from nonsmooth.chapter.rotor.rig_sweeps import (
    chaotic_span,
    followed_motion,
    machine_of,
    rig_sweeps,
)
from nonsmooth.chapter.rotor.speed_sweeps import CHAOTIC, PROTOCOLS, last_strobe

__all__ = ["CHECKS"]

_STATED = "follow up"
_WIDE = 0.5  # share of the columns
_PRINTED_FLIP, _PRINTED_CRISIS = "14.74", "26.1"
_BEFORE = 13.1  # Hz: period one of Fig. 42, below the doubling


def _summary(figure: str) -> list[Evidence]:
    hertz = machine_of(figure).natural_frequency
    rows = []
    for start in PROTOCOLS:
        sweep = rig_sweeps(figure)[start]
        span = chaotic_span(sweep)
        inside = sweep.labels[span[0] : span[1] + 1] if span else np.array([], int)
        rows.append(
            {
                "start": start,
                "chaotic_share": sweep.share(CHAOTIC),
                "from": float(hertz * sweep.eta[span[0]]) if span else None,
                "to": float(hertz * sweep.eta[span[1]]) if span else None,
                "periods_between": sorted({int(n) for n in inside if n > 0}),
                "step": float(hertz * sweep.step),
            }
        )
    return rows


def _forty() -> Evidence:
    return {"rows": _summary("40")}


def _judge_forty(evidence: Evidence) -> Finding:
    true = {
        row["start"]: bool(
            row["chaotic_share"] > _WIDE and {1, 2, 3} <= set(row["periods_between"])
        )
        for row in evidence["rows"]
    }
    listed = "; ".join(
        f"{row['start']}: {row['chaotic_share']:.0%} of the columns chaotic"
        + (
            f" between {row['from']:.1f} and {row['to']:.1f} Hz, periods"
            f" {', '.join(map(str, row['periods_between'])) or 'none'} among them"
            if row["from"] is not None else ""
        )
        for row in evidence["rows"]
    )  # fmt: skip
    return Finding(true[_STATED], f"{listed}; wide means more than half of 7 to 50 Hz")


def _motion(figure: str, speed: float) -> Evidence:
    return {"rows": [followed_motion(figure, speed, start) for start in PROTOCOLS]}


def _motion_text(evidence: Evidence) -> str:
    parts = []
    for row in evidence["rows"]:
        motion = f"period {row['period']}" if row["period"] else row["regime"]
        part = f"{row['start']} {motion}"
        if "exponent" in row and np.isfinite(row["exponent"]):
            part += f" ({row['exponent']:.3f} +- {row['error']:.3f} per period)"
        parts.append(part)
    motions = ", ".join(
        f"{_name(each)} ({each['share']:.0%})" for each in evidence["rows"][0]["motions"]
    )
    return (
        f"{evidence['rows'][0]['speed']:g} Hz: {', '.join(parts)}; {STARTS + 1} starts lead to"
        f" {motions}"
    )


def _name(motion: Evidence) -> str:
    if motion["period"]:
        return f"period {motion['period']}"
    return "chaos" if motion["chaotic"] else "no period"


def _stated(evidence: Evidence) -> Evidence:
    return next(row for row in evidence["rows"] if row["start"] == _STATED)


def _judge_chaotic(evidence: Evidence) -> Finding:
    row = _stated(evidence)
    true = row["regime"] == "chaotic" and row["exponent"] > 3.0 * row["error"]
    return Finding(bool(true), _motion_text(evidence))


def _judge_periodic(evidence: Evidence) -> Finding:
    return Finding(_stated(evidence)["period"] > 0, _motion_text(evidence))


def _doublings(eps: tuple[float, float] = EPS_41, delta: float = DELTA_41) -> Evidence:
    """Ends of period one and of the orbits that its doublings give, as the speed rises."""
    machine = rig(eps, delta, _BEFORE)
    hertz, period, speed = machine.natural_frequency, 1, _BEFORE
    ends: list[Evidence] = []
    while period <= 8:
        system = rig(eps, delta, speed).system()
        orbit = orbit_near(system, last_strobe(system, 3000), period)
        if orbit is None:
            break
        end = follow_orbit(system, orbit, 50.0 / hertz)
        ends.append(
            {"period": period, "speed": hertz * end["eta"], "kind": end["kind"],
             "multiplier": end["multiplier"]}
        )  # fmt: skip
        if end["kind"] != "flip":
            break
        period, speed = 2 * period, hertz * end["eta"] + 0.02
    return {"eps": list(eps), "delta": delta, "ends": ends}


def _ends_text(ends: list[Evidence]) -> str:
    return ", ".join(
        f"period {end['period']} {end['kind']} at {end['speed']:.3f} Hz" for end in ends
    )


def _route() -> Evidence:
    sweeps = rig_sweeps("41")
    hertz = machine_of("41").natural_frequency
    sequence: list[int] = []
    sweep = sweeps[_STATED]
    for column in np.flatnonzero(hertz * sweep.eta >= _BEFORE):
        label = int(sweep.labels[column])
        if not sequence or sequence[-1] != label:
            sequence.append(label)
    return _doublings() | {"sequence": sequence}


def _judge_route(evidence: Evidence) -> Finding:
    ends, sequence = evidence["ends"], evidence["sequence"]
    doubled = [end["period"] for end in ends if end["kind"] == "flip"]
    first = sequence.index(CHAOTIC) if CHAOTIC in sequence else len(sequence)
    before = sequence[:first]
    labels = " ".join(
        "chaos" if n == CHAOTIC else "unsettled" if n < 0 else str(n) for n in sequence
    )
    true = len(doubled) >= 2 and doubled[0] == 1 and first < len(sequence) and 2 in before
    text = f"orbits: {_ends_text(ends)}; labels from {_BEFORE:g} Hz, followed up: {labels}"
    return Finding(bool(true), text + "; a cascade: two doublings at least, and chaos")


def _judge_flip(evidence: Evidence) -> Finding:
    end = evidence["ends"][0]
    true = end["kind"] == "flip" and agrees(end["speed"], _PRINTED_FLIP, about=0.02)
    return Finding(
        bool(true), f"printed {_PRINTED_FLIP} Hz, about: 2 %; {_ends_text(evidence['ends'])}"
    )


def _crisis() -> Evidence:
    rows = _summary("41")
    motions = []
    for row in rows:
        if row["to"] is None or row["start"] != _STATED:
            continue
        for side in (-1.0, 1.0):
            speed = row["to"] + side * row["step"]
            found = coexisting(rig(EPS_41, DELTA_41, speed).system())
            motions.append(
                {"start": row["start"], "speed": speed,
                 "periods": [each["period"] for each in found]}
            )  # fmt: skip
    return {"rows": rows, "motions": motions}


def _judge_crisis(evidence: Evidence) -> Finding:
    stated = next(row for row in evidence["rows"] if row["start"] == _STATED)
    listed = ", ".join(
        f"{row['start']} {row['to']:.2f} Hz" if row["to"] else f"{row['start']} no chaos"
        for row in evidence["rows"]
    )
    beside = "; ".join(
        f"at {each['speed']:.2f} Hz periods {', '.join(map(str, each['periods']))} (0: none)"
        for each in evidence["motions"] if each["start"] == _STATED
    )  # fmt: skip
    true = stated["to"] is not None and agrees(
        stated["to"], _PRINTED_CRISIS, about=0.02, step=stated["step"]
    )
    text = (
        f"last chaotic column up to 30 Hz: {listed}; printed {_PRINTED_CRISIS} Hz, about: 2 %;"
        f" beside the end {STARTS + 1} starts lead to: {beside}; the meeting with an unstable orbit"
        " was not looked at, as the place decides"
    )
    return Finding(bool(true), text)


def _only_one(speeds: Sequence[float] = tuple(np.linspace(30.0, 50.0, 6))) -> Evidence:
    rows = [
        {"speed": float(speed), "periods": [
            each["period"] for each in coexisting(rig(EPS_41, DELTA_41, speed).system())
        ]}
        for speed in speeds
    ]  # fmt: skip
    return {"rows": rows}


def _judge_only_one(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    other = [row for row in rows if row["periods"] != [1]]
    listed = "; ".join(
        f"{row['speed']:g} Hz {', '.join(map(str, row['periods']))}" for row in other
    )
    return Finding(
        not other,
        f"period one alone at {len(rows) - len(other)} of {len(rows)} speeds"
        + (f"; elsewhere (0: no period): {listed}" if other else ""),
    )


def _changes() -> Evidence:
    sets = {
        "Fig. 40": (EPS_40, DELTA_40), "eccentricity of Fig. 41": (EPS_41, DELTA_40),
        "preload of Fig. 41": (EPS_40, DELTA_41), "Fig. 41": (EPS_41, DELTA_41),
    }  # fmt: skip
    return {"rows": [{"set": name, **_doublings(*values)} for name, values in sets.items()]}


def _judge_changes(evidence: Evidence) -> Finding:
    routes = [[end["kind"] for end in row["ends"]] for row in evidence["rows"]]
    listed = "; ".join(
        f"{row['set']}: {_ends_text(row['ends']) or 'no period one'}" for row in evidence["rows"]
    )
    # the claim: by eccentricity, so it must differ with the preload of either figure
    true = routes[0] != routes[1] and routes[2] != routes[3]
    return Finding(true, f"ends of period one from {_BEFORE:g} Hz upwards, and of its doublings: "
                   f"{listed}")  # fmt: skip


def _orbit() -> Evidence:
    return _motion("41", _BEFORE)


def _open_motion(evidence: Evidence) -> Finding:
    return Finding(None, _motion_text(evidence))


_SWEPT = (
    "columns 0.2 Hz apart from 7 Hz, from zero and followed up and down, 400 periods dropped, 100"
    " kept; chaos: no period and a largest exponent above 6 standard errors over 100 periods, or"
    " above 3 over 400;"
    " followed up decides"
)
_AT = (
    "regime begun where the nearest column of each diagram ended, 400 periods dropped; followed up"
    f" decides; {STARTS} random starts and zero, up to {DROPPED} periods dropped, beside it"
)

CHECKS = (
    Check("R38", _SWEPT, _forty, _judge_forty),
    Check("R39", _AT, lambda: _motion("40", 30.1), _judge_chaotic),
    Check("R40", _AT, lambda: _motion("40", 37.1), _judge_chaotic),
    Check("R41", _AT, lambda: {"rows": [*_motion("40", 30.1)["rows"]]}, _open_motion),
    Check("R42", _SWEPT + "; orbits followed from 13.1 Hz, with their multipliers", _route,
          _judge_route),
    Check("R43", "orbit of period one followed from 13.1 Hz to its flip", _doublings,
          _judge_flip),
    Check("R44", _SWEPT, _crisis, _judge_crisis),
    Check("R45", f"6 speeds from 30 to 50 Hz, {STARTS} random starts and zero, {DROPPED} periods"
          " dropped",
          _only_one, _judge_only_one),
    Check("R46", _AT, lambda: _motion("41", 17.6), _judge_periodic),
    Check("R47", _AT, lambda: _motion("41", 25.0), _judge_chaotic),
    Check("R48", "orbit of period one followed from 13.1 Hz for both sets and each change alone",
          _changes, _judge_changes),
    Check("R49", _AT, _orbit, _open_motion),
)  # fmt: skip
