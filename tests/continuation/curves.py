"""Residuals with branches in closed form."""

import numpy as np
from scipy import sparse


def circle(u, p):
    """u**2 + p**2 = 1."""
    return u**2 + p**2 - 1, 2 * u, 2 * p


def cubic(u, p):
    """u**3 - u + p = 0: folds at u = +-1/sqrt(3), p = +-2/sqrt(27)."""
    return u**3 - u + p, 3 * u**2 - 1, 1.0


def pitchfork(u, p):
    """The branch u = 0 and the parabola p = u**2 cross at 0."""
    return u * (p - u**2), p - 3 * u**2, u


def lemniscate(u, p):
    """(u**2 + p**2)**2 = p**2 - u**2, a figure eight that crosses itself at 0."""
    s = u * u + p * p
    return s**2 - p * p + u * u, 4 * u * s + 2 * u, 4 * p * s - 2 * p


def reaction(u, p, q, beta=2.0):
    """The reaction A -> B in a stirred tank (Uppal, Ray and Poore 1974), first of AUTO's examples.

    In equilibrium u[1] = q u[0]/(1 + beta).
    """
    x, y = u
    e, rest = np.exp(y), 1 - x
    r = np.array([-x + p * rest * e, -y + p * q * rest * e - beta * y])
    J_u = np.array([[-1 - p * e, p * rest * e], [-p * q * e, -1 + p * q * rest * e - beta]])
    return r, J_u, np.array([rest * e, q * rest * e]), np.array([0.0, p * rest * e])


def reaction_folds(q, beta=2.0):
    """u[0] and p at both folds: p = x/(1 - x) exp(-k x) has its extrema where k x (1 - x) = 1."""
    k = q / (1 + beta)
    x = 0.5 + np.array([-0.5, 0.5]) * np.sqrt(1 - 4 / k)
    return x, x / (1 - x) * np.exp(-k * x)


def henon(u, a, b):
    """Fixed points of x, y -> 1 - a x**2 + y, b x as zeros of u - f(u)."""
    x, y = u
    r = np.array([x - 1 + a * x * x - y, y - b * x])
    J_u = np.array([[1 + 2 * a * x, -1.0], [-b, 1.0]])
    return r, J_u, np.array([x * x, 0.0]), np.array([0.0, -x])


def henon_fixed_point(a, b):
    """The outer one of them."""
    x = (-(1 - b) + np.sqrt((1 - b) ** 2 + 4 * a)) / (2 * a)
    return np.array([x, b * x])


def chebyshev_bratu(m):
    """u'' + p exp(u) = 0, u(0) = u(1) = 0 by collocation in m + 1 points (Trefethen's matrix)."""
    k = np.arange(m + 1)
    x = np.cos(np.pi * k / m)
    c = np.where((k == 0) | (k == m), 2.0, 1.0) * (-1.0) ** k
    apart = x[:, None] - x[None, :]
    D = np.outer(c, 1 / c) / (apart + np.eye(m + 1))
    D -= np.diag(D.sum(axis=1))
    second = 4 * (D @ D)[1:-1, 1:-1]

    def residual(u, p):
        e = np.exp(u)
        return second @ u + p * e, second + p * np.diag(e), e

    return residual, m - 1


def sparse_bratu(n):
    """The same by second differences in n inner points."""
    ones = np.ones(n)
    laplace = sparse.diags_array([ones[1:], -2 * ones, ones[1:]], offsets=[-1, 0, 1]).tocsr()
    laplace = laplace * (n + 1) ** 2

    def residual(u, p):
        e = np.exp(u)
        return laplace @ u + p * e, laplace + p * sparse.diags_array(e), e

    return residual
