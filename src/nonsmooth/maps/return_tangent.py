"""Derivative of a return map: that of the flow, taken along the motion onto the section."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.engine import records as at
from nonsmooth.engine.layout import Tables
from nonsmooth.engine.status import CURES, Status
from nonsmooth.errors import RunError
from nonsmooth.maps.rates import Rates
from nonsmooth.maps.section_points import SectionStart, misfit, start_on_section
from nonsmooth.maps.section_search import PATIENCE
from nonsmooth.simulation.clock import Instant
from nonsmooth.simulation.runner import NoMode, build_derivatives
from nonsmooth.simulation.start import start_at_end
from nonsmooth.simulation.tangent_flow import TangentFlow
from nonsmooth.system.system import System

if TYPE_CHECKING:
    from nonsmooth.maps.poincare import PoincareMap

__all__ = ["return_tangent", "tangent_array"]

Floats = npt.NDArray[np.float64]


def return_tangent(
    chosen: PoincareMap,
    initial: Any,
    crossings: int,
    mode: str | None,
    t_start: float | None,
    tolerance: float,
) -> xr.DataArray:
    """Derivative of a point, so many crossings on, by the start."""
    motion = start_on_section(chosen, initial, mode, t_start, True)
    if motion.begin.anchor is not None:
        motion = motion._replace(begin=start_at_end(motion.begin))
    flow, status, entry = _started(chosen, motion, tolerance)
    split = chosen.split
    rates = Rates(chosen.system, motion.tables, None if split is None else split.origin)
    first = rates.at(flow.here, flow.mode, np.array(flow.anchor.state))
    for k in range(crossings):
        if status == Status.COMPLETED:
            status = _to_next(flow, motion)
        if status != Status.BUFFER_FULL:
            raise _too_few(chosen, flow, status, k, crossings)
        status = Status.COMPLETED
    matrix = _on_section(chosen, flow, rates)
    states = chosen.system.states
    if not _reads_time(motion.tables):
        return tangent_array(chosen.system, matrix[:-1] @ entry, states)
    # the motion from a later start is that from a start as much behind on the way
    matrix = np.column_stack([matrix @ entry, -matrix @ first])
    return tangent_array(chosen.system, matrix, (*states, "time"))


def tangent_array(system: System, matrix: Floats, names: Sequence[str]) -> xr.DataArray:
    """Derivatives of the coordinates of an image by those of the start."""
    coords = {
        "state": ("state", np.array(names)),
        "state_0": ("state_0", np.array(names), {"long_name": "initial state"}),
    }
    label = "derivatives of the image by the start"
    attrs = {"long_name": label, "system_name": system.name}
    return xr.DataArray(matrix, coords, ("state", "state_0"), name="tangent", attrs=attrs)


def _started(
    chosen: PoincareMap, motion: SectionStart, tolerance: float
) -> tuple[TangentFlow, Status, Floats]:
    """Flow at its start, in the first of the modes that admits it.

    Also what the start itself does to changes of the state: where it lies at an event it stays
    there, and changes along the section are taken through the reset.
    """
    system = chosen.system if chosen.split is None else chosen.split.system
    derivatives = build_derivatives(system, motion.tables, ())
    begin = motion.begin
    n = len(system.states)
    for mode in begin.modes:
        flow = TangentFlow(motion.tables, derivatives, n, tolerance)
        try:
            status = flow.start(begin.state, begin.instant, mode)
            entry = np.eye(n)
            if flow.passed_at_start and status == Status.COMPLETED:
                entry = flow.first_columns.T.copy()
                status = flow.start(np.array(flow.anchor.state), begin.instant, flow.mode)
        except NoMode:
            continue
        flow.set_columns(flow.first_columns)
        return flow, status, entry
    raise misfit(chosen, motion, tolerance)


def _to_next(flow: TangentFlow, motion: SectionStart) -> Status:
    """Run to just behind the next point; COMPLETED where none came for long."""
    end = Instant(flow.here.number + PATIENCE, flow.here.phase)
    while True:
        status = flow.run_to(end, one_event=True)
        if status != Status.BUFFER_FULL:
            return status
        points, _ = motion.pick(*flow.last_rows)
        if points.number.size:
            return status


def _on_section(chosen: PoincareMap, flow: TangentFlow, rates: Rates) -> Floats:
    """States of the point, and its time last, by the initial states.

    shapes: returns (n + 1, n)
    """
    rows, values = flow.last_rows
    row, value = rows[-1], values[-1]
    after = chosen.side == "after"
    columns = flow.columns if after else flow.columns_before_event
    # the moment of a knot of a signal is known, so nothing shifts it
    at_knot = bool(chosen.system.signals) and value[at.GUARD_RATE] == 0.0
    shift = np.zeros(flow.n) if at_knot else -flow.time_shifts
    state = value[at.EVENT_FLOATS :].reshape(2, -1)[int(after)]
    here = Instant(int(row[at.NUMBER]), float(value[at.PHASE]))
    rate = rates.at(here, int(row[at.TO if after else at.FROM]), state)
    return np.vstack([columns.T + np.outer(rate, shift), shift])


def _reads_time(tables: Tables) -> bool:
    """Whether the system, or the section, depends on time."""
    _, powers, frequencies, *_ = (int(size) for size in tables.sizes)
    return powers > 0 or frequencies > 0 or tables.signals.shape[0] > 0


def _too_few(
    chosen: PoincareMap, flow: TangentFlow, status: Status, count: int, wanted: int
) -> RunError:
    time = flow.here.time(flow.window)
    why = CURES.get(status, "")
    if status == Status.COMPLETED:
        why = f"none came in the last {PATIENCE} periods or windows"
    return RunError(
        f"{chosen.system.name}: {count} of {wanted} points on section = {chosen.section!r} until"
        f" t = {time:.9g}, so there is no derivative: {why}",
        status="time_limit" if status == Status.COMPLETED else status.word,
        time=time,
    )
