"""Settled motions at many values of a parameter, reduced to a few arrays; parts of a dataset."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.chain_links import End, check_way, links_of, pack_end, take_end
from nonsmooth.analysis.diagrams.strobe_periods import said_of_restless
from nonsmooth.analysis.options import SharedOptions, result_attributes
from nonsmooth.analysis.settle import ParameterSets, at_time_zero, said_of_start, settle
from nonsmooth.analysis.statistics.periodicity import REPEATS
from nonsmooth.analysis.sweeps.settled import SweptMotion, reduce_settled
from nonsmooth.engine.status import Status
from nonsmooth.errors import OptionError
from nonsmooth.runs.of_system import map_of
from nonsmooth.runs.options import whole_number
from nonsmooth.runs.runner import build_tables
from nonsmooth.runs.start import check_carried, resolve_start
from nonsmooth.runs.stored_tasks import run_stored_tasks
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.runs.sweep_runner import SweepRunner, motions_per_task
from nonsmooth.system.system import System

__all__ = [
    "SweepProtocol",
    "Swept",
    "make_sweep",
    "motion_periods",
    "parameter_coordinate",
    "run_sweep",
    "stacked",
    "statuses",
    "sweep_attributes",
]

Arrays = dict[str, npt.NDArray[Any]]
Done = tuple[list[Arrays], End | None]  # of some values, and where the last motion has ended
Reduce = Callable[[SweptMotion], Arrays]


@dataclass(frozen=True)
class SweepProtocol:
    """How the motions of a sweep are computed."""

    chosen: StroboscopicMap
    initial: Any
    start: str
    transient: int
    record: int
    shared: SharedOptions

    @property
    def system(self) -> System:
        """The system with the parameters of the call."""
        return self.chosen.system

    @property
    def options(self) -> dict[str, Any]:
        """What of the options stands in a result."""
        return {
            "start": self.start,
            "transient": self.transient,
            "record": self.record,
            **self.chosen.protocol,
            **self.shared.recorded,
            "initial": said_of_start(self.initial),
        }


@dataclass(frozen=True)
class Swept:
    """What a sweep has come to: values that are done, their results, and whether these are all."""

    values: npt.NDArray[np.float64]
    found: list[Arrays]
    complete: bool


def make_sweep(
    system: Any,
    verb: str,
    *,
    initial: Any,
    start: str,
    transient: Any,
    record: Any,
    shared: SharedOptions,
) -> SweepProtocol:
    """The options that all sweeps share, checked."""
    chosen = map_of(
        system, shared.parameters, shared.tolerance, verb, mode=shared.mode, strobes_only=True
    )
    if not isinstance(chosen, StroboscopicMap):
        raise OptionError(
            f"{verb} looks at whole periods: give it a system, or a StroboscopicMap with the length"
            " of a period"
        )
    return SweepProtocol(
        chosen, initial, check_way(start),
        whole_number("transient", transient, 0),
        whole_number("record", record), shared,
    )  # fmt: skip


def run_sweep(
    sweep: SweepProtocol,
    parameter: str,
    grid: npt.NDArray[np.float64],
    reduce: Reduce,
    *,
    call: str,
    options: Mapping[str, Any],
) -> Swept:
    """What ``reduce`` makes of the motion at each value, with its ``status``.

    Where a motion ended early there is only the status. Values that were not computed, as the user
    interrupted, are left out.
    """
    system, shared = sweep.system, sweep.shared
    check_carried(system, sweep.initial, shared.parameters, (parameter,))
    begin = resolve_start(system, build_tables(system), sweep.initial, None, shared.mode, True)
    found = {} if parameter else {0: {"status": np.array(int(Status.INTERRUPTED))}}
    links = links_of(grid, sweep.start, motions_per_task(grid.size))
    follow = sweep.start != "restart"
    ends: dict[int, End | None] = {}
    sets = ParameterSets(
        sweep.chosen, {parameter: grid} if parameter else {}, sweep.initial, shared.mode,
        at_time_zero,
    )  # fmt: skip
    tasks: list[Any] = [
        partial(
            settle,
            sets=sets,
            which=places,
            times=lambda group: group.iterates(sweep.transient, 1),
            reduce=partial(reduce_settled, reduce, sweep.transient, sweep.record),
            follow=partial(ends.get, i - 1) if follow else None,
            alone=follow,
        )
        for i, places in enumerate(links)
    ]  # fmt: skip

    def keep(i: int, done: Done) -> None:
        found.update(zip(links[i], done[0], strict=True))
        ends[i] = done[1]

    complete = run_stored_tasks(
        tasks,
        lambda: SweepRunner(system, shared.tolerance),
        store=shared.store,
        protocol={
            "call": call, "system": system.to_toml(), "parameter": parameter, "values": grid,
            **sweep.options, **options, "initial_state": [*begin.state, *begin.modes],
        },
        pack=_pack,
        unpack=_unpack,
        threads=shared.workers,
        label=call.replace("_", " "),
        keep=keep,
        after={i: i - 1 for i in range(1, len(links))} if follow else None,
    )  # fmt: skip
    done = sorted(found)
    return Swept(grid[done], [found[i] for i in done], complete)


def _pack(done: Done) -> Arrays:
    results, end = done
    return pack_end(end) | {
        f"{i}.{name}": a for i, one in enumerate(results) for name, a in one.items()
    }


def _unpack(arrays: Arrays) -> Done:
    end, arrays = take_end(arrays)
    results: list[Arrays] = []
    for key, array in arrays.items():
        number, _, name = key.partition(".")
        while len(results) <= int(number):
            results.append({})
        results[int(number)][name] = array
    return results, end


def parameter_coordinate(system: System, parameter: str, grid: npt.NDArray[np.float64]) -> Any:
    """Coordinate of the parameter with its label."""
    return ("parameter",), grid, {"long_name": system.describe.get(parameter, parameter)}


def statuses(found: Sequence[Arrays]) -> Any:
    """How the motions ended."""
    words = [Status(int(one["status"])).word for one in found]
    return ("parameter",), np.array(words, str), {"long_name": "how the motion ended"}


def stacked(found: Sequence[Arrays], name: str, shape: tuple[int, ...]) -> npt.NDArray[np.float64]:
    """One array of each motion below each other; nan where a motion has none."""
    rows = np.full((len(found), *shape), np.nan)
    for i, one in enumerate(found):
        rows[i] = one.get(name, np.nan)
    return rows


def motion_periods(found: Sequence[Arrays]) -> Any:
    """Period of each motion; 0 where its strobes show none, or where it ended early."""
    periods = np.array([int(one.get("motion_period", 0)) for one in found], np.int64)
    label = "period of the motion in periods of the forcing, 0 for none"
    return ("parameter",), periods, {"long_name": label}


def sweep_attributes(
    sweep: SweepProtocol, swept: Swept, options: Mapping[str, Any]
) -> dict[str, Any]:
    """Attributes: the system, how it went, and the options."""
    status = "completed" if swept.complete else "interrupted"
    return result_attributes(sweep.system, status, _message(sweep, swept), options)


def _message(sweep: SweepProtocol, swept: Swept) -> str:
    """How the motions ended, and how many of them show no period."""
    found = swept.found
    ended = {Status(int(one["status"])).word for one in found} - {Status.COMPLETED.word}
    if not swept.complete:
        return (
            f"interrupted by the user; {len(found)} values are done and kept, the others are left"
            " out"
        )
    message = "completed"
    if ended:
        message = "some motions ended early, see status: " + ", ".join(sorted(ended))
    periods = [int(one["motion_period"]) for one in found if "motion_period" in one]
    if sweep.record < REPEATS and periods:
        return f"{message}; record = {sweep.record} is too short to tell whether motions settled"
    if restless := periods.count(0):
        length = sweep.transient + sweep.record
        message += "; " + said_of_restless(
            restless, len(periods), sweep.record, length, "period", "transient"
        )
    return message
