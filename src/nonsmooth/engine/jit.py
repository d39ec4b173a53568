"""The one place that says how kernels are compiled and cached.

numba caches machine code per function and looks only at the file of that function, so an
upgrade that changes a helper in another file would run old code. Here the name of every
cache file holds a hash of all kernel sources, and one of the processor and of numba. A cache
that cannot be read or written costs time and never a result.
"""

from __future__ import annotations

import contextlib
import hashlib
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.registry import cpu_target

__all__ = [
    "allocating",
    "entry",
    "inlined",
    "is_kept",
    "is_warm",
    "kernel",
    "sources_hash",
]

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


_SOURCES = sources_hash()[:16]
_MAKER = f"numba {numba.__version__} for {cpu_target.target_context.codegen().magic_tuple()}"
_IDENTITY = f"{_SOURCES}-{hashlib.sha256(_MAKER.encode()).hexdigest()[:16]}"

_named_folder, _own_folder, *_other_folders = CompileResultCacheImpl._locator_classes


def _file_name(function: str) -> str:
    return f"{function}-{_IDENTITY}.{sys.implementation.cache_tag}"


class _MadeAhead:
    """The folder of the installation where the code is there already, writable or not."""

    @staticmethod
    def from_function(function: Any, path: str) -> Any:
        folder = _own_folder(function, path)
        name = _file_name(f"{Path(path).stem}.{function.__qualname__}")
        return folder if Path(folder.get_cache_path(), f"{name}.nbi").exists() else None


class _Files(CompileResultCacheImpl):
    """Where the files of a kernel are, and their names."""

    _locator_classes = (_named_folder, _MadeAhead, _own_folder, *_other_folders)

    def get_filename_base(self, function: str, abiflags: str) -> str:
        return _file_name(function)


class _KernelCache(FunctionCache):
    """numba's file cache under these names; faults of the disk are no faults of a run."""

    _impl_class = _Files

    def load_overload(self, signature: Any, target: Any) -> Any:
        try:
            return super().load_overload(signature, target)
        except Exception:  # files cut short, as by a crash of the machine
            with contextlib.suppress(OSError):
                self.flush()
            return None

    def save_overload(self, signature: Any, data: Any) -> None:
        try:
            super().save_overload(signature, data)
        except Exception as fault:
            warnings.warn(
                f"compiled kernels could not be kept in {self.cache_path} ({fault}); the next"
                " process compiles them again",
                RuntimeWarning,
                stacklevel=2,
            )
            return
        function = self._impl.filename_base.partition("-")[0]
        for path in Path(self.cache_path).glob(f"{function}-*.nb[ci]*"):
            if _SOURCES not in path.name:  # of an older version of this installation
                with contextlib.suppress(OSError):
                    path.unlink()


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


def is_kept(dispatcher: Any) -> bool:
    """Whether there is a place on disk for the machine code of a kernel."""
    return isinstance(getattr(dispatcher, "_cache", None), _KernelCache)


def is_warm(dispatcher: Any) -> bool:
    """Whether a kernel is compiled already, in this process or in the cache on disk."""
    if getattr(dispatcher, "signatures", True):  # plain functions when jitting is switched off
        return True
    if not is_kept(dispatcher):
        return False
    try:
        return bool(dispatcher._cache._cache_file._load_index())
    except Exception:  # a file cut short
        return False
