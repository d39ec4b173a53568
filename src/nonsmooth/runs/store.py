"""Results of long work in a folder, task by task: what is done stays done.

The folder holds ``protocol.json``, which tells what is computed and how, one file of arrays for
each task that is done, and ``lock``. Files appear whole or not at all, so the work may be ended at
any moment, by a full disk or by loss of power, and goes on where it was.

Tasks are cut by the work alone, never by the number of threads, so a task that was done yesterday
fits today, and digits do not depend on threads. HDF5 does not survive a full disk, so the files of
tasks are ``.npz`` files with a checksum.
"""

from __future__ import annotations

import errno
import json
import os
import re
import warnings
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy.typing as npt

from nonsmooth.errors import OptionError, ResultWarning, RunError
from nonsmooth.files import replacing
from nonsmooth.runs.chunk_file import Damaged, read_arrays, write_arrays
from nonsmooth.runs.protocol import differences, plain
from nonsmooth.runs.store_lock import lock, unlock
from nonsmooth.version import __version__

__all__ = ["Store", "trouble"]

_FORMAT = 1
_PROTOCOL, _LOCK = "protocol.json", "lock"
_CHUNK = re.compile(r"(\d{6,})\.npz")
_DRAFT = re.compile(r"\.(\d{6,}|protocol|result)\.\d+\.(npz|json|nc)")  # see `replacing`
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_MOST_NAMED = 5  # damaged files in a message


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


def _folder(path: str | Path) -> Path:
    """Folder of a store, made where it is missing."""
    if not isinstance(path, str | os.PathLike) or not str(path):
        raise OptionError(f"store = {path!r:.60}: give the path of a folder")
    folder = Path(path)
    try:
        folder.mkdir(exist_ok=True)
    except FileNotFoundError:
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
