"""`plan_map`: a map of any size, written down before any of it is computed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.regimes.border_refinement import check_levels, refined_values
from nonsmooth.analysis.regimes.map_question import MapQuestion, ask_map
from nonsmooth.analysis.regimes.options import RegimeProtocol
from nonsmooth.analysis.regimes.regime_dataset import map_dataset
from nonsmooth.analysis.settle import said_of_start
from nonsmooth.cluster.progress import progress
from nonsmooth.cluster.tile_store import TileStore, make_store
from nonsmooth.errors import OptionError
from nonsmooth.runs.options import whole_number
from nonsmooth.runs.protocols import plain
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["plan_map", "planned_question"]

_LARGEST_TILE = 1024  # points along a side; one takes a kilobyte while a tile is computed
_MOST_TILES = 10**6  # a file for each variable of each


def plan_map(
    store: str | Path,
    system: System,
    over: Mapping[str, npt.ArrayLike],
    *,
    tile: int = 64,
    refine: int = 0,
    initial: Mapping[str, float] | None = None,
    transient: int = 200,
    record: int = 100,
    evidence: int = 500,
    longest: int | None = None,
    confirm: int = 10_000,
    phase: float = 0.0,
    period: float | str | None = None,
    match: float = 1e-6,
    parameters: Mapping[str, float] | None = None,
    tolerance: float = 1e-12,
    mode: str | None = None,
) -> xr.Dataset:
    """Plan a map of regimes over two parameters that many processes compute together.

    Nothing is computed yet: `work` does that, here or on any machine that reaches the folder, and
    `open_map` reads what is there. The map has the variables of `nonsmooth.regime_map`, and the
    same digits where a point is computed; there is no limit to its size.

    Parameters
    ----------
    store : str or Path
        Folder of the map, made where it is missing: a Zarr store. A folder that was planned with
        the same options stays as it is, so every job may begin with the same call.
    system : System
        The system; it needs a period, or ``period``. It is kept in the store as text.
    over : mapping of str to array_like
        Two parameters and their values, which grow: the first one is the horizontal axis of a
        picture.
    tile : int, optional
        Points along each side of a tile, which one thread computes at a time. A tile that its
        worker does not finish is begun anew.
    refine : int, optional
        How often cells of the map are halved where labels differ, as in `nonsmooth.regime_map`; the
        points of a tile are then those of the refined map. ``tile`` is a multiple of 2 to this
        power.
    initial : mapping of str to float, optional
        Initial state as in `simulate`, the same everywhere. States that are not given are those at
        rest, for each point anew.

    Other Parameters
    ----------------
    transient, record, evidence : int, optional
        As in `regime`.
    longest, confirm : int, optional
        As in `regime`. A chaotic point takes most of the time; a smaller ``confirm`` saves a part.
    phase : float, optional
        As in `regime`.
    period : float or str, optional
        As in `regime`; an expression is evaluated at each point.
    match : float, optional
        As in `regime`.
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.
    mode : str, optional
        Mode to start in, where several would fit; a cell, or a mode for any of its cells.

    Returns
    -------
    xarray.Dataset
        How far the job is, as `progress` tells it.

    Raises
    ------
    OptionError
        For a folder that holds something else, or a map that was planned with other options or by
        another version; and for what `nonsmooth.regime_map` refuses.
    RunError
        Where the store could not be written, for want of room for one.

    See Also
    --------
    work : compute what is missing.
    forecast : how long that will take.
    nonsmooth.regime_map : the same in one process, with refined borders.

    Notes
    -----
    A tile depends on no other one. So there are no motions that follow each other along a row
    (``start`` of `nonsmooth.regime_map`): every point is computed from its own start. With
    ``refine`` each tile halves its own cells. Where a label is found between two corners on the
    edge of a tile, the cell beyond that edge is not halved for it, as `nonsmooth.regime_map` would
    do. So near edges of tiles some points are filled that `nonsmooth.regime_map` computes, and
    their labels may be others; `computed` tells which points are filled. With ``refine=0`` all
    points are the same.

    Examples
    --------
    >>> import tempfile
    >>> import nonsmooth as ns
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     job = ns.cluster.plan_map(
    ...         f"{folder}/map.zarr",
    ...         ns.models.soft_impact(),
    ...         {"omega": [0.7, 0.8, 0.9], "zeta": [0.01, 0.05]},
    ...         tile=2,
    ...     )
    >>> print(job.attrs["message"])
    0 of 2 tiles are done
    """
    side = whole_number("tile", tile)
    if side > _LARGEST_TILE:
        raise OptionError(f"tile = {side} must be at most {_LARGEST_TILE}; 64 is usual")
    levels = check_levels(refine)
    if side % 2**levels:
        raise OptionError(
            f"tile = {side} and refine = {levels}: a tile is made of whole cells; give a multiple"
            f" of {2**levels}"
        )
    if initial is not None and (hasattr(initial, "data_vars") or not isinstance(initial, Mapping)):
        raise OptionError(
            "initial: give the states as numbers, such as {'x': 0.1, 'v': 0.0}; other processes"
            " begin from them"
        )
    question = ask_map(
        "plan_map", system, over, initial=initial, transient=transient, record=record,
        evidence=evidence, longest=longest, confirm=confirm, phase=phase, period=period,
        match=match, parameters=parameters, tolerance=tolerance, mode=mode,
    )  # fmt: skip
    first, second = (refined_values(values, levels) for values in question.values)
    question = replace(question, values=(first, second))
    shape = (second.size, first.size)
    count = -(-shape[0] // side) * -(-shape[1] // side)
    if count > _MOST_TILES:
        raise OptionError(
            f"tile = {side}: {shape[1]} times {shape[0]} points are {count} tiles, at most"
            f" {_MOST_TILES:g}; take a larger tile="
        )
    planned = make_store(store, _empty(question, levels), _plan_of(question, side, levels, shape))
    return progress(planned.folder)


def _plan_of(
    question: MapQuestion, side: int, levels: int, shape: tuple[int, int]
) -> dict[str, Any]:
    """What a store keeps of a question, from which `planned_question` makes it again."""
    told = question.recorded | question.told
    period = question.period
    return {
        "names": list(question.names),
        "values": question.values,
        "shape": list(shape),
        "tile": side,
        "levels": levels,
        "protocol": plain(told),
        "question": {
            "regime": asdict(question.protocol),
            "period": period if period is None or isinstance(period, str) else float(period),
            "mode": question.mode,
            "tolerance": float(question.tolerance),
        },
    }


def planned_question(store: TileStore) -> MapQuestion:
    """The question of a store."""
    protocol, kept = store.plan["protocol"], store.plan["question"]
    first, second = store.plan["names"]
    return MapQuestion(
        System.from_toml(protocol["system"]),
        (first, second),
        store.values(),
        RegimeProtocol(**kept["regime"]),
        kept["period"],
        dict(protocol["initial"]),
        kept["mode"],
        kept["tolerance"],
        protocol["changed_parameters"],
    )


def _empty(question: MapQuestion, levels: int) -> xr.Dataset:
    """The map with one point of which nothing is known; `work` writes the others."""
    options = {"start": "restart", "initial": said_of_start(question.initial), "refine": levels}
    options |= {"fill": "labels", **question.recorded}
    one = (question.values[0][:1], question.values[1][:1])
    empty = map_dataset(
        question.system, question.names, one, np.full((1, 1), None), np.zeros((0, 2), int), options
    )
    for name in ("status", "message"):  # which `open_map` tells
        del empty.attrs[name]
    return empty
