"""`fit`: parameters of a system, with intervals, from a measured record."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.stats import qmc

from nonsmooth.analysis.options import SharedOptions, check_seed
from nonsmooth.errors import ModelError, OptionError, RunError, is_known
from nonsmooth.fitting.beginning import sizes_of_states
from nonsmooth.fitting.channels import (
    ObservedChannel,
    Range,
    check_free,
    check_record_times,
    read_channels,
)
from nonsmooth.fitting.report import Search, fit_dataset
from nonsmooth.fitting.shooting import Shooting
from nonsmooth.fitting.solver import LOSSES, Fitted, height, solve_from
from nonsmooth.real_numbers import finite_real
from nonsmooth.runs.options import whole_number
from nonsmooth.runs.start import resolve_start
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["fit"]

Floats = npt.NDArray[np.float64]

_PER_SEGMENT = 50  # samples, without a period
_PARTS = 4  # of a segment, with which the search begins
_MOST_UNKNOWNS = 480  # of all parts: a step of the solver decomposes a matrix of that size
_FORMS = ("transient", "steady")
_SAME = 1e-12  # of a period: a difference that is rounding


class _Cut(NamedTuple):
    """Which part of a record is fitted, and into what it is cut."""

    held_back: float  # part at the end
    segments: Any  # number of segments as the caller gave it
    cycle: float | None  # after which a steady motion repeats itself


def fit(
    system: System,
    record: xr.Dataset,
    free: Mapping[str, tuple[float, float]],
    observe: Mapping[str, str] | None = None,
    *,
    initial: Mapping[str, float] | None = None,
    gain: Any = None,
    offset: Any = None,
    delay: Any = None,
    noise: Any = None,
    form: str = "transient",
    cycle: int = 1,
    segments: int | None = None,
    hold_back: float = 0.1,
    starts: int = 4,
    loss: str = "linear",
    bootstrap: int = 0,
    parameters: Mapping[str, float | str] | None = None,
    tolerance: float = 1e-12,
    seed: int = 0,
) -> xr.Dataset:
    r"""Fit parameters of a system to a record, and say how well the record determines them.

    The record may be long, and the motion may be transient, periodic or chaotic. It is cut into
    segments whose initial states are found together with the parameters, under the condition that
    each segment ends where the next one begins. All derivatives of motions, also through impacts
    and switches, are those of the engine.

    Parameters
    ----------
    system : System
        The system. Parameters that are not named in ``free`` keep their values.
    record : xarray.Dataset
        Channels over ``time``, from `measured.read_csv` or made by hand. Samples that are nan, and
        those that `measured.flagged` has marked, are left out. Times are those of the system: the
        forcing has the phase that its equations say.
    free : mapping of str to (float, float)
        Parameters to find, each with its least and largest value.
    observe : mapping of str to str, optional
        What each channel shows: an expression of states, outputs, parameters and rates such as
        ``"rate(v)"``. Without it, the channels that are called like a state or an output.

    Other Parameters
    ----------------
    initial : mapping of str to float, optional
        Guess of the state at the first sample; the rest state by default. The state is found too.
    gain, offset, delay : float, (float, float), "free" or mapping, optional
        How a channel shows its quantity: ``gain * quantity(t - delay) + offset``. A number is
        fixed, a pair bounds what is found, and ``"free"`` has no bounds; a delay that is found
        needs bounds. A mapping says it by channel. Without them 1, 0 and 0.
    noise : float, (float, float), "free" or mapping, optional
        Standard deviation of the noise of a channel, likewise; found by default.
    form : {"transient", "steady"}, optional
        What the record shows. ``"transient"`` takes any motion. ``"steady"`` takes a motion that
        repeats itself in the whole record, and fits a periodic orbit to all its periods at once;
        only one cycle is run, however long the record is.
    cycle : int, optional
        Number of periods of the forcing after which a steady motion repeats itself.
    segments : int, optional
        Number of segments; one per period by default, or per 50 samples without a period, and at
        first each of these is cut into up to four parts.
    hold_back : float, optional
        Part of the record, at its end, that is not fitted but predicted.
    starts : int, optional
        Number of starts, in the middle of the bounds and spread over them.
    loss : {"linear", "soft_l1", "huber", "cauchy", "arctan"}, optional
        Loss of a residual; all but the first one give outliers less weight.
    bootstrap : int, optional
        Number of records with residuals drawn anew in blocks, for intervals that hold where
        residuals are correlated too. 0 makes none; 200 is usual.
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.
    seed : int, optional
        Seed of the random numbers: the same seed gives the same result.

    Returns
    -------
    xarray.Dataset
        Over ``parameter``, the free parameters and what is found of gain, offset and delay, such
        as ``"a1 gain"``: ``estimate``, ``standard_error``, ``interval_low`` and
        ``interval_high`` (95 %, from the profile of the likelihood), ``interval_open`` where a
        bound cuts an interval off, ``profile_followed``, false where an end is that of the
        standard error since the profile could not be followed, ``variance_ratio`` to what white
        residuals would give, ``identified``, ``lower_bound`` and ``upper_bound``;
        ``covariance`` and ``correlation`` (also over ``parameter_0``); with ``bootstrap``,
        ``bootstrap_low`` and ``bootstrap_high``. Over ``channel``: ``noise``,
        ``prediction_error`` (root mean square of what was held back, in units of the noise),
        ``ljung_box`` and ``whiteness`` (its probability for white residuals). Over ``channel``
        and ``time``: ``measured``, ``fitted``, ``residual``; ``held_back`` over ``time``. Over
        ``segment``: ``segment_time``, ``segment_state``. Over ``start``: ``start_estimate``,
        ``start_cost``, ``start_agrees``. Over ``direction``, combinations of parameters that
        are not determined: ``direction_part``, ``direction_spread``. Attributes: ``status``
        (completed, not_converged), ``message``, ``open_parameters`` and ``interval_method`` in
        words, ``largest_gap``
        between segments in parts of the states, ``n_evaluations``; for a steady motion
        ``largest_multiplier``, above 1 where the fitted orbit is unstable.

    Raises
    ------
    OptionError
        When a name is unknown, bounds are not in order, or an expression cannot be read.
    RunError
        When no motion can be computed from any start.

    See Also
    --------
    simulate : the motion of the fitted system.
    plot.fit : measured beside fitted.

    Notes
    -----
    Maximum likelihood for noise that is normal and white. The solver is
    ``scipy.optimize.least_squares`` with bounds; the method of multipliers makes the segments
    continuous. An interval ends where twice the logarithm of the likelihood, with everything else
    found anew, has fallen by the quantile of an F distribution.

    Where the test of Ljung and Box speaks against white residuals, each channel is described by an
    autoregression, whose innovations may be correlated from channel to channel. The covariance of
    the estimates is then a sandwich, and the profile falls by the quantile times the ratio of the
    variances. That counts in coloured noise. It does not count in that a wrong model shifts
    estimates, which no single record shows.

    References
    ----------
    H. G. Bock, Recent advances in parameter identification techniques for O.D.E., 1983: multiple
    shooting. D. P. Bertsekas, Constrained Optimization and Lagrange Multiplier Methods, 1982.
    W. J. den Haan and A. Levin, A practitioner's guide to robust covariance matrix estimation,
    Handbook of Statistics 15, 299-342 (1997): autoregressions. R. E. Chandler and S. Bate,
    Inference for clustered data using the independence loglikelihood, Biometrika 94, 167-183
    (2007): the profile. E. Carlstein, The use of subseries values for estimating the variance of a
    general statistic from a stationary sequence, Annals of Statistics 14, 1171-1179 (1986): the
    length of blocks.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.linspace(0, 20, 400)
    >>> noise = 0.01 * np.random.default_rng(1).standard_normal(t.size)
    >>> x = 0.5 * np.exp(-0.1 * t) * np.cos(2 * t) + noise
    >>> record = ns.measured.from_arrays({"x": x}, times=t)
    >>> spring = ns.System(
    ...     states=["x", "v"],
    ...     parameters={"k": 3.0, "c": 0.1},
    ...     equations={"x": "v", "v": "-k*x - c*v"},
    ... )
    >>> found = ns.fit(spring, record, {"k": (1, 9), "c": (0, 1)}, {"x": "x"})
    >>> found["estimate"].values.round(2)
    array([4.01, 0.2 ])
    """
    options = SharedOptions(parameters=parameters, tolerance=tolerance)
    system = options.system_of(system)
    bounds = check_free(system, free)
    times = check_record_times(record)
    channels = read_channels(
        system, record, observe, {"gain": gain, "offset": offset, "delay": delay}, noise
    )
    if not is_known(loss, LOSSES):
        raise OptionError(f"loss = {loss!r:.60}: give one of {', '.join(LOSSES)}")
    share = finite_real("hold_back", hold_back)
    if not 0.0 <= share <= 0.9:
        raise OptionError(f"hold_back = {share:g} must lie between 0 and 0.9")
    count, drawn = whole_number("starts", starts), whole_number("bootstrap", bootstrap, 0)
    chosen = check_seed(seed)
    cut = _Cut(share, segments, _cycle_length(system, bounds, form, cycle))
    make = partial(_shooting, system, bounds, channels, times, cut, tolerance)
    found = _search(make, _rest(system, initial), loss, count, chosen)
    told = options.recorded | {
        "free": str({name: (each.low, each.high) for name, each in bounds.items()}),
        "observe": str({channel.name: channel.text for channel in channels}),
        "form": form, "cycle": cycle, "hold_back": share, "loss": loss,
        "starts": count, "bootstrap": drawn, "seed": chosen,
    }  # fmt: skip
    return fit_dataset(channels, times, found, told, loss, drawn, chosen)


def _rest(system: System, initial: Any) -> Floats:
    """Guess of the first state."""
    from nonsmooth.runs.runner import build_tables

    start: Floats = resolve_start(system, build_tables(system), initial).state
    return np.where(np.isfinite(start), start, 0.0)


def _shooting(
    system: System,
    free: Mapping[str, Range],
    channels: list[ObservedChannel],
    times: Floats,
    cut: _Cut,
    tolerance: float,
) -> Shooting:
    """The equations of the part of the record that is fitted, cut into segments."""
    last = times[0] + (1.0 - cut.held_back) * (times[-1] - times[0])
    kept = times <= last
    fitted = [c._replace(values=np.where(kept, c.values, np.nan)) for c in channels]
    for channel in fitted:
        count = int(np.count_nonzero(np.isfinite(channel.values)))
        if count < len(system.states) + len(free) + 2:
            raise OptionError(
                f"record[{channel.name!r}]: {count} samples are fitted, too few for {len(free)}"
                f" parameters and {len(system.states)} states; give a longer record, or a smaller"
                " hold_back="
            )
    used = times[kept]
    begin = used[0] - max(channel.delay.high for channel in channels)
    end = used[-1] - min(channel.delay.low for channel in channels)
    if cut.cycle is not None:
        if end - begin < cut.cycle:
            raise OptionError(
                f"form = 'steady': what is fitted lasts {end - begin:.6g}, less than one cycle of"
                f" {cut.cycle:.6g}; give a longer record, or a smaller hold_back="
            )
        end = begin + cut.cycle
    together = 1
    if cut.segments is None:
        period = _period(system, free)
        number = used.size / _PER_SEGMENT if period is None else (end - begin) / period
        most = used.size // (4 * (len(system.states) + 1))
        number = int(np.clip(round(number), 1, max(1, most)))
        together = _parts(number, used.size * len(channels), len(system.states))
    else:
        number = whole_number("segments", cut.segments)
        if number > used.size // 2:
            raise OptionError(
                f"segments = {number}: at most {used.size // 2}, half the samples that are fitted"
            )
    return Shooting(
        system, free, fitted, times, np.linspace(begin, end, number * together + 1), tolerance,
        is_cycle=cut.cycle is not None, together=together,
    )  # fmt: skip


def _parts(number: int, n_data: int, n_states: int) -> int:
    """Into how many parts each of some segments is cut at first, where the data allow it."""
    most = min(_MOST_UNKNOWNS // n_states, n_data // (2 * (n_states + 1)))
    return int(np.clip(most // number, 1, _PARTS))


def _cycle_length(system: System, free: Mapping[str, Range], form: Any, cycle: Any) -> float | None:
    """Time after which a steady motion repeats itself; None for a transient one."""
    if not is_known(form, _FORMS):
        raise OptionError(f"form = {form!r:.60}: give one of {', '.join(_FORMS)}")
    number = whole_number("cycle", cycle)
    if form == "transient":
        if number != 1:
            raise OptionError(f"cycle = {number}: only form='steady' takes it")
        return None
    if system.drift:
        raise OptionError(
            f"form = 'steady': {', '.join(system.drift)} may drift, so the motion need not come"
            " back after a cycle; give form='transient'"
        )
    period = _period(system, free)
    if period is None:
        raise OptionError(
            f"form = 'steady': {system.name} has no period, so nothing says after which time the"
            " motion repeats itself; give form='transient'"
        )
    for name, each in free.items():
        for value in (each.low, each.high):
            other = _period(system, {**free, name: Range(value, value, value)})
            if other is None or abs(other - period) > _SAME * period:
                raise OptionError(
                    f"form = 'steady': the period depends on {name!r}, which is in free=, so it is"
                    " not known where the motion repeats itself; give form='transient'"
                )
    return number * period


def _period(system: System, free: Mapping[str, Range]) -> float | None:
    """Period in the middle of the bounds, or where the system refuses that, its own."""
    middle = {name: each.guess for name, each in free.items()}
    try:
        return system.with_parameters(**middle).period_value
    except ModelError:
        return system.period_value


def _search(
    make: Callable[[], Shooting], initial: Floats, loss: str, count: int, seed: int
) -> Search:
    """The best minimum of several starts."""
    shootings = [make() for _ in range(count)]
    first = shootings[0]
    guesses = np.tile(first.guess(), (count, 1))
    if count > 1:
        sampler = qmc.LatinHypercube(first.p, rng=np.random.default_rng(seed))
        low = np.array([each.low for each in first.free.values()])
        width = np.array([each.scale for each in first.free.values()])
        guesses[1:, : first.p] = low + width * sampler.random(count - 1)
    noise = np.array([channel.noise.guess for channel in first.channels])
    found: list[Fitted | None] = []
    for k, (shooting, guess) in enumerate(zip(shootings, guesses, strict=True)):
        if shooting.set_up(shooting.head_of(guess)):
            shooting.scales = sizes_of_states(shooting, initial)
            best = min((height(each) for each in found if each is not None), default=np.inf)
            found.append(solve_from(shooting, guess, initial, noise, loss, seed + k, best))
        else:
            found.append(None)
    if all(each is None for each in found):
        raise RunError(
            f"{first.system.name}: no motion could be computed from any of {count} starts; give"
            " initial= a state that one of the modes admits, narrower bounds in free=, or more"
            " starts="
        )
    return Search(found, shootings)
