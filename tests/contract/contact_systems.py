"""The systems of `reference.contact_models` once more, as a user writes them.

The two share the parameter values, the start and the times, and nothing else: here no mode at
rest and no motion on a surface is written down.
"""

import json
from pathlib import Path

import nonsmooth as ns

RUNS = json.loads((Path(__file__).parents[1] / "reference" / "contact_runs.json").read_text())
TANGENTS, ACCUMULATIONS = RUNS["tangents"], RUNS["accumulations"]


def belt(parameters):
    hold = "hold" if "hold" in parameters else None
    return ns.System(
        states=["x", "v", "y", "w"],
        parameters=parameters,
        period="2*pi/omega",
        definitions={"between": "k*(x - y)"},
        equations={
            "x": "v",
            "v": "a*cos(omega*t) - x - between - F_k*sign(slip)",
            "y": "w",
            "w": "between - c*w",
        },
        surfaces={"slip": ns.Surface("v - v_b", "lag", "stick", "lead", hold=hold)},
    )


def two_brakes(parameters):
    return ns.System(
        states=["x", "v", "y", "w"],
        parameters=parameters,
        period="2*pi/omega",
        equations={
            "x": "v",
            "v": "a*cos(omega*t) - x - k*(x - y) - F_1*sign(v - v_b)",
            "y": "w",
            "w": "k*(x - y) - c*w - F_2*sign(w)",
        },
    )


def relay(parameters):
    return ns.System(
        states=["x", "y", "z"],
        parameters=parameters,
        equations={
            "x": "y",
            "y": "z - x - c*y",
            "z": "a*sin(t) - 2*sign(z + x + y + b*x**2)",
        },
    )


def wall(parameters):
    impact = ns.Exit("sigma - x", reset={"v": "-r*v"}, sticks="stuck", name="impact")
    flow = {
        "x": "v",
        "v": "F*cos(omega*t) - 2*zeta*v - x - between",
        "y": "w",
        "w": "between - 2*zeta*w",
    }
    # a coefficient of zero would leave a cubic system: linear text for the linear one
    cubic = " + k3*(x - y)**3" if parameters["k3"] else " + 0*k3"
    return ns.System(
        states=["x", "v", "y", "w"],
        parameters=parameters,
        period="2*pi/omega",
        definitions={"between": "k*(x - y)" + cubic},
        modes={"free": ns.Mode(flow, exits=[impact])},
    )


def platform(parameters):
    reset = {
        "v": "v - (1 + r)*M/(1 + M)*(v - w)",
        "w": "w + (1 + r)/(1 + M)*(v - w)",
    }
    flow = {"x": "v", "v": "-g", "y": "w", "w": "(a*cos(omega*t) - K*y - c*w)/M"}
    return ns.System(
        states=["x", "v", "y", "w"],
        parameters=parameters,
        period="2*pi/omega",
        modes={"flight": ns.Mode(flow, exits=[ns.Exit("x - y", reset=reset, sticks="riding")])},
    )


def table(parameters):
    reset = {"v": "-r*v + (1 + r)*A*omega*cos(omega*t)"}
    landing = ns.Exit("x - A*sin(omega*t)", reset=reset, sticks="riding", name="landing")
    return ns.System(
        states=["x", "v"],
        parameters=parameters,
        period="2*pi/omega",
        modes={"flight": ns.Mode({"x": "v", "v": "-g"}, exits=[landing])},
    )


def oscillator(parameters):
    impact = ns.Exit("sigma - x", reset={"v": "-r*v"}, sticks="stuck", name="impact")
    flow = {"x": "v", "v": "F*cos(omega*t) - 2*zeta*v - x"}
    return ns.System(
        states=["x", "v"],
        parameters=parameters,
        period="2*pi/omega",
        modes={"free": ns.Mode(flow, exits=[impact])},
    )


_MAKERS = {
    "belt": belt,
    "two": two_brakes,
    "relay": relay,
    "plastic": wall,
    "wall": wall,
    "wall,": wall,
    "platform": platform,
    "table": table,
    "resting": table,
    "oscillator": oscillator,
    "damped": oscillator,
}


def system_of(name):
    run = {**TANGENTS, **ACCUMULATIONS}[name]
    return _MAKERS[name.split()[0]](run["parameters"])


def start_of(name):
    run = {**TANGENTS, **ACCUMULATIONS}[name]
    return dict(zip(run["states"], run["start"], strict=True))
