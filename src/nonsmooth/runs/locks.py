"""A file that one process at a time can lock, by what the operating system has for it.

The system's own locks end with the process that holds them, however it ends, so the file that a
killed process leaves behind locks nobody out. The process number in it is for people.
"""

from __future__ import annotations

import os
import sys
import time
import warnings
from pathlib import Path

from nonsmooth.errors import OptionError, ResultWarning

__all__ = ["lock", "unlock"]

_LOOK = 0.02  # seconds between two looks at the lock of another process
_FAR = 1 << 30  # byte that Windows locks: others can still read the number at the beginning


def lock(path: Path, patience: float | None = None) -> int:
    """Lock a file, made where it is missing; returns what `unlock` takes.

    With ``patience`` it is waited for so many seconds, and a file system without locks is taken as
    it is; without, another process that has the lock is an error at once.
    """
    handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    deadline = time.monotonic() + (patience or 0.0)
    try:
        while not _take(handle, must=patience is None):
            if time.monotonic() >= deadline:
                raise OptionError(
                    f"the store {str(path.parent)!r} is in use by process {_owner(handle)}; wait"
                    " until it ends, or give another folder"
                )
            time.sleep(_LOOK)
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

    def _take(handle: int, must: bool) -> bool:
        """Lock a file unless another process has."""
        del must  # every file can be locked
        os.lseek(handle, _FAR, os.SEEK_SET)
        try:
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        os.lseek(handle, 0, os.SEEK_SET)
        return True

else:
    import fcntl

    def _take(handle: int, must: bool) -> bool:
        """Lock a file unless another process has; where it ``must``, warn of what has no locks."""
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        except OSError as fault:  # some network file systems have no locks
            if must:
                warnings.warn(
                    f"the store cannot be locked ({fault.strerror}); see to it that no other"
                    " process uses it at the same time",
                    ResultWarning,
                    stacklevel=6,
                )
        return True
