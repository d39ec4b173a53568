"""The compiled engine: which of its builds serves this processor, and its declarations.

The declarations come from ``native/interface.h``; ``build_engine.py`` makes both when the package
is built. Nothing is compiled when a program runs.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

__all__ = ["constant", "engine", "ffi"]

_FOLDER = Path(__file__).parent
_SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
_CURE = (
    "reinstall nonsmooth, or in a folder of its sources run `make engine`"
    " (`python build_engine.py` in the environment where it is installed)"
)

try:
    from nonsmooth.engine._declarations import ffi
except ImportError as fault:
    raise ImportError(f"the engine of nonsmooth is not built: {_CURE}") from fault


def _load() -> Any:
    """The fastest build that the processor can run; both give the same digits."""
    wanted = os.environ.get("NONSMOOTH_ENGINE", "")
    if os.sep in wanted:
        return _open(Path(wanted))
    if wanted not in ("", "baseline", "v3"):
        raise ImportError(
            f"NONSMOOTH_ENGINE is {wanted!r}; it may be 'baseline', 'v3' or the path of a library"
        )
    baseline, v3 = (_FOLDER / f"_nonsmooth_{build}{_SUFFIX}" for build in ("baseline", "v3"))
    engine = _open(baseline)
    if wanted != "baseline" and v3.exists() and engine.nonsmooth_runs_v3():
        return _open(v3)
    return engine


def _open(path: Path) -> Any:
    try:
        return ffi.dlopen(str(path))
    except OSError as fault:
        raise ImportError(f"the engine of nonsmooth cannot be loaded ({fault}): {_CURE}") from fault


engine = _load()


def constant(name: str) -> int:
    """A number that interface.h names."""
    return int(ffi.integer_const(name))
