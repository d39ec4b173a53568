"""Folders of results: files that appear whole, and what is done already from the same code."""

from __future__ import annotations

import csv
import hashlib
import inspect
import json
import math
import os
import platform
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import nonsmooth as ns
from nonsmooth import OptionError

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "ENTRIES",
    "basis",
    "code_version",
    "library_versions",
    "locked",
    "plain",
    "processors",
    "read_entry",
    "remove_drafts",
    "replacing",
    "save_data",
    "save_json",
    "save_table",
    "unknown_name",
    "write_entry",
]


# Files of figures, tables and claims: netCDF, CSV, JSON; they appear whole or not at all.


@contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """Give a temporary path beside a file, and move it to the file's place on success.

    A reader, or a crash half way, never meets half a file. The process number keeps two
    programs that write the same file apart.
    """
    draft = target.with_name(f".{target.stem}.{os.getpid()}{target.suffix}")
    try:
        yield draft
        os.replace(draft, target)
    finally:
        draft.unlink(missing_ok=True)


def processors() -> int:
    """Number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return max(1, len(os.sched_getaffinity(0)))
    return os.cpu_count() or 1


def unknown_name(kind: str, name: str, known: Iterable[str]) -> str:
    """Sentence for a name that does not exist: the nearest one, and where all are listed."""
    near = get_close_matches(name, list(known), n=1)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    return f"unknown {kind} {name!r:.80}{hint} (known: {', '.join(known)})"


def save_data(data: xr.Dataset, path: Path) -> Path:
    """Write a dataset as netCDF.

    Parameters
    ----------
    data : xarray.Dataset
        The data.
    path : pathlib.Path
        File to write; its folder exists.

    Returns
    -------
    pathlib.Path
        The file.

    Examples
    --------
    >>> import tempfile
    >>> import xarray as xr
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_data(xr.Dataset({"x": 1.0}), Path(folder) / "x.nc").name
    'x.nc'
    """
    with replacing(path) as draft:
        data.to_netcdf(draft, engine="h5netcdf")
    return path


def save_table(rows: Sequence[Mapping[str, Any]], path: Path) -> Path:
    """Write rows with the same keys as a CSV file with a header.

    Parameters
    ----------
    rows : sequence of mapping
        The rows, at least one.
    path : pathlib.Path
        File to write; its folder exists.

    Returns
    -------
    pathlib.Path
        The file.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_table([{"b": 0.15, "v": 31.3}], Path(folder) / "t.csv").read_text().split()
    ['b,v', '0.15,31.3']
    """
    with replacing(path) as draft, draft.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
    return path


def save_json(value: Any, path: Path) -> Path:
    """Write a value as JSON.

    Parameters
    ----------
    value : object
        Mappings, lists, numbers and texts, see `plain`.
    path : pathlib.Path
        File to write; its folder exists.

    Returns
    -------
    pathlib.Path
        The file.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_json({"v": 1.5}, Path(folder) / "v.json").read_text().split()
    ['{', '"v":', '1.5', '}']
    """
    with replacing(path) as draft:
        draft.write_text(json.dumps(plain(value), indent=2, ensure_ascii=False), encoding="utf-8")
    return path


def plain(value: Any) -> Any:
    """Value in the types of JSON, which has neither arrays of numpy nor infinities.

    Parameters
    ----------
    value : object
        Mappings, lists, arrays, numbers and texts.

    Returns
    -------
    object
        The same; None for what is not finite, and text for what JSON has no type for.

    Examples
    --------
    >>> import numpy as np
    >>> plain({"v": np.array([1.0, np.inf])})
    {'v': [1.0, None]}
    """
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if value is None or isinstance(value, str | bool | int | float):
        return value
    return str(value)


# Which code computes: the version of the library, and a digest of its files and the study's.

_LIBRARY, _STUDY = Path(ns.__file__).parent, Path(__file__).parent
# They print and lay out what is computed elsewhere; no number depends on them.
_NO_NUMBERS = (
    _LIBRARY / "cli",
    _STUDY / "command.py",
    _STUDY / "figures.toml",
    _STUDY / "report.py",
)
_SUFFIXES = (".py", ".json", ".toml")
_LIBRARIES = ("numpy", "scipy", "matplotlib", "xarray")


@cache
def code_version() -> str:
    """Version of the library, and what tells its files and the study's from another state of them.

    Commands and the layout of reports do not count.

    Returns
    -------
    str

    Examples
    --------
    >>> code_version().partition("+")[0]
    '0.1.0'
    """
    digest = hashlib.sha256()
    for package in (_LIBRARY, _STUDY):
        for path in sorted(package.rglob("*")):
            counts = not any(path.is_relative_to(part) for part in _NO_NUMBERS)
            if path.suffix in _SUFFIXES and counts:
                digest.update(path.relative_to(package).as_posix().encode())
                digest.update(hashlib.sha256(path.read_bytes()).digest())
    return f"{ns.__version__}+{digest.hexdigest()[:12]}"


@cache
def library_versions() -> dict[str, str]:
    """Versions of Python and of the libraries that digits may depend on.

    Returns
    -------
    dict of str to str

    Examples
    --------
    >>> sorted(library_versions())
    ['matplotlib', 'numpy', 'python', 'scipy', 'xarray']
    """
    found = {"python": platform.python_version()}
    return found | {name: version(name) for name in _LIBRARIES}


# What of the chapter is done in a folder: an entry for each figure and each claim.
#
# An entry says what the result depends on, and of a figure the digests of its files. It is written
# last, so what has an entry is whole unless somebody changed it later, which the digests tell.

ENTRIES = "entries"  # folder of them, within that of the results
_DRAFT = re.compile(r"\.[\w-]+\.\d+\.(png|pdf|nc|json|html)")  # see `replacing`


def basis(function: Callable[..., Any]) -> dict[str, Any]:
    """All that a result depends on: code, libraries, and the options by default.

    Parameters
    ----------
    function : callable
        What computes.

    Returns
    -------
    dict

    Examples
    --------
    >>> basis(lambda columns=400: None)["options"]
    {'columns': 400}
    """
    arguments = inspect.signature(function).parameters.values()
    options = {each.name: each.default for each in arguments if each.default is not each.empty}
    return {
        "code": code_version(),
        "libraries": library_versions(),
        "options": plain(options),
    }


def write_entry(
    folder: Path, name: str, depends: dict[str, Any], files: Sequence[Path], told: dict[str, Any]
) -> None:
    """Say that something is done.

    Parameters
    ----------
    folder : pathlib.Path
        Folder of the results.
    name : str
        Figure or claim.
    depends : dict
        Result of `basis`.
    files : sequence of pathlib.Path
        Files of the result, in the folder.
    told : dict
        What else to keep.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_entry(Path(folder), "M03", {}, [], {"verdict": "differs"})
    ...     read_entry(Path(folder), "M03", {})["verdict"]
    'differs'
    """
    entry = {
        "name": name,
        "basis": depends,
        "files": {path.name: _digest(path) for path in files},
        "told": plain(told),
    }
    place = folder / ENTRIES
    place.mkdir(exist_ok=True)
    with replacing(place / f"{name}.json") as draft:
        draft.write_text(json.dumps(entry, indent=1, ensure_ascii=False), encoding="utf-8")


def read_entry(folder: Path, name: str, depends: dict[str, Any]) -> dict[str, Any] | None:
    """What was kept beside a result, None where it has to be computed.

    Parameters
    ----------
    folder : pathlib.Path
        Folder of the results.
    name : str
        Figure or claim.
    depends : dict
        Result of `basis` now.

    Returns
    -------
    dict or None
        None without an entry, for another basis, and where a file is missing or changed.

    Examples
    --------
    >>> read_entry(Path("nowhere"), "M03", {})
    """
    try:
        entry = json.loads((folder / ENTRIES / f"{name}.json").read_text(encoding="utf-8"))
        whole = entry["name"] == name and entry["basis"] == depends
        if whole and all(
            _digest(folder / file) == digest for file, digest in entry["files"].items()
        ):
            told: dict[str, Any] = entry["told"]
            return told
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        pass  # damaged, or of another kind: computed again
    return None


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Keep other runs out of a folder, by a lock on a file in it.

    The system's own locks end with the process that holds them, however it ends, so the file that
    a killed process leaves behind locks nobody out. The process number in it is for people.

    Parameters
    ----------
    path : pathlib.Path
        File to lock; made where it is missing.

    Raises
    ------
    OptionError
        Where another process has locked it.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder, locked(Path(folder) / "lock"):
    ...     print("nobody else is here")
    nobody else is here
    """
    with open(path, "a+", encoding="utf-8") as file:  # a file that another process reads stays
        try:
            _lock(file.fileno())
        except OSError:
            file.seek(0)
            owner = file.read() or "of another user"
            raise OptionError(
                f"the store {str(path.parent)!r} is in use by process {owner}; wait until it ends,"
                " or give another folder"
            ) from None
        file.truncate(0)
        file.write(str(os.getpid()))
        file.flush()
        try:
            yield
        finally:
            file.truncate(0)


if sys.platform == "win32":
    import msvcrt

    def _lock(handle: int) -> None:
        """Lock a byte far behind the number, which others can still read then."""
        os.lseek(handle, 1 << 30, os.SEEK_SET)
        msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        os.lseek(handle, 0, os.SEEK_SET)

else:
    import errno
    import fcntl

    def _lock(handle: int) -> None:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as fault:
            # some network file systems have no locks; there the user sees to it
            if fault.errno not in (errno.ENOLCK, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS):
                raise


def remove_drafts(folder: Path) -> None:
    """Remove half-written files that a process left behind which was ended.

    Parameters
    ----------
    folder : pathlib.Path
        Folder of the results, which no other process uses.

    Examples
    --------
    >>> remove_drafts(Path("nowhere"))
    """
    for place in (folder, folder / ENTRIES):
        if place.is_dir():
            for path in place.iterdir():
                if _DRAFT.fullmatch(path.name):
                    path.unlink(missing_ok=True)


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
