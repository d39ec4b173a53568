"""Linear models and runs on which the exact and the Taylor flow must agree."""

from typing import Any, NamedTuple

import nonsmooth as ns
from contract.rig import rig
from contract.tangent_systems import bilinear, rigid_impact, vibrating_table


class Model(NamedTuple):
    """A system, its start, the length of the run, and in how many pieces growth is measured."""

    system: ns.System
    initial: dict[str, float]
    t_end: float
    pieces: int


def dry_friction_progression(b, a, omega):
    """A body that slips forward while the load exceeds the friction limit 1, and sticks else.

    In stick the guard is a function of time alone and the speed is slaved to zero.
    """
    return ns.System(
        states=["x", "v"],
        drift=["x"],
        period="2*pi/omega",
        parameters={"b": b, "a": a, "omega": omega},
        definitions={"load": "b + a*cos(omega*t)"},
        modes={
            "stick": ns.Mode({"x": "0"}, slaved={"v": "0"}, exits=[ns.Exit("1 - load", to="slip")]),
            "slip": ns.Mode({"x": "v", "v": "load - 1"}, exits=[ns.Exit("v", to="stick")]),
        },
    )


def mole(periods: int = 20, **parameters: float) -> Model:
    system = ns.models.moling(**parameters)
    assert system.period_value is not None
    return Model(system, {}, periods * system.period_value, 2 * periods)


def mole_rig() -> Model:
    si: dict[str, Any] = {"mass": 2.0, "stiffness": 5e4, "damping": 31.6, "gap": 8e-5}
    forces = {"static_force": 30.0, "dynamic_force": 60.0, "friction_force": 200.0}
    system = ns.models.MolingRig(**si, **forces, angular_frequency=15.8).system()
    return Model(system, {}, 20 * system.period_value, 40)


SOFT = {"a": 0.7, "omega": 0.8, "zeta": 0.01, "e": 1.26, "beta": 29.0}
HARD = {"F": 1.0, "omega": 2.8, "zeta": 0.02, "sigma": 0.1, "r": 0.8}
PRESSED = {**HARD, "sigma": -0.2}
TABLE = {"g": 1.0, "A": 0.3, "omega": 3.0, "r": 0.7}
MOVED = {"X1": 0.01, "X2": 0.1, "X3": 0.02, "X4": 0.01}

MODELS = {
    "mole, one contact per period": mole(),
    "mole, irregular": mole(b=0.05, periods=9),
    "mole, many contacts": mole(b=0.27),
    "mole, direct passages": mole(a=0.9, b=0.3),
    "mole, fast forcing": mole(b=0.1, xi=0.1, omega=1.6, periods=40),
    "mole, critical": mole(xi=1.0),
    "mole, overdamped": mole(xi=1.5),
    "mole, heavy damping": mole(a=0.5, b=0.456, xi=0.35, omega=0.11),
    "mole, SI": mole_rig(),
    "bilinear": Model(bilinear({**SOFT, "beta": 3.0}), {"x": 0.2}, 160.0, 40),
    "soft impact": Model(bilinear(SOFT), {"x": 0.2, "v": -0.1}, 160.0, 40),
    "soft impact, hard stop": Model(bilinear({**SOFT, "beta": 1e4}), {"x": 0.2}, 80.0, 40),
    "rigid impact": Model(rigid_impact(HARD), {"x": -0.3, "v": 0.4}, 45.0, 30),
    "rigid impact, preloaded": Model(rigid_impact(PRESSED), {"x": -0.6}, 45.0, 30),
    "vibrating table": Model(vibrating_table(TABLE), {"x": 0.8, "v": 0.1}, 16.0, 20),
    "progression by dry friction": Model(dry_friction_progression(0.4, 0.9, 0.7), {}, 180.0, 40),
    "fatigue rig": Model(rig(), {}, 2.1, 10),
    "fatigue rig, in motion": Model(rig(f1=5.44, f2=3.52, eta=2.5), MOVED, 5.0, 20),
}
