"""The systems of `reference.nonlinear_models` once more, as a user writes them.

The two share the parameter values, the start and the times, and nothing else.
"""

import json
from pathlib import Path

import nonsmooth as ns

RUNS = json.loads((Path(__file__).parents[1] / "reference" / "tangent_runs.json").read_text())


def bilinear(parameters):
    flow = {"x": "v", "v": "a*omega**2*sin(omega*t) - 2*zeta*v - x - push"}
    return ns.System(
        states=["x", "v"],
        parameters=parameters,
        definitions={"push": "0"},
        modes={
            "free": ns.Mode(flow, exits=[ns.Exit("e - x", to="contact")]),
            "contact": ns.Mode(
                flow, definitions={"push": "beta*(x - e)"}, exits=[ns.Exit("x - e", to="free")]
            ),
        },
    )


def rigid_impact(parameters):
    impact = ns.Exit("sigma - x", reset={"v": "-r*v"}, name="impact")
    return ns.System(
        states=["x", "v"],
        period="2*pi/omega",
        parameters=parameters,
        modes={
            "free": ns.Mode({"x": "v", "v": "F*cos(omega*t) - 2*zeta*v - x"}, exits=[impact]),
        },
    )


def vibrating_table(parameters):
    impact = ns.Exit("x - A*sin(omega*t)", reset={"v": "table - r*(v - table)"}, name="impact")
    return ns.System(
        states=["x", "v"],
        period="2*pi/omega",
        parameters=parameters,
        definitions={"table": "A*omega*cos(omega*t)"},
        modes={"flight": ns.Mode({"x": "v", "v": "-g"}, exits=[impact])},
    )


def mole(parameters):
    return ns.models.moling(**parameters)


def rotor(parameters):
    return ns.System(
        states=["x", "y", "u", "w"],
        period="2*pi/omega",
        parameters=parameters,
        definitions={
            "load": "rho*omega**2",
            "R": "sqrt(x**2 + y**2)",
            "k": "0",
        },
        modes={
            "free": ns.Mode(_whirl, exits=[ns.Exit("1 - x**2 - y**2", to="rub")]),
            "rub": ns.Mode(
                _whirl,
                definitions={"k": "kappa*(1 - 1/R)"},
                exits=[ns.Exit("x**2 + y**2 - 1", to="free")],
            ),
        },
    )


_whirl = {
    "x": "u",
    "y": "w",
    "u": "load*cos(omega*t) - 2*zeta*u - x - k*x",
    "w": "load*sin(omega*t) - 2*zeta*w - y - k*y",
}


def curved_mole(parameters):
    return ns.System(
        states=["p", "y", "q"],
        period="2*pi/omega",
        parameters=parameters,
        definitions={
            "f": "b + a*cos(omega*t)",
            "spring": "q + k*q**3",
            "F": "2*xi*y + spring",
            "lever": "1 + 2*h*q",
            "head": "q + g + h*q**2",
        },
        modes={
            "flight": ns.Mode(
                {"p": "y", "y": "f", "q": "-spring/(2*xi*lever)"},
                exits=[ns.Exit("head - p", to="contact")],
            ),
            "contact": ns.Mode(
                {"y": "f - F", "q": "y/lever"},
                slaved={"p": "head"},
                exits=[ns.Exit("F", to="flight")],
            ),
        },
    )


def pendulum(parameters):
    """e0 enters twice, the second time through a definition of parameters only."""
    return ns.System(
        states=["theta", "w"],
        period="2*pi/nu",
        parameters=parameters,
        definitions={
            "k": "e1*e0",
            "wall": "D*nu*cos(nu*t)",
            "speed": "L*cos(theta)*w - wall",
        },
        modes={
            "swing": ns.Mode(
                {"theta": "w", "w": "-sin(theta) - c*w + M*cos(nu*t)"},
                exits=[
                    ns.Exit(
                        "d + D*sin(nu*t) - L*sin(theta)",
                        reset={"w": "(wall - e0*speed/(1 + k*speed))/(L*cos(theta))"},
                        name="impact",
                    )
                ],
            )
        },
    )


def ramp(parameters):
    impact = ns.Exit("s + u*t - x", reset={"v": "u - h*(v - u)*exp(-x**2)"}, name="impact")
    flow = {"x": "v", "v": "x - x**3 - c*v + F*cos(nu*t + k*t**2/2)"}
    return ns.System(
        states=["x", "v"], parameters=parameters, modes={"well": ns.Mode(flow, exits=[impact])}
    )


SYSTEMS = {
    "bilinear": bilinear,
    "rigid impact": rigid_impact,
    "vibrating table": vibrating_table,
    "mole": mole,
    "rotor": rotor,
    "pendulum": pendulum,
    "curved mole": curved_mole,
    "ramp": ramp,
}
LINEAR = ["bilinear", "rigid impact", "vibrating table", "mole"]


def system_of(name):
    """The system of a stored run, with the parameters of that run."""
    return SYSTEMS[name](RUNS[name]["parameters"])


def start_of(name):
    return dict(zip(RUNS[name]["states"], RUNS[name]["start"], strict=True))
