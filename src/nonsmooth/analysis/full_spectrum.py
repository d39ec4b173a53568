"""`full_spectrum`: forward and backward parts of a motion in a plane, over frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.analysis.spectra.segments import (
    check_window,
    record_attributes,
    record_of,
    segments_of,
)
from nonsmooth.analysis.spectra.spectrum_dataset import check_plane, plane_label, spectrum_dataset
from nonsmooth.analysis.spectra.transforms import lines_of
from nonsmooth.analysis.statistics.series import is_by_angle
from nonsmooth.runs.options import whole_number

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["full_spectrum"]


def full_spectrum(
    run: xr.Dataset,
    x: str,
    y: str,
    *,
    transient: float = 0.0,
    window: str = "boxcar",
    segments: int = 1,
) -> xr.Dataset:
    """Amplitude and power spectrum of x + iy over positive and negative frequencies.

    A circle that is passed from x towards y, as a rotor turns, has one line at its positive
    frequency, as high as its radius; the same circle passed backward has it at the negative
    one. An ellipse has both: its half axes are their sum and their difference.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `simulate` with equidistant samples.
    x, y : str
        States or outputs: the two coordinates of a motion in a plane, in the same units.

    Other Parameters
    ----------------
    transient : float, optional
        What is dropped first, in periods; in units of time for a run without a period.
    window : str, optional
        As in `power_spectrum`.
    segments : int, optional
        As in `power_spectrum`.

    Returns
    -------
    xarray.Dataset
        Over ``frequency``, in cycles per unit time, from the lowest negative one on:
        ``amplitude``, the radius of the circle that turns at that frequency, the distance of
        the mean from the origin at zero, and ``power_density``, whose integral is the mean of
        x² + y². With a period ``harmonic`` counts frequencies in that of the forcing, as orders of
        a rotor's speed.
        Attributes as of `power_spectrum`; ``mean`` is that of x, ``second_mean`` that of y.

    Raises
    ------
    OptionError
        As of `power_spectrum`, or where x and y differ in their units.

    See Also
    --------
    power_spectrum : of one variable; it does not tell forward from backward.
    waterfall : spectra over a parameter.

    References
    ----------
    P. Goldman and A. Muszynska, Application of full spectrum to rotating machinery diagnostics,
    Orbit, First Quarter 1999, 17-21.

    Examples
    --------
    A shaft whirls forward only, on springs that differ also backward:

    >>> import nonsmooth as ns
    >>> shaft = ns.System(
    ...     states=["x", "y", "u", "v"],
    ...     parameters={"k": 1.5},
    ...     period="pi",
    ...     equations={
    ...         "x": "u",
    ...         "y": "v",
    ...         "u": "cos(2*t) - 0.5*u - x",
    ...         "v": "sin(2*t) - 0.5*v - k*y",
    ...     },
    ... )
    >>> for k in (1.0, 1.5):
    ...     run = ns.simulate(shaft, periods=60, parameters={"k": k})
    ...     over = ns.full_spectrum(run, "x", "y", transient=50)["amplitude"]
    ...     over.swap_dims(frequency="harmonic").sel(harmonic=[-1, 1]).values.round(6) + 0.0
    array([0.      , 0.316228])
    array([0.029361, 0.343662])
    """
    count = whole_number("segments", segments)
    series = [record_of(run, name).after(transient) for name in (x, y)]
    names = check_plane((x, y), (x, y), lambda name: series[(x, y).index(name)].label)
    first, second = (segments_of(one, count) for one in series)
    length = first.values.shape[1]
    values = first.values + 1j * second.values
    lines = lines_of(values, check_window(window, length), first.step)
    attrs = series[0].attrs | record_attributes(series[0], first, window, transient)
    attrs |= {"variable": x, "second_variable": y, "second_mean": float(second.values.mean())}
    what, unit = plane_label(names, ""), series[0].label.get("units", "")
    time_unit = run["time"].attrs.get("units", "")
    return spectrum_dataset(
        lines, first.periods, what, unit, time_unit, attrs, by_angle=is_by_angle(run)
    )
