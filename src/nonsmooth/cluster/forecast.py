"""`forecast`: how long a map in tiles will take and how much room it needs, from a sample of it."""

from __future__ import annotations

import threading
import time
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.options import check_seed
from nonsmooth.cluster.plan_map import planned_question
from nonsmooth.cluster.tile_map import tile_points
from nonsmooth.cluster.tile_store import Tile, TileStore
from nonsmooth.errors import OptionError
from nonsmooth.runs.crew import check_threads, run_tasks
from nonsmooth.runs.memory import size_text
from nonsmooth.runs.options import whole_number
from nonsmooth.runs.sweep_runner import SweepRunner
from nonsmooth.version import __version__

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["forecast"]

_TOGETHER = 64  # neighbours that are computed side by side, as in a tile
_CELLS = 8  # along each side of a square that is refined as a tile is
_LEAST = 8  # places of which a mean and its error tell something
_WEIGHED = 64  # tiles that are done and whose size is read
_UNITS = ((86400.0, "d"), (3600.0, "h"), (60.0, "min"), (1.0, "s"))

Floats = npt.NDArray[np.float64]


def forecast(
    store: str | Path, *, sample: int = 128, threads: int | None = None, seed: int = 0
) -> xr.Dataset:
    """Tell how long the rest of a map in tiles will take here, and how large its store will be.

    Parameters
    ----------
    store : str or Path
        Folder that `plan_map` has made.
    sample : int, optional
        Number of places at which up to 64 neighbouring points are computed and timed: one place at
        random in each of as many equal parts of the map. Their results are not kept.
    threads : int, optional
        Number of threads; without it, one for each processor. The forecast is for as many.
    seed : int, optional
        Seed of the random numbers: the same seed gives the same result. Here the same places, as
        times differ from call to call.

    Returns
    -------
    xarray.Dataset
        ``seconds``, that `work` would take here for the tiles that are not done, with the standard
        error ``seconds_error``; ``point_seconds``, of one thread; ``points`` that are left;
        ``bytes`` of the whole store: at most so many before a tile is done, then by those that are
        done. The attribute ``message`` says it in words.

    Raises
    ------
    OptionError
        Where the folder is no such store, is of another format or version, or the sample is too
        small.
    KeyboardInterrupt
        After Ctrl-C: a part of the sample would not stand for the map.

    Notes
    -----
    A place counts for its part of the map, and its points are computed as a tile would compute
    them, in all threads at once. So the time holds what the threads cost each other, and what else
    runs on the machine. To write a tile takes some tenths of a second more. Costs of points differ
    a hundredfold between periodic and chaotic motions; many places with few points each tell more
    than a few whole tiles would in the same time.

    For other machines, divide: twice as many equal processors take half of the time.
    The samples run on the processor, also where `use_device` has chosen a graphics device: the time
    is that of processors alone.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     over = {"omega": np.linspace(0.7, 0.9, 40), "zeta": np.linspace(0.01, 0.05, 30)}
    ...     _ = ns.cluster.plan_map(
    ...         f"{folder}/map.zarr", ns.models.soft_impact(), over, confirm=100
    ...     )
    ...     cost = ns.cluster.forecast(f"{folder}/map.zarr", sample=8, threads=1)
    >>> print(cost.attrs["message"])
    1200 points are left: ... on 1 thread; the store takes at most ...
    """
    import xarray as xr

    opened = TileStore.open(store)
    opened.check_version()
    places, workers = whole_number("sample", sample), check_threads(threads)
    if places < _LEAST:
        raise OptionError(f"sample = {places}: give {_LEAST} places or more")
    generator = np.random.default_rng(check_seed(seed))
    done = opened.done()
    chosen = _places(opened, done, places, generator)
    times = _times(opened, chosen, workers)
    left = sum(_points(opened, number) for number in range(opened.count) if number not in done)
    # of one thread; a place near the edge of a map has fewer points
    counts = np.array([_area(*place) for place in chosen])
    each = times.sum() / counts.sum() if chosen else 0.0
    scatter = np.std(times - each * counts, ddof=1) if len(chosen) > 1 else 0.0
    error = float(scatter * np.sqrt(len(chosen)) / counts.sum()) if chosen else 0.0
    size, known = _size(opened, done)
    seconds, doubt = left * each / workers, left * error / workers
    threads_text = "1 thread" if workers == 1 else f"{workers} threads"
    message = (
        f"{left} points are left: {_duration(seconds)} on {threads_text}; the store takes"
        f" {'about' if known else 'at most'} {size_text(size)}"
    )
    return xr.Dataset(
        {
            "seconds": ((), seconds, {"long_name": "time for the rest", "units": "s"}),
            "seconds_error": ((), doubt, {"long_name": "standard error of it", "units": "s"}),
            "point_seconds": ((), each, {"long_name": "time of a point", "units": "s"}),
            "points": ((), left, {"long_name": "points that are left"}),
            "bytes": ((), size, {"long_name": "size of the whole store", "units": "bytes"}),
        },
        attrs={
            "store": str(opened.folder), "message": message, "threads": workers,
            "sample": len(chosen), "nonsmooth_version": __version__,
        },
    )  # fmt: skip


Place = tuple[slice, slice]  # rows and columns


def _places(
    store: TileStore, done: set[int], count: int, generator: np.random.Generator
) -> list[Place]:
    """Neighbours within a tile at a random place of each part of the map, where that is missing."""
    height, width = store.shape
    across = int(np.clip(round(np.sqrt(count * width / height)), 1, width))
    down = int(np.clip(round(count / across), 1, height))
    rows, columns = (
        np.linspace(0, size, parts + 1).astype(int)
        for size, parts in ((height, down), (width, across))
    )
    found = {}
    for top, bottom in pairwise(rows):
        for left, right in pairwise(columns):
            row, column = int(generator.integers(top, bottom)), int(generator.integers(left, right))
            number = row // store.tile * store.tiles[1] + column // store.tile
            if number in done:
                continue
            place = _around(store, store.at(number), row, column)
            found[place[0].start, place[1].start] = place
    return list(found.values())


def _around(store: TileStore, tile: Tile, row: int, column: int) -> Place:
    """Neighbours of a point in its tile: those of its row, or a square of cells to be refined."""
    across = _TOGETHER if store.levels == 0 else min(_CELLS * 2**store.levels, store.tile)
    down = 1 if store.levels == 0 else across
    top = tile.rows.start + (row - tile.rows.start) // down * down
    left = tile.columns.start + (column - tile.columns.start) // across * across
    return (
        slice(top, min(top + down, tile.rows.stop)),
        slice(left, min(left + across, tile.columns.stop)),
    )


def _overhang(store: TileStore) -> float:
    """Points that a tile computes beyond its edges, and a place beyond its own: their ratio.

    Per point inside; what is computed there costs as much as elsewhere.
    """
    if store.levels == 0:
        return 1.0
    step = 2**store.levels
    side = min(_CELLS * step, store.tile)
    return ((1.0 + step / store.tile) / (1.0 + step / side)) ** 2


def _times(store: TileStore, places: list[Place], threads: int) -> Floats:
    """Seconds that each place takes, with all threads at work."""
    question, share = planned_question(store), _overhang(store)

    def task(place: Place, runner: SweepRunner, stop: threading.Event) -> float:
        began = time.perf_counter()
        tile_points(question, store.levels, *place, runner, stop)
        return share * (time.perf_counter() - began)

    def runner() -> SweepRunner:
        return SweepRunner(question.system, question.tolerance)

    times = np.zeros(len(places))
    if places:
        task(places[0], runner(), threading.Event())  # loads what runs need
    complete = run_tasks(
        [partial(task, place) for place in places],
        runner,
        threads=threads,
        label="sample of the map",
        keep=times.__setitem__,
    )
    if not complete:
        raise KeyboardInterrupt
    return times


def _points(store: TileStore, number: int) -> int:
    tile = store.at(number)
    return _area(tile.rows, tile.columns)


def _area(rows: slice, columns: slice) -> int:
    return int((rows.stop - rows.start) * (columns.stop - columns.start))


def _size(store: TileStore, done: set[int]) -> tuple[float, bool]:
    """Bytes of the whole store, and whether tiles that are done tell them."""
    total = store.shape[0] * store.shape[1]
    if not done:
        return float(total * store.bytes_per_point), False
    chosen = sorted(done)[:: max(1, len(done) // _WEIGHED)]
    return store.size(chosen) * total / sum(_points(store, number) for number in chosen), True


def _duration(seconds: float) -> str:
    """A time in words, with about two digits."""
    for length, unit in _UNITS:
        if seconds >= 2.0 * length:
            number = seconds / length
            return f"about {number:.2g} {unit}" if number < 10.0 else f"about {number:.0f} {unit}"
    return "less than 2 s" if seconds else "no time"
