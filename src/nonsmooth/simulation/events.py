"""The event log of a run: arrays of the engine to named columns."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine import records as at
from nonsmooth.engine.status import EventKind
from nonsmooth.engine.transitions import PATH_BITS, PATH_LENGTH
from nonsmooth.simulation.runner import Outcome
from nonsmooth.system.system import System

__all__ = ["event_variables", "mode_flags"]


def mode_flags(system: System, long_name: str) -> dict[str, Any]:
    """CF flags that say which mode an integer stands for."""
    return {
        "long_name": long_name,
        "flag_values": np.arange(len(system.mode_names), dtype=np.int8),
        "flag_meanings": " ".join(system.mode_names),
    }


def event_variables(system: System, outcome: Outcome) -> dict[str, Any]:
    """Variables over ``event`` for a dataset."""
    rows, values = outcome.event_integers, outcome.event_floats
    n = len(system.states)
    window = float(outcome.tables.clock[0])
    number, phase = rows[:, at.NUMBER], values[:, at.PHASE]
    kinds = np.array([kind.word for kind in EventKind])
    before = values[:, at.EVENT_FLOATS : at.EVENT_FLOATS + n]
    after = values[:, at.EVENT_FLOATS + n :]
    event_state = ("event", "state")
    return {
        "event_time": ("event", number * window + phase, {"long_name": "time of the event"}),
        "event_period_number": ("event", number, {"long_name": "whole windows before the event"}),
        "event_phase": ("event", phase, {"long_name": "time of the event within its window"}),
        "event_name": (
            "event",
            _names(system, rows),
            {"long_name": "name of the first exit passed"},
        ),
        "event_kind": ("event", kinds[rows[:, at.KIND]], {"long_name": "kind of the event"}),
        "event_from": (
            "event",
            rows[:, at.FROM].astype(np.int8),
            mode_flags(system, "mode before the event"),
        ),
        "event_to": (
            "event",
            rows[:, at.TO].astype(np.int8),
            mode_flags(system, "mode after the event"),
        ),
        "event_path": ("event", _paths(system, rows), {"long_name": "exits passed at the instant"}),
        "event_count": (
            "event",
            np.ones(len(rows), np.int64),
            {"long_name": "impacts that this row stands for"},
        ),
        "guard_rate": (
            "event",
            values[:, at.GUARD_RATE],
            {"long_name": "rate of the guard that fired, just before the event"},
        ),
        "certified": (
            "event",
            rows[:, at.IS_CERTIFIED].astype(bool),
            {"long_name": "whether rounding leaves no doubt about the event"},
        ),
        "state_before": (event_state, before, {"long_name": "states just before the event"}),
        "state_after": (event_state, after, {"long_name": "states just after the event"}),
    }


def _names(system: System, rows: npt.NDArray[np.int64]) -> npt.NDArray[Any]:
    """Exit names looked up by mode and exit; the start has a name of its own."""
    names = system.compiled.exit_names
    most = max(1, *(len(of_mode) for of_mode in names))
    table = np.array([[*of_mode, *[""] * (most - len(of_mode)), "start"] for of_mode in names])
    return table[rows[:, at.FROM], rows[:, at.EXIT]]  # exit -1, the start, is the last column


def _paths(system: System, rows: npt.NDArray[np.int64]) -> npt.NDArray[Any]:
    """Names of the exits passed at one instant, joined by '>'."""
    if len(rows) == 0:
        return np.array([], dtype=str)
    keys = rows[:, [at.FROM, at.PATH, at.PASSES]]
    # distinct paths are few, so only they are decoded
    code = (keys[:, 1] * len(system.modes) + keys[:, 0]) * 2 + (keys[:, 2] > PATH_LENGTH)
    _, first, inverse = np.unique(code, return_index=True, return_inverse=True)
    texts = np.array([_path_text(system, *(int(v) for v in keys[k])) for k in first])
    return texts[inverse]


def _path_text(system: System, mode: int, path: int, passes: int) -> str:
    wiring = system.compiled.program.wiring
    names = []
    for _ in range(min(passes, PATH_LENGTH)):
        way = (path & ((1 << PATH_BITS) - 1)) - 1
        path >>= PATH_BITS
        names.append(system.compiled.exit_names[mode][way])
        mode = int(wiring[mode, 1 + way, 0])
    return ">".join(names) + (">..." if passes > PATH_LENGTH else "")
