"""Closure: the part of a cycle in which the crack is shut does no work."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, is_known, quote
from nonsmooth.fatigue.checks import Array, finite, number_array

__all__ = ["Closure", "NewmanClosure", "closure_text", "effective_range"]

Closure = Any  # "none", "shut", a number, or NewmanClosure
_WORDS = ("none", "shut")
_ROUNDING = 1e-12  # of a formula for the stress intensity, of its value


@dataclass(frozen=True)
class NewmanClosure:
    r"""Newman's opening stress of a crack that plasticity closes.

    .. math::

        K_{op}/K_{max} = A_0 + A_1R + A_2R^2 + A_3R^3 \ (R\ge 0), \quad A_0 + A_1R \ (R<0)

    Parameters
    ----------
    alpha : float
        Constraint: 1 for plane stress to 3 for plane strain.
    stress_ratio : float
        Largest stress by flow stress, 0 to below 1.
    reference : float or None
        Load ratio at which the constants of the law were measured: ranges are given as those
        that would open the crack as much there. None: the constants are for effective ranges.

    Raises
    ------
    OptionError
        For values outside of these ranges.

    References
    ----------
    J. C. Newman, International Journal of Fracture 24, R131-R135 (1984).

    Examples
    --------
    >>> from nonsmooth.fatigue import NewmanClosure
    >>> round(float(NewmanClosure(alpha=1.0, stress_ratio=0.0).opening(0.0)), 3)
    0.535
    """

    alpha: float = 2.0
    stress_ratio: float = 0.3
    reference: float | None = 0.0

    def __post_init__(self) -> None:
        if not 1.0 <= finite("alpha", self.alpha) <= 3.0:
            raise OptionError(f"alpha = {self.alpha:g}: 1 (plane stress) to 3 (plane strain)")
        if not 0.0 <= finite("stress_ratio", self.stress_ratio) < 1.0:
            raise OptionError(f"stress_ratio = {self.stress_ratio:g}: from 0 to below 1")
        if self.reference is not None and not -1.0 <= finite("reference", self.reference) < 1.0:
            raise OptionError(f"reference = {self.reference:g}: from -1 to below 1")

    def opening(self, R: npt.ArrayLike) -> Array:
        """Stress intensity at which the crack opens, by the largest one.

        Parameters
        ----------
        R : array_like
            Load ratios; below -1 the value at -1 is taken.

        Returns
        -------
        numpy.ndarray
            Opening ratios, not below R nor below zero.
        """
        a, s = self.alpha, self.stress_ratio
        a0 = (0.825 - 0.34 * a + 0.05 * a * a) * math.cos(0.5 * math.pi * s) ** (1.0 / a)
        a1 = (0.415 - 0.071 * a) * s
        a3 = 2.0 * a0 + a1 - 1.0
        a2 = 1.0 - a0 - a1 - a3
        r = np.maximum(number_array("R", R), -1.0)
        opened = a0 + r * (a1 + np.where(r >= 0.0, r * (a2 + r * a3), 0.0))
        # at one, where they meet, rounding may leave the sum above it
        opened = np.minimum(opened, np.maximum(r, 1.0))
        return np.maximum(np.maximum(opened, r), 0.0)


def effective_range(
    K_min: npt.ArrayLike, K_max: npt.ArrayLike, closure: str | float | NewmanClosure = "shut"
) -> tuple[Array, Array]:
    """Range of stress intensity that works, and the load ratio that a law is given with it.

    Parameters
    ----------
    K_min, K_max : array_like
        Smallest and largest stress intensity of cycles, MPa sqrt(m); negative ones are those of
        a load that presses the crack together.
    closure : {"shut", "none"}, float or NewmanClosure, optional
        ``"shut"``: below zero the crack is shut and does no work; the ratio is zero where it is
        negative. ``"none"``: the whole range, with its own ratio. A number: the crack opens at
        that part of the largest value; the range above it, with the ratio zero, for constants of
        effective ranges. Or Newman's formula.

    Returns
    -------
    range : numpy.ndarray
        Ranges, zero where the crack never opens.
    ratio : numpy.ndarray
        Load ratios, below one.

    Raises
    ------
    OptionError
        For an unknown word, a number that is not from 0 to below 1, or a smallest stress intensity
        above the largest.

    Examples
    --------
    >>> from nonsmooth.fatigue import effective_range
    >>> size, ratio = effective_range(-10.0, 10.0)
    >>> float(size), float(ratio)
    (10.0, 0.0)
    """
    low, high = number_array("K_min", K_min), number_array("K_max", K_max)
    try:
        low, high = np.broadcast_arrays(low, high)
    except ValueError:
        raise OptionError(
            f"K_min and K_max: one value each for every cycle, not {low.size} and {high.size}"
        ) from None
    low = _ordered(low, high)
    # without closure a cycle in compression has a range too, and no ratio below one
    top = np.where(high > 0.0, high, 1.0)
    if is_known(closure, ("none",)):
        return high - low, np.where(high > 0.0, low / top, 0.0)
    open_high = np.maximum(high, 0.0)
    ratio = np.where(high > 0.0, low / top, 0.0)
    if is_known(closure, ("shut",)):
        return open_high - np.maximum(np.minimum(low, open_high), 0.0), np.maximum(ratio, 0.0)
    if isinstance(closure, NewmanClosure):
        size = open_high * (1.0 - closure.opening(ratio))
        if closure.reference is None:
            return size, np.zeros_like(size)
        at = closure.reference
        share = (1.0 - float(closure.opening(at))) / (1.0 - at)
        return size / share, np.full_like(size, at)
    if isinstance(closure, str):
        raise OptionError(f"closure = {quote(closure)}; known are {', '.join(_WORDS)}, a number,"
                          " and a NewmanClosure")  # fmt: skip
    opened = finite("closure", closure)
    if not 0.0 <= opened < 1.0:
        raise OptionError(f"closure = {opened:g}: the opening ratio is from 0 to below 1")
    size = open_high * (1.0 - np.clip(np.maximum(ratio, opened), 0.0, 1.0))
    return size, np.zeros_like(size)


def _ordered(low: Array, high: Array) -> Array:
    """Smallest values, none above the largest but by the rounding of the two."""
    wrong = np.flatnonzero(low > high + _ROUNDING * np.abs(high))
    if wrong.size:
        first = wrong[0]
        raise OptionError(
            f"K_min = {low.flat[first]:g} is above K_max = {high.flat[first]:g} MPa sqrt(m); of a"
            " cycle they are the smallest and the largest stress intensity, which grows with the"
            " load"
        )
    return np.minimum(low, high)


def closure_text(closure: Closure) -> str:
    """How it is told in the attributes of a result."""
    return closure if isinstance(closure, str) else repr(closure)
