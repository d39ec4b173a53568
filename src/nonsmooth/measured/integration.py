"""`displacements`: accelerations integrated twice, without drift."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.errors import OptionError, is_known, quote
from nonsmooth.measured.channel import check_name
from nonsmooth.measured.even_samples import (
    check_even,
    check_variables,
    listed,
    noise_before_filters,
    over_time,
)
from nonsmooth.measured.quality.masks import quality_of
from nonsmooth.runs.options import finite_number, whole_number

__all__ = ["displacements"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_G = 9.80665  # m/s^2, standard gravity, exactly
_GRAVITY = ("g", "gn", "g_n")
# such as m/s^2, m/s2, m/s**2, m/s², m/s/s, m s^-2, m s⁻², m·s⁻²
_PER_SQUARE = re.compile(
    r"(?P<length>[^/]+?)\s*(?:/\s*\(?(?P<a>[^\s/^*²)]*[^\s/^*²)\d])\s*(?:\^\s*2|\*\*\s*2|2|²)\)?"
    r"|/\s*(?P<b>[^\s/^*²]+)\s*/\s*(?P=b)"
    r"|[\s·*](?P<c>[^\s/^*²⁻-]+)\s*(?:\^\s*-2|\*\*\s*-2|-2|⁻²))"
)
_RATE_SQUARED = re.compile(r"(.+) (\S+)\^2")  # such as A_b omega^2
_EDGE = 0.01  # of what an end does is left within the edge
_SLOWEST = 7e-5  # cycles per sample; below it rounding is felt
_REFINED = 3  # corrections of the solution
# integral of s^4/(1 + s^4)^2 from 0 to infinity; of s^6 over that it is three times as much
_NOISE = math.pi * math.sqrt(2.0) / 16.0
_MOST = 100  # harmonics by default; what is beyond is divided by its square
_MEMORY = 3 * 10**7  # numbers of a matrix
_WHOLE = 1e-6  # of a period that may lack
_MOST_DRIFT = 5
_EDGES = ("keep", "cut")


class _IntegralUnits(NamedTuple):
    """What readings are multiplied by, and the units of displacements and velocities."""

    factor: float = 1.0
    displacement: str = ""
    velocity: str = ""


def _integral_units(name: str, unit: Any, time: Any) -> _IntegralUnits:
    """Units of the integrals over a time: the length in the unit of the acceleration, m for g.

    Nothing is known of the integrals of what has no unit.
    """
    unit, time = str(unit or "").strip(), str(time or "").strip()
    if unit in ("", "1"):
        return _IntegralUnits()
    if unit in _GRAVITY:
        _check_time(name, unit, time, "s")
        return _IntegralUnits(_G, "m", "m/s")
    found = _PER_SQUARE.fullmatch(unit)
    if found:
        second = found["a"] or found["b"] or found["c"]
        _check_time(name, unit, time, second)
        return _IntegralUnits(1.0, found["length"], f"{found['length']}/{second}")
    scaled = _RATE_SQUARED.fullmatch(unit)
    if scaled and scaled[2] not in (time, "s", "ms"):  # not a length times a time squared
        return _IntegralUnits(1.0, scaled[1], f"{scaled[1]} {scaled[2]}")
    raise OptionError(
        f"accelerations: {name} is in {quote(unit)}, which is no unit of an acceleration; known are"
        " g, lengths over a time squared such as m/s^2 or mm/s^2, and lengths times a rate squared"
        " such as A_b omega^2. Name the right one by units= when it is read (of a Channel, with"
        " its sensitivity), or leave units out"
    )


def _check_time(name: str, unit: str, time: str, second: str) -> None:
    if time not in ("", second):
        raise OptionError(
            f"accelerations: {name} is in {quote(unit)} and the time in {quote(time)}; give the"
            f" time in {second}"
        )


@dataclass(frozen=True)
class _RegularIntegral:
    r"""Solution of :math:`\sum (D x + d - a)^2 + \omega_c^4 \sum x^2 = \min`.

    D are second differences, and d is a straight line.
    """

    count: int
    step: float
    corner: float  # omega_c
    lowest: float
    bias: float
    edge: int

    @classmethod
    def design(cls, count: int, step: float, lowest: float, bias: Any) -> _RegularIntegral:
        """Integral that loses ``bias`` of a sine of the lowest frequency."""
        lost = finite_number("bias", bias)
        if not 0.0 < lost < 1.0:
            raise OptionError(f"bias = {lost:g} must lie between 0 and 1")
        if not 0.0 < lowest * step < 0.25:
            raise OptionError(
                f"lowest = {lowest:g} must be positive and below a quarter of the sample rate,"
                f" {0.25 / step:g}"
            )
        corner = 2.0 * math.pi * lowest * (lost / (1.0 - lost)) ** 0.25
        if corner * step < 2.0 * math.pi * _SLOWEST:
            raise OptionError(
                f"lowest = {lowest:g} with bias = {lost:g} is too low for {1 / step:g} samples per"
                " unit time; take every second sample or less after low_pass, or give a higher"
                " lowest= or more bias="
            )
        # what an end does fades as exp(-corner t / sqrt(2))
        edge = math.ceil(-math.log(_EDGE) * math.sqrt(2.0) / (corner * step))
        if count <= 2 * edge:
            raise OptionError(
                f"lowest = {lowest:g}: the data last {count * step:g}, and {2 * edge * step:.4g} of"
                " them are not sure at the ends; take a longer record, or give a higher lowest="
                " or more bias="
            )
        return cls(count, step, corner, lowest, lost, edge)

    @property
    def noise_gains(self) -> tuple[float, float]:
        """Of white noise in the acceleration this is left in displacement and velocity."""
        frequency, density = self.corner / (2.0 * math.pi), 2.0 * self.step
        x = math.sqrt(density * _NOISE / frequency**3) / (2.0 * math.pi) ** 2
        v = math.sqrt(density * 3.0 * _NOISE / frequency) / (2.0 * math.pi)
        return x, v

    def __call__(self, values: Floats, good: Mask | None) -> tuple[Floats, Floats, dict[str, Any]]:
        """Displacement and velocity at the samples; bad ones are felt about themselves only."""
        # an offset and a drift do nothing but at the ends, where they would be large
        away = values - self._trend(values, good)
        x = self._integrated(away)
        v = np.gradient(x, self.step, edge_order=2)
        v[1:-1] -= self.step / 12.0 * (away[2:] - away[:-2])
        words = {"lowest": self.lowest, "bias": self.bias, "edge": self.edge * self.step}
        return x, v, words

    @cached_property
    def _factor(self) -> Floats:
        """Banded Cholesky factor of the equations of the displacement."""
        from scipy.linalg import cholesky_banded

        bands = _bands(self.count)
        bands[0] += self._weight
        factor: Floats = cholesky_banded(bands, lower=True)
        return factor

    @property
    def _weight(self) -> float:
        return (self.corner * self.step) ** 4

    def _integrated(self, values: Floats) -> Floats:
        """The displacement of accelerations."""
        from scipy.linalg import cho_solve_banded

        wanted, x = _numerov(values, self.step), np.zeros(values.size)
        for _ in range(_REFINED):
            left = wanted - np.diff(x, 2)
            x += cho_solve_banded((self._factor, True), _transposed(left) - self._weight * x)
        return x

    def _trend(self, values: Floats, good: Mask | None) -> Floats:
        """The straight line by which a reading is off: with it the sum of squares is least.

        It is found together with the displacement, which follows the motion, so that a period that
        is not whole does not count as drift. It is felt at the ends only: the sum of squares has
        no other displacement of a straight line than zero, far from them.
        """
        number = np.arange(values.size)
        if good is not None and good.any():
            values = np.interp(number, number[good], values[good])
        mean = values.mean()
        lines = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, values.size), 1)
        left = [self._left(line) for line in lines.T]
        wanted = _numerov(values - mean, self.step)
        own = np.array([_numerov(line, self.step) for line in lines.T])
        shares = np.linalg.solve(own @ np.transpose(left), np.array(left) @ wanted)
        trend: Floats = mean + lines @ shares
        return trend

    def _left(self, values: Floats) -> Floats:
        """What the displacement of accelerations does not follow, in second differences."""
        return _numerov(values, self.step) - np.diff(self._integrated(values), 2)


def _numerov(values: Floats, step: float) -> Floats:
    """Second differences that a displacement should have: means of accelerations, 1, 10, 1."""
    found: Floats = step**2 / 12.0 * (values[:-2] + 10.0 * values[1:-1] + values[2:])
    return found


def _bands(count: int) -> Floats:
    """D^T D of second differences, its diagonal and the two below."""
    bands = np.zeros((3, count))
    rows = np.ones(count - 2)
    for k, c in enumerate((1.0, -2.0, 1.0)):
        bands[0, k : k + count - 2] += c * c * rows
    for k in range(2):
        bands[1, k : k + count - 2] += -2.0 * rows
    bands[2, : count - 2] += rows
    return bands


def _transposed(values: Floats) -> Floats:
    """D^T of values."""
    found = np.zeros(values.size + 2)
    found[:-2] += values
    found[1:-1] -= 2.0 * values
    found[2:] += values
    return found


@dataclass(frozen=True)
class _FourierIntegral:
    """Fit of harmonics and of a polynomial to samples."""

    angle: Floats  # of the fundamental at the samples
    rate: float  # angular frequency of the fundamental
    harmonics: int
    drift: int  # degree
    edge: int = 0

    @classmethod
    def design(
        cls, count: int, step: float, period: Any, highest: Any, drift: Any
    ) -> _FourierIntegral:
        """Fit for some number of samples."""
        length = finite_number("period", period)
        if length <= 0.0:
            raise OptionError(f"period = {length:g} must be positive")
        periods = count * step / length
        if periods < 1.0 - _WHOLE:
            raise OptionError(
                f"period = {length:g} is longer than the data, {count * step:g}; give lowest= for a"
                " motion that does not repeat, or take a longer record"
            )
        degree = (1 if periods >= 2.0 - _WHOLE else 0) if drift is None else drift
        if degree not in range(_MOST_DRIFT + 1):
            raise OptionError(f"drift = {quote(drift)} must be a whole number from 0 to 5")
        if degree and periods < 2.0 - _WHOLE:
            raise OptionError("drift: it cannot be told from a motion in less than two periods")
        fastest = math.ceil(0.5 * length / step * (1.0 - 1e-9)) - 1  # below half the sample rate
        if fastest < 1:
            raise OptionError(
                f"period = {length:g} holds {length / step:.3g} samples; sample faster"
            )
        wanted = min(fastest, _MOST)
        if highest is not None:
            wanted = math.floor(finite_number("highest", highest) * length * (1.0 + 1e-9))
            if not 1 <= wanted <= fastest:
                raise OptionError(
                    f"highest = {highest:g} must be from 1 / period = {1 / length:g} to below half"
                    f" the sample rate, {0.5 / step:g}"
                )
        if count * (2 * wanted + degree + 1) > _MEMORY:
            raise OptionError(
                f"{wanted} harmonics in {count} samples are too many to fit; give a lower highest=,"
                " or a part of the data"
            )
        angle = 2.0 * math.pi / length * step * np.arange(count, dtype=np.float64)
        angle -= 0.5 * angle[-1]
        return cls(angle, 2.0 * math.pi / length, whole_number("harmonics", wanted), int(degree))

    @property
    def noise_gains(self) -> tuple[float, float]:
        """Of white noise in the acceleration this is left in displacement and velocity."""
        frequencies = self.rate * np.arange(1, self.harmonics + 1)
        share = 2.0 / self.angle.size
        x, v = (math.sqrt(share * float((frequencies**-power).sum())) for power in (4.0, 2.0))
        return x, v

    @cached_property
    def _fit(self) -> tuple[Floats, Floats, npt.NDArray[np.complex128]]:
        """Q and R of what is fitted, and the harmonics at the samples."""
        turns = np.exp(1j * np.outer(self.angle, np.arange(1, self.harmonics + 1)))
        place = self.angle / max(float(np.abs(self.angle).max()), 1e-300)
        drifts = np.polynomial.legendre.legvander(place, self.drift)
        q, r = np.linalg.qr(np.hstack([drifts, turns.real, turns.imag]))
        return q, r, turns

    def __call__(self, values: Floats, good: Mask | None) -> tuple[Floats, Floats, dict[str, Any]]:
        """Displacement and velocity at the samples; only the good ones are fitted."""
        from scipy.linalg import solve_triangular

        q, r, turns = self._fit
        orders = np.arange(1, self.harmonics + 1)
        if good is None or good.all():
            shares = values @ q
            left = values - q @ shares
        else:
            _check_enough(int(good.sum()), q.shape[1])
            shares = np.asarray(np.linalg.lstsq(q[good], values[good], rcond=None)[0], dtype=float)
            left = values[good] - q[good] @ shares
        found = solve_triangular(r, shares)
        real, imaginary = np.split(found[self.drift + 1 :], 2)
        amplitude = (real - 1j * imaginary) / (1j * self.rate * orders)  # of the velocity
        velocity = (turns @ amplitude).real
        displacement = (turns @ (amplitude / (1j * self.rate * orders))).real
        words = {
            "period": 2.0 * math.pi / self.rate,
            "harmonics": self.harmonics,
            "residual": float(np.sqrt(np.mean(left * left))),
        }
        return displacement, velocity, words


def _check_enough(good: int, unknown: int) -> None:
    if good < 2 * unknown:
        raise OptionError(
            f"{good} samples are left without a flaw, too few to fit {unknown} numbers; give a"
            " lower highest=, or a part of the data"
        )


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
        the end does is left behind it. An offset of the reading and a straight drift do nothing
        there; a slower change of another form, by which the reading at the end is off by e, does
        about :math:`e/\omega_c^2`, see the notes.

    Returns
    -------
    xarray.Dataset
        Displacements and velocities over time with the coordinates of the data; the mean of a
        displacement is not known, and zero. Displacements are in the length of the accelerations:
        mm of mm/s^2, m of m/s^2, and m of g, 9.80665 m/s^2, wherever the record comes from; they
        have no units where accelerations have none. Attributes of each displacement:
        ``integral_of``; ``noise_gain``, the standard deviation of its noise for one of 1 in the
        acceleration (white noise; of g: in m/s^2); ``noise``, that times the noise of the
        acceleration, which is estimated, and neither what is lost by ``bias`` nor what an end
        leaves;
        and ``lowest`` with ``bias`` and ``edge``, or ``period`` with ``harmonics`` and
        ``residual``, what is not periodic in the acceleration (root mean square). Velocities have
        ``derivative_of``, ``noise_gain`` and ``noise`` likewise. The flags of a quality mask,
        that of `flagged`, spread with ``lowest`` over two edges to either side, behind which a
        ten-thousandth of what a flaw does is left; with ``period`` flagged samples are left out of
        the fit.

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

    With ``lowest`` the displacement x and a straight line d, the offset and the drift of the
    reading, are what makes :math:`\sum (\ddot x + d - a)^2 + \omega_c^4 \sum x^2` least: the one
    that follows the acceleration without leaving zero (Lee, Hong and Park). The line is felt near
    the ends only. The displacement lags behind nothing, needs no initial values, and multiplies a
    sine by :math:`-\omega^{-2} / (1 + (\omega_c/\omega)^4)`; ``lowest`` and ``bias`` give
    :math:`\omega_c = 2\pi\, lowest\, (bias/(1 - bias))^{1/4}`. Differences are of fourth order:
    besides, a sine of frequency f comes out larger by :math:`(2\pi f h)^4/240` with the time h
    between samples.

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
    if not is_known(edges, _EDGES):
        raise OptionError(f"edges = {quote(edges)} must be 'cut' or 'keep'")
    count = data.sizes["time"]
    method: _FourierIntegral | _RegularIntegral
    if period is not None:
        method = _FourierIntegral.design(count, step, period, highest, drift)
    elif highest is not None or drift is not None:
        raise OptionError("highest= and drift= go with period=; filter fast noise by low_pass")
    else:
        method = _RegularIntegral.design(count, step, finite_number("lowest", lowest), bias)
    edge = method.edge if edges == "cut" else 0
    part = slice(edge, count - edge)
    found: dict[str, Any] = {}
    rates: dict[str, Any] = {}
    for source, name in names.items():
        units = _integral_units(
            source, data[source].attrs.get("units"), data["time"].attrs.get("units")
        )
        values = units.factor * data[source].values.astype(float)
        flags = quality_of(data, source)
        x, v, words = method(values, None if flags is None else flags == 0)
        noise = units.factor * noise_before_filters(data[source])
        about = {"integral_of": source} | words
        costs = [{"noise_gain": gain, "noise": gain * noise} for gain in method.noise_gains]
        words = {"long_name": f"displacement {name}"} | _unit(units.displacement) | about | costs[0]
        found[name] = ("time", x[part], words)
        words = (
            {"long_name": f"velocity of {name}"} | _unit(units.velocity) | {"derivative_of": name}
        )
        rates[f"v{name}"] = ("time", v[part], words | costs[1])
    sources = {name: source for source, name in names.items()}
    sources |= {f"v{name}": source for name, source in sources.items()}
    # behind one edge a hundredth of what a flaw does is left, behind two of them a ten-thousandth
    return over_time(data, found | rates, part, sources, 2 * method.edge)


def _names(data: xr.Dataset, given: Any) -> dict[str, str]:
    """Names of the displacements by those of the accelerations."""
    if isinstance(given, Mapping):
        sources, wanted = list(given), [given[name] for name in given]
    else:
        sources = listed(given, "accelerations")
        wanted = [
            "x" + str(name).removeprefix("acceleration")
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
