"""`alarm`: a threshold for indicators over windows, set for a stated rate of false alarms."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr
from scipy.stats import beta, rankdata

from nonsmooth.errors import OptionError
from nonsmooth.runs.options import finite_number, whole_number
from nonsmooth.version import __version__

__all__ = ["alarm"]

Floats = npt.NDArray[np.float64]


class _Reference(NamedTuple):
    """Healthy windows that set the scale: mean, spread, and the inverse of the correlation."""

    mean: Floats
    spread: Floats
    inverse: Floats

    def standardised(self, values: Floats) -> Floats:
        scaled: Floats = (values - self.mean) / self.spread
        return scaled

    def score(self, values: Floats) -> Floats:
        """Mahalanobis distance of each window."""
        z = self.standardised(values)
        distance: Floats = np.sqrt(np.einsum("ij,jk,ik->i", z, self.inverse, z))
        return distance


def alarm(
    healthy: xr.Dataset | Iterable[xr.Dataset],
    watched: xr.Dataset | None = None,
    *,
    rate: float = 0.01,
    training: float = 0.5,
    needed: int = 1,
    among: int = 1,
) -> xr.Dataset:
    r"""Set a threshold for a stated rate of false alarms, and judge watched windows by it.

    Parameters
    ----------
    healthy : xarray.Dataset or list of xarray.Dataset
        Indicators of healthy windows, in order of time: variables over ``window``, such as the
        size of the second harmonic. In a list, one dataset for each record.
    watched : xarray.Dataset, optional
        The same indicators of the windows to be judged.

    Other Parameters
    ----------------
    rate : float, optional
        Wanted probability that a healthy window lies above the threshold.
    training : float, optional
        Share of each healthy dataset, from its beginning, that sets mean and covariance. The rest
        sets the threshold: were both from the same windows, false alarms would be more frequent
        than stated.
    needed, among : int, optional
        An alarm is raised where at least ``needed`` of the last ``among`` windows lie above the
        threshold.

    Returns
    -------
    xarray.Dataset
        ``threshold`` of the score; ``rate_expected``, ``rate_low`` and ``rate_high``, the expected
        rate of false alarms and its 95 % interval; ``n_training``, ``n_calibration``, and
        ``n_effective``, to how many independent windows those of the calibration are worth. Over
        ``window``, if windows are watched: ``score``, ``exceeded``, ``alarmed`` and ``leading``,
        the indicator farthest from its healthy mean; ``first_alarm``, the place of the first
        window with an alarm, -1 for none.

    Raises
    ------
    OptionError
        If the healthy windows are too few for the rate, or the indicators do not fit.

    Notes
    -----
    The score is the Mahalanobis distance, with the correlation shrunk towards the identity. The
    threshold is the r-th largest of n calibration scores, r = floor(rate (n + 1)). The rate of
    windows above it has the distribution Beta(r, n + 1 - r) whatever the distribution of the
    scores, if windows are independent. Successive windows are not: both parameters are divided by
    the integrated autocorrelation time of the ranks of the scores, which is an approximation. The
    rates are those of single windows, before ``needed`` and ``among``, and hold only while
    healthy windows stay as they were: a change of load or temperature is an alarm, too. The
    interval is too narrow where healthy records differ from each other.

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
    wanted, share = _between("rate", rate), _between("training", training)
    least, last = whole_number("needed", needed, 1), whole_number("among", among, 1)
    if least > last:
        raise OptionError(f"needed = {least} must not exceed among = {last}")
    sets = [healthy] if isinstance(healthy, xr.Dataset) else _several(healthy)
    names = _indicators(sets[0], "healthy")
    tables = [_table(one, names, "healthy") for one in sets]
    cuts = [int(share * table.shape[0]) for table in tables]
    first = np.concatenate([table[:cut] for table, cut in zip(tables, cuts, strict=True)])
    reference = _reference(first, names)
    runs = [reference.score(table[cut:]) for table, cut in zip(tables, cuts, strict=True)]
    scores = np.concatenate(runs)
    count, rank = scores.size, math.floor(wanted * (scores.size + 1) + 1e-9)
    if rank < 1:
        raise OptionError(
            f"healthy: {count} windows for the threshold support no rate below"
            f" {1 / (count + 1):.3g}, and rate = {wanted:g}; give at least"
            f" {math.ceil(1 / wanted - 1e-9) - 1} of them, or a larger rate"
        )
    worth = 1.0 / _correlation_time(runs)
    spread = beta(rank * worth, (count + 1 - rank) * worth)
    threshold = float(np.sort(scores)[count - rank])
    found = xr.Dataset(
        {
            "threshold": threshold,
            "rate_expected": rank / (count + 1),
            "rate_low": float(spread.ppf(0.025)),
            "rate_high": float(spread.ppf(0.975)),
            "n_training": first.shape[0],
            "n_calibration": count,
            "n_effective": count * worth,
        },
        attrs={"rate": wanted, "needed": least, "among": last, "nonsmooth_version": __version__},
    )
    if watched is None:
        return found
    return found.assign(_judged(_table(watched, names, "watched"), names, reference, found))


def _judged(
    table: Floats, names: list[str], reference: _Reference, found: xr.Dataset
) -> dict[str, Any]:
    """Variables of watched windows."""
    score = reference.score(table)
    exceeded = score > float(found["threshold"])
    among = int(found.attrs["among"])
    recent = np.convolve(exceeded.astype(int), np.ones(among, dtype=int))[: exceeded.size]
    alarmed = recent >= int(found.attrs["needed"])
    farthest = np.abs(reference.standardised(table)).argmax(axis=1)
    return {
        "score": ("window", score),
        "exceeded": ("window", exceeded),
        "alarmed": ("window", alarmed),
        "leading": ("window", np.array(names)[farthest]),
        "first_alarm": int(alarmed.argmax()) if alarmed.any() else -1,
    }


def _reference(values: Floats, names: list[str]) -> _Reference:
    """Mean, spread and correlation, the last shrunk by the share p / (n + p) of the identity."""
    count, width = values.shape
    if count < width + 2:
        raise OptionError(
            f"healthy: {count} windows for mean and covariance are too few for {width} indicators;"
            f" give at least {width + 2} of them, or a larger training"
        )
    mean, spread = values.mean(axis=0), values.std(axis=0, ddof=1)
    still = [name for name, one in zip(names, np.ptp(values, axis=0), strict=True) if one == 0.0]
    if still:
        raise OptionError(f"healthy: the indicator {still[0]} does not vary; leave it out")
    z = (values - mean) / spread
    share = width / (count + width)
    correlation = (1.0 - share) * (z.T @ z) / (count - 1) + share * np.eye(width)
    return _Reference(mean, spread, np.linalg.inv(correlation))


def _correlation_time(runs: list[Floats]) -> float:
    """Integrated autocorrelation time of ranks, by the initial positive sequence of Geyer."""
    ranks = rankdata(np.concatenate(runs))
    ranks -= ranks.mean()
    parts = np.split(ranks, np.cumsum([one.size for one in runs])[:-1])
    power = float(ranks @ ranks)
    if power == 0.0:
        return float(ranks.size)
    total, longest = -1.0, max(one.size for one in parts)
    for lag in range(0, longest - 1, 2):
        pair = sum(
            float(one[: one.size - k] @ one[k:])
            for one in parts
            for k in (lag, lag + 1)
            if k < one.size
        )
        if pair <= 0.0:
            break
        total += 2.0 * pair / power
    return max(total, 1.0)


def _between(name: str, value: Any) -> float:
    number = finite_number(name, value)
    if not 0.0 < number < 1.0:
        raise OptionError(f"{name} = {number:g} must lie between 0 and 1")
    return number


def _several(healthy: Any) -> list[Any]:
    sets = list(healthy) if isinstance(healthy, Iterable) and not isinstance(healthy, str) else []
    if not sets:
        raise OptionError("healthy: give a dataset over window, or a list of such datasets")
    return sets


def _indicators(data: Any, option: str) -> list[str]:
    """Variables over ``window``."""
    if not isinstance(data, xr.Dataset) or "window" not in data.dims:
        raise OptionError(f"{option}: give a dataset with indicators over window")
    names = [str(name) for name, one in data.data_vars.items() if one.dims == ("window",)]
    if not names:
        raise OptionError(f"{option}: no variable of the dataset lies over window alone")
    return names


def _table(data: Any, names: list[str], option: str) -> Floats:
    """Values by window and indicator."""
    there = _indicators(data, option)
    missing = [name for name in names if name not in there]
    if missing:
        raise OptionError(f"{option}: the indicator {missing[0]} is missing; it has {there}")
    if any(data[name].dtype.kind not in "biuf" for name in names):
        raise OptionError(f"{option}: indicators must be real numbers")
    table = np.column_stack([data[name].values.astype(float) for name in names])
    if not np.isfinite(table).all():
        raise OptionError(f"{option}: an indicator is not finite; leave such windows out")
    return table
