"""Coefficients of normal forms of a map in many digits, from its derivatives by mpmath.

For planar maps on a complex eigenvector the formula is that of the Poincare normal form with
g20, g11, g02 and g21 (Kuznetsov, section 4.7), which needs no inverse of a matrix.
"""

from collections.abc import Callable

from mpmath import mp, mpc, mpf

DIGITS = 60
Map = Callable[..., list[mpf]]  # from (state, parameter) to the image


def along(function: Map, state, parameter, directions: list, orders: tuple[int, ...]):
    """Mixed derivative of the image along directions, (n,)."""

    def component(i: int):
        def moved(*steps):
            point = [
                x + sum(s * d[k] for s, d in zip(steps, directions, strict=True))
                for k, x in enumerate(state)
            ]
            return function(point, parameter)[i]

        return mp.diff(moved, (0,) * len(orders), orders)

    return mp.matrix([component(i) for i in range(len(state))])


def jacobian(function: Map, state, parameter):
    n = len(state)
    unit = mp.eye(n)
    columns = [along(function, state, parameter, [list(unit[:, k])], (1,)) for k in range(n)]
    return mp.matrix([[columns[k][i] for k in range(n)] for i in range(n)])


def eigenvectors(matrix, target):
    """Right eigenvector of length one and left one of product one, for a multiplier."""
    values, left, right = mp.eig(matrix, left=True, right=True)
    place = min(range(len(values)), key=lambda k: abs(values[k] - target))
    q = right[:, place]
    q /= mp.norm(q)
    p = left[place, :].T  # rows: no conjugate
    p /= (p.T * q)[0]
    return values[place], q, p


def dot(p, vector):
    return (p.T * vector)[0]


def fold(function: Map, state, parameter):
    """Quadratic coefficient, and that of the parameter up to the sign of q."""
    matrix = jacobian(function, state, parameter)
    _, q, p = eigenvectors(matrix, mpf(1))
    a = dot(p, along(function, state, parameter, [list(q)], (2,))) / 2
    by_parameter = mp.matrix(
        [mp.diff(lambda m, i=i: function(state, m)[i], parameter) for i in range(len(state))]
    )
    return mp.re(a), mp.re(dot(p, by_parameter))


def flip(function: Map, state, parameter):
    """Cubic coefficient."""
    matrix = jacobian(function, state, parameter)
    _, q, p = eigenvectors(matrix, mpf(-1))
    square = along(function, state, parameter, [list(q)], (2,))
    shift = mp.lu_solve(mp.eye(len(state)) - matrix, square)
    cube = along(function, state, parameter, [list(q)], (3,))
    mixed = along(function, state, parameter, [list(q), list(shift)], (1, 1))
    return mp.re(dot(p, cube + 3 * mixed)) / 6


def planar_torus(function: Map, state, parameter):
    """First Lyapunov coefficient of a map of the plane, by complex coordinates z.

    The state is z q + conj(z) conj(q); the image along q is a polynomial of z and conj(z), whose
    coefficients are derivatives by the real and imaginary parts of z.
    """
    matrix = jacobian(function, state, parameter)
    values, _, right = mp.eig(matrix, left=True, right=True)
    place = 0 if mp.im(values[0]) > 0 else 1
    value, q = values[place], right[:, place]
    q /= mp.norm(q)
    # conj(p) with conj(p) q = 1 and conj(p) conj(q) = 0
    basis = mp.matrix([[q[0], mp.conj(q[0])], [q[1], mp.conj(q[1])]])
    p = (basis**-1)[0, :].T
    re, im = [2 * mp.re(x) for x in q], [-2 * mp.im(x) for x in q]

    def derivative(*orders: int):
        return dot(p, along(function, state, parameter, [re, im], orders))

    # d/dz = (d/dx - i d/dy)/2 of z = x + i y
    xx, xy, yy = derivative(2, 0), derivative(1, 1), derivative(0, 2)
    g20, g11, g02 = (xx - yy - 2j * xy) / 4, (xx + yy) / 4, (xx - yy + 2j * xy) / 4
    xxx, xxy, xyy, yyy = (derivative(3 - k, k) for k in range(4))
    g21 = (xxx + xyy - 1j * (xxy + yyy)) / 8
    back = mp.conj(value) / abs(value)
    turn = mpc(value) / abs(value)
    return mp.re(
        back * g21 / 2
        - (1 - 2 * turn) * back**2 / (2 * (1 - turn)) * g20 * g11
        - abs(g11) ** 2 / 2
        - abs(g02) ** 2 / 4
    )
