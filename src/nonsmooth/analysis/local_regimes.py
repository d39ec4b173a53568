"""`local_regimes`: which period a slowly changing motion has, point by point."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.options import derived_attributes
from nonsmooth.analysis.regimes.stretches import (
    LEAST_VISITS,
    local_periods,
    period_words,
    stretch_columns,
)
from nonsmooth.analysis.regimes.strobe_points import StrobePoints, strobe_points
from nonsmooth.analysis.statistics.sizes_by_rates import AT_REST
from nonsmooth.errors import OptionError, is_known, unknown_name
from nonsmooth.runs.options import finite_number, whole_number

__all__ = ["local_regimes"]

_VISITS = 10  # of each branch of the longest period in a window, by default
_FLOOR = 1e-6  # of the size of a variable: a spread below it is none
_TINY = 1e-9  # of the largest value, points that lie apart from all others included
_FEW, _SHARE = 3, 1000  # points at either end of the range that may lie apart: of any, of so many
_FAR = 10.0  # times the range of all others is apart
_MOST = 1000  # visits and periods; a longer window is no local one

Floats = npt.NDArray[np.float64]


def local_regimes(
    data: Any,
    *,
    window: int | None = None,
    most_period: int = 12,
    tolerance: float = 1e-3,
    variables: str | list[str] | None = None,
    parameter: str | None = None,
) -> xr.Dataset:
    """Tell the period of a slowly changing motion at each of its strobes.

    A motion whose parameters change slowly settles to nothing: its strobes drift, and now and
    then its regime changes. Over a window of strobes it has period n when each of the n
    interleaved sequences of points lies on a straight line, and n is the least such number.

    Parameters
    ----------
    data : xarray.Dataset or array
        Result of `simulate` with one sample per period (of more, those with the phase of the last
        one count), or with ``times`` at multiples of the period where parameters change within
        the equations; result of `stroboscopic_map` or `poincare_section`; numbers in order, or
        points as rows of an array.

    Other Parameters
    ----------------
    window : int, optional
        Strobes of a window; ten times ``most_period`` by default, four times at least.
    most_period : int, optional
        Longest period that is looked for.
    tolerance : float, optional
        What lines may leave of each branch (root mean square), as a part of the spread of each
        variable over all of the data.
    variables : str or list of str, optional
        What must repeat; all states by default, but those that drift. Angles of the system of a run
        repeat up to whole turns.
    parameter : str, optional
        Variable of the data to tell where each stretch begins and ends; by default the parameters
        that vary slowly in the run.

    Returns
    -------
    xarray.Dataset
        ``period`` over the strobes, with ``time`` and the parameters as coordinates: 0 where the
        motion has none within ``most_period``, as where it is chaotic or settles anew. Over
        ``stretch``, one row for each stretch of one period: ``first`` and ``last`` (numbers of
        points), ``from_time`` and ``to_time``, likewise of each parameter (such as
        ``from_crack``), ``stretch_period``, and ``regime``, 'periodic' or 'aperiodic'; ``drift``,
        the way that the branches take within the stretch, and ``net_drift``, the distance from
        its begin to its end, both on the average over branches and in parts of the spread.
        `to_dataframe` of those makes a table.

    Raises
    ------
    OptionError
        For an option out of its range, data shorter than a window or not finite.

    See Also
    --------
    regime : what a motion settles to while nothing changes, with exponents as evidence.
    bifurcation_diagram : settled motions over a parameter.

    Notes
    -----
    A point has the least period of all windows that hold it, so labels reach up to the change of
    a regime, and windows with a jump inside have none. What the label says and what it cannot:

    - Branches closer than twice ``tolerance``, in parts of the spread, are one: a period-doubled
      motion has its period from where its branches are farther apart. The label of the shorter
      period lasts a little longer in turn.
    - After a change the motion settles by its multipliers, at 1000 strobes where their modulus is
      0.993. Meanwhile it has no period, unless it settles along a line, where one real multiplier
      is near 1: then it has the period that it settles to. A multiplier near -1 makes points
      alternate; those are not taken for a doubled period while their distance changes by more than
      half within a window. So a doubled period lacks about a window where its branches part or
      merge.
    - 0 does not mean chaos: it may be a longer period, a quasi-periodic motion, or one that drifts
      too quickly for a line through a window. A shorter ``window`` tells the last one.
    - In a shorter window a chaotic motion may pass for periodic, while it stays close to an
      unstable periodic orbit or passes a fold that is about to happen.

    - A slow quasi-periodic motion looks like a drift: points that turn by 1/3 + 1e-4 per strobe
      move on, within a window, as a slowly drifting motion of period three does. In a long stretch
      ``drift`` tells: it is as large as the spread or larger although the parameter hardly
      changes, and larger than ``net_drift`` where branches turn back although the parameter does
      not. A longer ``window`` takes the label away. One of 1e-3 per strobe alternates between 1
      where it turns back and 0 between.

    The spread counts what a transient at the beginning adds; leave that out by
    ``data.isel(time=slice(100, None))``. A few points that lie apart by more than ten times the
    range of all others, up to a thousandth of them, or three, do not count.

    Examples
    --------
    A logistic map whose parameter grows through its period doubling at 3. The motion stays at the
    fixed point for a while, as it takes time to leave it:

    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> a, x = np.linspace(2.8, 3.4, 6000), [9 / 14]
    >>> for k in range(5999):
    ...     x.append(a[k] * x[-1] * (1 - x[-1]))
    >>> found = ns.local_regimes(x)
    >>> found["stretch_period"].values
    array([1, 0, 2])
    >>> a[found["first"].values].round(2)
    array([2.8 , 3.08, 3.08])
    """
    points = strobe_points(data, variables)
    most = _whole("most_period", most_period)
    length = _VISITS * most if window is None else _whole("window", window, _MOST * most)
    if length < LEAST_VISITS * most:
        raise OptionError(
            f"window = {length} must hold {LEAST_VISITS} visits of each branch, {LEAST_VISITS} *"
            f" most_period = {LEAST_VISITS * most} strobes; give a longer window= or a smaller"
            " most_period="
        )
    if len(points.values) < length:
        raise OptionError(
            f"data: {len(points.values)} strobes are less than a window of {length}; take a longer"
            " run, or give a smaller most_period="
        )
    allowed = finite_number("tolerance", tolerance)
    if not 0.0 < allowed < 1.0:
        raise OptionError(f"tolerance = {allowed:g} must lie between 0 and 1")
    scaled = _scaled(points.values, AT_REST * points.natural)
    periods = local_periods(scaled, length, most, allowed)
    names = _parameters(points, parameter)
    columns = stretch_columns(points, periods, names, scaled, length)
    return _dataset(points, periods, columns, names, {
        "window_length": length, "most_period": most, "tolerance": allowed,
    })  # fmt: skip


def _whole(name: str, value: Any, most: int = _MOST) -> int:
    number = whole_number(name, value)
    if number > most:
        raise OptionError(f"{name} = {number} must be {most} at most")
    return number


def _scaled(values: Floats, rounding: Floats) -> Floats:
    """Points in units of the spread of each variable; one that rests does not count.

    rounding: (d,), spreads that are those of a state at rest
    """
    low, high = _range(values)
    spread = high - low
    unit = np.maximum(spread, _FLOOR * np.maximum(np.abs(low), np.abs(high)))
    unit = np.maximum.reduce([unit, _TINY * np.abs(values).max(axis=0), rounding])
    scaled: Floats = (values - (low + 0.5 * spread)) / np.where(unit > 0.0, unit, 1.0)
    return scaled


def _range(values: Floats) -> tuple[Floats, Floats]:
    """Range of each variable, without a few points that lie far away from all others.

    One reading that went wrong must not make the rest look as if it rested. What settles is no
    such thing: its points lie closer and closer.
    """
    count = len(values)
    few = min(max(_FEW, count // _SHARE), count // 10)
    if few == 0:
        return values.min(axis=0), values.max(axis=0)
    ordered = np.partition(values, (few, count - 1 - few), axis=0)
    low, high = ordered[few], ordered[count - 1 - few]
    room = _FAR * (high - low)
    near = (values >= low - room) & (values <= high + room)
    return (
        np.where(near, values, np.inf).min(axis=0),
        np.where(near, values, -np.inf).max(axis=0),
    )


def _parameters(points: StrobePoints, parameter: str | None) -> list[str]:
    if parameter is None:
        return list(points.slow)
    known = [str(n) for n, v in points.data.variables.items() if v.dims == (points.dim,)]
    if not is_known(parameter, known):
        raise OptionError(f"parameter: {unknown_name('variable', parameter, known)}")
    return [parameter] if parameter != "time" else []


def _dataset(
    points: StrobePoints,
    periods: npt.NDArray[np.int64],
    columns: dict[str, Any],
    parameters: list[str],
    used: dict[str, Any],
) -> xr.Dataset:
    wanted = ("time", "period_number", *parameters)
    coords = {
        n: points.data[n].variable
        for n in wanted
        if n in points.data and points.data[n].dims == (points.dim,)
    }
    attrs = derived_attributes(points.data, "period", "speed")
    attrs["variables"] = ", ".join(points.names)
    return xr.Dataset(
        {"period": (points.dim, periods, period_words()), **columns}, coords, attrs | used
    )
