"""Natural motions of a linear mode: what its states do when nothing drives them.

For display: eigenvalues in double precision with an estimate of their error, so that what
is zero, real or repeated up to rounding is called so. A run does not use them; the engine
has its own modal form.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

__all__ = ["Motion", "natural_motions", "reached"]

_EPS = float(np.finfo(float).eps)
_SAFETY = 100.0  # over the first-order estimate of an eigenvalue's error
_NEARLY_EQUAL = 1e-3  # relative distance of motions that are shown as one


@dataclass(frozen=True, slots=True)
class Motion:
    """Motions with nearly the same eigenvalue.

    ``rate`` has no negative imaginary part; ``count`` conjugate pairs or real eigenvalues
    are meant. ``chains`` is the number of independent motions: as many as ``count``, but
    fewer where zeros belong to a rigid body, whose position and velocity make one motion.
    """

    rate: complex
    count: int
    states: tuple[int, ...]
    chains: int

    @property
    def frequency(self) -> float:
        """Natural angular frequency of an oscillation, zero for other motions."""
        return abs(self.rate) if self.rate.imag else 0.0

    @property
    def damping(self) -> float:
        """Damping ratio of an oscillation; negative when it grows."""
        return -self.rate.real / abs(self.rate)


@dataclass(frozen=True, slots=True)
class _Eigenvalue:
    value: complex
    error: float
    states: tuple[int, ...]


def natural_motions(matrix: np.ndarray) -> list[Motion]:
    """Natural motions of x' = matrix x: zero first, the others from slow to fast.

    Raises
    ------
    numpy.linalg.LinAlgError
        When the eigenvalues are not found.
    """
    scale = float(np.abs(matrix).max(initial=0.0)) or 1.0
    matrix = matrix / scale  # far from overflow
    found = [value for block in _blocks(matrix) for value in _eigenvalues(matrix, block)]
    zero = [value for value in found if value.value == 0.0]
    others = sorted((v for v in found if v.value.imag >= 0.0), key=lambda v: abs(v.value))
    groups: list[list[_Eigenvalue]] = []
    for value in others:
        if value.value == 0.0:
            continue
        near = (group for group in groups if _nearly_equal(group[0], value))
        group = next(near, None)
        if group is None:
            groups.append([value])
        else:
            group.append(value)
    moving = [
        Motion(
            rate=scale * complex(np.mean([v.value for v in group])),
            count=len(group),
            states=_all_states(group),
            chains=len(group),
        )
        for group in groups
    ]
    return [*_zero_motions(matrix, zero), *moving]


def reached(matrix: np.ndarray, states: Iterable[int]) -> set[int]:
    """States that follow when some states are driven."""
    found: set[int] = set()
    open_ = list(states)
    while open_:
        state = open_.pop()
        if state not in found:
            found.add(state)
            open_.extend(int(i) for i in np.flatnonzero(matrix[:, state]))
    return found


def _blocks(matrix: np.ndarray) -> list[np.ndarray]:
    """States that influence each other both ways: a zero between blocks stays exact."""
    from scipy.sparse.csgraph import connected_components

    count, label = connected_components(matrix != 0.0, directed=True, connection="strong")
    return [np.flatnonzero(label == i) for i in range(count)]


def _eigenvalues(matrix: np.ndarray, block: np.ndarray) -> list[_Eigenvalue]:
    """Eigenvalues of a block, those on an axis up to their error put there."""
    from scipy.linalg import eig

    states = tuple(int(i) for i in block)
    part = matrix[np.ix_(block, block)]
    if len(block) == 1:
        return [_Eigenvalue(complex(part[0, 0]), 0.0, states)]
    balanced = _balanced(part)
    values, left, right = eig(balanced, left=True, right=True)
    # first-order error: eps |A| over the cosine between left and right eigenvector; where
    # that vanishes, three eigenvalues that meet are still off by eps^(1/3) only
    cosine = np.abs(np.sum(left.conj() * right, axis=0))
    size = float(np.linalg.norm(balanced, 2))
    errors = _SAFETY * _EPS * size / np.maximum(cosine, _EPS ** (2.0 / 3.0))
    return [
        _Eigenvalue(_on_axis(complex(value), float(error)), float(error), states)
        for value, error in zip(values, errors, strict=True)
    ]


def _balanced(matrix: np.ndarray) -> np.ndarray:
    """Similar matrix whose rows and columns have sizes alike."""
    from scipy.linalg import matrix_balance

    # scipy converts all scaling factors to integers, and uses those of permutations only
    with np.errstate(invalid="ignore"):
        balanced: np.ndarray = matrix_balance(matrix)[0]
    return balanced


def _on_axis(value: complex, error: float) -> complex:
    real = 0.0 if abs(value.real) <= error else value.real
    imaginary = 0.0 if abs(value.imag) <= error else value.imag
    return complex(real, imaginary)


def _nearly_equal(one: _Eigenvalue, other: _Eigenvalue) -> bool:
    distance = abs(one.value - other.value)
    same_kind = bool(one.value.imag) == bool(other.value.imag)
    return same_kind and distance <= max(_NEARLY_EQUAL * abs(one.value), one.error + other.error)


def _all_states(group: Sequence[_Eigenvalue]) -> tuple[int, ...]:
    return tuple(sorted({state for value in group for state in value.states}))


def _zero_motions(matrix: np.ndarray, zeros: list[_Eigenvalue]) -> list[Motion]:
    """Constants and rigid-body motions: zero eigenvalues, by the states that they link."""
    motions = []
    rest = list(zeros)
    while rest:
        group, linked = [rest.pop(0)], True
        while linked:  # until no other block with a zero drives this one, or is driven by it
            mine = _all_states(group)
            linked = False
            for value in list(rest):
                if _meet(matrix, mine, value.states):
                    group.append(value)
                    rest.remove(value)
                    linked = True
        states = _all_states(group)
        chains = min(max(1, _nullity(matrix, states)), len(group))  # whatever rounding says
        motions.append(Motion(0.0j, len(group), states, chains))
    return motions


def _meet(matrix: np.ndarray, some: tuple[int, ...], others: tuple[int, ...]) -> bool:
    forward, backward = reached(matrix, some), reached(matrix, others)
    return bool(forward & set(others) or backward & set(some))


def _nullity(matrix: np.ndarray, states: tuple[int, ...]) -> int:
    """Independent constants among the motions of some states and those between them."""
    start = set(states)
    between = [
        i
        for i in range(len(matrix))
        if i in start or (i in reached(matrix, states) and start & reached(matrix, [i]))
    ]
    part = _balanced(matrix[np.ix_(between, between)])
    return len(between) - int(np.linalg.matrix_rank(part))
