"""Which code computes: the package's version and a digest of its files."""

from __future__ import annotations

import hashlib
import platform
from functools import cache
from importlib.metadata import version
from pathlib import Path

from nonsmooth.version import __version__

__all__ = ["code_version", "library_versions"]

_PACKAGE = Path(__file__).parents[1]
# They print and lay out what is computed elsewhere; no number depends on them.
_NO_NUMBERS = (_PACKAGE / "cli", _PACKAGE / "chapter" / "report")
_SUFFIXES = (".py", ".json", ".toml")
_LIBRARIES = ("numpy", "scipy", "matplotlib", "xarray")


@cache
def code_version() -> str:
    """Version of the package, and what tells its files from those of another state of it.

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
    for path in sorted(_PACKAGE.rglob("*")):
        if path.suffix in _SUFFIXES and not any(path.is_relative_to(part) for part in _NO_NUMBERS):
            digest.update(path.relative_to(_PACKAGE).as_posix().encode())
            digest.update(hashlib.sha256(path.read_bytes()).digest())
    return f"{__version__}+{digest.hexdigest()[:12]}"


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
