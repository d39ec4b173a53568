"""`count_cycles`: cycles of a load by rainflow counting; `reversals`, where it turns."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.fatigue.checks import Array, check_times, flag, record_values

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["count_cycles", "reversals"]


_CLOSED = 1e-6  # of the range: ends of a block so near are one sample


def reversals(values: npt.ArrayLike) -> npt.NDArray[np.intp]:
    """Places at which a record turns, its two ends included.

    Of equal samples in a row the last one counts, as ASTM E1049 leaves open and as `rainflow`
    does.

    Parameters
    ----------
    values : array_like
        Samples.

    Returns
    -------
    numpy.ndarray
        Indices, increasing.

    Examples
    --------
    >>> from nonsmooth.fatigue import reversals
    >>> reversals([0.0, 1.0, 2.0, 2.0, 1.0, 3.0]).tolist()
    [0, 3, 4, 5]
    """
    return _turning_places(record_values("values", values))


def _turning_places(found: Array) -> npt.NDArray[np.intp]:
    """The same of checked samples."""
    last = np.flatnonzero(np.append(found[1:] != found[:-1], True))
    rising = np.diff(found[last]) > 0.0
    inner = last[1:-1][rising[1:] != rising[:-1]] if last.size > 2 else last[:0]
    return np.concatenate([[0], inner, [found.size - 1]]).astype(np.intp)


def refined(found: Array) -> Array:
    """Samples whose reversals have the values of parabolas through the nearest three samples."""
    inner = _turning_places(found)[1:-1]
    before, at, after = found[inner - 1], found[inner], found[inner + 1]
    bend = before - 2.0 * at + after  # not zero where a record turns
    values = found.copy()
    values[inner] = at - (after - before) ** 2 / (8.0 * bend)
    return values


def count_cycles(
    load: npt.ArrayLike | xr.DataArray,
    times: npt.ArrayLike | None = None,
    *,
    repeating: bool = False,
    refine: bool = False,
) -> xr.Dataset:
    """Cycles of a record by rainflow counting (ASTM E1049, section 5.4.4).

    The record is reduced to its reversals first, which changes nothing in the counts, and these
    are counted by the library `rainflow`.

    Parameters
    ----------
    load : array_like or xarray.DataArray
        Samples, such as ``run["load"]``; a DataArray over ``time`` brings its times and units.
    times : array_like, optional
        Times of the samples, in s; by default their numbers.

    Other Parameters
    ----------------
    repeating : bool, optional
        Whether the record is one block of a load that repeats itself, its last sample at the
        time of the first one of the next block: it is turned to begin at its largest value, and
        every cycle is a whole one (section 5.4.5). Otherwise what is left open at the end counts
        as half cycles.
    refine : bool, optional
        Whether the value at a reversal is that of the parabola through the nearest three
        samples. A sine with n samples in a period is otherwise up to 5/n**2 too small. Not for
        noise.

    Returns
    -------
    xarray.Dataset
        Over ``cycle``: ``range``, ``mean``, ``minimum``, ``maximum``, ``count`` (1 or 0.5), and
        ``start`` and ``end``, the times of the two reversals in the order counted. Attributes:
        ``duration`` of the record, ``n_samples``, ``n_reversals``, ``n_cycles`` (sum of counts)
        and the options.

    Raises
    ------
    OptionError
        For a record that is empty or not finite, with the index, and times that do not increase.

    See Also
    --------
    LoadBlock : cycles as a load that repeats itself, for `life`.

    References
    ----------
    ASTM E1049-85, Standard practices for cycle counting in fatigue analysis.

    Examples
    --------
    The example of the standard:

    >>> import nonsmooth as ns
    >>> cycles = ns.fatigue.count_cycles([-2, 1, -3, 5, -1, 3, -4, 4, -2])
    >>> for size in (3, 4, 6, 8, 9):
    ...     print(size, float(cycles["count"].where(cycles["range"] == size).sum()))
    3 0.5
    4 1.5
    6 0.5
    8 1.0
    9 0.5
    """
    import xarray as xr

    if isinstance(load, xr.DataArray) and times is None and "time" in load.coords:
        times = load["time"].values
    repeating, refine = flag("repeating", repeating), flag("refine", refine)
    values = record_values("load", load)
    clock = None if times is None else check_times(times, values.size)
    if clock is None:
        clock = np.arange(values.size, dtype=float)
    if refine:
        values = _refined(values, repeating)
    order = np.arange(values.size)
    if repeating:
        top = int(np.argmax(values))
        order = np.concatenate([order[top:], order[: top + 1]])
    places = _turning_places(values[order])
    rows = _rainflow(values[order[places]], repeating)
    attrs: dict[str, Any] = {
        "duration": float(clock[-1] - clock[0]),
        "n_samples": int(values.size),
        "n_reversals": int(places.size),
        "n_cycles": float(rows[:, 2].sum()),
        "method": "rainflow counting, ASTM E1049",
        "repeating": int(repeating),
        "refine": int(refine),
    }
    moments = clock[order[places]]
    unit = str(load.attrs.get("units", "")) if isinstance(load, xr.DataArray) else ""
    return _dataset(rows, moments, unit, "s" if times is not None else "samples", attrs)


def _refined(values: Array, repeating: bool) -> Array:
    """Samples with refined reversals, also at the join of a block that closes."""
    if not repeating or abs(values[0] - values[-1]) > _CLOSED * np.ptp(values):
        return refined(values)
    around = refined(np.concatenate([values[:-1], values, values[1:]]))
    return around[values.size - 1 : 2 * values.size - 1]


def _rainflow(values: Array, repeating: bool) -> Array:
    """Rows of range, mean, count, first and last reversal."""
    from rainflow import extract_cycles

    last = values.size - 1
    # the last value once more, for the library has no cycle in two values
    points = [*values.tolist(), float(values[-1])]
    if repeating:
        # a rise from far below to the largest value is never closed, so that no cycle contains
        # the beginning and all of them are whole; it is left out again
        points.insert(0, float(values[0] - 3.0 * np.ptp(values) - 1.0))
    found = np.array([*extract_cycles(points)], dtype=float).reshape(-1, 5)
    found[:, 3:] = np.minimum(found[:, 3:] - int(repeating), last)
    # a record that never changes has two reversals and no cycle
    return found[(found[:, 3] >= 0) & (found[:, 0] > 0.0)]


def _dataset(
    rows: Array, moments: Array, unit: str, time_unit: str, attrs: dict[str, Any]
) -> xr.Dataset:
    import xarray as xr

    size, mean = rows[:, 0], rows[:, 1]
    ends = rows[:, 3:].astype(int)
    columns = {
        "range": (size, "range of the cycle", unit),
        "mean": (mean, "mean of the cycle", unit),
        "minimum": (mean - size / 2.0, "smallest value of the cycle", unit),
        "maximum": (mean + size / 2.0, "largest value of the cycle", unit),
        "count": (rows[:, 2], "cycles counted", ""),
        "start": (moments[ends[:, 0]], "time of the first reversal", time_unit),
        "end": (moments[ends[:, 1]], "time of the second reversal", time_unit),
    }
    return xr.Dataset(
        {
            name: ("cycle", values, {"long_name": text} | ({"units": u} if u else {}))
            for name, (values, text, u) in columns.items()
        },
        attrs=attrs,
    )
