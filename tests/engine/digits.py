"""Digits of some runs, to compare builds of the engine.

    NONSMOOTH_ENGINE=baseline PYTHONPATH=src:tests python -m engine.digits

prints the library that was used, and a hash of each variable of each result.
"""

import hashlib
import json
from pathlib import Path

import nonsmooth as ns
from engine.flow_survey import coefficients, template
from engine.spectra import draw
from nonsmooth.engine.library import engine

models = ns.models
PENDULUM = ns.System(
    states=["x", "v"],
    parameters={"F": 1.2, "c": 0.1},
    period="3*pi",
    modes={
        "swings": ns.Mode(
            {"x": "v", "v": "-sin(x) - c*v + F*cos(2*t/3)"},
            exits=[ns.Exit("1.5 - x", reset={"v": "-0.8*v"}, name="stop")],
        )
    },
)
FUNCTIONS = ns.System(  # each kernel of Taylor series once
    states=["x", "v"],
    period="2*pi",
    equations={
        "x": "v",
        "v": "exp(-x**2)*cos(t) - x - tanh(v)/3 - atan(x)/9 - v*x**2/7 - sqrt(9 + x*v)/5"
        " - log(9 + v)/8 - sinh(x)/9 - cosh(x)/9 - sin(x) - x**3/(1 + x**2) - tan(x/9)"
        " - (2 + cos(x))**0.3*v/4 - asin(v/20) + acos(x/20)/9 - atan2(x, 9 + v)/3"
        " - (x - v)*(x + 2*v)*v/9",
    },
)
RIG = Path(__file__).parents[2] / "examples" / "fatigue_rig.toml"


def relaxing():
    """Relaxation at 1e5 beside decay at 0.006, which needs sums in doubled precision."""
    case = draw("relaxing", 3)
    system = template(len(case.start), case.frequencies.size).with_parameters(**coefficients(case))
    start = {f"x{i}": float(x) for i, x in enumerate(case.start)}
    return ns.simulate(system, start, t_end=2.0, tangent=["a0_0"])


RUNS = {
    "soft_impact": lambda: ns.simulate(models.soft_impact(), periods=50),
    "moling": lambda: ns.simulate(models.moling(), periods=50, tangent=True),
    "rotor": lambda: ns.simulate(models.rotor(), periods=20),
    "fatigue_rig": lambda: ns.simulate(models.fatigue_rig(), periods=20),
    "fatigue_rig.toml": lambda: ns.simulate(ns.System.from_toml(RIG), periods=20),
    "relaxing": relaxing,
    "pendulum": lambda: ns.simulate(PENDULUM, {"x": 0.4}, periods=20, tangent=["F", "c"]),
    "functions": lambda: ns.simulate(FUNCTIONS, {"x": 0.4}, periods=20, tangent=[]),
    "parameters": lambda: ns.simulate(
        models.soft_impact(), periods=20, tangent=["omega", "beta", "e"]
    ),
    "orbit": lambda: ns.find_orbit(models.impact_oscillator()),
}


def digits(result):
    """Hash of each variable that holds numbers."""
    arrays = {name: result[name].values for name in result.variables}
    return {
        name: hashlib.sha256(array.tobytes()).hexdigest()
        for name, array in arrays.items()
        if array.dtype.kind in "bifc"
    }


if __name__ == "__main__":
    found = {name: digits(run()) for name, run in RUNS.items()}
    print(json.dumps({"library": str(engine), "digits": found}))
