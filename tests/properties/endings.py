"""Whether a run that did not complete had a reason to end."""

from __future__ import annotations

import re
from itertools import combinations

import numpy as np
from scipy.integrate import solve_ivp

from properties.fields import sides
from properties.judging import CLOSE, owner
from properties.own_texts import Texts
from properties.words import Drawn

_NEAR = 1e-6  # distance, beside the size of states, within which surfaces meet
_TANGENT = 1e-3  # rate of the distance from a surface, beside that of the states
_FURTHER = 0.02  # time for which a motion goes on that was called singular
_BRIEF = 1e-4  # flights between rebounds that accumulate
_MOST_EVENTS = 10_000  # in a period, or in what is taken for one
_MOST_GROWTH = 30.0
_MOST_CALLS = 5000
_SOON = 1e-3  # time within which a wall is passed by what is pressed into it
_STEPS = 100  # until then
_RUNS_OFF = 1e3  # size of states, of starts of size 1, beside which a function of them is steep


def unreasonable(drawn: Drawn, texts: Texts, run) -> list[str]:
    """Complaints about the status of a run that has ended early."""
    status = run.attrs["status"]
    if status == "singular":
        return _not_singular(drawn, texts, run)
    if status == "event_limit":
        return _not_accumulating(drawn, texts, run)
    if status == "step_limit" and np.abs(run["end_state"].values).max() > _RUNS_OFF:
        return []
    if status == "undecided":
        return _decided(texts, run)
    if status == "sliding":
        return _not_meeting(drawn, texts, run)
    if status in ("inadmissible", "step_limit", "interrupted"):
        return [f"{status}: {run.attrs['message'][:200]}"]
    return []


def _not_singular(drawn: Drawn, texts: Texts, run) -> list[str]:
    """The texts go on smoothly from where the run has ended."""
    t = run.attrs["end_number"] * run.attrs["window"] + run.attrs["end_phase"]
    if t == 0.0:
        return ["singular at the start"]
    labels = run["mode"].attrs["flag_meanings"].split()
    label = labels[int(run["event_to"].values[-1])]
    mode, resting = owner(texts, label, drawn)
    relations = texts.modes[mode].get("slaved", {}).values()
    if resting or "0" in label or label.startswith("on") or any("=" in r for r in relations):
        return []
    z, calls = run["end_state"].values, 0

    def field(t: float, z: np.ndarray) -> np.ndarray:
        nonlocal calls
        calls += 1
        return texts.field(mode, z, t) if calls < _MOST_CALLS else np.full(len(z), np.nan)

    on = solve_ivp(field, (t, t + _FURTHER), z, method="DOP853", rtol=1e-9, atol=1e-12)
    size = 1 + np.abs(z).max()
    if on.success and np.abs(on.y).max() < _MOST_GROWTH * size:
        return [f"singular at t = {t:.6g}, where the motion goes on ({label})"]
    return []


def _not_meeting(drawn: Drawn, texts: Texts, run) -> list[str]:
    """No surfaces are near each other where some are said to meet; nor is motion tangent to one.

    High powers are left out: the library may know of no sliding along their surfaces, for it takes
    the multiple zero that the rates on both sides share for their only one.
    """
    t = run.attrs["end_number"] * run.attrs["window"] + run.attrs["end_phase"]
    z = run["end_state"].values
    labels = run["mode"].attrs["flag_meanings"].split()
    mode, _ = owner(texts, labels[int(run["event_to"].values[-1])], drawn)
    near = {
        switch.text
        for switch in drawn.switches
        if abs(float(texts.value(switch.text, z, t)))
        <= texts.change(switch.text, z, t, _NEAR * (1 + np.abs(z).max()))
    }
    if len(near) > 1:
        return []
    for text in near:
        fields, rates = sides(texts, mode, text, z, t)
        high = re.search(r"\*\*([3-9]|\d\d)", text)
        if high or np.abs(rates).min() <= _TANGENT * np.abs(fields).max():
            return []
    return [f"sliding, though {len(near)} surfaces are near"]


def _decided(texts: Texts, run) -> list[str]:
    """An exit that was passed in a circle does not fire by the texts: its guard does not fall."""
    if len(texts.modes) == 1:
        return ["undecided, with one mode only"]
    ways = {w["name"]: (mode, w) for mode, x in texts.modes.items() for w in x.get("exits", [])}
    t, z = float(run["event_time"].values[-1]), run["state_before"].values[-1].copy()
    for name in str(run["event_path"].values[-1]).split(">"):
        if name not in ways:
            continue
        mode, way = ways[name]
        rate = float(texts.along(way["guard"], z, t, texts.field(mode, z, t)))
        off = texts.change(way["guard"], z, t, CLOSE * (1 + np.abs(z).max()))
        if rate > 0.0 or float(texts.value(way["guard"], z, t)) > off:
            return [f"undecided, though {name} does not fire"]
        behind = {k: float(texts.value(text, z, t)) for k, text in way.get("reset", {}).items()}
        for state, value in behind.items():
            z[texts.states.index(state)] = value
    return []


def _not_accumulating(drawn: Drawn, texts: Texts, run) -> list[str]:
    """Events are far apart, or all of them are of exits that stick."""
    last = str(run["event_path"].values[-1]).split(">")
    if last[-1] == "...":
        return _not_pressed(texts, run, {name for name in last if name.startswith("e")})
    gaps = np.diff(run["event_time"].values)[-5:]
    regular = run.attrs["n_events"] >= _MOST_EVENTS
    if len(gaps) == 5 and gaps.mean() > _BRIEF and not regular:
        return [f"event_limit, with events {gaps.mean():.3g} apart"]
    sticking = {
        way["name"]
        for mode in drawn.words.get("modes", {}).values()
        for way in mode.get("exits", [])
        if "sticks" in way
    }
    passed = {name for path in run["event_path"].values[-20:] for name in str(path).split(">")}
    loose = {name for name in passed if name.startswith("e")} - sticking
    if not loose and not any(name.startswith(("s", "flow")) for name in passed):
        return [f"event_limit, though all of {', '.join(sorted(passed))} stick"]
    return []


def _not_pressed(texts: Texts, run, names: set[str]) -> list[str]:
    """Exits pass at one instant without end, though the texts lead away from all their guards."""
    labels = run["mode"].attrs["flag_meanings"].split()
    mode = labels[int(run["event_to"].values[-1])].split("[")[0]
    if mode not in texts.modes:
        return []
    t, z = float(run["event_time"].values[-1]), run["end_state"].values
    step = _SOON / _STEPS
    for _ in range(_STEPS):  # of one length, for signs may alternate
        middle = z + 0.5 * step * texts.field(mode, z, t)
        z = z + step * texts.field(mode, middle, t + 0.5 * step)
        t += step
    guards = [way["guard"] for way in texts.modes[mode].get("exits", []) if way["name"] in names]
    if any(float(texts.value(guard, z, t)) < 0.0 for guard in guards):
        return []
    if _squeezed(texts, run, guards):
        return []
    return [f"event_limit at one instant, and nothing is pressed into {', '.join(sorted(names))}"]


def _squeezed(texts: Texts, run, guards: list[str]) -> bool:
    """Whether two walls that face each other have met, so that nothing is left between them.

    Then impacts have no end before they meet, wherever the motion would lead if there were none.
    """
    t, z = float(run["event_time"].values[-1]), run["end_state"].values
    error = CLOSE * (1 + np.abs(z).max())
    met = [
        texts.gradient(guard, z, t)
        for guard in guards
        if abs(float(texts.value(guard, z, t))) <= texts.change(guard, z, t, error)
    ]
    return any(one @ other < 0.0 for one, other in combinations(met, 2))
