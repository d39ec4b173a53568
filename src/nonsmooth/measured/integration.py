"""`displacements`: accelerations integrated twice, without drift."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.errors import OptionError
from nonsmooth.measured.acceleration_units import integral_units
from nonsmooth.measured.channel import check_name
from nonsmooth.measured.even_samples import check_even, check_variables, over_time
from nonsmooth.measured.fourier_integral import FourierIntegral
from nonsmooth.measured.noise import noise_before_filters
from nonsmooth.measured.regular_integral import RegularIntegral
from nonsmooth.runs.options import finite_number

__all__ = ["displacements"]

_EDGES = ("keep", "cut")

Floats = npt.NDArray[np.float64]


def displacements(
    data: xr.Dataset,
    accelerations: Mapping[str, str] | str | list[str],
    *,
    lowest: float | None = None,
    bias: float = 0.01,
    period: float | None = None,
    highest: float | None = None,
    drift: int | None = None,
    edges: str = "cut",
) -> xr.Dataset:
    r"""Displacements and velocities from accelerations, by integrating twice without drift.

    An offset of an accelerometer grows with the square of time when it is integrated twice, and
    its noise nearly as fast. What makes the difference is what is known of the displacement: that
    it repeats after a ``period``, or that it has nothing to tell below a ``lowest`` frequency.
    Give one of the two.

    Parameters
    ----------
    data : xarray.Dataset
        Record, or result of `simulate` with equidistant samples.
    accelerations : str, list of str, or mapping of str to str
        Variables to integrate; a mapping gives the name of each displacement. Without it
        ``acceleration1`` gives ``x1``, any other one ``x_`` and its name. Velocities have a ``v``
        in front. Names that the data have already are refused.

    Other Parameters
    ----------------
    lowest : float, optional
        Lowest frequency that is kept, in cycles per unit time (Hz where time is in s).
    bias : float, optional
        Part of a sine of the lowest frequency that is lost; of others it is that over
        (f / lowest)^4 nearly.
    period : float, optional
        Time after which the motion repeats: that of the forcing, or as many times that as the
        motion takes.
    highest : float, optional
        With ``period``: highest harmonic that is fitted, as a frequency; that below half the
        sample rate by default, but at most the hundredth.
    drift : int, optional
        With ``period``: degree of the polynomial in time by which the reading is off; 1 by
        default, 0 where the data hold less than two periods.
    edges : {"cut", "keep"}, optional
        With ``lowest``: whether to cut off either end, where nothing is known of what was before
        or comes after: 3.3 / lowest with a bias of 0.01, 1 / lowest with 0.5. A hundredth of what
        the end does is left behind it.

    Returns
    -------
    xarray.Dataset
        Displacements and velocities over time with the coordinates of the data; the mean of a
        displacement is not known, and zero. Displacements are in the length of the accelerations:
        mm of mm/s^2, m of m/s^2, and m of g, 9.80665 m/s^2, wherever the record comes from; they
        have no units where accelerations have none. Attributes of each displacement:
        ``integral_of``; ``noise_gain``, the standard deviation of its noise for one of 1 in the
        acceleration (white noise; of g: in m/s^2); ``noise``, that times the noise of the
        acceleration, which is estimated;
        and ``lowest`` with ``bias`` and ``edge``, or ``period`` with ``harmonics`` and
        ``residual``, what is not periodic in the acceleration (root mean square). Velocities have
        ``derivative_of``, ``noise_gain`` and ``noise`` likewise.

    Raises
    ------
    OptionError
        For samples that are not equidistant, units that are not those of an acceleration, names
        that are taken, neither or both of ``lowest`` and ``period``, or data that are too short
        for them.

    See Also
    --------
    low_pass : takes off fast noise, which hardly matters here.
    velocities : the other way, from displacements.

    Notes
    -----
    With ``period`` a Fourier series and the polynomial are fitted by least squares, and each
    harmonic is divided by :math:`-\omega^2`. Of a periodic motion and such a drift this is exact
    but for harmonics that the sampling cannot tell. Where the acceleration jumps by J between two
    samples, h apart, it may have done so at any time between them: the displacement is off by up to
    J h T / 16 for each jump in a period T.

    With ``lowest`` the displacement x is what makes :math:`\sum (\ddot x - a)^2 + \omega_c^4 \sum
    x^2` least: the one that follows the acceleration without leaving zero (Lee, Hong and Park).
    It lags behind nothing, needs no initial values, and multiplies a sine by :math:`-\omega^{-2}
    / (1 + (\omega_c/\omega)^4)`; ``lowest`` and ``bias`` give :math:`\omega_c`. Differences are of
    fourth order: besides, a sine of frequency f comes out larger by :math:`(2\pi f h)^4/240` with
    the time h between samples.

    References
    ----------
    H. S. Lee, Y. H. Hong and H. W. Park, Design of an FIR filter for the displacement
    reconstruction using measured acceleration in low-frequency dominant structures, International
    Journal for Numerical Methods in Engineering 82, 403-434 (2010).

    Examples
    --------
    An offset and a drift of the reading do not matter:

    >>> import nonsmooth as ns
    >>> rig = ns.models.fatigue_rig()
    >>> T = rig.period_value
    >>> run = ns.simulate(rig, periods=80, samples_per_period=128).isel(time=slice(6400, None))
    >>> run["reading"] = run["acceleration1"] + 0.5 + 1e-3 * run["time"]
    >>> found = ns.measured.displacements(run, {"reading": "x1"}, period=T)
    >>> away = found["x1"] - (run["X1"] - run["X1"][:-1].mean())
    >>> float(abs(away).max().round(4)), float(abs(run["X1"]).max().round(4))
    (0.0001, 0.8)
    """
    step = check_even(data)
    names = _names(data, accelerations)
    if (lowest is None) == (period is None):
        raise OptionError(
            "give lowest=, the lowest frequency to keep, or period=, after which the motion repeats"
        )
    if edges not in _EDGES:
        raise OptionError(f"edges = {edges!r:.60} must be 'cut' or 'keep'")
    count = data.sizes["time"]
    method: FourierIntegral | RegularIntegral
    if period is not None:
        method = FourierIntegral.design(count, step, period, highest, drift)
    elif highest is not None or drift is not None:
        raise OptionError("highest= and drift= go with period=; filter fast noise by low_pass")
    else:
        method = RegularIntegral.design(count, step, finite_number("lowest", lowest), bias)
    edge = method.edge if edges == "cut" else 0
    part = slice(edge, count - edge)
    found: dict[str, Any] = {}
    rates: dict[str, Any] = {}
    for source, name in names.items():
        units = integral_units(
            source, data[source].attrs.get("units"), data["time"].attrs.get("units")
        )
        values = units.factor * data[source].values.astype(float)
        x, v, words = method(values)
        noise = units.factor * noise_before_filters(data[source])
        about = {"integral_of": source} | words
        costs = [{"noise_gain": gain, "noise": gain * noise} for gain in method.noise_gains]
        words = {"long_name": f"displacement {name}"} | _unit(units.displacement) | about | costs[0]
        found[name] = ("time", x[part], words)
        words = (
            {"long_name": f"velocity of {name}"} | _unit(units.velocity) | {"derivative_of": name}
        )
        rates[f"v{name}"] = ("time", v[part], words | costs[1])
    return over_time(data, found | rates, part)


def _names(data: xr.Dataset, given: Any) -> dict[str, str]:
    """Names of the displacements by those of the accelerations."""
    if isinstance(given, Mapping):
        sources, wanted = list(given), [given[name] for name in given]
    else:
        sources = [given] if isinstance(given, str) else list(given)
        wanted = [
            "x" + name.removeprefix("acceleration")
            if str(name).startswith("acceleration")
            else f"x_{name}"
            for name in sources
        ]
    sources = check_variables(data, sources, "accelerations")
    found: dict[str, str] = {}
    for source, name in zip(sources, wanted, strict=True):
        check_name(name, [*found.values(), *(f"v{other}" for other in found.values())])
        for new in (name, f"v{name}"):
            if new in data.variables:
                raise OptionError(
                    f"accelerations: the data have {new!r} already; call the displacement of"
                    f" {source} otherwise, such as {{{source!r}: {_free(data)!r}}}"
                )
        found[source] = name
    return found


def _free(data: xr.Dataset) -> str:
    """Name of a displacement that is not taken, nor that of its velocity."""
    numbers = itertools.count(1)
    return next(x for x in (f"z{k}" for k in numbers) if not {x, f"v{x}"} & set(data.variables))


def _unit(unit: str) -> dict[str, str]:
    return {"units": unit} if unit else {}
