"""Orbits as datasets: one, or many along a dimension."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.periodic.orbit import Orbit
from nonsmooth.simulation.assemble import Columns, assemble
from nonsmooth.simulation.labels import labels_of
from nonsmooth.system.system import System
from nonsmooth.version import __version__

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["failed_dataset", "orbit_dataset", "orbit_variables"]


def orbit_dataset(system: System, orbit: Orbit, attrs: dict[str, Any]) -> xr.Dataset:
    """Dataset of one orbit."""
    return _dataset(system, orbit_variables(system, [orbit], ()), attrs, orbit)


def failed_dataset(system: System, attrs: dict[str, Any]) -> xr.Dataset:
    """The same variables where there is no orbit."""
    return _dataset(system, orbit_variables(system, [None], ()), attrs, None)


def _dataset(
    system: System, variables: Columns, attrs: dict[str, Any], orbit: Orbit | None
) -> xr.Dataset:
    labels = labels_of(system)
    time = np.nan if orbit is None else float(orbit.turn.instants[0])
    coords: Columns = {
        "time": ((), np.asarray(time), labels.attributes("time")),
        "state": (("state",), labels.states, {}),
    }
    if system.drift_states:
        coords["drift_state"] = (("drift_state",), np.array(system.drift_states), {})
    return assemble(variables, coords, {"state": labels.state_index}, common(system) | attrs)


def common(system: System) -> dict[str, Any]:
    """Attributes of every result."""
    return {
        "system_name": system.name,
        "system": labels_of(system).system,
        "nonsmooth_version": __version__,
    }


def orbit_variables(
    system: System, orbits: Sequence[Orbit | None], dims: tuple[str, ...]
) -> Columns:
    """Variables of orbits; None is one that was not found. Legs are filled up with nothing.

    dims: of the orbits, or none for one
    """
    labels = labels_of(system)
    shape = (len(orbits),) if dims else ()
    n = len(system.states)

    def each(values: Any, text: str, kind: Any = float, **words: str) -> Any:
        return dims, np.array(list(values), kind).reshape(shape), {"long_name": text, **words}

    def number(value: Any, default: Any = np.nan) -> list[Any]:
        return [default if o is None else value(o) for o in orbits]

    units = labels.attributes("time").get("units")
    of_time = {"units": units} if units else {}
    variables: Columns = {}
    for i, name in enumerate(system.states):
        values = np.array(number(lambda o, i=i: o.turn.states[0, i])).reshape(shape)
        variables[name] = (dims, values, labels.attributes(name))
    variables |= {
        "length": each(number(lambda o: o.length), "time of one turn", **of_time),
        "word": each(number(lambda o: o.word.text(system), ""), "modes of one turn", str),
        "residual": each(number(lambda o: o.residual), "what the equations leave, scaled"),
        "admissible": each(
            number(lambda o: o.admissibility.admissible, False), "whether it is a motion", bool
        ),
        "stable": each(
            number(lambda o: o.stable, False), "whether all multipliers are inside the circle", bool
        ),
        "primitive_parts": each(
            number(lambda o: o.primitive, 0), "how often the turn repeats a shorter orbit", int
        ),
        "log_determinant": each(
            number(lambda o: o.multipliers.log_determinant),
            "logarithm of the determinant of the tangent over one turn",
        ),
    }
    variables |= _multipliers(orbits, dims, shape)
    variables |= _drifts(system, orbits, dims, shape)
    return variables | _legs(system, orbits, dims, n)


def _multipliers(
    orbits: Sequence[Orbit | None], dims: tuple[str, ...], shape: tuple[int, ...]
) -> Columns:
    width = max((o.multipliers.multipliers.size for o in orbits if o is not None), default=0)
    values = np.full((len(orbits), width), np.nan, complex)
    for row, orbit in zip(values, orbits, strict=True):
        if orbit is not None:
            row[: orbit.multipliers.multipliers.size] = orbit.multipliers.multipliers
    words = {"long_name": "multipliers, the largest first"}
    found: Columns = {"multipliers": ((*dims, "multiplier"), values.reshape(*shape, width), words)}
    return found


def _drifts(
    system: System, orbits: Sequence[Orbit | None], dims: tuple[str, ...], shape: tuple[int, ...]
) -> Columns:
    if not system.drift_states:
        return {}
    labels = labels_of(system)
    variables: Columns = {}
    places = [system.states.index(name) for name in system.drift_states]
    whole = np.full((len(orbits), len(places)), np.nan)
    periods, lengths = np.full(len(orbits), np.nan), np.full(len(orbits), np.nan)
    for k, orbit in enumerate(orbits):
        if orbit is not None:
            whole[k] = orbit.drift[places]
            periods[k], lengths[k] = orbit.period, orbit.length
    words = {"long_name": "change of the drifts over one turn"}
    variables["drift"] = ((*dims, "drift_state"), whole.reshape(*shape, len(places)), words)
    for i, name in enumerate(system.drift_states):
        text = labels.attributes(name)["long_name"]
        for what, over in (("period", periods), ("time", lengths)):
            label = "per period" if what == "period" else "per unit time"
            variables[f"{name}_per_{what}"] = (
                dims, (whole[:, i] / over).reshape(shape), {"long_name": f"{text}, {label}"},
            )  # fmt: skip
    return variables


def _legs(system: System, orbits: Sequence[Orbit | None], dims: tuple[str, ...], n: int) -> Columns:
    """Variables over ``leg``."""
    labels = labels_of(system)
    width = max((len(o.word) for o in orbits if o is not None), default=0)
    shape = (len(orbits), width)
    durations, times = np.full(shape, np.nan), np.full(shape, np.nan)
    states, modes = np.full((*shape, n), np.nan), np.full(shape, -1, np.int8)
    exits, paths = [[""] * width for _ in orbits], np.zeros(shape, np.int64)
    for k, orbit in enumerate(orbits):
        if orbit is None:
            continue
        count = len(orbit.word)
        durations[k, :count], times[k, :count] = orbit.turn.durations, orbit.turn.instants[:-1]
        states[k, :count], modes[k, :count] = orbit.turn.states, orbit.word.modes
        paths[k, :count] = orbit.word.path_bits
        exits[k][:count] = [orbit.word.exit_text(system, leg) for leg in range(count)]
    over = (*dims, "leg")

    def legs(values: Any) -> Any:
        return np.asarray(values) if dims else np.asarray(values)[0]

    time = labels.attributes("time")
    units = {"units": time["units"]} if "units" in time else {}
    return {
        "durations": (over, legs(durations), {"long_name": "time spent in each leg", **units}),
        "leg_mode": (over, legs(modes), labels.mode_flags("mode of each leg")),
        "leg_exit": (over, legs(exits), {"long_name": "exits at the end of each leg"}),
        "leg_path": (over, legs(paths), {"long_name": "the same exits, coded"}),
        "leg_time": (over, legs(times), {"long_name": "time at which each leg begins", **units}),
        "leg_states": (
            (*over, "state"), legs(states), {"long_name": "state at which each leg begins"},
        ),
    }  # fmt: skip
