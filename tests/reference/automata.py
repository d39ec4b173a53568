"""Classic systems as automata for ``hybrid_run``, with the states they start from.

The forcing enters as two states (cos, sin of its phase), constants as a last state 1.
"""

from typing import Any

from mpmath import mp, mpf

from .hybrid import DIGITS, LinearExit, LinearMode

Modes = dict[str, LinearMode]


@mp.workdps(DIGITS + 10)
def rigid_impact(*, F: Any, omega: Any, zeta: Any, sigma: Any, r: Any) -> Modes:
    """x'' + 2 zeta x' + x = F cos(theta), x <= sigma, v+ = -r v-. z = (x, v, cos, sin, 1).

    There is no mode for resting at the wall: chatter that accumulates has no end here.
    """
    F, w, zeta, sigma, r = (mpf(x) for x in (F, omega, zeta, sigma, r))
    matrix = [[0, 1, 0, 0, 0], [-1, -2 * zeta, F, 0, 0], *_harmonics(w, before=2, n=5)]
    reset = [[0, 0, 0, 0, sigma], [0, -r, 0, 0, 0], *_unit_rows(2, 5)]
    return {"free": LinearMode(matrix, [LinearExit([-1, 0, 0, 0, sigma], "free", reset)])}


@mp.workdps(DIGITS + 10)
def soft_impact(*, a: Any, omega: Any, zeta: Any, e: Any, beta: Any) -> Modes:
    """x'' + 2 zeta x' + x + beta (x - e) H(x - e) = a omega^2 sin(theta). z as above."""
    a, w, zeta, e, beta = (mpf(x) for x in (a, omega, zeta, e, beta))
    load = a * w**2
    rest = _harmonics(w, before=2, n=5)
    free = [[0, 1, 0, 0, 0], [-1, -2 * zeta, 0, load, 0], *rest]
    contact = [[0, 1, 0, 0, 0], [-1 - beta, -2 * zeta, 0, load, beta * e], *rest]
    return {
        "free": LinearMode(free, [LinearExit([-1, 0, 0, 0, e], "contact")]),
        "contact": LinearMode(contact, [LinearExit([1, 0, 0, 0, -e], "free")]),
    }


@mp.workdps(DIGITS + 10)
def oscillator_start(x: Any, v: Any, theta: Any = 0) -> list[mpf]:
    """z of the two oscillators above; ``theta`` is the phase of the forcing at the start."""
    return [mpf(x), mpf(v), *mp.cos_sin(mpf(theta)), mpf(1)]


@mp.workdps(DIGITS + 10)
def mole(*, a: Any, b: Any, xi: Any, omega: Any, g: Any) -> Modes:
    """The ground mole, a second way. z = (p, y, q, v, cos, sin, 1)."""
    a, b, xi, w, g = (mpf(x) for x in (a, b, xi, omega, g))
    k = 1 / (2 * xi)
    still, rest = [0] * 7, _harmonics(w, before=4, n=7)
    speed, relaxation = [0, 1, 0, 0, 0, 0, 0], [0, 0, -k, 0, 0, 0, k]
    free = [speed, [0, 0, 0, 0, a, 0, b], [0, 0, -k, 0, 0, 0, 0], still, *rest]
    held = [speed, [0, -2 * xi, -1, 0, a, 0, b], speed, still, *rest]
    drift = [0, 1, k, 0, 0, 0, -k]
    moving = [relaxation, [0, 0, 0, 0, a, 0, b - 1], relaxation, drift, *rest]
    gap, force = [-1, 0, 1, 0, 0, 0, g], [0, 2 * xi, 1, 0, 0, 0, 0]
    spare, excess = [0, -2 * xi, -1, 0, 0, 0, 1], [0, 2 * xi, 1, 0, 0, 0, -1]
    onto_surface = [[0, 0, 1, 0, 0, 0, g], *_unit_rows(1, 7)]
    return {
        "no_contact": LinearMode(free, [LinearExit(gap, "contact", onto_surface)]),
        "contact": LinearMode(
            held, [LinearExit(force, "no_contact"), LinearExit(spare, "progression")]
        ),
        "progression": LinearMode(moving, [LinearExit(excess, "contact")]),
    }


@mp.workdps(DIGITS + 10)
def mole_start(theta: Any, p: Any = 0, y: Any = 0, q: Any = 0, v: Any = 0) -> list[mpf]:
    """z of the mole; ``theta`` is omega t + phi at the start."""
    return [mpf(p), mpf(y), mpf(q), mpf(v), *mp.cos_sin(mpf(theta)), mpf(1)]


def _harmonics(omega: mpf, before: int, n: int) -> list[list[Any]]:
    """Rows of cos' = -omega sin, sin' = omega cos and 1' = 0, the last three of n."""
    rows: list[list[Any]] = [[0] * n for _ in range(3)]
    rows[0][before + 1], rows[1][before] = -omega, omega
    return rows


def _unit_rows(first: int, n: int) -> list[list[int]]:
    return [[int(i == j) for j in range(n)] for i in range(first, n)]
