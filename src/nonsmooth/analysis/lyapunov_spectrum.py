"""`lyapunov_spectrum`: Lyapunov exponents of a trajectory, through impacts and switches."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import xarray as xr

from nonsmooth.analysis.exponents.exponent_dataset import exponent_dataset
from nonsmooth.analysis.exponents.exponent_run import (
    ExponentProtocol,
    ExponentRun,
    run_exponents,
)
from nonsmooth.analysis.exponents.horizon import find_horizon
from nonsmooth.analysis.exponents.return_time import return_time
from nonsmooth.analysis.options import SharedOptions, check_seed
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import Tables
from nonsmooth.errors import OptionError, ResultWarning, RunWarning
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.options import check_signals, finite_number
from nonsmooth.runs.options import whole_number as whole
from nonsmooth.runs.poincare_map import PoincareMap
from nonsmooth.runs.runner import build_derivatives, build_tables
from nonsmooth.runs.start import Start, resolve_start, start_at_end
from nonsmooth.runs.strobe_times import strobes
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.system.system import System

__all__ = ["lyapunov_spectrum"]

_MOST_INTERVALS = 1e7  # of transient and record
_TRANSIENT, _RECORD = 200.0, 1000.0  # periods, or returns of a motion without one
_OF_RETURN = 32.0  # intervals of one, where the clock ticks so much faster than a motion returns
_PARTS = 256  # intervals of a record without a period, at least


def lyapunov_spectrum(
    system: System | StroboscopicMap,
    initial: Mapping[str, float] | xr.Dataset | None = None,
    *,
    transient: float | None = None,
    record: float | None = None,
    exponents: int | None = None,
    interval: float | None = None,
    confirm: int = 10_000,
    parameters: Mapping[str, float | str] | None = None,
    tolerance: float = 1e-12,
    mode: str | None = None,
    t_start: float | None = None,
    seed: int = 0,
) -> xr.Dataset:
    """Lyapunov exponents of a trajectory, with standard errors.

    Derivatives by the initial state are carried along the trajectory, through impacts,
    switches and slaved states, and orthonormalised again and again; their growth per unit
    time is the spectrum.

    Parameters
    ----------
    system : System or StroboscopicMap
        The system; or a map of it, whose iterates then take the place of periods below, and at
        whose phase a mapping of states begins. Exponents are per unit time all the same.
    initial : mapping, xarray.Dataset, optional
        Start, as for `simulate`: state names to values, a point of a result, or a run.

    Other Parameters
    ----------------
    transient : float, optional
        What is dropped first, in periods, 200 by default. In units of time for a system without a
        period; by default as long as its motion takes to come back 200 times, see notes.
        Derivatives are carried there too, so that they have found their directions; a direction
        that is lost there begins anew.
    record : float, optional
        Length over which exponents are averaged, in periods or units of time; 1000 periods or
        returns by default.
    exponents : int, optional
        How many exponents, from the largest on; as many as there are states by default.
    interval : float, optional
        Periods, or time, after which the growth is noted: the step of the running estimate,
        and of the block averages; one period by default. Derivatives are orthonormalised as
        often as they need it, whatever the interval.
    confirm : int, optional
        Periods for which a chaotic motion is run on behind the record, without derivatives, to see
        whether it was a transient; 0 for none. Where the system has no period it is run on for as
        many times as it takes to come back, on average. It goes on from a point beside its last
        one, by 1e-8 of its size. Where the equations do not repeat, as with ``signals``, or with t
        by itself, it is not run on.
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
        Time at the start, zero by default.
    seed : int, optional
        Seed of the random numbers: the same seed gives the same result. They are the directions
        with which the derivatives begin.

    Returns
    -------
    xarray.Dataset
        Over ``exponent``, numbered from one: ``lyapunov_exponent`` per unit time, the largest
        first, ``standard_error``; over ``time`` too: ``running_exponent``, the average from the end
        of the transient up to that time. ``exponent_sum`` and ``kaplan_yorke_dimension`` where all
        that they need is there. Attributes: ``status`` and ``message`` as for `simulate`,
        ``certified``, ``n_uncertain`` and ``n_estimated`` likewise, ``n_events`` and ``n_impacts``
        of the record (as in `bifurcation_diagram`) and its ``duration``, ``chaotic_for`` and
        ``escape_rate_below`` (periods of chaos without an end, and the bound that follows, see
        notes; 0 and nan where it is not chaotic), ``block_length`` (in intervals), ``n_blocks``,
        ``blocks_independent``, the system as TOML and the options; ``transient`` and ``record``
        are the lengths that were taken.

    Raises
    ------
    OptionError
        When the start fits no mode, or an option cannot be right.
    ModelError
        When the parameters are refused by the system.

    Warns
    -----
    RunWarning
        When the run ended early; the result holds what was computed until then.
    ResultWarning
        When the exponents are those of a transient, see notes.

    See Also
    --------
    zero_one_test : chaos or not from a series of numbers alone.

    Notes
    -----
    A forced system has as many exponents as states; that of time itself, zero, is not among
    them. A system without a period has a zero exponent along its motion, and one for each
    symmetry such as a drift, which forced systems may have too: on their periodic motions
    ``exponents=1`` gives that zero, so ask for one more. A direction that is lost at an event of
    the record has the exponent minus infinity exactly: a state becomes slaved, or a mass sticks.
    Strong contraction alone stays a number, however fast.

    A unit of time says nothing of a motion without a period: it may hold a millionth of a cycle,
    or a million of them. So the default lengths follow the motion. A first look at it, ever longer
    up to 64 windows or 20000 events, counts how often each state comes up through its mean, and
    takes the state that does so most seldom. Where none has come back by then, it goes on, up to
    262144 windows. A motion that does not come back there, rests, or ends, counts as if it
    oscillated as fast as the fastest natural motion. With inputs of ``signals`` the default lengths
    are 200 and 1000 units of time. Where no state comes back in a record, however its length was
    chosen, and the motion does not die out either, the attribute ``settled`` is 0, and a warning
    and the message say so.

    Where the equations do not repeat, exponents are those of this stretch of this motion: nothing
    tells what they are later.

    Standard errors come from the averages of 32 blocks of the record, or a few more, each a
    whole number of intervals, and are no smaller than what a cycle that the record cuts off leaves
    open; ``blocks_independent`` says whether neighbouring blocks are uncorrelated, below two over
    the root of their number. Where they are not, take a longer record. Standard errors do not see a
    transient that was too short. Two checks do. The largest exponents of both halves of the record
    are compared. And a motion with an exponent above zero is run on for ``confirm`` periods, at the
    end of which its exponents are taken again over half as many periods as ``record``. Where the
    halves differ, or the motion repeats, ends or has other exponents later, the attribute
    ``settled`` is 0, and a warning and the message say why. So it is where the run ended early.

    No finite run tells chaos from a longer transient. ``chaotic_for`` tells for how many periods
    the motion was chaotic without an end: up to the record behind ``confirm``, or without it up to
    the second half of the record. A transient whose motions leave it at the rate k per period lasts
    for N periods with the probability exp(-k N), so the rate is below ``escape_rate_below`` =
    -log(0.05)/N with 95 % confidence.

    Equal machines that begin in step stay in step, as rounding is the same for each of them. Where
    that is unstable, the largest exponent is that of differences which nothing brings about. So the
    motion is run on from a point beside it, and leaves what its neighbours leave: ``settled`` is 0
    then. Let such machines begin with a small difference.

    The Kaplan-Yorke dimension counts an exponent as zero that is below three standard errors
    or below one over the duration. For a forced system it is that of the stroboscopic map;
    the flow has one more.

    References
    ----------
    G. Benettin, L. Galgani, A. Giorgilli and J.-M. Strelcyn, Meccanica 15, 9-20 (1980);
    P. Mueller, Chaos, Solitons and Fractals 5, 1671-1681 (1995), for the events.

    Examples
    --------
    The sum of both exponents of an oscillator with damping ratio 0.01 is -0.02, also where it
    meets a soft stop.

    >>> import nonsmooth as ns
    >>> spectrum = ns.lyapunov_spectrum(ns.models.soft_impact(), transient=20, record=100)
    >>> float(spectrum["exponent_sum"].round(9))
    -0.02
    """
    strobe, system = _system_of(system)
    shared = SharedOptions(parameters, tolerance, mode, seed=seed)
    system = shared.system_of(system)
    if system.slow:
        raise OptionError(
            f"{system.name}: exponents belong to one set of parameters, and slow= varies"
            f" {next(iter(system.slow))!r}; make the system without slow="
        )
    count = _count(system, exponents)
    tables = build_tables(system)
    window = tables.window
    periodic = system.period_value is not None
    unit = 1.0 if periodic else window
    if strobe is not None:
        strobe = strobe.with_parameters(**parameters) if parameters else strobe
        periodic, unit = True, window / (strobe.every * (strobe.length or window))
    start = _start(system, tables, strobe, initial, t_start, shared)
    more = whole("confirm", confirm, 0)
    length = strobe.length if strobe is not None else None
    tick = one = 1.0
    if not (periodic or system.signals) and (transient is None or record is None or more):
        length = one = return_time(system, tables, start, tolerance)
        if transient is None or record is None:
            tick = max(1.0, one / window / _OF_RETURN)
    transient = _TRANSIENT * one if transient is None else transient
    record = _RECORD * one if record is None else record
    protocol = _protocol(transient, record, interval, unit, periodic, tick)
    first = start.instant.time(window)
    check_signals(system, first, first + (protocol.transient + protocol.record) * window)
    derivatives, number = build_derivatives(system, tables, ()), check_seed(shared.seed)

    def run_from(begin: Start, how: ExponentProtocol) -> ExponentRun:
        return run_exponents(system, tables, derivatives, begin, how, count, tolerance, number)

    run = run_from(start, protocol)
    options: dict[str, Any] = {
        "transient": protocol.transient * unit,
        "record": protocol.record * unit,
        "interval": protocol.interval * unit,
        "confirm": more,
        "tolerance": float(tolerance),
        "seed": number,
        "changed_parameters": shared.changes,
        **({} if strobe is None else strobe.protocol),
    }
    look_on = partial(
        find_horizon, system, run, protocol, run_from, length=length, window=window,
        tolerance=tolerance,
    )  # fmt: skip
    try:
        horizon = look_on(confirm=0 if system.unrepeated else more)
    except KeyboardInterrupt:  # the record is there, and tells what it tells without `confirm`
        horizon, run = look_on(confirm=0), replace(run, status=Status.INTERRUPTED)
    counts = _counts(strobe, periodic)
    result = exponent_dataset(system, run, horizon, unit, counts, options)
    if run.status not in (Status.COMPLETED, Status.STOPPED):
        warnings.warn(f"{system.name}: {result.attrs['message']}", RunWarning, stacklevel=2)
    if horizon.unsettled:
        warnings.warn(f"{system.name}: {horizon.unsettled}", ResultWarning, stacklevel=2)
    return result


def _counts(strobe: StroboscopicMap | None, periodic: bool) -> str:
    """What transient and record are counted in."""
    if strobe is not None and (strobe.period is not None or strobe.every > 1):
        return "iterate"
    return "period" if periodic else "unit"


def _system_of(given: Any) -> tuple[StroboscopicMap | None, Any]:
    """The strobe map that was given, if it was one, and the system."""
    if isinstance(given, PoincareMap):
        raise OptionError(
            "lyapunov_spectrum: exponents are those of the motion between points; give the system"
            " of the map. Per iterate they are larger by the mean time between points, and the"
            " zero along the motion is none of the map"
        )
    return (given, given.system) if isinstance(given, StroboscopicMap) else (None, given)


def _start(
    system: System,
    tables: Tables,
    strobe: StroboscopicMap | None,
    initial: Any,
    t_start: float | None,
    shared: SharedOptions,
) -> Start:
    """Where derivatives begin: at a state, and without a time of its own at the phase of a map."""
    repeated = shared.parameters is not None
    start = start_at_end(resolve_start(system, tables, initial, t_start, shared.mode, repeated))
    if strobe is None or t_start is not None or hasattr(initial, "data_vars"):
        return start
    number, phase = strobes(tables.window, Instant(0, 0.0), strobe.length, strobe.phase, 0, 1)
    return replace(start, instant=Instant(int(number[0]), float(phase[0])))


def _count(system: System, exponents: Any) -> int:
    n = len(system.states)
    count = n if exponents is None else whole("exponents", exponents)
    if count > n:
        raise OptionError(
            f"exponents = {count}: {system.name!r} has {n} states, and as many exponents at most"
        )
    return count


def _protocol(
    transient: Any, record: Any, interval: Any, unit: float, periodic: bool, tick: float
) -> ExponentProtocol:
    """Lengths in windows, the interval such that the record has a whole number of them.

    ``unit``: how much of what lengths are counted in makes a window; ``periodic``: whether that is
    periods, one of which is an interval; ``tick``: windows that make one of a long record without.
    """
    lengths = {"transient": transient, "record": record}
    for name, value in lengths.items():
        if finite_number(name, value) < 0.0 or (name == "record" and value == 0):
            least = "must be positive" if name == "record" else "must not be negative"
            raise OptionError(f"{name} = {value} {least}; it counts periods, or time without one")
    whole_record = float(record) / unit
    if interval is None:
        wanted = 1.0 / unit if periodic else min(tick, whole_record / _PARTS)
    else:
        wanted = finite_number("interval", interval) / unit
        if not wanted > 0.0:
            raise OptionError(f"interval = {interval} must be positive")
    first = float(transient) / unit
    if first + whole_record > _MOST_INTERVALS * min(wanted, whole_record):
        name, value = ("record", record) if interval is None else ("interval", interval)
        raise OptionError(
            f"{name} = {value} is too short beside transient = {transient} and record = {record}:"
            f" they would make more than {_MOST_INTERVALS:g} intervals; give a longer interval="
            " and record="
        )
    parts = max(1, round(whole_record / wanted))
    return ExponentProtocol(first, whole_record, whole_record / parts, parts)
