"""Systems in text whose periodic orbits are known in closed form, and how orbits are compared."""

import json
from pathlib import Path

import numpy as np

import nonsmooth as ns

ORBITS = json.loads(
    (Path(__file__).parent / "references" / "orbits.json").read_text(encoding="utf-8")
)


def rigid_wall(**values: float) -> ns.System:
    """Oscillator at a rigid wall."""
    return ns.System(
        name="wall",
        states=["x", "v"],
        parameters={"F": 1.0, "omega": 2.8, "zeta": 0.02, "sigma": 0.1, "r": 0.8} | values,
        period="2*pi/omega",
        modes={
            "free": ns.Mode(
                {"x": "v", "v": "F*cos(omega*t) - 2*zeta*v - x"},
                exits=[ns.Exit("sigma - x", reset={"v": "-r*v"}, name="impact")],
            )
        },
        initial={"x": -1.0},
    )


def ball_in_space(gamma: float, r: float) -> ns.System:
    """Absolute height of a ball; the table is in the guard and in the reset."""
    return ns.System(
        name="ball_in_space",
        states=["x", "u"],
        period="2*pi/omega",
        parameters={"Gamma": gamma, "omega": 1.0, "r": r},
        modes={
            "flight": ns.Mode(
                {"x": "u", "u": "-1"},
                exits=[
                    ns.Exit(
                        "x - Gamma*sin(omega*t)",
                        reset={"u": "(1 + r)*Gamma*omega*cos(omega*t) - r*u"},
                        name="impact",
                    )
                ],
            )
        },
        initial={"x": 5.0},
    )


def ball_on_table(gamma: float, r: float) -> ns.System:
    """Height above the table, which moves with the ball's frame."""
    return ns.System(
        name="ball_on_table",
        states=["h", "w"],
        period="2*pi/omega",
        parameters={"Gamma": gamma, "omega": 1.0, "r": r},
        modes={
            "flight": ns.Mode(
                {"h": "w", "w": "Gamma*omega**2*sin(omega*t) - 1"},
                exits=[ns.Exit("h", reset={"w": "-r*w"}, name="impact")],
            )
        },
        initial={"h": 5.0},
    )


def friction(beta: float, q: float) -> ns.System:
    """Coulomb friction without a stop: the sign of the velocity switches and is crossed."""
    return ns.System(
        name="friction",
        states=["x", "v"],
        period="2*pi/beta",
        parameters={"beta": beta, "q": q},
        modes={
            "down": ns.Mode({"x": "v", "v": "cos(beta*t) - x + q"}, exits=[ns.Exit("-v", to="up")]),
            "up": ns.Mode({"x": "v", "v": "cos(beta*t) - x - q"}, exits=[ns.Exit("v", to="down")]),
        },
    )


def friction_text(beta: float, q: float) -> ns.System:
    """The same as one piecewise text."""
    return ns.System(
        name="friction_text",
        states=["x", "v"],
        period="2*pi/beta",
        parameters={"beta": beta, "q": q},
        equations={"x": "v", "v": "cos(beta*t) - x - q*sign(v)"},
    )


def clock(zeta: float, energy: float) -> ns.System:
    """Oscillator that gets an energy where it passes x = 0 upwards."""
    return ns.System(
        name="clock",
        states=["x", "v"],
        parameters={"zeta": zeta, "E": energy},
        modes={
            "left": ns.Mode(
                {"x": "v", "v": "-2*zeta*v - x"},
                exits=[
                    ns.Exit("-x", to="right", reset={"v": "sqrt(v**2 + 2*E)"}, name="kick"),
                ],
            ),
            "right": ns.Mode(
                {"x": "v", "v": "-2*zeta*v - x"}, exits=[ns.Exit("x", to="left", name="back")]
            ),
        },
    )


def relay(zeta: float, h: float) -> ns.System:
    """Oscillator under a relay with hysteresis."""
    return ns.System(
        name="relay",
        states=["x", "v"],
        parameters={"zeta": zeta, "h": h},
        modes={
            "push": ns.Mode(
                {"x": "v", "v": "1 - 2*zeta*v - x"}, exits=[ns.Exit("h - x", to="pull", name="top")]
            ),
            "pull": ns.Mode(
                {"x": "v", "v": "-1 - 2*zeta*v - x"},
                exits=[ns.Exit("h + x", to="push", name="bottom")],
            ),
        },
    )


def round_cycle() -> ns.System:
    """In polar coordinates R' = R - R^3 and angle' = 1; the halves are modes with one field."""
    field = {"x": "x - y - x*(x**2 + y**2)", "y": "x + y - y*(x**2 + y**2)"}
    return ns.System(
        name="round_cycle",
        states=["x", "y"],
        modes={
            "upper": ns.Mode(field, exits=[ns.Exit("y", to="lower", name="left_axis")]),
            "lower": ns.Mode(field, exits=[ns.Exit("-y", to="upper", name="right_axis")]),
        },
        initial={"x": 0.5, "y": 0.1},
    )


def as_complex(text: str) -> complex:
    """A number as the file of orbits writes it: real, or real and imaginary part."""
    parts = [float(each) for each in text.split()]
    return complex(*parts)


def assert_multipliers(orbit, expected) -> None:
    """As promised: 1e-9 relative down to 1e-6 of the largest, then 1e-9 of the largest."""
    found = np.atleast_1d(orbit["multipliers"].values)
    expected = [complex(each) for each in expected]
    largest = max(map(abs, expected))
    assert found.size >= len([m for m in expected if abs(m) > 1e-9 * largest])
    left = list(found)
    for value in sorted(expected, key=lambda m: -abs(m))[: found.size]:
        nearest = min(left, key=lambda m: abs(m - value))
        left.remove(nearest)
        allowed = abs(value) if abs(value) > 1e-6 * largest else largest
        assert abs(nearest - value) < 1e-9 * allowed, (found, expected)
    assert all(abs(m) < 1e-9 * largest for m in left), (found, expected)


def assert_state(orbit, expected, tolerance: float = 1e-10) -> None:
    """States on the section, in units of the largest of them or one."""
    scale = max(1.0, *(abs(value) for value in expected.values()))
    for name, value in expected.items():
        assert abs(float(orbit[name]) - value) < tolerance * scale, (
            name,
            float(orbit[name]),
            value,
        )


# the speed at which the pressure of a follower on its cam comes to zero once in a turn: it is
# 4 + (w**2 - 4)/2 cos(w t) + 0.1 w sin(w t), so 16 = (w**2 - 4)**2 / 4 + 0.01 w**2
LIFT_OFF = float(np.sqrt(3.98 + np.sqrt(3.98**2 + 48.0)))


def cam_follower(phase: float = 0.0) -> ns.System:
    """A follower that a spring holds on a cam; the cam is at rest at its lowest at -phase / w."""
    return ns.System(
        states=["y", "v"],
        parameters={"w": 3.0, "phase": phase},
        period="2*pi/w",
        initial={"y": 2.0},
        definitions={"s": "(1 - cos(w*t + phase))/2", "sd": "w*sin(w*t + phase)/2"},
        modes={
            "air": ns.Mode(
                {"y": "v", "v": "-4*(y + 0.5) - 0.2*v"},
                exits=[
                    ns.Exit("y - s", reset={"v": "sd - 0.3*(v - sd)"}, sticks="rides", name="land")
                ],
            )
        },
    )
