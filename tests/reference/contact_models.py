"""Systems that stick, slide and come to rest, written mode by mode for `nonlinear.py`.

A mode on a surface has the rates of motion that stays on it, and exits where the force that holds
it there reaches its limit. Nothing is convex, equivalent or derived here: each is worked out by
hand from the balance of forces. Contacts come to rest by `resting.RestingExit`.
"""

from collections.abc import Mapping
from itertools import product
from typing import Any

from .nonlinear import SmoothExit, SmoothMode, SmoothModel
from .nonlinear_models import Case, negative
from .power_series import cos, sin
from .resting import RestingExit

# ---------------------------------------------------------------- friction


def pulls(t: Any, z: Any, p: Any) -> tuple[Any, Any]:
    """Forces on two masses, but for friction: springs to the ground, between them, and a load."""
    x, _, y, w = z
    between = p.k * (x - y)
    return p.a * cos(p.omega * t) - x - between, between - p.c * w


def belt_pair() -> SmoothModel:
    """The first of two masses rubs on a belt at the speed v_b: F_k in slip, more in stick."""

    def held(p: Any) -> Any:
        return p.F_k * getattr(p, "hold", 1)

    def rates(t: Any, z: Any, p: Any, friction: Any) -> list[Any]:
        first, second = pulls(t, z, p)
        return [z[1], first - friction, z[3], second]

    def slip(t: Any, z: Any, p: Any) -> Any:
        return z[1] - p.v_b

    def stuck(t: Any, z: Any, p: Any) -> list[Any]:
        return [p.v_b, 0, z[3], pulls(t, z, p)[1]]

    ways_off = [
        SmoothExit(lambda t, z, p: held(p) - pulls(t, z, p)[0], "lead"),
        SmoothExit(lambda t, z, p: held(p) + pulls(t, z, p)[0], "lag"),
    ]
    return SmoothModel(
        ["x", "v", "y", "w"],
        {
            "lag": SmoothMode(
                lambda t, z, p: rates(t, z, p, -p.F_k), [SmoothExit(negative(slip), "stick")]
            ),
            "lead": SmoothMode(lambda t, z, p: rates(t, z, p, p.F_k), [SmoothExit(slip, "stick")]),
            "stick": SmoothMode(stuck, ways_off, {1: lambda t, z, p: p.v_b}),
        },
    )


def two_brakes() -> SmoothModel:
    """Both masses rub: the first on a belt, the second on the ground. Names: signs of the slips."""

    def mode(first: int, second: int) -> SmoothMode:
        def rates(t: Any, z: Any, p: Any) -> list[Any]:
            one, two = pulls(t, z, p)
            return [
                z[1],
                one - first * p.F_1 if first else 0,
                z[3],
                two - second * p.F_2 if second else 0,
            ]

        exits = _brake(first, lambda s: name(s, second), 0, lambda z, p: z[1] - p.v_b, "F_1")
        exits += _brake(second, lambda s: name(first, s), 1, lambda z, p: z[3], "F_2")
        slaved: dict[int, Any] = {}
        if not first:
            slaved[1] = lambda t, z, p: p.v_b
        if not second:
            slaved[3] = lambda t, z, p: 0
        return SmoothMode(rates, exits, slaved)

    def name(first: int, second: int) -> str:
        return "-0+"[first + 1] + "-0+"[second + 1]

    signs = product((-1, 0, 1), repeat=2)
    return SmoothModel(["x", "v", "y", "w"], {name(*pair): mode(*pair) for pair in signs})


def _brake(sign: int, name: Any, number: int, slip: Any, limit: str) -> list[SmoothExit]:
    """Ways onto the surface of one brake, or off it."""
    if sign:
        return [SmoothExit(lambda t, z, p: sign * slip(z, p), name(0))]

    def spare(t: Any, z: Any, p: Any, side: int) -> Any:
        return getattr(p, limit) - side * pulls(t, z, p)[number]

    return [
        SmoothExit(lambda t, z, p: spare(t, z, p, 1), name(1)),
        SmoothExit(lambda t, z, p: spare(t, z, p, -1), name(-1)),
    ]


def relay() -> SmoothModel:
    """A relay on the curved surface z + x + y + b x**2 = 0: z' = a sin(t) - 2 sign(of it)."""

    def plant(t: Any, z: Any, p: Any) -> list[Any]:
        x, y, push = z
        return [y, push - x - p.c * y]

    def surface(t: Any, z: Any, p: Any) -> Any:
        return z[2] + z[0] + z[1] + p.b * z[0] * z[0]

    def held(t: Any, z: Any, p: Any) -> Any:
        one, two = plant(t, z, p)
        return -one - two - 2 * p.b * z[0] * one

    def drive(t: Any, z: Any, p: Any) -> Any:
        """2 u, with u between -1 and 1 while the relay holds the surface."""
        return p.a * sin(t) - held(t, z, p)

    def side(sign: int) -> SmoothMode:
        return SmoothMode(
            lambda t, z, p: [*plant(t, z, p), p.a * sin(t) - 2 * sign],
            [SmoothExit(lambda t, z, p: sign * surface(t, z, p), "on")],
        )

    on = SmoothMode(
        lambda t, z, p: [*plant(t, z, p), held(t, z, p)],
        [
            SmoothExit(lambda t, z, p: 2 - drive(t, z, p), "above"),
            SmoothExit(lambda t, z, p: 2 + drive(t, z, p), "below"),
        ],
        {2: lambda t, z, p: -z[0] - z[1] - p.b * z[0] * z[0]},
    )
    return SmoothModel(["x", "y", "z"], {"above": side(1), "below": side(-1), "on": on})


# ---------------------------------------------------------------- contacts at rest


def chattering_oscillator() -> SmoothModel:
    """x'' + 2 zeta x' + x = F cos(omega t), x <= sigma, v+ = -r v-, and rest at the wall."""

    def load(t: Any, p: Any) -> Any:
        return p.F * cos(p.omega * t)

    wall = RestingExit(
        lambda t, z, p: p.sigma - z[0],
        "free",
        lambda t, z, p: [p.sigma, -p.r * z[1]],
        "stuck",
        lambda t, z, p: [p.sigma, 0],
    )
    free = SmoothMode(lambda t, z, p: [z[1], load(t, p) - 2 * p.zeta * z[1] - z[0]], [wall])
    force = SmoothExit(lambda t, z, p: load(t, p) - p.sigma, "free")
    return SmoothModel(
        ["x", "v"], {"free": free, "stuck": SmoothMode(lambda t, z, p: [0 * t, 0 * t], [force])}
    )


def ball_on_a_table() -> SmoothModel:
    """A ball that falls with g onto A sin(omega t), and rides on it while A omega^2 sin < g."""

    def table(t: Any, p: Any) -> tuple[Any, Any, Any]:
        angle = p.omega * t
        return (
            p.A * sin(angle),
            p.A * p.omega * cos(angle),
            -p.A * p.omega * p.omega * sin(angle),
        )

    def rebound(t: Any, z: Any, p: Any) -> list[Any]:
        height, speed, _ = table(t, p)
        return [height, speed - p.r * (z[1] - speed)]

    contact = RestingExit(
        lambda t, z, p: z[0] - table(t, p)[0],
        "flight",
        rebound,
        "riding",
        lambda t, z, p: list(table(t, p)[:2]),
    )
    flight = SmoothMode(lambda t, z, p: [z[1], -p.g], [contact])
    riding = SmoothMode(
        lambda t, z, p: list(table(t, p)[1:]),
        [SmoothExit(lambda t, z, p: table(t, p)[2] + p.g, "flight")],
        {0: lambda t, z, p: table(t, p)[0], 1: lambda t, z, p: table(t, p)[1]},
    )
    return SmoothModel(["x", "v"], {"flight": flight, "riding": riding})


def platform() -> SmoothModel:
    """A ball of mass 1 that rebounds from a platform of mass M on a spring, shaken by a load.

    Momentum is kept at an impact, so both speeds jump; at rest they move as one mass.
    """

    def load(t: Any, y: Any, w: Any, p: Any) -> Any:
        return p.a * cos(p.omega * t) - p.K * y - p.c * w

    def flight(t: Any, z: Any, p: Any) -> list[Any]:
        return [z[1], -p.g, z[3], load(t, z[2], z[3], p) / p.M]

    def rebound(t: Any, z: Any, p: Any) -> list[Any]:
        impulse = -(1 + p.r) * p.M / (1 + p.M) * (z[1] - z[3])
        return [z[2], z[1] + impulse, z[2], z[3] - impulse / p.M]

    def together(t: Any, z: Any, p: Any) -> list[Any]:
        speed = (z[1] + p.M * z[3]) / (1 + p.M)
        return [z[2], speed, z[2], speed]

    def lift(t: Any, z: Any, p: Any) -> Any:
        return (load(t, z[2], z[3], p) - p.g) / (1 + p.M)

    riding = SmoothMode(
        lambda t, z, p: [z[3], lift(t, z, p), z[3], lift(t, z, p)],
        [SmoothExit(lambda t, z, p: lift(t, z, p) + p.g, "flight")],
        {0: lambda t, z, p: z[2], 1: lambda t, z, p: z[3]},
    )
    contact = RestingExit(lambda t, z, p: z[0] - z[2], "flight", rebound, "riding", together)
    return SmoothModel(
        ["x", "v", "y", "w"], {"flight": SmoothMode(flight, [contact]), "riding": riding}
    )


def wall_pair() -> SmoothModel:
    """Two masses and springs, the one between them with a cubic part; the first meets a wall."""

    def between(z: Any, p: Any) -> Any:
        stretch = z[0] - z[2]
        return p.k * stretch + p.k3 * stretch * stretch * stretch

    def force(t: Any, z: Any, p: Any) -> Any:
        return p.F * cos(p.omega * t) - 2 * p.zeta * z[1] - z[0] - between(z, p)

    def second(z: Any, p: Any) -> Any:
        return between(z, p) - 2 * p.zeta * z[3]

    wall = RestingExit(
        lambda t, z, p: p.sigma - z[0],
        "free",
        lambda t, z, p: [p.sigma, -p.r * z[1], z[2], z[3]],
        "stuck",
        lambda t, z, p: [p.sigma, 0, z[2], z[3]],
    )
    free = SmoothMode(lambda t, z, p: [z[1], force(t, z, p), z[3], second(z, p)], [wall])
    stuck = SmoothMode(
        lambda t, z, p: [0 * t, 0 * t, z[3], second(z, p)],
        [SmoothExit(force, "free")],
        {0: lambda t, z, p: p.sigma, 1: lambda t, z, p: 0},
    )
    return SmoothModel(["x", "v", "y", "w"], {"free": free, "stuck": stuck})


# ---------------------------------------------------------------- runs

BELT: Mapping[str, float] = {
    "k": 0.5, "c": 0.1, "a": 0.6, "omega": 0.7, "v_b": 0.3, "F_k": 0.4,
}  # fmt: skip
BRAKES: Mapping[str, float] = {
    "k": 0.5, "c": 0.1, "a": 0.7, "omega": 0.7, "v_b": 0.1, "F_1": 0.4, "F_2": 0.3,
}  # fmt: skip
WALL: Mapping[str, float] = {"F": 1.0, "omega": 0.3, "zeta": 0.0, "sigma": 0.0, "r": 0.8}
TABLE: Mapping[str, float] = {"A": 1.5, "omega": 1.0, "g": 1.0, "r": 0.3}
PAIR: Mapping[str, float] = {
    "F": 1.0, "omega": 0.3, "zeta": 0.05, "sigma": 0.1, "r": 0.5, "k": 0.7, "k3": 0.0,
}  # fmt: skip
PLATFORM: Mapping[str, float] = {
    "g": 1.0, "M": 2.0, "K": 3.0, "c": 0.2, "a": 2.5, "omega": 0.8, "r": 0.5,
}  # fmt: skip

# With tangents and sensitivities: each passes entry, exit, and something behind both.
CASES: Mapping[str, Case] = {
    "belt": Case(belt_pair(), BELT, [0.2, -0.4, -0.3, 0.5], "lag", [2.0, 6.0, 12.0, 20.0]),
    "belt that holds": Case(
        belt_pair(), {**BELT, "hold": 1.5}, [0.2, -0.4, -0.3, 0.5], "lag", [2.0, 6.0, 12.0, 20.0]
    ),
    "two brakes": Case(two_brakes(), BRAKES, [0.5, -0.6, -0.7, 0.5], "-+", [2.0, 6.0, 12.0, 20.0]),
    "relay": Case(
        relay(), {"c": 0.1, "b": 0.3, "a": 2.2}, [0.8, -0.5, 1.0], "above", [1.0, 3.5, 6.5, 11.0]
    ),
    "plastic wall": Case(
        wall_pair(), {**PAIR, "r": 0.0}, [-0.5, 0.3, 0.2, -0.4], "free", [5.0, 22.0, 30.0]
    ),
    "wall": Case(wall_pair(), PAIR, [-0.5, 0.3, 0.2, -0.4], "free", [5.0, 22.0, 30.0]),
    "wall, cubic": Case(
        wall_pair(), {**PAIR, "k3": 0.4}, [-0.5, 0.3, 0.2, -0.4], "free", [5.0, 22.0, 30.0]
    ),
    "platform": Case(platform(), PLATFORM, [1.0, 0.0, 0.1, 0.2], "flight", [2.0, 5.0, 8.0, 12.0]),
    "table": Case(ball_on_a_table(), TABLE, [1.0, 0.5], "flight", [2.0, 9.0, 12.0, 16.0]),
}

# States and events alone. The larger the ratio, the less a table may shake a ball that is to rest.
RATIOS = {0.05: 0.4, 0.3: 0.4, 0.8: 0.4, 0.95: 0.01, 0.99: 0.002}
ACCUMULATIONS: Mapping[str, Case] = {
    "oscillator": Case(chattering_oscillator(), WALL, [-0.5, 0.0], "free", [20.0, 25.0, 30.0]),
    "damped oscillator": Case(
        chattering_oscillator(),
        {**WALL, "zeta": 0.1, "sigma": 0.2},
        [-0.5, 0.0],
        "free",
        [20.0, 25.0, 30.0],
    ),
    **{
        f"resting table, r = {r}": Case(
            ball_on_a_table(),
            {"A": height, "omega": 1.3, "g": 1.0, "r": r},
            [1.0, 0.1] if r < 0.9 else [0.3, 0.1],
            "flight",
            [1.0, 40.0 if r < 0.97 else 160.0],
        )
        for r, height in RATIOS.items()
    },
}
