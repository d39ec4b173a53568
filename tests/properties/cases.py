"""One random system from its words to its verdict."""

from __future__ import annotations

import time
import warnings
from dataclasses import dataclass, field

import numpy as np

import nonsmooth as ns
from nonsmooth.errors import NonsmoothError
from properties.draw import draw
from properties.endings import unreasonable
from properties.fields import deviation
from properties.hard import draw_hard
from properties.judging import complaints, dip_times, flight_times, flights
from properties.own_texts import Texts
from properties.words import Drawn

_SHORTEST_MESSAGE = 25
HARD = 1_000_000  # from this seed on systems are hard to certify


def drawn_of(seed: int) -> Drawn:
    """The system of a seed, of one of two families."""
    return draw_hard(seed) if seed >= HARD else draw(seed)


@dataclass
class Verdict:
    """What a seed came to. ``complaints`` are faults; the others are for the statistics."""

    seed: int
    status: str = "none"
    features: set[str] = field(default_factory=set)
    kinds: set[str] = field(default_factory=set)
    flows: set[str] = field(default_factory=set)
    complaints: list[str] = field(default_factory=list)
    flagged: bool = False
    integrated: int = 0
    seconds: float = 0.0  # of one processor, for the longest run: these are compared
    n_events: int = 0


def judge(seed: int) -> Verdict:
    """Draw, write, run and judge; an exception that is none of the package's is a fault."""
    drawn = drawn_of(seed)
    verdict = Verdict(seed, features=set(drawn.features))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", ns.RunWarning)
            _judge(drawn, verdict)
    except NonsmoothError as refusal:
        verdict.status = f"refused: {type(refusal).__name__}"
        if len(str(refusal)) < _SHORTEST_MESSAGE:
            verdict.complaints.append(f"the message says little: {refusal}")
    except Exception as fault:
        verdict.complaints.append(f"{type(fault).__name__}: {fault}")
    return verdict


def _judge(drawn: Drawn, verdict: Verdict) -> None:
    system = _written(drawn, verdict)
    verdict.flows = {"linear" if m.taylor is None else "Taylor" for m in system.structure.running}
    run = _timed(verdict, system, drawn.start, **drawn.length)
    verdict.status, verdict.n_events = run.attrs["status"], run.attrs["n_events"]
    verdict.kinds = set(run["event_kind"].values.tolist())
    verdict.flagged = run.attrs["n_uncertain"] > 0 or run.attrs["certified"] != 1
    if verdict.status == "completed":
        _judge_motion(drawn, verdict, system, run)
        return
    hangs_on_rounding = verdict.flagged and verdict.status in ("undecided", "inadmissible")
    if not hangs_on_rounding:  # said so: counted, not judged
        verdict.complaints += unreasonable(drawn, Texts(drawn.words), run)
    if len(run.attrs["message"]) < _SHORTEST_MESSAGE:
        verdict.complaints.append(f"the message says little: {run.attrs['message']}")


def _written(drawn: Drawn, verdict: Verdict) -> ns.System:
    """The system from Python's words or from TOML; one in four by all ways."""
    system = ns.System.from_toml(drawn.toml()) if drawn.seed % 2 else drawn.system()
    if drawn.seed % 4 == 0:
        ways = [ns.System.from_toml(drawn.toml()), ns.System.from_toml(system.to_toml())]
        if any(way != system for way in ways):
            verdict.complaints.append("the system is another one once it went through TOML")
    return system


def _timed(verdict: Verdict, system: ns.System, start, **length):
    began = time.process_time()
    run = ns.simulate(system, start, **length)
    if run.attrs["status"] != "step_limit":  # that status tells of a long run by itself
        verdict.seconds = max(verdict.seconds, time.process_time() - began)
    return run


def _judge_motion(drawn: Drawn, verdict: Verdict, system: ns.System, run) -> None:
    texts, end = Texts(drawn.words), float(run["time"].values[-1])
    times = np.append(flight_times(run), end)
    dense = _timed(verdict, system, drawn.start, times=times)
    for name in ("event_time", "state_after", "end_state"):
        if not np.array_equal(dense[name].values, run[name].values):
            verdict.complaints.append(f"{name} depends on the samples")
    found = complaints(drawn, texts, dense)
    dips = dip_times(drawn, texts, dense)
    if len(dips) and not found:
        near = _timed(verdict, system, drawn.start, times=np.append(dips[dips < end], end))
        found += complaints(drawn, texts, near)
    size = 1.0 + max(np.abs(dense[name].values).max() for name in texts.states)
    if drawn.seed % 3 == 0 and not found:
        longest = sorted(flights(drawn, texts, dense), key=lambda f: f.t[0] - f.t[-1])
        for flight in [*longest[:1], *longest[1:][-1:]]:
            verdict.integrated += 1
            found += deviation(drawn, texts, flight, size)
    if drawn.seed % 3 == 1:
        _judge_cut(drawn, verdict, system, end, dense)
    if verdict.flagged:  # said so: counted, not judged
        found = [text for text in found if "not finite" in text]
    verdict.complaints += found


def _judge_cut(drawn: Drawn, verdict: Verdict, system: ns.System, end: float, whole) -> None:
    """A run that is cut goes on bit for bit."""
    first = ns.simulate(system, drawn.start, times=[0.37 * end])
    second = ns.simulate(system, first, times=[end])
    if not np.array_equal(second["end_state"].values, whole["end_state"].values):
        off = np.abs(second["end_state"].values - whole["end_state"].values).max()
        verdict.complaints.append(f"cut in two the run ends {off:.3g} away")
