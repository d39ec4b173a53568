"""`orbit_samples`: the motion along a periodic orbit, leg by leg, stable or not."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.orbit_search.options import period_of, system_of_one
from nonsmooth.periodic_orbits.legs import Legs
from nonsmooth.periodic_orbits.restart import guess_of_dataset
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.options import check_count, whole_number
from nonsmooth.runs.outputs import SampleClock, output_values
from nonsmooth.runs.part_names import OF_SAMPLES, check_part_names
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["orbit_samples"]

_PER_LEG, _PER_PERIOD = 50, 200  # intervals


def orbit_samples(orbit: xr.Dataset, *, per_leg: int | None = None) -> xr.Dataset:
    """Sample one turn of a periodic orbit, each leg from its own start.

    A simulation leaves an unstable orbit after a while, and never follows one that is no motion;
    the legs of the orbit are there in either case.

    Parameters
    ----------
    orbit : xarray.Dataset
        Result of `find_orbit`, or one orbit of `orbits` or `continue_orbit`, as in
        ``branch.isel(point=3)``.
    per_leg : int, optional
        Intervals in each leg; by default 50, and more in long legs: their share of 200 in each
        period.

    Returns
    -------
    xarray.Dataset
        Over ``time``: states and outputs, ``mode``, ``leg`` (its number from 0) and ``leg_exit``,
        the exits at the end of that leg. Each leg has samples at both of its ends, so at an event
        there are two at the same time, before and behind it. Scalars ``length`` and
        ``admissible`` and, where states drift, ``drift``, as of the orbit.

    Raises
    ------
    OptionError
        When this is no orbit, or several.

    See Also
    --------
    simulate : motions from any start.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> orbit = ns.find_orbit(ns.models.moling(a=0.3, b=0.15, xi=0.05, omega=0.1))
    >>> samples = ns.orbit_samples(orbit, per_leg=20)
    >>> samples.sizes["time"], float(samples["slider_force"].max()) > 1.0
    (105, True)
    """
    system = system_of_one(orbit)
    check_part_names(system, OF_SAMPLES, outputs=True)
    word, turn = guess_of_dataset(system, orbit)
    counts = _intervals(orbit, turn.durations, per_leg)
    check_count(float(np.sum(counts + 1.0)))
    legs = Legs(system)
    legs.set_values(system.parameter_values)
    leg = np.repeat(np.arange(len(word)), counts + 1)
    shares = np.concatenate([np.linspace(0.0, 1.0, count + 1) for count in counts])
    times = turn.instants[leg] + shares * turn.durations[leg]
    modes = np.array(word.modes, np.int64)[leg]
    cut = Word(tuple(int(m) for m in modes), ((),) * modes.size)
    found = legs.follow_each(cut, turn.states[leg], turn.instants[leg], times)
    return _dataset(system, legs, orbit, word, leg, times, modes, found.ends.copy())


def _intervals(orbit: xr.Dataset, durations: Any, per_leg: int | None) -> Any:
    """Number of intervals in each leg."""
    if per_leg is not None:
        return np.full(len(durations), whole_number("per_leg", per_leg), np.int64)
    turn = _PER_PERIOD * period_of(orbit)
    shares = np.ceil(turn * durations / float(np.sum(durations)) * (1.0 - 1e-12))
    return np.maximum(shares, _PER_LEG).astype(np.int64)


def _dataset(
    system: System, legs: Legs, orbit: Any, word: Word, leg: Any, times: Any, modes: Any,
    states: Any,
) -> xr.Dataset:  # fmt: skip
    import xarray as xr

    labels, over = labels_of(system), ("time",)
    window = legs.window
    number = np.floor(times / window).astype(np.int64)
    clock = SampleClock(number, times - number * window, legs.tables)
    variables: dict[str, Any] = {
        name: (over, states[:, i].copy(), labels.attributes(name))
        for i, name in enumerate(system.states)
    }
    for name, values in output_values(system, clock, states.T.copy(), modes).items():
        variables[name] = (over, values, labels.attributes(name))
    exits = np.array([word.exit_text(system, k) for k in range(len(word))])
    variables |= {
        "mode": (over, modes.astype(labels.mode_type), labels.mode_flags("mode")),
        "leg": (over, leg, {"long_name": "number of the leg"}),
        "leg_exit": (over, exits[leg], {"long_name": "exits at the end of the leg"}),
        "length": ((), float(orbit["length"]), dict(orbit["length"].attrs)),
        "admissible": ((), bool(orbit["admissible"]), dict(orbit["admissible"].attrs)),
    }
    coords: dict[str, Any] = {"time": (over, times, labels.attributes("time"))}
    if "drift" in orbit:
        variables["drift"] = (("drift_state",), orbit["drift"].values, dict(orbit["drift"].attrs))
        coords["drift_state"] = (("drift_state",), np.array(tuple(system.drift)))
    attrs = {key: value for key, value in orbit.attrs.items() if key != "system"}
    return xr.Dataset(variables, coords, {"system": labels.system} | attrs)
