"""Results of long work in a folder, task by task: what is done stays done.

With the lock that keeps other processes out, and the room on disk and in memory that there is.

The folder holds ``protocol.json``, which tells what is computed and how, one file of arrays for
each task that is done, and ``lock``. Files appear whole or not at all, so the work may be ended at
any moment, by a full disk or by loss of power, and goes on where it was.

Tasks are cut by the work alone, never by the number of threads, so a task that was done yesterday
fits today, and digits do not depend on threads. HDF5 does not survive a full disk, so the files of
tasks are ``.npz`` files with a checksum.

The system's own locks end with the process that holds them, however it ends, so the file that a
killed process leaves behind locks nobody out. The process number in it is for people.
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
import threading
import warnings
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, ResultWarning, RunError
from nonsmooth.files import replacing
from nonsmooth.runs.crew import run_tasks
from nonsmooth.runs.memory import size_text
from nonsmooth.runs.protocols import differences, plain
from nonsmooth.version import __version__

__all__ = [
    "Damaged",
    "Store",
    "check_store",
    "lock",
    "part_of_store",
    "read_arrays",
    "reserve",
    "run_stored_tasks",
    "trouble",
    "unlock",
    "write_arrays",
]

T = TypeVar("T")

_PART = re.compile(r"part-\d{5}")  # a store of several
_SUFFIX = ".npy"  # of the arrays within the file, as `numpy.load` expects it
_DIGITS = 64  # of a checksum over all that stands before it, the comment at the end of the file
_FORMAT = 1
_PROTOCOL, _LOCK = "protocol.json", "lock"
_CHUNK = re.compile(r"(\d{6,})\.npz")
_DRAFT = re.compile(r"\.(\d{6,}|protocol|result)\.\d+\.(npz|json|nc)")  # see `replacing`
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_MOST_NAMED = 5  # damaged files in a message
_FAR = 1 << 30  # byte that Windows locks: others can still read the number at the beginning
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
    try:
        content = memoryview(path.read_bytes())
    except OSError as fault:
        raise Damaged(fault.strerror) from None
    if len(content) < _DIGITS or content[-_DIGITS:] != _checksum(content[:-_DIGITS]):
        raise Damaged("its checksum is wrong")
    with np.load(io.BytesIO(content), allow_pickle=False) as archive:
        return dict(archive.items())


def _checksum(content: memoryview) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()


class Store:
    """Arrays of each task of a computation, in a folder; see `Store.open`."""

    def __init__(self, folder: Path, handle: int) -> None:
        self.folder = folder
        self.done: set[int] = set()
        self._handle: int | None = handle

    @classmethod
    def open(cls, path: str | Path, protocol: Mapping[str, Any], n_tasks: int) -> Store:
        """Store in a folder, made where it is missing, for this process alone.

        ``protocol`` holds every option that the results depend on, by the name that users know:
        numbers, texts, arrays, and lists and mappings of these. A folder of another protocol is
        refused. Chunks that are damaged are told, and count as not done.
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
            store = cls(folder, lock(folder / _LOCK))
        except OSError as fault:
            raise trouble(folder, _LOCK, fault) from fault
        try:
            store._agree(whole)
            store._find(n_tasks)
        except BaseException:
            store.close()
            raise
        return store

    def put(self, i: int, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
        """Keep the arrays of a task; `RunError` where they could not be written."""
        path = self._chunk(i)
        try:
            write_arrays(path, arrays)
        except OSError as fault:
            raise trouble(self.folder, path.name, fault) from fault
        self.done.add(i)

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
        return self.folder / f"{i:06d}.npz"

    def _agree(self, whole: dict[str, Any]) -> None:
        """Write the protocol, or compare it with the one that is there."""
        path = self.folder / _PROTOCOL
        if not path.exists():
            try:
                with replacing(path) as draft:
                    draft.write_text(json.dumps(whole, indent=1), encoding="utf-8")
            except OSError as fault:
                raise trouble(self.folder, _PROTOCOL, fault) from fault
            return
        try:
            before = json.loads(path.read_text(encoding="utf-8"))
            former = {**before.pop("protocol"), **before}
        except (OSError, ValueError, AttributeError, KeyError, TypeError):
            raise OptionError(
                f"store = {str(self.folder)!r}: {_PROTOCOL} in it is none that this version can"
                " read; give another folder"
            ) from None
        now = {**whole.pop("protocol"), **whole}
        different = differences(former, now)
        if different:
            raise OptionError(
                f"store = {str(self.folder)!r} was begun with other options:\n"
                + "\n".join(f"  {line}" for line in different)
                + "\nrepeat the options as they were to go on, or give another folder"
            )

    def _find(self, n_tasks: int) -> None:
        """See which tasks are done; loss of power may have left less than was written."""
        damaged = []
        for path in sorted(self.folder.iterdir()):
            if _DRAFT.fullmatch(path.name):  # of a process that was killed
                path.unlink(missing_ok=True)
            match = _CHUNK.fullmatch(path.name)
            if match is None or int(match[1]) >= n_tasks:
                continue
            try:
                read_arrays(path)
            except Damaged as fault:
                damaged.append(f"{path.name} ({fault})")
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
        raise OptionError(f"store = {path!r:.60}: give the path of a folder")
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
    if fault.errno in (errno.EACCES, errno.EPERM, errno.EROFS):
        return OptionError(f"{what}; give a folder in which files may be made")
    return RunError(
        f"{what}. What is done is kept: repeat the same call, and it goes on", status="interrupted"
    )


def run_stored_tasks(
    tasks: list[Callable[[Any, threading.Event], T]],
    make_worker: Callable[[], Any],
    *,
    store: str | Path | None,
    protocol: Mapping[str, Any],
    pack: Callable[[T], Mapping[str, npt.NDArray[Any]]],
    unpack: Callable[[dict[str, npt.NDArray[Any]]], T],
    threads: int,
    label: str,
    keep: Callable[[int, T], None],
    after: Mapping[int, int] | None = None,
    parts: bool = False,
) -> bool:
    """Run tasks as `run_tasks` does, those that the folder ``store`` has not done already.

    ``protocol`` is all that the results depend on, see `Store.open`. ``pack`` makes arrays of a
    result, and ``unpack`` the same result of them. ``keep`` is told every result, former or new,
    and where there are ``parts`` also those of tasks that were stopped: these are not stored.
    """
    keep_part = keep if parts else None
    if store is None:
        return run_tasks(
            tasks, make_worker, threads=threads, label=label, keep=keep, after=after,
            keep_part=keep_part,
        )  # fmt: skip
    with Store.open(store, protocol, len(tasks)) as folder:
        done = frozenset(folder.done)
        for i in sorted(done):
            keep(i, unpack(folder.get(i)))

        def keep_both(i: int, result: T) -> None:
            folder.put(i, pack(result))
            keep(i, result)

        return run_tasks(
            tasks, make_worker, threads=threads, label=label, keep=keep_both, done=done,
            after=after, keep_part=keep_part,
        )  # fmt: skip


def lock(path: Path) -> int:
    """Lock a file, made where it is missing; returns what `unlock` takes."""
    handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        if not _take(handle):
            raise OptionError(
                f"the store {str(path.parent)!r} is in use by process {_owner(handle)}; wait until"
                " it ends, or give another folder"
            )
        os.ftruncate(handle, 0)
        os.write(handle, str(os.getpid()).encode())
    except BaseException:
        os.close(handle)
        raise
    return handle


def unlock(handle: int) -> None:
    """Let others in. The file stays: who has it open already would lock one that is gone."""
    try:
        os.ftruncate(handle, 0)
    finally:
        os.close(handle)


def _owner(handle: int) -> str:
    os.lseek(handle, 0, os.SEEK_SET)
    return os.read(handle, 20).decode(errors="replace") or "of another user"


if sys.platform == "win32":
    import msvcrt

    def _take(handle: int) -> bool:
        """Lock a file unless another process has."""
        os.lseek(handle, _FAR, os.SEEK_SET)
        try:
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        os.lseek(handle, 0, os.SEEK_SET)
        return True

else:
    import fcntl

    def _take(handle: int) -> bool:
        """Lock a file unless another process has."""
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        except OSError as fault:  # some network file systems have no locks
            warnings.warn(
                f"the store cannot be locked ({fault.strerror}); see to it that no other process"
                " uses it at the same time",
                ResultWarning,
                stacklevel=6,
            )
        return True


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
