"""Which rows of an event log are points of a section."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.record import Rows, columns
from nonsmooth.engine.status import Certificate, EventKind
from nonsmooth.engine.tables import Tables, exits_of_path, members
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.outputs import SampleClock, output_values
from nonsmooth.runs.section_search import Pick, SectionPoints, some_points
from nonsmooth.system.section import Section
from nonsmooth.system.system import System

__all__ = ["AT_ONCE", "BehindStart", "Crossings", "NamedEvents", "behind_start", "event_names"]

Integers = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

_SMALL = 1e-9  # part of its terms, within which an expression is zero at an event
_PASSAGE = "from_mode", "to_mode", "path", "passes"  # what tells events apart
AT_ONCE = 1e-12  # part of a window; a point so soon after a start is the start up to rounding
_SHIFT = 1e-4  # relative change of a state that tells the size of the terms it stands in


class Crossings:
    """Instants at which the motion goes through a section; a jump over it is none."""

    def __init__(self, section: Section, tables: Tables, direction: int) -> None:
        self.section = section
        self.tables = tables
        self.direction = direction
        self.knots = bool(section.system.signals)

    def __call__(self, rows: Rows, states: Floats) -> tuple[SectionPoints, Flags]:
        """Points among rows of the event log, and which rows are open contacts."""
        section = self.section
        before, after = rows["from_mode"], rows["to_mode"]
        way = section.side[after]
        grazes = rows["kind"] == EventKind.GRAZE
        open_ = grazes & (rows["exit"] >= 0) & (rows["exit"] == section.gate[before])
        crosses = (section.side[before] * way < 0) & ~grazes
        crosses &= rows["kind"] != EventKind.START
        if self.direction:
            crosses &= way == self.direction
        # a jump may lead over the section, as may an input whose rate jumps at a knot
        doubtful = crosses & (rows["passes"] > 1)
        doubtful |= crosses & self.knots & (rows["guard_rate"] == 0.0)
        if doubtful.any():
            crosses[doubtful] = self._go_through(rows[doubtful], states[doubtful])
        here = np.flatnonzero(crosses)
        points = _points(rows, states, here, section.origin, way[here])
        # nothing but the side has changed, and behind it the state lies on the section exactly
        plain = rows["passes"][here] == 1
        points.states[0, plain] = points.states[1, plain]
        return points, open_

    def is_own(self, row: Any) -> bool:
        """Whether a row would not be there without the section."""
        return bool(row["exit"] >= 0 and row["exit"] == self.section.gate[row["from_mode"]])

    def _go_through(self, rows: Rows, states: Floats) -> Flags:
        """Whether the expression is continuous at events with several exits, or at knots."""
        found = np.zeros(len(rows), bool)
        at_knot = self.knots & (rows["guard_rate"] == 0.0)
        kinds = np.column_stack([columns(rows, *_PASSAGE), at_knot])
        distinct, which = np.unique(kinds, axis=0, return_inverse=True)
        for k in range(len(distinct)):  # events that pass the same exits
            here = np.flatnonzero(which.ravel() == k)
            found[here] = self._all_go_through(rows[here], states[here], bool(distinct[k, -1]))
        return found

    def _all_go_through(self, rows: Rows, states: Floats, at_knot: bool) -> Flags:
        """The same for events that pass the same exits."""
        row = rows[0]
        before, after = int(row["from_mode"]), int(row["to_mode"])
        if at_knot:
            return self._vanish(rows, after, states[:, 1])
        read = self._states_read(before) | self._states_read(after)
        if read & self._states_reset(row):
            return self._vanish(rows, before, states[:, 0]) & self._vanish(
                rows, after, states[:, 1]
            )
        first, one = self._values(rows, before, states[:, 1])
        second, other = self._values(rows, after, states[:, 1])
        same: Flags = np.abs(first - second) <= _SMALL * (one + other)
        return same

    def _states_read(self, mode: int) -> set[str]:
        """States on which the expression depends in a mode."""
        system = self.section.system
        forms = system.structure.running[mode]
        equation = system.structure.outputs[self.section.value]
        return forms.graph.states_in(forms.resolver.lenient().tree(equation))

    def _states_reset(self, row: Any) -> set[str]:
        """States that jump at an event."""
        wiring, mode = self.tables.wiring, int(row["from_mode"])
        states = self.section.system.states
        reset: set[str] = set()
        for way in exits_of_path(int(row["path"]), int(row["passes"])):
            jumping = members(wiring.exits["resetting"][mode, way], len(states))
            reset.update(state for state, jumps in zip(states, jumping, strict=True) if jumps)
            mode = int(wiring.exits["target"][mode, way])
        return reset

    def _vanish(self, rows: Rows, mode: int, states: Floats) -> Flags:
        value, size = self._values(rows, mode, states)
        none: Flags = np.abs(value) <= _SMALL * size
        return none

    def _values(self, rows: Rows, mode: int, states: Floats) -> tuple[Floats, Floats]:
        """Values of the expression at events, and the size of its terms there."""
        count, n = states.shape
        shifts = np.vstack([np.ones(n), 1.0 + _SHIFT * np.eye(n)])
        shifted = (states[:, None] * shifts).reshape(-1, n)
        number = np.repeat(rows["number"], n + 1)
        phase = np.repeat(rows["phase"], n + 1)
        system = self.section.system
        clock, modes = SampleClock(number, phase, self.tables), np.full(number.size, mode)
        found = output_values(system, clock, shifted.T, modes)[self.section.value]
        whole = np.broadcast_to(found, number.shape).reshape(count, n + 1)
        return whole[:, 0], np.abs(whole[:, 1:] - whole[:, :1]).sum(axis=1) / _SHIFT


class NamedEvents:
    """Instants at which an exit of a name is passed, or a mode of that name entered."""

    def __init__(self, system: System, name: str) -> None:
        self.labels = labels_of(system)
        self.name = name
        running = system.structure.running
        self.modes = np.array([name in (m.label, m.parent, m.name) for m in running])
        self.origin = np.arange(len(running))

    def __call__(self, rows: Rows, states: Floats) -> tuple[SectionPoints, Flags]:
        """Points among rows of the event log, and which rows are open contacts."""
        kinds = columns(rows, "from_mode", "path", "passes", "to_mode")
        distinct, which = np.unique(kinds, axis=0, return_inverse=True)
        meant = np.array([self._is_meant(*map(int, kind)) for kind in distinct], bool)
        meant = meant[which.ravel()] if len(rows) else np.zeros(0, bool)
        meant &= rows["kind"] != EventKind.START
        grazes = rows["kind"] == EventKind.GRAZE
        here = np.flatnonzero(meant & ~grazes)
        none = np.zeros(here.size, np.int64)
        return _points(rows, states, here, self.origin, none), meant & grazes

    def is_own(self, row: Any) -> bool:
        """Whether a row would not be there without the section: events always are."""
        return False

    def _is_meant(self, before: int, path: int, passes: int, after: int) -> bool:
        entered = bool(self.modes[after] and not self.modes[before])
        return entered or self.name in self.labels.path(before, path, passes).split(">")


class BehindStart:
    """Points that another pick finds, without the start itself."""

    def __init__(self, pick: Pick, begin: Instant, window: float, within: float = AT_ONCE) -> None:
        self.pick, self.begin, self.window, self.within = pick, begin, window, within

    def __call__(self, rows: Rows, states: Floats) -> tuple[SectionPoints, Flags]:
        """Points among rows of the event log, and which rows are open contacts."""
        points, open_ = self.pick(rows, states)
        return behind_start(points, self.begin, self.window, self.within), open_

    def is_own(self, row: Any) -> bool:
        """Whether a row would not be there without the section."""
        return self.pick.is_own(row)


def behind_start(
    points: SectionPoints, begin: Instant, window: float, within: float = AT_ONCE
) -> SectionPoints:
    """Points without those that are the start up to rounding, from which a motion goes on.

    ``within`` is the part of a window up to which they are.
    """
    since = (points.number - begin.number) * window + (points.phase - begin.phase)
    late = since > within * window
    return points if late.all() else some_points(points, np.flatnonzero(late))


def event_names(system: System) -> set[str]:
    """Names of the exits, and of the modes that they enter."""
    names = {way for of_mode in system.compiled.exit_names for way in of_mode}
    running = system.structure.running
    targets = {target for m in running for target in m.targets if target >= 0}
    for target in targets:
        names |= {running[target].label, running[target].parent}
    return names


def _points(
    rows: Rows, states: Floats, here: Integers, origin: Integers, direction: Integers
) -> SectionPoints:
    rows = rows[here]
    return SectionPoints(
        here,
        rows["number"].copy(),
        rows["phase"].copy(),
        origin[columns(rows, "from_mode", "to_mode").T],
        states[here].transpose(1, 0, 2).copy(),
        direction.copy(),
        rows["certificate"] == Certificate.CERTIFIED,
    )
