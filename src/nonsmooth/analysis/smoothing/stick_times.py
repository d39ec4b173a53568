"""Time that a motion spends on its surfaces: exactly, and beside them where it is smoothed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.status import EventKind
from nonsmooth.engine.tables import SLIDES
from nonsmooth.system.system import System
from nonsmooth.system.text.evaluate import evaluate_shared
from nonsmooth.system.text.expressions import Expression

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Band", "bands_of", "creep_beside", "time_beside", "time_on"]

Floats = npt.NDArray[np.float64]


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
