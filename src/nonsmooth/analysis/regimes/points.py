"""Regimes of points of a parameter plane, spread over threads and kept in a folder."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.chain_links import End, pack_end, take_end
from nonsmooth.analysis.regimes.border_refinement import UNKNOWN
from nonsmooth.analysis.regimes.labels import LABELS, REPEATING
from nonsmooth.analysis.regimes.options import strobe_length
from nonsmooth.analysis.regimes.regime_run import settled_regime
from nonsmooth.analysis.regimes.verdict import Protocol, Verdict
from nonsmooth.analysis.regimes.window import cyclic_word
from nonsmooth.engine.lanes import SAME
from nonsmooth.engine.status import Status
from nonsmooth.errors import ModelError
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.crew import Stopped
from nonsmooth.runs.lane_runner import LaneRunner
from nonsmooth.runs.start import Start, resolve_start
from nonsmooth.runs.store import run_stored_tasks
from nonsmooth.runs.strobe_times import strobes
from nonsmooth.system.system import System

__all__ = ["Plane"]

_TOGETHER = 16  # points in a task: some hundredths of a second
_NUMBERS = (
    "transient_used", "length", "period", "events", "impacts", "exponent", "error", "k",
    "residual", "uncertain", "estimated", "progresses",
)  # fmt: skip
_WHOLE = ("transient_used", "period", "uncertain", "estimated", "progresses")

Places = npt.NDArray[np.int64]
Done = tuple[list[Verdict], End | None]  # of some points, and where the last motion has ended


@dataclass
class Plane:
    """Verdicts over two parameters; places are (number of the second, number of the first)."""

    protocol: Protocol
    system: System
    names: tuple[str, str]
    values: tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]
    initial: Any
    mode: str | None
    period: Any
    tolerance: float
    threads: int
    store: str | Path | None
    way: str  # restart, or follow up or down the first parameter
    told: Mapping[str, Any]  # all that the results depend on, for the store

    def __post_init__(self) -> None:
        shape = (self.values[1].size, self.values[0].size)
        self.verdicts = np.full(shape, None, object)
        self.keys = np.full(shape, UNKNOWN, np.int64)
        self._known: dict[tuple[Any, ...], int] = {}
        self._step = 0

    def compute(self, places: Places) -> bool:
        """Verdicts of some places; False where the user interrupted."""
        parts, after = self._parts(places)
        ends: dict[int, End | None] = {}

        def keep(i: int, done: Done) -> None:
            # of a task that was stopped the last points are missing
            for (row, column), verdict in zip(parts[i], done[0], strict=False):
                self.verdicts[row, column] = verdict
            ends[i] = done[1]

        store = self.store
        if store is not None and self._step:
            store = Path(store) / f"step-{self._step:03d}"
        self._step += 1
        complete = run_stored_tasks(
            [self._task(part, after.get(i), ends) for i, part in enumerate(parts)],
            lambda: LaneRunner(self.system, self.tolerance),
            store=store,
            protocol=self.told,
            pack=_packed,
            unpack=_unpacked,
            threads=self.threads,
            label="regime map" if self._step == 1 else "regime map, borders",
            keep=keep,
            after=after,
            parts=True,
        )
        for row, column in places:  # in order: the number of a key does not depend on threads
            verdict = self.verdicts[row, column]
            if verdict is not None:
                key = _key(verdict)
                self.keys[row, column] = self._known.setdefault(key, len(self._known) + 1)
        return complete

    def _parts(self, places: Places) -> tuple[list[Places], dict[int, int]]:
        """Places of each task, in an order that equal work has whenever it is done again.

        Motions that follow each other are those of one row; with the task that each one follows.
        """
        if self.way == "restart":
            return _some_each(places), {}
        rows = np.split(places, np.flatnonzero(np.diff(places[:, 0])) + 1)
        parts: list[Places] = []
        after: dict[int, int] = {}
        for row in rows:
            for k, part in enumerate(_some_each(row if self.way == "follow up" else row[::-1])):
                if k:
                    after[len(parts)] = len(parts) - 1
                parts.append(part)
        return parts, after

    def fill(self, places: Places) -> None:
        """Give places the label that has been found all around them, and no evidence."""
        examples: dict[tuple[Any, ...], Verdict] = {}
        for verdict in self.verdicts.ravel():
            if verdict is not None:
                examples.setdefault(_key(verdict), verdict)
        shared = {
            self._known[key]: Verdict(
                like.label,
                "",
                0,
                np.nan,
                np.full_like(like.drift, np.nan),
                like.period,
                like.word,
                progresses=like.progresses,
            )
            for key, like in examples.items()
        }
        for row, column in places:
            self.verdicts[row, column] = shared[int(self.keys[row, column])]

    def _task(
        self, places: Places, before: int | None, ends: dict[int, End | None]
    ) -> Callable[[LaneRunner, threading.Event], Done]:
        def run(runner: LaneRunner, stop: threading.Event) -> Done:
            found: list[Verdict] = []
            end = None if before is None else ends.get(before)
            for row, column in places:
                try:
                    found.append(self._verdict(runner, stop, row, column, end))
                except Stopped:
                    raise Stopped((found, None)) from None
                last = found[-1].last
                end = End(*last) if last is not None and self.way != "restart" else None
            return found, end

        return run

    def _verdict(
        self,
        runner: LaneRunner,
        stop: threading.Event,
        row: int,
        column: int,
        behind: End | None,
    ) -> Verdict:
        """Verdict of a motion that begins at its start, or goes on from where one has been last."""
        here = dict(zip(self.names, (self.values[0][column], self.values[1][row]), strict=True))
        try:
            system = self.system.with_parameters(**{k: float(v) for k, v in here.items()})
            runner.set_up(system.parameter_values)
            length = strobe_length(system, self.period)
        except ModelError as fault:
            nothing = np.full(len(self.system.states), np.nan)
            return Verdict(Status.REFUSED.word, str(fault), 0, np.nan, nothing)
        # states that are not given are those at rest, which may depend on the parameters
        start = resolve_start(system, runner.tables, self.initial, None, self.mode, repeated=True)
        if behind is not None:
            start = self._following(runner, start, length, behind.state, behind.mode)
        return settled_regime(self.protocol, system, runner, start, length, stop)

    def _following(
        self,
        runner: LaneRunner,
        start: Start,
        length: float | None,
        state: npt.NDArray[np.float64],
        mode: int,
    ) -> Start:
        """The start at a strobe of another motion; drifts begin where the start itself does."""
        drifting = [name in self.system.drift_states for name in self.system.states]
        number, phase = strobes(runner.window, Instant(0, 0.0), length, self.protocol.phase, 0, 1)
        begin = Instant(int(number[0]), float(phase[0]))
        return Start(np.where(drifting, start.state, state), begin, (SAME - mode,))


def _some_each(places: Places) -> list[Places]:
    return [places[i : i + _TOGETHER] for i in range(0, len(places), _TOGETHER)]


def _key(verdict: Verdict) -> tuple[Any, ...]:
    """What neighbours have in common."""
    if verdict.label not in REPEATING:
        return (verdict.label,)
    count = round(verdict.impacts * verdict.period)
    word = cyclic_word(verdict.word)
    return verdict.label, verdict.period, word, count, verdict.progresses


def _packed(done: Done) -> dict[str, npt.NDArray[Any]]:
    """Verdicts as arrays; what stands in a map, and no reasons."""
    found, end = done
    arrays = {name: np.array([getattr(v, name) for v in found]) for name in _NUMBERS}
    most = max(v.multipliers.size for v in found)
    multipliers = np.full((len(found), most), np.nan, complex)
    for i, verdict in enumerate(found):
        multipliers[i, : verdict.multipliers.size] = verdict.multipliers
    return (
        pack_end(end)
        | arrays
        | {
            "label": np.array([LABELS.index(v.label) for v in found], np.int64),
            "word": np.array([v.word for v in found], str),
            "drift": np.array([v.drift for v in found]),
            "multipliers": multipliers,
        }
    )


def _unpacked(arrays: dict[str, npt.NDArray[Any]]) -> Done:
    end, arrays = take_end(arrays)
    found = []
    for i, label in enumerate(arrays["label"]):
        numbers = {name: arrays[name][i].item() for name in _NUMBERS}
        numbers |= {name: int(numbers[name]) for name in _WHOLE}
        multipliers = arrays["multipliers"][i]
        verdict = Verdict(
            label=LABELS[label], reason="", drift=arrays["drift"][i], word=str(arrays["word"][i]),
            multipliers=multipliers[~np.isnan(multipliers)], **numbers,
        )  # fmt: skip
        found.append(verdict)
    return found, end
