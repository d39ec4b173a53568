"""The exact system and the smoothed ones of a ladder of widths, and their runs."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, RunError, RunWarning
from nonsmooth.runs.options import check_count, check_run_options, finite_number, whole_number
from nonsmooth.runs.simulate import simulate
from nonsmooth.system.smoothed import smoothed
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Ladder", "Stretch", "read_ladder", "read_stretch", "run_exactly", "run_smoothed"]

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Ladder:
    """A system, the same smoothed with a width that is a parameter, and the widths."""

    exact: System
    soft: System
    width: str
    epsilons: Floats

    def at(self, epsilon: float) -> System:
        """The system smoothed by one of the widths."""
        return self.soft.with_parameters(**{self.width: float(epsilon)})


@dataclass(frozen=True)
class Stretch:
    """The part of the motion that is compared."""

    initial: Any
    times: Floats
    tolerance: float


def read_ladder(system: Any, epsilons: Any, kind: str, parameters: Any, tolerance: float) -> Ladder:
    """Check the widths and smooth the system."""
    exact = check_run_options(system, parameters, None, tolerance)
    try:
        widths = np.unique(np.asarray(epsilons, dtype=float))
    except (TypeError, ValueError, OverflowError):
        widths = np.zeros(0)
    if widths.size < 2 or not np.all(np.isfinite(widths) & (widths > 0.0)):
        raise OptionError(
            f"epsilons = {epsilons!r:.60}: give two or more different positive numbers, such as"
            " (0.1, 0.01, 0.001)"
        )
    taken = {*exact.states, *exact.parameters, *exact.definitions, *exact.outputs, *exact.signals}
    name = "epsilon"
    while name in taken | set(exact.surfaces):
        name += "_"
    return Ladder(exact, smoothed(exact, name, kind=kind), name, widths)


def read_stretch(
    system: System,
    initial: Any,
    periods: Any,
    t_end: Any,
    transient: Any,
    samples: Any,
    tolerance: float,
) -> Stretch:
    """Instants at which the motions are compared."""
    if (periods is None) == (t_end is None):
        raise OptionError("give either periods= or t_end=, the length of the motion")
    if initial is not None and not isinstance(initial, Mapping):
        raise OptionError(
            f"initial = {initial!r:.60}: give a mapping of states to numbers; a run of the exact"
            " system is no start for a smoothed one"
        )
    unit = 1.0
    if periods is not None:
        if system.period_value is None:
            raise OptionError(f"{system.name} has no period; give t_end= instead of periods=")
        unit = system.period_value
    length = finite_number("periods" if t_end is None else "t_end", periods or t_end)
    begin = finite_number("transient", transient)
    if not 0.0 <= begin < length:
        raise OptionError(
            f"transient = {begin:g}: it is a part of the motion, which is {length:g} long"
        )
    count = whole_number("samples", samples)
    if periods is not None:
        count = check_count(np.ceil(count * (length - begin)))
    times = np.linspace(begin * unit, length * unit, check_count(count) + 1)
    return Stretch(initial, times, tolerance)


def run_exactly(system: System, stretch: Stretch) -> xr.Dataset:
    """Motion of the exact system, which all others are compared with."""
    run = _run(system, stretch)
    if run.attrs["status"] != "completed":
        raise RunError(
            f"{system.name}: the exact motion ends early, so there is nothing to compare with:"
            f" {run.attrs['message']}",
            status=run.attrs["status"],
            partial=run,
        )
    return run


def run_smoothed(system: System, stretch: Stretch) -> xr.Dataset:
    """Motion of a smoothed system; its status tells where it ended early."""
    return _run(system, stretch)


def _run(system: System, stretch: Stretch) -> xr.Dataset:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RunWarning)  # the status is part of the report
        return simulate(system, stretch.initial, times=stretch.times, tolerance=stretch.tolerance)
