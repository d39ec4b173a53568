"""Results of long work in a folder, task by task: what is done stays done.

The folder holds ``protocol.json``, which tells what is computed and how, one file of arrays for
each task that is done, and ``lock``. Files appear whole or not at all, so the work may be ended at
any moment, by a full disk or by loss of power, and goes on where it was.

Tasks are cut by the work alone, never by the number of threads, so a task that was done yesterday
fits today, and digits do not depend on threads. HDF5 does not survive a full disk, so the files of
tasks are ``.npz`` files with a checksum.

A store belongs to one process, or it is shared by all that make the same call. Then the lock is
held only while they agree on the protocol, and claims say who computes which task.
"""

from __future__ import annotations

import errno
import hashlib
import io
import json
import os
import re
import shutil
import sys
import time
import warnings
import zipfile
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, ResultWarning, RunError, quote
from nonsmooth.files import replacing
from nonsmooth.runs.claims import PATIENCE, clear_claims, make_claim_folders
from nonsmooth.runs.locks import lock, unlock
from nonsmooth.runs.memory import size_text
from nonsmooth.runs.protocols import differences, plain
from nonsmooth.version import __version__

__all__ = [
    "Damaged",
    "Store",
    "check_store",
    "part_of_store",
    "read_arrays",
    "reserve",
    "task_key",
    "tasks_of",
    "trouble",
    "write_arrays",
]

_PART = re.compile(r"part-\d{5}")  # a store of several
_SUFFIX = ".npy"  # of the arrays within the file, as `numpy.load` expects it
_DIGITS = 64  # of a checksum over all that stands before it, the comment at the end of the file
_FORMAT = 1
_PROTOCOL, _LOCK = "protocol.json", "lock"
_CHUNK = re.compile(r"(\d{6,})\.npz")
_DRAFT = re.compile(r"\.(\d{6,}|protocol|result)\.\d+\.(npz|json|nc)")  # see `replacing`
_STALE = 600.0  # seconds after which a draft in a shared store is none of a living process
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_MAY_NOT = (errno.EACCES, errno.EPERM, errno.EROFS)
_MOST_NAMED = 5  # damaged files in a message
_CANNOT = (errno.EINVAL, errno.ENOSYS, errno.EOPNOTSUPP)  # file systems that do not reserve


class Damaged(Exception):
    """A file that does not hold what was written; says what is wrong with it."""


def write_arrays(path: Path, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
    """Write arrays by name; nothing in them needs pickle."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, array in arrays.items():
            with archive.open(name + _SUFFIX, "w", force_zip64=True) as file:
                np.lib.format.write_array(file, np.asarray(array), allow_pickle=False)
        archive.comment = b"0" * _DIGITS
    content = buffer.getbuffer()
    content[-_DIGITS:] = _checksum(content[:-_DIGITS])
    with replacing(path) as draft:
        draft.write_bytes(content)


def read_arrays(path: Path) -> dict[str, npt.NDArray[Any]]:
    """Arrays of a file by name; `Damaged` where a single bit of it has changed."""
    with np.load(io.BytesIO(_whole_content(path)), allow_pickle=False) as archive:
        return dict(archive.items())


def _whole_content(path: Path) -> memoryview:
    """Content of a file of arrays; `Damaged` where its checksum is wrong."""
    try:
        content = memoryview(path.read_bytes())
    except OSError as fault:
        raise Damaged(fault.strerror) from None
    if len(content) < _DIGITS or content[-_DIGITS:] != _checksum(content[:-_DIGITS]):
        raise Damaged("its checksum is wrong")
    return content


def _checksum(content: memoryview) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()


class Store:
    """Arrays of each task of a computation, in a folder; see `Store.open`."""

    def __init__(self, folder: Path, handle: int | None) -> None:
        self.folder = folder
        self.done: set[int] = set()
        self.read_only = False
        self._handle: int | None = handle

    @classmethod
    def open(
        cls,
        path: str | Path,
        protocol: Mapping[str, Any],
        n_tasks: int,
        *,
        shared: bool = False,
    ) -> Store:
        """Store in a folder, made where it is missing, for this process alone unless ``shared``.

        ``protocol`` holds every option that the results depend on, by the name that users know:
        numbers, texts, arrays, and lists and mappings of these; and as its ``call`` the function
        that was called; ``follow`` are names of options that were not given and follow from others.
        A folder of another protocol is refused. Chunks that are damaged are told, removed, and
        count as not done.
        """
        folder = _folder(path)
        _refuse_strangers(folder)
        whole = {
            "format": _FORMAT,
            "nonsmooth_version": __version__,
            "tasks": n_tasks,
            "protocol": plain(protocol),
        }
        try:
            store = cls(folder, lock(folder / _LOCK, PATIENCE if shared else None))
        except OSError as fault:
            if shared and fault.errno in _MAY_NOT and (folder / _PROTOCOL).exists():
                return cls._read_only(folder, whole, fault)
            raise trouble(folder, _LOCK, fault) from fault
        try:
            store._agree(whole)
            if shared:
                store.close()  # to read what is there may take longer than others wait
            store._clear_drafts(_STALE if shared else 0.0)
            store._find(n_tasks)
            if shared:
                make_claim_folders(folder)
                clear_claims(folder, map(task_key, store.done))
        except OSError as fault:
            store.close()
            raise trouble(folder, "a file in it", fault) from fault
        except BaseException:
            store.close()
            raise
        return store

    @classmethod
    def _read_only(cls, folder: Path, whole: dict[str, Any], fault: OSError) -> Store:
        """Store in which nothing can be written; of use where all its tasks are done."""
        store = cls(folder, None)
        store.read_only = True
        store._agree(whole)
        store._find(whole["tasks"])
        if len(store.done) < whole["tasks"]:
            raise trouble(folder, _LOCK, fault) from fault
        return store

    def put(self, i: int, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
        """Keep the arrays of a task; `RunError` where they could not be written."""
        path = self._chunk(i)
        try:
            write_arrays(path, arrays)
        except OSError as fault:
            raise trouble(self.folder, path.name, fault) from fault
        self.done.add(i)

    def is_done(self, i: int) -> bool:
        """Whether anybody has done a task; opened, as network file systems keep old listings."""
        try:
            with self._chunk(i).open("rb"):
                return True
        except FileNotFoundError:
            return False

    def get(self, i: int) -> dict[str, npt.NDArray[Any]]:
        """Arrays of a task that is done."""
        path = self._chunk(i)
        try:
            return read_arrays(path)
        except Damaged as fault:
            raise RunError(
                f"the store {str(self.folder)!r}: {path.name} was damaged on the way: {fault}; the"
                " same call computes it again"
            ) from None

    def forget(self, numbers: Iterable[int]) -> None:
        """Count tasks as not done."""
        for i in numbers:
            self._chunk(i).unlink(missing_ok=True)
            self.done.discard(i)

    def close(self) -> None:
        """Let other processes use the folder."""
        if self._handle is not None:
            unlock(self._handle)
            self._handle = None

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _chunk(self, i: int) -> Path:
        return self.folder / f"{task_key(i)}.npz"

    def _agree(self, whole: dict[str, Any]) -> None:
        """Write the protocol, or compare it with the one that is there."""
        path = self.folder / _PROTOCOL
        if not path.exists():
            try:
                with replacing(path) as draft:
                    draft.write_text(json.dumps(whole, indent=1), encoding="utf-8")
            except OSError as fault:
                raise trouble(self.folder, _PROTOCOL, fault) from fault
        try:
            before = json.loads(path.read_text(encoding="utf-8"))
            former = {**before.pop("protocol"), **before}
        except (OSError, ValueError, AttributeError, KeyError, TypeError):
            raise OptionError(
                f"store = {str(self.folder)!r}: {_PROTOCOL} in it is none that this version can"
                " read; give another folder"
            ) from None
        now = {**whole.pop("protocol"), **whole}
        held, call = former.pop("call", None), now.pop("call", None)
        if held not in (None, call):  # former stores do not say; options of two calls have no match
            raise OptionError(
                f"store = {str(self.folder)!r} belongs to another kind of call: it holds results of"
                f" {held}, not of {call}; give another folder"
            )
        follow = now.pop("follow", [])
        also = former.pop("follow", follow)  # former stores do not say
        different = differences(former, now, [name for name in follow if name in also])
        if different:
            raise OptionError(
                f"store = {str(self.folder)!r} was begun with other options:\n"
                + "\n".join(f"  {line}" for line in different)
                + "\nrepeat the options as they were to go on, or give another folder"
            )

    def _clear_drafts(self, age: float) -> None:
        """Remove what processes that were killed have left half written, so long ago or more."""
        latest = time.time() - age
        for path in self.folder.iterdir():
            if _DRAFT.fullmatch(path.name):
                with suppress(FileNotFoundError):  # it has just become whole
                    if path.stat().st_mtime <= latest:
                        path.unlink()

    def _find(self, n_tasks: int) -> None:
        """See which tasks are done; loss of power may have left less than was written."""
        damaged = []
        for path in sorted(self.folder.iterdir()):
            match = _CHUNK.fullmatch(path.name)
            if match is None or int(match[1]) >= n_tasks:
                continue
            try:
                _whole_content(path)
            except Damaged as fault:
                damaged.append(f"{path.name} ({fault})")
                with suppress(OSError):  # somebody else has removed it, or nobody may
                    path.unlink()
            else:
                self.done.add(int(match[1]))
        if damaged:
            more = f" and {len(damaged) - _MOST_NAMED} more" if len(damaged) > _MOST_NAMED else ""
            warnings.warn(
                f"the store {str(self.folder)!r} has damaged files, which are computed again:"
                f" {', '.join(damaged[:_MOST_NAMED])}{more}",
                ResultWarning,
                stacklevel=5,
            )


def tasks_of(folder: Path) -> tuple[int, dict[int, float]] | None:
    """Tasks of the store in a folder, and when each that is done was written; None for no store."""
    try:
        count = int(json.loads((folder / _PROTOCOL).read_text(encoding="utf-8"))["tasks"])
    except (OSError, ValueError, KeyError, TypeError):
        return None
    done = {}
    for path in folder.iterdir():
        match = _CHUNK.fullmatch(path.name)
        if match is not None and int(match[1]) < count:
            with suppress(FileNotFoundError):  # it was damaged, and has just been removed
                done[int(match[1])] = path.stat().st_mtime
    return count, done


def task_key(i: int) -> str:
    """Name of a task in its file and its claim."""
    return f"{i:06d}"


def check_store(store: str | Path | None) -> None:
    """Refuse a folder that cannot be a store, before long work whose results it would keep."""
    if store is not None:
        _refuse_strangers(_folder(store))


def part_of_store(store: str | Path, number: int) -> Path:
    """Folder of one of several stores in one folder, for long work made of long works."""
    folder = _folder(store)
    for path in folder.iterdir():
        if not _PART.fullmatch(path.name):
            raise OptionError(
                f"store = {str(folder)!r} is no store of such work, and not empty: it holds"
                f" {path.name!r}; give a new folder"
            )
    return folder / f"part-{number:05d}"


def _folder(path: str | Path) -> Path:
    """Folder of a store, made where it is missing."""
    if not isinstance(path, str | os.PathLike) or not str(path):
        raise OptionError(f"store = {quote(path)}: give the path of a folder")
    folder = Path(path)
    try:
        folder.mkdir(exist_ok=True)
    except FileNotFoundError:
        if folder.parent.is_dir():  # as folders of the operating system say, which take no others
            raise OptionError(
                f"store = {str(path)!r}: no folder can be made in {str(folder.parent)!r}; choose"
                " another place"
            ) from None
        raise OptionError(
            f"store = {str(path)!r}: the folder {str(folder.parent)!r} does not exist; make it"
            " first"
        ) from None
    except (FileExistsError, NotADirectoryError):
        raise OptionError(
            f"store = {str(path)!r} is a file, or lies in one; give the path of a folder"
        ) from None
    except OSError as fault:
        raise trouble(folder, "the folder", fault) from fault
    return folder


def _refuse_strangers(folder: Path) -> None:
    """A folder without a protocol is empty but for what an earlier attempt left."""
    if (folder / _PROTOCOL).exists():
        return
    for path in folder.iterdir():
        if path.name != _LOCK and not _DRAFT.fullmatch(path.name):
            if (folder / _PROTOCOL).exists():  # another process has just written it
                return
            raise OptionError(
                f"store = {str(folder)!r} is no store, and not empty: it holds {path.name!r} and no"
                f" {_PROTOCOL}; give a new folder"
            )


def trouble(folder: Path, name: str, fault: OSError) -> OptionError | RunError:
    """What to say of a file that could not be written."""
    what = f"the store {str(folder)!r}: {name} could not be written: {fault.strerror or fault}"
    if fault.errno in _FULL:
        return RunError(
            f"{what}. What is done is kept: make room and repeat the same call, and it goes on",
            status="interrupted",
        )
    if fault.errno in _MAY_NOT:
        return OptionError(f"{what}; give a folder in which files may be made")
    return RunError(
        f"{what}. What is done is kept: repeat the same call, and it goes on", status="interrupted"
    )


def reserve(path: Path, size: int) -> None:
    """Take room on disk for a file that is written next; `OSError` where there is not enough.

    For files whose writers do not survive a full disk, as HDF5 does not.
    """
    free = shutil.disk_usage(path.parent).free
    if size > free:
        need = f"{size_text(size)} are needed, and {size_text(free)} are free"
        raise OSError(errno.ENOSPC, f"{os.strerror(errno.ENOSPC)}, {need}")
    if sys.platform == "linux":  # the file system may have quotas as well
        with path.open("wb") as file:
            try:
                os.posix_fallocate(file.fileno(), 0, size)
            except OSError as fault:
                if fault.errno not in _CANNOT:
                    raise
