"""Frequencies of a beam with a crack that opens and shuts."""

from __future__ import annotations

from typing import Any

import numpy as np

from nonsmooth.errors import OptionError
from nonsmooth.fatigue.checks import finite_array

__all__ = ["bilinear_frequency", "breathing_frequency_ratio"]


def bilinear_frequency(closed: Any, opened: Any) -> Any:
    r"""Natural frequency of an oscillator with one stiffness on each side of its rest position.

    Half a period of each kind makes a period: :math:`2 f_1 f_2/(f_1 + f_2)`. This is exact for free
    undamped motion of one mass when the stiffness changes where the mass is at rest; it does not
    depend on the amplitude then.

    Parameters
    ----------
    closed, opened : float or array_like
        Natural frequencies on either side, in any unit; broadcast together.

    Returns
    -------
    float or numpy.ndarray
        The frequency in the same unit.

    Raises
    ------
    OptionError
        For a frequency that is not positive.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> round(ns.fatigue.bilinear_frequency(100.0, 50.0), 3)
    66.667
    """
    first, second = _positive("closed", closed), _positive("opened", opened)
    found = 2.0 * first * second / (first + second)
    return found if np.ndim(found) else float(found)


def breathing_frequency_ratio(stiffness_ratio: Any) -> Any:
    r"""Natural frequency with a breathing crack over that without one.

    One mass on the stiffness of the specimen: with :math:`r = \sqrt{k_{op}/k_{cl}}` the ratio is
    :math:`2r/(1 + r)`. The mass of the beam itself is left out, or taken to move in one shape
    whether the crack is open or shut.

    Parameters
    ----------
    stiffness_ratio : float or array_like
        Open stiffness over closed stiffness, as of `Specimen.stiffness_ratio`, from above 0 to 1;
        with other springs beside the specimen the ratio of the sums.

    Returns
    -------
    float or numpy.ndarray
        The ratio; that for a crack which stays open would be r itself.

    Raises
    ------
    OptionError
        For a ratio that is not positive.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> specimen = ns.fatigue.Specimen()
    >>> [
    ...     round(ns.fatigue.breathing_frequency_ratio(specimen.stiffness_ratio(a)), 3)
    ...     for a in (5.0, 10.0)
    ... ]
    [0.967, 0.861]
    """
    root = np.sqrt(_positive("stiffness_ratio", stiffness_ratio))
    return bilinear_frequency(1.0, root)


def _positive(name: str, values: Any) -> Any:
    numbers = finite_array(name, values)
    if np.any(numbers <= 0.0):
        raise OptionError(f"{name} = {float(numbers.min()):g} must be positive")
    return numbers
