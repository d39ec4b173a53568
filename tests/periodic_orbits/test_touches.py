"""Touches just at the strobe, at two places of one leg, and where nothing is lost.

Without damping x = F cos(w t)/(1 - w**2): it touches a wall at 1 at F = 1 - w**2, with phase 0.
"""

import numpy as np
import pytest

import nonsmooth as ns

W = 0.7
TOUCH = 1.0 - W**2


def oscillator(kind: str) -> ns.System:
    """x'' + x = F cos(w t) with one wall or two, or soft ones."""
    words = {"states": ["x", "v"], "parameters": {"F": 0.4}, "period": f"2*pi/{W}"}
    rate = f"F*cos({W}*t) - x"
    if kind.startswith("soft"):
        inside = "min(x, 1)" if kind == "soft" else "clip(x, -1, 1)"
        return ns.System(equations={"x": "v", "v": f"{rate} - 5*(x - {inside})"}, **words)
    exits = [ns.Exit("1 - x", reset={"v": "-0.8*v"}, name="right")]
    if kind == "walls":
        exits.append(ns.Exit("1 + x", reset={"v": "-0.8*v"}, name="left"))
    return ns.System(modes={"free": ns.Mode({"x": "v", "v": rate}, exits=exits)}, **words)


def branch(kind: str, phase: float):
    start = {"x": 0.4 / TOUCH, "v": 0.0}
    begin = ns.find_orbit(oscillator(kind), start, transient=0, phase=phase)
    return ns.continue_orbit(
        oscillator(kind), "F", (0.3, 0.7), initial=begin, direction="up", phase=phase
    )


@pytest.mark.few(2)
@pytest.mark.parametrize("phase", [0.0, 0.1, 0.5])
@pytest.mark.parametrize("kind", ["wall", "walls", "soft", "soft walls"])
def test_special_points_do_not_depend_on_where_the_touch_is(kind, phase):
    found = branch(kind, phase)
    assert found["special_kind"].values[0] == "grazing"
    assert found["special_value"].values[0] == pytest.approx(TOUCH, abs=1e-12)
    assert found.attrs["end_last"] == "bound"
    assert "torus" not in found["special_kind"].values  # where pairs have the product one
    usual = branch(kind, 0.3)
    assert found["special_kind"].values.tolist() == usual["special_kind"].values.tolist()
    np.testing.assert_allclose(found["special_value"], usual["special_value"], atol=1e-9)
