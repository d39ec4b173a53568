"""`contact_statistics`: how often, how long and how hard, of settled motions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.options import SharedOptions, check_values, refuse_fixed
from nonsmooth.analysis.sweeps.contacts import Asked, contact_dataset, contact_numbers
from nonsmooth.analysis.sweeps.sweep import SweepProtocol, make_sweep, run_sweep
from nonsmooth.errors import OptionError, quote, unknown_name
from nonsmooth.runs.start import mode_numbers

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.runs.stroboscopic_map import StroboscopicMap
    from nonsmooth.system.system import System

__all__ = ["contact_statistics"]


def contact_statistics(
    system: System | StroboscopicMap,
    parameter: str | None = None,
    values: npt.ArrayLike | None = None,
    *,
    contact: str | Sequence[str] = "contact",
    of: str | Sequence[str] = (),
    percentiles: Sequence[float] = (5.0, 50.0, 95.0),
    initial: Any = None,
    start: str = "restart",
    transient: int = 200,
    record: int = 100,
    parameters: Mapping[str, float] | None = None,
    tolerance: float = 1e-12,
    mode: str | None = None,
    threads: int | None = None,
    store: str | Path | None = None,
) -> xr.Dataset:
    """Count the contacts of settled motions, and tell how long they last and how hard they are.

    Parameters
    ----------
    system : System or StroboscopicMap
        A system with a period, or a map that gives it another one.
    parameter : str, optional
        A parameter that is changed, such as a speed; without it there is one motion.
    values : array_like, optional
        Its values.
    contact : str or sequence of str, optional
        The mode, or the modes, that are contact; a mode stands for all of its cells, and a word in
        the names of cells for these: ``contact`` for ``contact,rolling``. Any mode may be asked
        for: sticking, progression, flight.
    of : str or sequence of str, optional
        States or outputs of which statistics over time are wanted, such as a contact force.
    percentiles : sequence of float, optional
        Parts of the time, from 0 to 100, below whose value a variable is.

    Other Parameters
    ----------------
    initial : mapping or dataset, optional
        Initial state as in `simulate`.
    start : {"restart", "follow up", "follow down"}, optional
        As in `bifurcation_diagram`: where the motions begin.
    transient : int, optional
        Periods left out at the beginning of each motion.
    record : int, optional
        Periods looked at after that.
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.
    mode : str, optional
        Mode to start in, where several would fit; a cell, or a mode for any of its cells.
    threads : int, optional
        Number of threads; without it, one for each processor. The result does not depend on it.
    store : str or Path, optional
        Folder in which finished parts are kept, made where it is missing. After an interruption the
        same call goes on from them.

    Returns
    -------
    xarray.Dataset
        Over ``parameter`` where there is one: ``contacts``, how many begin per period,
        ``contact_share``, the part of the time, and ``contact_duration``, ``shortest_contact`` and
        ``longest_contact`` of those that begin and end within the record, nan where there are
        none. Of every variable asked for ``_mean``, ``_rms``, ``_min`` and ``_max`` with
        ``_min_error`` and ``_max_error``, the variable's mean over the time of contact,
        ``_in_contact``, and over ``percentile`` also ``_percentile``, as in ``force_max``; then
        ``motion_period``, see notes, and ``status``.

    Raises
    ------
    OptionError
        For an option out of its range, an unknown name, a system without a period, or a ``store``
        that was begun with other options.
    RunError
        When the store could not be written, for want of room for one; what is done is kept there.

    See Also
    --------
    period_statistics : period by period along one run.
    bifurcation_diagram : counts events and impacts.

    Notes
    -----
    Counts and durations are exact: they come from the events. Statistics are weighted by time.
    Between events a variable is a series of Legendre polynomials on pieces of time which are halved
    until the last terms are 1e-10 of its largest value; these terms are the error that is told with
    the extremes. A variable that jumps or has a corner within a mode has a larger one.
    Percentiles are read off 32 values of each piece.

    The ``motion_period``, in periods of the forcing, is found as in `bifurcation_diagram`: strobes
    repeat after it to 1e-6 of the size of each state. It is at most half of ``record``. Motions
    with a 0 are chaotic or quasi-periodic, have a longer period, or still hold a transient, which
    then is in the numbers too. The message says how many there are. A larger ``transient`` takes a
    transient away, `regime` tells chaos.

    Examples
    --------
    One contact every other period, with the largest force of the stop:

    >>> import nonsmooth as ns
    >>> found = ns.contact_statistics(
    ...     ns.models.soft_impact(omega=0.83), of="stop_force", transient=400, record=10
    ... )
    >>> float(found["contacts"]), float(found["stop_force_max_error"]) < 1e-6
    (0.5, True)
    """
    if (parameter is None) != (values is None):
        raise OptionError("give both a parameter and its values, or neither for a single motion")
    sweep = make_sweep(
        system, "contact_statistics", initial=initial, start=start, transient=transient,
        record=record, shared=SharedOptions(parameters, tolerance, mode, threads, store),
    )  # fmt: skip
    asked = _asked(sweep, contact, of, percentiles)
    model = sweep.system
    name, grid = "", np.zeros(1)
    if parameter is not None:
        name, grid = parameter, check_values(model, parameter, values)
        refuse_fixed(system, parameters, (parameter,), "values")
    swept = run_sweep(
        sweep, name, grid, lambda settled: contact_numbers(settled, asked),
        call="contact_statistics", options=asked.options,
    )  # fmt: skip
    result = contact_dataset(sweep, name, swept, asked)
    if parameter is None:
        result = result.isel(parameter=0, drop=True)
        del result.attrs["parameter"]
    return result


def _names(option: str, given: Any) -> tuple[str, ...]:
    if isinstance(given, str):
        return (given,)
    if not isinstance(given, Sequence):
        raise OptionError(f"{option} = {quote(given)}: give a name, or a list of names")
    return tuple(str(name) for name in given)


def _asked(sweep: SweepProtocol, contact: Any, of: Any, percentiles: Any) -> Asked:
    """What is to be found out, checked."""
    model = sweep.system
    modes = _names("contact", contact)
    if not modes:
        raise OptionError(f"contact= names no mode; the system has {', '.join(model.modes)}")
    numbers: set[int] = set()
    for name in modes:
        try:
            numbers |= set(mode_numbers(model, str(name)))
        except OptionError as fault:
            if contact == "contact":  # by default, so nobody may have typed it
                raise OptionError(
                    f"contact: the system has no mode 'contact'; name the modes that are"
                    f" contact by contact=, of {', '.join(model.modes)}"
                ) from None
            raise OptionError(f"contact: {str(fault).removeprefix('mode: ')}") from None
    variables = _names("of", of)
    known = [*model.states, *model.outputs]
    for name in variables:
        if name not in known:
            raise OptionError(f"of: {unknown_name('variable', name, known)}")
    try:
        parts = np.atleast_1d(np.asarray(percentiles, dtype=float))
    except (TypeError, ValueError, OverflowError):
        parts = np.full(1, np.nan)
    if parts.ndim != 1 or not np.all((parts >= 0.0) & (parts <= 100.0)):
        raise OptionError(f"percentiles = {quote(percentiles)}: give numbers from 0 to 100")
    return Asked(modes, tuple(sorted(numbers)), variables, parts)
