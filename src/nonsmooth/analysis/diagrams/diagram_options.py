"""Options of a bifurcation diagram, checked."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.columns import DiagramProtocol
from nonsmooth.analysis.options import check_match
from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.runs.maps import Map
from nonsmooth.runs.options import whole_number
from nonsmooth.runs.poincare_map import PoincareMap
from nonsmooth.system.system import System

__all__ = ["check_values", "check_way", "read_protocol"]

_STARTS = ("restart", "follow up", "follow down")
_SIDES = ("before", "after")


def check_way(start: Any) -> str:
    """How columns begin."""
    if start not in _STARTS:
        raise OptionError(f"start = {start!r}: {unknown_name('way', str(start), _STARTS)}")
    return str(start)


def read_protocol(
    chosen: Map, parameter: str, transient: Any, record: Any, match: Any, at: Any, side: Any
) -> DiagramProtocol:
    """How every column is computed."""
    system = chosen.system
    if side not in _SIDES:
        raise OptionError(f"side = {side!r}: {unknown_name('side', str(side), _SIDES)}")
    return DiagramProtocol(
        chosen=chosen,
        parameter=parameter,
        transient=0 if transient == 0 else whole_number("transient", transient),
        record=whole_number("record", record),
        match=check_match(match),
        exits=_exits(chosen, at, side),
        after=side == "after",
        drifting=np.array([name in system.drift_states for name in system.states]),
        outputs=bool(system.outputs),
    )


def check_values(system: System, parameter: Any, values: Any) -> npt.NDArray[np.float64]:
    """Values of the parameter, one for each column."""
    if parameter not in system.parameters:
        raise OptionError(unknown_name("parameter", str(parameter), system.parameters))
    try:
        grid = np.atleast_1d(np.asarray(values, dtype=float))
    except (TypeError, ValueError):
        raise OptionError(f"values = {values!r:.60}: give a list of numbers") from None
    if grid.ndim != 1 or grid.size == 0 or not np.all(np.isfinite(grid)):
        raise OptionError(
            "values= takes a one-dimensional, non-empty list of finite numbers, such as"
            " np.linspace(0.5, 1.0, 400)"
        )
    return grid


def _exits(chosen: Map, at: Any, side: Any) -> npt.NDArray[np.bool_] | None:
    """Exits of each mode with a name; None for the points of the map."""
    system = chosen.system
    if isinstance(chosen, PoincareMap) and (at, side) != ("strobe", "before"):
        raise OptionError(
            f"at = {at!r:.60}, side = {side!r:.60}: the map says itself where its points lie and on"
            " which side of an event; give these to PoincareMap"
        )
    if at == "strobe":
        return None
    names = system.compiled.exit_names
    known = dict.fromkeys(name for of_mode in names for name in of_mode)
    if at not in known:
        raise OptionError(f"at: {unknown_name('event', str(at), ['strobe', *known])}")
    most = max(len(of_mode) for of_mode in names)
    found = np.zeros((len(names), most), bool)
    for m, of_mode in enumerate(names):
        found[m, : len(of_mode)] = [name == at for name in of_mode]
    return found
