"""Settled motions of the mole, sweeps over the static force, and windows of period."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import groupby, product

import numpy as np
import xarray as xr

from nonsmooth import System, bifurcation_diagram, regime
from nonsmooth.models import moling
from nonsmooth_chapter.exponents import largest_exponent
from nonsmooth_chapter.judgement import Evidence

__all__ = [
    "AMPLITUDES",
    "CHAOTIC",
    "PROTOCOLS",
    "REST",
    "STARTS",
    "UNSETTLED",
    "Sweep",
    "at_the_end",
    "bounded_states",
    "even_forces",
    "first_fifty",
    "force_sweep",
    "main_window",
    "order_of_labels",
    "primitive_period",
    "regimes_from",
    "settled_labels",
    "settled_regime",
    "stretches",
    "widest",
]


# Which motion a run of the mole settles to: primitive period, its evidence, other attractors.

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


# The mole over its static force: what each column of a diagram settles to, by three protocols.
#
# The chapter prints neither the range of the static force nor how its columns begin. Here b runs
# evenly up to a: above b = a the force never draws the mass off the
# ground. Columns begin at rest, or where the next lower or higher one has ended.

AMPLITUDES = (0.1, 0.3, 0.9)
PROTOCOLS = ("restart", "follow up", "follow down")
CHAOTIC, UNSETTLED = 0, -1
_SPAN = 150  # periods over which an exponent is taken
# where a window begins: columns for one of the diagram, and how far, as a part of the window
_BETWEEN, _BEGINNING = 20, 0.1


@dataclass(frozen=True)
class Sweep:
    """Columns of a diagram of the mole over b, in order of b.

    Parameters
    ----------
    b : numpy.ndarray
        Static forces.
    labels : numpy.ndarray
        Period of each motion, or `CHAOTIC` or `UNSETTLED`.
    per_period : numpy.ndarray
        Settled progression per period.
    exponents : numpy.ndarray
        Largest exponent per period of those without a period, nan elsewhere.

    Examples
    --------
    >>> import numpy as np
    >>> Sweep(np.array([0.1, 0.2]), np.array([1, 0]), np.zeros(2), np.zeros(2)).step
    0.1
    """

    b: np.ndarray
    labels: np.ndarray
    per_period: np.ndarray
    exponents: np.ndarray

    @property
    def step(self) -> float:
        """Distance of neighbouring columns."""
        return float(self.b[1] - self.b[0])


def even_forces(limit: float, columns: int) -> tuple[float, ...]:
    """Static forces from limit/columns to limit.

    Parameters
    ----------
    limit : float
        The largest.
    columns : int
        How many.

    Returns
    -------
    tuple of float

    Examples
    --------
    >>> even_forces(0.4, 4)
    (0.1, 0.2, 0.3, 0.4)
    """
    return tuple(round(limit * (k + 1) / columns, 12) for k in range(columns))


@lru_cache(maxsize=64)
def force_sweep(
    a: float,
    forces: tuple[float, ...],
    start: str = "restart",
    *,
    transient: int = 600,
    record: int = 128,
    xi: float = 0.05,
    omega: float = 0.1,
) -> Sweep:
    """Labels and progression of the mole for many static forces.

    Parameters
    ----------
    a : float
        Amplitude of the force.
    forces : tuple of float
        Static forces, rising.
    start : str, optional
        Protocol, as for `bifurcation_diagram`.
    transient, record : int, optional
        Periods left out and looked at.
    xi, omega : float, optional
        Damping ratio and frequency.

    Returns
    -------
    Sweep

    Examples
    --------
    >>> force_sweep(0.3, (0.1, 0.15), transient=200, record=20).labels
    array([2, 1])
    """
    diagram = bifurcation_diagram(
        moling(a=a, xi=xi, omega=omega), "b", list(forces), start=start, transient=transient,
        record=record,
    )  # fmt: skip
    labels, exponents = settled_labels(diagram, a=a, xi=xi, omega=omega)
    return Sweep(np.array(forces), labels, diagram["v_per_period"].values[:, 0], exponents)


def settled_labels(
    diagram: xr.Dataset, *, a: float, xi: float, omega: float
) -> tuple[np.ndarray, np.ndarray]:
    """Label of each column, with the largest exponent per period of those without a period.

    A motion without a period is chaotic when its exponent is above three standard errors and
    above one over the periods averaged; otherwise it has not settled, as near a bifurcation.

    Parameters
    ----------
    diagram : xarray.Dataset
        Diagram over b, one lane.
    a, xi, omega : float
        Other parameters of the mole.

    Returns
    -------
    labels, exponents : numpy.ndarray

    Examples
    --------
    >>> import nonsmooth as ns
    >>> diagram = ns.bifurcation_diagram(ns.models.moling(), "b", [0.05, 0.15])
    >>> settled_labels(diagram, a=0.3, xi=0.05, omega=0.1)[0]
    array([0, 1])
    """
    labels = diagram["period"].isel(lane=0).values.astype(int)
    exponents = np.full(labels.size, np.nan)
    for i in np.flatnonzero(labels == 0):
        exponents[i], error = largest_exponent(
            moling(a=a, b=float(diagram["parameter"][i]), xi=xi, omega=omega),
            diagram.isel(parameter=i, lane=0, point=-1),
            transient=10,
            record=_SPAN,
        )
        labels[i] = CHAOTIC if exponents[i] > max(3.0 * error, 1.0 / _SPAN) else UNSETTLED
    return labels, exponents


@lru_cache(maxsize=16)
def first_fifty(a: float, forces: tuple[float, ...]) -> np.ndarray:
    """Progression in the first 50 periods from rest, xi = 0.05 and omega = 0.1.

    Parameters
    ----------
    a : float
        Amplitude of the force.
    forces : tuple of float
        Static forces.

    Returns
    -------
    numpy.ndarray

    Examples
    --------
    >>> first_fifty(0.3, (0.1, 0.15)).round()
    array([ 697., 1554.])
    """
    diagram = bifurcation_diagram(moling(a=a), "b", list(forces), transient=0, record=50)
    return 50.0 * diagram["v_per_period"].values[:, 0]


# Windows of periodic motion in a sweep, and the stretches of chaos between them.


def stretches(sweep: Sweep) -> list[Evidence]:
    """Neighbouring columns with chaos, and those without, in order of b.

    Columns that have not settled, as near a period doubling, do not end a window; among them
    alone there is none.

    Parameters
    ----------
    sweep : Sweep
        Columns with labels.

    Returns
    -------
    list of dict
        ``low`` and ``high`` (first and last b), ``columns`` and ``periods`` that occur: none for a
        stretch of chaos.

    Examples
    --------
    >>> import numpy as np
    >>> sweep = Sweep(np.arange(5.0), np.array([0, 2, -1, 1, 0]), np.zeros(5), np.zeros(5))
    >>> [(part["low"], part["high"], part["periods"]) for part in stretches(sweep)]
    [(0.0, 0.0, []), (1.0, 3.0, [1, 2]), (4.0, 4.0, [])]
    """
    labels = sweep.labels.copy()
    for regular, part in _runs(labels != CHAOTIC):
        if regular and all(labels[i] == UNSETTLED for i in part):
            labels[part] = CHAOTIC
    return [
        {
            "low": float(sweep.b[part[0]]),
            "high": float(sweep.b[part[-1]]),
            "columns": len(part),
            "periods": sorted({int(labels[i]) for i in part} - {CHAOTIC, UNSETTLED}),
        }
        for _, part in _runs(labels != CHAOTIC)
    ]


def _runs(flags: Iterable[bool]) -> list[tuple[bool, list[int]]]:
    numbered = enumerate(bool(flag) for flag in flags)
    return [(flag, [i for i, _ in part]) for flag, part in groupby(numbered, lambda pair: pair[1])]


def widest(parts: list[Evidence]) -> Evidence:
    """Widest window of periodic motion.

    Parameters
    ----------
    parts : list of dict
        Result of `stretches`.

    Returns
    -------
    dict

    Examples
    --------
    >>> widest([{"columns": 9, "periods": []}, {"columns": 2, "periods": [1]}])["columns"]
    2
    """
    return max((part for part in parts if part["periods"]), key=lambda part: part["columns"])


def main_window(a: float, sweep: Sweep) -> Evidence:
    """Widest window from rest; it begins behind the last chaos that columns in between show.

    Chaos has room between the columns of a diagram. At a = 0.9 it parts a window of period four at
    b = 0.2025 from that of period one, and the only column there, 0.207, is on a chaotic transient
    of some 1700 periods: rounding says what it looks like after 600.

    Parameters
    ----------
    a : float
        Amplitude of the force.
    sweep : Sweep
        Columns from rest.

    Returns
    -------
    dict
        Part of `stretches`, with another ``low``.

    Examples
    --------
    >>> main_window(0.3, force_sweep(0.3, (0.08, 0.1, 0.15, 0.16)))["periods"]
    [1, 2]
    """
    main = widest(stretches(sweep))
    end = main["low"] + _BEGINNING * (main["high"] - main["low"])
    forces = np.arange(main["low"] - sweep.step, end, sweep.step / _BETWEEN).round(12)
    chaos = np.flatnonzero(force_sweep(a, tuple(forces.tolist())).labels == CHAOTIC)
    first = min(chaos[-1] + 1, forces.size - 1) if chaos.size else 0
    return main | {"low": float(forces[first])}


def order_of_labels(sweep: Sweep) -> list[int]:
    """Labels in order of b, each stretch once, without columns that have not settled.

    Parameters
    ----------
    sweep : Sweep
        Columns with labels.

    Returns
    -------
    list of int

    Examples
    --------
    >>> import numpy as np
    >>> order_of_labels(Sweep(np.arange(5.0), np.array([4, 4, -1, 2, 0]), np.zeros(5), np.zeros(5)))
    [4, 2, 0]
    """
    return [int(label) for label, _ in groupby(sweep.labels[sweep.labels != UNSETTLED])]


def at_the_end(b: float, window: Evidence, step: float) -> bool:
    """Whether b is the upper end of a window, within 2 % or a step of the sweep.

    Parameters
    ----------
    b : float
        Static force.
    window : dict
        Part of `stretches`.
    step : float
        Distance of columns.

    Returns
    -------
    bool

    Examples
    --------
    >>> at_the_end(0.98, {"high": 1.0}, 0.01), at_the_end(0.97, {"high": 1.0}, 0.01)
    (True, False)
    """
    return abs(b - window["high"]) <= max(0.02 * window["high"], step) * (1.0 + 1e-9)
