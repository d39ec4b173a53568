"""Which motion a run of the mole settles to: primitive period, its evidence, other attractors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np
import xarray as xr

from nonsmooth import System, bifurcation_diagram, regime
from nonsmooth_chapter.judgement import Evidence

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
        ``regime``, ``period`` (zero: none found), ``residual`` and ``per_period`` (mean
        progression over the record). For a periodic motion ``multiplier``, the size of the
        largest. For another one ``exponent`` per period with ``exponent_error``: largest exponent
        and its standard error.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> found = settled_regime(ns.models.moling(b=0.15))
    >>> found["period"], round(found["per_period"], 3)
    (1, 31.345)
    """
    one = regime(system, start, transient=transient, record=record)
    found: Evidence = {
        "regime": one["regime"].item(),
        "period": int(one["period"]),
        "residual": float(one["residual"]),
        "per_period": float(one["v_per_period"]),
    }
    if found["period"]:
        return found | {"multiplier": float(one["multiplier_modulus"].max())}
    length = float(system.period_value or 1.0)
    return found | {
        "exponent": float(one["exponent"]) * length,
        "exponent_error": float(one["exponent_error"]) * length,
    }


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
    b = system.parameter_values["b"]
    columns = bifurcation_diagram(
        system, "b", [b], initial=[dict(start) for start in starts], transient=600, record=400
    )
    found: dict[tuple[int, float], list[float]] = {}
    for lane in columns["lane"].values:
        period = int(columns["period"].sel(lane=lane)[0])
        per_period = float(columns["v_per_period"].sel(lane=lane)[0])
        # progression of an aperiodic motion is an average that scatters
        key = (period, round(per_period, 5) if period else 0.0)
        found.setdefault(key, []).append(per_period)
    return [
        {"period": period, "per_period": float(np.mean(values)), "starts": len(values)}
        for (period, _), values in sorted(found.items())
    ]
