"""`progress` and `open_map`: how far a map is, and the map itself, read from its store alone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.cluster.task_progress import (
    STATES,
    is_folder_of_tasks,
    message_of,
    task_progress,
)
from nonsmooth.cluster.tile_store import TileStore, told_of_damage
from nonsmooth.cluster.whole_chunks import checked_store
from nonsmooth.runs.claims import CLAIMS, is_recent
from nonsmooth.version import __version__

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["open_map", "progress", "progress_of"]

_TIMED = 256  # tiles of which the time is read


def progress(store: str | Path) -> xr.Dataset:
    """Tell how far long work is, from its folder alone.

    Parameters
    ----------
    store : str or Path
        Folder that `plan_map` has made, or that was given to a function as ``store=``.

    Returns
    -------
    xarray.Dataset
        Of a map in tiles: ``state`` over ``row`` and ``column`` of the tiles, with CF flags:
        ``missing``, ``claimed`` by a worker that gives signs of life, ``done``, ``failed``. The
        counts ``tiles``, ``done``, ``claimed`` and ``failed``; ``tile_seconds``, the mean time of a
        tile that is done; ``rate``, tiles per second while so many are claimed; and ``time_left``
        in seconds, nan where nobody is at work. ``reason``, over ``failure``: why the tiles of
        ``failed_tile`` failed. The attribute ``status`` is ``completed`` or ``incomplete``.

        Of other work: ``state`` over ``task``, with the folder of each as ``part``; ``tasks``,
        ``done``, ``claimed``, ``rate`` and ``time_left``. Work in steps, such as the refinement of
        a map, has its next step only when it begins.

    Raises
    ------
    OptionError
        Where the folder is no such store, or of another format.

    See Also
    --------
    open_map : the map itself.

    Notes
    -----
    Whether a claim counts is told by the clock of this machine and that of the file server; where
    they differ by minutes, ``claimed`` and ``time_left`` are wrong, and nothing else.

    Examples
    --------
    >>> import tempfile
    >>> import nonsmooth as ns
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     over = {"omega": [0.7, 0.8, 0.9], "zeta": [0.01, 0.05]}
    ...     _ = ns.cluster.plan_map(f"{folder}/map.zarr", ns.models.soft_impact(), over, tile=2)
    ...     job = ns.cluster.progress(f"{folder}/map.zarr")
    >>> int(job["tiles"]), int(job["done"])
    (2, 0)
    """
    if is_folder_of_tasks(store):
        return task_progress(Path(store))
    return progress_of(TileStore.open(store))


def progress_of(store: TileStore) -> xr.Dataset:
    """How far a store is that is open."""
    import xarray as xr

    done, failures = store.done(), store.failures()
    states = np.zeros(store.count, np.int8)
    for path in (store.job / CLAIMS).glob("[0-9]*.[0-9]*"):
        row, _, column = path.name.partition(".")
        number = int(row) * store.tiles[1] + int(column)
        if number < store.count and is_recent(store.job, path.name):
            states[number] = STATES.index("claimed")
    failed = sorted(set(failures) - done)
    states[failed] = STATES.index("failed")
    states[sorted(done)] = STATES.index("done")
    claimed = int(np.count_nonzero(states == STATES.index("claimed")))
    mean = _mean_time(store, sorted(done))
    left = store.count - len(done) - len(failed)
    rate = claimed / mean if claimed else np.nan
    flags = {"flag_values": np.arange(4, dtype=np.int8), "flag_meanings": " ".join(STATES)}
    variables: dict[str, Any] = {
        "state": (("row", "column"), states.reshape(store.tiles), {"long_name": "state", **flags}),
        "tiles": ((), store.count, {"long_name": "tiles of the map"}),
        "done": ((), len(done), {"long_name": "tiles that are done"}),
        "claimed": ((), claimed, {"long_name": "tiles that are under way"}),
        "failed": ((), len(failed), {"long_name": "tiles that could not be computed"}),
        "tile_seconds": ((), mean, {"long_name": "mean time of a tile", "units": "s"}),
        "rate": ((), rate, {"long_name": "tiles per unit time", "units": "1/s"}),
        "time_left": ((), left / rate if left else 0.0, {"long_name": "time left", "units": "s"}),
        "failed_tile": ("failure", np.array(failed, np.int64), {"long_name": "number of a tile"}),
        "reason": ("failure", np.array([failures[each] for each in failed], str)),
    }
    message = message_of("tiles", store.count, len(done), claimed, len(failed))
    status = "completed" if len(done) == store.count else "incomplete"
    return xr.Dataset(variables, attrs={
        "store": str(store.folder), "status": status, "message": message,
        "nonsmooth_version": __version__,
    })  # fmt: skip


def _mean_time(store: TileStore, done: list[int]) -> float:
    """Mean time of tiles, of some of them where they are many."""
    if not done:
        return float("nan")
    chosen = done[:: max(1, len(done) // _TIMED)]
    took = store.seconds(chosen)
    return float(np.nanmean(took)) if np.any(np.isfinite(took)) else float("nan")


def open_map(store: str | Path) -> xr.Dataset:
    """Open a map in tiles; what you use of it is read then, so it need not fit into memory.

    Parameters
    ----------
    store : str or Path
        Folder that `plan_map` has made. Workers may still add to it.

    Returns
    -------
    xarray.Dataset
        The variables of `nonsmooth.regime_map` over the second and the first parameter. Points of
        tiles that are not done have the regime ``interrupted``, and nan, 0 or no text elsewhere.
        The attributes ``status`` and ``message`` say how far the map is.

    Raises
    ------
    OptionError
        Where the folder is no such store, or of another format.
    RunError
        When values are used whose file is damaged; `work` computes its tile again.

    See Also
    --------
    nonsmooth.plot.regime_map : draw it, or a part of it.

    Notes
    -----
    Take a part with ``isel`` or ``sel`` before you draw or compute: of a map of 30000 times 30000
    points a picture shows every tenth. Any program that knows Zarr reads the folder as well.

    Examples
    --------
    >>> import tempfile
    >>> import nonsmooth as ns
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     over = {"omega": [0.7, 0.8, 0.9], "zeta": [0.01, 0.05]}
    ...     _ = ns.cluster.plan_map(f"{folder}/map.zarr", ns.models.soft_impact(), over, tile=2)
    ...     _ = ns.cluster.work(f"{folder}/map.zarr", threads=1)
    ...     grid = ns.cluster.open_map(f"{folder}/map.zarr").load()
    >>> grid["period"].values.tolist()
    [[1, 5, 0], [1, 1, 2]]
    """
    import xarray as xr

    opened = TileStore.open(store)
    done = len(opened.done())
    for name in (*opened.plan["names"], *opened.plan["variables"]):
        opened.check(name)
    with told_of_damage(opened.folder, "zarr.json"):
        data = xr.open_dataset(
            checked_store(opened.folder),
            engine="zarr",
            consolidated=False,
            chunks=None,
            mask_and_scale=False,
            decode_times=False,
        )
    ordered = data[opened.plan["variables"]]
    for name in ordered.data_vars:
        flags = ordered[name].attrs.get("flag_values")
        if flags is not None:
            ordered[name].attrs["flag_values"] = np.array(flags, np.int8)
    return ordered.assign_attrs(
        status="completed" if done == opened.count else "interrupted",
        message=message_of("tiles", opened.count, done, 0, 0),
    )
