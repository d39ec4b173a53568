"""The event log of a run: arrays of the engine to named columns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.record import Rows, columns
from nonsmooth.engine.status import Certificate, EventKind
from nonsmooth.engine.tables import PATH_LENGTH
from nonsmooth.runs.after_chatter import states_after
from nonsmooth.runs.assemble import Columns
from nonsmooth.runs.labels import Labels
from nonsmooth.runs.runner import Outcome

__all__ = ["event_variables"]

_KINDS = [kind.word for kind in EventKind]


def event_variables(labels: Labels, outcome: Outcome) -> Columns:
    """Variables over ``event`` for a dataset."""
    rows, states = outcome.events, outcome.event_states
    number, phase = rows["number"].copy(), rows["phase"] + rows["wait"]
    time = outcome.times(number, phase)
    before = states[:, 0]
    codes = rows["from_mode"] * labels.width
    codes += rows["exit"]
    codes[rows["exit"] < 0] += labels.width  # the start
    variables: dict[str, tuple[Any, str | dict[str, Any]]] = {
        "event_time": (time, "time of the event"),
        "event_period_number": (number, "whole windows before the event"),
        "event_phase": (phase, "time of the event within its window"),
        "event_name": (_texts(labels.names, codes), "name of the first exit passed"),
        "event_kind": (_texts(_KINDS, rows["kind"]), "kind of the event"),
        "event_from": (
            rows["from_mode"].astype(labels.mode_type),
            labels.mode_flags("mode before the event"),
        ),
        "event_to": (
            rows["to_mode"].astype(labels.mode_type),
            labels.mode_flags("mode after the event"),
        ),
        "event_path": (_paths(labels, rows, codes), "exits passed at the instant"),
        "event_count": (rows["count"].copy(), "impacts that this row stands for"),
        "guard_rate": (
            rows["guard_rate"].copy(),
            "rate of the guard that fired, just before the event",
        ),
        "certified": (
            rows["certificate"] == Certificate.CERTIFIED,
            "whether neither rounding nor an estimate leaves a doubt about the event",
        ),
        "estimated": (
            rows["certificate"] == Certificate.ESTIMATED,
            "whether the event rests on an estimate of the errors of Taylor series",
        ),
        "state_before": (before.copy(), "states just before the event"),
        "state_after": (states_after(outcome).copy(), "states just after the event"),
    }
    return {
        name: (
            ("event", "state")[: column.ndim],
            column,
            {"long_name": words} if isinstance(words, str) else words,
        )
        for name, (column, words) in variables.items()
    }


def _texts(table: Sequence[str], codes: npt.NDArray[np.int64]) -> npt.NDArray[Any]:
    """Texts by number, as wide as the longest that occurs, which is the width files restore."""
    counts = np.bincount(codes, minlength=len(table))
    words = np.array([text if n else "" for text, n in zip(table, counts, strict=True)])
    return words.take(codes)


def _paths(labels: Labels, rows: Rows, codes: npt.NDArray[np.int64]) -> npt.NDArray[Any]:
    """Exits passed: mostly the one that has named the event; longer paths are decoded."""
    several = np.flatnonzero(rows["passes"] > (rows["exit"] >= 0))
    if several.size == 0:
        return _texts(labels.paths, codes)
    mode, path, passes = columns(rows[several], "from_mode", "path", "passes").T
    _, path_code = np.unique(path, return_inverse=True)
    code = (path_code * len(labels.modes) + mode) * 2 + (passes > PATH_LENGTH)
    _, first, which = np.unique(code, return_index=True, return_inverse=True)
    texts = [labels.path(int(mode[k]), int(path[k]), int(passes[k])) for k in first]
    codes = codes.copy()
    codes[several] = len(labels.paths) + which
    return _texts([*labels.paths, *texts], codes)
