"""`low_pass`: a record without what is faster than some frequency, and without delay."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.errors import OptionError, is_known, quote
from nonsmooth.measured.even_samples import (
    check_even,
    check_variables,
    noise_before_filters,
    over_time,
)
from nonsmooth.runs.options import finite_number, whole_number

__all__ = ["low_pass"]

_EDGES = ("reflect", "cut")
_SETTLED = 1e-3  # of what an edge does is left within the edge
_FREQUENCIES = 1 << 15  # up to half the sample rate
_REFLECTED = 3  # edges, so that how the filter starts is not felt at all
_MOST_ORDER = 8

Floats = npt.NDArray[np.float64]


def low_pass(
    data: xr.Dataset,
    cutoff: float,
    *,
    variables: str | list[str] | None = None,
    order: int = 4,
    edges: str = "reflect",
) -> xr.Dataset:
    r"""Low-pass filter without delay: a Butterworth filter, forward and backward.

    Parameters
    ----------
    data : xarray.Dataset
        Record, or result of `simulate` with equidistant samples.
    cutoff : float
        Frequency of which 71 % are left (-3 dB), in cycles per unit time: Hz where time is in s.

    Other Parameters
    ----------------
    variables : str or list of str, optional
        What is filtered; all variables by default. Others are left out of the result.
    order : int, optional
        Order of the filter in one direction, 1 to 8; the steeper, the longer its edges.
    edges : {"reflect", "cut"}, optional
        What is done at either end, where the filter lacks samples: they are reflected through the
        last one, with both signs changed; or what this reaches is cut off.

    Returns
    -------
    xarray.Dataset
        The variables with their units, coordinates and attributes; attributes of each variable:
        ``low_pass``, the cut-off frequency, ``low_pass_order``; ``edge``, the time at either
        end which reflection reaches: outside of it less than a thousandth of it is felt;
        ``noise_gain``, what is left of white noise, and ``noise``, that times the noise of the
        samples, which is estimated (standard deviations). The flags of a quality mask, that of
        `flagged`, spread over ``edge`` to either side.

    Raises
    ------
    OptionError
        For a cut-off at or above half the sample rate, samples that are not equidistant, or data
        that are shorter than both edges.

    See Also
    --------
    velocities : filters by itself; what it is given need not be smooth.
    displacements : from accelerations.

    Notes
    -----
    Of a sine of frequency f is left, without any shift in time,

    .. math:: 1 / \left(1 + (\sqrt 2 - 1) (\tan(\pi f h) / \tan(\pi f_c h))^{2 n}\right)

    with the order n and the time h between samples: the square of the response of one direction,
    whose own cut-off lies higher, so that both together leave 71 % at f_c. An impact is smeared
    over about 1 / f_c.

    References
    ----------
    F. Gustafsson, Determining the initial states in forward-backward filtering, IEEE Transactions
    on Signal Processing 44, 988-992 (1996).

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.arange(4000) / 2000.0
    >>> slow, fast = np.cos(100 * t), 0.2 * np.cos(3000 * t)
    >>> record = ns.measured.from_arrays(
    ...     {"x": slow + fast}, times=t, marks=np.arange(31) * np.pi / 50, units="mm"
    ... )
    >>> smooth = ns.measured.low_pass(record, 40.0, edges="cut")
    >>> round(float(abs(smooth["x"] - np.cos(100 * smooth["time"])).max()), 4)
    0.0003
    """
    step = check_even(data)
    names = check_variables(data, variables, "variables")
    top, n = finite_number("cutoff", cutoff), whole_number("order", order)
    if n > _MOST_ORDER:
        raise OptionError(f"order = {n} must be from 1 to {_MOST_ORDER}")
    if not is_known(edges, _EDGES):
        raise OptionError(f"edges = {quote(edges)} must be 'reflect' or 'cut'")
    if top <= 0.0:
        raise OptionError(f"cutoff = {top:g} must be positive")
    if not top * step < 0.5:
        raise OptionError(
            f"cutoff = {top:g} must be below half the sample rate, {0.5 / step:g}: the samples hold"
            " nothing faster, so leave the filter out, give a lower cutoff=, or sample faster"
        )
    sections, edge = _design(top * step, n)
    count = data.sizes["time"]
    if count <= 2 * edge:
        raise OptionError(
            f"the data have {count} samples, and the filter needs more than {2 * edge}; give a"
            " higher cutoff= or a lower order=, or take a longer record"
        )
    part = slice(edge, count - edge) if edges == "cut" else slice(None)
    gain = _noise_gain(sections)
    added = {"low_pass": top, "low_pass_order": n, "edge": edge * step, "noise_gain": gain}
    found: dict[str, Any] = {}
    for name in names:
        words = data[name].attrs | added | {"noise": gain * noise_before_filters(data[name])}
        found[name] = ("time", _filtered(sections, data[name].values, edge)[part], words)
    return over_time(data, found, part, {name: name for name in names}, edge)


def _design(cutoff: float, order: int) -> tuple[Floats, int]:
    """Sections of the filter, and samples after which its slowest part has faded.

    cutoff: of both directions together, in cycles per sample
    """
    from scipy.signal import butter

    share = (math.sqrt(2.0) - 1.0) ** (0.5 / order)
    one = math.atan(math.tan(math.pi * cutoff) / share) / math.pi
    sections = butter(order, 2.0 * one, output="sos")
    poles = butter(order, 2.0 * one, output="zpk")[1]
    slowest = float(np.abs(poles).max())
    if slowest >= 1.0:
        raise OptionError(
            f"cutoff: at {cutoff:g} of the sample rate the filter never settles; give a higher one,"
            " or resample the record first"
        )
    return sections, math.ceil(math.log(_SETTLED) / math.log(slowest)) if slowest > 0.0 else 1


def _noise_gain(sections: Floats) -> float:
    """Of the standard deviation of white noise this is left by both directions."""
    from scipy.signal import sosfreqz

    _, once = sosfreqz(sections, worN=_FREQUENCIES)
    return float(np.sqrt(np.mean(np.abs(once) ** 4)))


def _filtered(sections: Floats, values: npt.ArrayLike, edge: int) -> Floats:
    from scipy.signal import sosfiltfilt

    longest = np.size(values) - 1
    found: Floats = sosfiltfilt(
        sections, values, padtype="odd", padlen=min(_REFLECTED * edge, longest)
    )
    return found
