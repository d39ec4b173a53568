"""Samples of a periodic orbit, leg by leg, as a run over some turns with its event log."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError
from nonsmooth.plot.style import mode_colours

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["as_run", "exits_of_legs", "over_time"]

Floats = npt.NDArray[np.float64]


def over_time(samples: xr.Dataset) -> list[str]:
    """Names of the states and outputs of samples."""
    return [
        str(name)
        for name, values in samples.data_vars.items()
        if values.dims == ("time",) and values.dtype.kind == "f"
    ]


def exits_of_legs(samples: xr.Dataset, legs: int) -> list[str]:
    """Names of the exits passed at the end of each leg, "" at the section."""
    if "leg_exit" not in samples:  # then it is no event where a mode is cut by the section
        modes = samples["mode"].values
        return ["event"] * (legs - 1) + ["event" if modes[0] != modes[-1] else ""]
    names = [str(name) for name in samples["leg_exit"].values]
    if samples["leg_exit"].dims == ("time",):
        leg = np.append(samples["leg"].values.astype(int), -1)
        names = [names[k] for k in np.flatnonzero(np.diff(leg))]
    return names[:legs]


def as_run(samples: xr.Dataset, *, turns: int = 1, drift: bool = True) -> xr.Dataset:
    """Samples as a run: so many turns, then the instant at which the next one begins.

    Without its drift each state that drifts, and each output that goes with it, is less the mean
    motion.
    """
    import xarray as xr

    _check(samples, turns)
    names = over_time(samples)
    time = samples["time"].values.astype(float)
    leg = samples["leg"].values.astype(np.int64)
    legs = int(leg[-1]) + 1
    length = float(samples["length"]) if "length" in samples else float(time[-1] - time[0])
    exits = exits_of_legs(samples, legs)
    change = _changes(samples, names, jumps=bool(exits[-1]))
    turn = np.repeat(np.arange(turns), time.size)
    clock = np.append(np.tile(time - time[0], turns) + turn * length, turns * length)
    numbers = np.append(np.tile(leg, turns) + turn * legs, turns * legs)
    modes = samples["mode"].values
    variables: dict[str, Any] = {
        "mode": ("time", np.append(np.tile(modes, turns), modes[0]), samples["mode"].attrs),
        "leg": ("time", numbers),
    }
    for name in names:
        values = samples[name].values.astype(float)
        tiled = np.append(np.tile(values, turns) + turn * change[name], 0.0)
        tiled[-1] = values[0] + turns * change[name]
        attrs = dict(samples[name].attrs)
        if not drift and change[name] != 0.0:
            tiled = tiled - change[name] * clock / length
            attrs["long_name"] = f"{attrs.get('long_name') or name} less its drift"
        variables[name] = ("time", tiled, attrs)
    run = xr.Dataset(
        variables, {"time": ("time", time[0] + clock, samples["time"].attrs)}, samples.attrs
    )
    return run.assign(_log(run, names, exits))


def _check(samples: xr.Dataset, turns: int) -> None:
    if not {"leg", "mode"} <= set(samples.variables) or "time" not in samples.dims:
        raise OptionError(
            "the dataset has no variables 'leg' and 'mode' over 'time'; draw the samples of an"
            " orbit: ns.orbit_samples(orbit)"
        )
    mode_colours(samples)  # names of modes are there
    if samples.sizes["time"] < 2:
        raise OptionError("the orbit has no samples to draw; see its attribute 'message'")
    if isinstance(turns, bool) or not isinstance(turns, int | np.integer) or turns < 1:
        raise OptionError(f"turns = {turns!r:.60} must be a whole number, 1 or more")


def _changes(samples: xr.Dataset, names: list[str], *, jumps: bool) -> dict[str, float]:
    """Change of each variable over a turn; of most it is zero but for rounding."""
    drifts: dict[str, float] = {}
    if "drift" in samples:
        pairs = zip(samples["drift_state"].values, samples["drift"].values, strict=True)
        drifts = {str(name): float(value) for name, value in pairs}
    change = dict.fromkeys(names, 0.0)
    states = set(names)
    if "system" in samples.attrs:
        from nonsmooth.system.system import System

        system = System.from_toml(samples.attrs["system"])
        states = set(system.states)
        drifts = dict.fromkeys(system.drift_states, np.nan) | drifts
    for name in names:
        values = samples[name].values
        if name in drifts:
            known = np.isfinite(drifts[name])
            change[name] = drifts[name] if known else float(values[-1] - values[0])
        elif name not in states and drifts and not jumps:
            # an output that follows a drift: nothing jumps where the turn ends
            moved = float(values[-1] - values[0])
            change[name] = moved if abs(moved) > 1e-9 * float(np.ptp(values)) else 0.0
    return change


def _log(run: xr.Dataset, names: list[str], exits: list[str]) -> dict[str, Any]:
    """Event log of the changes from leg to leg that are events."""
    leg = run["leg"].values
    ends = np.flatnonzero(np.diff(leg))
    labels = np.array([exits[leg[k] % len(exits)] for k in ends], str)
    ends, labels = ends[labels != ""], labels[labels != ""]
    states = np.stack([run[name].values for name in names], axis=1)
    modes = run["mode"].values
    return {
        "event_time": ("event", run["time"].values[ends + 1]),
        "event_name": ("event", labels),
        "event_kind": ("event", np.full(ends.size, "switch")),
        "event_from": ("event", modes[ends]),
        "event_to": ("event", modes[ends + 1]),
        "state_before": (("event", "state"), states[ends]),
        "state_after": (("event", "state"), states[ends + 1]),
        "state": ("state", np.array(names)),
    }
