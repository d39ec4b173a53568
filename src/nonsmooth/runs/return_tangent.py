"""Derivative of a return map: that of the flow, taken along the motion onto the section."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.engine.status import CURES, Status
from nonsmooth.errors import RunError
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.maps import tangent_array
from nonsmooth.runs.outputs import StateRates
from nonsmooth.runs.runner import NoMode, build_derivatives
from nonsmooth.runs.section_map import SectionMap
from nonsmooth.runs.section_points import SectionStart, misfit, start_on_section
from nonsmooth.runs.section_search import PATIENCE
from nonsmooth.runs.start import start_at_end
from nonsmooth.runs.strobe_times import is_driven
from nonsmooth.runs.tangent_flow import TangentFlow

__all__ = ["images_of_point", "return_tangent"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def return_tangent(
    chosen: SectionMap,
    initial: Any,
    crossings: int,
    mode: str | None,
    t_start: float | None,
    tolerance: float,
) -> xr.DataArray:
    """Derivative of a point, so many crossings on, by the start."""
    motion = start_on_section(chosen, initial, mode, t_start, True)
    motion = motion._replace(begin=start_at_end(motion.begin))
    try:
        path = _Path(chosen, motion, tolerance)
    except NoMode:
        raise misfit(chosen, motion, tolerance) from None
    for k in range(crossings):
        if path.to_next() != Status.BUFFER_FULL:
            raise _too_few(chosen, path.flow, path.status, k, crossings)
    matrix = path.on_section()
    states = chosen.system.states
    if not is_driven(motion.tables):
        return tangent_array(chosen.system, matrix[:-1] @ path.entry, states)
    # the motion from a later start is that from a start as much behind on the way
    matrix = np.column_stack([matrix @ path.entry, -matrix @ path.first])
    return tangent_array(chosen.system, matrix, (*states, "time"))


def images_of_point(
    chosen: SectionMap, motion: SectionStart, count: int, tolerance: float
) -> tuple[Floats, Integers, Floats] | None:
    """Images of a point with their modes, and the derivative of the last one by the point.

    None where no mode admits the point, the motion ends before, or it only touches the section, as
    a motion at rest does: then there is no derivative.

    returns: states (count, n), modes (count,), derivative (n, n)
    """
    states, modes = [], []
    try:
        path = _Path(chosen, motion, tolerance)
    except NoMode:
        return None
    for k in range(count * chosen.every):
        if path.to_next() != Status.BUFFER_FULL:
            return None
        if (k + 1) % chosen.every == 0:
            state, mode = path.point()
            states.append(state)
            modes.append(mode)
    with np.errstate(invalid="ignore"):  # the time of a point changes without bound at a touch
        derivative = path.on_section()[:-1] @ path.entry
    if not np.all(np.isfinite(derivative)):
        return None
    return np.array(states), np.array(modes), derivative


class _Path:
    """A motion from point to point with its derivatives.

    ``entry`` is what the start itself does to changes of the state: where it lies at an event it
    stays there, and changes along the section are taken through the reset. ``first`` are the
    rates with which the motion begins. `NoMode` where no mode admits the start.
    """

    def __init__(self, chosen: SectionMap, motion: SectionStart, tolerance: float) -> None:
        split = chosen.split
        system = chosen.system if split is None else split.system
        self._motion = motion
        self._side = int(chosen.side == "after")
        self._knots = bool(chosen.system.signals)
        self._rates = StateRates(
            chosen.system, motion.tables, None if split is None else split.origin
        )
        derivatives = build_derivatives(system, motion.tables, ())
        n = len(system.states)
        for mode in motion.begin.modes:
            self.flow = TangentFlow(motion.tables, derivatives, n, tolerance)
            try:
                self._start(mode)
                break
            except NoMode as fault:
                refused = fault
        else:
            raise refused
        flow = self.flow
        self.first = self._rates.at(flow.here, flow.mode, np.array(flow.anchor.state))

    def _start(self, mode: int) -> None:
        begin, flow = self._motion.begin, self.flow
        self.status = flow.start(begin.state, begin.instant, mode)
        self.entry = np.eye(flow.n)
        if flow.passed_at_start and self.status == Status.COMPLETED:
            self.entry = flow.first_columns.T.copy()
            self.status = flow.start(np.array(flow.anchor.state), begin.instant, flow.mode)
        flow.set_columns(flow.first_columns)

    def to_next(self) -> Status:
        """Run to just behind the next point: BUFFER_FULL there, COMPLETED if none came for long."""
        if self.status not in (Status.COMPLETED, Status.BUFFER_FULL):
            return self.status
        flow = self.flow
        end = Instant(flow.here.number + PATIENCE, flow.here.phase)
        while True:
            self.status = flow.run_to(end, one_event=True)
            if self.status != Status.BUFFER_FULL:
                return self.status
            points, _ = self._motion.pick(*flow.last_rows)
            if points.number.size:
                return self.status

    def point(self) -> tuple[Floats, int]:
        """State of the point that has been reached, and its mode in the system."""
        rows, states = self.flow.last_rows
        mode = rows[("from_mode", "to_mode")[self._side]][-1]
        return states[-1, self._side].copy(), int(self._rates.origin[mode])

    def on_section(self) -> Floats:
        """States of the point, and its time last, by the initial states.

        shapes: returns (n + 1, n)
        """
        flow = self.flow
        rows, states = flow.last_rows
        row, state = rows[-1], states[-1, self._side]
        columns = flow.columns if self._side else flow.columns_before_event
        # the moment of a knot of a signal is known, so nothing shifts it
        at_knot = self._knots and row["guard_rate"] == 0.0
        shift = np.zeros(flow.n) if at_knot else -flow.time_shifts
        here = Instant(int(row["number"]), float(row["phase"]))
        rate = self._rates.at(here, int(row[("from_mode", "to_mode")[self._side]]), state)
        return np.vstack([columns.T + np.outer(rate, shift), shift])


def _too_few(
    chosen: SectionMap, flow: TangentFlow, status: Status, count: int, wanted: int
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
