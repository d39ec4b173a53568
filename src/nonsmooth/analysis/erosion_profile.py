"""`erosion_profile`: how basins shrink over a parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.basins.attractor_search import SearchOptions, read_search
from nonsmooth.analysis.basins.by_recurrences import Basins, label_grid
from nonsmooth.analysis.basins.region import Box, Grid, read_grid
from nonsmooth.analysis.measures.erosion_dataset import Profile, erosion_dataset
from nonsmooth.analysis.measures.integrity_measures import read_axis_scales
from nonsmooth.analysis.options import SharedOptions, check_values, refuse_fixed
from nonsmooth.analysis.pictures.columns import Column, settle_columns
from nonsmooth.errors import ModelError, OptionError, is_known, quote
from nonsmooth.progress import Progress
from nonsmooth.runs.maps import Map
from nonsmooth.runs.of_system import map_of
from nonsmooth.runs.store import check_store, part_of_store

__all__ = ["erosion_profile"]

_SAFE = ("each", "all")


def erosion_profile(
    system: Any,
    parameter: str,
    values: Sequence[float] | npt.ArrayLike,
    region: Mapping[str, Any],
    *,
    safe: Literal["each", "all"] = "each",
    scales: Mapping[str, float] | None = None,
    completion: Mapping[str, float | str] | None = None,
    samples: int = 200,
    seed: int = 0,
    cells: int = 64,
    longest: int = 10_000,
    record: int = 20_000,
    match: float = 1e-6,
    parameters: Mapping[str, float] | None = None,
    tolerance: float = 1e-12,
    threads: int | None = None,
    store: str | Path | None = None,
) -> xr.Dataset:
    """Measure the integrity of basins for many values of a parameter.

    Parameters
    ----------
    system : System or map
        A system with a period, for its stroboscopic map, or a `StroboscopicMap` or `PoincareMap`.
    parameter : str
        Name of the parameter.
    values : array_like
        Values of the parameter, in order.
    region : mapping of str to array_like
        Increasing values of two states or more; each combination is the centre of a cell, as in
        `basins_of_attraction`.
    safe : {"each", "all"}, optional
        Whether each attractor has a basin of its own, or those of all are one safe basin, out of
        which motions end early.
    scales : mapping of str to float, optional
        Sizes by which states are divided before distances are measured, 1 without it.
    completion : mapping of str to float or str, optional
        States that are not in the region, as in `attractors`. Those not given are at rest.
    seed : int, optional
        Seed of the random numbers: the same seed gives the same result.
    samples, cells, longest, record, match : optional
        How attractors are found, see `attractors`.
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.
    threads : int, optional
        Number of threads; without it, one for each processor. The result does not depend on it.
    store : str or Path, optional
        Folder in which finished parts are kept, made where it is missing. After an interruption
        the same call goes on from them.

    Returns
    -------
    xarray.Dataset
        Over ``parameter`` and ``attractor``: ``local_integrity``, ``global_integrity`` and
        ``integrity_factor`` with their errors and limits, as `integrity` gives them, nan where the
        attractor does not exist; its ``kind`` and ``period``. Over ``parameter``: ``ended``, the
        share of the region from which motions end early, and ``unsettled``. ``label`` over
        ``parameter`` and the states of the region. Attributes: ``half_diagonal`` of a cell, which
        bounds the errors.

    Raises
    ------
    OptionError
        For an unknown parameter or state, a value that the system refuses, or an option out of its
        range.

    See Also
    --------
    integrity : the same of basins that are computed already, with what the measures mean.
    bifurcation_picture : attractors and shares of random starts over a parameter.
    nonsmooth.plot.erosion_profile : a picture of it.

    Notes
    -----
    At each value all cells run until they have come to an attractor, as in
    `basins_of_attraction`. An attractor keeps its number from value to value where motions that
    begin on it lead to it after the step, and back; one that does not has a new number. Read a
    profile with its errors: of a basin that is thinner than a cell there is nothing to see.

    References
    ----------
    J. M. T. Thompson, Chaotic phenomena triggering the escape from a potential well, Proceedings of
    the Royal Society A 421, 195-225 (1989).

    G. Rega and S. Lenci, Identifying, evaluating, and controlling dynamical integrity measures in
    non-linear mechanical oscillators, Nonlinear Analysis 63, 902-914 (2005).

    Examples
    --------
    The border between two wells moves to one of them, at a distance of (1 - c)/sqrt(2):

    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> wells = ns.System(
    ...     states=["x", "y"],
    ...     parameters={"c": 0.0},
    ...     period=1.0,
    ...     definitions={"s": "x + y"},
    ...     equations={"x": "(-s + sign(s - c))/2 - x + y", "y": "(-s + sign(s - c))/2 + x - y"},
    ... )
    >>> cells = np.linspace(-2, 2, 40)
    >>> found = ns.erosion_profile(wells, "c", [0.0, 0.4, 0.8], {"x": cells, "y": cells})
    >>> right = found["local_integrity"].sel(attractor=2)
    >>> exact = (1 - found["parameter"]) / 2**0.5
    >>> bool((abs(right - exact) <= found["local_error"].sel(attractor=2)).all())
    True
    """
    shared = SharedOptions(parameters, tolerance, threads=threads, store=store, seed=seed)
    chosen = map_of(system, parameters, tolerance, "erosion_profile", states_only=True)
    grid = check_values(chosen.system, parameter, values)
    refuse_fixed(system, parameters, (parameter,), "parameter")
    if not is_known(safe, _SAFE):
        raise OptionError(f"safe = {quote(safe)} must be 'each' or 'all'")
    first = read_grid(chosen.system, region, completion)
    sizes = read_axis_scales(scales, list(first.completion.given))
    how = read_search(samples, cells, longest, record, match, shared)
    _ = shared.workers
    if store is not None:
        check_store(part_of_store(store, 0))
    maps = [(float(value), _at(chosen, parameter, float(value))) for value in grid]
    grids = [read_grid(each.system, region, completion) for _, each in maps]
    options = {
        "parameter": parameter, "safe": safe, "scales": str(dict(scales)) if scales else "",
        "completion": str(dict(first.completion.texts)), **chosen.protocol, **how.options,
        **shared.recorded,
    }  # fmt: skip
    with Progress("erosion profile: attractors", 2 * len(maps) - 1) as progress:
        columns, complete = settle_columns(
            maps, lambda each: _box(read_grid(each.system, region, completion)), how,
            progress.update,
        )  # fmt: skip
    basins: list[Basins] = []
    with Progress("erosion profile: basins", len(maps)) as progress:
        for k, (column, each) in enumerate(zip(columns, grids, strict=False)):
            if not complete:
                break
            basins.append(_labels(maps[k][1], each, column, how, shared, options, k))
            complete = basins[-1].complete
            progress.update(k + 1)
    done = [k for k, one in enumerate(basins) if one.complete]
    profile = Profile(
        chosen.system, first, sizes, safe == "all", [columns[k] for k in done],
        [basins[k].settled.label for k in done],
    )  # fmt: skip
    return erosion_dataset(profile, parameter, options, complete=complete)


def _at(chosen: Map, parameter: str, value: float) -> Map:
    """The map at a value; an error says which value the system refuses."""
    try:
        return chosen.with_parameters(**{parameter: value})
    except ModelError as fault:
        raise OptionError(f"values: the system refuses {parameter} = {value:g}: {fault}") from None


def _box(grid: Grid) -> Box:
    """The box that a grid fills."""
    ends = np.array([[axis[0], axis[-1]] for axis in grid.axes])
    return Box(ends[:, 0], ends[:, 1], grid.completion)


def _labels(
    chosen: Map, grid: Grid, column: Column, how: SearchOptions, shared: SharedOptions,
    options: Mapping[str, Any], k: int,
) -> Basins:  # fmt: skip
    """Labels of the cells at one value."""
    own = shared if shared.store is None else replace(shared, store=part_of_store(shared.store, k))
    protocol = {
        "call": "erosion_profile", "system": chosen.system.to_toml(), "value": column.value,
        **options,
        **{f"region_{name}": axis for name, axis in zip(
            grid.completion.given, grid.axes, strict=True)},
    }  # fmt: skip
    return label_grid(chosen, grid, column.found, how, own, protocol)
