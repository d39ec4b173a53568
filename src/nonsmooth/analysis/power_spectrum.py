"""`power_spectrum`: amplitudes and power of a variable over frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.analysis.spectra.segments import (
    check_window,
    record_attributes,
    record_of,
    segments_of,
)
from nonsmooth.analysis.spectra.spectrum_dataset import spectrum_dataset
from nonsmooth.analysis.spectra.transforms import lines_of
from nonsmooth.analysis.statistics.series import is_by_angle
from nonsmooth.runs.options import whole_number

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["power_spectrum"]


def power_spectrum(
    run: xr.Dataset,
    variable: str,
    *,
    transient: float = 0.0,
    window: str = "boxcar",
    segments: int = 1,
) -> xr.Dataset:
    """One-sided amplitude and power spectrum of a variable of a run.

    The samples of a run are exact, and of a run with a period the last whole periods are
    taken, so the harmonics of the forcing fall on bins: amplitudes of a periodic motion are
    its Fourier amplitudes up to aliasing, without leakage.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `simulate` with equidistant samples, or of `measured.synchronous`, whose lines are
        orders: their frequencies are those at the mean speed.
    variable : str
        A state or an output. Of a state with drift the mean progression is taken off first.

    Other Parameters
    ----------------
    transient : float, optional
        What is dropped first, in periods; in units of time for a run without a period.
    window : str, optional
        Name of a window of `scipy.signal.get_window`, such as ``"hann"``, against leakage
        where the motion does not repeat with the record; ``"boxcar"`` is none.
    segments : int, optional
        Parts of the record whose power is averaged: less scatter of a chaotic motion, at a
        coarser resolution.

    Returns
    -------
    xarray.Dataset
        Over ``frequency``, in cycles per unit time: ``amplitude`` of a sine at that frequency,
        the size of the mean at zero, and ``power_density``, whose integral is the mean square.
        With a period ``harmonic`` counts frequencies in that of the forcing. Attributes: ``mean``
        with its sign, of a state with drift that of what is left; ``step`` between samples,
        ``n_samples`` and ``resolution`` of a segment, and the options.

    Raises
    ------
    OptionError
        For an unknown variable or window, samples that are not equidistant, a record that is
        too short, or samples that do not fit into a period a whole number of times.

    See Also
    --------
    full_spectrum : of two variables together, with forward and backward whirl apart.
    waterfall : spectra over a parameter.
    zero_one_test : chaotic or regular.

    Notes
    -----
    Frequencies above half of those of the samples are folded back; take more samples per period
    where amplitudes have not fallen to nothing there. A jump in velocity falls off as one over
    the frequency, one in acceleration as its square.

    Examples
    --------
    A linear oscillator answers a unit force of frequency 2 with the amplitude 1/sqrt(10)
    and nothing else.

    >>> import nonsmooth as ns
    >>> spring = ns.System(
    ...     states=["x", "v"], period="pi", equations={"x": "v", "v": "cos(2*t) - 0.5*v - x"}
    ... )
    >>> spectrum = ns.power_spectrum(ns.simulate(spring, periods=60), "x", transient=50)
    >>> over = spectrum["amplitude"].swap_dims(frequency="harmonic")
    >>> float(over.sel(harmonic=1).round(9))  # 1/sqrt(3**2 + 1)
    0.316227766
    """
    count = whole_number("segments", segments)
    series = record_of(run, variable).after(transient)
    parts = segments_of(series, count)
    length = parts.values.shape[1]
    lines = lines_of(parts.values, check_window(window, length), parts.step)
    attrs = series.attrs | record_attributes(series, parts, window, transient)
    label = series.label["long_name"]
    what, unit = label if label == variable else f"the {label}", series.label.get("units", "")
    time_unit = run["time"].attrs.get("units", "")
    return spectrum_dataset(
        lines, parts.periods, what, unit, time_unit, attrs, by_angle=is_by_angle(run)
    )
