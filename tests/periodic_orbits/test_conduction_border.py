"""A boost converter whose current just comes to zero as the clock ticks: CCM to DCM and back."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import fsolve

import nonsmooth as ns

VIN, L, C, PEAK, T = 10.0, 200e-6, 100e-6, 1.2, 1e-4


def converter(load: float) -> ns.System:
    clock = ns.Exit("T - tau", to="on", reset={"tau": "0"}, name="clock")
    empty = ns.Exit("i", to="dead", reset={"i": "0"}, name="empty")
    falls = {"u": "-u/(R*C)", "tau": "1"}
    return ns.System(
        states=["i", "u", "tau"],
        parameters={"Vin": VIN, "L": L, "C": C, "R": load, "Iref": PEAK, "T": T},
        period="T",
        modes={
            "on": ns.Mode({"i": "Vin/L", **falls}, exits=[ns.Exit("Iref - i", to="off")]),
            "off": ns.Mode(
                {"i": "(Vin - u)/L", "u": "i/C - u/(R*C)", "tau": "1"}, exits=[clock, empty]
            ),
            "dead": ns.Mode({"i": "0", **falls}, exits=[clock]),
        },
    )


def border() -> float:
    """Load at which a cycle from i = 0 comes back to it just after a period, by exponentials."""
    on = PEAK * L / VIN

    def left(unknown):
        load, start = unknown
        u = start * np.exp(-on / (load * C))
        flow = np.array([[0, -1 / L, VIN / L], [1 / C, -1 / (load * C), 0], [0, 0, 0]])
        i, u, _ = expm(flow * (T - on)) @ [PEAK, u, 1.0]
        return i, u - start

    return float(fsolve(left, [28.0, 13.0], xtol=1e-13)[0])


@pytest.mark.parametrize(("load", "bounds"), [(27.0, (26.0, 32.0)), (31.0, (26.0, 32.0))])
def test_the_border_is_passed_both_ways(load, bounds):
    system = converter(load)
    orbit = ns.find_orbit(system, {"i": 0.3, "u": 13.0}, transient=300)
    branch = ns.continue_orbit(system, "R", bounds, initial=orbit)
    assert [branch.attrs[f"end_{end}"] for end in ("first", "last")] == ["bound", "bound"]
    ends = dict(zip(branch["special_kind"].values, branch["special_value"].values, strict=True))
    # the engine's rounding of i is 1e-13 of its peak, and R moves by 1e2 of that
    assert ends["corner"] == pytest.approx(border(), rel=1e-10)
    words = {"dead" in word.split() for word in branch["word"].values}
    assert words == {False, True}
