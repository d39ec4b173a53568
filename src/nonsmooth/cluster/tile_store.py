"""A map as a Zarr store in a folder, tile by tile; whoever reaches the folder may compute a tile.

All state of a job lies here, and none in a scheduler. The root of the store is the map as a
dataset: one array for each variable, a chunk of it for each tile. The group ``tiles`` holds the
plan in its attributes, and the array ``seconds``, whose entry is written last: with it a tile
counts as done. Plain files beside it keep claims, workers and failures.

Zarr writes a chunk beside its place and moves it there, so a worker that is killed leaves a whole
chunk or none, and a tile may be computed twice without harm. Loss of power can still leave less
than was written. Every chunk therefore ends with its checksum, and `TileStore.damaged` looks.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import secrets
import shutil
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from nonsmooth.cluster.whole_chunks import is_whole
from nonsmooth.errors import OptionError, quote
from nonsmooth.files import replacing
from nonsmooth.runs.claims import make_claim_folders
from nonsmooth.runs.protocols import differences
from nonsmooth.runs.store import tasks_of, trouble
from nonsmooth.version import __version__

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Tile", "TileStore", "make_store", "need_zarr", "told_of_damage"]

FORMAT = 2  # of the store
_FAILURES = "tiles/failures"
_PLAN, _SECONDS = "tiles", "tiles/seconds"
_METADATA = "zarr.json"
_WORD = 64  # bytes


class Tile(NamedTuple):
    """A rectangle of a map: its row and column among the tiles, and its points."""

    row: int
    column: int
    rows: slice  # of the second parameter
    columns: slice  # of the first parameter

    @property
    def key(self) -> str:
        """The tile in names of files."""
        return f"{self.row}.{self.column}"


class TileStore:
    """A store that was planned; see `make_store`."""

    def __init__(self, folder: Path, plan: dict[str, Any]) -> None:
        self.folder = folder
        self.plan = plan
        self.shape: tuple[int, int] = (plan["shape"][0], plan["shape"][1])
        self.tile: int = plan["tile"]
        self.levels: int = plan["levels"]
        self.tiles = (-(-self.shape[0] // self.tile), -(-self.shape[1] // self.tile))
        self.count = self.tiles[0] * self.tiles[1]
        self._arrays: dict[str, Any] = {}

    @property
    def job(self) -> Path:
        """Folder in which workers keep their claims."""
        return self.folder / _PLAN

    @classmethod
    def open(cls, path: str | Path) -> TileStore:
        """Store in a folder; refused where there is none, or one of another format."""
        need_zarr()
        folder = _folder(path)
        plan = _read_plan(folder)
        if plan is None and tasks_of(folder) is not None:
            raise OptionError(
                f"store = {str(folder)!r} is that of a call with store=, and no map in tiles;"
                " repeat the call to go on with it, or to read its result"
            )
        if plan is None:
            there = "no store" if folder.exists() else "there is nothing"
            raise OptionError(
                f"store = {str(folder)!r}: {there}; make one with nonsmooth.cluster.plan_map, or"
                " nonsmooth plan"
            )
        if plan.get("format") != FORMAT:
            raise OptionError(
                f"store = {str(folder)!r} has the format {plan.get('format')!r}, and nonsmooth"
                f" {__version__} reads {FORMAT}; use nonsmooth {plan.get('version')}, which made"
                " it, or plan a new store"
            )
        with told_of_damage(folder, _METADATA):
            _check_root(folder)
        return cls(folder, plan)

    def check_version(self) -> None:
        """Refuse to add to what another version has begun: its digits may differ."""
        if self.plan["version"] != __version__:
            raise OptionError(
                f"store = {str(self.folder)!r} was begun with nonsmooth {self.plan['version']}, and"
                f" this is {__version__}, whose digits may differ; install that version to go on,"
                " or plan a new store"
            )

    @property
    def identity(self) -> str:
        """Hash of the plan, by which processes tell this job from others."""
        return hashlib.sha256(json.dumps(self.plan, sort_keys=True).encode()).hexdigest()

    def at(self, number: int) -> Tile:
        """Tile of a number; they are counted along the first parameter."""
        row, column = divmod(number, self.tiles[1])
        size = self.tile
        rows = slice(row * size, min((row + 1) * size, self.shape[0]))
        columns = slice(column * size, min((column + 1) * size, self.shape[1]))
        return Tile(row, column, rows, columns)

    def number(self, tile: Tile) -> int:
        """Number of a tile."""
        return tile.row * self.tiles[1] + tile.column

    def values(self) -> tuple[np.ndarray, np.ndarray]:
        """Values of both parameters."""
        first, second = (np.asarray(self._array(name)[:]) for name in self.plan["names"])
        return first, second

    def check(self, name: str) -> None:
        """Refuse a store in which an array is not described."""
        self._array(name)

    def is_done(self, tile: Tile) -> bool:
        """Whether a tile is done; the file is opened, as network file systems keep old listings."""
        try:
            with self._chunk(_SECONDS, tile).open("rb"):
                return True
        except (FileNotFoundError, NotADirectoryError):
            return False

    def done(self) -> set[int]:
        """Numbers of the tiles that are done, by the names of their files alone."""
        return {
            row * self.tiles[1] + column
            for row, name in _entries(self.folder / _SECONDS / "c")
            for column, _ in _entries(self.folder / _SECONDS / "c" / name)
        }

    def put(self, tile: Tile, found: xr.Dataset, seconds: float) -> None:
        """Keep the variables of a tile, and then that it is done."""
        for name in self._variables:
            self._array(name)[tile.rows, tile.columns] = found[name].values
        self._array(_SECONDS)[tile.row, tile.column] = seconds
        self._failure(tile).unlink(missing_ok=True)

    def damaged(self, tile: Tile) -> str:
        """What is wrong with the chunks of a tile that is done, "" where nothing is."""
        for name in (*self._variables, _SECONDS):
            try:
                content = self._chunk(name, tile).read_bytes()
            except FileNotFoundError:
                return f"{name} is missing"
            except OSError as fault:
                return f"{name} cannot be read: {fault.strerror}"
            if not is_whole(content):
                return f"the checksum of {name} is wrong"
        return ""

    def forget(self, tile: Tile) -> None:
        """Count a tile as not done, and remove its chunks: writing one may read the old one."""
        for name in (_SECONDS, *self._variables):
            self._chunk(name, tile).unlink(missing_ok=True)

    def seconds(self, numbers: list[int]) -> np.ndarray:
        """How long the computation of some tiles took; nan of those that are not done."""
        took = []
        for number in numbers:
            tile = self.at(number)
            try:
                took.append(float(self._array(_SECONDS)[tile.row, tile.column]))
            except ValueError:  # a torn chunk
                took.append(np.nan)
        return np.array(took)

    def size(self, numbers: list[int]) -> int:
        """Bytes of the chunks of some tiles."""
        total = 0
        for number in numbers:
            for name in (*self._variables, _SECONDS):
                with suppress(FileNotFoundError):
                    total += self._chunk(name, self.at(number)).stat().st_size
        return total

    @property
    def bytes_per_point(self) -> int:
        """Bytes of a point before they are compressed; a word counts as some modes."""
        return sum(
            _WORD if self._array(name).dtype.kind == "T" else self._array(name).dtype.itemsize
            for name in self._variables
        )

    def fail(self, tile: Tile, fault: BaseException) -> None:
        """Keep why a tile could not be computed."""
        text = f"{type(fault).__name__}: {fault}"
        with replacing(self._failure(tile)) as draft:
            draft.write_text(json.dumps({"reason": text}), encoding="utf-8")

    def failures(self) -> dict[int, str]:
        """Why tiles could not be computed, by their numbers."""
        found = {}
        for path in sorted((self.folder / _FAILURES).glob("*.json")):
            row, _, column = path.stem.partition(".")
            with suppress(OSError, ValueError, KeyError):
                number = int(row) * self.tiles[1] + int(column)
                found[number] = str(json.loads(path.read_text(encoding="utf-8"))["reason"])
        return found

    def forget_failures(self, numbers: Iterable[int]) -> None:
        """Count tiles as not yet tried."""
        for number in numbers:
            self._failure(self.at(number)).unlink(missing_ok=True)

    def _failure(self, tile: Tile) -> Path:
        return self.folder / _FAILURES / f"{tile.key}.json"

    def _chunk(self, name: str, tile: Tile) -> Path:
        return self.folder / name / "c" / str(tile.row) / str(tile.column)

    def _array(self, name: str) -> Any:
        """An array of the store; chunks of it are written even where nothing is known of a tile."""
        import zarr

        if name not in self._arrays:
            with told_of_damage(self.folder, f"{name}/{_METADATA}"):
                array = zarr.open_array(self.folder / name, mode="r+", zarr_format=3)
            self._arrays[name] = array.with_config({"write_empty_chunks": True})
        return self._arrays[name]

    @property
    def _variables(self) -> list[str]:
        return list(self.plan["variables"])


@contextmanager
def told_of_damage(folder: Path, name: str) -> Iterator[None]:
    """Say what to do where the description of a map or of a variable cannot be read."""
    try:
        yield
    except (ValueError, KeyError, TypeError, FileNotFoundError) as fault:
        raise OptionError(
            f"store = {str(folder)!r}: {name} in it is damaged or missing"
            f" ({type(fault).__name__}); plan the same map in a new folder, and copy this file from"
            " there: what is done is then read again"
        ) from fault


def need_zarr() -> None:
    """Refuse to go on without the libraries of the extra."""
    try:
        import google_crc32c
        import zarr
    except ImportError as fault:
        raise OptionError(
            f"maps in tiles need the library {fault.name!r}; install it with pip install"
            " 'nonsmooth[cluster]'"
        ) from None
    del google_crc32c, zarr


def make_store(path: str | Path, empty: xr.Dataset, plan: dict[str, Any]) -> TileStore:
    """Write the store of a plan, or compare the plan with that of the store that is there.

    ``empty`` has one point, of which nothing is known: each variable of it becomes an array that
    is filled with its value there. The store appears whole, so any number of processes may plan the
    same job at the same time.
    """
    need_zarr()
    folder = _folder(path)
    plan = {
        "format": FORMAT, "version": __version__, "variables": list(map(str, empty.data_vars)),
        **plan,
    }  # fmt: skip
    if folder.is_dir() and not any(folder.iterdir()):
        with suppress(OSError):
            folder.rmdir()
    if not folder.exists():
        draft = folder.with_name(f".{folder.name}.{secrets.token_hex(8)}")
        try:
            _write(draft, empty, plan)
            os.rename(draft, folder)
        except OSError as fault:
            if fault.errno not in (errno.ENOTEMPTY, errno.EEXIST):
                raise trouble(folder, "the plan", fault) from fault
        finally:
            shutil.rmtree(draft, ignore_errors=True)
    before = _read_plan(folder)
    if before is None:
        raise OptionError(
            f"store = {str(folder)!r} is no store of a map in tiles, and not empty; give a new"
            " folder"
        )
    store = TileStore.open(folder)
    store.check_version()
    different = differences(_flat(before), _flat(plan))
    if different:
        raise OptionError(
            f"store = {str(folder)!r} was begun with other options:\n"
            + "\n".join(f"  {line}" for line in different)
            + "\nrepeat the options as they were to go on, or give another folder"
        )
    return store


def _flat(plan: Mapping[str, Any]) -> dict[str, Any]:
    own = {"tile": plan["tile"], "refine": plan["levels"], "parameters": plan["names"]}
    return {**plan["protocol"], **own}


def _write(folder: Path, empty: xr.Dataset, plan: dict[str, Any]) -> None:
    """Arrays without chunks, with the values of the parameters, and the plan."""
    import zarr
    from zarr.codecs import Crc32cCodec, ZstdCodec

    codecs = (ZstdCodec(level=3), Crc32cCodec())
    names, shape, tile = plan["names"], tuple(plan["shape"]), plan["tile"]
    group = zarr.create_group(folder, zarr_format=3, attributes=_native(empty.attrs))
    for name, values in zip(names, plan.pop("values"), strict=True):
        axis = group.create_array(
            name, shape=values.shape, chunks=values.shape, dtype="float64", compressors=codecs,
            dimension_names=(name,), attributes=_native(empty[name].attrs),
        )  # fmt: skip
        axis[:] = values
    for name, variable in empty.data_vars.items():
        text = variable.dtype.kind == "U"
        group.create_array(
            str(name), shape=shape, chunks=(tile, tile), compressors=codecs,
            dtype="string" if text else variable.dtype, fill_value=variable.values[0, 0].item(),
            dimension_names=tuple(map(str, variable.dims)), attributes=_native(variable.attrs),
        )  # fmt: skip
    tiles = group.create_group("tiles", attributes={"plan": plan})
    counts = tuple(-(-size // tile) for size in shape)
    tiles.create_array(
        "seconds", shape=counts, chunks=(1, 1), dtype="float64", fill_value=np.nan,
        compressors=codecs, dimension_names=("row", "column"),
        attributes={"long_name": "time the tile took; nan where it is not done", "units": "s"},
    )  # fmt: skip
    make_claim_folders(folder / _PLAN)
    (folder / _FAILURES).mkdir()


def _native(attributes: Mapping[Any, Any]) -> dict[str, Any]:
    """Attributes as JSON has them."""
    return {
        str(name): value.tolist() if isinstance(value, np.ndarray | np.generic) else value
        for name, value in attributes.items()
    }


def _read_plan(folder: Path) -> dict[str, Any] | None:
    """Plan of the store in a folder; None where it holds none."""
    try:
        text = (folder / _PLAN / _METADATA).read_text(encoding="utf-8")
        plan = json.loads(text)["attributes"]["plan"]
    except (FileNotFoundError, NotADirectoryError, KeyError, ValueError, TypeError):
        return None
    except OSError as fault:
        raise OptionError(
            f"store = {str(folder)!r} cannot be read: {fault.strerror}; ask its owner for the right"
            " to read it"
        ) from fault
    return plan if isinstance(plan, dict) else None


def _check_root(folder: Path) -> None:
    """Raise a `ValueError` where the description of the whole map is none of a group."""
    root = json.loads((folder / _METADATA).read_text(encoding="utf-8"))
    if not isinstance(root, dict) or root.get("node_type") != "group" or "attributes" not in root:
        raise ValueError("it does not describe a group")


def _folder(path: Any) -> Path:
    if not isinstance(path, str | os.PathLike) or not str(path):
        raise OptionError(f"store = {quote(path)}: give the path of a folder")
    folder = Path(path)
    if folder.parent.exists() and not folder.parent.is_dir():
        raise OptionError(f"store = {str(path)!r} lies in a file; give the path of a folder")
    if not folder.parent.is_dir():
        raise OptionError(
            f"store = {str(path)!r}: the folder {str(folder.parent)!r} does not exist; make it"
            " first"
        )
    if folder.exists() and not folder.is_dir():
        raise OptionError(f"store = {str(path)!r} is a file; give the path of a folder")
    return folder


def _entries(folder: Path) -> Iterator[tuple[int, str]]:
    """Numbers that are names in a folder; drafts of writers that were killed are none."""
    try:
        names = os.listdir(folder)
    except (FileNotFoundError, NotADirectoryError):
        return
    for name in names:
        if name.isdecimal():
            yield int(name), name
