"""Run from a start in the first of its modes that admits it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from nonsmooth.engine.tables import Tables
from nonsmooth.errors import OptionError
from nonsmooth.runs.misfit import explain_misfit
from nonsmooth.runs.runner import NoMode
from nonsmooth.runs.start import Start
from nonsmooth.system.system import System

__all__ = ["in_first_mode"]

Result = TypeVar("Result")


def in_first_mode(
    system: System, tables: Tables, start: Start, run: Callable[[int], Result]
) -> Result:
    """What ``run`` gives in the first mode that it does not refuse with `NoMode`.

    Raises `OptionError` that tells what fails in each mode where none admits the start.
    """
    for mode in start.modes:
        try:
            return run(mode)
        except NoMode as fault:
            misfit = fault
    raise OptionError(explain_misfit(system, tables, start, misfit.z))
