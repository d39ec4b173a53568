"""Systems with several attractors whose basins are known in closed form."""

from __future__ import annotations

import nonsmooth as ns

__all__ = ["forced_wells", "narrow_well", "runaway"]


def forced_wells() -> ns.System:
    """Two wells, told apart by the sign of x + y, both shaken: s = x + y and d = x - y.

    s' = -s + sgn(s) goes to one of +-1, d' = -2 d + cos t to (2 cos t + sin t)/5.
    """
    return ns.System(
        name="wells",
        states=["x", "y"],
        period="2*pi",
        definitions={"s": "x + y", "d": "x - y"},
        equations={
            "x": "(-s + sign(s) - 2*d + cos(t))/2",
            "y": "(-s + sign(s) + 2*d - cos(t))/2",
        },
    )


def narrow_well(width: float) -> ns.System:
    """x goes to 0 from below 0.4 and to 1 from above, but within ``width`` of 0.4 to 0.4 itself."""
    return ns.System(
        name="narrow",
        states=["x", "y"],
        period=1.0,
        parameters={"w": width},
        equations={"x": "where(abs(x - 0.4) < w, 0.4 - x, where(x < 0.4, -x, 1 - x))", "y": "-y"},
    )


def runaway() -> ns.System:
    """x fades where it is less than 1 in size and grows beyond all bounds where it is more."""
    return ns.System(
        name="runaway",
        states=["x", "y"],
        period=1.0,
        equations={"x": "where(abs(x) < 1, -x, 2*x)", "y": "-y"},
    )
