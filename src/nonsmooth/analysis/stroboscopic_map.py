"""`stroboscopic_map`: points of one motion, one per period."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from nonsmooth.runs.options import check_run_options, whole_number
from nonsmooth.runs.strobed_motion import StrobeRequest, StrobeSchedule, strobe_points
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["stroboscopic_map"]


def stroboscopic_map(
    system: System,
    initial: Any = None,
    *,
    transient: int = 0,
    record: int = 1000,
    phase: float = 0.0,
    period: float | str | None = None,
    parameters: Mapping[str, float] | None = None,
    tolerance: float = 1e-12,
    mode: str | None = None,
    t_start: float | None = None,
) -> xr.Dataset:
    """Look at a motion once per period.

    Parameters
    ----------
    system : System
        The system; it needs a period, or ``period``.
    initial : mapping, dataset or run, optional
        Initial state as in `simulate`; the rest state without it.
    transient : int, optional
        Strobes left out at the beginning.
    record : int, optional
        Strobes kept.
    phase : float, optional
        Part of the period at which strobes are taken, from 0 to less than 1 (dimensionless).
    period : float or str, optional
        Another time between strobes than the period of the system: a length of time, or an
        expression of parameters such as ``"2*pi/omega_2"``, for a system with several
        frequencies or none.
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
        Time of the start, 0 without it.

    Returns
    -------
    xarray.Dataset
        Over ``point``: every state and output, ``time`` and ``mode``; attributes with the protocol
        and the ``status``. A run that ends early leaves the points until then.

    Raises
    ------
    OptionError
        For a system without a period, or an option out of its range.

    Warns
    -----
    RunWarning
        When the run ended early.

    See Also
    --------
    simulate : the whole motion.
    StroboscopicMap : the map itself.

    Notes
    -----
    The strobes of the period of a system are taken at exactly the same phase, however late; those
    of another period at times that are rounded once each. The equations need not repeat: a motion
    under ``signals``, or with t by itself in its equations, has its points as well.

    References
    ----------
    M. Wiercigroch and E. Pavlovskaia, Engineering Applications of Non-smooth Dynamics, 2012,
    section 2: Poincaré maps of the mole.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> points = ns.stroboscopic_map(ns.models.soft_impact(), transient=100, record=50)
    >>> dict(points.sizes), points.attrs["status"]
    ({'point': 50}, 'completed')
    """
    system = check_run_options(system, parameters, mode, tolerance)
    chosen = StrobeSchedule(system, phase=phase, period=period)
    wanted = StrobeRequest(
        initial,
        transient=whole_number("transient", transient, 0),
        record=whole_number("record", record),
        from_start=True,
        mode=mode,
        t_start=t_start,
        tolerance=tolerance,
        repeated=parameters is not None,
    )
    return strobe_points(chosen, wanted, str(dict(parameters)) if parameters else "")
