"""What a map of regimes over two parameters asks, with every option checked."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.options import SharedOptions, refuse_fixed
from nonsmooth.analysis.regimes.options import RegimeProtocol, check_system, make_protocol
from nonsmooth.errors import ModelError, OptionError, quote, unknown_name
from nonsmooth.runs.runner import build_tables
from nonsmooth.runs.start import check_carried, resolve_start
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.system.system import System

__all__ = ["MapQuestion", "ask_map"]

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class MapQuestion:
    """All that the regime of each point of a map depends on."""

    system: System
    names: tuple[str, str]  # of the two parameters, the horizontal one first
    values: tuple[Floats, Floats]
    protocol: RegimeProtocol
    period: float | str | None
    initial: Any
    mode: str | None
    tolerance: float
    changes: str  # the parameters that the user changed, as a text

    @cached_property
    def strobes(self) -> StroboscopicMap:
        """The map whose points are the times at which motions are looked at."""
        return StroboscopicMap(self.system, phase=self.protocol.phase, period=self.period)

    @property
    def recorded(self) -> dict[str, Any]:
        """What every result tells of the options, as attributes."""
        protocol, period = self.protocol, self.period
        return {
            "transient": protocol.transient,
            "record": protocol.record,
            "evidence": protocol.evidence,
            "longest": protocol.longest,
            "confirm": protocol.confirm,
            "phase_of_period": protocol.phase,
            "strobe_period": "the period of the system" if period is None else str(period),
            "match": protocol.match,
            "tolerance": float(self.tolerance),
            "mode_of_start": self.mode or "",
            "changed_parameters": self.changes,
        }

    @property
    def told(self) -> dict[str, Any]:
        """What a store compares beside these: the system, the values and the initial state."""
        return {
            "system": self.system.to_toml(),
            "over": dict(zip(self.names, self.values, strict=True)),
            "initial": self._start,
        }

    @property
    def _start(self) -> Any:
        """The initial state in numbers, for comparison with that of an earlier call."""
        if hasattr(self.initial, "data_vars"):
            begin = resolve_start(
                self.system, build_tables(self.system), self.initial, None, self.mode, repeated=True
            )
            return [*begin.state, *begin.modes]
        return {str(name): float(value) for name, value in (self.initial or {}).items()}


def ask_map(
    verb: str,
    given: System,
    over: Any,
    *,
    initial: Any,
    transient: int,
    record: int,
    evidence: int,
    longest: int | None,
    confirm: int,
    phase: float,
    period: float | str | None,
    match: float,
    parameters: Mapping[str, float] | None,
    tolerance: float,
    mode: str | None,
) -> MapQuestion:
    """The question of a verb; what no point could begin with is refused here."""
    shared = SharedOptions(parameters, tolerance, mode)
    system = shared.system_of(given)
    check_system(system, period, verb)
    names, values = _check_grid(system, over)
    refuse_fixed(given, parameters, names, "over")
    _check_corners(system, period, verb, names, values)
    protocol = make_protocol(transient, record, evidence, longest, confirm, phase, match)
    check_carried(system, initial, parameters, names)
    resolve_start(system, build_tables(system), initial, None, mode, repeated=True)
    return MapQuestion(
        system, names, values, protocol, period, initial, mode, tolerance, shared.changes
    )


def _check_corners(
    system: System,
    period: float | str | None,
    verb: str,
    names: tuple[str, str],
    values: tuple[Floats, Floats],
) -> None:
    """Refuse a time between strobes that is one period of the system here, and none there."""
    if period is None:
        return
    for corner in product(*((each[0], each[-1]) for each in values)):
        with suppress(ModelError):  # the map has a label for what the system refuses
            there = system.with_parameters(**dict(zip(names, map(float, corner), strict=True)))
            check_system(there, period, verb)


def _check_grid(system: System, over: Any) -> tuple[tuple[str, str], tuple[Floats, Floats]]:
    """Names and values of the two parameters."""
    if not isinstance(over, Mapping) or len(over) != 2:
        what = f": it names {len(over)}" if isinstance(over, Mapping) else f" = {quote(over)}"
        raise OptionError(
            f"over{what}; give two different parameters and their values, such as"
            ' {"omega": np.linspace(0.5, 1, 50), "zeta": np.linspace(0.01, 0.1, 40)}'
        )
    values = []
    for name, each in over.items():
        if name not in system.parameters:
            raise OptionError(f"over: {unknown_name('parameter', name, system.parameters)}")
        try:
            array = np.atleast_1d(np.asarray(each, dtype=float))
        except (TypeError, ValueError, OverflowError):
            raise OptionError(f"over: {name!r}: {quote(each)} is no list of numbers") from None
        if array.ndim != 1 or array.size == 0 or not np.all(np.isfinite(array)):
            raise OptionError(
                f"over: {name!r} takes a one-dimensional, non-empty list of finite numbers, such as"
                " np.linspace(0.5, 1, 50)"
            )
        if np.any(np.diff(array) <= 0.0):
            raise OptionError(f"over: the values of {name!r} must grow; sort them, each once")
        values.append(array)
    first, second = (str(name) for name in over)
    return (first, second), (values[0], values[1])
