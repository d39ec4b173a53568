"""The one place that says how kernels are compiled and cached.

numba caches machine code per function and looks only at the file of that function, so an
upgrade that changes a helper in another file would run old code. Here the identity of
every cached kernel holds a hash of all kernel sources.
"""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import FunctionCache

__all__ = ["allocating", "entry", "inlined", "is_warm", "kernel", "sources_hash"]

# contract, nsz and arcp keep the certificate valid; reassoc and nnan would not
_OPTIONS: dict[str, Any] = {
    "fastmath": {"contract", "nsz", "arcp"},
    "error_model": "numpy",
    "nogil": True,
}


def sources_hash(folder: Path | None = None) -> str:
    """Hash of all kernel sources, the files of this package."""
    folder = folder or Path(__file__).parent
    digest = hashlib.sha256()
    for path in sorted(folder.glob("*.py")):
        digest.update(path.name.encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


_SOURCES = sources_hash()


class _KernelCache(FunctionCache):
    """numba's file cache with the hash of all kernel sources in the key."""

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        return (*super()._index_key(sig, codegen), _SOURCES)


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that other kernels call; it lives in its callers' cache.

    Without numba's memory manager: allocating is an error, and arrays are passed without
    reference counts, whose atomic updates cost more than the arithmetic of a small kernel.
    """
    return numba.njit(**_OPTIONS, _nrt=False)(function)


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a kernel into its callers.

    For the parts of the loop that take many arrays: numba passes an array as seven words
    by value, and a call with thirty arrays costs as much as a guard evaluation.
    """
    return numba.njit(**_OPTIONS, _nrt=False, forceinline=True)(function)


def allocating(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that kernels call and that may allocate; for set-up only."""
    return numba.njit(**_OPTIONS)(function)


def entry(function: Callable[..., Any], *, allocates: bool = False) -> Callable[..., Any]:
    """Compile a function that Python calls, cached on disk where a place can be written."""
    dispatcher = numba.njit(**_OPTIONS, _nrt=allocates)(function)
    # without a writable place it is compiled anew in each process: slow but right
    with contextlib.suppress(RuntimeError, OSError):
        dispatcher._cache = _KernelCache(function)
    return dispatcher


def is_warm(dispatcher: Any) -> bool:
    """Whether a kernel is compiled already, in this process or in the cache on disk."""
    if getattr(dispatcher, "signatures", True):  # plain functions when jitting is switched off
        return True
    cache = getattr(dispatcher, "_cache", None)
    if not isinstance(cache, _KernelCache):
        return False
    keys = cache._cache_file._load_index()
    return any(key[-1] == _SOURCES for key in keys)
