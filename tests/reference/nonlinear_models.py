"""Piecewise-smooth systems as functions for `nonlinear.py`, each with a run of a few periods.

Parameters and starts are doubles. All events are transversal: the smallest guard rate is in
`tangent_runs.json`. Starts lie inside a mode.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from .nonlinear import SmoothExit, SmoothMode, SmoothModel
from .power_series import Function, cos, exp, sin, sqrt


class Case(NamedTuple):
    """A system and a run of it."""

    model: SmoothModel
    parameters: Mapping[str, float]
    start: Sequence[float]
    mode: str
    times: Sequence[float]


def negative(function: Function) -> Function:
    return lambda t, z, p: -function(t, z, p)


# ---------------------------------------------------------------- linear in each mode


def oscillator(t: Any, z: Any, p: Any, push: Any) -> list[Any]:
    x, v = z
    return [v, push - 2 * p.zeta * v - x]


def bilinear() -> SmoothModel:
    """x'' + 2 zeta x' + x + beta (x - e) H(x - e) = a omega^2 sin(omega t)."""

    def load(t: Any, p: Any) -> Any:
        return p.a * p.omega**2 * sin(p.omega * t)

    def free(t: Any, z: Any, p: Any) -> list[Any]:
        return oscillator(t, z, p, load(t, p))

    def contact(t: Any, z: Any, p: Any) -> list[Any]:
        return oscillator(t, z, p, load(t, p) - p.beta * (z[0] - p.e))

    def room(t: Any, z: Any, p: Any) -> Any:
        return p.e - z[0]

    return SmoothModel(
        ["x", "v"],
        {
            "free": SmoothMode(free, [SmoothExit(room, "contact")]),
            "contact": SmoothMode(contact, [SmoothExit(negative(room), "free")]),
        },
    )


def rigid_impact() -> SmoothModel:
    """x'' + 2 zeta x' + x = F cos(omega t), x <= sigma, v+ = -r v-."""

    def free(t: Any, z: Any, p: Any) -> list[Any]:
        return oscillator(t, z, p, p.F * cos(p.omega * t))

    def room(t: Any, z: Any, p: Any) -> Any:
        return p.sigma - z[0]

    def rebound(t: Any, z: Any, p: Any) -> list[Any]:
        return [z[0], -p.r * z[1]]

    return SmoothModel(["x", "v"], {"free": SmoothMode(free, [SmoothExit(room, "free", rebound)])})


def vibrating_table() -> SmoothModel:
    """A ball that falls with g onto a table at A sin(omega t); the impact law is for the gap."""

    def fall(t: Any, z: Any, p: Any) -> list[Any]:
        return [z[1], -p.g]

    def gap(t: Any, z: Any, p: Any) -> Any:
        return z[0] - p.A * sin(p.omega * t)

    def rebound(t: Any, z: Any, p: Any) -> list[Any]:
        table = p.A * p.omega * cos(p.omega * t)
        return [z[0], -p.r * (z[1] - table) + table]

    return SmoothModel(
        ["x", "v"], {"flight": SmoothMode(fall, [SmoothExit(gap, "flight", rebound)])}
    )


def mole() -> SmoothModel:
    """The ground mole (section 2 of the chapter); in contact p is slaved to q + g."""

    def load(t: Any, p: Any) -> Any:
        return p.b + p.a * cos(p.omega * t + p.phi)

    def force(t: Any, z: Any, p: Any) -> Any:
        return 2 * p.xi * z[1] + z[2]

    def flight(t: Any, z: Any, p: Any) -> list[Any]:
        return [z[1], load(t, p), -z[2] / (2 * p.xi), 0]

    def contact(t: Any, z: Any, p: Any) -> list[Any]:
        return [0, load(t, p) - force(t, z, p), z[1], 0]

    def progression(t: Any, z: Any, p: Any) -> list[Any]:
        creep = (1 - z[2]) / (2 * p.xi)
        return [0, load(t, p) - 1, creep, z[1] - creep]

    def gap(t: Any, z: Any, p: Any) -> Any:
        return z[2] + p.g - z[0]

    def spare(t: Any, z: Any, p: Any) -> Any:
        return 1 - force(t, z, p)

    on_top = {0: lambda t, z, p: z[2] + p.g}
    ways_out = [SmoothExit(force, "no_contact"), SmoothExit(spare, "progression")]
    return SmoothModel(
        ["p", "y", "q", "v"],
        {
            "no_contact": SmoothMode(flight, [SmoothExit(gap, "contact")]),
            "contact": SmoothMode(contact, ways_out, on_top),
            "progression": SmoothMode(
                progression, [SmoothExit(negative(spare), "contact")], on_top
            ),
        },
    )


# ---------------------------------------------------------------- not linear


def rotor() -> SmoothModel:
    """z'' + 2 zeta z' + z + kappa (1 - 1/|z|) z H(|z| > 1) = rho omega^2 exp(i omega t)."""

    def rates(t: Any, z: Any, p: Any, stiffness: Any) -> list[Any]:
        x, y, u, w = z
        load = p.rho * p.omega**2
        return [
            u,
            w,
            load * cos(p.omega * t) - 2 * p.zeta * u - (1 + stiffness) * x,
            load * sin(p.omega * t) - 2 * p.zeta * w - (1 + stiffness) * y,
        ]

    def free(t: Any, z: Any, p: Any) -> list[Any]:
        return rates(t, z, p, 0)

    def rub(t: Any, z: Any, p: Any) -> list[Any]:
        radius = sqrt(z[0] * z[0] + z[1] * z[1])
        return rates(t, z, p, p.kappa * (1 - 1 / radius))

    def clearance(t: Any, z: Any, p: Any) -> Any:
        return 1 - z[0] * z[0] - z[1] * z[1]

    return SmoothModel(
        ["x", "y", "u", "w"],
        {
            "free": SmoothMode(free, [SmoothExit(clearance, "rub")]),
            "rub": SmoothMode(rub, [SmoothExit(negative(clearance), "free")]),
        },
    )


def curved_mole() -> SmoothModel:
    """A mole without friction: a cubic spring, and a slider whose head is curved.

    In contact p = q + g + h q^2, so F = 2 xi y + q + k q^3 with (1 + 2 h q) q' = y. It lets go
    where F falls to zero: the gap and its rate are both zero there.
    """

    def load(t: Any, p: Any) -> Any:
        return p.b + p.a * cos(p.omega * t)

    def spring(z: Any, p: Any) -> Any:
        q = z[2]
        return q + p.k * q * q * q

    def lever(z: Any, p: Any) -> Any:
        return 1 + 2 * p.h * z[2]

    def force(t: Any, z: Any, p: Any) -> Any:
        return 2 * p.xi * z[1] + spring(z, p)

    def head(t: Any, z: Any, p: Any) -> Any:
        return z[2] + p.g + p.h * z[2] * z[2]

    def flight(t: Any, z: Any, p: Any) -> list[Any]:
        return [z[1], load(t, p), -spring(z, p) / (2 * p.xi * lever(z, p))]

    def contact(t: Any, z: Any, p: Any) -> list[Any]:
        return [0, load(t, p) - force(t, z, p), z[1] / lever(z, p)]

    def gap(t: Any, z: Any, p: Any) -> Any:
        return head(t, z, p) - z[0]

    return SmoothModel(
        ["p", "y", "q"],
        {
            "flight": SmoothMode(flight, [SmoothExit(gap, "contact")]),
            "contact": SmoothMode(contact, [SmoothExit(force, "flight")], {0: head}),
        },
    )


def pendulum() -> SmoothModel:
    """theta'' = -sin(theta) - c theta' + M cos(nu t) beside a wall at d + D sin(nu t).

    The bob, at L sin(theta), meets the wall at the relative speed s and leaves it at
    -e0 s/(1 + k s): the faster, the less elastic. k = e1 e0 is a definition in the text.
    """

    def swing(t: Any, z: Any, p: Any) -> list[Any]:
        return [z[1], p.M * cos(p.nu * t) - sin(z[0]) - p.c * z[1]]

    def room(t: Any, z: Any, p: Any) -> Any:
        return p.d + p.D * sin(p.nu * t) - p.L * sin(z[0])

    def rebound(t: Any, z: Any, p: Any) -> list[Any]:
        wall, arm = p.D * p.nu * cos(p.nu * t), p.L * cos(z[0])
        speed = arm * z[1] - wall
        return [z[0], (wall - p.e0 * speed / (1 + p.e1 * p.e0 * speed)) / arm]

    states = ["theta", "w"]
    return SmoothModel(states, {"swing": SmoothMode(swing, [SmoothExit(room, "swing", rebound)])})


def ramp() -> SmoothModel:
    """x'' = x - x^3 - c x' + F cos(nu t + k t^2/2) beside a wall that recedes, s + u t.

    Of the speed relative to the wall, h exp(-x^2) is left.
    """

    def well(t: Any, z: Any, p: Any) -> list[Any]:
        x, v = z
        load = p.F * cos(p.nu * t + p.k * t * t / 2)
        return [v, x - x * x * x - p.c * v + load]

    def room(t: Any, z: Any, p: Any) -> Any:
        return p.s + p.u * t - z[0]

    def rebound(t: Any, z: Any, p: Any) -> list[Any]:
        return [z[0], p.u - p.h * (z[1] - p.u) * exp(-z[0] * z[0])]

    return SmoothModel(["x", "v"], {"well": SmoothMode(well, [SmoothExit(room, "well", rebound)])})


def every(step: float, count: int) -> list[float]:
    return [step * (k + 1) for k in range(count)]


CASES = {
    "bilinear": Case(
        bilinear(),
        {"a": 0.7, "omega": 0.8, "zeta": 0.01, "e": 1.26, "beta": 29.0},
        [0.2, -0.1],
        "free",
        every(4.1, 8),
    ),
    "rigid impact": Case(
        rigid_impact(),
        {"F": 1.0, "omega": 2.8, "zeta": 0.02, "sigma": 0.1, "r": 0.8},
        [-0.3, 0.4],
        "free",
        every(2.3, 8),
    ),
    "vibrating table": Case(
        vibrating_table(),
        {"g": 1.0, "A": 0.3, "omega": 3.0, "r": 0.7},
        [0.8, 0.1],
        "flight",
        every(2.1, 8),
    ),
    "mole": Case(
        mole(),
        {"a": 0.5, "b": 0.3, "xi": 0.2, "omega": 0.4, "g": 0.02, "phi": math.pi / 2},
        [0.0, 0.0, 0.0, 0.0],
        "no_contact",
        every(5.3, 10),
    ),
    "rotor": Case(
        rotor(),
        {"zeta": 0.1, "kappa": 20.0, "rho": 1.0, "omega": 1.1},
        [0.1, 0.0, 0.0, 0.2],
        "free",
        every(2.3, 8),
    ),
    "pendulum": Case(
        pendulum(),
        {"c": 0.1, "M": 0.4, "nu": 1.3, "d": 0.2, "D": 0.1, "L": 1.2, "e0": 0.9, "e1": 0.4},
        [-0.4, 0.1],
        "swing",
        every(2.6, 8),
    ),
    "curved mole": Case(
        curved_mole(),
        {"a": 0.5, "b": 0.2, "xi": 0.2, "omega": 1.3, "g": 0.02, "h": 0.3, "k": 0.5},
        [-0.1, 0.0, 0.05],
        "flight",
        every(3.3, 8),
    ),
    "ramp": Case(
        ramp(),
        {"c": 0.1, "F": 0.5, "nu": 0.7, "k": 0.05, "s": 0.4, "u": 0.01, "h": 1.1},
        [-0.5, 0.3],
        "well",
        every(2.1, 8),
    ),
}
