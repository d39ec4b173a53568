"""`simulate`: one trajectory of a system with its event log."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy.typing as npt
import xarray as xr

from nonsmooth.engine.status import Status
from nonsmooth.errors import RunWarning
from nonsmooth.runs.clock import plan_run
from nonsmooth.runs.dataset import repeated_exit, run_dataset, time_of_lost_derivatives
from nonsmooth.runs.event_log import LentRoom, lent_room
from nonsmooth.runs.first_mode import in_first_mode
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.options import (
    check_flag,
    check_run_options,
    check_signals,
    parameters_of_tangent,
)
from nonsmooth.runs.runner import (
    Outcome,
    WorkLimits,
    build_derivatives,
    build_tables,
    limits_from,
    run_plan,
)
from nonsmooth.runs.slow import check_slow_tangent, resolve_slow_start, run_slow, tables_of
from nonsmooth.runs.slow_plan import plan_slow_run
from nonsmooth.runs.start import resolve_start, start_at_end
from nonsmooth.system.slow import SlowParameters
from nonsmooth.system.system import System

__all__ = ["simulate"]


def simulate(
    system: System,
    initial: Mapping[str, float] | xr.Dataset | None = None,
    *,
    periods: float | None = None,
    t_end: float | None = None,
    times: npt.ArrayLike | None = None,
    t_start: float | None = None,
    samples_per_period: int = 100,
    parameters: Mapping[str, float | str] | None = None,
    mode: str | None = None,
    tolerance: float = 1e-12,
    events: bool = True,
    tangent: bool | Sequence[str] = False,
    max_seconds: float | None = None,
    max_events: int | None = None,
) -> xr.Dataset:
    """Trajectory of a system, its event log and the certificate of both.

    Within a mode the motion is the closed form of the equations where they are linear, and
    their Taylor series elsewhere; events are first roots of the guards found with bounds on
    their Taylor polynomials, so that none is skipped between two looks. Samples only read
    either: neither their number nor the end of the run changes the trajectory.

    Parameters
    ----------
    system : System
        The system.
    initial : mapping, xarray.Dataset, optional
        Start: state names to values (names left out take their rest value), a point of a
        result such as ``run.isel(time=5)``, or a whole run, which goes on where it ended. What was
        made with other values of parameters is refused; repeat ``parameters`` then.
    periods : float, optional
        Length of the run in periods of the forcing.
    t_end : float, optional
        Time at which the run ends.
    times : array_like, shape (n,), optional
        Times to sample, not decreasing; the run ends at the last one.

    Other Parameters
    ----------------
    t_start : float, optional
        Time at the start, zero by default.
    samples_per_period : int, optional
        Samples per period with ``periods`` and ``t_end``. A system without a period is
        sampled at 1001 equidistant times, or at ``times``.
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.
    mode : str, optional
        Mode to start in, where several would fit; a cell, or a mode for any of its cells.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.
    events : bool, optional
        Whether to keep the event log. Without it a run of any length needs no more memory
        than its samples; events are found and counted as ever, and the run can go on.
    tangent : bool or sequence of str, optional
        Whether to carry the derivatives of the states by the initial states, and by the
        parameters: by all of them, or by those named in a list, which may be empty. A run
        that goes on begins them anew.
    max_seconds : float, optional
        Seconds of the clock that the run may take. A run that takes longer ends with status
        ``work_limit``: it holds everything up to there, and goes on when it is passed as
        ``initial``. The clock decides where the run ends, never what it computes.
    max_events : int, optional
        Largest number of events, tangencies included, after which the run ends.

    Returns
    -------
    xarray.Dataset
        Over ``time``: every state, output and slow parameter by name, and ``mode``. Over
        ``event``, one row per instant: ``event_time``, ``event_name``, ``event_kind``
        (start, switch, impact, corner, graze, slide_entry, slide_exit, stick, chatter,
        release), ``event_from``, ``event_to``, ``event_path``, ``event_count``,
        ``guard_rate``, ``certified``, ``estimated``, ``state_before`` and ``state_after``;
        nothing over ``event`` with ``events=False``. With ``tangent``:
        ``tangent (time, state, state_0)``, the derivatives by the initial states, and
        ``sensitivity (time, state, parameter_0)``, those by parameters, both at a fixed
        time and just before an event that falls on a sample, and ``digits``, an estimate of
        how many digits rounding leaves: no certificate tells that of a chaotic motion.
        Attributes: ``status``
        (completed, stopped, diverged, undecided, nonunique, inadmissible, event_limit,
        step_limit, work_limit, singular, sliding, refused, interrupted) with its ``message``,
        ``phase_word`` of the last period, ``n_events``, ``n_uncertain``, ``n_estimated``, the
        system as TOML and the options.

    Raises
    ------
    OptionError
        When the start fits no mode, a name is unknown, or options contradict each other.
    ModelError
        When the parameters are refused by the system.

    Warns
    -----
    RunWarning
        When the run ended early; the result holds what was computed until then. When
        derivatives have grown beyond the range of numbers.

    See Also
    --------
    phase_word : modes visited between two times.

    Notes
    -----
    A linear mode without exits needs neither looks nor steps: whatever its frequencies, its
    closed form leads from the start to any time.

    Cost in a linear mode with exits: about a microsecond per event and as much per sample. In
    a mode that is not linear the cost is that of the steps of its Taylor series of order 20, each
    about as long as the fastest motion takes, so stiff ones are slow. Guarantees are up to
    rounding: a tangency that it leaves open is decided by the best guess, flagged in
    ``certified`` and counted in ``n_uncertain``. Where no bound of the error of a series is
    found, it is estimated: flagged in ``estimated``, counted in ``n_estimated``. Where there
    is no Taylor series, at the zero of a root for one, the run ends with status
    ``singular``; where impacts accumulate and no exit sticks, with ``event_limit``; where
    switching surfaces meet and no motion along them is known, with ``sliding``.

    Parameters in the system's ``slow`` keep their value for a whole period; a sample at the
    end of a period is that before they change. Segments also end at the knots of signals,
    which costs about a microsecond per knot.

    References
    ----------
    M. Wiercigroch and E. Pavlovskaia, Engineering Applications of Non-smooth Dynamics,
    2012, section 1: global solutions stitched from local ones.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.moling(a=0.3, b=0.15, xi=0.05, omega=0.1), periods=20)
    >>> run.attrs["status"], float(run["v"][-1].round(4))
    ('completed', 613.4445)
    """
    system = check_run_options(system, parameters, mode, tolerance)
    chosen = parameters_of_tangent(system, tangent)
    keep_events = check_flag("events", events)
    limits = limits_from(max_seconds, max_events)
    with lent_room() as room:
        wanted = _Request(
            initial=initial,
            t_start=t_start,
            mode=mode,
            repeated=parameters is not None,
            ends={"periods": periods, "t_end": t_end, "times": times},
            samples_per_period=samples_per_period,
            tolerance=tolerance,
            keep_events=keep_events,
            chosen=chosen,
            limits=limits,
            room=room,
        )
        outcome = (_simulate_slow if system.slow else _simulate)(system, wanted)
        options: dict[str, Any] = {
            "tolerance": float(tolerance),
            "samples_per_period": int(samples_per_period),
            "events": int(keep_events),
            "changed_parameters": str(dict(parameters)) if parameters else "",
        }
        result = run_dataset(system, outcome, options)
    if outcome.status not in (Status.COMPLETED, Status.STOPPED):
        warnings.warn(f"{system.name}: {result.attrs['message']}", RunWarning, stacklevel=2)
    elif repeated := repeated_exit(labels_of(system), outcome):
        warnings.warn(f"{system.name}: {repeated}", RunWarning, stacklevel=2)
    lost = time_of_lost_derivatives(result)
    if lost is not None:
        warnings.warn(
            f"{system.name}: from t = {lost:.9g} on, derivatives are beyond the range of numbers;"
            " go on from a run that ends earlier, where they begin anew",
            RunWarning,
            stacklevel=2,
        )
    return result


@dataclass(frozen=True)
class _Request:
    """A run as it was asked for, its options checked."""

    initial: Any
    t_start: float | None
    mode: str | None
    repeated: bool  # whether parameters were given again
    ends: dict[str, Any]  # periods, t_end and times, of which one or none is given
    samples_per_period: int
    tolerance: float
    keep_events: bool
    chosen: tuple[str, ...] | None  # parameters of the derivatives; None where there are none
    limits: WorkLimits
    room: LentRoom

    def sample_bytes(self, system: System) -> int:
        """Memory for a sample: its time, mode and states in the run and in the result, and more."""
        n, columns = len(system.states), 0
        if self.chosen is not None:
            columns = n + len(self.chosen)
        return 8 * (5 + n * (2 + 2 * columns) + len(system.outputs))


def _simulate(system: System, wanted: _Request) -> Outcome:
    tables = build_tables(system)
    start = resolve_start(
        system, tables, wanted.initial, wanted.t_start, wanted.mode, wanted.repeated
    )
    if wanted.chosen is not None:
        start = start_at_end(start)
    window = tables.window
    plan = plan_run(
        window, system.period_value is not None, start.instant, **wanted.ends,
        samples_per_period=wanted.samples_per_period, sample_bytes=wanted.sample_bytes(system),
    )  # fmt: skip
    check_signals(system, start.instant.time(window), plan.end.time(window))
    run = partial(
        run_plan, tables, plan, wanted.tolerance, anchor=start.anchor, state=start.state,
        begin=start.instant, keep_events=wanted.keep_events,
        derivatives=build_derivatives(system, tables, wanted.chosen), limits=wanted.limits,
        room=wanted.room,
    )  # fmt: skip
    return in_first_mode(system, tables, start, run)


def _simulate_slow(system: System, wanted: _Request) -> Outcome:
    slow = SlowParameters(system)
    check_slow_tangent(slow, wanted.chosen)
    start, period, tables = resolve_slow_start(
        slow, lambda values: tables_of(slow, values), wanted.initial, wanted.t_start, wanted.mode,
        wanted.repeated,
    )  # fmt: skip
    if wanted.chosen is not None:
        start = start_at_end(start)
    plan = plan_slow_run(
        start.instant, period, tables.window, **wanted.ends,
        samples_per_period=wanted.samples_per_period, sample_bytes=wanted.sample_bytes(system),
    )  # fmt: skip
    run = partial(
        run_slow, slow, tables, period, plan, start, wanted.tolerance,
        keep_events=wanted.keep_events, chosen=wanted.chosen, limits=wanted.limits,
    )  # fmt: skip
    return in_first_mode(system, tables, start, run)
