"""How much memory and disk there is, for results that may not fit."""

from __future__ import annotations

import errno
import os
import shutil
import sys
from pathlib import Path

__all__ = ["free_memory", "reserve", "size_text"]

_CANNOT = (errno.EINVAL, errno.ENOSYS, errno.EOPNOTSUPP)  # file systems that do not reserve
_UNKNOWN = 4 * 2**30  # bytes, where the system does not tell


def free_memory() -> int:
    """Bytes of memory that could be used without harm to others."""
    try:
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    except (OSError, ValueError, IndexError):
        pass  # not Linux
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2
    except (AttributeError, ValueError, OSError):
        return _UNKNOWN


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


def size_text(size: float) -> str:
    """A number of bytes for people."""
    for unit in ("bytes", "kB", "MB", "GB"):
        if size < 999.5:
            return f"{size:.3g} {unit}"
        size /= 1000.0
    return f"{size:.3g} TB"
