"""What analyses of maps are given: a map, or a system that stands for its stroboscopic map."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nonsmooth.errors import OptionError, quote
from nonsmooth.runs.maps import Map
from nonsmooth.runs.options import check_run_options
from nonsmooth.runs.strobe_times import require_period, require_repeats
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.system.system import System

__all__ = ["map_of"]


def map_of(
    given: Any,
    parameters: Mapping[str, float | str] | None,
    tolerance: float,
    verb: str,
    *,
    phase: float = 0.0,
    mode: str | None = None,
    states_only: bool = False,
    strobes_only: bool = False,
) -> Map:
    """The map that is meant, with some parameters changed; the options of a run are checked.

    ``phase`` is that of the strobes of a system; a map has its own. ``states_only``: whether the
    states of a point have to tell all about it, which those of a section with forcing do not.
    ``strobes_only``: whether a section is none of the advice.
    """
    if isinstance(given, Map):
        check_run_options(given.system, parameters, mode, tolerance)
        if phase != 0.0:
            raise OptionError(
                f"phase = {quote(phase)}: the map says itself where its points lie; give the phase"
                " to StroboscopicMap, or leave it out"
            )
        chosen = given.with_parameters(**parameters) if parameters else given
        require_repeats(chosen.system, verb)
        if states_only:
            chosen.check_states_suffice(verb)
        return chosen
    if not isinstance(given, System):
        raise OptionError(
            f"system = {quote(given)} is neither a System nor a map; write one, take one from"
            " ns.models, or make a map of one with ns.StroboscopicMap or ns.PoincareMap"
        )
    system = check_run_options(given, parameters, mode, tolerance)
    require_repeats(system, verb)
    if not system.slow:  # about which the map has more to say
        section = "" if strobes_only else ", or ns.PoincareMap for a section of it"
        require_period(
            system,
            verb,
            "give ns.StroboscopicMap(system, period=...) with a length of time in its place"
            f"{section}, or give the system a period",
        )
    strobed = StroboscopicMap(system, phase=phase)
    if states_only:
        strobed.check_states_suffice(verb)
    return strobed
