"""`integrity`: how far attractors are from the borders of their basins."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.measures.integrity_measures import (
    Cells,
    integrity_of_labels,
    read_axis_scales,
)
from nonsmooth.analysis.measures.outcomes import LEFT_OUT, outcomes_of
from nonsmooth.errors import OptionError, quote
from nonsmooth.runs.whole_turns import periods_of
from nonsmooth.system.system import System

__all__ = ["integrity"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def integrity(
    basins: xr.Dataset,
    *,
    safe: Iterable[int] | None = None,
    scales: Mapping[str, float] | None = None,
    leave_out: Iterable[int] = LEFT_OUT,
) -> xr.Dataset:
    """Measure how far attractors are from the borders of their basins, and how large these are.

    Parameters
    ----------
    basins : xarray.Dataset
        Result of `basins_of_attraction`.
    safe : iterable of int, optional
        Attractors whose basins are one safe basin, such as all of those that do not end early. By
        default each has its own.
    scales : mapping of str to float, optional
        Sizes by which states are divided before distances are measured, 1 without it. Give them
        where states have different units: the largest disturbances that are expected of each.

    Other Parameters
    ----------------
    leave_out : iterable of int, optional
        Labels that are no outcome: by default starts that are unsettled (0), inadmissible (-2) or
        not computed (-3). They are part of no basin, and no border either.

    Returns
    -------
    xarray.Dataset
        Over ``attractor``: ``local_integrity``, the radius of the largest ball around the attractor
        in its basin, the least of those around its points; ``global_integrity``, the share of the
        region that is the basin; ``integrity_factor``, the radius of the largest ball in the basin,
        around ``factor_centre``. A bound of the error of each: ``local_error``, ``global_error``,
        ``factor_error``. ``local_limit`` and ``factor_limit`` tell what ends a ball: the border of
        the basin, or the end of the region, beyond which nothing is known, so that it may be
        larger; "outside" where points of the attractor do not lie in the region.

    Raises
    ------
    OptionError
        For what is no result of `basins_of_attraction`, an unknown state or attractor.

    See Also
    --------
    erosion_profile : the same over a parameter.
    basin_fractions : shares of starts, with the error of random ones.

    Notes
    -----
    These are the local and the global integrity measure and the integrity factor of dynamical
    integrity, before anybody divides them by those at a reference value. Only a ball that fits into
    the basin is free of its thin tongues and of fractal fringes, in which a slight disturbance may
    lead elsewhere.

    Labels are those of centres of cells. With the half diagonal h of the largest cell, in scaled
    states, the distance of the nearest centre outside less h is off the distance of the border by h
    at most. The largest ball has its centre in the middle of a cell, so its radius is off by 3h/2
    at most. Shares are off by the cells that touch another outcome, at most. All of this holds
    where basins are wider than a cell; thinner ones are seen in part or not at all.

    Where the region leaves states out that do not drift, the basin is a section of the whole one,
    and the attractor need not lie in it: ``local_integrity`` is then nan.

    If the cells of an angle fill its turn, the last one lies beside the first, and the region has
    no end there. Otherwise both ends count, and an attractor lies in the region if it does so up to
    whole turns.

    References
    ----------
    J. M. T. Thompson and M. S. Soliman, Fractal control boundaries of driven oscillators and their
    relevance to safe engineering design, Proceedings of the Royal Society A 428, 1-13 (1990).

    G. Rega and S. Lenci, Identifying, evaluating, and controlling dynamical integrity measures in
    non-linear mechanical oscillators, Nonlinear Analysis 63, 902-914 (2005).

    Examples
    --------
    Two wells with a straight border between them, at x + y = 0, and attractors at distances of
    one over the root of two:

    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> wells = ns.System(
    ...     states=["x", "y"],
    ...     period=1.0,
    ...     definitions={"s": "x + y"},
    ...     equations={"x": "(-s + sign(s))/2 - x + y", "y": "(-s + sign(s))/2 + x - y"},
    ... )
    >>> cells = np.linspace(-2, 2, 40)
    >>> basins = ns.basins_of_attraction(wells, {"x": cells, "y": cells}, samples=20)
    >>> found = ns.integrity(basins)
    >>> off = abs(found["local_integrity"] - 0.5**0.5)
    >>> bool((off <= found["local_error"]).all()), found["local_limit"].values.tolist()
    (True, ['border', 'border'])
    """
    if not isinstance(basins, xr.Dataset) or not {"label", "points", "state"} <= set(
        basins.variables
    ):
        raise OptionError(
            "basins: integrity needs the attractors beside the labels; give the dataset that"
            " basins_of_attraction returns"
        )
    if not basins.sizes.get("attractor"):
        raise OptionError("basins: there are no attractors in this dataset; see its message")
    outcomes = outcomes_of(basins, leave_out)
    names = [str(name) for name in reversed(basins["label"].dims)]
    axes = tuple(np.asarray(basins[name].values, float) for name in names)
    _check_axes(names, axes)
    sizes = read_axis_scales(scales, names)
    cells = Cells(axes, sizes, outcomes.counts, _periods(basins, names))
    numbers = basins["attractor"].values.astype(int)
    together = _read_safe(safe, numbers)
    missing = _left_out(basins, names)
    points = [_points_of(basins, k, names, missing) for k in range(numbers.size)]
    found = integrity_of_labels(cells, outcomes.labels, numbers, points, together)
    message = "completed"
    if missing:
        message = (
            f"the region leaves out {', '.join(missing)}, so attractors need not lie in it and have"
            " no local integrity"
        )
    return xr.Dataset(
        {**found.variables, **_kept(basins)},
        {"attractor": basins["attractor"], "state_of_region": names},
        outcomes.attrs
        | {
            "message": message,
            "half_diagonal": cells.half_diagonal,
            "scales": str(dict(scales)) if scales else "",
            "safe": " ".join(map(str, sorted(together))),
        },
    )


def _periods(basins: xr.Dataset, names: list[str]) -> Floats:
    """Periods of the states of the region that are angles, zero of the others."""
    if "system" not in basins.attrs:
        return np.zeros(len(names))
    return periods_of(System.from_toml(basins.attrs["system"]), names)


def _kept(basins: xr.Dataset) -> dict[str, Any]:
    """Kind and period of the attractors, where they are told."""
    return {name: basins[name] for name in ("kind", "period") if name in basins}


def _points_of(basins: xr.Dataset, k: int, names: list[str], missing: list[str]) -> Floats:
    """Points of an attractor in the states of the region; none where that has not all of them."""
    if missing:
        return np.zeros((0, len(names)))
    own = basins["points"].isel(attractor=k).sel(state=names).values
    found: Floats = own[np.isfinite(own).all(axis=1)]
    return found


def _left_out(basins: xr.Dataset, names: list[str]) -> list[str]:
    """States that neither drift nor are in the region."""
    return [
        str(name)
        for name in basins["state"].values
        if str(name) not in names and f"{name}_per_iterate" not in basins
    ]


def _check_axes(names: list[str], axes: tuple[Floats, ...]) -> None:
    for name, axis in zip(names, axes, strict=True):
        if axis.size < 2 or np.any(np.diff(axis) <= 0.0):
            raise OptionError(
                f"basins: {name!r} has no two increasing values; give the dataset that"
                " basins_of_attraction returns"
            )


def _read_safe(safe: Any, numbers: Integers) -> set[int]:
    """Numbers of attractors whose basins count as one."""
    if safe is None:
        return set()
    try:
        found = {int(number) for number in safe}
        whole = all(int(number) == number for number in safe)
    except (TypeError, ValueError, OverflowError):
        found, whole = set(), False
    known = set(numbers.tolist())
    if not whole or not found or not found <= known:
        raise OptionError(
            f"safe = {quote(safe)}: give numbers of attractors, of"
            f" {', '.join(map(str, sorted(known)))}, such as [1, 2]"
        )
    return found
