r"""Whether motions of a structure decay or grow, by all of its eigenvalues.

Of a large structure only those near zero are known. Those beyond need not be: with an eigenvector
:math:`\phi`, and :math:`m = \phi^* M \phi`, :math:`d` of the symmetric part of C, :math:`k` and
:math:`i s` of the symmetric and the skew part of K alike, the balance of power of an eigenvalue
:math:`\sigma + i \omega` of modulus r is
:math:`\sigma (r^2 m + k) + r^2 d + \omega s = 0`. Where :math:`R^2 M + K` is positive definite and
:math:`R D + i S` not negative, each :math:`r \ge R` has :math:`\sigma \le 0`: no motion grows whose
eigenvalue is at least R.

Nor does one grow by more than a share :math:`\epsilon` of r, a negative damping ratio, where
:math:`R D + i S + \epsilon (R^2 M + K)` and :math:`D + 2 \epsilon R M` are not negative: the latter
makes the former grow with R. So a cross-coupling at a node without damping is no obstacle, as that
of a seal: what it can feed is little beside the energy of fast modes.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError, ResultWarning, RunError
from nonsmooth.structures.eigenpairs import is_small, nearest_to_zero
from nonsmooth.structures.matrices import is_definite, is_sparse
from nonsmooth.structures.pencil import Pencil

__all__ = ["Decay", "ModeGrowth", "decay_of", "decaying", "growth_of"]

Array = npt.NDArray[Any]

_ROUNDING = 1e-12  # of a row, by which a matrix that is singular may fail to be definite


class Decay(NamedTuple):
    """What the eigenvalues of a structure say."""

    others_decay: bool
    """Whether all have a negative real part, but for those that are zero."""
    zeros: int
    """How many are zero: motions without a restoring force."""


class ModeGrowth(NamedTuple):
    """What the eigenvalues of a structure say of motions that leave its responses."""

    grows: bool
    modes: int
    """How many were looked at, the slowest ones."""
    untold: str
    """Why the others may grow; empty where they do not."""


def decay_of(pencil: Pencil, known: Array) -> Decay:
    """By the eigenvalues nearest to zero, which are known, and as many more as it takes."""

    def grows(values: Array) -> bool:
        return not bool((values[values != 0.0].real < 0.0).all())

    found, told = _until_told(pencil, known, grows)
    if not told:
        warnings.warn(f"stable: {_untold(pencil, found)}", ResultWarning, stacklevel=4)
    return Decay(not grows(found), int((known == 0.0).sum()))


def growth_of(pencil: Pencil, ratio: float, count: int) -> ModeGrowth:
    """Whether a motion grows by more than a share of its frequency, from so many modes on."""

    def grows(values: Array) -> bool:
        return bool((values.real > ratio * np.abs(values)).any())

    small = is_small(pencil.structure.size)
    known = nearest_to_zero(pencil, None if small else count).values
    found, told = _until_told(pencil, known, grows, ratio)
    return ModeGrowth(grows(found), len(found), "" if told else _untold(pencil, found))


def _until_told(
    pencil: Pencil, known: Array, grows: Callable[[Array], bool], ratio: float = 0.0
) -> tuple[Array, bool]:
    """Eigenvalues up to one that grows, or to where no others do; and whether these are told."""
    size = pencil.structure.size
    complete = is_small(size)
    while not grows(known):
        if complete or _none_grows_beyond(pencil, float(np.abs(known).max()), ratio):
            return known, True
        more = 2 * len(known)
        complete = is_small(size, more)
        try:
            known = nearest_to_zero(pencil, None if complete else more).values
        except (ModelError, RunError):
            return known, False
    return known, True


def _untold(pencil: Pencil, known: Array) -> str:
    return (
        f"of {pencil.structure.size} degrees of freedom only the {len(known)} eigenvalues nearest"
        " to zero were looked at, and the damping does not tell whether the others decay"
    )


def decaying(found: list[Decay]) -> npt.NDArray[np.bool_]:
    """Whether all motions decay, for each value of some.

    Rigid motions, which have no restoring force at any value, are left aside; one that has none at
    some values only is on the border of stability there.
    """
    rigid = min(each.zeros for each in found)
    return np.array([each.others_decay and each.zeros == rigid for each in found])


def _none_grows_beyond(pencil: Pencil, radius: float, ratio: float) -> bool:
    if abs(_skew(pencil.M)).max() > 0.0:
        return False
    energy = radius**2 * pencil.M + (pencil.K + pencil.K.T) / 2.0
    if not is_definite(energy):
        return False
    damping, skew = (pencil.C + pencil.C.T) / 2.0, _skew(pencil.K)
    lost = radius * damping + ratio * energy
    if not is_definite(_lifted(lost + 1j * skew if abs(skew).max() > 0.0 else lost)):
        return False
    # without a share the first condition implies this one
    return ratio == 0.0 or is_definite(_lifted(damping + 2.0 * ratio * radius * pencil.M))


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
