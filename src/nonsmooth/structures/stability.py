r"""Whether all motions of a structure decay, by all of its eigenvalues.

Of a large structure only those near zero are known. Those beyond need not be: with an eigenvector
:math:`\phi`, and :math:`m = \phi^* M \phi`, :math:`d` of the symmetric part of C, :math:`k` and
:math:`i s` of the symmetric and the skew part of K alike, the balance of power of an eigenvalue
:math:`\sigma + i \omega` of modulus r is
:math:`\sigma (r^2 m + k) + r^2 d + \omega s = 0`. Where :math:`R^2 M + K` is positive definite and
:math:`R D + i S` not negative, each :math:`r \ge R` has :math:`\sigma \le 0`: no motion grows whose
eigenvalue is at least R.
"""

from __future__ import annotations

import warnings
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError, ResultWarning
from nonsmooth.structures.eigenpairs import is_small, nearest_to_zero
from nonsmooth.structures.matrices import is_definite, is_sparse
from nonsmooth.structures.pencil import Pencil

__all__ = ["Decay", "decay_of", "decaying"]

Array = npt.NDArray[Any]

_ROUNDING = 1e-12  # of a row, by which a matrix that is singular may fail to be definite


class Decay(NamedTuple):
    """What the eigenvalues of a structure say."""

    others_decay: bool
    """Whether all have a negative real part, but for those that are zero."""
    zeros: int
    """How many are zero: motions without a restoring force."""


def decay_of(pencil: Pencil, known: Array) -> Decay:
    """By the eigenvalues nearest to zero, which are known, and as many more as it takes."""
    zeros = int((known == 0.0).sum())
    size = pencil.structure.size
    complete = is_small(size)
    while (known[known != 0.0].real < 0.0).all():
        if complete or _none_grows_beyond(pencil, float(np.abs(known).max())):
            return Decay(True, zeros)
        more = 2 * len(known)
        complete = is_small(size, more)
        try:
            known = nearest_to_zero(pencil, None if complete else more).values
        except ModelError:
            warnings.warn(
                f"stable: of {size} degrees of freedom only the {len(known)} eigenvalues nearest"
                " to zero were looked at, and the damping does not tell whether the others decay",
                ResultWarning,
                stacklevel=4,
            )
            return Decay(True, zeros)
    return Decay(False, zeros)


def decaying(found: list[Decay]) -> npt.NDArray[np.bool_]:
    """Whether all motions decay, for each value of some.

    Rigid motions, which have no restoring force at any value, are left aside; one that has none at
    some values only is on the border of stability there.
    """
    rigid = min(each.zeros for each in found)
    return np.array([each.others_decay and each.zeros == rigid for each in found])


def _none_grows_beyond(pencil: Pencil, radius: float) -> bool:
    if abs(_skew(pencil.M)).max() > 0.0:
        return False
    if not is_definite(radius**2 * pencil.M + (pencil.K + pencil.K.T) / 2.0):
        return False
    damping, skew = radius * (pencil.C + pencil.C.T) / 2.0, _skew(pencil.K)
    return is_definite(_lifted(damping + 1j * skew if abs(skew).max() > 0.0 else damping))


def _skew(matrix: Any) -> Any:
    """The skew part, without that of rounding."""
    part = (matrix - matrix.T) / 2.0
    return part * (abs(part) > _ROUNDING * (abs(matrix) + abs(matrix.T)))


def _lifted(matrix: Any) -> Any:
    """With so much on the diagonal that rounding does not matter; empty rows are no obstacle."""
    sums = np.asarray(abs(matrix).sum(axis=1)).ravel()
    more = np.where(sums > 0.0, _ROUNDING * sums, 1.0)
    if not is_sparse(matrix):
        return matrix + np.diag(more)
    from scipy.sparse import diags_array

    return (matrix + diags_array(more)).tocsc()
