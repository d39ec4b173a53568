"""`alarm`: a threshold for indicators over windows, set for a stated rate of false alarms."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.errors import OptionError, ResultWarning
from nonsmooth.measured.monitoring.dependence import Worth, design_effect, tail_effect
from nonsmooth.measured.monitoring.scores import (
    Healthy,
    healthy_scores,
    share_between,
    windows_of,
)
from nonsmooth.runs.options import whole_number
from nonsmooth.version import __version__

__all__ = ["alarm"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_BLOCKS = 10  # of one healthy record, each judged by a threshold from the others


class _Rule(NamedTuple):
    """How many of the last windows must lie above the threshold."""

    needed: int
    among: int

    def alarmed(self, exceeded: Mask) -> Mask:
        """Windows of one record at which an alarm is raised."""
        recent = np.convolve(exceeded.astype(int), np.ones(self.among, dtype=int))
        found: Mask = recent[: exceeded.size] >= self.needed
        return found


def alarm(
    healthy: xr.Dataset | Iterable[xr.Dataset],
    watched: xr.Dataset | Iterable[xr.Dataset] | None = None,
    *,
    rate: float = 0.01,
    training: float | None = None,
    needed: int = 1,
    among: int = 1,
) -> xr.Dataset:
    r"""Set a threshold for a stated rate of false alarms, and judge watched windows by it.

    Parameters
    ----------
    healthy : xarray.Dataset or list of xarray.Dataset
        Indicators of healthy windows, in order of time: variables over ``window``, as of
        `indicators`. In a list, one dataset for each record.
    watched : xarray.Dataset or list of xarray.Dataset, optional
        The same indicators of the windows to be judged, in order of time.

    Other Parameters
    ----------------
    rate : float, optional
        Wanted probability that a healthy window lies above the threshold.
    training : float, optional
        The beginning of one healthy record, as a part of it, that sets mean and covariance; a
        half by default. The rest sets the threshold: were both from the same windows, false
        alarms would be more frequent than stated. Of several records, each is scored by the mean
        and the covariance of all others, so nothing is set aside.
    needed, among : int, optional
        An alarm is raised where at least ``needed`` of the last ``among`` windows of the same
        record lie above the threshold.

    Returns
    -------
    xarray.Dataset
        ``threshold`` of the score; ``rate_expected``, ``rate_low`` and ``rate_high``, the expected
        rate of healthy windows above it and its 95 % interval; ``alarm_rate``, ``alarm_rate_low``
        and ``alarm_rate_high``, the same for windows with an alarm; ``n_training``,
        ``n_calibration``, and ``n_effective``, to how many independent windows those of the
        calibration are worth; over ``healthy_record`` the ``share_exceeded`` of its windows. Over
        ``window``, if windows are watched: ``score``, ``exceeded``, ``alarmed`` and ``leading``,
        the indicator farthest from its healthy mean; ``first_alarm``, the place of the first
        window with an alarm, -1 for none, and ``first_alarm_time`` where windows have a ``time``,
        nan for none.

    Raises
    ------
    OptionError
        If the healthy windows are too few for the rate, or the indicators do not fit.

    Warns
    -----
    ResultWarning
        If healthy windows would be enough for the rate were they independent, and are not. The
        largest score is then the threshold, and ``rate_expected`` is larger than ``rate``.

    See Also
    --------
    indicators : windows of a record.
    roc : detections against false alarms, over all thresholds.
    nonsmooth.plot.alarm : a picture.

    Notes
    -----
    The score is the Mahalanobis distance, with the correlation shrunk towards the identity. The n
    scores of healthy windows that the reference does not know are worth n / D independent ones,
    where D is the design effect. It is the integrated autocorrelation time of the upper ranks of
    the scores, or, if that is larger, the variance of their means over records beside that of
    independent windows. The threshold is the r-th largest score, or lies between two of them,

    .. math:: r = p (n + D) - (D - 1) / 2,

    for the rate p. The true rate then has about the distribution Beta(p (n/D + 1),
    (1 - p) (n/D + 1)), exactly so for D = 1 and a whole r, whatever the distribution of the scores.
    With m records the interval is that of Clopper and Pearson for a share p of n/D windows, where
    n/D is multiplied by (1.96 / t)\ :sup:`2`, t being the quantile of Student's distribution with
    m - 1 degrees of freedom [1]_: few records tell little of how much they differ. It begins at
    zero where less than one independent window is expected above the threshold. The rate is that
    of windows of further records, on the average over records. One record alone tells nothing of
    how others differ, and then the rate holds for this record only.

    The rate of alarms is that of held-out windows in their order: thresholds come from all records
    but one, or from nine tenths of a record, and the rule is applied to what is left. Its interval
    is that of Clopper and Pearson for the effective number. With ``needed = among = 1`` both rates
    are the same.

    All of this holds only while healthy windows stay as they were: a change of load or temperature
    is an alarm, too, unless the healthy records have such changes.

    References
    ----------
    .. [1] E. L. Korn and B. I. Graubard, "Confidence intervals for proportions with small expected
       number of positive counts estimated from survey data", Survey Methodology 24 (1998), 193.

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> import nonsmooth as ns
    >>> noise = np.random.default_rng(0).normal(size=(2, 1000))
    >>> healthy = xr.Dataset({"second": ("window", noise[0]), "rms": ("window", noise[1])})
    >>> watched = xr.Dataset({"second": ("window", [0.0, 9.0]), "rms": ("window", [0.0, 0.0])})
    >>> found = ns.measured.alarm(healthy, watched)
    >>> found["alarmed"].values.tolist(), str(found["leading"].values[1])
    ([False, True], 'second')
    """
    wanted = share_between("rate", rate)
    rule = _Rule(whole_number("needed", needed, 1), whole_number("among", among, 1))
    if rule.needed > rule.among:
        raise OptionError(f"needed = {rule.needed} must not exceed among = {rule.among}")
    known = healthy_scores(healthy, training)
    scores = np.concatenate(known.runs)
    if wanted * (scores.size + 1) < 1.0 - 1e-9:
        raise OptionError(
            f"healthy: {scores.size} windows for the threshold support no rate below"
            f" {1 / (scores.size + 1):.3g}, and rate = {wanted:g}; give at least"
            f" {np.ceil(1.0 / wanted - 1e-9) - 1.0:.15g} of them, or a larger rate"
        )
    worth = Worth(scores.size, tail_effect(known.runs), len(known.runs))
    threshold, expected = _threshold(scores, wanted, worth.effect)
    if expected > wanted * (1.0 + 1e-9):
        warnings.warn(_too_few(worth, wanted, expected), ResultWarning, stacklevel=2)
    rates = (expected, *worth.interval(expected))
    alarms = rates if rule.among == 1 else _rates_of_rule(known.runs, wanted, worth, rule)
    found = xr.Dataset(
        {
            "threshold": ((), threshold, {"long_name": "threshold of the score"}),
            **_three("rate_expected rate_low rate_high", rates, "healthy windows above it"),
            **_three("alarm_rate alarm_rate_low alarm_rate_high", alarms, "false alarms"),
            "n_training": known.n_training,
            "n_calibration": scores.size,
            "n_effective": worth.effective,
            "share_exceeded": (
                "healthy_record", [float(np.mean(one > threshold)) for one in known.runs],
                {"long_name": "share of healthy windows above the threshold"},
            ),
        },
        attrs={
            "rate": wanted, "needed": rule.needed, "among": rule.among,
            "nonsmooth_version": __version__,
        },
    )  # fmt: skip
    if watched is None:
        return found
    tables, coords = windows_of(watched, known.names, "watched")
    judged = _judged(tables, known, threshold, rule)
    return _with_time(found.assign(judged).assign_coords(coords))


def _threshold(scores: Floats, rate: float, effect: float) -> tuple[float, float]:
    """Threshold for a rate, and the rate that is expected of it: more, where windows are too few.

    Scores in groups of D equal ones show why: the r-th largest score is, on the average over its
    place in a group, the (r / D + (1 - 1 / D) / 2)-th largest of n / D independent ones, and the
    rate of what exceeds that is expected to be this over n / D + 1.
    """
    count = scores.size
    rank = rate * (count + effect) - 0.5 * (effect - 1.0)
    rank = min(max(rank, 1.0), float(count))
    above = np.sort(scores)[::-1]
    threshold = float(np.interp(rank, np.arange(1.0, count + 1.0), above))
    return threshold, max(rate, (rank + 0.5 * (effect - 1.0)) / (count + effect))


def _too_few(worth: Worth, rate: float, expected: float) -> str:
    why = "that differ" if worth.records > 1 else "that follow each other"
    return (
        f"{worth.size} healthy windows {why} are worth {worth.effective:.0f} independent ones,"
        f" which do not support rate = {rate:g}: the threshold is the largest score, and"
        f" {expected:.2g} of healthy windows are expected above it; give more healthy"
        f" {'records' if worth.records > 1 else 'windows'}, or a larger rate="
    )


def _rates_of_rule(
    runs: list[Floats], rate: float, worth: Worth, rule: _Rule
) -> tuple[float, float, float]:
    """Share of held-out windows with an alarm by the rule, with its interval."""
    parts = runs
    if len(runs) == 1:
        parts = np.array_split(runs[0], min(_BLOCKS, runs[0].size))
    alarmed = []
    for k, part in enumerate(parts):
        others = np.concatenate([one for i, one in enumerate(parts) if i != k] or [part])
        limit, _ = _threshold(others, rate, worth.effect)
        alarmed.append(rule.alarmed(part > limit).astype(float))
    share = float(np.concatenate(alarmed).mean())
    effect = max(worth.effect, float(rule.among), design_effect(alarmed))
    low, high = worth._replace(effect=effect).interval_of_seen(share)
    return share, float(low), float(high)


def _three(names: str, values: tuple[float, ...], text: str) -> dict[str, Any]:
    """A rate and the ends of its interval, with their names."""
    words = ("expected rate of", "least rate of", "largest rate of")
    return {
        name: ((), value, {"long_name": f"{word} {text}"})
        for name, value, word in zip(names.split(), values, words, strict=True)
    }


def _judged(tables: list[Floats], known: Healthy, threshold: float, rule: _Rule) -> dict[str, Any]:
    """Variables of watched windows; each record begins without windows before it."""
    scores = [known.reference.score(table) for table in tables]
    alarmed = np.concatenate([rule.alarmed(one > threshold) for one in scores])
    score, table = np.concatenate(scores), np.concatenate(tables)
    farthest = np.abs(known.reference.standardised(table)).argmax(axis=1)
    return {
        "score": ("window", score, {"long_name": "distance from healthy windows"}),
        "exceeded": ("window", score > threshold, {"long_name": "score above the threshold"}),
        "alarmed": ("window", alarmed, {"long_name": "alarm"}),
        "leading": (
            "window", np.array(known.names)[farthest],
            {"long_name": "indicator farthest from its healthy mean"},
        ),
        "first_alarm": int(alarmed.argmax()) if alarmed.any() else -1,
    }  # fmt: skip


def _with_time(found: xr.Dataset) -> xr.Dataset:
    """With the time of the first alarm, where windows have times."""
    if "time" not in found.coords:
        return found
    place, words = int(found["first_alarm"]), dict(found["time"].attrs)
    time = float(found["time"][place]) if place >= 0 else math.nan
    return found.assign(
        first_alarm_time=((), time, words | {"long_name": "time of the first alarm"})
    )
