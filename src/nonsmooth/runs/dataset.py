"""A finished run as an xarray dataset; the only place where results get their names.

Where rebounds accumulate, the engine passes the last of infinitely many impacts as one, a little
before, and goes on in rest from there: its log has the states of that instant, from which an orbit
can be built. A dataset has the time when the rebounds are over, and the states of that time.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr
from xarray.indexes import PandasIndex

from nonsmooth.engine.derivatives import no_rates, no_scratch
from nonsmooth.engine.lanes import (
    SAME,
    allocate_anchor,
    allocate_records,
    allocate_segment,
    allocate_tangent,
    run,
)
from nonsmooth.engine.record import Rows, columns
from nonsmooth.engine.status import (
    CURES,
    RELAYED_ACCUMULATE,
    SWITCHES_ACCUMULATE,
    WINDING_ACCUMULATES,
    Certificate,
    EventKind,
    Status,
)
from nonsmooth.engine.tables import PATH_LENGTH, TAYLOR, Tables, exits_of_path
from nonsmooth.runs.labels import Columns, Labels, assemble, labels_of, with_doubts
from nonsmooth.runs.outputs import output_values, sample_clock
from nonsmooth.runs.runner import Outcome
from nonsmooth.runs.words import last_period_word
from nonsmooth.system.system import System
from nonsmooth.version import __version__

__all__ = ["repeated_exit", "run_dataset", "time_of_lost_derivatives"]

Floats = npt.NDArray[np.float64]

_KINDS = [kind.word for kind in EventKind]
_NO_TIMES = (np.zeros(0, np.int64), np.zeros(0))
_RATES, _SCRATCH = no_rates(), no_scratch()
_TOLERANCE = 1e-12
_LAST = 100  # events that tell how they accumulate
_SHORTER = 1e-6  # of their time, by which the later half of them takes less than the earlier one
_EPSILON = float(np.finfo(float).eps)


def run_dataset(system: System, outcome: Outcome, options: dict[str, Any]) -> xr.Dataset:
    """Dataset of a run: trajectory over ``time``, events over ``event``, attributes."""
    labels = labels_of(system)
    samples, coords = _samples(system, labels, outcome)
    events = _event_variables(labels, outcome) if outcome.keeps_events else {}
    ends: Columns = {
        "end_state": (("state",), outcome.records.end_state, {"long_name": "states at the end"}),
        "anchor_state": (
            ("state",),
            outcome.anchor.state,
            {"long_name": "states at the start of the last segment, from which the run goes on"},
        ),
    }
    attrs = _attributes(system, labels, outcome) | options
    indexes = {"time": PandasIndex(coords["time"][1], "time"), "state": labels.state_index}
    if outcome.columns is not None:
        samples |= _derivatives(system, outcome, coords)
        indexes["state_0"] = _index(coords, "state_0")
        if outcome.chosen:
            indexes["parameter_0"] = _index(coords, "parameter_0")
    return assemble(samples | events | ends, coords, indexes, attrs)


def _samples(system: System, labels: Labels, outcome: Outcome) -> tuple[Columns, Columns]:
    """Variables and coordinates over ``time``."""
    over_time = ("time",)
    count = outcome.n_samples
    number = outcome.records.sample_number[:count]
    phase = outcome.records.sample_phase[:count]
    states = outcome.records.sample_state[:count].T.copy()
    modes = outcome.records.sample_mode[:count]
    clock = sample_clock(outcome, number, phase)
    asked = outcome.plan.times
    time = clock.time if asked is None else asked[:count]  # so that a sample is found by its time
    coords: Columns = {
        "time": (over_time, time, labels.attributes("time")),
        "state": (("state",), labels.states, {}),
    }
    if system.period_value is not None:
        before = {"long_name": "whole periods before the sample"}
        coords["period_number"] = (over_time, number, before)
        coords["phase"] = (over_time, phase, {"long_name": "time since the period began"})
    columns = dict(zip(system.states, states, strict=True))
    columns |= output_values(system, clock, states, modes)
    variables: Columns = {
        name: (over_time, values, labels.attributes(name))
        for name, values in (columns | clock.parameters).items()
    }
    variables["mode"] = (over_time, modes.astype(labels.mode_type), labels.mode_flags("mode"))
    return variables, coords


def _index(coords: Columns, name: str) -> PandasIndex:
    """Index of names that stay texts of fixed width, as files restore them."""
    names = coords[name][1]
    return PandasIndex(names, name, coord_dtype=names.dtype)


def _derivatives(system: System, outcome: Outcome, coords: Columns) -> Columns:
    """Derivatives of the states at the samples; their coordinates are added."""
    assert outcome.columns is not None
    columns = outcome.columns[: outcome.n_samples].transpose(0, 2, 1)
    n = len(system.states)
    coords["state_0"] = (("state_0",), np.array(system.states), {"long_name": "initial state"})
    variables: Columns = {
        "tangent": (
            ("time", "state", "state_0"),
            columns[:, :, :n].copy(),
            {"long_name": "derivatives of the states by the initial states"},
        )
    }
    states = outcome.records.sample_state[: outcome.n_samples].T
    variables["digits"] = (
        ("time",), _digits_left(states, columns[:, :, :n]),
        {"long_name": "estimate of the digits that rounding has left"},
    )  # fmt: skip
    if outcome.chosen:
        coords["parameter_0"] = (
            ("parameter_0",), np.array(outcome.chosen), {"long_name": "parameter"},
        )  # fmt: skip
        variables["sensitivity"] = (
            ("time", "state", "parameter_0"),
            columns[:, :, n:].copy(),
            {"long_name": "derivatives of the states by the parameters, at a fixed time"},
        )
    return variables


def _attributes(system: System, labels: Labels, outcome: Outcome) -> dict[str, Any]:
    anchor = outcome.anchor
    attrs = {
        "system_name": system.name,
        "system": labels.system,
        "nonsmooth_version": __version__,
        "status": outcome.status.word,
        "message": _message(labels, outcome),
        "certified": int(outcome.n_uncertain == outcome.n_estimated == 0),
        "n_samples": outcome.n_samples,
        "n_rows": len(outcome.events) if outcome.keeps_events else 0,
        "n_events": outcome.n_events,
        "n_uncertain": outcome.n_uncertain,
        "n_estimated": outcome.n_estimated,
        "phase_word": last_period_word(system, outcome),
        "window": outcome.tables.window,
        "end_number": outcome.end.number,
        "end_phase": outcome.end.phase,
        "anchor_number": anchor.number,
        "anchor_phase": anchor.phase,
        "anchor_mode": anchor.mode,
        "anchor_is_estimated": int(anchor.place["is_estimated"]),
        "anchor_order": " ".join(str(order) for order in anchor.order),
    }
    if system.period_value is not None:
        attrs["period"] = system.period_value
    if outcome.history is not None:
        attrs["period"] = outcome.window
        attrs |= outcome.history.attributes() | {"end_time": outcome.end_time}
    return attrs


def _message(labels: Labels, outcome: Outcome) -> str:
    """What the status means for this run, with what to do about it."""
    status = outcome.status
    if status == Status.COMPLETED:
        text = with_doubts(status.word, outcome.n_uncertain, outcome.n_estimated)
        flagged = outcome.n_uncertain and outcome.keeps_events
        text += ", see certified over event" if flagged else ""
        repeated = repeated_exit(labels, outcome)
        return f"{text}; {repeated}" if repeated else text
    why = _accumulation(labels, outcome) if status == Status.EVENT_LIMIT else ""
    text = f"{status.word} at t = {outcome.end_time:.9g}: {why or CURES[status]}"
    if status == Status.REFUSED and outcome.history is not None:
        text += f" ({outcome.history.fault})"
    if status in (Status.UNDECIDED, Status.INADMISSIBLE) and len(outcome.events):
        last = outcome.events[-1]
        before, after = labels.modes[last["from_mode"]], labels.modes[last["to_mode"]]
        passed = labels.path(*(int(last[name]) for name in ("from_mode", "path", "passes")))
        text += f" (exits passed: {passed}, from {before!r} to {after!r})"
    return text


def _accumulation(labels: Labels, outcome: Outcome) -> str:
    """What the last events say of those that accumulate, "" where they are impacts of one mode."""
    rows = outcome.events[1:][-_LAST:]
    if not len(rows):
        return ""
    ways = [tuple(map(int, way)) for way in columns(rows, "from_mode", "path", "passes")]
    if not any(_resets(outcome.tables, *way) for way in set(ways)):
        surfaces = {labels.path(*way) for way in ways}
        gaps = np.diff(outcome.times(rows["number"], rows["phase"]))
        early, late = gaps[: gaps.size // 2].sum(), gaps[-(gaps.size // 2) :].sum()
        shorter = late <= (1.0 - _SHORTER) * early
        if len(surfaces) > 1:
            return WINDING_ACCUMULATES
        return SWITCHES_ACCUMULATE if shorter else ""
    # modes as they were declared; rounding and flights lead between cells of one
    pairs = columns(rows, "from_mode", "to_mode").tolist()
    relayed = all(_declared(labels, one) != _declared(labels, other) for one, other in pairs)
    return RELAYED_ACCUMULATE if relayed and len(pairs) > 1 else ""


def _declared(labels: Labels, mode: int) -> str:
    """Name of the mode to which a cell belongs, as in flow[+-]."""
    return labels.modes[mode].partition("[")[0]


def _resets(tables: Tables, mode: int, path: int, passes: int) -> bool:
    """Whether one of the exits that are passed at an event has a reset."""
    exits = tables.wiring.exits
    for way in exits_of_path(path, passes):
        if np.any(exits["resetting"][mode, way]):
            return True
        mode = int(exits["target"][mode, way])
    return False


def repeated_exit(labels: Labels, outcome: Outcome) -> str:
    """What to say of an exit that has fired again and again at one instant, "" where none has.

    A reset that leaves the speed its sign only makes it smaller, until nothing is left of it.
    """
    rows = outcome.events
    for k in np.flatnonzero(rows["passes"] > PATH_LENGTH).tolist():
        row = rows[k]
        ways = exits_of_path(int(row["path"]), int(row["passes"]))
        mode = int(row["from_mode"])
        if len(set(ways)) == 1 and labels.leads_back(mode, ways[0]):
            name = labels.paths[mode * labels.width + ways[0]]
            time = float(outcome.times(row["number"], row["phase"]))
            return (
                f"the exit {name!r} fired {int(row['passes'])} times at one instant, at t ="
                f" {time:.9g}: its reset takes speed away and does not turn it round; is a sign"
                f" missing, as in -r*v?"
            )
    return ""


def time_of_lost_derivatives(run: xr.Dataset) -> float | None:
    """Time of the first sample whose derivatives are no numbers although its states are."""
    lost = np.zeros(run.sizes["time"], bool)
    for name in ("tangent", "sensitivity"):
        if name in run:
            lost |= ~np.isfinite(run[name].values).all(axis=(1, 2))
    return float(run["time"].values[lost][0]) if lost.any() else None


def _event_variables(labels: Labels, outcome: Outcome) -> Columns:
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
        "state_after": (_states_after(outcome).copy(), "states just after the event"),
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


def _states_after(outcome: Outcome) -> npt.NDArray[np.float64]:
    """States just behind each event of the log, (event, n)."""
    sizes = outcome.tables.sizes
    rows, after = outcome.events, outcome.event_states[:, 1]
    late = np.flatnonzero(rows["wait"] > 0.0)
    still = [m for m in np.unique(rows["to_mode"][late]) if _stands(outcome.tables, int(m))]
    late = late[~np.isin(rows["to_mode"][late], still)]
    # where parameters change from period to period, the tables are those of the last one
    if late.size == 0 or outcome.history is not None:
        return after
    after = after.copy()
    anchor, records = allocate_anchor(sizes), allocate_records(sizes, *_NO_TIMES, 0)
    segment, tangent = allocate_segment(sizes), allocate_tangent(sizes, -1, 0)
    lane = (outcome.tables, _RATES, _SCRATCH, anchor, segment, tangent)
    for k in late:  # a long run has thousands of them, so nothing is made anew for one
        number, phase = int(rows["number"][k]), float(rows["phase"][k])
        anchor.move_to((number, phase))
        anchor.state[:] = after[k]
        records.counters[()] = 0
        mode = SAME - int(rows["to_mode"][k])
        run(lane, records, mode, (number, phase + float(rows["wait"][k])), _TOLERANCE)
        after[k] = records.end_state
    return after


def _stands(tables: Tables, m: int) -> bool:
    """Whether no state changes in a mode, as of a mass at rest at a wall that is fixed."""
    n = tables.sizes.states
    if tables.kinds[m] == TAYLOR or np.any(tables.generator[m][:n]):
        return False
    relations = np.array([tables.relation_row(m, i) for i in range(n)])
    return not np.any(np.delete(relations, n, axis=1))  # coordinate n is the constant one


def _digits_left(states: Floats, tangent: Floats) -> Floats:
    """Estimate of the correct digits of the states, beside their largest size, at each sample.

    An error of one rounding, made at any sample, has grown since by as much as the derivatives
    have; the largest of them counts, in the state that has it. Where derivatives are lost, or
    beyond the range of numbers, no digit is left.

    shapes: states (n, K), tangent (K, n, n); returns (K,)
    """
    size = np.abs(states).max(axis=1, initial=0.0)
    unit = np.where(size > 0.0, size, 1.0)
    with np.errstate(invalid="ignore", over="ignore"):
        growth = ((np.abs(tangent) @ size) / unit).max(axis=1, initial=0.0)
    growth = np.where(np.isfinite(growth), growth, np.inf)
    least = np.minimum.accumulate(growth)  # an error made there has grown most since
    since = np.divide(growth, least, out=np.ones_like(growth), where=least > 0.0)
    digits: Floats = np.maximum(-np.log10(_EPSILON * since), 0.0)
    return digits
