"""A finished run as an xarray dataset; the only place where results get their names."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from nonsmooth.engine.status import CURES, EventKind, Status
from nonsmooth.simulation.events import event_variables, mode_flags
from nonsmooth.simulation.outputs import Clock, output_values
from nonsmooth.simulation.runner import Outcome
from nonsmooth.simulation.words import last_period_word
from nonsmooth.system.system import System
from nonsmooth.version import __version__

__all__ = ["labelled", "run_dataset", "status_message"]


def run_dataset(system: System, outcome: Outcome, options: dict[str, Any]) -> xr.Dataset:
    """Dataset of a run: trajectory over ``time``, events over ``event``, attributes."""
    count = outcome.n_samples
    window = float(outcome.tables.clock[0])
    periodic = bool(outcome.tables.clock[1])
    number = outcome.records.sample_number[:count]
    phase = outcome.records.sample_phase[:count]
    time = number * window + phase
    states = outcome.records.sample_state[:count]
    modes = outcome.records.sample_mode[:count]
    coords: dict[str, Any] = {
        "time": ("time", time, labelled(system, "time", "time")),
        "state": ("state", list(system.states)),
    }
    if periodic:
        coords["period_number"] = ("time", number, {"long_name": "whole periods before the sample"})
        coords["phase"] = ("time", phase, {"long_name": "time since the period began"})
    variables: dict[str, Any] = {
        name: ("time", states[:, i].copy(), labelled(system, name, name))
        for i, name in enumerate(system.states)
    }
    clock = Clock(number, phase, outcome.tables)
    for name, values in output_values(system, clock, states, modes).items():
        variables[name] = ("time", values, labelled(system, name, name))
    variables["mode"] = ("time", modes.astype(np.int8), mode_flags(system, "mode"))
    variables |= event_variables(system, outcome)
    variables["end_state"] = (
        "state",
        outcome.records.end_state,
        {"long_name": "states at the end"},
    )
    variables["anchor_state"] = (
        "state",
        outcome.anchor.state,
        {"long_name": "states at the start of the last segment, from which the run goes on"},
    )
    attrs = _attributes(system, outcome, options)
    return xr.Dataset(variables, coords, attrs)


def labelled(system: System, name: str, default: str) -> dict[str, str]:
    """``long_name`` and ``units`` of a variable from the system's descriptions."""
    text = system.describe.get(name, default)
    if text.endswith("]") and "[" in text:
        label, units = text[:-1].rsplit("[", 1)
        return {"long_name": label.strip(), "units": units.strip()}
    return {"long_name": text}


def _attributes(system: System, outcome: Outcome, options: dict[str, Any]) -> dict[str, Any]:
    crossings = outcome.event_integers[:, 1] != EventKind.START
    attrs = {
        "system_name": system.name,
        "system": system.to_toml(),
        "nonsmooth_version": __version__,
        "status": outcome.status.word,
        "message": status_message(system, outcome),
        "certified": int(outcome.n_uncertain == 0),
        "n_samples": outcome.n_samples,
        "n_rows": len(outcome.event_integers),
        "n_events": int(np.count_nonzero(crossings)),
        "n_uncertain": outcome.n_uncertain,
        "phase_word": last_period_word(system, outcome),
        "window": float(outcome.tables.clock[0]),
        "end_number": outcome.end.number,
        "end_phase": outcome.end.phase,
        "anchor_number": int(outcome.anchor.place[0]),
        "anchor_phase": float(outcome.anchor.phase[0]),
        "anchor_mode": int(outcome.anchor.place[1]),
        "anchor_order": " ".join(str(order) for order in outcome.anchor.order),
    }
    if system.period_value is not None:
        attrs["period"] = system.period_value
    return attrs | options


def status_message(system: System, outcome: Outcome) -> str:
    """What the status means for this run, with what to do about it."""
    status = outcome.status
    end = outcome.end.number * float(outcome.tables.clock[0]) + outcome.end.phase
    if status == Status.COMPLETED:
        if outcome.n_uncertain:
            return (
                f"completed; {outcome.n_uncertain} tangency or tangencies lie within rounding,"
                " see certified over event"
            )
        return "completed"
    text = f"{status.word} at t = {end:.9g}: {CURES[status]}"
    if status in (Status.UNDECIDED, Status.INADMISSIBLE) and len(outcome.event_integers):
        last = event_variables(system, outcome)
        before = system.mode_names[int(last["event_from"][1][-1])]
        after = system.mode_names[int(last["event_to"][1][-1])]
        text += f" (exits passed: {last['event_path'][1][-1]}, from {before!r} to {after!r})"
    return text
