"""Points of one motion, one per period, and their derivatives."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.status import CURES, Status
from nonsmooth.errors import RunError, RunWarning
from nonsmooth.runs.assemble import Columns, assemble
from nonsmooth.runs.clock import Instant, Plan
from nonsmooth.runs.dataset import run_dataset
from nonsmooth.runs.first_mode import in_first_mode
from nonsmooth.runs.options import check_count, check_signals
from nonsmooth.runs.return_tangent import tangent_array
from nonsmooth.runs.runner import Outcome, build_derivatives, build_tables, run_plan
from nonsmooth.runs.start import Start, resolve_start, start_at_end
from nonsmooth.runs.stroboscopic import strobes
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.runs.stroboscopic_map import StroboscopicMap

__all__ = ["Wanted", "strobe_points", "strobe_tangent"]

_SAME = 1e-12  # of a strobe period, within which two times are one


class Wanted(NamedTuple):
    """Which strobes of a motion, and from where.

    ``from_start``: count them from the first strobe that is not before the start, otherwise from
    the first one after it, mappings of states being at the phase of the strobe.
    """

    initial: Any
    transient: int
    record: int
    from_start: bool
    mode: str | None
    t_start: float | None
    tolerance: float
    repeated: bool


def strobe_points(chosen: StroboscopicMap, wanted: Wanted, changed: str = "") -> xr.Dataset:
    """Dataset of the points of one motion; a warning where it ended early."""
    system = chosen.system
    outcome = _run(chosen, wanted, derivatives=False)
    options = chosen.protocol | {
        "transient": wanted.transient,
        "record": wanted.record,
        "tolerance": float(wanted.tolerance),
        "changed_parameters": changed,
    }
    points = _over_points(system, run_dataset(system, outcome, options), options)
    if not wanted.from_start:
        label = {"long_name": "iterate"}
        points = points.assign_coords(point=("point", points["point"].values + 1, label))
    if outcome.status not in (Status.COMPLETED, Status.STOPPED):
        # told where the user calls the verb or method that calls this
        warnings.warn(f"{system.name}: {points.attrs['message']}", RunWarning, stacklevel=3)
    return points


def strobe_tangent(chosen: StroboscopicMap, wanted: Wanted) -> xr.DataArray:
    """Derivative of the last of some strobes by the start."""
    system = chosen.system
    outcome = _run(chosen, wanted, derivatives=True)
    if outcome.n_samples < wanted.record:
        status = outcome.status
        raise RunError(
            f"{system.name}: {status.word} at t = {outcome.end_time:.9g}, so there is no"
            f" derivative: {CURES.get(status, '')}",
            status=status.word,
            time=outcome.end_time,
        )
    assert outcome.columns is not None
    return tangent_array(system, outcome.columns[-1].T.copy(), system.states)


def _run(chosen: StroboscopicMap, wanted: Wanted, *, derivatives: bool) -> Outcome:
    system = chosen.system
    tables = build_tables(system)
    window = tables.window
    start = resolve_start(
        system, tables, wanted.initial, wanted.t_start, wanted.mode, wanted.repeated
    )
    if derivatives and start.anchor is not None:
        start = start_at_end(start)
    first = wanted.transient
    if not wanted.from_start:
        start, first = _behind(chosen, wanted, start, window)
    every = chosen.every
    numbers, phases = strobes(
        window, start.instant, chosen.length, chosen.phase, first,
        check_count((wanted.record - 1) * every + 1),
    )  # fmt: skip
    numbers, phases = numbers[::every].copy(), phases[::every].copy()
    plan = Plan(Instant(int(numbers[-1]), float(phases[-1])), numbers, phases)
    check_signals(system, start.instant.time(window), plan.end.time(window))
    carried = build_derivatives(system, tables, () if derivatives else None)

    def run(mode: int) -> Outcome:
        return run_plan(
            tables, plan, wanted.tolerance, anchor=start.anchor, state=start.state,
            begin=start.instant, mode=mode, keep_events=False, derivatives=carried,
        )  # fmt: skip

    return in_first_mode(system, tables, start, run)


def _behind(
    chosen: StroboscopicMap, wanted: Wanted, start: Start, window: float
) -> tuple[Start, int]:
    """Start, and the number of its image among the strobes that are not before it."""
    length, phase, every = chosen.length, chosen.phase, chosen.every
    if not hasattr(wanted.initial, "data_vars"):  # states at the phase of the strobe
        number, at = strobes(window, Instant(0, 0.0), length, phase, 0, 1)
        return Start(start.state, Instant(int(number[0]), float(at[0])), start.modes), every
    numbers, phases = strobes(window, start.instant, length, phase, 0, 1)
    wait = (int(numbers[0]) - start.instant.number) * window + (
        float(phases[0]) - start.instant.phase
    )
    # a start at a strobe up to rounding is at it, and one just behind it comes after it anyway
    rounding = _SAME * (window if length is None else length)
    rounding += 4.0 * np.finfo(float).eps * abs(start.instant.time(window))
    return start, every if wait <= rounding else every - 1


def _over_points(system: System, run: xr.Dataset, options: dict[str, Any]) -> xr.Dataset:
    """The samples of a run as points of a map."""
    names = (*system.states, *system.outputs, "mode")
    variables: Columns = {
        name: (("point",), run[name].values, dict(run[name].attrs)) for name in names
    }
    number: npt.NDArray[np.int64] = np.arange(run.sizes["time"])
    coords: Columns = {
        "point": (("point",), number, {"long_name": "strobe"}),
        "time": (("point",), run["time"].values, dict(run["time"].attrs)),
    }
    kept = (
        "system", "system_name", "nonsmooth_version", "status", "message", "certified",
        "n_uncertain", "n_estimated", *options,
    )  # fmt: skip
    attrs = {name: run.attrs[name] for name in kept if name in run.attrs}
    return assemble(variables, coords, {}, attrs)
