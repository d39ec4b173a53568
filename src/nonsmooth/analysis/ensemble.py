"""Many runs: initial states by parameter values, on all processors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.ensembles.chunk import EnsembleProtocol
from nonsmooth.analysis.ensembles.ensemble_dataset import Frame
from nonsmooth.analysis.ensembles.members import mappings_of, members_of, split_parameters
from nonsmooth.analysis.ensembles.work import Work
from nonsmooth.analysis.options import SharedOptions, system_attributes
from nonsmooth.errors import ModelError, OptionError
from nonsmooth.runs.clock import Instant, Plan, plan_run
from nonsmooth.runs.labels import Columns, labels_of
from nonsmooth.runs.lane_runner import LaneRunner
from nonsmooth.runs.options import (
    check_count,
    check_signals,
    time_grid,
    whole_number,
)
from nonsmooth.runs.strobe_times import check_phase, require_period, strobes
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["ensemble"]

_BEGIN = Instant(0, 0.0)


def ensemble(
    system: System,
    initial: Any = None,
    *,
    parameters: Mapping[str, Any] | None = None,
    combine: str = "grid",
    transient: int = 0,
    record: int = 100,
    phase: float = 0.0,
    times: npt.ArrayLike | None = None,
    tolerance: float = 1e-12,
    mode: str | None = None,
    threads: int | None = None,
    store: str | Path | None = None,
) -> xr.Dataset:
    """Run a system from many initial states and for many parameter values.

    Parameters
    ----------
    system : System
        The system; without ``times`` it needs a period.
    initial : mapping or dataset, or a list of these, optional
        Numbers, or lists of numbers of one length, by the names of states: one initial state for
        each place in the lists. Or a point of a dataset, as in `simulate`, or a list with one for
        each. States that are not given are those at rest.
    parameters : mapping of str to float or array_like, optional
        Values of parameters that differ from those of the system. A list of values gives several.
    combine : {"grid", "pairs"}, optional
        With ``"grid"`` every initial state is run with every combination of the parameter values;
        initial states follow each other, then the last parameter changes first. With ``"pairs"``
        all lists have one length, and run i takes entry i of each.
    transient : int, optional
        Strobes left out at the beginning of each run; strobe 0 is at the start where ``phase`` is
        0.
    record : int, optional
        Strobes kept after that; the run ends at the last of them.
    phase : float, optional
        Part of the period at which strobes are taken, from 0 to less than 1.
    times : array_like, optional
        Times to record instead of strobes, in order; runs start at time 0.
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
        same call goes on from them. The dataset that comes back is read from its file ``result.nc``
        when it is needed, so that neither it nor what is kept has to fit into memory.

    Returns
    -------
    xarray.Dataset
        Over ``lane``, one for each run, and ``point`` (strobes, by number) or ``time``: states,
        outputs and ``mode``, nan and -1 after a run has ended. Over ``lane``: ``status``,
        ``n_uncertain``, ``n_estimated``, ``end_time``, the parameters with several values as
        coordinates, and with ``state`` also ``initial_state`` and ``end_state``. No run raises:
        what ended early says so in its status, a start that no mode admits is ``inadmissible``,
        parameters that the system refuses are ``refused``, and runs that an interruption left out
        ``interrupted``.

    Raises
    ------
    OptionError
        For an option out of its range, unknown names, lists of different lengths, a result that
        does not fit into memory, or a ``store`` that was begun with other options.
    RunError
        When the store could not be written, for want of room for one; what is done is kept there.

    See Also
    --------
    bifurcation_diagram : periods, words and drift over one parameter.
    simulate : a single run with all its events.

    Notes
    -----
    The equations need not repeat: under ``signals``, or with t by itself in them, strobes are
    instants to look at, and nothing is said of what the runs settle to.

    Runs are spread over threads in chunks that do not depend on their number, and each run is
    computed by itself: digits depend neither on threads nor on the other runs.

    References
    ----------
    M. Wiercigroch and E. Pavlovskaia, Engineering Applications of Non-smooth Dynamics, 2012,
    section 2: coexisting attractors of impact oscillators.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> runs = ns.ensemble(
    ...     ns.models.soft_impact(),
    ...     {"x": np.linspace(-0.5, 0.5, 10)},
    ...     parameters={"omega": [0.7, 0.8, 0.9]},
    ...     transient=100,
    ...     record=1,
    ... )
    >>> dict(runs.sizes), runs.attrs["message"]
    ({'lane': 30, 'point': 1, 'state': 2}, 'completed')
    """
    single, several = split_parameters(system, parameters)
    shared = SharedOptions(single, tolerance, mode, threads, store)
    system = shared.system_of(system)
    if system.slow:
        raise OptionError(
            "ensemble: the parameters in slow= change from period to period; simulate the system,"
            " or leave slow= out"
        )
    initial = mappings_of(system, initial, None if several and not single else parameters, several)
    plan, along, recorded = _plan(system, times, transient, record, phase)
    protocol = EnsembleProtocol(
        system=system,
        members=members_of(system, initial, several, combine),
        plan=plan,
        n_points=len(next(iter(along.values()))[1]),
        mode=mode,
    )
    _check_records(protocol)
    options = {
        "combine": combine,
        **recorded,
        "tolerance": float(tolerance),
        "initial_mode": mode or "",
        "changed_parameters": shared.changes,
    }
    attrs = system_attributes(system)
    frame = Frame(protocol, along, attrs | options)
    window = LaneRunner(system, tolerance).window
    work = Work(protocol, plan(window).end.number + 1, tolerance, shared.workers)
    if store is None:
        return work.in_memory(frame)
    asked = {
        "call": "ensemble",
        "system": attrs["system"],
        "initial": protocol.members.starts,
        "parameters": protocol.members.sets,
        **options,
        "times": along["time"][1] if "time" in along else [],
    }
    return work.in_store(frame, store, asked)


def _check_records(protocol: EnsembleProtocol) -> None:
    """Every signal is known until the end of each run, whose length may depend on parameters."""
    system, members = protocol.system, protocol.members
    for number in range(members.n_sets if system.signals else 0):
        try:
            window = system.with_parameters(**members.parameters(number)).period_value
        except ModelError:
            continue  # runs with these values are refused
        if window is not None:
            check_signals(system, 0.0, protocol.plan(window).end.time(window))


def _plan(
    system: System, times: Any, transient: Any, record: Any, phase: Any
) -> tuple[Callable[[float], Plan], Columns, dict[str, Any]]:
    """What is recorded: a plan for each length of the window, its coordinate, the options."""
    part = check_phase(phase)
    left_out = whole_number("transient", transient, 0)
    count = check_count(whole_number("record", record))
    if times is None:
        require_period(system, "ensemble", "give times=, or give the system a period")

        def of_strobes(window: float) -> Plan:
            numbers, phases = strobes(window, _BEGIN, None, part, left_out, count)
            return Plan(Instant(int(numbers[-1]), float(phases[-1])), numbers, phases)

        numbers = np.arange(left_out, left_out + count)
        along: Columns = {"point": (("point",), numbers, {"long_name": "strobe"})}
        return of_strobes, along, {
            "transient": left_out, "record": count, "phase_of_period": part,
        }  # fmt: skip
    if (left_out, count, part) != (0, 100, 0.0):
        raise OptionError("give times=, or transient=, record= and phase=, not both")
    grid = time_grid(times)
    if grid[0] < 0.0:
        raise OptionError(f"times[0] = {grid[0]:g} lies before the start, t = 0")
    check_signals(system, 0.0, float(grid[-1]))
    periodic = system.period_value is not None

    def of_times(window: float) -> Plan:
        return plan_run(
            window, periodic, _BEGIN, periods=None, t_end=None, times=grid, samples_per_period=1
        )

    return of_times, {"time": (("time",), grid, labels_of(system).attributes("time"))}, {}
