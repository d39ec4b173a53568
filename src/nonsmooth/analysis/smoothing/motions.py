"""Smoothed motions beside the exact one: distance, time on surfaces, creep."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.status import EventKind
from nonsmooth.engine.tables import SLIDES
from nonsmooth.errors import OptionError, RunError, RunWarning, quote
from nonsmooth.runs.options import check_count, check_run_options, finite_number, whole_number
from nonsmooth.runs.simulate import simulate
from nonsmooth.system.smoothed import smoothed
from nonsmooth.system.system import System
from nonsmooth.system.text.evaluate import evaluate_shared
from nonsmooth.system.text.expressions import Expression

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "Ladder",
    "compared_motions",
    "read_ladder",
    "read_stretch",
    "run_exactly",
    "run_smoothed",
]

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
class ComparedMotion:
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
            f"epsilons = {quote(epsilons)}: give two or more different positive numbers, such as"
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
) -> ComparedMotion:
    """Instants at which the motions are compared."""
    if (periods is None) == (t_end is None):
        raise OptionError("give either periods= or t_end=, the length of the motion")
    if initial is not None and not isinstance(initial, Mapping):
        raise OptionError(
            f"initial = {quote(initial)}: give a mapping of states to numbers; a run of the exact"
            " system is no start for a smoothed one"
        )
    unit = 1.0
    if periods is not None:
        if system.period_value is None:
            raise OptionError(f"{system.name} has no period; give t_end= instead of periods=")
        unit = system.period_value
    length = finite_number("t_end", t_end) if periods is None else finite_number("periods", periods)
    if not length > 0.0:
        name = "t_end" if periods is None else "periods"
        raise OptionError(f"{name} = {length:g} must be positive")
    begin = finite_number("transient", transient)
    if not 0.0 <= begin < length:
        raise OptionError(
            f"transient = {begin:g}: it is a part of the motion, which is {length:g} long"
        )
    count = whole_number("samples", samples)
    if periods is not None:
        count = check_count(np.ceil(count * (length - begin)))
    times = np.linspace(begin * unit, length * unit, check_count(count) + 1)
    return ComparedMotion(initial, times, tolerance)


def run_exactly(system: System, stretch: ComparedMotion) -> xr.Dataset:
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


def run_smoothed(system: System, stretch: ComparedMotion) -> xr.Dataset:
    """Motion of a smoothed system; its status tells where it ended early."""
    return _run(system, stretch)


def _run(system: System, stretch: ComparedMotion) -> xr.Dataset:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RunWarning)  # the status is part of the report
        return simulate(system, stretch.initial, times=stretch.times, tolerance=stretch.tolerance)


def compared_motions(
    ladder: Ladder, stretch: ComparedMotion, exact: xr.Dataset, runs: list[xr.Dataset], band: float
) -> dict[str, Any]:
    """Variables of the report that come from the motions."""
    system, count = ladder.exact, ladder.epsilons.size
    surfaces = bands_of(system)
    start, stop = float(stretch.times[0]), float(stretch.times[-1])
    error = np.full((count, len(system.states)), np.nan)
    beside, creep = np.full((2, count, len(surfaces)), np.nan)
    for i, (epsilon, run) in enumerate(zip(ladder.epsilons, runs, strict=True)):
        if run.attrs["status"] != "completed":
            continue
        for k, state in enumerate(system.states):
            error[i, k] = np.abs(run[state].values - exact[state].values).max()
        for k, surface in enumerate(surfaces):
            beside[i, k] = time_beside(ladder.soft, run, system, surface, band * epsilon)
            creep[i, k] = creep_beside(run, system, exact, surface)
    on = np.array([time_on(exact, surface, start, stop) for surface in surfaces])
    over = ("epsilon", "surface")
    return {
        "surface": ("surface", np.array([s.name for s in surfaces], str)),
        "state": ("state", np.array(system.states)),
        "status": ("epsilon", np.array([run.attrs["status"] for run in runs], str)),
        "error": (("epsilon", "state"), error),
        "stick_time_exact": ("surface", on),
        "stick_time": (over, beside),
        "stick_time_error": (over, beside - on),
        "creep": (over, creep),
    }


@dataclass(frozen=True)
class Band:
    """A surface of a mode on which motion slides.

    Each cell on it has numbers of the exact run, and the functions that keep their signs there.
    """

    name: str
    mode: str
    function: Expression
    cells: tuple[tuple[int, tuple[tuple[Expression, int], ...]], ...]


def bands_of(system: System) -> list[Band]:
    """Surfaces of a system on which motion slides."""
    structure = system.structure
    found: dict[tuple[str, str], list[tuple[int, tuple[tuple[Expression, int], ...]]]] = {}
    for number, forms in enumerate(structure.running):
        if forms.kind != SLIDES:
            continue
        mode = structure.families[forms.family].split
        nodes = {key: mode.nodes[name] for key, name in mode.names.items()}
        for key in forms.cell.on:
            sides = tuple(
                (nodes[other], sign) for other, sign in forms.cell.signs.items() if other != key
            )
            found.setdefault((forms.family, mode.names[key]), []).append((number, sides))
    several = len(structure.families) > 1
    return [
        Band(
            f"{family}.{name}" if several else name,
            family,
            structure.families[family].split.nodes[name],
            tuple(cells),
        )
        for (family, name), cells in found.items()
    ]


def time_on(run: xr.Dataset, band: Band, start: float, stop: float) -> float:
    """Time between two instants that an exact run spends on a surface, from its events."""
    keep = run["event_kind"].values != EventKind.GRAZE.word
    begin = np.clip(run["event_time"].values[keep], start, stop)
    lasts = np.diff(begin, append=stop)
    on = np.isin(run["event_to"].values[keep], [number for number, _ in band.cells])
    return float(lasts[on].sum())


def time_beside(system: System, run: xr.Dataset, exact: System, band: Band, width: float) -> float:
    """Time that a smoothed run has its function within a width, straight between samples."""
    values = partial(_values, exact, _names(exact, run))
    h = values(band.function)
    modes = run["mode"].values
    numbers = [i for i, m in enumerate(system.structure.running) if m.family == band.mode]
    here = np.isin(modes[1:], numbers) & np.isin(modes[:-1], numbers)
    share = np.zeros(h.size - 1)
    for _, sides in band.cells:
        limits = [width - h, width + h]
        # on another surface as well: within the width of the one is enough
        limits += [sign * values(node) for node, sign in sides if sign]
        share = np.maximum(share, _share_above_zero(limits))
    share[~here] = 0.0
    return float(share @ np.diff(run["time"].values))


def creep_beside(run: xr.Dataset, exact: System, exact_run: xr.Dataset, band: Band) -> float:
    """Mean size of the function of a smoothed run at samples at which the exact run slides."""
    slides = np.isin(exact_run["mode"].values, [number for number, _ in band.cells])
    whole = slides[1:] & slides[:-1]
    if not whole.any():
        return float("nan")
    size = np.abs(_values(exact, _names(exact, run), band.function))
    return float((0.5 * (size[1:] + size[:-1]))[whole].mean())


def _share_above_zero(limits: list[Floats]) -> Floats:
    """Part of each step in which all of some functions, straight in it, are positive."""
    enter, leave = np.zeros(limits[0].size - 1), np.ones(limits[0].size - 1)
    for limit in limits:
        low, high = limit[:-1], limit[1:]
        with np.errstate(all="ignore"):
            zero = low / (low - high)
        enter = np.where((low < 0.0) & (high > 0.0), np.maximum(enter, zero), enter)
        leave = np.where((low > 0.0) & (high < 0.0), np.minimum(leave, zero), leave)
        leave = np.where((low <= 0.0) & (high <= 0.0) & (low + high < 0.0), 0.0, leave)
    share: Floats = np.maximum(leave - enter, 0.0)
    return share


def _names(system: System, run: xr.Dataset) -> dict[str, Any]:
    times = run["time"].values
    names: dict[str, Any] = {"t": times, "pi": np.pi, **system.parameter_values}
    names |= {name: run[name].values for name in (*system.states, *system.slow)}
    return names | {name: signal(times) for name, signal in system.signals.items()}


def _values(system: System, names: dict[str, Any], node: Expression) -> Floats:
    """Values of a function at the samples of a run."""

    def of_signal(part: Expression) -> Any:
        found = system.structure.graph.signal_of(part)
        if found is None:
            return None
        return system.signals[found[0]](names["t"], derivative=found[1])

    value: Floats = np.broadcast_to(
        np.asarray(evaluate_shared(node, names, {}, of_signal), float), names["t"].shape
    )
    return value
