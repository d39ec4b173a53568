"""Systems for tests of exponents."""

import numpy as np

import nonsmooth as ns


def rigid_wall(**values: float) -> ns.System:
    """Oscillator at a rigid wall; chaotic at omega = 3.2, sigma = 0."""
    parameters = {"F": 1.0, "omega": 3.2, "zeta": 0.02, "sigma": 0.0, "r": 0.8} | values
    return ns.System(
        name="wall",
        states=["x", "v"],
        parameters=parameters,
        period="2*pi/omega",
        modes={
            "free": ns.Mode(
                {"x": "v", "v": "F*cos(omega*t) - 2*zeta*v - x"},
                exits=[ns.Exit("sigma - x", reset={"v": "-r*v"}, name="impact")],
            )
        },
        initial={"x": -1.0},
    )


def damped(zeta: float) -> ns.System:
    """Free linear oscillator; the period is that of the damped motion."""
    return ns.System(
        name="damped",
        states=["x", "v"],
        parameters={"zeta": zeta, "F": 1.0},
        period="2*pi/sqrt(1 - zeta**2)",
        equations={"x": "v", "v": "F*cos(sqrt(1 - zeta**2)*t) - 2*zeta*v - x"},
    )


def stick_and_slip() -> ns.System:
    """Block on a belt, driven; while it sticks, its velocity is that of the belt."""
    return ns.System(
        name="stick",
        states=["x", "v"],
        parameters={"u": 0.3, "k": 0.4, "s": 0.6},
        modes={
            "slip": ns.Mode({"x": "v", "v": "k - x"}, exits=[ns.Exit("u - v", to="stick")]),
            "stick": ns.Mode({"x": "u", "v": "0"}, exits=[ns.Exit("s - x", to="slip")]),
        },
    )


def beside_duffing(rate: float) -> ns.System:
    """Duffing's oscillator drives a state that relaxes at some rate; a Taylor mode."""
    return ns.System(
        name="stiff",
        states=["w", "x", "v"],
        parameters={"k": rate, "omega": 1.2},
        period="2*pi/omega",
        equations={"w": "-k*w + x", "x": "v", "v": "0.5*cos(omega*t) - 0.3*v + x - x**3"},
    )


def beside_soft_impact(rate: float) -> ns.System:
    """The same beside the soft impact oscillator; modes in closed form."""
    pull = "0.7*omega**2*sin(omega*t) - 0.02*v - x"
    return ns.System(
        name="stiff",
        states=["w", "x", "v"],
        parameters={"k": rate, "omega": 0.905},
        period="2*pi/omega",
        definitions={"e": "1.26"},
        modes={
            "free": ns.Mode(
                {"w": "-k*w + x", "x": "v", "v": pull}, exits=[ns.Exit("e - x", to="contact")]
            ),
            "contact": ns.Mode(
                {"w": "-k*w + x", "x": "v", "v": f"{pull} - 29*(x - e)"},
                exits=[ns.Exit("x - e", to="free")],
            ),
        },
    )


def kicked() -> ns.System:
    """Rolls towards a wall that throws it back at a speed of its own: its velocity is lost."""
    return ns.System(
        name="kicked",
        states=["x", "v"],
        parameters={"omega": 1.0},
        period="2*pi/omega",
        modes={
            "free": ns.Mode(
                {"x": "v", "v": "1 + 0.2*cos(omega*t)"},
                exits=[ns.Exit("-x", reset={"v": "-1"}, name="impact")],
            )
        },
        initial={"x": -1.0},
    )


def mole_determinant_rate(mole: ns.System, run) -> float:
    """Rate of the logarithm of the volume of the mole's two surviving directions, by hand.

    From one release to the next contact the flight lasts tau and the spring relaxes by
    E = exp(-tau/2 xi); with the saltation at contact the area in (y, q) changes by the factor
    1 - 2 xi tau E. Contact contracts it by exp(-2 xi t), progression by exp(-t/2 xi).
    """
    xi = mole.parameter_values["xi"]
    names = run["event_to"].attrs["flag_meanings"].split()
    period = run.attrs["period"]
    times = run["event_time"].values
    entered = [names[k] for k in run["event_to"].values]
    total, end = 0.0, float(run["time"][-1])
    # one period of the steady motion, from contact to contact
    starts = [
        k
        for k in range(1, len(times))
        if entered[k] == "contact" and entered[k - 1] == "no_contact"
    ]
    first, last = starts[-2], starts[-1]
    assert abs(times[last] - times[first] - period) < 1e-9 * period and times[last] <= end
    for k in range(first, last):
        duration = times[k + 1] - times[k]
        if entered[k] == "no_contact":
            total += np.log(1 - 2 * xi * duration * np.exp(-duration / (2 * xi)))
        elif entered[k] == "contact":
            total -= 2 * xi * duration
        else:
            total -= duration / (2 * xi)
    return total / period
