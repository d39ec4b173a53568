"""`roc`: detections against false alarms, over all thresholds of a score."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr
from scipy.special import expit, logit
from scipy.stats import rankdata, t

from nonsmooth.measured.monitoring.dependence import Worth, design_effect, tail_effect
from nonsmooth.measured.monitoring.scores import healthy_scores, windows_of
from nonsmooth.version import __version__

__all__ = ["roc"]

Floats = npt.NDArray[np.float64]

_MOST = 200  # thresholds of the curve
_OUTSIDE = 0.025  # of an interval, on either side


def roc(
    healthy: xr.Dataset | Iterable[xr.Dataset],
    faulty: xr.Dataset | Iterable[xr.Dataset],
    *,
    training: float | None = None,
) -> xr.Dataset:
    r"""Receiver operating characteristic: detections against false alarms.

    Parameters
    ----------
    healthy : xarray.Dataset or list of xarray.Dataset
        Indicators of healthy windows, as for `alarm`.
    faulty : xarray.Dataset or list of xarray.Dataset
        The same indicators of windows with the fault, such as those of one length of a crack.

    Other Parameters
    ----------------
    training : float, optional
        As for `alarm`.

    Returns
    -------
    xarray.Dataset
        Over ``threshold``, falling: ``false_alarms``, the share of held-out healthy windows with a
        score above it, and ``detections``, that of faulty windows, each with its 95 % interval
        (``false_alarms_low`` and so on). ``area``, the probability that a faulty window has a
        higher score than a healthy one, with ``area_low`` and ``area_high``. 0.5 is chance.

    Raises
    ------
    OptionError
        If the indicators do not fit, or the windows are too few.

    See Also
    --------
    alarm : one threshold, for a stated rate of false alarms.
    nonsmooth.plot.roc : a picture.

    Notes
    -----
    Scores are those of `alarm`. Intervals of shares are those of Clopper and Pearson for the
    effective number of windows. The area is the statistic of Mann and Whitney; the variance of its
    two parts is that of DeLong [1]_, each multiplied by its design effect, and the interval is made
    for the logit with the quantile of Student's distribution, for as many degrees of freedom as
    there are records, or effective windows of one record, less one. An area of 1 has the lower
    limit 0.025\ :sup:`1/k`, k being the smaller one of both effective numbers: the limit for k
    pairs that were all told apart. Windows of a fault that grows depend on each other, which makes
    the interval wide; records of one state of the fault are better.

    References
    ----------
    .. [1] E. R. DeLong, D. M. DeLong and D. L. Clarke-Pearson, "Comparing the areas under two or
       more correlated receiver operating characteristic curves", Biometrics 44 (1988), 837.

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> import nonsmooth as ns
    >>> noise = np.random.default_rng(0).normal(size=1400)
    >>> healthy = xr.Dataset({"second": ("window", noise[:1000])})
    >>> faulty = xr.Dataset({"second": ("window", 3 + noise[1000:])})
    >>> round(float(ns.measured.roc(healthy, faulty)["area"]), 2)
    0.97
    """
    known = healthy_scores(healthy, training)
    tables, _ = windows_of(faulty, known.names, "faulty")
    groups = {
        "false_alarms": known.runs,
        "detections": [known.reference.score(table) for table in tables],
    }
    whole = np.sort(np.concatenate([np.concatenate(runs) for runs in groups.values()]))
    places = np.linspace(0, whole.size - 1, min(whole.size, _MOST)).round().astype(int)
    limits = np.concatenate([[np.inf], whole[places[::-1]], [-np.inf]])
    words = {"false_alarms": "false alarms", "detections": "detections"}
    found: dict[str, Any] = {}
    for name, runs in groups.items():
        worth = Worth(sum(one.size for one in runs), tail_effect(runs), len(runs))
        shares = _shares_above(np.sort(np.concatenate(runs)), limits)
        ends = worth.interval_of_seen(shares)
        for key, values in zip(("", "_low", "_high"), (shares, *ends), strict=True):
            text = {"long_name": f"rate of {words[name]}"}
            found[f"{name}{key}"] = "threshold", values, text
    area = _area(groups["false_alarms"], groups["detections"])
    for key, value in zip(("area", "area_low", "area_high"), area, strict=True):
        found[key] = (), value, {"long_name": "area under the curve"}
    return xr.Dataset(
        found,
        {"threshold": ("threshold", limits, {"long_name": "threshold of the score"})},
        {
            "indicators": ", ".join(known.names),
            "n_healthy": sum(one.size for one in groups["false_alarms"]),
            "n_faulty": sum(one.size for one in groups["detections"]),
            "nonsmooth_version": __version__,
        },
    )


def _shares_above(scores: Floats, limits: Floats) -> Floats:
    """Share of sorted scores above each limit."""
    above = scores.size - np.searchsorted(scores, limits, side="right")
    found: Floats = above / scores.size
    return found


def _area(healthy: list[Floats], faulty: list[Floats]) -> tuple[float, float, float]:
    """Area under the curve with its 95 % interval."""
    low, high = _placed(healthy, faulty), _placed(faulty, healthy)
    area = float(np.concatenate(high).mean())
    numbers, freedom, variance = [], [], 0.0
    for runs in (low, high):
        places = np.concatenate(runs)
        numbers.append(places.size / design_effect(runs))
        freedom.append(len(runs) - 1.0 if len(runs) > 1 else numbers[-1] - 1.0)
        variance += float(places.var()) / numbers[-1]
    least = _OUTSIDE ** (1.0 / min(numbers))  # of as many pairs, all of them told apart
    if area in (0.0, 1.0) or variance == 0.0:
        return area, area if area < 1.0 else least, area if area > 0.0 else 1.0 - least
    quantile = float(t.ppf(1.0 - _OUTSIDE, max(min(freedom), 1.0)))
    reach = quantile * math.sqrt(variance) / (area * (1.0 - area))
    middle = float(logit(area))
    return area, float(expit(middle - reach)), float(expit(middle + reach))


def _placed(runs: list[Floats], others: list[Floats]) -> list[Floats]:
    """Share of the other scores below each score; half of those that are equal count."""
    own, other = np.concatenate(runs), np.concatenate(others)
    below = rankdata(np.concatenate([own, other]))[: own.size] - rankdata(own)
    return np.split(below / other.size, np.cumsum([one.size for one in runs])[:-1])
