"""What is asked of a run of a random system, by values of its texts and nothing else.

Samples lie strictly between events, fifty in each flight, up to a number of flights, and where a
guard seems to have a minimum close to zero between two of them. States may be off by 1e-9 of their
size, far above rounding of motions that are followed for a few hundred events, far below any real
fault; guards and switching functions by what such an error makes of them at that place, whatever
their units are and however flat they are.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BarycentricInterpolator

from properties.own_texts import Texts
from properties.words import Drawn

PER_FLIGHT, MOST_FLIGHTS = 50, 60
CLOSE = 1e-9
BRIEF = 1e-7  # flights shorter than this part of the run are not sampled: rounding of times
DIFFERENCES = 1e-7  # of rates that come from differences of texts
TINY = 1e-200  # what is nothing in any units
PASSED = ("switch", "impact")  # kinds of events at which an exit of its mode has fired
NEAR = 0.5  # part of a guard at samples to which it falls between them where it is looked at again
NODES, ROUNDS = 7, 4  # samples through which states are interpolated; each round has a tenth left


@dataclass
class Flight:
    """Samples between two events, all in one cell of one mode."""

    label: str
    mode: str
    resting: tuple[str, ...]
    t: np.ndarray
    z: np.ndarray
    row: int  # of the event that ends it


def flight_times(run) -> np.ndarray:
    """Fifty times within each flight, the first and last ones of a run with many."""
    ends = np.append(run["event_time"].values, run["time"].values[-1])
    long = np.flatnonzero(np.diff(ends) > BRIEF * max(1.0, abs(ends[-1])))
    if len(long) > MOST_FLIGHTS:
        long = np.append(long[: MOST_FLIGHTS // 2], long[-MOST_FLIGHTS // 2 :])
    parts = (np.arange(PER_FLIGHT) + 0.5) / PER_FLIGHT
    return (ends[long, None] + np.diff(ends)[long, None] * parts).ravel()


def flights(drawn: Drawn, texts: Texts, dense) -> Iterator[Flight]:
    """Runs of samples in one mode between the same two events."""
    labels = dense["mode"].attrs["flag_meanings"].split()
    values = np.stack([dense[name].values for name in texts.states], axis=1)
    modes, times = dense["mode"].values, dense["time"].values
    after = np.searchsorted(dense["event_time"].values, times)
    change = np.flatnonzero((np.diff(modes) != 0) | (np.diff(after) != 0)) + 1
    for part in np.split(np.arange(len(times)), change):
        if len(part):
            label = labels[int(modes[part[0]])]
            mode, resting = owner(texts, label, drawn)
            row = int(after[part[0]])
            yield Flight(label, mode, resting, times[part], values[part], row)


def owner(texts: Texts, label: str, drawn: Drawn) -> tuple[str, tuple[str, ...]]:
    """Declared mode of a cell, and which of its exits are at rest there."""
    name = re.sub(r"\[.*", "", label)
    for mode, words in texts.modes.items():
        rests = {way["sticks"] for way in words.get("exits", []) if "sticks" in way}
        if name == mode:
            return mode, ()
        if set(name.split("+")) <= rests:
            return mode, tuple(name.split("+"))
    if name == "":
        raise AssertionError(f"cell without a name: {label!r}")
    return next(iter(texts.modes)), ()  # named by the sides of its surfaces


def complaints(drawn: Drawn, texts: Texts, dense) -> list[str]:
    """Everything that is wrong with the motion of a run, in words."""
    found: list[str] = []
    states = np.stack([dense[name].values for name in texts.states], axis=1)
    if not np.isfinite(states).all():
        return ["a sample is not finite"]
    size = 1.0 + np.abs(states).max(initial=0.0)
    times = dense["event_time"].values
    if (np.diff(times) < -1e-12 * (1 + np.abs(times[-1]))).any():
        k = int(np.argmin(np.diff(times)))
        found.append(f"event times go back by {-np.diff(times)[k]:.2g} at row {k + 1}")
    found += jumps(drawn, texts, dense, size)
    for flight in flights(drawn, texts, dense):
        found += [
            f"{text} ({flight.label}, t = {flight.t[0]:.6g} to {flight.t[-1]:.6g})"
            for text in [
                *_of_flight(drawn, texts, flight, size),
                *_its_end(texts, flight, dense, size),
            ]
        ]
    return found


def _of_flight(drawn: Drawn, texts: Texts, flight: Flight, size: float) -> Iterator[str]:
    words = texts.modes[flight.mode]
    for way in words.get("exits", []):
        guard = texts.value(way["guard"], flight.z, flight.t)
        if way.get("sticks") in flight.resting:
            yield from _at_rest(texts, flight, way, guard, size)
        elif not _stays_positive(texts, flight, way["guard"], guard, size):
            yield f"guard {way['name']} is {guard.min():.3g}"
    for state, text in texts.slaved(flight.mode).items():
        off = np.abs(texts.value(text, flight.z, flight.t)).max()
        if off > CLOSE * size:
            yield f"the relation of {state} is off by {off:.3g}"
    yield from _cell(drawn, texts, flight, size)


def _stays_positive(
    texts: Texts, flight: Flight, text: str, value: np.ndarray, size: float
) -> bool:
    """Whether values of a text, or of its opposite, are positive all through a flight.

    They may fall short by what errors of the states make of them.
    """
    k = int(np.argmin(value))
    lowest = float(value[k])
    return lowest >= -TINY or lowest >= -texts.change(text, flight.z[k], flight.t[k], CLOSE * size)


def _is_positive(texts: Texts, flight: Flight, text: str, size: float) -> bool:
    """Whether a text is positive all through a flight, whatever errors of states make of it."""
    value = texts.value(text, flight.z, flight.t)
    k = int(np.argmin(value))
    return bool(value[k] > texts.change(text, flight.z[k], flight.t[k], CLOSE * size))


def vanishes(texts: Texts, flight: Flight, text: str, value: np.ndarray, size: float) -> bool:
    """Whether a text is zero all through a flight, but for what errors of states make of it."""
    k = int(np.argmax(np.abs(value)))
    off = texts.change(text, flight.z[k], flight.t[k], CLOSE * size)
    return bool(np.abs(value[k]) <= off + TINY)


def _its_end(texts: Texts, flight: Flight, run, size: float) -> Iterator[str]:
    """The guard of the exit that is passed first is zero where the log says so."""
    k = flight.row
    if flight.resting or k >= len(run["event_time"]) or run["event_kind"].values[k] not in PASSED:
        return
    name, t = str(run["event_name"].values[k]), float(run["event_time"].values[k])
    z = run["state_before"].values[k]
    for way in texts.modes[flight.mode].get("exits", []):
        if way["name"] != name:
            continue
        guard = float(texts.value(way["guard"], z, t))
        if abs(guard) > texts.change(way["guard"], z, t, CLOSE * size) + TINY:
            yield f"guard {name} is {guard:.3g} where it is passed"


def _at_rest(texts: Texts, flight: Flight, way, guard: np.ndarray, size: float) -> Iterator[str]:
    """Guard and guard rate are zero; the free motion would be pressed against the wall."""
    limit = CLOSE * (size + np.abs(guard).max())
    if not vanishes(texts, flight, way["guard"], guard, size):
        yield f"guard {way['name']} at rest is {np.abs(guard).max():.3g}"
    if flight.label.count("0"):
        return  # rates on surfaces are no texts

    def rate(z: np.ndarray, t) -> np.ndarray:
        return texts.along(way["guard"], z, t, texts.field(flight.mode, z, t))

    speed = np.abs(rate(flight.z, flight.t)).max()
    if speed > DIFFERENCES * (1 + limit / CLOSE):
        yield f"guard rate {way['name']} at rest is {speed:.3g}"


# ---------------------------------------------------------------- cells


def _cell(drawn: Drawn, texts: Texts, flight: Flight, size: float) -> Iterator[str]:
    """No switching function changes its sign; as many vanish as the cell has zeros."""
    zeros = 0
    for switch in drawn.switches:
        if switch.mode not in (None, flight.mode):
            continue
        value = texts.value(switch.text, flight.z, flight.t)
        zeros += vanishes(texts, flight, switch.text, value, size)
        if switch.when and not _is_positive(texts, flight, switch.when, size):
            continue
        positive = _stays_positive(texts, flight, switch.text, value, size)
        if not positive and not _stays_positive(texts, flight, switch.text, -value, size):
            yield f"{switch.text} changes its sign: {value.min():.3g} to {value.max():.3g}"
    signs = re.search(r"\[([-+0.]+)\]", flight.label)
    if signs and zeros < signs.group(1).count("0"):
        yield f"on {signs.group(1).count('0')} surfaces, and {zeros} switching functions are zero"
    yield from _declared(drawn, texts, flight, size)


def _declared(drawn: Drawn, texts: Texts, flight: Flight, size: float) -> Iterator[str]:
    """Names of sides agree with the signs of declared functions."""
    match = re.search(r"\[([a-z0-9,]+)\]", flight.label)
    sides = (match.group(1) if match else flight.label).split(",")
    for surface in drawn.words.get("surfaces", {}).values():
        text = surface["function"]
        value = texts.value(text, flight.z, flight.t)
        wrong = {
            "below": not _stays_positive(texts, flight, text, -value, size),
            "above": not _stays_positive(texts, flight, text, value, size),
            "on": not vanishes(texts, flight, text, value, size),
        }
        for side, fails in wrong.items():
            if surface.get(side) in sides and fails:
                yield f"{surface[side]}: {value.min():.3g} to {value.max():.3g}"


# ---------------------------------------------------------------- between samples


def dip_times(drawn: Drawn, texts: Texts, dense) -> np.ndarray:
    """Times at which guards and switching functions seem to come close to zero between samples.

    States are interpolated between samples, for they are smooth where guards are flat or steep; the
    engine is asked for its own states at these times afterwards.
    """
    found: list[float] = []
    for flight in flights(drawn, texts, dense):
        ways = texts.modes[flight.mode].get("exits", [])
        judged = [w["guard"] for w in ways if w.get("sticks") not in flight.resting]
        judged += [s.text for s in drawn.switches if s.mode in (None, flight.mode)]
        for text in judged:
            value = np.abs(texts.value(text, flight.z, flight.t))
            before, lowest, after = value[:-2], value[1:-1], value[2:]
            for k in np.flatnonzero((lowest < before) & (lowest <= after)) + 1:
                time, least = _least_around(texts, flight, text, int(k))
                if least < NEAR * value[k]:
                    found.append(time)
    return np.unique(found)


def _least_around(texts: Texts, flight: Flight, text: str, k: int) -> tuple[float, float]:
    """Where a text comes closest to zero around a sample, and its size there."""
    first = min(max(k - NODES // 2, 0), max(len(flight.t) - NODES, 0))
    nodes = slice(first, first + NODES)
    states = BarycentricInterpolator(flight.t[nodes], flight.z[nodes])
    low, high, least = flight.t[k - 1], flight.t[k + 1], (0.0, np.inf)
    for _ in range(ROUNDS):
        times = np.linspace(low, high, 21)
        value = np.abs(texts.value(text, states(times), times))
        j = int(np.argmin(value))
        least = float(times[j]), float(value[j])
        low, high = times[max(j - 1, 0)], times[min(j + 1, 20)]
    return least


# ---------------------------------------------------------------- jumps


def jumps(drawn: Drawn, texts: Texts, run, size: float) -> list[str]:
    """States behind an event are those before it, put through the resets passed."""
    exits = {w["name"]: w for m in texts.modes.values() for w in m.get("exits", [])}
    labels = run["event_from"].attrs["flag_meanings"].split()
    found = []
    rows = range(1, len(run["event_time"]))
    for k in [*rows[:40], *rows[40:][-20:]]:
        z = run["state_before"].values[k].copy()
        path = str(run["event_path"].values[k]).split(">")
        rests = any(name.startswith("rest") for name in path)
        _, resting = owner(texts, labels[int(run["event_from"].values[k])], drawn)
        slaved = {s for m in texts.modes.values() for s in m.get("slaved", {})}
        if "..." in path or rests or resting:
            continue
        t = float(run["event_time"].values[k])
        for name in path:
            resets = exits.get(name, {}).get("reset", {})
            values = {state: texts.value(text, z, t) for state, text in resets.items()}
            for state, value in values.items():
                z[texts.states.index(state)] = value
        kept = [i for i, s in enumerate(texts.states) if s not in slaved]
        off = np.abs(z - run["state_after"].values[k])[kept].max()
        if off > CLOSE * size:
            found.append(f"state behind {'>'.join(path)} (row {k}) is off by {off:.3g}")
    return found
