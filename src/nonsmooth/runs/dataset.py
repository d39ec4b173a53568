"""A finished run as an xarray dataset; the only place where results get their names."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from xarray.indexes import PandasIndex

from nonsmooth.engine.status import CURES, Status
from nonsmooth.runs.assemble import Columns, assemble
from nonsmooth.runs.certificate import with_doubts
from nonsmooth.runs.digits import digits_left
from nonsmooth.runs.events import event_variables
from nonsmooth.runs.labels import Labels, labels_of
from nonsmooth.runs.outputs import output_values, sample_clock
from nonsmooth.runs.runner import Outcome
from nonsmooth.runs.words import last_period_word
from nonsmooth.system.system import System
from nonsmooth.version import __version__

__all__ = ["run_dataset", "time_of_lost_derivatives"]


def run_dataset(system: System, outcome: Outcome, options: dict[str, Any]) -> xr.Dataset:
    """Dataset of a run: trajectory over ``time``, events over ``event``, attributes."""
    labels = labels_of(system)
    samples, coords = _samples(system, labels, outcome)
    events = event_variables(labels, outcome) if outcome.keeps_events else {}
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
        ("time",), digits_left(states, columns[:, :, :n]),
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
        return text + (", see certified over event" if flagged else "")
    text = f"{status.word} at t = {outcome.end_time:.9g}: {CURES[status]}"
    if status == Status.REFUSED and outcome.history is not None:
        text += f" ({outcome.history.fault})"
    if status in (Status.UNDECIDED, Status.INADMISSIBLE) and len(outcome.events):
        last = outcome.events[-1]
        before, after = labels.modes[last["from_mode"]], labels.modes[last["to_mode"]]
        passed = labels.path(*(int(last[name]) for name in ("from_mode", "path", "passes")))
        text += f" (exits passed: {passed}, from {before!r} to {after!r})"
    return text


def time_of_lost_derivatives(run: xr.Dataset) -> float | None:
    """Time of the first sample whose derivatives are no numbers although its states are."""
    lost = np.zeros(run.sizes["time"], bool)
    for name in ("tangent", "sensitivity"):
        if name in run:
            lost |= ~np.isfinite(run[name].values).all(axis=(1, 2))
    return float(run["time"].values[lost][0]) if lost.any() else None
