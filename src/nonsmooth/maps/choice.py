"""What an analysis is asked about: a map, or a system, which stands for its stroboscopic map."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TypeAlias

from nonsmooth.errors import OptionError
from nonsmooth.maps.poincare import PoincareMap
from nonsmooth.maps.stroboscopic import StroboscopicMap
from nonsmooth.simulation.options import check_run_options
from nonsmooth.simulation.stroboscopic import require_period
from nonsmooth.system.system import System

__all__ = ["Map", "as_map"]

Map: TypeAlias = StroboscopicMap | PoincareMap


def as_map(
    given: Any,
    verb: str,
    *,
    phase: float = 0.0,
    parameters: Mapping[str, float] | None = None,
    mode: str | None = None,
    tolerance: float = 1e-12,
) -> Map:
    """Map that is meant, its parameters changed; the options of a run are checked."""
    if isinstance(given, StroboscopicMap | PoincareMap):
        if phase != 0.0:
            raise OptionError(
                f"phase = {phase!r:.60}: the map says itself where its points lie; give the phase"
                " to StroboscopicMap, or leave it out"
            )
        system = check_run_options(given.system, parameters, mode, tolerance)
        return replace(given, system=system)
    if not isinstance(given, System):
        raise OptionError(
            f"system = {given!r:.60} is neither a System nor a map of one, such as"
            " ns.PoincareMap(system, 'v')"
        )
    system = check_run_options(given, parameters, mode, tolerance)
    if not system.slow:
        require_period(system, verb)
    return StroboscopicMap(system, phase=phase)
