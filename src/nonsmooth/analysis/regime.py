"""`regime`: what a motion settles to, with the evidence for it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.options import SharedOptions, result_attributes
from nonsmooth.analysis.regimes.labels import CHAOTIC, INADMISSIBLE, Verdict
from nonsmooth.analysis.regimes.options import RegimeProtocol, check_system, make_protocol
from nonsmooth.analysis.regimes.regime_dataset import numbers_of
from nonsmooth.analysis.regimes.regime_run import first_windows, settled_regimes
from nonsmooth.analysis.settle import ParameterSets, said_of_start, settle
from nonsmooth.analysis.statistics.escape import said_of_chaos
from nonsmooth.errors import OptionError
from nonsmooth.runs.crew import run_tasks
from nonsmooth.runs.first_mode import explain_misfit
from nonsmooth.runs.labels import with_doubts
from nonsmooth.runs.runner import build_tables
from nonsmooth.runs.start import resolve_start, start_at_end
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.runs.sweep_runner import SweepRunner
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["regime"]


def regime(
    system: System,
    initial: Any = None,
    *,
    transient: int = 200,
    record: int = 100,
    evidence: int = 500,
    longest: int | None = None,
    confirm: int = 10_000,
    phase: float = 0.0,
    period: float | str | None = None,
    match: float = 1e-6,
    parameters: Mapping[str, float] | None = None,
    tolerance: float = 1e-12,
    mode: str | None = None,
    t_start: float | None = None,
) -> xr.Dataset:
    """Tell what a motion settles to, and on what evidence.

    Parameters
    ----------
    system : System
        The system; it needs a period, or ``period``.
    initial : mapping, dataset or run, optional
        Initial state as in `simulate`; the rest state without it.
    transient : int, optional
        Periods left out at the beginning; more where the motion has not settled by then.

    Other Parameters
    ----------------
    record : int, optional
        Periods of a window in which strobes may repeat; half of it is the longest period that is
        found.
    evidence : int, optional
        Periods of a window for exponent and 0-1 test of a motion that does not repeat. Below 200
        the result is a survey: exponents alone decide, and ``K`` is nan; 20 at least.
    longest : int, optional
        Largest transient: it is doubled until there, at least, while the motion has not settled;
        16 times the transient (or the record, if that is longer) without it.
    confirm : int, optional
        Periods for which a chaotic motion is run on, as chaos may be a long transient, and a
        quasi-periodic one, as it may settle slowly; 0 to trust the windows. Without forcing, a
        motion that neighbours approach by a steady rate is ``unsettled`` then.
    phase : float, optional
        Part of the period at which strobes are taken, from 0 to less than 1.
    period : float or str, optional
        Another time between strobes than the period of the system, as in `stroboscopic_map`: for
        systems with several frequencies or none.
    match : float, optional
        Strobes repeat when they do to this part of the size of each state. One that is small at the
        strobes counts beside ``match`` of its natural size: the largest since the start, or the
        change that a part of an interval makes of the sizes of all states. So rounding of a state
        at rest is no motion.
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
        Scalars: ``regime``, ``period`` (in strobes, 0 where none was found), ``word`` (modes of one
        period), ``events`` and ``impacts`` (as in `bifurcation_diagram`) per strobe interval,
        ``residual`` (what is left between strobes a period apart, as a part of the size of the
        states; the least where there is no period), ``exponent`` with ``exponent_error``, ``K``,
        ``transient_used`` (in strobes), ``chaotic_for`` and ``escape_rate_below`` (periods of chaos
        without an end, and the bound that follows, see notes; 0 and nan of other motions),
        ``n_uncertain``, ``n_estimated``, and for every drifting state and angle its change per
        period and per unit time, as in ``v_per_period``. Over ``multiplier``:
        ``multiplier_real``, ``multiplier_imag`` and ``multiplier_modulus`` of a motion that
        repeats, the largest first. nan is what was not needed for the label. The attribute
        ``message`` tells the reason for the label.

    Raises
    ------
    OptionError
        When the start fits no mode, for an option out of its range, or a system that has no period
        and gets none.

    See Also
    --------
    regime_map : the same over two parameters.
    bifurcation_diagram : states over one parameter.
    lyapunov_spectrum : all exponents.

    Notes
    -----
    Two windows follow the transient, and a label holds when both give it, with the same period and
    word, or with exponents that agree within three standard errors. If they do not, the transient
    is doubled. The labels and their rules:

    ``periodic``
        Strobes repeat, but for drifts and whole turns of angles, and all multipliers lie inside
        the unit circle. A motion that travels steadily, in which drifts alone change, has the
        period one, and the message says so.
    ``locked``
        So they do, and every perturbation is lost within one period, by rank, as where a mass
        rests for a while. The exponent is minus infinity. Where two windows of ``evidence`` lose
        every perturbation and strobes do not repeat, the period is longer than half of ``record``.
    ``equilibrium``
        Nothing changes, between strobes either, and all multipliers lie inside the unit circle.
        Where nothing drives the system, this is told of the last of a decay, too: all states, at
        strobes, between them and at events, keep within ``match`` of their natural sizes; by the
        derivatives over an interval no more than that is left of the way; and strobes come nearer
        as neighbours do. On a surface, where states pass from
        mode to mode for ever, their spread must halve from window to window instead. A motion that
        has died away to ``match`` times ``match`` of its sizes is at rest in any system. Drifts
        are at rest too: a strobe interval adds no more than ``match`` of their way since the start.
    ``chaotic``
        Strobes do not repeat, the largest exponent is more than three standard errors above zero,
        and K of the 0-1 test is not below 0.2. The spread of no state grows tenfold from window
        to window, beyond all that was seen before, as in a motion that runs away. The motion is
        then run on for ``confirm`` periods, and looked at again. Where it has settled or ended, the
        label is that of what it came to; where it is on its way, it is looked at up to four times
        more, ever later. No finite run tells chaos from a longer transient, so
        ``chaotic_for`` counts the periods from the first window with an exponent above zero to the
        last one. A transient whose motions leave it at the rate k per period lasts as long with the
        probability exp(-k N), so the rate is below ``escape_rate_below`` = -log(0.05)/N with 95 %
        confidence.
        Equal machines that begin in step stay in step, as rounding is the same for each, also where
        that is unstable. So a motion that does not repeat and whose neighbours part goes on from
        a point beside it, by 1e-8 of its size, before each further look: the label is that of
        what machines come to that are not quite equal.
    ``quasi-periodic``
        The motion is driven, and the strobes of both windows keep the order of a rotation on a
        closed curve, or on several in turn: the polygon through them in that order turns by at
        most 0.1 radians at a strobe on average, and has no gap of more than ten mean steps. An
        exponent is not needed then; it must not be above 3 over the duration of a window in both.
        Or strobes do not repeat, the exponent is within three standard errors of zero and less than
        3 over the duration of a window in size, K is not above 0.5, and strobes do not nearly
        repeat, as those of motions that settle slowly do. Where neighbours part linearly, the
        exponent may fall by a quarter from window to window instead. Where strobes see the forcing
        at different phases, as with two frequencies, it may also be below zero.
        A motion that is driven is run on for ``confirm`` periods, as one that is chaotic, for two
        windows do not tell a slow decay from none. It must lie on the same curve then, or spread
        as far; where it does not, it is followed for as many periods once more. Where nothing
        drives the system, no state leaves the range of the windows before, and the states do not
        all shrink as below. The motion is run on as well: about a cycle to which it settles slowly
        it fills a tube, which is a torus that becomes thinner. It must be as thick then as before,
        to a fifth. Where neighbours approach it by one steady rate, that of an area along the
        motion and across it, the tube of such a decay would have to be seen to be thinner by then.
        States that lie along one closed curve, which neighbours neither come nearer to nor leave,
        have one frequency and no torus: they are ``unsettled``. The message tells the exponents of
        both windows.
    ``limit-cycle``
        Nothing drives the system, strobes do not repeat as the motion has a period of its own, and
        neighbours approach it: the exponent across it is below zero, or no perturbation across it
        outlives its events. Or states lie along a curve, and the exponent is below zero by a steady
        rate that windows alone do not tell from none. Strobes do not draw together as neighbours
        do, as where a clock turns once between them. There are two states at least beside drifts,
        or one that is an angle, or that events turn back. And the motion comes back to where it
        was, looked at once more within each strobe interval, over two windows of ``evidence``
        intervals: the values of each state, sorted, differ in the mean by no more than 5 % of its
        spread, and nine in ten of the later states lie within 5 % of an earlier one. Nor do the
        spreads of all states halve, or fall while the values differ by more. So motions that come
        to rest slowly, grow or travel are ``unsettled``, and so are cycles that are long beside a
        window; a longer ``period`` helps.
    ``absorbed``
        Impacts accumulate and no exit sticks, or an exit to 'stop' ends the run. However chaotic
        the motion was before, it has no exponent. Where no exit has a reset, what accumulates are
        switches, and the word is ``event_limit``.
    ``diverged`` and other words of `simulate`
        The run ended early in that way.
    ``unsettled``
        The windows disagree up to ``longest``, or the rules do. A motion that repeats with
        multipliers on the unit circle, as without damping, is none that others settle to. The
        message tells what decided.

    No window tells an exponent better than to one over its duration, so a standard error counts
    that much at least. K is that of the first state that does not contradict the label, or of the
    last one, after the strongest period up to 50 is taken off, as chaos in bands would need very
    long series otherwise. Exponents are per unit time. Left out are those of drifts, and along the
    motion of a system that nothing drives; likewise multipliers, which are one for a drift.
    Exponents of motions that repeat are those of their multipliers, without an error. Where
    nothing is left, as for one state that nothing drives, there is no exponent: nan.

    References
    ----------
    G. A. Gottwald and I. Melbourne, On the implementation of the 0-1 test for chaos, SIAM
    Journal on Applied Dynamical Systems 8, 129-145 (2009).

    Examples
    --------
    >>> import nonsmooth as ns
    >>> found = ns.regime(ns.models.soft_impact())
    >>> found["regime"].item(), found["period"].item(), found["events"].item()
    ('periodic', 5, 1.2)

    The product of the multipliers is what the damping leaves, exp(-2 zeta 5 T).

    >>> float(found["multiplier_modulus"].prod().round(4))
    0.4775
    """
    shared = SharedOptions(parameters, tolerance, mode)
    system = shared.system_of(system)
    check_system(system, period, "regime")
    protocol = make_protocol(transient, record, evidence, longest, confirm, phase, match)
    chosen = StroboscopicMap(system, phase=protocol.phase, period=period)
    tables = build_tables(system)
    start = resolve_start(system, tables, initial, t_start, mode, parameters is not None)
    start = start_at_end(start)
    runner = SweepRunner(system, tolerance)
    found: list[Verdict] = []
    task = partial(
        settle,
        sets=ParameterSets(chosen, {}, start, mode),
        times=partial(first_windows, protocol),
        reduce=partial(settled_regimes, protocol),
    )
    if not run_tasks(
        [task],
        lambda: runner,
        threads=1,
        label="regime",
        keep=lambda _, done: found.extend(done[0]),
    ):
        raise KeyboardInterrupt
    (verdict,) = found
    if verdict.label == INADMISSIBLE and verdict.transient_used == 0:
        raise OptionError(explain_misfit(system, tables, start, runner.segment.z))
    options = {**shared.recorded, "initial": said_of_start(initial)}
    return _dataset(system, protocol, verdict, options)


def _dataset(
    system: System, protocol: RegimeProtocol, verdict: Verdict, options: dict[str, Any]
) -> xr.Dataset:
    import xarray as xr

    variables: dict[str, Any] = {
        "regime": ((), verdict.label, {"long_name": "regime"}),
        **numbers_of(system, [verdict], (), ()),
    }
    multipliers = np.full(len(system.states) - len(system.drift_states), np.nan, complex)
    multipliers[: verdict.multipliers.size] = verdict.multipliers
    parts = {"real": multipliers.real, "imag": multipliers.imag, "modulus": np.abs(multipliers)}
    for name, values in parts.items():
        variables[f"multiplier_{name}"] = (
            ("multiplier",), values.copy(), {"long_name": f"multiplier, {name}"},
        )  # fmt: skip
    coords = {"multiplier": ("multiplier", np.arange(1, multipliers.size + 1))}
    reason = verdict.reason
    if verdict.label == CHAOTIC:
        reason += f"; {said_of_chaos(verdict.chaotic_for, 'period')}"
    message = with_doubts(f"{verdict.label}: {reason}", verdict.uncertain, verdict.estimated)
    told = {
        "certified": int(verdict.uncertain == verdict.estimated == 0),
        "transient": protocol.transient,
        "record": protocol.record,
        "evidence": protocol.evidence,
        "longest": protocol.longest,
        "confirm": protocol.confirm,
        "phase_of_period": protocol.phase,
        "strobe_period": verdict.length,
        "match": protocol.match,
        **options,
    }
    return xr.Dataset(variables, coords, result_attributes(system, "completed", message, told))
