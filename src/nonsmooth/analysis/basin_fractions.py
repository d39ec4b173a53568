"""`basin_fractions`: how many starts lead where."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.measures.outcomes import (
    ENDED_EARLY,
    INADMISSIBLE,
    NOT_COMPUTED,
    UNSETTLED,
    outcome_name,
    outcomes_of,
)

__all__ = ["basin_fractions"]


def basin_fractions(
    basins: xr.Dataset | xr.DataArray | npt.ArrayLike,
    *,
    leave_out: Iterable[int] = (INADMISSIBLE, NOT_COMPUTED),
) -> xr.Dataset:
    r"""Fraction of the starts that lead to each attractor: its basin stability.

    Parameters
    ----------
    basins : xarray.Dataset, xarray.DataArray, array_like of int
        Result of `basins_of_attraction`, its ``label``, or the labels of any starts, drawn at
        random or not, in any number of dimensions.

    Other Parameters
    ----------------
    leave_out : iterable of int, optional
        Labels of starts that do not count: by default those that no mode admits (-2) and
        those that an interruption left out (-3). Unsettled starts (0) and those that ended early
        (-1) count, with lines of their own.

    Returns
    -------
    xarray.Dataset
        Over ``label``: ``fraction``, ``fraction_error``, ``starts`` (their number) and
        ``outcome``, what the label says in words. Every attractor has a line, unsettled and ended
        early where there are such starts. Attribute ``n_starts``: how many count.

    Raises
    ------
    OptionError
        For what is no array of labels.

    See Also
    --------
    basin_entropy : how much basins are mixed.

    Notes
    -----
    The error of a fraction b of N starts is :math:`\sqrt{b (1 - b)/N}`, that of starts drawn at
    random; for starts on a grid it is an upper bound in most cases. A fraction of zero has no
    error by this formula: with 95 % certainty it is below 3/N.

    References
    ----------
    P. J. Menck, J. Heitzig, N. Marwan and J. Kurths, How basin stability complements the
    linear-stability paradigm, Nature Physics 9, 89-92 (2013).

    Examples
    --------
    >>> import nonsmooth as ns
    >>> found = ns.basin_fractions([1, 1, 2, 1, -2])
    >>> found["fraction"].values.tolist(), found["outcome"].values.tolist()
    ([0.75, 0.25], ['attractor 1', 'attractor 2'])
    """
    outcomes = outcomes_of(basins, leave_out)
    total = int(np.count_nonzero(outcomes.counts))
    others = [k for k in (UNSETTLED, ENDED_EARLY) if k in outcomes.numbers]
    more = [int(k) for k in outcomes.numbers if k < ENDED_EARLY]
    found = {int(k) for k in outcomes.numbers if k > 0}
    known = set(range(1, outcomes.n_attractors + 1)) - set(outcomes.left_out)
    every = sorted(found | known)
    numbers = np.array([*every, *others, *more])
    starts = np.array([np.count_nonzero(outcomes.labels == k) for k in numbers])
    fraction = starts / total
    return xr.Dataset(
        {
            "fraction": ("label", fraction, {"long_name": "fraction of the starts"}),
            "fraction_error": (
                "label",
                np.sqrt(fraction * (1.0 - fraction) / total),
                {"long_name": "standard error of the fraction"},
            ),
            "starts": ("label", starts, {"long_name": "number of starts"}),
            "outcome": ("label", [outcome_name(k) for k in numbers], {"long_name": "outcome"}),
        },
        {"label": ("label", numbers, {"long_name": "label"})},
        outcomes.attrs | {"n_starts": total},
    )
