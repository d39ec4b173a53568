"""Orbits as datasets: one, or many along a dimension."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.periodic_orbits.orbit import Orbit
from nonsmooth.periodic_orbits.strobes import NO_STROBES
from nonsmooth.runs.labels import Columns, assemble, labels_of
from nonsmooth.runs.whole_turns import periods_of_states, whole_turns
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
    if system.drift:
        coords["drift_state"] = (("drift_state",), np.array(tuple(system.drift)), {})
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
    variables |= _multipliers(orbits, dims, shape) | _strobes(orbits, dims, n, of_time)
    if system.symmetry:
        variables["symmetric"] = each(
            number(lambda o: o.reflection is not None and o.reflection.symmetric, False),
            "whether the orbit is its own mirror image", bool,
        )  # fmt: skip
        variables |= _half_multipliers(orbits, dims, shape)
    variables |= _drifts(system, orbits, dims, shape)
    return variables | _legs(system, orbits, dims, n)


def _multipliers(
    orbits: Sequence[Orbit | None], dims: tuple[str, ...], shape: tuple[int, ...]
) -> Columns:
    rows = [None if o is None else o.multipliers.multipliers for o in orbits]
    words = {"long_name": "multipliers, the largest first"}
    return {"multipliers": ((*dims, "multiplier"), _filled(rows, shape), words)}


def _strobes(
    orbits: Sequence[Orbit | None], dims: tuple[str, ...], n: int, of_time: Mapping[str, str]
) -> Columns:
    """Times and states of strobes, for orbits that have any."""
    found = [NO_STROBES if o is None else o.strobes for o in orbits]
    width = max((each.times.size for each in found), default=0)
    if not width:
        return {}
    times, states = np.full((len(orbits), width), np.nan), np.full((len(orbits), width, n), np.nan)
    for k, each in enumerate(found):
        times[k, : each.times.size] = each.times
        states[k, : each.times.size] = each.states
    over = (*dims, "strobe_of_turn")
    return {
        "strobes": (
            (*over, "state"), states if dims else states[0],
            {"long_name": "state at each strobe of one turn"},
        ),
        "strobe_times": (
            over, times if dims else times[0], {"long_name": "time of each strobe", **of_time},
        ),
    }  # fmt: skip


def _half_multipliers(
    orbits: Sequence[Orbit | None], dims: tuple[str, ...], shape: tuple[int, ...]
) -> Columns:
    rows = [None if o is None or o.reflection is None else o.reflection.multipliers for o in orbits]
    width = max((o.multipliers.multipliers.size for o in orbits if o is not None), default=0)
    words = {"long_name": "multipliers of half a turn followed by the symmetry"}
    return {"half_multipliers": ((*dims, "multiplier"), _filled(rows, shape, width), words)}


def _filled(
    rows: Sequence[npt.NDArray[np.complex128] | None], shape: tuple[int, ...], width: int = 0
) -> npt.NDArray[np.complex128]:
    """Rows of multipliers as one array, filled up with nan."""
    width = max([width, *(row.size for row in rows if row is not None)])
    values = np.full((len(rows), width), np.nan, complex)
    for filled, row in zip(values, rows, strict=True):
        if row is not None:
            filled[: row.size] = row
    return values.reshape(*shape, width)


def _drifts(
    system: System, orbits: Sequence[Orbit | None], dims: tuple[str, ...], shape: tuple[int, ...]
) -> Columns:
    if not system.drift:
        return {}
    labels = labels_of(system)
    variables: Columns = {}
    places = [system.states.index(name) for name in system.drift]
    periods_of_angles = periods_of_states(system)
    whole = np.full((len(orbits), len(places)), np.nan)
    periods, lengths = np.full(len(orbits), np.nan), np.full(len(orbits), np.nan)
    for k, orbit in enumerate(orbits):
        if orbit is not None:
            turned = whole_turns(orbit.drift, periods_of_angles)
            whole[k] = np.where(periods_of_angles > 0.0, turned, orbit.drift)[places]
            periods[k], lengths[k] = orbit.period, orbit.length
    words = {"long_name": "change of drifts and angles over one turn"}
    variables["drift"] = ((*dims, "drift_state"), whole.reshape(*shape, len(places)), words)
    for i, name in enumerate(system.drift):
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
    states, modes = np.full((*shape, n), np.nan), np.full(shape, -1, labels.mode_type)
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
