"""A mass on a belt by Stribeck's law, its cycle by scipy, and a mass beside a stiff stop."""

from functools import cache

import numpy as np
from scipy.integrate import solve_ivp

import nonsmooth as ns

F_K, F_S, V_S = 0.4, 0.6, 0.1


def stribeck(v_b: float, law: str = "exp(-abs(s)/v_s)") -> ns.System:
    """The rest state v = 0 lies in one cell; the other one begins at the speed of the belt."""
    return ns.System(
        name="stribeck",
        states=["x", "v"],
        parameters={"F_k": F_K, "F_s": F_S, "v_s": V_S, "v_b": v_b},
        surfaces={"s": ns.Surface("v - v_b", below="lag", on="stick", above="lead")},
        equations={"x": "v", "v": f"-x - sign(s)*(F_k + (F_s - F_k)*{law})"},
    )


@cache
def cycle_of_belt(v_b: float) -> float:
    """Time of a slip from where stick ends until the belt is caught again, and of the stick."""

    def slip(_: float, y: np.ndarray) -> list[float]:
        return [y[1], -y[0] + F_K + (F_S - F_K) * np.exp(-(v_b - y[1]) / V_S)]

    def caught(_: float, y: np.ndarray) -> float:
        return v_b - y[1]

    caught.terminal, caught.direction = True, -1
    exact = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}
    # past the start, where the surface is left by the third order of time
    first = solve_ivp(slip, (0.0, 1e-3), [F_S, v_b - 1e-12], **exact)
    rest = solve_ivp(slip, (1e-3, 100.0), first.y[:, -1], events=caught, max_step=0.05, **exact)
    assert rest.status == 1 and rest.y[0, -1] < F_S
    return float(rest.t[-1] + (F_S - rest.y[0, -1]) / v_b)


def stiff_stop(k: float) -> ns.System:
    """A mass that oscillates once in 2 pi, far from a stop whose own oscillations are fast."""
    return ns.System(
        name="stiff_stop",
        states=["x", "v"],
        parameters={"k": k},
        modes={
            "free": ns.Mode({"x": "v", "v": "0.4 - x"}, exits=[ns.Exit("x + 3", to="contact")]),
            "contact": ns.Mode(
                {"x": "v", "v": "0.4 - x - k*(x + 3)"}, exits=[ns.Exit("-3 - x", to="free")]
            ),
        },
    )
