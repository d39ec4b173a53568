"""Claims on the rig: data, diagrams, regimes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import zip_longest

import numpy as np
import xarray as xr
from scipy.stats import spearmanr

from nonsmooth import System
from nonsmooth_chapter.judgement import Evidence, Finding, agrees
from nonsmooth_chapter.rotor.motions import (
    DELTA_40,
    DELTA_41,
    EPS_40,
    EPS_41,
    STARTS,
    coexisting,
    follow_orbit,
    meeting_with_unstable_orbits,
    orbit_near,
    rig,
)
from nonsmooth_chapter.rotor.rig_sweeps import (
    chaotic_span,
    followed_motion,
    machine_of,
    rig_sweeps,
    speed_scan,
)
from nonsmooth_chapter.rotor.ring import heavy_ring_orbit
from nonsmooth_chapter.rotor.speed_sweeps import CHAOTIC, PROTOCOLS, last_strobe

# Claims on the data of the rig (section 4.4): what follows from the printed numbers.

_SMALL, _LARGE = 0.02, 0.1  # what the rules let "about" mean, in the strict and the wide sense


def _natural_frequency() -> Evidence:
    return {"frequency": rig().natural_frequency, "printed": "14.4"}


def _judge_frequency(evidence: Evidence) -> Finding:
    value = evidence["frequency"]
    return Finding(
        agrees(value, evidence["printed"]), f"{value:.3f} Hz, printed {evidence['printed']} Hz"
    )


def _damping(printed: tuple[float, ...] = (1050.0, 105.0), nu1: str = "0.06") -> Evidence:
    values = [replace(rig(), rotor_damping=c).parameters()["nu1"] for c in printed]
    return {"printed": list(printed), "nu1": values, "nu1_printed": nu1}


def _judge_damping(evidence: Evidence) -> Finding:
    fits = [agrees(value, evidence["nu1_printed"]) for value in evidence["nu1"]]
    listed = ", ".join(
        f"{c:g} gives nu1 = {value:.4f} ({'fits' if fit else 'does not fit'})"
        for c, value, fit in zip(evidence["printed"], evidence["nu1"], fits, strict=True)
    )
    text = (
        f"{listed}; set B has {evidence['nu1_printed']}, and a damping has the unit kg/s, not N/s."
        " One rig has one damping, so two different numbers cannot both fit: print contradicts"
        " itself, and the computation tells which number is meant"
    )
    return Finding(all(fits), text)


def _scaled() -> Evidence:
    values = rig().parameters()
    printed = {"K": "30", "nu2": "0.002", "eta_m": "0.00289", "rho": "70"}
    return {"computed": {name: values[name] for name in printed}, "printed": printed}


def _judge_scaled(evidence: Evidence) -> Finding:
    printed = evidence["printed"]
    fits = [agrees(evidence["computed"][name], text) for name, text in printed.items()]
    listed = ", ".join(
        f"{name} {evidence['computed'][name]:.6g} (printed {text})"
        for name, text in printed.items()
    )
    return Finding(all(fits), listed)


def _light_ring(
    ratio: float = 1.0 / 17.0, speed: float = 13.1, stiffnesses: tuple[float, ...] = (50.0, 200.0)
) -> Evidence:
    values = rig(speed=speed).parameters()
    eta, K = values["eta"], values["K"]
    frequencies = {n: float(np.sqrt(n * K / ratio)) for n in (1, 2)}
    return {
        "ratio": ratio,
        "speed": speed,
        "ring_over_forcing": {str(n): each / eta for n, each in frequencies.items()},
        "orbits": [heavy_ring_orbit(speed, ratio, stiff) for stiff in stiffnesses],
    }


def _judge_light_ring(evidence: Evidence) -> Finding:
    orbits = evidence["orbits"]
    same = all(row["period"] == row["massless_period"] for row in orbits)
    apart = max(row["difference"] for row in orbits)
    true = None if same and _SMALL < apart <= _LARGE else bool(same and apart <= _SMALL)
    above = min(evidence["ring_over_forcing"].values())
    listed = "; ".join(
        f"contact {row['stiffness']:g} K: period {row['period'] or 'none'} (massless"
        f" {row['massless_period'] or 'none'}), orbit differs by {row['difference']:.1%} of its"
        f" size, {row['contacts']:g} contacts per period (massless {row['massless_contacts']:g})"
        for row in orbits
    )
    text = (
        f"the ring on its springs vibrates at {above:.1f} times the forcing or more; with the mass"
        f" {evidence['ratio']:.4f} at {evidence['speed']:g} Hz: {listed}; negligible is a change"
        f" of {_SMALL:.0%} at most, no longer one above {_LARGE:.0%}; the chapter names no measure"
    )
    return Finding(true, text)


# Claims on the diagrams of the rig, Figs. 40 and 41, and on motions at single speeds.
#
# Section 4.4 follows the motion from one speed to the next; the direction is not printed. Rising
# speed decides here, as both diagrams are said to begin at 7 Hz; the others stand beside it.

_STATED = "follow up"
_WIDE = 0.5  # share of the columns
_MEETS = 0.02  # of the width of the chaotic set
_PRINTED_FLIP, _PRINTED_CRISIS = "14.74", "26.1"
_BEFORE = 13.1  # Hz: period one of Fig. 42, below the doubling
_UNKNOWN = "not found"  # a search that failed tells nothing of how a route goes on
_ABOVE = (0.02, 0.005, 0.05, 0.1)  # Hz above a doubling, where the doubled orbit is looked for


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
        system, orbit = _orbit_behind(eps, delta, speed, period)
        if orbit is None:
            ends.append(
                {"period": period, "speed": speed, "kind": _UNKNOWN, "multiplier": [0.0, 0.0]}
            )
            break
        end = follow_orbit(system, orbit, 50.0 / hertz)
        ends.append(
            {"period": period, "speed": hertz * end["eta"], "kind": end["kind"],
             "multiplier": end["multiplier"]}
        )  # fmt: skip
        if end["kind"] != "flip":
            break
        period, speed = 2 * period, hertz * end["eta"]
    return {"eps": list(eps), "delta": delta, "ends": ends}


def _orbit_behind(
    eps: tuple[float, float], delta: float, speed: float, period: int
) -> tuple[System, xr.Dataset | None]:
    """Orbit of a period that zero leads to at a speed, or a little above it where it is born."""
    system = rig(eps, delta, speed).system()
    for above in (0.0,) if period == 1 else _ABOVE:
        system = rig(eps, delta, speed + above).system()
        orbit = orbit_near(system, last_strobe(system, 3000), period)
        if orbit is not None:
            return system, orbit
    return system, None


def _ends_text(ends: list[Evidence]) -> str:
    return ", ".join(
        f"period {end['period']} {end['kind']} {'from' if end['kind'] == _UNKNOWN else 'at'}"
        f" {end['speed']:.3f} Hz"
        for end in ends
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
    return {"rows": rows, "motions": motions, "meetings": _meetings()}


def _meetings() -> list[Evidence]:
    """Unstable orbits that the chaotic set comes near at its last column."""
    sweep, system = rig_sweeps("41")[_STATED], machine_of("41").system()
    span = chaotic_span(sweep)
    if span is None:
        return []
    last = sweep.data.isel(parameter=span[1], point=-1)
    state = {name: float(last[name]) for name in system.states}
    inside = float(sweep.eta[span[1]])
    return meeting_with_unstable_orbits(system, state, inside, inside + sweep.step)


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
    place = stated["to"] is not None and agrees(
        stated["to"], _PRINTED_CRISIS, about=0.02, step=stated["step"]
    )
    meetings = evidence["meetings"]
    nearest = min((each["distance"] for each in meetings), default=np.inf)
    met = ", ".join(f"period {each['period']} {each['distance']:.1%}" for each in meetings)
    text = (
        f"last chaotic column up to 30 Hz: {listed}; printed {_PRINTED_CRISIS} Hz, about: 2 %;"
        f" beside the end {STARTS + 1} starts lead to: {beside}; distance of the set at its last"
        " column from the unstable orbits on the branches of what is left, beside its width:"
        f" {met or 'no such orbit found'} (a crisis: {_MEETS:.0%} at most)"
    )
    return Finding(bool(place and nearest <= _MEETS), text)


def _only_one(
    speeds: Sequence[float] = tuple(np.linspace(30.0, 50.0, 21)), starts: int = 12
) -> Evidence:
    """Motions at speeds 1 Hz apart, and how far the orbit of period one is stable in between."""
    rows = []
    for speed in speeds:
        found = coexisting(rig(EPS_41, DELTA_41, speed).system(), starts)
        rows.append({"speed": float(speed), "motions": [_name(each) for each in found]})
    machine = rig(EPS_41, DELTA_41, max(speeds))
    system = machine.system()
    orbit = orbit_near(system, last_strobe(system, 1500), 1)
    to = min(speeds) / machine.natural_frequency
    end = None if orbit is None else follow_orbit(system, orbit, to)
    branch = (
        {"kind": _UNKNOWN, "speed": float(max(speeds))}
        if end is None
        else {"kind": end["kind"], "speed": machine.natural_frequency * end["eta"]}
    )
    return {"rows": rows, "starts": starts + 1, "branch": branch}


def _judge_only_one(evidence: Evidence) -> Finding:
    rows, branch = evidence["rows"], evidence["branch"]
    # motions that have not settled tell nothing
    other = [row for row in rows if set(row["motions"]) - {"period 1", "no period"}]
    listed = "; ".join(f"{row['speed']:g} Hz {', '.join(row['motions'])}" for row in other)
    stable = branch["kind"] == "none"
    followed = (
        "is stable throughout"
        if stable
        else f"could be followed to {branch['speed']:.2f} Hz ({branch['kind']})"
    )
    searched = branch["kind"] != _UNKNOWN
    return Finding(
        False if other else stable if searched else None,
        f"from {evidence['starts']} starts other settled motions at {len(other)} of {len(rows)}"
        f" speeds{': ' * bool(other)}{listed}; the orbit of period one, followed down from 50 Hz,"
        f" {followed}",
    )


def _changes() -> Evidence:
    sets = {
        "Fig. 40": (EPS_40, DELTA_40), "eccentricity of Fig. 41": (EPS_41, DELTA_40),
        "preload of Fig. 41": (EPS_40, DELTA_41), "Fig. 41": (EPS_41, DELTA_41),
    }  # fmt: skip
    return {"rows": [{"set": name, **_doublings(*values)} for name, values in sets.items()]}


def _unlike(first: list[str], second: list[str]) -> bool | None:
    """Whether two routes differ; None where a search failed before they did."""
    for one, other in zip_longest(first, second, fillvalue=""):
        if _UNKNOWN in (one, other):
            return None
        if one != other:
            return True
    return False


def _judge_changes(evidence: Evidence) -> Finding:
    routes = [[end["kind"] for end in row["ends"]] for row in evidence["rows"]]
    listed = "; ".join(
        f"{row['set']}: {_ends_text(row['ends']) or 'no period one'}" for row in evidence["rows"]
    )
    # the claim: by eccentricity, so it must differ with the preload of either figure
    unlike = [_unlike(routes[0], routes[1]), _unlike(routes[2], routes[3])]
    true = False if False in unlike else None if None in unlike else True
    return Finding(true, f"ends of period one from {_BEFORE:g} Hz upwards, and of its doublings: "
                   f"{listed}")  # fmt: skip


def _orbit() -> Evidence:
    return _motion("41", _BEFORE)


def _open_motion(evidence: Evidence) -> Finding:
    return Finding(
        None,
        f"{_motion_text(evidence)}; the measured strobes of Fig. 40(b), as numbers, would decide:"
        " their set beside ours, and the largest exponent of both",
    )


def _judge_orbit(evidence: Evidence) -> Finding:
    """The theoretical half can refute the claim; the other half needs the measured orbits."""
    periodic = all(row["period"] == 1 for row in evidence["rows"])
    return Finding(
        periodic,
        f"the theoretical half {'holds' if periodic else 'differs'}: {_motion_text(evidence)}; the"
        " measured orbits would decide the other half",
        for_all="" if periodic else "any measured orbits",
    )


# Claims at the end of section 4.4: contacts, forces and amplitudes over the rig's speed.

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


def _judge_contacts(evidence: Evidence) -> Finding:
    return _each(evidence, _contacts)


def _judge_forces(evidence: Evidence) -> Finding:
    return _each(evidence, _forces)


def _judge_widths(evidence: Evidence) -> Finding:
    return _each(evidence, _widths)


def _judge_amplitudes(evidence: Evidence) -> Finding:
    return _each(evidence, _amplitudes)
