"""Matrices as arrays from files: one to a file, or several by name."""

from __future__ import annotations

import warnings
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.errors import ModelError

__all__ = ["MATRIX_SUFFIXES", "archive_fault", "read_archive", "read_matrix"]

MATRIX_SUFFIXES = (".npy", ".csv", ".mtx")
_OBJECTS = "Object arrays cannot be loaded"  # what numpy says of them
_PICKLED = "pickled"
_NO_OBJECTS = (
    "holds Python objects, which could run code when they are read; save numbers by"
    " .astype(float), names by .astype(str)"
)
_FAULTS = (OSError, ValueError, EOFError, TypeError, OverflowError, zipfile.BadZipFile)


def read_matrix(name: str, path: Path, cure: str = "") -> Any:
    """Array of a file that holds one; that of a Matrix Market file may be sparse."""
    suffix = path.suffix.lower()
    try:
        if suffix == ".npy":
            return np.load(path, allow_pickle=False)
        if suffix == ".csv":
            with warnings.catch_warnings():  # of a file without numbers, which has no matrix
                warnings.filterwarnings("ignore", "loadtxt: input contained no data")
                return np.loadtxt(path, delimiter=",", ndmin=2)
        if suffix == ".mtx":
            from scipy.io import mmread

            return mmread(path, spmatrix=False)
    except _FAULTS as error:
        fault = _NO_OBJECTS if _OBJECTS in str(error) else f"cannot be read: {error}"
        if _PICKLED in str(error):
            fault = f"cannot be read: it is no {suffix} file"
        raise ModelError(f"{name}: {path.name} {fault}") from None
    raise ModelError(
        f"{name}: {path.name} has none of the suffixes {', '.join(MATRIX_SUFFIXES)}{cure}"
    )


def read_archive(path: Path, known: Sequence[str], needed: Sequence[str]) -> dict[str, Any]:
    """Arrays of an ``.npz`` or ``.mat`` file by name; others than those known are refused."""
    if not path.exists():
        raise ModelError(f"path: there is no file or folder '{path}'")
    arrays = _mat(path) if path.suffix.lower() == ".mat" else _npz(path)
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
    return {name: _texts(f"path: {path.name}: {name!r}", each) for name, each in arrays.items()}


def _npz(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = {}
    name = ""
    try:
        with np.load(path, allow_pickle=False) as archive:
            if not isinstance(archive, np.lib.npyio.NpzFile):
                raise ValueError("it holds one array without a name")
            for name in archive.files:
                found[name] = archive[name]
            return found
    except _FAULTS as error:
        if name and _OBJECTS in str(error):
            raise ModelError(f"path: {path.name}: array {name!r} {_NO_OBJECTS}") from None
        raise ModelError(
            f"path: {path.name} cannot be read as .npz: {archive_fault(error)}"
        ) from None


def archive_fault(error: Exception) -> str:
    """What numpy says of an archive that it cannot read.

    It takes any other file for Python objects, and says how to read those.
    """
    return "it is no archive of arrays" if _PICKLED in str(error) else str(error)


def _mat(path: Path) -> dict[str, Any]:
    """Variables of MATLAB up to version 7; later files are HDF5, in which sparse means else."""
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        found = loadmat(path, spmatrix=False)
    except NotImplementedError:  # what scipy says of files that are HDF5
        raise ModelError(
            f"path: {path.name} is a file of MATLAB's version 7.3; save it with '-v7'"
        ) from None
    except (*_FAULTS, MatReadError) as error:
        raise ModelError(f"path: {path.name} cannot be read as .mat: {error}") from None
    return {name: array for name, array in found.items() if not name.startswith("__")}


def _texts(where: str, array: Any) -> Any:
    """Texts of a cell array, each of which is an array of its own; other arrays as they are."""
    kind = array.dtype.kind
    if kind == "V":
        raise ModelError(f"{where} is a struct of MATLAB; save its fields as variables")
    if kind != "O":
        return array
    cells = [np.ravel(each) for each in np.ravel(array)]
    if not all(each.size == 1 and each.dtype.kind == "U" for each in cells):
        raise ModelError(
            f"{where} is a cell array; only one of texts can be read, such as names of coordinates:"
            " turn one of numbers into a matrix by cell2mat"
        )
    return np.array([str(each[0]) for each in cells])
