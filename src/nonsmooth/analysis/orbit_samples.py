"""`orbit_samples`: the motion along a periodic orbit, leg by leg, stable or not."""

from __future__ import annotations

import warnings
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.orbit_search.options import period_of, system_of_one
from nonsmooth.errors import ResultWarning
from nonsmooth.periodic_orbits.equations import Turn
from nonsmooth.periodic_orbits.leg_samples import LegSamples, evenly, refined
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

_PER_LEG, _PER_PERIOD = 50, 200  # intervals to begin with


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
        Intervals of equal length in each leg. By default 50, more in long legs, which have their
        share of 200 in each period, and more where a leg oscillates or hurries; see notes.

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

    Warns
    -----
    ResultWarning
        When the orbit would need more samples than 20000: how far off straight lines between those
        that there are may be.

    See Also
    --------
    simulate : motions from any start.

    Notes
    -----
    Without ``per_leg`` straight lines between samples are off the motion by at most a thousandth of
    the range of each state and output, which is the width of a line in a picture: that takes some
    50 samples in an oscillation over the whole range. They are added where they are needed, as in
    the beginning of a leg in which fast parts of the motion fade.

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
    samples = evenly(legs, word, turn, counts)
    if per_leg is None:
        drawn = partial(_drawn, system, legs, word, turn, samples.states[-1] - samples.states[0])
        samples, off = refined(legs, word, turn, samples, drawn)
        if off:
            warnings.warn(
                f"orbit_samples: the orbit changes so fast that between {samples.times.size}"
                f" samples straight lines are up to {100.0 * off:.2g} % of the range of a variable"
                " off, and maxima are too small; in Python per_leg= takes as many as you want",
                ResultWarning,
                stacklevel=2,
            )
    return _dataset(system, legs, orbit, word, samples)


def _intervals(orbit: xr.Dataset, durations: Any, per_leg: int | None) -> Any:
    """Number of intervals in each leg."""
    if per_leg is not None:
        return np.full(len(durations), whole_number("per_leg", per_leg), np.int64)
    turn = _PER_PERIOD * period_of(orbit)
    shares = np.ceil(turn * durations / float(np.sum(durations)) * (1.0 - 1e-12))
    return np.maximum(shares, _PER_LEG).astype(np.int64)


def _drawn(
    system: System, legs: Legs, word: Word, turn: Turn, drift: Any, samples: LegSamples
) -> Any:
    """States, without what they drift by in a turn, and outputs, (N, m)."""
    share = (samples.times - turn.instants[0]) / (turn.instants[-1] - turn.instants[0])
    outputs = _outputs(system, legs, word, samples)
    return np.column_stack([samples.states - share[:, None] * drift, *outputs.values()])


def _outputs(system: System, legs: Legs, word: Word, samples: LegSamples) -> dict[str, Any]:
    window = legs.window
    number = np.floor(samples.times / window).astype(np.int64)
    clock = SampleClock(number, samples.times - number * window, legs.tables)
    return output_values(system, clock, samples.states.T.copy(), word.mode_array[samples.leg])


def _dataset(system: System, legs: Legs, orbit: Any, word: Word, samples: LegSamples) -> xr.Dataset:
    import xarray as xr

    labels, over = labels_of(system), ("time",)
    leg, modes = samples.leg, word.mode_array[samples.leg]
    variables: dict[str, Any] = {
        name: (over, samples.states[:, i].copy(), labels.attributes(name))
        for i, name in enumerate(system.states)
    }
    for name, values in _outputs(system, legs, word, samples).items():
        variables[name] = (over, values, labels.attributes(name))
    exits = np.array([word.exit_text(system, k) for k in range(len(word))])
    variables |= {
        "mode": (over, modes.astype(labels.mode_type), labels.mode_flags("mode")),
        "leg": (over, leg, {"long_name": "number of the leg"}),
        "leg_exit": (over, exits[leg], {"long_name": "exits at the end of the leg"}),
        "length": ((), float(orbit["length"]), dict(orbit["length"].attrs)),
        "admissible": ((), bool(orbit["admissible"]), dict(orbit["admissible"].attrs)),
    }
    coords: dict[str, Any] = {"time": (over, samples.times, labels.attributes("time"))}
    if "drift" in orbit:
        variables["drift"] = (("drift_state",), orbit["drift"].values, dict(orbit["drift"].attrs))
        coords["drift_state"] = (("drift_state",), np.array(tuple(system.drift)))
    attrs = {key: value for key, value in orbit.attrs.items() if key != "system"}
    return xr.Dataset(variables, coords, {"system": labels.system} | attrs)
