"""To which attractor the cells of a grid of initial states lead."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from nonsmooth.analysis.basins.attractor import renumbered
from nonsmooth.analysis.basins.attractor_dataset import (
    attractor_variables,
    search_message,
    with_images,
    with_words,
)
from nonsmooth.analysis.basins.attractor_search import (
    ENDED,
    INADMISSIBLE,
    NOT_COMPUTED,
    UNSETTLED,
    SearchOptions,
    read_search,
)
from nonsmooth.analysis.basins.by_cell_mapping import by_cell_mapping
from nonsmooth.analysis.basins.by_cell_shares import by_cell_shares
from nonsmooth.analysis.basins.by_recurrences import Basins, by_recurrences
from nonsmooth.analysis.basins.region import Grid, read_grid
from nonsmooth.analysis.options import SharedOptions, result_attributes
from nonsmooth.errors import OptionError, is_known, unknown_choice
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.maps import Map
from nonsmooth.runs.of_system import map_of
from nonsmooth.runs.poincare_map import PoincareMap
from nonsmooth.runs.store import check_store
from nonsmooth.system.system import System

__all__ = ["basins_of_attraction"]

_FOLLOWED = "recurrences"
_MAPPINGS = {
    "cell mapping": by_cell_mapping,
    "generalised cell mapping": by_cell_shares,
}

_OF_CELLS = ("label", "iterations", "probability")


def basins_of_attraction(
    system: Any,
    region: Mapping[str, Any],
    *,
    method: str = "recurrences",
    completion: Mapping[str, float | str] | None = None,
    samples: int = 1000,
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
    """Compute the basins of all attractors on a grid of initial states.

    Parameters
    ----------
    system : System or map
        A system with a period, for its stroboscopic map, or a `StroboscopicMap` or `PoincareMap`.
    region : mapping of str to array_like
        Increasing values of two states or more; each combination is the centre of a cell.
    method : {"recurrences", "cell mapping", "generalised cell mapping"}, optional
        ``"recurrences"`` runs the centre of each cell until it has come to an attractor; ``"cell
        mapping"`` finds to which cell each centre goes in one step, and follows these chains of
        cells; ``"generalised cell mapping"`` finds to which cells nine points of each cell go
        (three along each state), and gives probabilities. The last two need all states that do not
        drift in the region, are as exact as its cells are small, and do not go with a
        `PoincareMap`.
    completion : mapping of str to float or str, optional
        States that are not in the region, as in `attractors`: a section of the state space that
        all starts lie on. Those not given are at rest.
    seed : int, optional
        Seed of the random numbers: the same seed gives the same result.
    samples, cells, longest, record, match : optional
        How attractors are found, see `attractors`. Cells that come to none of them are looked at
        one by one, so that an attractor whose basin is a single cell is found.
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
        Folder in which finished parts are kept, made where it is missing. After an interruption the
        same call goes on from them. Only ``"recurrences"`` takes it.

    Returns
    -------
    xarray.Dataset
        What `attractors` gives, and over the states of the region, the last one first: ``label``,
        the number of the attractor, 0 where a start came to none in the longest time, -1 where it
        ended early (as it diverges), -2 where no mode admits it, -3 where an interruption left it
        out; and ``iterations`` until that was known. ``fraction`` is the share of the admissible
        cells, ``fraction_error`` its error for independent starts. The generalised cell mapping
        labels a cell by the attractor to which most of it goes, and gives ``probability`` in place
        of ``iterations``: the share of the cell that goes there, by the chain of cells. It tells
        how a cell is divided, not how certain the label is: cells that are too coarse may be wrong
        together, and basins thinner than a cell get too small a ``fraction``. The attribute
        ``iterates_per_cell`` tells how often cells were mapped, ``changed_by_doubling`` which part
        of the labels the last doubling changed, and ``cells_of_several_attractors`` how many cells
        are too coarse to tell attractors apart; then the message says so too.

    Raises
    ------
    OptionError
        For an unknown state or method, a range in place of values, a region without admissible
        cells, a store of another computation.

    See Also
    --------
    attractors : the attractors alone, from random starts.
    uncertainty_exponent, basin_entropy : how entangled basins are.

    Notes
    -----
    Centres are independent of each other: parts of the grid run side by side, and each centre is
    left as soon as its attractor is known. A centre that has come to a cycle is run on, until a
    motion that converges must have come ten times as near, and belongs to the cycle only if it has.
    That is left out for a cycle that needs more than 2000 iterates for it; ``unconfirmed_cells``
    counts the cells of such cycles, and the message says so. In the cell mapping, cycles of cells
    are followed by the exact map from one of their centres, which gives their attractors; chains
    that leave the grid and do not return are followed so too. Images are those after 1, 2, 4, ...
    iterates, until a doubling changes the label of at most 1 in 1000 cells more than three cells
    away from others, twice: each image is rounded to a cell, and so there are fewer roundings. The
    generalised one does the same with all its points; those that have come to an attractor go no
    further.

    References
    ----------
    G. Datseris and A. Wagemakers, Chaos 32, 023104 (2022); C. S. Hsu, Cell-to-Cell Mapping,
    Springer (1987), the method of reference 26 of the chapter.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> basins = ns.basins_of_attraction(
    ...     ns.models.duffing(),
    ...     {"x": np.linspace(-2, 2, 20), "v": np.linspace(-2, 2, 20)},
    ...     samples=50,
    ... )
    >>> basins["label"].dims, basins["label"].shape
    (('v', 'x'), (20, 20))
    """
    shared = SharedOptions(parameters, tolerance, threads=threads, store=store, seed=seed)
    chosen = map_of(system, parameters, tolerance, "basins_of_attraction", states_only=True)
    grid = read_grid(chosen.system, region, completion)
    check_names(chosen.system, region)
    if not is_known(method, (_FOLLOWED,)):
        _check_mapping(chosen, region, method, store)
    how, workers = read_search(samples, cells, longest, record, match, shared), shared.workers
    options = {
        "method": method,
        "completion": str(dict(grid.completion.texts)),
        **chosen.protocol,
        **how.options,
        **shared.recorded,
    }
    protocol = {
        "call": "basins_of_attraction",
        "system": chosen.system.to_toml(),
        **{
            f"region_{name}": np.asarray(axis) for name, axis in zip(region, grid.axes, strict=True)
        },
        **options,
    }
    check_store(store)
    if method == _FOLLOWED:
        found = by_recurrences(chosen, grid, how, shared, protocol)
    else:
        found = _MAPPINGS[method](chosen, grid, how, workers)
    return basin_dataset(chosen, grid, found, how, options)


def _check_mapping(
    chosen: Map, region: Mapping[str, Any], method: Any, store: str | Path | None
) -> None:
    """Refuse what a map of cells cannot do."""
    if not is_known(method, _MAPPINGS):
        known = [_FOLLOWED, *_MAPPINGS]
        raise OptionError(unknown_choice("method", method, known))
    if isinstance(chosen, PoincareMap):
        raise OptionError(
            f"method = {method!r} needs a map of cells along every state, and points of a section"
            f" lie on a surface, here {chosen.section!r}, that cells cut at any angle; take"
            f" method={_FOLLOWED!r}"
        )
    missing = [
        name
        for name in chosen.system.states
        if name not in chosen.system.drift_states and name not in region
    ]
    if missing:
        raise OptionError(
            f"a cell mapping needs cells along every state, and {', '.join(missing)} is not in the"
            f" region; add it, or take method={_FOLLOWED!r}"
        )
    if store is not None:
        raise OptionError(f"store= is for method={_FOLLOWED!r} alone; leave it out")


def check_names(system: System, region: Iterable[str]) -> None:
    """Refuse states of a region, coordinates of the result, that are called like parts of it."""
    variables, coords = attractor_variables(system, [], np.zeros(0, np.int64))
    dims = {name for dims, *_ in variables.values() for name in dims}
    for name in region:
        if name in {*variables, *coords, *dims, *_OF_CELLS}:
            raise OptionError(
                f"region: {name!r} is also the name of a part of the result; give the state another"
                " name"
            )


def basin_dataset(
    chosen: Any, grid: Grid, basins: Basins, how: SearchOptions, options: dict[str, Any]
) -> xr.Dataset:
    """Labels over the states of the region, beside the attractors."""
    system = chosen.system
    order, label = renumbered(basins.attractors, basins.settled.label)
    order = with_images(
        chosen, with_words(chosen, order, options["tolerance"]), options["tolerance"]
    )
    variables, coords = attractor_variables(system, order, label[label > INADMISSIBLE])
    names = grid.completion.given
    dims = tuple(reversed(names))
    words = labels_of(system)
    variables["label"] = (
        dims,
        label.reshape(grid.shape).astype(np.int16),
        {
            "long_name": "attractor",
            "comment": "0: unsettled, -1: ended early, -2: inadmissible, -3: not computed",
        },
    )
    if basins.probability is None:
        variables["iterations"] = (
            dims, basins.settled.needed.reshape(grid.shape).astype(np.int32),
            {"long_name": "iterates until the attractor was known"},
        )  # fmt: skip
    else:
        variables["probability"] = (
            dims, basins.probability.reshape(grid.shape),
            {"long_name": "probability of the attractor of the label"},
        )  # fmt: skip
    for name, axis in zip(names, grid.axes, strict=True):
        coords[name] = ((name,), axis, words.attributes(name))
    counts = {
        "unsettled_cells": int(np.sum(label == UNSETTLED)),
        "ended_cells": int(np.sum(label == ENDED)),
        "inadmissible_cells": int(np.sum(label == INADMISSIBLE)),
        "cells_left_out": int(np.sum(label == NOT_COMPUTED)),
    }
    status = "completed" if basins.complete else "interrupted"
    message = "interrupted by the user; the cells that are done are kept"
    if basins.complete:
        settled = replace(basins.settled, label=label)
        message = search_message("cells", settled, order, how, chosen)
    if basins.remark:
        message = f"{message}; {basins.remark}"
    attrs = result_attributes(system, status, message, options | counts | dict(basins.notes))
    return xr.Dataset(variables, coords, attrs)
