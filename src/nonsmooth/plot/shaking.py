"""`shaking`: a record of base acceleration and its spectrum."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, quote
from nonsmooth.plot.figures import print_figure
from nonsmooth.plot.style import LINES, PALETTE, axis_label, finish_axes
from nonsmooth.runs.options import positive_number

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["shaking"]

_FLOOR = 1e-6  # of the largest line


@checked
def shaking(
    record: xr.Dataset,
    variable: str = "acceleration",
    *,
    axes: Sequence[Axes] | None = None,
    span: float | None = None,
    highest: float | None = None,
) -> list[Axes]:
    """Record over time, and its power density over frequency.

    Parameters
    ----------
    record : xarray.Dataset
        ``to_dataset()`` of a record of `excitation`, or any dataset with even times.
    variable : str, optional
        What to draw.
    axes : sequence of matplotlib.axes.Axes, optional
        Two axes, for the record and the spectrum; a new figure of two columns' width by default.
    span : float, optional
        Length of the record that is drawn over time, from its beginning; half a second by default.
    highest : float, optional
        Highest frequency drawn; by default that below which lie 99.9 % of the power, and some.

    Returns
    -------
    list of matplotlib.axes.Axes
        Both; a dashed line stands at the strongest frequency.

    Raises
    ------
    OptionError
        For a dataset without the variable, uneven times, a number of axes that is not two, or a
        span with less than two samples.

    Notes
    -----
    The density is that of Welch's method with segments of an eighth of the record under Hann
    windows, so that its scatter is small; harmonic lines are as wide as a segment resolves.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> sine = ns.excitation.harmonic(20.0, 3.0, duration=4.0)
    >>> time, frequency = ns.plot.shaking(sine.to_dataset())
    >>> float(round(frequency.lines[0].get_xdata()[0], 6))
    20.0
    """
    if "time" not in record.dims or variable not in record:
        raise OptionError(f"variable: the record has no {quote(variable)} over time")
    times, values = record["time"].values, record[variable].values
    if times.size < 2:
        raise OptionError(f"record: {times.size} samples make no record; give two at least")
    step = float(times[-1] - times[0]) / (times.size - 1)
    if np.abs(np.diff(times) - step).max() > 1e-6 * step:
        raise OptionError("the times are not even; resample the record first")
    if axes is None:
        _, axes = print_figure(1, 2, width=16.0)
    if len(axes) != 2:
        raise OptionError(f"{len(axes)} axes came; a record and its spectrum need two")
    first, second = axes
    length = max(0.5, step) if span is None else positive_number("span", span)
    shown = times <= times[0] + length
    if shown.sum() < 2:
        raise OptionError(f"span = {length:g} holds one sample; they are {step:g} apart")
    first.plot(times[shown], values[shown], **LINES[0] | {"linewidth": 0.7})
    first.set_xlim(times[shown][0], times[shown][-1])
    finish_axes(first, axis_label(record["time"]), axis_label(record[variable]))
    _spectrum(second, values, step, highest)
    unit = str(record[variable].attrs.get("units", ""))
    finish_axes(
        second, "frequency [Hz]", f"power density [({unit})²/Hz]" if unit else "power density"
    )
    return [first, second]


def _spectrum(ax: Axes, values: np.ndarray, step: float, highest: float | None) -> None:
    from scipy.signal import welch

    frequency, density = welch(
        values - values.mean(), 1.0 / step, nperseg=max(16, values.size // 8), detrend=False
    )
    total = np.cumsum(density) / density.sum()
    if highest is None:
        highest = 1.3 * float(frequency[np.searchsorted(total, 0.999)])
    kept = (frequency > 0.0) & (frequency <= max(float(highest), 4 * frequency[1]))
    top = frequency[kept][np.argmax(density[kept])]
    ax.axvline(float(top), color=PALETTE["sky"], linestyle="--", linewidth=0.6, zorder=0)
    floor = _FLOOR * float(density.max())
    ax.semilogy(frequency[kept], np.maximum(density[kept], floor), **LINES[0] | {"linewidth": 0.7})
    ax.set_xlim(0.0, float(frequency[kept][-1]))
