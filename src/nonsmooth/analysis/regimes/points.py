"""Regimes of points of a parameter plane, spread over threads and kept in a folder."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.chain_links import End, pack_end, take_end
from nonsmooth.analysis.regimes.label_grid import LabelGrid
from nonsmooth.analysis.regimes.labels import LABELS, Verdict
from nonsmooth.analysis.regimes.options import RegimeProtocol
from nonsmooth.analysis.regimes.regime_run import first_windows, settled_regimes
from nonsmooth.analysis.settle import ParameterSets, settle
from nonsmooth.runs.devices import device_for
from nonsmooth.runs.stored_tasks import run_stored_tasks
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.runs.sweep_runner import SweepRunner, motions_per_task

__all__ = ["Plane"]

_IN_A_ROW = 16  # points in a task whose motions follow each other: some hundredths of a second
_ON_DEVICE = 4096  # points in a task on a graphics device
_NUMBERS = (
    "transient_used", "length", "period", "events", "impacts", "exponent", "error", "k",
    "residual", "chaotic_for", "uncertain", "estimated", "progresses",
)  # fmt: skip
_WHOLE = ("transient_used", "period", "chaotic_for", "uncertain", "estimated", "progresses")

Places = npt.NDArray[np.int64]
Done = tuple[list[Verdict], End | None]  # of some points, and where the last motion has ended


@dataclass
class Plane:
    """Verdicts over two parameters; places are (number of the second, number of the first)."""

    protocol: RegimeProtocol
    chosen: StroboscopicMap
    names: tuple[str, str]
    values: tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]
    initial: Any
    mode: str | None
    tolerance: float
    threads: int
    store: str | Path | None
    way: str  # restart, or follow up or down the first parameter
    told: Mapping[str, Any]  # all that the results depend on, for the store

    def __post_init__(self) -> None:
        shape = (self.values[1].size, self.values[0].size)
        self.grid = LabelGrid(shape)
        self._step = 0
        self._on_device = self.way == "restart" and device_for(self.chosen.system) is not None
        # of a device, whose tasks are others
        self._stored_with = {**self.told, "device": "gpu"} if self._on_device else self.told

    def compute(self, places: Places) -> bool:
        """Verdicts of some places; False where the user interrupted."""
        parts, after = self._parts(places)
        ends: dict[int, End | None] = {}

        def keep(i: int, done: Done) -> None:
            # of a task that was stopped the last points are missing
            for (row, column), verdict in zip(parts[i], done[0], strict=False):
                self.grid.verdicts[row, column] = verdict
            ends[i] = done[1]

        store = self.store
        if store is not None and self._step:
            store = Path(store) / f"step-{self._step:03d}"
        self._step += 1
        complete = run_stored_tasks(
            [self._task(part, after.get(i), ends) for i, part in enumerate(parts)],
            lambda: SweepRunner(self.chosen.system, self.tolerance),
            store=store,
            protocol=self._stored_with,
            pack=_packed,
            unpack=_unpacked,
            threads=self.threads,
            label="regime map" if self._step == 1 else "regime map, borders",
            keep=keep,
            after=after,
            parts=True,
        )
        self.grid.number(places)
        return complete

    def _parts(self, places: Places) -> tuple[list[Places], dict[int, int]]:
        """Places of each task, in an order that equal work has whenever it is done again.

        Motions that follow each other are those of one row; with the task that each one follows.
        """
        if self.way == "restart":
            size = _ON_DEVICE if self._on_device else motions_per_task(len(places))
            return _some_each(places, size), {}
        rows = np.split(places, np.flatnonzero(np.diff(places[:, 0])) + 1)
        parts: list[Places] = []
        after: dict[int, int] = {}
        for row in rows:
            ordered = row if self.way == "follow up" else row[::-1]
            for k, part in enumerate(_some_each(ordered, _IN_A_ROW)):
                if k:
                    after[len(parts)] = len(parts) - 1
                parts.append(part)
        return parts, after

    def _task(
        self, places: Places, before: int | None, ends: dict[int, End | None]
    ) -> Callable[[SweepRunner, threading.Event], Done]:
        """Verdicts of motions that begin at their starts, or go on from where one was last."""
        follow = self.way != "restart"
        over = {
            name: values[places[:, axis]]
            for name, values, axis in zip(self.names, self.values, (1, 0), strict=True)
        }
        return partial(
            settle,
            sets=ParameterSets(self.chosen, over, self.initial, self.mode),
            times=partial(first_windows, self.protocol),
            reduce=partial(settled_regimes, self.protocol),
            follow=partial(ends.get, -1 if before is None else before) if follow else None,
            alone=follow,
        )


def _some_each(places: Places, size: int) -> list[Places]:
    return [places[i : i + size] for i in range(0, len(places), size)]


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
