"""What of the chapter is done in a folder: an entry for each figure and each claim.

An entry says what the result depends on, and of a figure the digests of its files. It is written
last, so what has an entry is whole unless somebody changed it later, which the digests tell.
"""

from __future__ import annotations

import hashlib
import inspect
import json
import os
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from nonsmooth import OptionError
from nonsmooth_chapter.code_version import code_version, library_versions
from nonsmooth_chapter.files import plain, replacing

__all__ = ["ENTRIES", "basis", "locked", "read_entry", "remove_drafts", "write_entry"]

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
