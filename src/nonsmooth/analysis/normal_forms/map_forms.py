"""Coefficients of the normal forms of a fixed point of a smooth map.

The formulas are those of Yu. A. Kuznetsov, Elements of Applied Bifurcation Theory, 3rd edition
(2004), sections 5.4 and 9.7: a centre manifold is never computed, only products of the critical
eigenvectors with derivatives of the map. ``q`` is the right eigenvector, of length one where states
are in the units of the user, ``p`` the left one with <p, q> = 1; ``B(u, .)`` and ``C(u, u, .)`` are
matrices, the derivatives of the Jacobian along ``u``. Coefficients come as the terms of which each
is the sum, so that rounding in a sum of large terms is known.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.leading_entry import leading_entry

__all__ = [
    "Critical",
    "critical",
    "cubic_of_crossing",
    "cubic_of_flip",
    "cubic_of_torus",
    "quadratic",
    "solve_beside",
]

Floats = npt.NDArray[np.float64]
Complexes = npt.NDArray[np.complex128]

_NOTHING = 1e-30  # of the largest entry of a matrix


class Critical(NamedTuple):
    """The multiplier of a fixed point that is on the unit circle, with its eigenvectors."""

    multiplier: complex
    right: Complexes  # q, of length one in the units of the user
    left: Complexes  # p, with <p, q> = conj(p) q = 1
    others: Complexes  # the other multipliers, without the conjugate


def critical(jacobian: Floats, sizes: Floats, target: complex | None) -> Critical:
    """The multiplier nearest to 1 or -1; without a target, of pairs nearest to the circle.

    sizes: units in which the map has its states
    """
    # what an event wipes out is left as 1e-200 or so, by which LAPACK would balance the matrix
    scaled = np.where(np.abs(jacobian) > _NOTHING * np.abs(jacobian).max(), jacobian, 0.0)
    values = np.linalg.eigvals(scaled).astype(complex)
    if target is None:
        pairs = np.where(values.imag > 0.0, np.abs(np.abs(values) - 1.0), np.inf)
        place = int(np.argmin(pairs))
    else:
        place = int(np.argmin(np.abs(values - target)))
    value = complex(values[place])
    left, _, right = np.linalg.svd(scaled - value * np.eye(sizes.size))
    q, p = np.conj(right[-1]), left[:, -1]
    # the largest entry real and positive, so that numbers do not depend on the library
    whole = q * sizes
    largest = whole[leading_entry(whole)]
    q = q * np.conj(largest) / (abs(largest) * np.linalg.norm(whole))
    p = p / np.conj(np.vdot(p, q))
    rest = np.delete(values, place)
    if value.imag != 0.0:
        rest = np.delete(rest, int(np.argmin(np.abs(rest - np.conj(value)))))
    return Critical(value, q.astype(complex), p.astype(complex), rest)


def quadratic(here: Critical, b: Floats) -> Floats:
    """<p, B(q, q)>/2 of a fold."""
    q, p = here.right.real, here.left.real
    return p * (b @ q) / 2.0


def cubic_of_flip(here: Critical, jacobian: Floats, b: Floats, c: Floats) -> Floats:
    """<p, C(q, q, q) + 3 B(q, (I - A)^-1 B(q, q))>/6 of a flip; positive: supercritical."""
    q, p = here.right.real, here.left.real
    shift = np.linalg.solve(np.eye(q.size) - jacobian, b @ q)
    return np.concatenate([p * (c @ q), 3.0 * p * (b @ shift)]) / 6.0


def cubic_of_crossing(here: Critical, jacobian: Floats, b: Floats, c: Floats) -> Floats:
    """The same where branches cross in a pitchfork, I - A being singular; negative: supercritical.

    B(q, q) has no part along q there, and the solution is that without one.
    """
    q, p = here.right.real, here.left.real
    square = b @ q
    shift = solve_beside(here, jacobian, square - (p @ square) * q)
    return np.concatenate([p * (c @ q), 3.0 * p * (b @ shift)]) / 6.0


def solve_beside(here: Critical, jacobian: Floats, given: Floats) -> Floats:
    """Solution h of (I - A) h = given with <p, h> = 0, for a multiplier 1."""
    q, p = here.right.real, here.left.real
    bordered = np.block([[np.eye(q.size) - jacobian, q[:, None]], [p[None], np.zeros((1, 1))]])
    found: Floats = np.linalg.solve(bordered, np.append(given, 0.0))[:-1]
    return found


def cubic_of_torus(
    here: Critical, jacobian: Floats, b: tuple[Floats, Floats], c: tuple[Floats, Floats]
) -> Floats:
    """First Lyapunov coefficient of a torus; negative: supercritical.

    b, c: derivatives along the real and along the imaginary part of q
    """
    q, p, unit = here.right, here.left, np.eye(here.right.size)
    turn = here.multiplier / abs(here.multiplier)
    along, back = b[0] + 1j * b[1], b[0] - 1j * b[1]
    mean = np.linalg.solve(unit - jacobian, along @ np.conj(q))
    double = np.linalg.solve(turn**2 * unit - jacobian, along @ q)
    # C(q, q, conj q) is C(re, re, q) + C(im, im, q)
    terms = [(c[0] + c[1]) @ q, 2.0 * along @ mean, back @ double]
    return np.concatenate([(np.conj(turn * p) * term).real for term in terms]) / 2.0
