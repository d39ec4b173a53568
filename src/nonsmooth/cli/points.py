"""Points of one motion for commands: strobes, or those of a section, and two of their variables."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

from nonsmooth.cli.arguments import names
from nonsmooth.errors import OptionError, RunWarning, unknown_name

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.system.system import System

__all__ = ["pair_of_variables", "strobe_points"]


def strobe_points(system: System, initial: dict[str, float], **options: Any) -> xr.Dataset:
    """Strobes; the summary of a command says what a warning would say."""
    from nonsmooth.analysis.stroboscopic_map import stroboscopic_map

    if system.period is None and options.get("period") is None:
        raise OptionError(
            f"{system.name} has no period; give the time between strobes by --period, or take"
            f" points of a section: nonsmooth section --section {system.states[-1]}"
        )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RunWarning)
        return stroboscopic_map(system, initial, **options)


def pair_of_variables(system: System, text: str | None) -> tuple[str, str]:
    """Two variables to draw; by default the first two states, or the only one in time."""
    if text is None:
        return (system.states[0], system.states[1]) if len(system.states) > 1 else (
            "time", system.states[0],
        )  # fmt: skip
    pair = names(text)
    if len(pair) != 2:
        raise OptionError(f"--variables: {text!r} is not two variables, such as x,v")
    known = [*system.states, *system.outputs, "time"]
    for name in pair:
        if name not in known:
            raise OptionError(f"--variables: {unknown_name('variable', name, known)}")
    return pair[0], pair[1]
