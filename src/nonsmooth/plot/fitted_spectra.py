"""`fit_spectra`: a measured channel, what was fitted to it, and the residual over frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.alignment import marks_of
from nonsmooth.plot.compared_spectra import MEASURED, SpectrumCurve, decibel_label, draw_spectra
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.fitted_records import fitted_channel
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import LINES, PALETTE, axis_label, finish_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["fit_spectra"]

Floats = npt.NDArray[np.float64]

_EVEN = 1e-6  # of a step: samples are even to this part
_FEWEST = 32  # samples
_SEGMENTS = 4  # parts of the record whose power is averaged
_RESIDUAL = PALETTE["blue"]


@checked
def fit_spectra(
    data: xr.Dataset,
    channel: str | None = None,
    *,
    ax: Axes | None = None,
    segments: int | None = None,
) -> Axes:
    """Spectra of a measured channel, of the fitted motion and of the residual, in decibels.

    A residual that is white lies along the dotted line, the level of the noise that was found.
    Peaks of it tell at which frequencies the model misses something. Dashed lines stand at the
    multiples of the frequency of the marks or of the forcing.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `fit`, of a record with even times.
    channel : str, optional
        Channel of the record; the first one by default.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    segments : int, optional
        Parts of the record whose power is averaged; four by default, which overlap by half.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    OptionError
        For another dataset, a channel that was not fitted, uneven times, or too few samples.

    Notes
    -----
    One-sided power densities by Welch's method under Hann windows, of the longest stretch that was
    fitted and has no gap. Decibels are 10 times the decimal logarithm of the density over one unit.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.linspace(0, 10, 200)
    >>> noise = 0.01 * np.random.default_rng(1).standard_normal(t.size)
    >>> record = ns.measured.from_arrays({"x": np.exp(-0.5 * t) + noise}, times=t)
    >>> decay = ns.System(states=["x"], parameters={"k": 1.0}, equations={"x": "-k*x"})
    >>> ax = ns.plot.fit_spectra(ns.fit(decay, record, {"k": (0.1, 2)}))
    >>> [each.get_text() for each in ax.get_legend().get_texts()]
    ['measured', 'residual', 'fitted', 'noise']
    """
    count = _SEGMENTS if segments is None else segments
    if count < 1:
        raise OptionError(f"segments = {count}: give at least 1")
    shown = _longest_stretch(fitted_channel(data, channel))
    step = _step_of(shown["time"].values)
    labels = _labels(data, shown)
    curves = [
        SpectrumCurve(_spectrum(shown[name].values, step, count, labels), name, look)
        for name, look in (
            ("measured", {"color": MEASURED, "linewidth": 1.6}),
            ("residual", {"color": _RESIDUAL, "linewidth": 0.7}),
            ("fitted", {"color": LINES[0]["color"], "linewidth": 0.7}),
        )
    ]
    ax = new_axes() if ax is None else ax
    marks = marks_of(data)
    period = float(np.median(np.diff(marks))) if marks.size > 1 else None
    draw_spectra(curves, "frequency", "power_density", ax, period, n_orders=None)
    level = 10.0 * np.log10(2.0 * step * float(shown["noise"]) ** 2)
    ax.axhline(level, color="0.35", linestyle=":", linewidth=1.0, zorder=3, label="noise")
    finish_axes(ax, axis_label(curves[0].data["frequency"]),
                decibel_label(curves[0].data["power_density"]))  # fmt: skip
    place_legend(ax)
    return ax


def _labels(data: xr.Dataset, shown: xr.Dataset) -> tuple[dict[str, str], dict[str, str]]:
    """Attributes of power density and frequency, with units where the record has times in s."""
    density, frequency = {"long_name": "power density"}, {"long_name": "frequency"}
    if data["time"].attrs.get("units") != "s":
        return density, frequency
    units = str(shown["channel_units"].item()) if "channel_units" in shown else ""
    if units:
        density["units"] = f"({units})^2/Hz" if "/" in units else f"{units}^2/Hz"
    return density, frequency | {"units": "Hz"}


def _longest_stretch(shown: xr.Dataset) -> xr.Dataset:
    """The most samples in a row that were fitted."""
    good = np.isfinite(shown["residual"].values) & ~shown["held_back"].values
    edges = np.flatnonzero(np.diff(np.concatenate([[0], good.astype(int), [0]])))
    begins, ends = edges[::2], edges[1::2]
    if not begins.size or (ends - begins).max() < _FEWEST:
        raise OptionError(
            f"data: a spectrum needs {_FEWEST} samples in a row that were fitted; give a fit of a"
            " longer record"
        )
    longest = int((ends - begins).argmax())
    return shown.isel(time=slice(int(begins[longest]), int(ends[longest])))


def _step_of(times: Floats) -> float:
    step = float(times[-1] - times[0]) / (times.size - 1)
    if np.abs(np.diff(times) - step).max() > _EVEN * step:
        raise OptionError(
            "data: the times of the record are not even, so it has no spectrum; resample it before"
            " the fit"
        )
    return step


def _spectrum(
    values: Floats, step: float, segments: int, labels: tuple[dict[str, str], dict[str, str]]
) -> xr.Dataset:
    from scipy.signal import welch

    # segments that overlap by half: so many of them need (segments + 1) / 2 of their length
    length = max(_FEWEST // 2, min(values.size, 2 * values.size // (segments + 1)))
    frequency, density = welch(values - values.mean(), 1.0 / step, nperseg=length)
    per_density, per_frequency = labels
    return xr.Dataset(
        {"power_density": ("frequency", density[1:], per_density)},
        {"frequency": ("frequency", frequency[1:], per_frequency)},
    )
