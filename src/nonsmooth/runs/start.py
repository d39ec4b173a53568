"""Where a run starts: from names, from a point of a dataset, or from the end of a run."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.derivatives import no_rates, no_scratch
from nonsmooth.engine.lanes import (
    Anchor,
    allocate_anchor,
    allocate_records,
    allocate_segment,
    allocate_tangent,
    run,
)
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import Tables
from nonsmooth.errors import OptionError, quote, unknown_name
from nonsmooth.real_numbers import finite_real
from nonsmooth.runs.clock import Instant, instants
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.options import finite_number
from nonsmooth.system.system import System

__all__ = [
    "GOES_ON",
    "Start",
    "begin",
    "carried_parameters",
    "check_carried",
    "complete_state",
    "mode_numbers",
    "refuse_other_parameters",
    "resolve_start",
    "start_at_end",
    "unknown_state",
]


_TOLERANCE = 1e-12
# statuses of runs that go on where they ended
GOES_ON = (Status.COMPLETED.word, Status.WORK_LIMIT.word, Status.INTERRUPTED.word)
_NO_TIMES = (np.zeros(0, np.int64), np.zeros(0))
_TIMES = {"time", "phase", "period_number"}  # coordinates of any result


@dataclass(frozen=True)
class Start:
    """State, instant and modes of a start, or the anchor of a run to go on from.

    One of the ``modes`` is to admit the start; -1 stands for any.
    """

    state: npt.NDArray[np.float64]
    instant: Instant
    modes: tuple[int, ...] = (-1,)
    anchor: Anchor | None = None


def resolve_start(
    system: System,
    tables: Tables,
    initial: Any,
    t_start: float | None = None,
    mode: str | None = None,
    repeated: bool = True,
) -> Start:
    """Start of a run from what the user gave.

    ``repeated`` says whether the user has given parameters again with a point of a dataset. Where
    he has not, a run of other parameters is refused.
    """
    if hasattr(initial, "data_vars"):
        _check_states(system, initial)
        if "time" in initial.dims:
            return _from_run(system, tables, initial, t_start, mode, repeated)
        return _from_point(system, tables, initial, t_start, mode, repeated)
    if initial is not None and not isinstance(initial, Mapping):
        raise OptionError(
            f"initial = {quote(initial)}: give a mapping of state names to numbers, such as"
            f" {{{system.states[0]!r}: 0.1}}, a point of a dataset, or a run to go on from"
        )
    state = _from_mapping(system, initial or {})
    instant, modes = (
        _instant(tables, 0.0 if t_start is None else t_start),
        mode_numbers(system, mode),
    )
    if np.any(np.isnan(state)):
        state = complete_state(system, tables, state, instant, modes)
    return Start(state, instant, modes)


def complete_state(
    system: System,
    tables: Tables,
    state: npt.NDArray[np.float64],
    instant: Instant,
    modes: tuple[int, ...] = (-1,),
) -> npt.NDArray[np.float64]:
    """State with what was left out, as nan, as the mode wants it in which a run begins there.

    The run has no length. Where no mode takes the start, what was left out is at rest.
    """
    left_out = np.isnan(state)
    found = np.array([system.rest_state[name] for name in system.states])
    for mode in modes:
        anchor = begin(tables, state, instant, mode)
        if anchor.mode >= 0:
            found = anchor.state
            break
    return np.where(left_out, found, state)


def begin(tables: Tables, state: npt.NDArray[np.float64], instant: Instant, mode: int) -> Anchor:
    """Anchor of a run without length; its mode is -1 where none takes the state."""
    anchor = allocate_anchor(tables.sizes)
    anchor.move_to(instant)
    anchor.state[:] = state
    records = allocate_records(tables.sizes, *_NO_TIMES, 0)
    segment, tangent = allocate_segment(tables.sizes), allocate_tangent(tables.sizes, -1, 0)
    lane = (tables, no_rates(), no_scratch(), anchor, segment, tangent)
    run(lane, records, mode, instant, _TOLERANCE)
    return anchor


def unknown_state(system: System, name: str) -> str:
    """Words for a name that is no state."""
    words = unknown_name("state", name, system.states)
    if {"eta1", "veta1"} <= set(system.states):  # natural modes of a structure
        words += "; the method start of a ReducedStructure makes states of displacements by name"
    return words


def _from_mapping(system: System, initial: Mapping[str, Any]) -> npt.NDArray[np.float64]:
    values = dict(system.open_state)
    for name, value in initial.items():
        if name not in values:
            raise OptionError(f"initial: {unknown_state(system, str(name))}")
        values[name] = finite_real(f"initial[{name!r}]", value)
    return np.array([values[name] for name in system.states])


def mode_numbers(system: System, mode: Any) -> tuple[int, ...]:
    """Modes that a name stands for: a cell, cells of one name, or all cells of a mode.

    Where there is none, all cells with it as a word of their names, as ``contact,rolling`` for
    ``contact``.
    """
    if mode is None:
        return (-1,)
    if not isinstance(mode, str):
        raise OptionError(f"mode = {quote(mode)} is not the name of a mode")
    running = system.structure.running
    found = tuple(i for i, m in enumerate(running) if mode in (m.name, m.label, m.parent))
    if not found:
        found = tuple(i for i, m in enumerate(running) if mode in re.split(r"[][,]", m.label))
    if not found:
        known = [*system.modes, *system.mode_names]
        raise OptionError(f"mode: {unknown_name('mode', mode, dict.fromkeys(known))}")
    return found


def _instant(tables: Tables, time: float) -> Instant:
    time = finite_number("t_start", time)
    if time == 0.0:
        return Instant(0, 0.0)
    number, phase = instants([time], tables.window)
    return Instant(int(number[0]), float(phase[0]))


def _check_states(system: System, data: Any) -> None:
    missing = [name for name in system.states if name not in data.data_vars]
    if missing:
        raise OptionError(f"initial: the dataset has no state {missing[0]!r} of {system.name!r}")


def _from_point(
    system: System,
    tables: Tables,
    data: Any,
    t_start: float | None,
    mode: str | None,
    repeated: bool,
) -> Start:
    if not repeated:
        refuse_other_parameters(system, data, "point")
    axes = dict.fromkeys(str(each) for name in system.states for each in data[name].dims)
    if axes:
        points = ", ".join(f"{each}=0" for each in axes)
        raise OptionError(
            f"initial: the states of the dataset have the dimensions {', '.join(axes)}, and a run"
            f" starts from one point; choose it, as by .isel({points})"
        )
    state = np.array([float(data[name]) for name in system.states])
    if not np.all(np.isfinite(state)):
        raise OptionError("initial: the point of the dataset has states that are not finite")
    time = t_start if t_start is not None else float(data.coords.get("time", 0.0))
    names = data["mode"].attrs.get("flag_meanings", "").split() if "mode" in data else []
    if mode is None and names == list(system.mode_names):
        return Start(state, _instant(tables, time), (int(data["mode"]),))
    modes = mode_numbers(system, mode)
    if mode is None and "leg_mode" in data:
        # an orbit begins just behind an event, and rounding may put it on the other side of it
        names = data["leg_mode"].attrs.get("flag_meanings", "").split()
        first = int(np.ravel(data["leg_mode"].values)[0])
        if names == list(system.mode_names) and first >= 0:
            modes = (first, *modes)
    return Start(state, _instant(tables, time), modes)


def _from_run(
    system: System,
    tables: Tables,
    run: Any,
    t_start: float | None,
    mode: str | None,
    repeated: bool,
) -> Start:
    status = run.attrs.get("status")
    if status not in GOES_ON or "anchor_state" not in run or "end_state" not in run:
        raise OptionError(
            f"initial: the run ended with status {status!r} and cannot go on; take one of its"
            " points instead, as in run.isel(time=-1)"
        )
    rows = run.sizes.get("event", 0)
    if (run.sizes["time"], rows) != (run.attrs["n_samples"], run.attrs["n_rows"]):
        raise OptionError(
            "initial: this is a part of a run, which cannot go on; take one of its points, as in"
            " run.isel(time=-1), or the whole run"
        )
    if t_start is not None or mode is not None:
        raise OptionError("a run goes on where it ended: leave out t_start= and mode=")
    if not repeated:
        refuse_other_parameters(system, run, "run")
    end = Instant(int(run.attrs["end_number"]), float(run.attrs["end_phase"]))
    if run.attrs["system"] != labels_of(system).system:
        # another system, a changed parameter for instance: same state, same phase
        window = tables.window
        same = math.isclose(window, float(run.attrs["window"]), rel_tol=1e-15)
        time = end.number * float(run.attrs["window"]) + end.phase
        if "end_time" in run.attrs:  # of a run with slow parameters
            time, same = float(run.attrs["end_time"]), False
        state = run["end_state"].sel(state=list(system.states)).values.copy()  # by name, not place
        return Start(state, end if same else _instant(tables, time))
    anchor = allocate_anchor(tables.sizes)
    anchor.move_to((int(run.attrs["anchor_number"]), float(run.attrs["anchor_phase"])))
    anchor.place["mode"] = run.attrs["anchor_mode"]
    anchor.place["is_estimated"] = run.attrs.get("anchor_is_estimated", 0)
    anchor.state[:] = run["anchor_state"].values
    anchor.order[:] = np.array(run.attrs["anchor_order"].split(), np.int64)
    return Start(run["end_state"].values.copy(), end, anchor=anchor)


def start_at_end(start: Start) -> Start:
    """The start itself, or where it has an anchor, the end of the run that has left it.

    For what begins at a state, such as derivatives, and not within a segment.
    """
    if start.anchor is None:
        return start
    return Start(start.state, start.instant, (start.anchor.mode,))


def check_carried(
    system: System,
    initial: Any,
    parameters: Mapping[str, Any] | None,
    swept: Collection[str] = (),
) -> None:
    """Refuse an initial point or run of other parameters, unless ``parameters`` were given anew.

    Those that are ``swept`` differ from run to run, whatever the start.
    """
    if parameters is None and hasattr(initial, "data_vars"):
        what = "run" if "time" in initial.dims else "point"
        refuse_other_parameters(system, initial, what, swept)


def refuse_other_parameters(
    system: System, data: Any, what: str, swept: Collection[str] = ()
) -> None:
    """Refuse a point, or a run, that belongs to other parameters than those of the system."""
    known = system.parameter_values
    other = {
        name: value
        for name, value in carried_parameters(system, data).items()
        if name not in swept and value != known[name]
    }
    if not other:
        return
    raise OptionError(
        f"initial: the {what} belongs to parameters={other}, and the system has"
        f" {', '.join(f'{name} = {known[name]:.9g}' for name in other)}; repeat parameters=, or"
        " pass parameters={} for the system's own"
    )


def carried_parameters(system: System, data: Any) -> dict[str, float]:
    """Parameters of the system that a result was made with, where it tells that they changed."""
    names = [name for name in system.parameters if name not in system.slow]
    found: dict[str, float] = {}
    text = data.attrs.get("system", "")
    if data.attrs.get("changed_parameters") and text and text != labels_of(system).system:
        values = System.from_toml(text).parameter_values
        found |= {name: values[name] for name in names if name in values}
    told = {name: data.coords[name] for name in names if name in set(data.coords) - _TIMES}
    swept = data.attrs.get("parameter")  # of a diagram or a branch
    if swept in names and (swept in data.variables or "parameter" in data.coords):
        told[swept] = data[swept if swept in data.variables else "parameter"]
    return found | {name: float(each) for name, each in told.items() if each.ndim == 0}
