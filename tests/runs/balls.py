"""Systems whose maps are known."""

import nonsmooth as ns


def logistic_ball(**values: float) -> ns.System:
    """Ball on fixed ground whose speed w at an impact becomes a w (1 - w): the logistic map."""
    return ns.System(
        name="logistic",
        states=["h", "u"],
        parameters={"a": 3.2} | values,
        initial={"u": 0.3},
        modes={
            "flight": ns.Mode(
                {"h": "u", "u": "-1"},
                exits=[ns.Exit("h", reset={"u": "-a*u*(1 + u)"}, name="impact")],
            )
        },
    )


def bouncing_ball(r: float = 0.8) -> ns.System:
    """Ball on fixed ground that keeps the part r of its speed."""
    return ns.System(
        name="ball",
        states=["h", "u"],
        parameters={"r": r, "g": 1.0},
        modes={
            "flight": ns.Mode(
                {"h": "u", "u": "-g"}, exits=[ns.Exit("h", reset={"u": "-r*u"}, name="impact")]
            )
        },
    )


def damped(zeta: float = 0.1) -> ns.System:
    """Free oscillator without forcing."""
    return ns.System(
        name="damped",
        states=["x", "v"],
        parameters={"zeta": zeta},
        equations={"x": "v", "v": "-2*zeta*v - x"},
    )


def forced(**values: float) -> ns.System:
    """Linear oscillator under cos(omega t)."""
    return ns.System(
        name="forced",
        states=["x", "v"],
        parameters={"omega": 1.3, "zeta": 0.1} | values,
        period="2*pi/omega",
        equations={"x": "v", "v": "cos(omega*t) - 2*zeta*v - x"},
    )


def rigid_wall(**values: float) -> ns.System:
    """Forced oscillator at a rigid wall."""
    return ns.System(
        name="wall",
        states=["x", "v"],
        parameters={"omega": 2.5, "zeta": 0.02, "sigma": 0.0, "r": 0.8} | values,
        period="2*pi/omega",
        modes={
            "free": ns.Mode(
                {"x": "v", "v": "cos(omega*t) - 2*zeta*v - x"},
                exits=[ns.Exit("sigma - x", reset={"v": "-r*v"}, name="impact")],
            )
        },
        initial={"x": -0.5},
    )
