"""Which motion a run of the mole settles to: primitive period, its evidence, other attractors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np
import xarray as xr

from nonsmooth import System, simulate
from nonsmooth.chapter.judgement import Evidence
from nonsmooth.models import progression

__all__ = [
    "REST",
    "STARTS",
    "bounded_states",
    "primitive_period",
    "regimes_from",
    "settled_regime",
]

Start = Mapping[str, float]
REST: Start = {}
# Positions before and behind the rest position; q is the least that is admissible.
STARTS: tuple[Start, ...] = tuple(
    {"p": p, "y": y, "q": max(0.0, p - 0.02)}
    for p, y in product((-3.0, -1.0, 0.0, 1.0), (-1.0, 0.0, 1.0))
)
_LONGEST, _CLOSE = 64, 1e-8
# Neighbouring runs: the offset is far above rounding, and small after its growth.
_PAIRS, _OFFSET, _TURNED, _GROWN = 60, 1e-10, 2, 3


def bounded_states(run: xr.Dataset) -> np.ndarray:
    """States p, y, q of a run, shape (time, 3).

    Parameters
    ----------
    run : xarray.Dataset
        Run of the mole.

    Returns
    -------
    numpy.ndarray

    Examples
    --------
    >>> import nonsmooth as ns
    >>> bounded_states(ns.simulate(ns.models.moling(), periods=1, samples_per_period=4)).shape
    (5, 3)
    """
    return np.column_stack([run[name].values for name in "pyq"])


def primitive_period(
    points: np.ndarray, *, longest: int = _LONGEST, close: float = _CLOSE
) -> tuple[int, float]:
    """Least number of periods after which all points of a strobed motion repeat.

    Parameters
    ----------
    points : numpy.ndarray, shape (period, state)
        Strobed states, transient left out.
    longest : int, optional
        Largest number to try.
    close : float, optional
        Largest difference that counts as none.

    Returns
    -------
    period : int
        The number, zero when there is none up to ``longest``.
    residual : float
        Largest difference for it, or the least of those tried.

    Examples
    --------
    >>> import numpy as np
    >>> primitive_period(np.array([[0.0], [1.0]] * 40), longest=10)
    (2, 0.0)
    """
    residuals = [
        float(np.abs(points[n:] - points[:-n]).max())
        for n in range(1, min(longest, len(points) - 1) + 1)
    ]
    for n, residual in enumerate(residuals, start=1):
        if residual <= close:
            return n, residual
    return 0, min(residuals)


def settled_regime(
    system: System, start: Start = REST, *, transient: int = 600, record: int = 400
) -> Evidence:
    """Regime of one long run.

    Parameters
    ----------
    system : System
        The mole.
    start : mapping of str to float, optional
        Initial state.
    transient, record : int, optional
        Periods left out, and periods looked at.

    Returns
    -------
    dict
        ``period`` (zero: none found), ``residual`` and ``per_period`` (mean progression over
        the record). For a periodic motion ``contraction``: factor per period by which the
        run nears it, an estimate of its largest multiplier, None where it was too quick to
        be seen. For another one ``exponent`` per period with ``exponent_error``: largest
        exponent and its standard error, from neighbouring runs.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> found = settled_regime(ns.models.moling(b=0.15))
    >>> found["period"], round(found["per_period"], 3)
    (1, 31.345)
    """
    run = _strobed(system, start, transient + record)
    points = bounded_states(run)
    period, residual, per_period = _settled(run, record)
    found = {"period": period, "residual": residual, "per_period": per_period}
    if period:
        return found | {"contraction": _contraction(points, period)}
    exponent, error = _exponent(system, run.isel(time=slice(transient, None)))
    return found | {"exponent": exponent, "exponent_error": error}


def _strobed(system: System, start: Start, periods: int) -> xr.Dataset:
    return simulate(system, start, periods=periods, samples_per_period=1)


def _settled(run: xr.Dataset, record: int) -> tuple[int, float, float]:
    """Primitive period, its residual, and mean progression over the last periods."""
    period, residual = primitive_period(bounded_states(run)[-record - 1 :])
    return period, residual, float(progression(run, periods=record)["per_period"])


def _exponent(system: System, strobes: xr.Dataset) -> tuple[float, float]:
    """Mean growth of a small distance, per period, along the free flights of a motion."""
    # the distance turns to the direction of growth within the first periods
    flights = np.flatnonzero(strobes["mode"].values == 0)
    growth = []
    for k in flights[:: max(1, len(flights) // _PAIRS)]:
        start = {name: float(strobes[name][k]) for name in "pyq"}
        ends = [
            bounded_states(
                simulate(
                    system,
                    start | {"y": start["y"] + offset},
                    periods=_TURNED + _GROWN,
                    samples_per_period=1,
                )
            )
            for offset in (0.0, _OFFSET)
        ]
        distance = np.abs(ends[1] - ends[0]).max(axis=1)
        if distance[_TURNED] > 0.0 and distance[-1] > 0.0:
            growth.append(np.log(distance[-1] / distance[_TURNED]) / _GROWN)
    return float(np.mean(growth)), float(np.std(growth, ddof=1) / np.sqrt(len(growth)))


def _contraction(points: np.ndarray, period: int) -> float | None:
    """Slope of the logarithm of the distance from the final motion, between 1e-2 and 1e-9."""
    final = points[-period:]
    count = (len(points) // period) * period
    turns = points[len(points) - count :].reshape(-1, period, points.shape[1])
    distance = np.abs(turns - final).max(axis=(1, 2))
    late = np.flatnonzero(distance > 1e-2)
    first = int(late[-1]) + 1 if len(late) else 0
    fitted = first + np.flatnonzero(distance[first:] > 1e-9)
    if len(fitted) < 2:
        return None
    slope = np.polyfit(fitted, np.log(distance[fitted]), 1)[0]
    return float(np.exp(slope / period))


def regimes_from(system: System, starts: Sequence[Start] = STARTS) -> list[Evidence]:
    """Distinct regimes that a number of starts lead to.

    Parameters
    ----------
    system : System
        The mole.
    starts : sequence of mappings, optional
        Initial states.

    Returns
    -------
    list of dict
        ``period``, mean ``per_period`` and number of ``starts`` of each; aperiodic motions
        count as one.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> [row["period"] for row in regimes_from(ns.models.moling(b=0.15), STARTS[:3])]
    [1]
    """
    found: dict[tuple[int, float], list[float]] = {}
    for start in starts:
        period, _, per_period = _settled(_strobed(system, start, 1000), 400)
        # progression of an aperiodic motion is an average that scatters
        key = (period, round(per_period, 5) if period else 0.0)
        found.setdefault(key, []).append(per_period)
    return [
        {"period": period, "per_period": float(np.mean(values)), "starts": len(values)}
        for (period, _), values in sorted(found.items())
    ]
