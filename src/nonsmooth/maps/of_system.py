"""What analyses of maps are given: a map, or a system that stands for its stroboscopic map."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nonsmooth.errors import OptionError
from nonsmooth.maps.poincare import PoincareMap
from nonsmooth.maps.stroboscopic import StroboscopicMap
from nonsmooth.simulation.options import check_run_options
from nonsmooth.simulation.stroboscopic import require_period
from nonsmooth.system.system import System

__all__ = ["map_of"]


def map_of(
    given: Any, parameters: Mapping[str, float] | None, tolerance: float, verb: str
) -> StroboscopicMap | PoincareMap:
    """The map that is meant, with some parameters changed."""
    if isinstance(given, StroboscopicMap | PoincareMap):
        check_run_options(given.system, parameters, None, tolerance)
        return given.with_parameters(**parameters) if parameters else given
    if not isinstance(given, System):
        raise OptionError(
            f"system = {given!r:.60} is neither a System nor a map; write one, take one from"
            " ns.models, or make a map of one with ns.StroboscopicMap or ns.PoincareMap"
        )
    system = check_run_options(given, parameters, None, tolerance)
    require_period(system, verb)
    return StroboscopicMap(system)
