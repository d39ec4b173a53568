"""Random linear flows of every kind that is hard to compute, class by class.

A case is x' = A x + sum of forcing harmonics over a given time. The matrices are built so that
the hard property is exact in double precision where its class says so: defects are hidden by
integer matrices whose inverse is an integer matrix too.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np


class Case(NamedTuple):
    """x' = matrix x + cosines cos(frequencies t) + sines sin(frequencies t), up to time."""

    matrix: np.ndarray
    time: float
    start: np.ndarray
    frequencies: np.ndarray
    cosines: np.ndarray  # (n, number of frequencies)
    sines: np.ndarray

    @property
    def augmented(self) -> np.ndarray:
        """The autonomous matrix of (x, cos, sin, cos, sin, ...)."""
        n, k = len(self.matrix), self.frequencies.size
        full = np.zeros((n + 2 * k, n + 2 * k))
        full[:n, :n] = self.matrix
        full[:n, n::2], full[:n, n + 1 :: 2] = self.cosines, self.sines
        for j, w in enumerate(self.frequencies):
            c = n + 2 * j
            full[c, c + 1], full[c + 1, c] = -w, w
        return full

    @property
    def augmented_start(self) -> np.ndarray:
        return np.concatenate([self.start, np.tile([1.0, 0.0], self.frequencies.size)])


def _log(rng, low, high):
    """A number whose decimal logarithm is uniform."""
    return 10.0 ** rng.uniform(low, high)


def _case(rng, matrix, frequencies=(), forcing=None, longest=1e3, time=None):
    """Case with a time over which motions turn, decay or grow as much as they may."""
    matrix = np.array(matrix, float)
    n, w = len(matrix), np.array(frequencies, float)
    if time is None:
        time = horizon(rng, matrix, w, longest)
    if forcing is None:
        forcing = rng.normal(size=(2, n, w.size))
    return Case(matrix, float(time), rng.normal(size=n), w, forcing[0], forcing[1])


def horizon(rng, matrix, frequencies=(), longest=1e3):
    """Time up to |Im| t = longest, growth exponent 20, and some lives of the slowest decay."""
    values = np.linalg.eigvals(matrix)
    speeds = np.abs(np.concatenate([values.imag, np.atleast_1d(frequencies)]))
    decays = np.abs(values.real)
    decays = decays[decays > 1e-6 * max(1.0, decays.max())]
    growth = max(values.real.max(), 0.0)
    time = _log(rng, -1.5, 1.5) / (decays.min() if decays.size else 1.0)
    if speeds.max() > 1e-9:
        time = min(max(time, 1.0 / speeds.max()), longest * rng.uniform(0.01, 1) / speeds.max())
    return min(time, rng.uniform(1, 20) / growth) if growth > 1e-6 else time


def unimodular(rng, n, steps=None):
    """An integer matrix and its integer inverse, products of elementary ones."""
    t, inverse = np.eye(n), np.eye(n)
    for _ in range(2 * n if steps is None else steps):
        if n == 1:
            break
        i, j = rng.choice(n, 2, replace=False)
        factor = rng.choice([-1, 1])
        t[i] += factor * t[j]
        inverse[:, j] -= factor * inverse[:, i]
    return t, inverse


def hidden(rng, matrix):
    """The matrix in coordinates that hide its form; exact for integers and short fractions."""
    t, inverse = unimodular(rng, len(matrix))
    return t @ matrix @ inverse


def rotation(n, rng):
    """A random orthogonal matrix."""
    return np.linalg.qr(rng.normal(size=(n, n)))[0]


def jordan(value, size, coupling=1.0):
    """A Jordan block; a complex value gives the real block of twice the size."""
    if isinstance(value, complex):
        a, w = value.real, value.imag
        block = np.kron(np.eye(size), [[a, -w], [w, a]])
        return block + coupling * np.kron(np.diag(np.ones(size - 1), 1), np.eye(2))
    return value * np.eye(size) + coupling * np.diag(np.ones(size - 1), 1)


def together(*blocks):
    """Block diagonal."""
    n = sum(len(b) for b in blocks)
    full, low = np.zeros((n, n)), 0
    for b in blocks:
        full[low : low + len(b), low : low + len(b)] = b
        low += len(b)
    return full


def dyadic(rng, low=-4, high=0):
    """A short fraction, so that integer similarities stay exact."""
    return float(rng.integers(low * 8, high * 8 + 1)) / 8


def generic(rng):
    n = rng.integers(1, 9)
    matrix = rng.normal(size=(n, n)) * _log(rng, -2, 4.5)
    return _case(rng, matrix)


def stiff(rng):
    """Decays between 1 and 1e5 beside slow oscillations, behind a rotation or triangular."""
    n = int(rng.integers(2, 9))
    blocks, size = [], 0
    while size < n:
        if size + 2 <= n and rng.random() < 0.4:
            blocks.append([[-_log(rng, -3, 0), 1.0], [-_log(rng, -1, 2), -_log(rng, -3, 0)]])
        else:
            blocks.append([[-_log(rng, 0, 5)]])
        size += len(blocks[-1])
    matrix = together(*map(np.array, blocks))
    kind = rng.integers(3)
    if kind == 0:
        q = rotation(n, rng)
        matrix = q @ matrix @ q.T
    elif kind == 1:
        matrix += np.triu(rng.normal(size=(n, n)), 1) * _log(rng, -2, 3)
    else:  # graded: each row as large as its own rate
        matrix += rng.normal(size=(n, n)) * np.abs(np.diag(matrix))[:, None] * 0.1
    return _case(rng, matrix, time=_log(rng, -2, 1))


def relaxing(rng):
    """Mechanical stiffness: masses on springs through massless dashpots that relax at up to 1e5."""
    n_pairs, n_fast = int(rng.integers(1, 4)), int(rng.integers(1, 3))
    n = 2 * n_pairs + n_fast
    matrix = np.zeros((n, n))
    for i in range(n_pairs):
        matrix[2 * i, 2 * i + 1] = 1.0
        matrix[2 * i + 1, 2 * i] = -_log(rng, -1, 2)
        matrix[2 * i + 1, 2 * i + 1] = -_log(rng, -3, 0)
    for j in range(n_fast):
        f, rate = 2 * n_pairs + j, _log(rng, 2, 5)
        matrix[f, f] = -rate
        for i in range(n_pairs):
            stiffness = _log(rng, 0, 2.7)
            matrix[2 * i + 1, f], matrix[f, 2 * i] = stiffness, rate * rng.uniform(0.1, 0.5)
            matrix[2 * i + 1, 2 * i] -= stiffness
    return _case(rng, matrix, time=_log(rng, -1, 1))


def oscillating(rng):
    """Chains of masses, hardly damped, up to 1000 radians."""
    pairs = int(rng.integers(1, 5))
    mass = rng.uniform(0.5, 2, pairs)
    springs = [_log(rng, -2, 2) for _ in range(pairs + 1)]
    k = np.diag(springs[:-1]) + np.diag(springs[1:])
    k -= np.diag(springs[1:-1], 1) + np.diag(springs[1:-1], -1)
    damping = rng.choice([0.0, _log(rng, -5, -2)])
    a = np.block(
        [
            [np.zeros((pairs, pairs)), np.eye(pairs)],
            [-k / mass[:, None], -damping * k / mass[:, None]],
        ]
    )
    time = rng.uniform(0.05, 1) * 1e3 / np.abs(np.linalg.eigvals(a).imag).max()
    return _case(rng, a, time=time)


def defect(rng):
    """Jordan blocks, exact; plain, in mechanical form, or hidden by an integer similarity."""
    value = complex(dyadic(rng, -2, 0), float(rng.integers(1, 4))) if rng.random() < 0.3 else None
    if value is None:
        size = int(rng.integers(2, 7))
        blocks = [jordan(dyadic(rng), size, _log(rng, -1, 1) if rng.random() < 0.3 else 1.0)]
        if size < 6:
            blocks.append(jordan(dyadic(rng), int(rng.integers(1, 9 - size))))
    else:
        blocks = [jordan(value, int(rng.integers(2, 4)))]
    matrix = together(*blocks)
    if rng.random() < 0.7:
        matrix = hidden(rng, matrix)
    return _case(rng, matrix, longest=100, time=_log(rng, -1, 1.3))


def near_defect(rng):
    """The same with the eigenvalues of each block split by 1e-1 to 1e-14."""
    size, value = int(rng.integers(2, 6)), dyadic(rng)
    split = _log(rng, -14, -1)
    matrix = jordan(value, size) + np.diag(split * rng.normal(size=size))
    if rng.random() < 0.5:
        matrix = together(matrix, jordan(dyadic(rng), int(rng.integers(1, 4))))
    kind = rng.integers(3)
    if kind == 0:
        matrix = hidden(rng, matrix)
    elif kind == 1:
        q = rotation(len(matrix), rng)
        matrix = q @ matrix @ q.T
    return _case(rng, matrix, longest=100, time=_log(rng, -1, 1.3))


def resonance(rng):
    """Forcing at a natural frequency of one or two oscillators in series, exact or nearly so."""
    w = float(rng.integers(1, 17)) / 4
    off = 1.0 + rng.choice([0.0, rng.choice([-1, 1]) * _log(rng, -14, -1)])
    if rng.random() < 0.4:
        block = np.array([[0.0, w], [-w, 0.0]])
    else:
        block = np.array([[0.0, 1.0], [-w * w, -rng.choice([0.0, _log(rng, -12, -2)])]])
    if rng.random() < 0.4:  # the first oscillator drives the second: a double resonance
        series = together(block, block)
        series[3, 0] = 1.0
        block = series
    if rng.random() < 0.3:
        block = hidden(rng, block)
    frequencies = [w * off] if rng.random() < 0.6 else [w * off, w * (1 + _log(rng, -6, 0))]
    time = rng.uniform(0.02, 1) * 1e3 / max(w, *frequencies)
    return _case(rng, block, frequencies, time=time)


def critical(rng):
    """Critically damped oscillators in series, exact and near, forced or not."""
    pairs, w = int(rng.integers(1, 5)), float(rng.integers(1, 9)) / 2
    off = rng.choice([0.0, rng.choice([-1, 1]) * _log(rng, -14, -1)])
    blocks = [np.array([[0.0, 1.0], [-w * w, -2 * w * (1 + off)]]) for _ in range(pairs)]
    matrix = together(*blocks)
    for i in range(1, pairs):
        matrix[2 * i + 1, 2 * i - 2] = rng.normal()
    frequencies = [_log(rng, -1, 1)] if rng.random() < 0.4 else []
    return _case(rng, matrix, frequencies, time=_log(rng, -1, 1.3) / w)


def non_normal(rng):
    """Grcar and other Toeplitz matrices, triangular ones with large couplings."""
    n = int(rng.integers(3, 9))
    kind = rng.integers(3)
    if kind == 0:
        matrix = (
            np.triu(np.ones((n, n))) - np.triu(np.ones((n, n)), 4) - np.diag(np.ones(n - 1), -1)
        )
        matrix -= rng.uniform(0, 2) * np.eye(n)
    elif kind == 1:
        matrix = np.triu(rng.normal(size=(n, n)), 1) * _log(rng, 0, 4)
        matrix += np.diag(-np.abs(rng.normal(size=n)) * _log(rng, -1, 1))
    else:
        matrix = sum(rng.normal() * np.diag(np.ones(n - abs(d)), d) for d in range(-2, 4))
        matrix -= (np.linalg.eigvals(matrix).real.max() + 0.1) * np.eye(n)
    return _case(rng, matrix, longest=100)


def nilpotent(rng):
    """Rigid-body motion: chains of integrators with coefficients, hidden or not."""
    n = int(rng.integers(2, 9))
    matrix = np.triu(rng.integers(-3, 4, size=(n, n)), 1).astype(float)
    if rng.random() < 0.5:
        matrix = np.diag(np.array([_log(rng, -2, 2) for _ in range(n - 1)]), 1)
    elif rng.random() < 0.7:
        matrix = hidden(rng, matrix)
    frequencies = [_log(rng, -1, 1)] if rng.random() < 0.3 else []
    return _case(rng, matrix, frequencies, time=_log(rng, -1, 1.5))


def unstable(rng):
    """Growth up to exp(20), simple, oscillating, or in a Jordan block."""
    n, kind = int(rng.integers(1, 9)), rng.integers(3)
    if kind == 0:
        matrix = rng.normal(size=(n, n)) + rng.uniform(0, 2) * np.eye(n)
    elif kind == 1:
        matrix = hidden(rng, together(jordan(0.5, min(n, 3)), jordan(-1.0, max(1, n - 3))))
    else:
        values = rng.uniform(-3, 1, n)
        q = rotation(n, rng)
        matrix = q @ (np.diag(values) + np.triu(rng.normal(size=(n, n)), 1)) @ q.T
    growth = max(np.linalg.eigvals(matrix).real.max(), 0.05)
    return _case(rng, matrix, time=min(rng.uniform(5, 20) / growth, 100.0))


def badly_scaled(rng):
    """Any other class in units that are up to 1e6 too large or too small."""
    inner = CLASSES[rng.choice([c for c in CLASSES if c not in ("badly scaled", "mixture")])](rng)
    n = len(inner.matrix)
    scale = np.array([_log(rng, -6, 6) for _ in range(n)])
    return inner._replace(
        matrix=inner.matrix * scale[:, None] / scale,
        start=inner.start * scale,
        cosines=inner.cosines * scale[:, None],
        sines=inner.sines * scale[:, None],
    )


def mixture(rng):
    """Two classes side by side, the first driven by the second, two frequencies."""
    names = [c for c in CLASSES if c not in ("mixture", "badly scaled", "generic")]
    while True:
        one, two = (CLASSES[name](rng) for name in rng.choice(names, 2))
        n, k = len(one.matrix), len(two.matrix)
        if n + k <= 8:
            break
    matrix = together(one.matrix, two.matrix)
    matrix[:n, n:] = rng.normal(size=(n, k)) * (rng.random((n, k)) < 0.5)
    time = min(one.time, two.time)
    w = np.concatenate([one.frequencies, two.frequencies])[:2]
    if w.size < 2 and rng.random() < 0.5:
        w = np.append(w, _log(rng, -1, 1.5))
    return _case(rng, matrix, w, time=time)


CLASSES: dict[str, Callable[[np.random.Generator], Case]] = {
    "generic": generic,
    "stiff": stiff,
    "relaxing": relaxing,
    "oscillating": oscillating,
    "defect": defect,
    "near defect": near_defect,
    "resonance": resonance,
    "critical": critical,
    "non-normal": non_normal,
    "nilpotent": nilpotent,
    "unstable": unstable,
    "badly scaled": badly_scaled,
    "mixture": mixture,
}


def draw(name: str, seed: int) -> Case:
    """The case of a class that belongs to a seed; every fourth stops after a short time."""
    rng = np.random.default_rng([seed, *name.encode()])
    with np.errstate(all="ignore"):
        case = CLASSES[name](rng)
    return case._replace(time=case.time * _log(rng, -5, 0)) if seed % 4 == 3 else case
