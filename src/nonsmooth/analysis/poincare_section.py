"""`poincare_section`: points of one trajectory where an expression vanishes, or at events."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from nonsmooth.analysis.section_dataset import section_dataset
from nonsmooth.analysis.section_options import (
    check_side,
    read_section,
    refuse_slow,
    set_limits,
)
from nonsmooth.analysis.section_rows import Crossings, NamedEvents
from nonsmooth.analysis.section_search import Pick, search, to_begin
from nonsmooth.engine.layout import Tables
from nonsmooth.errors import ModelError, OptionError, RunWarning
from nonsmooth.simulation.clock import Instant, instants
from nonsmooth.simulation.options import check_run_options, whole_number
from nonsmooth.simulation.runner import NoMode, build_tables
from nonsmooth.simulation.start import Start, explain_misfit, resolve_start, start_at_end
from nonsmooth.system.section import Section, with_section
from nonsmooth.system.system import System

__all__ = ["poincare_section"]


def poincare_section(
    system: System,
    initial: Mapping[str, float] | xr.Dataset | None = None,
    *,
    section: str,
    direction: int | None = None,
    side: str = "before",
    transient: float = 0.0,
    record: int = 1000,
    parameters: Mapping[str, float | str] | None = None,
    tolerance: float = 1e-12,
    mode: str | None = None,
    t_start: float | None = None,
    t_end: float | None = None,
) -> xr.Dataset:
    """Points at which a trajectory goes through a section, or at which an event happens.

    A crossing is found as any event is: the first root of the expression in the closed form
    or Taylor series of the motion, with none skipped between two looks.

    Parameters
    ----------
    system : System
        The system; its parameters do not vary (``slow``).
    initial : mapping, xarray.Dataset, optional
        Start, as in `simulate`.
    section : str
        An expression, such as ``"v"`` or ``"x - 0.5"``, which may also be written as
        ``"x = 0.5"``: points lie where it vanishes. Or the name of an event: of an exit, such
        as ``"impact"``, or of a mode that is entered. A name that is both a variable and an
        event means the variable.
    direction : {1, -1, 0}, optional
        Crossings that count: the expression grows (1, the default), falls (-1), or either
        (0). Events have none.
    side : {"before", "after"}, optional
        Whether a point has the states just before or just after the instant: events may
        jump.

    Other Parameters
    ----------------
    transient : float, optional
        What to drop first, in periods of the forcing, or in time units without a period.
    record : int, optional
        Number of points.
    parameters, tolerance, mode, t_start
        As in `simulate`.
    t_end : float, optional
        Time at which the search ends, however many points there are. Without it, it is given
        up after 10000 periods in which nothing came (without a period: some 50000
        oscillations of the fastest motion).

    Returns
    -------
    xarray.Dataset
        Over ``point``: every state and output by name, ``time``, ``mode``, ``certified``
        (whether rounding leaves no doubt about the crossing), and for an expression
        ``direction``, 1 where it grows and -1 where it falls; ``period_number`` and ``phase``
        where there is a period. Attributes: ``status`` (that of a run, ``time_limit`` when
        nothing came for long, or ``at_rest``) with its ``message``, ``n_points``,
        ``n_uncertain``, ``n_grazes``, the system as TOML and all options.

    Raises
    ------
    OptionError
        When the section has unknown names or never changes along the motion, the start fits
        no mode, or options contradict each other.
    ModelError
        When the parameters are refused by the system.

    Warns
    -----
    RunWarning
        When there are fewer points than asked for and no ``t_end`` was given, when there are
        none at all, and when the run ended early.

    See Also
    --------
    simulate : the trajectory itself; ``section.isel(point=-1)`` is a start for it.

    Notes
    -----
    A start on the section is no crossing: there is nothing before it. A tangential contact is
    none either; where rounding leaves open whether it is one, the best guess counts, is
    marked in ``certified``, and a contact taken for none is counted in ``n_grazes``. A jump
    over the section, as by an impact where the section is ``v``, is no crossing: take the name
    of the event. Motion that stays on the section, such as sticking where the section is the
    relative velocity, does not cross it either: take the name of the mode that is entered or
    left.

    Each crossing ends a segment of the run, so the points are those of the trajectory of
    `simulate` up to rounding, which chaos amplifies. A section that is not linear in the
    states makes the modes run by Taylor series.

    Examples
    --------
    Maxima of a damped oscillation, where the velocity falls through zero:

    >>> import nonsmooth as ns
    >>> bell = ns.System(states=["x", "v"], equations={"x": "v", "v": "-x - 0.2*v"})
    >>> top = ns.poincare_section(bell, {"v": 1.0}, section="v", direction=-1, record=2)
    >>> top["x"].values.round(4)
    array([0.8626, 0.4587])
    """
    system = check_run_options(system, parameters, mode, tolerance)
    refuse_slow(system)
    crossing, way = read_section(system, section, direction)
    check_side(side)
    record = whole_number("record", record)
    split = with_section(system, section) if crossing else None
    tables = build_tables(system)
    start = resolve_start(system, tables, initial, t_start, mode, parameters is not None)
    window = float(tables.clock[0])
    protocol: dict[str, Any] = {
        "section": section,
        "section_kind": "crossing" if crossing else "event",
        "direction": way,
        "side": side,
        "transient": float(transient),
        "record": record,
        "tolerance": float(tolerance),
        "mode": mode or "",
        "t_start": start.instant.time(window),
        "t_end": math.inf if t_end is None else float(t_end),
        "changed_parameters": str(dict(parameters)) if parameters else "",
    }
    pick: Pick = NamedEvents(system, section)
    used, begin = tables, start
    if split is not None:
        used = _tables_of(split)
        begin = _on_either_side(start, split, window, float(used.clock[0]))
        pick = Crossings(split, used, way)
    limits = set_limits(system, used, begin.instant, transient, record, t_end)
    try:
        found = search(used, begin, limits, tolerance, pick)
    except NoMode:
        raise _misfit(system, tables, start, tolerance, section) from None
    result = section_dataset(system, used, found, protocol)
    if result.attrs["message"] != "completed":
        warnings.warn(f"{system.name}: {result.attrs['message']}", RunWarning, stacklevel=2)
    return result


def _misfit(
    system: System, tables: Tables, start: Start, tolerance: float, section: str
) -> OptionError:
    """Why no mode admits a start: the system, or a section that is not smooth there."""
    try:
        to_begin(tables, start, start.instant, tolerance)
    except NoMode as misfit:
        return OptionError(explain_misfit(system, tables, start, misfit.z))
    return OptionError(
        f"section = {section!r}: at the start it has no finite value or derivative; start a little"
        " beside, or write it without what is singular there, such as x**2 + y**2 - 1 in place of"
        " sqrt(x**2 + y**2) - 1"
    )


def _tables_of(split: Section) -> Tables:
    """Tables of a system with a section in it; errors speak of the system without."""
    try:
        return build_tables(split.system)
    except ModelError as fault:
        raise ModelError(split.folded(str(fault))) from None


def _on_either_side(start: Start, split: Section, window: float, used: float) -> Start:
    """The same start for the system with a section, where each mode may have become several."""
    if start.anchor is not None:
        start = start_at_end(start)
    instant = start.instant
    if used != window:
        number, phase = instants([instant.time(window)], used)
        instant = Instant(int(number[0]), float(phase[0]))
    modes = start.modes
    if modes != (-1,):
        modes = tuple(int(i) for m in modes for i in np.flatnonzero(split.origin == m))
    return Start(start.state, instant, modes)
