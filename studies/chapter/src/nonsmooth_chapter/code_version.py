"""Which code computes: the version of the library, and a digest of its files and the study's."""

from __future__ import annotations

import hashlib
import platform
from functools import cache
from importlib.metadata import version
from pathlib import Path

import nonsmooth as ns

__all__ = ["code_version", "library_versions"]

_LIBRARY, _STUDY = Path(ns.__file__).parent, Path(__file__).parent
# They print and lay out what is computed elsewhere; no number depends on them.
_NO_NUMBERS = (_LIBRARY / "cli", _STUDY / "command.py", _STUDY / "report")
_SUFFIXES = (".py", ".json", ".toml")
_LIBRARIES = ("numpy", "scipy", "matplotlib", "xarray")


@cache
def code_version() -> str:
    """Version of the library, and what tells its files and the study's from another state of them.

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
    for package in (_LIBRARY, _STUDY):
        for path in sorted(package.rglob("*")):
            counts = not any(path.is_relative_to(part) for part in _NO_NUMBERS)
            if path.suffix in _SUFFIXES and counts:
                digest.update(path.relative_to(package).as_posix().encode())
                digest.update(hashlib.sha256(path.read_bytes()).digest())
    return f"{ns.__version__}+{digest.hexdigest()[:12]}"


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
