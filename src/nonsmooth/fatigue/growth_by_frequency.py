"""`growth_by_frequency`: which cycles of a load let a crack grow, by their own frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, quote
from nonsmooth.fatigue.checks import number_array, positive, record_values
from nonsmooth.fatigue.closure import NewmanClosure
from nonsmooth.fatigue.growth_laws import GrowthLaw
from nonsmooth.fatigue.growth_rate import StressIntensity, check_law, cycle_growth

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["growth_by_frequency"]


def growth_by_frequency(
    cycles: xr.Dataset,
    stress_intensity: StressIntensity,
    law: GrowthLaw,
    *,
    crack: float,
    edges: npt.ArrayLike,
    closure: str | float | NewmanClosure = "shut",
) -> xr.Dataset:
    """Cycles and growth per s of a load in bands of frequency, at one length of the crack.

    A cycle's own frequency is that of a sine that takes as long from its minimum to its maximum,
    or back: half of the inverse of the time between the two reversals that rainflow counting
    paired. A large cycle may be one that small ones interrupt.

    Parameters
    ----------
    cycles : xarray.Dataset
        Result of `count_cycles` over times, in N.
    stress_intensity : callable
        As of `life`.
    law : Paris, Walker or Forman
        Law of growth.

    Other Parameters
    ----------------
    crack : float
        Length of the crack, mm.
    edges : array_like
        Edges of the bands in Hz, increasing; below and above there are two more bands.
    closure : {"shut", "none"}, float or NewmanClosure, optional
        Part of a cycle that does no work.

    Returns
    -------
    xarray.Dataset
        Over ``band``: ``lowest`` and ``highest`` frequency in Hz, ``cycles_per_second``,
        ``growth`` in mm/s and ``share`` of the growth.

    Raises
    ------
    OptionError
        For edges that do not increase, or another dataset.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.arange(4001) / 2000.0
    >>> load = 100.0 * np.sin(40 * np.pi * t) + 20.0 * np.sin(400 * np.pi * t)
    >>> found = ns.fatigue.growth_by_frequency(
    ...     ns.fatigue.count_cycles(load, t),
    ...     lambda load, crack: 0.02 * load * crack**0.5,
    ...     ns.fatigue.Paris(C=1e-8, m=3.5),
    ...     crack=6.4,
    ...     edges=[50.0],
    ... )
    >>> found["share"].values.round(2).tolist()
    [0.99, 0.01]
    """
    import xarray as xr

    is_data = isinstance(cycles, xr.Dataset)
    if not is_data or "cycle" not in cycles.dims or "duration" not in cycles.attrs:
        raise OptionError(f"cycles = {quote(cycles)}: give a result of count_cycles")
    check_law(law)
    inner = np.atleast_1d(number_array("edges", edges))
    if inner.size > 1:
        inner = record_values("edges", inner)
    if np.any(np.diff(inner) <= 0.0) or not np.all(inner > 0.0):
        raise OptionError("edges must increase and be above zero, in Hz")
    length = np.full(cycles.sizes["cycle"], positive("crack", crack, "mm"))
    both = cycles["minimum"].values, cycles["maximum"].values
    duration, count = float(cycles.attrs["duration"]), cycles["count"].values
    growth = cycle_growth(stress_intensity, law, both, length, closure) * count / duration
    apart = np.abs(cycles["end"].values - cycles["start"].values)
    if cycles.attrs.get("repeating"):
        apart = np.minimum(apart, duration - apart)  # the other way round the join
    frequency = 0.5 / np.maximum(apart, 1e-12 * duration)
    band = np.searchsorted(inner, frequency, side="right")
    total = np.bincount(band, growth, inner.size + 1)
    number = np.bincount(band, count, inner.size + 1) / duration
    bounds = np.concatenate([[0.0], inner, [np.inf]])
    whole = float(total.sum())
    columns = {
        "lowest": (bounds[:-1], "lowest frequency", "Hz"),
        "highest": (bounds[1:], "highest frequency", "Hz"),
        "cycles_per_second": (number, "cycles per second", "1/s"),
        "growth": (total, "crack growth", "mm/s"),
        "share": (total / whole if whole > 0.0 else total, "share of the growth", ""),
    }
    return xr.Dataset(
        {
            name: ("band", values, {"long_name": text} | ({"units": unit} if unit else {}))
            for name, (values, text, unit) in columns.items()
        },
        attrs={"crack": float(crack), "law": repr(law), "duration": duration},
    )
