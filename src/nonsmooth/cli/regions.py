"""Texts of the command line as regions of starts and as maps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from nonsmooth.cli.arguments import constants, settings, value_range
from nonsmooth.errors import OptionError, unknown_name

if TYPE_CHECKING:
    import numpy as np

    from nonsmooth.runs.poincare_map import PoincareMap
    from nonsmooth.runs.stroboscopic_map import StroboscopicMap
    from nonsmooth.system.system import System

__all__ = ["build_map", "completion_rules", "grid_region", "range_region"]

_MOST_CELLS = 100_000_000  # of a grid


def range_region(system: System, over: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Ranges of states from texts such as ``x=-1:1``."""
    region = {}
    for name, value in settings(over, "--over").items():
        parts = [part.strip() for part in value.split(":")]
        if len(parts) != 2 or not all(parts):
            raise OptionError(f"--over: {name}={value} is not of the form name=low:high")
        _check_state(system, name)
        ends = constants(dict(zip(("low", "high"), parts, strict=True)), "--over")
        region[name] = (ends["low"], ends["high"])
    return region


def grid_region(system: System, over: Sequence[str]) -> dict[str, np.ndarray]:
    """Values of states from texts such as ``x=-1:1:200``, two states at least."""
    region: dict[str, np.ndarray] = {}
    cells = 1
    for text in over:
        name, values = value_range(text)
        if name in region:
            raise OptionError(f"--over: {name!r} is given twice")
        _check_state(system, name)
        if values.size < 2 or not values[0] < values[-1]:
            raise OptionError(
                f"--over: {text!r} is no row of cells; the first value must be less than the last"
                " one, and the count 2 or more"
            )
        region[name] = values
        cells *= values.size
    if len(region) < 2:
        raise OptionError("--over: basins need two states or more, such as x=-1:1:200")
    if cells > _MOST_CELLS:
        raise OptionError(f"--over: {cells} cells are too many; {_MOST_CELLS} are the most")
    return region


def _check_state(system: System, name: str) -> None:
    if name not in system.states:
        raise OptionError(f"--over: {unknown_name('state', name, system.states)}")


def completion_rules(texts: Sequence[str]) -> dict[str, float | str]:
    """States outside the region from texts such as ``q=max(0, p - g)``."""
    return dict(settings(texts, "--complete"))


def build_map(
    system: System,
    *,
    section: str | None,
    direction: int | None,
    side: str | None,
    phase: float | None,
    period: str | None,
    every: int,
) -> PoincareMap | StroboscopicMap:
    """The map from strobe to strobe, or from one point of a section to the next."""
    if section is None:
        if direction is not None or side is not None:
            raise OptionError("--direction and --side are those of a section: name it: --section")
        from nonsmooth.runs.stroboscopic_map import StroboscopicMap

        if period is None and system.period is None:
            raise OptionError(
                f"{system.name} has no period; name a section, such as --section"
                f" {system.states[-1]}, or give --period"
            )
        return StroboscopicMap(system, phase=phase or 0.0, period=period, every=every)
    if phase is not None or period is not None:
        raise OptionError("--phase and --period are those of strobes: leave out --section, or them")
    from nonsmooth.runs.poincare_map import PoincareMap

    return PoincareMap(system, section, direction=direction, side=side or "before", every=every)
