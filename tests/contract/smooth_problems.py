"""Smooth systems that are not linear, as texts and as expressions of heyoka."""

from collections.abc import Callable
from typing import Any, NamedTuple

import pytest

import nonsmooth as ns

hy = pytest.importorskip("heyoka", reason="comes with the extra 'benchmark'")


class Problem(NamedTuple):
    """Rates as texts by state, and the same as a function of heyoka's variables."""

    flow: dict[str, str]
    parameters: dict[str, float]
    start: dict[str, float]
    t_end: float
    peer: Callable[..., list[Any]]

    def system(self) -> ns.System:
        return ns.System(
            states=list(self.flow), parameters=self.parameters, modes={"m": ns.Mode(self.flow)}
        )

    def expressions(self) -> list[tuple[Any, Any]]:
        variables = hy.make_vars(*self.flow)
        return list(zip(variables, self.peer(*variables, **self.parameters), strict=True))


def duffing(x, v, c, F, omega):
    return [v, x - x**3 - c * v + F * hy.cos(omega * hy.time)]


def pendulum(x, v, c, M, nu):
    return [v, -hy.sin(x) - c * v + M * hy.cos(nu * hy.time)]


def van_der_pol(x, v, mu):
    return [v, mu * (1.0 - x * x) * v - x]


def lorenz(x, y, z, sigma, rho, beta):
    return [sigma * (y - x), x * (rho - z) - y, x * y - beta * z]


def chua(x, y, z, alpha, beta, a, c):
    return [alpha * (y - a * x**3 - c * x), x - y + z, -beta * y]


def double_pendulum(a, b, u, w, g):
    """Two equal masses on two equal rods of length one."""
    s, c = hy.sin(a - b), hy.cos(a - b)
    k = 2.0 - c * c
    return [
        u,
        w,
        (-s * (c * u * u + w * w) - 2.0 * g * hy.sin(a) + g * c * hy.sin(b)) / k,
        (s * (2.0 * u * u + c * w * w) + 2.0 * g * c * hy.sin(a) - 2.0 * g * hy.sin(b)) / k,
    ]


def kepler(x, y, u, w, mu):
    cube = (x * x + y * y) ** 1.5
    return [u, w, -mu * x / cube, -mu * y / cube]


def self_sustained(x, v, b, p):
    """Stribeck friction without a corner."""
    slip = v - b
    return [v, -x - hy.tanh(slip / p) * (0.4 + 0.2 * hy.exp(-slip * slip))]


PROBLEMS = {
    "Duffing": Problem(
        {"x": "v", "v": "x - x**3 - c*v + F*cos(omega*t)"},
        {"c": 0.15, "F": 0.3, "omega": 1.0},
        {"x": 0.5, "v": -0.2},
        40.0,
        duffing,
    ),
    "pendulum": Problem(
        {"x": "v", "v": "-sin(x) - c*v + M*cos(nu*t)"},
        {"c": 0.5, "M": 1.15, "nu": 2 / 3},
        {"x": 0.2, "v": 0.0},
        40.0,
        pendulum,
    ),
    "Van der Pol": Problem(
        {"x": "v", "v": "mu*(1 - x**2)*v - x"}, {"mu": 5.0}, {"x": 2.0, "v": 0.0}, 40.0, van_der_pol
    ),
    "Lorenz": Problem(
        {"x": "sigma*(y - x)", "y": "x*(rho - z) - y", "z": "x*y - beta*z"},
        {"sigma": 10.0, "rho": 28.0, "beta": 8 / 3},
        {"x": 1.0, "y": 1.0, "z": 20.0},
        8.0,
        lorenz,
    ),
    "Chua, cubic": Problem(
        {"x": "alpha*(y - a*x**3 - c*x)", "y": "x - y + z", "z": "-beta*y"},
        {"alpha": 10.0, "beta": 16.0, "a": 1 / 16, "c": -1 / 6},
        {"x": 0.1, "y": 0.0, "z": 0.0},
        30.0,
        chua,
    ),
    "double pendulum": Problem(
        {
            "a": "u",
            "b": "w",
            "u": "(-sin(a-b)*(cos(a-b)*u**2 + w**2) - 2*g*sin(a) + g*cos(a-b)*sin(b))"
            "/(2 - cos(a-b)**2)",
            "w": "(sin(a-b)*(2*u**2 + cos(a-b)*w**2) + 2*g*cos(a-b)*sin(a) - 2*g*sin(b))"
            "/(2 - cos(a-b)**2)",
        },
        {"g": 9.81},
        {"a": 1.5, "b": 2.0, "u": 0.0, "w": 0.0},
        5.0,
        double_pendulum,
    ),
    "Kepler, eccentricity 0.9": Problem(
        {"x": "u", "y": "w", "u": "-mu*x/(x**2 + y**2)**1.5", "w": "-mu*y/(x**2 + y**2)**1.5"},
        {"mu": 1.0},
        {"x": 0.1, "y": 0.0, "u": 0.0, "w": 19.0**0.5},
        20.0,
        kepler,
    ),
    "smooth friction": Problem(
        {"x": "v", "v": "-x - tanh((v - b)/p)*(0.4 + 0.2*exp(-(v - b)**2))"},
        {"b": 0.3, "p": 0.05},
        {"x": 0.0, "v": 0.0},
        30.0,
        self_sustained,
    ),
}

# f(x) along x' = v, v' = -sin(x): each function of the grammar within its domain
FUNCTIONS = {
    "sin(2*x)": lambda x, v: hy.sin(2.0 * x),
    "cos(x*v)": lambda x, v: hy.cos(x * v),
    "tan(x)": lambda x, v: hy.tan(x),
    "asin(x/3)": lambda x, v: hy.asin(x / 3.0),
    "acos(v/3)": lambda x, v: hy.acos(v / 3.0),
    "atan(4*x)": lambda x, v: hy.atan(4.0 * x),
    "atan2(v, x + 3)": lambda x, v: hy.atan2(v, x + 3.0),
    "sinh(x)": lambda x, v: hy.sinh(x),
    "cosh(2*v)": lambda x, v: hy.cosh(2.0 * v),
    "tanh(5*x)": lambda x, v: hy.tanh(5.0 * x),
    "exp(-x)": lambda x, v: hy.exp(-x),
    "log(x + 2)": lambda x, v: hy.log(x + 2.0),
    "sqrt(x + 2)": lambda x, v: hy.sqrt(x + 2.0),
    "1/(1 + x**2)": lambda x, v: 1.0 / (1.0 + x * x),
    "(2 + x)**0.7": lambda x, v: (2.0 + x) ** 0.7,
    "(2 + x)**(-1.3)": lambda x, v: (2.0 + x) ** -1.3,
    "x**7": lambda x, v: x**7.0,
    "(2 + v)**x": lambda x, v: (2.0 + v) ** x,
    "2**x": lambda x, v: hy.expression(2.0) ** x,
    "x**2*v**3": lambda x, v: x**2.0 * v**3.0,
}
