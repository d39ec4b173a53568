"""`poincare_section`: points of one trajectory where an expression vanishes, or at events."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from nonsmooth.runs.options import check_run_options
from nonsmooth.runs.poincare_map import PoincareMap
from nonsmooth.runs.section_points import take_points
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

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
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.
    mode : str, optional
        Mode to start in, where several would fit; a cell, or a mode for any of its cells.
    t_start : float, optional
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
    PoincareMap : the map from one point to the next.
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
    chosen = PoincareMap(system, section, direction=direction, side=side)
    return take_points(
        chosen,
        initial,
        transient=transient,
        record=record,
        tolerance=tolerance,
        mode=mode,
        t_start=t_start,
        t_end=t_end,
        changed=str(dict(parameters)) if parameters else "",
        repeated=parameters is not None,
    )
