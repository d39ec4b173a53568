"""Derivative of a return map: that of the flow, taken along the motion onto the section."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.engine import records as at
from nonsmooth.engine.layout import Tables
from nonsmooth.engine.status import CURES, Status
from nonsmooth.errors import RunError
from nonsmooth.maps.section_points import SectionStart, misfit, start_on_section
from nonsmooth.maps.section_search import PATIENCE
from nonsmooth.simulation.clock import Instant
from nonsmooth.simulation.outputs import Clock, output_values
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
    flow, status = _started(chosen, motion, tolerance)
    rates = _Rates(chosen, motion.tables)
    first = rates.at(flow.here, flow.mode, motion_state(flow))
    for k in range(crossings):
        if status == Status.COMPLETED:
            status = _to_next(flow, motion)
        if status != Status.BUFFER_FULL:
            raise _too_few(chosen, flow, status, k, crossings)
        status = Status.COMPLETED
    matrix = _on_section(chosen, flow, rates)
    states = chosen.system.states
    if not _reads_time(motion.tables):
        return tangent_array(chosen.system, matrix[:-1], states)
    # the motion from a later start is that from a start as much behind on the way
    return tangent_array(
        chosen.system, np.column_stack([matrix, -matrix @ first]), (*states, "time")
    )


def tangent_array(system: System, matrix: Floats, names: Sequence[str]) -> xr.DataArray:
    """Derivatives of the coordinates of an image by those of the start."""
    coords = {
        "state": ("state", np.array(names)),
        "state_0": ("state_0", np.array(names), {"long_name": "initial state"}),
    }
    label = "derivatives of the image by the start"
    attrs = {"long_name": label, "system_name": system.name}
    return xr.DataArray(matrix, coords, ("state", "state_0"), name="tangent", attrs=attrs)


def motion_state(flow: TangentFlow) -> Floats:
    """State at the anchor."""
    return np.array(flow.anchor.state)


def _started(
    chosen: PoincareMap, motion: SectionStart, tolerance: float
) -> tuple[TangentFlow, Status]:
    """Flow at its start, in the first of the modes that admits it."""
    system = chosen.system if chosen.split is None else chosen.split.system
    derivatives = build_derivatives(system, motion.tables, ())
    begin = motion.begin
    for mode in begin.modes:
        flow = TangentFlow(motion.tables, derivatives, len(system.states), tolerance)
        try:
            status = flow.start(begin.state, begin.instant, mode)
        except NoMode:
            continue
        flow.set_columns(flow.first_columns)
        return flow, status
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


def _on_section(chosen: PoincareMap, flow: TangentFlow, rates: _Rates) -> Floats:
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


class _Rates:
    """Rates of the states anywhere, from their equations."""

    def __init__(self, chosen: PoincareMap, tables: Tables) -> None:
        split = chosen.split
        n_modes = len(chosen.system.mode_names)
        self.origin = np.arange(n_modes) if split is None else split.origin
        self.system, self.names = _with_rates(chosen.system)
        self.tables = tables

    def at(self, here: Instant, mode: int, state: Floats) -> Floats:
        """Rates at an instant, in a mode of the system with the section in it."""
        clock = Clock(np.array([here.number]), np.array([here.phase]), self.tables)
        modes = self.origin[[mode]]
        found = output_values(self.system, clock, state[:, None], modes)
        return np.array([float(found[name][0]) for name in self.names])


@lru_cache(maxsize=32)
def _with_rates(system: System) -> tuple[System, tuple[str, ...]]:
    """System with the rate of each state as an output, and their names."""
    taken = {*system.states, *system.outputs, *system.definitions, *system.parameters}
    names = []
    for state in system.states:
        name = f"rate_of_{state}"
        while name in taken:
            name += "_"
        names.append(name)
    rates = {name: f"rate({state})" for name, state in zip(names, system.states, strict=True)}
    return replace(system, outputs={**system.outputs, **rates}), tuple(names)
