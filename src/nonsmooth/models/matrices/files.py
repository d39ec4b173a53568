"""Structural matrices from arrays and files, checked; nothing in a file is executed."""

from __future__ import annotations

import os
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.errors import ModelError

__all__ = ["read_archive", "square_matrix"]

_SUFFIXES = ".npy, .csv and .mtx"


def square_matrix(name: str, given: Any, size: int | None = None) -> np.ndarray:
    """Square array of finite numbers, from an array or the path of a file."""
    if isinstance(given, str | os.PathLike):
        array, name = _read(name, Path(given)), f"{name} ({Path(given).name})"
    else:
        array = given
    array = array.toarray() if hasattr(array, "toarray") else array  # sparse, as scipy has it
    try:
        matrix = np.asarray(array)
        if matrix.dtype.kind not in "iuf":
            raise TypeError
        matrix = matrix.astype(float)
    except (TypeError, ValueError, OverflowError):
        raise ModelError(f"{name}: a matrix has real numbers in rows of one length") from None
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1] or not matrix.size:
        raise ModelError(
            f"{name} has shape {matrix.shape}; it is square, with a row and a column for each"
            " degree of freedom"
        )
    if size is not None and len(matrix) != size:
        raise ModelError(
            f"{name} is {len(matrix)} x {len(matrix)} and the mass matrix {size} x {size}; all"
            " have the same degrees of freedom"
        )
    if not np.isfinite(matrix).all():
        row, column = np.argwhere(~np.isfinite(matrix))[0]
        raise ModelError(f"{name}[{row}, {column}] = {matrix[row, column]} is not finite")
    return matrix


def read_archive(path: Path, known: tuple[str, ...], needed: tuple[str, ...]) -> dict[str, Any]:
    """Arrays of an ``.npz`` file by name; others than those known are refused."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            if not isinstance(archive, np.lib.npyio.NpzFile):
                raise ValueError("it holds one array without a name")
            arrays = {name: archive[name] for name in archive.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise ModelError(f"{path.name} cannot be read as .npz: {error}") from None
    for name in needed:
        if name not in arrays:
            raise ModelError(
                f"{path.name} has no array {name!r}; it has {sorted(arrays)}, and these have a"
                f" meaning: {', '.join(known)}"
            )
    for name in arrays:
        if name not in known:
            raise ModelError(
                f"{path.name}: array {name!r} has no meaning here; these have: {', '.join(known)}"
            )
    return arrays


def _read(name: str, path: Path) -> Any:
    suffix = path.suffix.lower()
    try:
        if suffix == ".npy":
            return np.load(path, allow_pickle=False)
        if suffix == ".csv":
            return np.loadtxt(path, delimiter=",", ndmin=2)
        if suffix == ".mtx":
            from scipy.io import mmread

            return mmread(path)
    except (OSError, ValueError, EOFError, TypeError, OverflowError) as error:
        raise ModelError(f"{name}: {path.name} cannot be read: {error}") from None
    raise ModelError(
        f"{name}: {path.name} has none of the suffixes {_SUFFIXES}; an .npz file with all matrices"
        " is read by MatrixRotor.from_file"
    )
