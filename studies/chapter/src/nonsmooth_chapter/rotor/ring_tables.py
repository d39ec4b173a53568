"""Tables 4, 5 and 6 of the chapter row by row, as printed and corrected, and what they come from.

All take lengths, stiffness and damping in any consistent units. The rows are numbered in the
order of print:

=== ================================= ======================================
row condition                         regime
=== ================================= ======================================
1   |x_s| < Delta_x, |y_s| < Delta_y  II
2   |x_s| < Delta_x, |y_s| >= Delta_y IV
3   |x_s| >= Delta_x, |y_s| < Delta_y III
4   both not less                     V
=== ================================= ======================================

What is wrong in print: Table 4 misses a bracket in row 3, which changes nothing. In Table 5 the
formulas of rows 2 and 3 stand in each other's place, and row 4 has Delta_x in the square that
belongs to y, where it should be Delta_y; rows 2 and 4 have a bracket too many. In Table 6 rows 2
and 3 are exchanged likewise, and x_s of row 1 lacks its division sign.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth import OptionError

__all__ = [
    "REGIME_OF_ROW",
    "boundary_curve",
    "energy_by_work",
    "force_of_springs",
    "table_4",
    "table_5",
    "table_6",
]

REGIME_OF_ROW = {1: "II", 2: "IV", 3: "III", 4: "V"}
_EXCHANGED = {1: 1, 2: 3, 3: 2, 4: 4}  # rows of Tables 5 and 6 in print
_BISECTIONS = 64

Array = np.ndarray
Pair = tuple[Array, Array]


def force_of_springs(
    sx: ArrayLike,
    sy: ArrayLike,
    vx: ArrayLike = 0.0,
    vy: ArrayLike = 0.0,
    *,
    k_s: float = 1.0,
    c_s: float = 0.0,
    delta_x: float = 0.1,
    delta_y: float = 0.1,
) -> Pair:
    """Force of the ring from its four springs and dampers, Eqs. (55)-(59).

    Parameters
    ----------
    sx, sy, vx, vy : array_like
        Displacements and velocities of the ring.
    k_s, c_s : float, optional
        Stiffness and damping of one spring and damper.
    delta_x, delta_y : float, optional
        Preloads.

    Returns
    -------
    tuple of numpy.ndarray
        Components of the restraining force F_s.

    Examples
    --------
    >>> from nonsmooth_chapter.rotor.ring_tables import force_of_springs
    >>> [round(float(part), 6) for part in force_of_springs(0.05, 0.2)]
    [0.1, 0.3]
    """
    return _pair_of_springs(sx, vx, k_s, c_s, delta_x), _pair_of_springs(sy, vy, k_s, c_s, delta_y)


def _pair_of_springs(s: ArrayLike, v: ArrayLike, k_s: float, c_s: float, delta: float) -> Array:
    s, v = np.broadcast_arrays(np.asarray(s, float), np.asarray(v, float))
    # the spring behind pushes back, the one in front pushes on until it has left the ring
    behind = np.where(s > -delta, -(k_s * (delta + s) + c_s * v), 0.0)
    ahead = np.where(s < delta, k_s * (delta - s) - c_s * v, 0.0)
    return -(behind + ahead)


def energy_by_work(
    sx: ArrayLike,
    sy: ArrayLike,
    *,
    k_s: float = 1.0,
    delta_x: float = 0.1,
    delta_y: float = 0.1,
) -> Array:
    """Elastic energy of the ring as the work of Eq. (60).

    The forces are straight lines between the places where a spring leaves the ring, so the
    trapezoidal rule between these is exact.

    Parameters
    ----------
    sx, sy : array_like
        Displacements of the ring.
    k_s : float, optional
        Stiffness of one spring.
    delta_x, delta_y : float, optional
        Preloads.

    Returns
    -------
    numpy.ndarray
        The energy.

    Examples
    --------
    >>> from nonsmooth_chapter.rotor.ring_tables import energy_by_work
    >>> round(float(energy_by_work(0.05, 0.2)), 6)
    0.0375
    """
    total = np.zeros(())
    for s, delta in ((sx, delta_x), (sy, delta_y)):
        end = np.abs(np.asarray(s, float))
        middle = np.minimum(end, delta)
        # just inside the preload both springs still act: there the force is 2 k_s s
        inner = 0.5 * middle * 2.0 * k_s * middle
        forces = (2.0 * k_s * middle, _pair_of_springs(end, 0.0, k_s, 0.0, delta))
        total = total + inner + 0.5 * (end - middle) * (forces[0] + forces[1])
    return np.asarray(total)


def table_4(
    row: int,
    sx: ArrayLike,
    sy: ArrayLike,
    vx: ArrayLike = 0.0,
    vy: ArrayLike = 0.0,
    *,
    k_s: float = 1.0,
    c_s: float = 0.0,
    delta_x: float = 0.1,
    delta_y: float = 0.1,
) -> Pair:
    """Force of the ring by one row of Table 4; print and correction agree.

    Parameters
    ----------
    row : int
        Row, 1 to 4.
    sx, sy, vx, vy : array_like
        Displacements and velocities of the ring; whether the row holds there is not asked.
    k_s, c_s : float, optional
        Stiffness and damping of one spring and damper.
    delta_x, delta_y : float, optional
        Preloads.

    Returns
    -------
    tuple of numpy.ndarray
        Components of the force.

    Examples
    --------
    >>> from nonsmooth_chapter.rotor.ring_tables import table_4
    >>> [round(float(part), 6) for part in table_4(2, 0.05, 0.2)]
    [0.1, 0.3]
    """
    _check(row)
    sx, sy, vx, vy = (np.asarray(values, float) for values in (sx, sy, vx, vy))
    both_x, both_y = 2.0 * k_s * sx + 2.0 * c_s * vx, 2.0 * k_s * sy + 2.0 * c_s * vy
    one_x = np.sign(sx) * k_s * (delta_x + np.abs(sx)) + c_s * vx
    one_y = np.sign(sy) * k_s * (delta_y + np.abs(sy)) + c_s * vy
    return {1: (both_x, both_y), 2: (both_x, one_y), 3: (one_x, both_y), 4: (one_x, one_y)}[row]


def table_5(
    row: int,
    sx: ArrayLike,
    sy: ArrayLike,
    *,
    k_s: float = 1.0,
    delta_x: float = 0.1,
    delta_y: float = 0.1,
    printed: bool = False,
) -> Array:
    """Elastic energy of the ring by one row of Table 5.

    Parameters
    ----------
    row : int
        Row, 1 to 4.
    sx, sy : array_like
        Displacements of the ring; whether the row holds there is not asked.
    k_s : float, optional
        Stiffness of one spring.
    delta_x, delta_y : float, optional
        Preloads.
    printed : bool, optional
        Whether to take the row as it is printed.

    Returns
    -------
    numpy.ndarray
        The energy.

    Examples
    --------
    >>> from nonsmooth_chapter.rotor.ring_tables import table_5
    >>> round(float(table_5(2, 0.05, 0.2)), 6), round(float(table_5(2, 0.05, 0.2, printed=True)), 6)
    (0.0375, 0.04125)
    """
    _check(row)
    x, y = np.abs(np.asarray(sx, float)), np.abs(np.asarray(sy, float))
    two_x, two_y = k_s * x**2, k_s * y**2
    one_x = 0.5 * k_s * ((x + delta_x) ** 2 - 2.0 * delta_x**2)
    added = delta_x if printed and row == 4 else delta_y
    one_y = 0.5 * k_s * ((y + added) ** 2 - 2.0 * delta_y**2)
    correct = {1: two_x + two_y, 2: two_x + one_y, 3: one_x + two_y, 4: one_x + one_y}
    return correct[_EXCHANGED[row] if printed else row]


def table_6(
    row: int,
    x: ArrayLike,
    y: ArrayLike,
    *,
    gamma: float = 1.0,
    delta_x: float = 0.1,
    delta_y: float = 0.1,
    printed: bool = False,
) -> Pair:
    """Position of the ring by one row of Table 6, for a rotor in contact.

    The quartics of rows 2 and 3 are solved for the root between zero and the rotor's coordinate,
    by bisection.

    Parameters
    ----------
    row : int
        Row, 1 to 4.
    x, y : array_like
        Positions of the rotor; whether the row holds there is not asked.
    gamma : float, optional
        Gap.
    delta_x, delta_y : float, optional
        Preloads.
    printed : bool, optional
        Whether to take the row as it is printed.

    Returns
    -------
    tuple of numpy.ndarray
        Coordinates of the ring; not a number where a quartic has no such root.

    Examples
    --------
    >>> from nonsmooth_chapter.rotor.ring_tables import table_6
    >>> [round(float(part), 6) for part in table_6(3, 1.5, 0.2)]
    [0.511732, 0.04727]
    """
    _check(row)
    x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
    wanted = _EXCHANGED[row] if printed else row
    if wanted == 1:
        radius = np.hypot(x, y)
        factor = (radius - gamma) * radius if printed else (radius - gamma) / radius
        return x * factor, y * (radius - gamma) / radius
    if wanted == 2:
        sy, sx = _by_quartic(y, x, delta_y, gamma)
        return sx, sy
    if wanted == 3:
        return _by_quartic(x, y, delta_x, gamma)
    shifted_x, shifted_y = np.abs(x) + delta_x, np.abs(y) + delta_y
    radius = np.hypot(shifted_x, shifted_y)
    share = (radius - gamma) / radius
    sx, sy = shifted_x * share - delta_x, shifted_y * share - delta_y
    return np.sign(x) * sx, np.sign(y) * sy


def boundary_curve(
    equation: int,
    coordinate: ArrayLike,
    *,
    gamma: float = 1.0,
    delta_x: float = 0.1,
    delta_y: float = 0.1,
) -> Array:
    """Boundary in the first quadrant by one of the explicit Eqs. (62)-(66), which are right.

    Parameters
    ----------
    equation : int
        Its number, 62 to 66.
    coordinate : array_like
        Coordinate of the rotor: x for (62), (63) and (66), y for (64) and (65).
    gamma : float, optional
        Gap.
    delta_x, delta_y : float, optional
        Preloads.

    Returns
    -------
    numpy.ndarray
        The other coordinate, also where another equation takes over beyond the corner; not a
        number where there is none.

    Examples
    --------
    >>> from nonsmooth_chapter.rotor.ring_tables import boundary_curve
    >>> round(float(boundary_curve(63, 1.05)), 6)
    0.345118
    """
    if equation not in range(62, 67):
        raise OptionError(f"equation = {equation!r}: the boundaries are 62 to 66")
    value = np.asarray(coordinate, float)
    with np.errstate(invalid="ignore", divide="ignore"):
        if equation == 62:
            return np.sqrt(gamma**2 - value**2)
        # (64) and (65) are (63) and (66) with x and y exchanged
        delta, other = (delta_x, delta_y) if equation in (63, 66) else (delta_y, delta_x)
        root = np.sqrt(gamma**2 - (value - delta) ** 2)
        if equation in (63, 64):
            return value / (value - delta) * root
        return -other + (value + delta) / (value - delta) * root


def _by_quartic(x: Array, y: Array, delta: float, gamma: float) -> Pair:
    """Formulas with one spring in x: (y - t)^2 (X^2 + (y + t)^2) = gamma^2 (y + t)^2, t = |y_s|."""
    shifted, q = np.abs(x) + delta, np.abs(y)
    low, high = np.zeros_like(q), q.copy()

    def excess(t: Array) -> Array:
        return (q - t) ** 2 * (shifted**2 + (q + t) ** 2) - (gamma * (q + t)) ** 2

    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        outside = excess(middle) > 0.0
        low, high = np.where(outside, middle, low), np.where(outside, high, middle)
    t = 0.5 * (low + high)
    # without y the ratio is 0/0; its limit puts the ring straight behind the rotor
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.where(q > 0.0, 2.0 * t / (q + t), 1.0 - gamma / shifted)
    missing = (q > 0.0) & (excess(np.zeros_like(q)) < 0.0)
    sx = np.sign(x) * (shifted * ratio - delta)
    return np.where(missing, np.nan, sx), np.where(missing, np.nan, np.sign(y) * t)


def _check(row: int) -> None:
    if row not in REGIME_OF_ROW:
        raise OptionError(f"row = {row!r}: the tables have rows 1 to 4")
