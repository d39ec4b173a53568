"""What analyses of maps are given: a map, or a system that stands for its stroboscopic map."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any, TypeAlias

from nonsmooth.errors import OptionError, ResultWarning
from nonsmooth.runs.options import check_run_options
from nonsmooth.runs.poincare_map import PoincareMap
from nonsmooth.runs.stroboscopic import require_period
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.system.system import System

__all__ = ["Map", "map_of"]

Map: TypeAlias = StroboscopicMap | PoincareMap


def map_of(
    given: Any,
    parameters: Mapping[str, float] | None,
    tolerance: float,
    verb: str,
    *,
    phase: float = 0.0,
    mode: str | None = None,
    states_only: bool = False,
) -> Map:
    """The map that is meant, with some parameters changed; the options of a run are checked.

    ``phase`` is that of the strobes of a system; a map has its own. ``states_only``: whether the
    states of a point have to tell all about it, which those of a section with forcing do not.
    """
    if isinstance(given, StroboscopicMap | PoincareMap):
        check_run_options(given.system, parameters, mode, tolerance)
        if phase != 0.0:
            raise OptionError(
                f"phase = {phase!r:.60}: the map says itself where its points lie; give the phase"
                " to StroboscopicMap, or leave it out"
            )
        if states_only and isinstance(given, PoincareMap) and given.reads_time:
            raise OptionError(
                f"{verb}: the motion of {given.system.name!r} depends on time, so that it also"
                f" matters when it comes to section = {given.section!r}; take its StroboscopicMap"
            )
        chosen = given.with_parameters(**parameters) if parameters else given
        return _told(chosen, verb) if states_only else chosen
    if not isinstance(given, System):
        raise OptionError(
            f"system = {given!r:.60} is neither a System nor a map; write one, take one from"
            " ns.models, or make a map of one with ns.StroboscopicMap or ns.PoincareMap"
        )
    system = check_run_options(given, parameters, mode, tolerance)
    if not system.slow:  # about which the map has more to say
        require_period(system, verb)
    chosen = StroboscopicMap(system, phase=phase)
    return _told(chosen, verb) if states_only else chosen


def _told(chosen: Map, verb: str) -> Map:
    """The map, with a warning where its points do not say all; refused where time decides."""
    if isinstance(chosen, StroboscopicMap) and chosen.system.unrepeated:
        raise OptionError(
            f"{verb}: {chosen.system.name!r} has {chosen.system.unrepeated}, which does not repeat,"
            " so a state at a strobe does not say what follows; leave it out, or look at runs from"
            " one time with simulate or ensemble"
        )
    if isinstance(chosen, StroboscopicMap) and chosen.hides_phase:
        # told where the user calls the verb
        warnings.warn(
            f"{verb}: {chosen.system.name!r} has a frequency that is at another phase at each"
            " strobe. All starts begin at the same phases, and later points differ by more than"
            " their states: closed curves may be called aperiodic, and basins belong to this start"
            " alone. Take a period that holds whole turns of every frequency, where there is one",
            ResultWarning,
            stacklevel=4,
        )
    return chosen
