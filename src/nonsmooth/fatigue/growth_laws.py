"""Laws of fatigue crack growth: growth in a cycle by the range of stress intensity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, quote
from nonsmooth.fatigue.checks import Array, finite, number_array, positive, same_shape

__all__ = ["Forman", "GrowthLaw", "Paris", "Walker"]


class GrowthLaw(Protocol):
    """What `life` asks of a law."""

    @property
    def source(self) -> str:
        """Where the constants come from."""
        ...

    def rate(self, delta_K: Any, R: Any = 0.0) -> Array:
        """Growth in mm per cycle."""
        ...


@dataclass(frozen=True)
class Paris:
    r"""Paris' law :math:`da/dN = C\,\Delta K^m`, whatever the load ratio.

    Parameters
    ----------
    C : float
        Growth in mm per cycle at a range of 1 MPa sqrt(m).
    m : float
        Exponent.
    threshold : float, optional
        Range in MPa sqrt(m) below which nothing grows.
    source : str, optional
        Where the constants come from.

    Raises
    ------
    OptionError
        For constants that are not positive.

    See Also
    --------
    published_laws : laws with constants of published sources.

    Examples
    --------
    >>> from nonsmooth.fatigue import Paris
    >>> float(Paris(C=2e-8, m=3.0).rate(10.0))
    2e-05
    """

    C: float
    m: float
    threshold: float = 0.0
    source: str = ""

    def __post_init__(self) -> None:
        _check(self, "C", "m")

    def rate(self, delta_K: npt.ArrayLike, R: npt.ArrayLike = 0.0) -> Array:
        """Growth in mm per cycle.

        Parameters
        ----------
        delta_K : array_like
            Ranges of stress intensity, MPa sqrt(m), from zero on, at which nothing grows.
        R : array_like
            Load ratios, minimum by maximum; without influence.

        Returns
        -------
        numpy.ndarray
            Growth in mm per cycle; nan where it is not known, as of a range that is nan.

        Raises
        ------
        OptionError
            For a negative range.
        """
        size, _ = _together(delta_K, R)
        return _above(size, self.threshold, self.C * size**self.m)


@dataclass(frozen=True)
class Walker:
    r"""Walker's law :math:`da/dN = C\,[\Delta K/(1-R)^{1-\gamma}]^m`.

    Parameters
    ----------
    C : float
        Growth in mm per cycle at a range of 1 MPa sqrt(m) and R = 0.
    m : float
        Exponent.
    gamma : float
        Influence of the load ratio, from 0 to 1: none at 1; at 0 the largest value alone counts.
    threshold : float, optional
        Equivalent range, that in brackets, in MPa sqrt(m), below which nothing grows.
    source : str, optional
        Where the constants come from.

    Raises
    ------
    OptionError
        For C or m that are not positive, and gamma out of its range. The bracket is
        :math:`\Delta K^\gamma K_{max}^{1-\gamma}`: beyond 1 a larger load would slow the growth
        at the same range, below 0 a larger range would at the same largest load.

    References
    ----------
    K. Walker, in ASTM STP 462, 1-14 (1970).

    Examples
    --------
    >>> from nonsmooth.fatigue import Walker
    >>> float(Walker(C=2e-8, m=3.0, gamma=0.5).rate(10.0, R=0.75))
    0.00016
    """

    C: float
    m: float
    gamma: float
    threshold: float = 0.0
    source: str = ""

    def __post_init__(self) -> None:
        _check(self, "C", "m")
        if not 0.0 <= finite("gamma", self.gamma) <= 1.0:
            raise OptionError(
                f"gamma = {self.gamma:g} must be from 0 to 1: above 1 a larger mean load would slow"
                " the growth, below 0 a larger range would"
            )

    def rate(self, delta_K: npt.ArrayLike, R: npt.ArrayLike = 0.0) -> Array:
        """Growth in mm per cycle.

        Parameters
        ----------
        delta_K : array_like
            Ranges of stress intensity, MPa sqrt(m), from zero on, at which nothing grows.
        R : array_like
            Load ratios, minimum by maximum, below one.

        Returns
        -------
        numpy.ndarray
            Growth in mm per cycle; nan where it is not known, as of a range that is nan.

        Raises
        ------
        OptionError
            For a negative range, and a load ratio that is not below one.
        """
        size, ratio = _changing(delta_K, R)
        size = size / (1.0 - ratio) ** (1.0 - self.gamma)
        return _above(size, self.threshold, self.C * size**self.m)


@dataclass(frozen=True)
class Forman:
    r"""Forman's law :math:`da/dN = C\,\Delta K^m/[(1-R)K_c - \Delta K]`.

    It rises without bound where the largest stress intensity reaches :math:`K_c`; beyond it the
    rate is infinite.

    Parameters
    ----------
    C : float
        Constant in mm per cycle, for ranges in MPa sqrt(m).
    m : float
        Exponent.
    K_c : float
        Stress intensity at fracture, MPa sqrt(m).
    threshold : float, optional
        Range in MPa sqrt(m) below which nothing grows.
    source : str, optional
        Where the constants come from.

    Raises
    ------
    OptionError
        For constants that are not positive.

    Examples
    --------
    >>> from nonsmooth.fatigue import Forman
    >>> float(Forman(C=4e-6, m=3.0, K_c=50.0).rate(10.0))
    0.0001
    """

    C: float
    m: float
    K_c: float
    threshold: float = 0.0
    source: str = ""

    def __post_init__(self) -> None:
        _check(self, "C", "m", "K_c")

    def rate(self, delta_K: npt.ArrayLike, R: npt.ArrayLike = 0.0) -> Array:
        """Growth in mm per cycle.

        Parameters
        ----------
        delta_K : array_like
            Ranges of stress intensity, MPa sqrt(m), from zero on, at which nothing grows.
        R : array_like
            Load ratios, minimum by maximum, below one.

        Returns
        -------
        numpy.ndarray
            Growth in mm per cycle; nan where it is not known, as of a range that is nan.

        Raises
        ------
        OptionError
            For a negative range, and a load ratio that is not below one.
        """
        size, ratio = _changing(delta_K, R)
        left = (1.0 - ratio) * self.K_c - size
        broken = left <= 0.0  # not so where it is nan
        rate = self.C * size**self.m / np.where(broken, 1.0, left)
        return _above(size, self.threshold, np.where(broken, np.inf, rate))


def _together(delta_K: npt.ArrayLike, R: npt.ArrayLike) -> tuple[Array, Array]:
    """Ranges and load ratios in one shape."""
    size, ratio = number_array("delta_K", delta_K), number_array("R", R)
    same_shape(delta_K=size, R=ratio)
    if np.any(size < 0.0):
        raise OptionError(
            f"delta_K = {np.nanmin(size):g} MPa sqrt(m): a range of stress intensity, the largest"
            " less the smallest of a cycle, is not negative"
        )
    size, ratio = np.broadcast_arrays(size, ratio)
    return size, ratio


def _changing(delta_K: npt.ArrayLike, R: npt.ArrayLike) -> tuple[Array, Array]:
    """Ranges with the load ratios of loads that change; where none does, no ratio counts."""
    size, ratio = _together(delta_K, R)
    ratio = np.where(size > 0.0, ratio, 0.0)
    if np.any(ratio >= 1.0):
        raise OptionError(f"R = {np.nanmax(ratio):g}: a load ratio is below 1, as loads change")
    return size, ratio


def _above(size: Array, threshold: float, rate: Array) -> Array:
    """Rates with none up to a threshold; a size that is nan is not known to lie there."""
    return np.where(size <= threshold, 0.0, rate)


def _check(law: Any, *names: str) -> None:
    for name in names:
        positive(name, getattr(law, name))
    if not isinstance(law.source, str):
        raise OptionError(f"source = {quote(law.source)}: give a text")
    if finite("threshold", law.threshold) < 0.0:
        raise OptionError(f"threshold = {law.threshold:g} MPa sqrt(m): it cannot be negative")
