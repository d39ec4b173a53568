"""`fit`: parameters of a system, with intervals, from measured records."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from scipy.stats import qmc

from nonsmooth.analysis.options import SharedOptions, check_seed, refuse_fixed
from nonsmooth.errors import OptionError, ResultWarning, RunError, is_known, quote, unknown_name
from nonsmooth.fitting.channels import (
    Range,
    check_allowed,
    check_free,
    check_record_times,
    read_channels,
    read_shift,
)
from nonsmooth.fitting.clock_trial import explaining_shift, said_of_shift
from nonsmooth.fitting.course import Course
from nonsmooth.fitting.cuts import Cut, GivenRecord, cut_for, equations_of
from nonsmooth.fitting.gain_trial import (
    LITTLE,
    explaining_gains,
    explains,
    height_of_explaining,
    said_of_gains,
)
from nonsmooth.fitting.report import Search, fit_dataset
from nonsmooth.fitting.shooting import Shooting
from nonsmooth.fitting.solver import LOSSES, Fitted, height, prepare, solve_from
from nonsmooth.fitting.time_scales import said_of_times
from nonsmooth.fitting.units import with_units
from nonsmooth.progress import Progress
from nonsmooth.real_numbers import finite_real
from nonsmooth.runs.options import whole_number
from nonsmooth.runs.start import resolve_start
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["fit"]

Floats = npt.NDArray[np.float64]

_HALF = 0.5  # noise beside a record of doubtful times: starts that leave more are given up
_TRIALS = 6  # of gains and phases of the forcing, at most


def fit(
    system: System,
    record: xr.Dataset | Mapping[str, xr.Dataset],
    free: Mapping[str, tuple[float, float]],
    observe: Mapping[str, str] | None = None,
    *,
    initial: Mapping[str, float] | None = None,
    gain: Any = None,
    offset: Any = None,
    delay: Any = None,
    noise: Any = None,
    shift: Any = None,
    private: Sequence[str] = (),
    by_record: Mapping[str, Mapping[str, float]] | None = None,
    form: str | None = None,
    cycle: int | None = None,
    segments: int | None = None,
    hold_back: float = 0.1,
    starts: int = 4,
    loss: str = "linear",
    bootstrap: int = 0,
    parameters: Mapping[str, float | str] | None = None,
    tolerance: float = 1e-12,
    seed: int = 0,
) -> xr.Dataset:
    r"""Fit parameters of a system to records, and say how well these determine them.

    A record may be long, and the motion may be transient, periodic or chaotic. It is cut into
    segments whose initial states are found together with the parameters, under the condition that
    each segment ends where the next one begins. All derivatives of motions and of instants of
    events, also through impacts and switches, are those of the engine.

    Parameters
    ----------
    system : System
        The system. Parameters that are not named in ``free`` keep their values.
    record : xarray.Dataset or mapping of str to xarray.Dataset
        Channels over ``time``, from `measured.read_csv` or made by hand. Samples that are nan, and
        those that `measured.flagged` has marked, are left out. Times are those of the system: the
        forcing has the phase that its equations say, or ``shift`` later. A channel over a
        dimension of its own has the instants of events, such as impacts picked from an
        accelerometer, within the times of the samples. Several records are given by their names.
        Nothing is converted: where a channel is in other units than the state or output that it
        shows, and no gain turns one into the other, the ``message`` says so.
    free : mapping of str to (float, float)
        Parameters to find, each with its least and largest value. The search begins in the middle
        and, with ``starts``, elsewhere between them; a value in ``parameters`` would count for
        nothing, and is refused.
    observe : mapping of str to str, optional
        What each channel shows: an expression of states, outputs, parameters and rates such as
        ``"rate(v)"``; for instants the name of an event, which is that of an exit or of the mode
        it enters. Without it, the channels that are called like a state, an output or an event.

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
    shift : float or (float, float), optional
        Time of the system at time zero of the record, or its bounds, where it is not known with
        which phase of the forcing the record begins; 0 by default.
    private : sequence of str, optional
        Parameters, ``shift``, or entries such as ``"a1 gain"`` that are found for each of several
        records by itself; they are named ``"RECORD a1 gain"``. All others are shared.
    by_record : mapping of str to mapping of str to float, optional
        Values of parameters that are known and differ from record to record, such as the speed, by
        the name of the record.
    form : {"transient", "steady"}, optional
        What a record shows. ``"transient"`` takes any motion. ``"steady"`` takes a motion that
        repeats itself in the whole record, and fits a periodic orbit to all its periods at once;
        only one cycle is run, however long the record is. By default it is steady where two tests
        say so: the halves of the record have the same Fourier series, and leave white residuals.
    cycle : int, optional
        Number of periods of the forcing after which a steady motion repeats itself; by default the
        smallest one that passes the tests.
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
        ``bootstrap_low``, ``bootstrap_high`` and ``bootstrap_estimate`` (also over ``draw``);
        ``profile_value`` and ``profile_rise`` (also over ``profile_point``), points of the
        profiles, whose intervals end where the rise is the attribute ``profile_threshold``. Over
        ``channel``: ``noise``, ``time_error`` (standard deviation of the times of the samples,
        where residuals speak of one),
        ``prediction_error`` (root mean square of what was held back, in units of the noise),
        ``ljung_box`` and ``whiteness`` (its probability for white residuals), ``channel_units``,
        those of the record, and ``channel_quantity``, what it calls the channel, else what the
        model calls the state or output that this shows. Over ``channel`` and ``source``:
        ``discrepancy``, the root mean square of errors that follow the motion, 0 where residuals
        speak of none. Over ``source``: ``force_error``, that of the forces as a part of the
        accelerations. Over ``channel`` and ``time``: ``measured``, ``fitted``, ``residual``,
        ``held_back``. Over ``picked``, the events of all channels: ``picked_channel``,
        ``picked_measured``, ``picked_fitted``, ``picked_residual``, ``picked_held_back``, and
        ``picked_missed`` where the motion has no such event. Over ``segment``: ``segment_time``,
        ``segment_state`` and the number of its record, ``segment_record``. Over ``mark``:
        ``mark_time``, marks of a single record or where periods of the forcing begin. Over
        ``start``: ``start_estimate``, ``start_cost``, ``start_agrees``. Over ``direction``,
        parameters that are not determined, and combinations of several: ``direction_part``,
        ``direction_spread``. Attributes: ``status`` (completed, not_converged), ``message``,
        ``open_parameters`` and ``interval_method`` in words, ``largest_gap`` between segments in
        parts of the states, ``n_evaluations``; ``form`` and ``cycle`` of each record; for steady
        motions ``largest_multiplier``, above 1 where a fitted orbit is unstable.

    Raises
    ------
    OptionError
        When a name is unknown, bounds are not in order, the system is allowed nowhere within them,
        an expression cannot be read, or instants lie outside of the samples.
    RunError
        When no motion can be computed from any start.

    Warns
    -----
    ResultWarning
        When the fit has not converged, as its ``status`` says. Before the fit, when the system is
        not allowed at one of the bounds, and when samples are further apart than any motion of the
        model lasts, or all of them within a small part of one: times may be in another unit.

    See Also
    --------
    simulate : the motion of the fitted system.
    posterior : how probable values are, where a normal density with these errors is not enough.
    plot.fit : measured beside fitted.
    plot.profiles : how fast the likelihood falls away from each estimate.

    Notes
    -----
    Maximum likelihood for noise that is normal and white. The solver is
    ``scipy.optimize.least_squares`` with bounds; the method of multipliers makes the segments
    continuous. Where a state fits several modes, as with a latch or a thermostat, a segment begins
    in the mode in which the one before has ended, and the first one in that which fits its data
    best, or where the motion is periodic, in the mode of its end. Far from the minimum each segment
    begins in the mode that fits its own data best. A run of a segment ends early, as if no motion
    were there, after ten times the work that the motion from ``initial`` and a step of the engine
    to each sample need: a record in mm of a model in m asks for motions that are a thousand times
    as fast. A start is given up that cannot come near the best one, or where times are doubtful, if
    it leaves more than half of a record; a search that has not converged looks for better values
    along profiles with as many motions as it has taken, and for no errors that follow the motion.
    An interval ends where twice the logarithm of
    the likelihood, with everything else found anew, has fallen by the quantile of an F
    distribution.

    Where the test of Ljung and Box speaks against white residuals, each channel is described by an
    autoregression, whose innovations may be correlated from channel to channel. The covariance of
    the estimates is then a sandwich, and the profile falls by the quantile times the ratio of the
    variances. That counts in coloured noise. Residuals remember less than the noise, by what the
    fit has taken out of them, and this is made up for as by Worsley and others. The memory is known
    with few degrees of freedom where noise remembers long, which make the quantile larger.

    Errors that follow the motion come again with it, and noise does not. Five families of them are
    looked for: errors of the times of the samples that change from period to period; a filter of a
    few samples, as that of a sensor; any filter as long as a period, which the model or the sensor
    may cause; forces that err as those of a mass, a stiffness, a damper or a dead load that is
    off; and nonlinear forces that the model lacks, up to the third degree in position and velocity
    of each mass. Columns of the last two are derivatives of the motion by the engine, and all
    channels share their coefficients. They need states that are rates of others, of at most six
    masses. Each family has random coefficients whose variance is found by restricted maximum
    likelihood, beside the autoregression. One after the other enters as long as the ratio of
    likelihoods has a probability below 0.01 without it, and is named. That is the level of each
    family: of five, one in twenty records of a right model in white noise could get a name; of 1320
    such records with one and two channels, 16 did, 1.2 %, as families look alike and errors of the
    forces are to be seen in a channel and in all of them together. Where residuals are not
    white, more of them count, without a name, as long as it is below a quarter, the level of tests
    before pooling of variances (Bozivich and others). The covariance of all is part of the
    sandwich, and degrees of freedom of the variances, by Satterthwaite, make the quantile larger:
    few of them tell the size of a wrong mass, and intervals are wide. Forces that would err
    by 30 % and more count as none. What the parameters absorb of a wrong model leaves no trace in
    the residuals; no single record shows it.

    References
    ----------
    H. G. Bock, Recent advances in parameter identification techniques for O.D.E., 1983: multiple
    shooting. D. P. Bertsekas, Constrained Optimization and Lagrange Multiplier Methods, 1982.
    W. J. den Haan and A. Levin, A practitioner's guide to robust covariance matrix estimation,
    Handbook of Statistics 15, 299-342 (1997): autoregressions. R. E. Chandler and S. Bate,
    Inference for clustered data using the independence loglikelihood, Biometrika 94, 167-183
    (2007): the profile. K. J. Worsley, C. H. Liao, J. Aston, V. Petre, G. H. Duncan, F. Morales and
    A. C. Evans, A general statistical analysis for fMRI data, NeuroImage 15, 1-15 (2002), appendix:
    autocorrelation from residuals. E. Carlstein, The use of subseries values for estimating the
    variance of a general statistic from a stationary sequence, Annals of Statistics 14, 1171-1179
    (1986): the length of blocks. M. C. Kennedy and A. O'Hagan, Bayesian calibration of computer
    models, Journal of the Royal Statistical Society B 63, 425-464 (2001): discrepancies of models.
    K. Sargsyan, X. Huan and H. N. Najm, Embedded model error representation for Bayesian model
    calibration, International Journal for Uncertainty Quantification 9, 365-394 (2019): errors in
    the equations. S. F. Masri and T. K. Caughey, A nonparametric identification technique for
    nonlinear dynamic problems, Journal of Applied Mechanics 46, 433-447 (1979): forces as
    polynomials of position and velocity.
    H. D. Patterson and R. Thompson, Recovery of inter-block information when block sizes are
    unequal, Biometrika 58, 545-554 (1971): restricted maximum likelihood. F. E. Satterthwaite, An
    approximate distribution of estimates of variance components, Biometrics Bulletin 2, 110-114
    (1946). H. Bozivich, T. A. Bancroft and H. O. Hartley, Power of analysis of variance test
    procedures for certain incompletely specified models, I, Annals of Mathematical Statistics 27,
    1017-1043 (1956).

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
    given, system = system, options.system_of(system)
    bounds, moved = check_free(system, free), read_shift(shift)
    refuse_fixed(given, parameters, bounds, "free")
    nuisances = {"gain": gain, "offset": offset, "delay": delay}
    records, datasets = [], []
    for label, data, each in _records(system, record, by_record, bounds):
        check_allowed(each, bounds)
        times = check_record_times(f"record {label!r}" if label else "record", data)
        channels = read_channels(each, data, observe, nuisances, noise)
        records.append(GivenRecord(label, each, channels, times))
        datasets.append(data)
    if not is_known(loss, LOSSES):
        raise OptionError(f"loss = {quote(loss)}: give one of {', '.join(LOSSES)}")
    share = finite_real("hold_back", hold_back)
    if not 0.0 <= share <= 0.9:
        raise OptionError(f"hold_back = {share:g} must lie between 0 and 0.9")
    count, drawn = whole_number("starts", starts), whole_number("bootstrap", bootstrap, 0)
    chosen = check_seed(seed)
    cuts = [cut_for(each, bounds, form, cycle, segments, share) for each in records]
    own = _private(private, records)
    make = partial(_shooting, records, bounds, moved, cuts, own, tolerance)
    rest = _rest(system, initial)
    doubts = said_of_times(records, datasets, cuts, bounds, rest)
    highest = height_of_explaining(make(), _HALF) if doubts else np.inf
    for words in doubts:
        warnings.warn(f"{system.name}: {words}", ResultWarning, stacklevel=2)
    told = options.recorded | {
        "free": str({name: (each.low, each.high) for name, each in bounds.items()}),
        "observe": str({c.name: c.text for each in records for c in each.channels}),
        "form": ", ".join("transient" if cut.cycle is None else "steady" for cut in cuts),
        "cycle": ", ".join("none" if cut.cycle is None else str(cut.cycle) for cut in cuts),
        "private": ", ".join(own), "hold_back": share, "loss": loss,
        "starts": count, "bootstrap": drawn, "seed": chosen,
    }  # fmt: skip
    whole = [channel for each in records for channel in each.channels]
    with Progress("fit", count + 1 + bool(drawn)) as bar:
        course = Course(bar)
        found = _search(make, rest, loss, count, chosen, course, highest)
        result = fit_dataset(whole, found, told, loss, drawn, chosen, _marks(record), course)
    result = with_units(result, records, datasets)

    def begin(others: Sequence[GivenRecord], clock: Range = moved) -> Shooting:
        return _shooting(others, bounds, clock, cuts, own, tolerance)

    def again(others: Sequence[GivenRecord], clock: Range = moved) -> Search:
        made = partial(begin, others, clock)
        return _search(made, rest, loss, 1, chosen, course, height_of_explaining(made()))

    told_so = ""
    if not (doubts or (found.best.closed and explains(found, LITTLE))):
        with Progress("fit: other units", _TRIALS) as bar:
            course = Course(bar)
            told_so = said_of_gains(explaining_gains(records, found, rest, begin, again))
            if not (told_so or moved.is_free):
                clocks = partial(begin, records), partial(again, records)
                told_so = said_of_shift(explaining_shift(records, found, rest, *clocks))
    more = "".join(f"; {words}" for words in (*doubts, told_so) if words)
    if result.attrs["status"] != "completed":
        reason = str(result.attrs["message"]).removeprefix("not_converged: ").split("; ")
        said = f"{system.name}: the fit has not converged: {'; '.join(reason[:2])}"
        warnings.warn(f"{said}{more}", ResultWarning, stacklevel=2)
    return result.assign_attrs(message=f"{result.attrs['message']}{more}")


def _marks(record: Any) -> Floats | None:
    """Marks of a single record that has some."""
    if "mark_time" not in getattr(record, "coords", ()):
        return None
    return np.asarray(record["mark_time"].values, float)


def _records(
    system: System, record: Any, by_record: Any, free: Collection[str]
) -> list[tuple[str, Any, System]]:
    """Name, dataset and system of each record; a single one has no name."""
    several = isinstance(record, Mapping) and not hasattr(record, "data_vars")
    named = dict(record) if several else {"": record}
    if not named:
        raise OptionError("record: give a dataset, or several by their names")
    values = {} if by_record is None else by_record
    if not isinstance(values, Mapping) or not all(
        isinstance(each, Mapping) for each in values.values()
    ):
        raise OptionError(
            f"by_record = {quote(by_record)}: give parameters by the name of the record, such as"
            " {'slow': {'omega': 0.8}}"
        )
    for label in values:
        if not several:
            raise OptionError(
                "by_record: there is one record; give its value to the system, or give several"
                " records by their names"
            )
        if label not in named:
            raise OptionError(f"by_record: {unknown_name('record', label, named)}")
        for name in free:
            if name in values[label]:
                raise OptionError(
                    f"by_record: {name!r} is given for the record {str(label)!r}, and is to be"
                    " found too; leave it out of by_record=, or of free="
                )
    return [
        (str(label), data, SharedOptions(parameters=values.get(label)).system_of(system))
        for label, data in named.items()
    ]


def _private(private: Any, records: Sequence[GivenRecord]) -> tuple[str, ...]:
    """Names of what is found for each record by itself."""
    if isinstance(private, str) or not hasattr(private, "__iter__"):
        raise OptionError(f"private = {quote(private)}: give a list of names")
    names = tuple(map(str, private))
    if names and len(records) == 1:
        raise OptionError("private: there is one record; give several by their names, or leave it")
    return names


def _rest(system: System, initial: Any) -> Floats:
    """Guess of the first state."""
    from nonsmooth.runs.runner import build_tables

    start: Floats = resolve_start(system, build_tables(system), initial).state
    return np.where(np.isfinite(start), start, 0.0)


def _shooting(
    records: Sequence[GivenRecord],
    free: Mapping[str, Range],
    shift: Range,
    cuts: Sequence[Cut],
    private: Collection[str],
    tolerance: float,
) -> Shooting:
    """The equations of all records."""
    equations = [
        equations_of(each, free, shift, cut, tolerance)
        for each, cut in zip(records, cuts, strict=True)
    ]
    labels = [each.label for each in records]
    return Shooting(equations, list(free.values()), labels, private)


def _search(
    make: Callable[[], Shooting],
    initial: Floats,
    loss: str,
    count: int,
    seed: int,
    course: Course,
    highest: float = np.inf,
) -> Search:
    """The best minimum of several starts; those that cannot come below a height are given up."""
    shootings = [make() for _ in range(count)]
    first = shootings[0]
    guesses = np.tile(first.guess(), (count, 1))
    if count > 1:
        spread = np.flatnonzero(first.is_spread)
        sampler = qmc.LatinHypercube(spread.size, rng=np.random.default_rng(seed))
        low = np.array([first.ranges[k].low for k in spread])
        width = np.array([first.ranges[k].scale for k in spread])
        guesses[1:, spread] = low + width * sampler.random(count - 1)
    noise = np.array([channel.noise.guess for channel in first.channels])
    found: list[Fitted | None] = []
    for k, (shooting, guess) in enumerate(zip(shootings, guesses, strict=True)):
        shooting.tell(course)
        if prepare(shooting, guess, initial):
            best = min([highest, *(height(each) for each in found if each is not None)])
            found.append(solve_from(shooting, guess, initial, noise, loss, seed + k, best))
        else:
            found.append(None)
        course.end_phase()
    if all(each is None for each in found):
        raise RunError(
            f"{first.system.name}: no motion could be computed from any of {count} starts; give"
            " initial= a state that one of the modes admits, narrower bounds in free=, or more"
            " starts="
        )
    return Search(found, shootings)
