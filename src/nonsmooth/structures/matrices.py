"""The matrices of a structure, dense or sparse: read, checked, scaled, with more added to them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError, quote
from nonsmooth.matrix_files import MATRIX_SUFFIXES, archive_fault, read_archive, read_matrix

__all__ = ["MATRICES", "check_definite", "dense", "frozen", "is_definite", "is_sparse", "placed",
           "read_matrices", "read_structure", "scaled"]  # fmt: skip

MATRICES = ("mass", "stiffness", "damping", "gyroscopic")
_SHORT = {"M": "mass", "K": "stiffness", "C": "damping", "G": "gyroscopic"}
_KNOWN = (*MATRICES, *_SHORT, "coordinates")
_ROUNDING = 1e-12  # of the largest eigenvalue: one that is below zero by no more may be zero


def is_sparse(matrix: Any) -> bool:
    """Whether a matrix is one of scipy.sparse, or of another library that is like it."""
    return callable(getattr(matrix, "toarray", None))


def dense(matrix: Any) -> npt.NDArray[np.float64]:
    """Array of all entries."""
    return matrix.toarray() if is_sparse(matrix) else matrix


def frozen(matrix: Any) -> None:
    """Let nobody write into a matrix."""
    for part in (matrix.data, matrix.indices, matrix.indptr) if is_sparse(matrix) else (matrix,):
        part.setflags(write=False)


def read_matrices(given: Mapping[str, Any]) -> dict[str, Any]:
    """All four, of one size and kind; zero where none is given."""
    found = {
        name: _square(name, each)
        for name, each in given.items()
        if each is not None or name in MATRICES[:2]
    }
    size = found["mass"].shape[0]
    for name, matrix in found.items():
        if matrix.shape[0] != size:
            raise ModelError(
                f"{name} is {matrix.shape[0]} x {matrix.shape[0]} and the mass matrix {size} x"
                f" {size}; all have the same degrees of freedom"
            )
    if any(map(is_sparse, found.values())):
        from scipy.sparse import csc_array

        return {name: csc_array(found.get(name, (size, size)), dtype=float) for name in MATRICES}
    return {name: found.get(name, np.zeros((size, size))) for name in MATRICES}


def _square(name: str, given: Any) -> Any:
    """Square matrix of finite numbers, a copy of what was given."""
    if isinstance(given, str | os.PathLike):
        given = _read(name, Path(given))
    if is_sparse(given):
        from scipy.sparse import csc_array

        given = csc_array(given)
        given.sum_duplicates()
    try:
        matrix = given if is_sparse(given) else np.asarray(given)
        if matrix.dtype.kind not in "iuf":
            raise TypeError
        matrix = matrix.astype(float)
    except (TypeError, ValueError, OverflowError):
        objects = getattr(getattr(given, "dtype", None), "kind", "") == "O"
        cure = "; this is an array of Python objects: turn it by .astype(float)" if objects else ""
        raise ModelError(
            f"{name} = {quote(given)}: a matrix has real numbers in rows of one length{cure}"
        ) from None
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1] or not matrix.shape[0]:
        raise ModelError(
            f"{name} has shape {matrix.shape}; it is square, with a row and a column for each"
            " degree of freedom"
        )
    entries = matrix.data if is_sparse(matrix) else matrix
    if not np.isfinite(entries).all():
        row, column = np.argwhere(~np.isfinite(dense(matrix)))[0]
        raise ModelError(f"{name}[{row}, {column}] = {matrix[row, column]} is not finite")
    return matrix


def _read(name: str, path: Path) -> Any:
    if path.suffix.lower() != ".npz":
        return read_matrix(
            name, path, " and .npz; a file with all matrices is read by Structure.from_files"
        )
    from scipy.sparse import load_npz

    try:
        return load_npz(path)
    except (OSError, ValueError, EOFError, TypeError, KeyError) as error:
        raise ModelError(
            f"{name}: {path.name} cannot be read as one sparse matrix: {archive_fault(error)}; a"
            " file with all matrices is read by Structure.from_files"
        ) from None


def read_structure(path: Path) -> dict[str, Any]:
    """Matrices of a file or a folder by their long names, and names of coordinates if there."""
    arrays = _folder(path) if path.is_dir() else read_archive(path, _KNOWN, ())
    shown = path.name or str(path)  # "." has no name
    found: dict[str, Any] = {}
    for name, array in arrays.items():
        long = _SHORT.get(name, name)
        if long in found:
            raise ModelError(f"path: {shown} has {long} twice; leave one out")
        found[long] = array
    for name in MATRICES[:2]:
        if name not in found:
            raise ModelError(
                f"path: {shown} has no {name}; it has {sorted(arrays)}, and these have a"
                f" meaning: {', '.join(_KNOWN)}"
            )
    if "coordinates" in found:  # padded with blanks where MATLAB wrote them
        found["coordinates"] = [str(each).strip() for each in np.ravel(found["coordinates"])]
    return found


def _folder(path: Path) -> dict[str, Any]:
    """Files of a folder that are called like matrices; others may lie beside them."""
    suffixes = (*MATRIX_SUFFIXES, ".npz")
    return {
        file.stem: file
        for file in sorted(path.iterdir())
        if file.stem in (*MATRICES, *_SHORT) and file.suffix.lower() in suffixes
    }


def check_definite(mass: Any) -> None:
    """Refuse a symmetric mass matrix by which some velocity has no kinetic energy, or less.

    By Cholesky's factors of a dense matrix, by the signs of the pivots of a sparse one.
    """
    if is_definite(mass):
        return
    least, largest = _extreme_eigenvalues(mass)
    if least < -_ROUNDING * largest:
        raise ModelError(
            f"mass is indefinite: its most negative eigenvalue is {least:.4g}, so some motion"
            " would have negative kinetic energy; look for an entry with the wrong sign or place"
        )
    raise ModelError("mass is singular: every coordinate has inertia; condense those without it")


def is_definite(matrix: Any) -> bool:
    """Whether a symmetric or Hermitian matrix is positive definite."""
    if not is_sparse(matrix):
        try:
            np.linalg.cholesky(matrix)
        except np.linalg.LinAlgError:
            return False
        return True
    from scipy.sparse.linalg import splu

    try:  # without exchanges of rows the pivots have the signs of the eigenvalues
        factors = splu(
            matrix.tocsc(), "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
    except RuntimeError:  # a pivot is zero
        return False
    unchanged = (factors.perm_r == factors.perm_c).all()
    return bool(unchanged and (factors.U.diagonal().real > 0.0).all())


def _extreme_eigenvalues(matrix: Any) -> tuple[float, float]:
    """Least eigenvalue of a symmetric matrix, and a bound of the largest."""
    if not is_sparse(matrix):
        values = np.linalg.eigvalsh(matrix)
        return float(values[0]), float(values[-1])
    from scipy.sparse.linalg import eigsh

    bound = float(abs(matrix).sum(axis=1).max())  # of all sizes, after Gershgorin
    start = np.random.default_rng(0).normal(size=matrix.shape[0])  # the same digits each time
    nearest = eigsh(matrix, 1, sigma=-1.01 * bound, v0=start, return_eigenvectors=False)
    return float(nearest[0]), bound


def scaled(matrix: Any, factor: float, levers: npt.NDArray[np.float64]) -> Any:
    """Each entry times a factor and those of its row and its column."""
    if not is_sparse(matrix):
        return matrix * (factor * np.outer(levers, levers))
    rows, columns = matrix.tocoo().coords
    changed = matrix.copy()
    changed.data = matrix.data * (factor * levers[rows] * levers[columns])
    return changed


def placed(matrix: Any, block: npt.NDArray[np.float64], at: tuple[Any, ...]) -> Any:
    """The matrix and a block added to some of its rows and columns."""
    if not is_sparse(matrix):
        total = matrix.copy()
        total[at] += block
        return total
    from scipy.sparse import csc_array

    rows, columns = np.broadcast_arrays(*at)
    shape = matrix.shape
    return matrix + csc_array((block.ravel(), (rows.ravel(), columns.ravel())), shape=shape)
