"""Which surfaces get a cell: those to which both sides can point, for some state and parameters."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Mode, System
from nonsmooth.engine.tables import SLIDES

# rate of x, rate of v, and the surfaces on which motion can slide, by hand
CASES = [
    # the sides point at it where |a| < 1
    ("a - sign(x)", "0", ["s1"]),
    # ... where |x| < 0.1, a small part of what x can be
    ("v", "-1000*x - 0.1*sign(v)", ["s1"]),
    ("v", "-0.001*x - 1e-7*sign(v)", ["s1"]),
    # ... and a very small one, as of a dry friction beside a stiff spring
    *(("v", f"-{k}*x - 3*v - 0.3*sign(v)", ["s1"]) for k in ("1e6", "1e8", "1e10")),
    ("v", "-x - v - 5e-8*sign(v)", ["s1"]),
    # only where b < 0
    ("v", "-x - b*sign(v)", ["s1"]),
    # where t is near a multiple of pi
    ("v", "100*sin(t) - sign(v)", ["s1"]),
    ("v", "exp(x) - sign(v)", ["s1"]),
    ("v", "1 - (1 + x**2)*sign(v)", ["s1"]),
    # a curved surface
    ("v", "-x - sign(x**2 + v**2 - 1)*v", ["s1"]),
    # the velocity goes through a displacement without a jump, whatever the force does
    ("v", "-x - a*sign(x - b)", []),
    ("v", "-x - a*max(x - b, 0)", []),
    # both sides go the same way at two speeds: no state and no parameter gives them two signs
    ("where(x > 1, 2, 1)", "0", []),
    ("where(x > 1, 2, 1)*(v + a)", "0", []),
    ("where(x > 1, 2, 1)*(v**2 + a)", "-v", []),
    ("where(x > 1, 2, 1)*exp(v)", "0", []),
    # but here v = -a parts them
    ("v + a + where(x > 1, 2, 1)", "0", ["s1"]),
    # time passes, whatever the states do
    ("x*where(t > 0.3, 1, 2)", "0", []),
    ("sign(sin(t)) - x", "0", []),
    ("v", "-x + sign(cos(t))", []),
    # a surface that moves
    ("v", "-x - sign(v - cos(t))", ["s1"]),
    # the sides agree on it
    ("abs(b*x - a) + abs(a - x*b)", "0", []),
    ("sign(x)*x", "0", []),
]


@pytest.mark.parametrize(("x", "v", "names"), CASES, ids=[f"{x}, {v}" for x, v, _ in CASES])
def test_surfaces_with_cells(x, v, names):
    system = System(states=["x", "v"], parameters={"a": 0.4, "b": 0.7}, equations={"x": x, "v": v})
    found = [dict(cell.sides) for cell in system.structure.running if cell.kind == SLIDES]
    assert [name for sides in found for name, sign in sides.items() if sign == "0"] == names


@pytest.mark.parametrize("k", [1e4, 1e6, 1e8])
def test_dry_friction_holds_beside_a_stiff_spring(k):
    """Two swings, each 0.6/k shorter, end at -0.1/k, where the spring cannot move the block."""
    block = System(
        states=["x", "v"],
        period=4.0 * np.pi / np.sqrt(k),
        equations={"x": "v", "v": f"-{k}*x - 0.3*sign(v)"},
    )
    end = ns.simulate(block, {"x": 1.1 / k}, periods=1).isel(time=-1)
    assert float(end["v"]) == 0.0
    assert float(end["x"]) * k == pytest.approx(-0.1, abs=1e-6)


@pytest.mark.slow
def test_dampers_that_come_and_go_hold_nothing():
    """In contact the ring of the rotor stands where its springs put it, and passes their ends."""
    cells = ns.models.rotor().structure.running
    assert sum(cell.parent == "contact" for cell in cells) > 8
    for cell in cells:
        if cell.parent == "contact":
            assert cell.name.count("0") != 1, cell.name


def test_surfaces_that_attract_together():
    """Two blocks on each other and on the ground: at rest both stick, and neither does alone.

    The upper block is driven by F; 0.3 holds it on the lower one, and 0.2 that one on the ground.
    At rest the lower friction is that of the upper contact, F itself.
    """
    flow = {"v": "F - 0.3*sign(v - w)", "w": "0.3*sign(v - w) - 0.2*sign(w)"}
    outputs = {"upper": "0.3*sign(v - w)", "lower": "0.2*sign(w)"}
    for force, word in ((0.1, "flow[00]"), (0.25, "flow[0+]"), (0.75, "flow[++]")):
        system = System(states=["v", "w"], parameters={"F": force}, equations=flow, outputs=outputs)
        assert set(system.mode_names[4:]) == {"flow[0+]", "flow[0-]", "flow[00]"}
        run = ns.simulate(system, t_end=1.0)
        assert (run.attrs["status"], ns.phase_word(run)) == ("completed", (word,))
        # by hand: at rest; both with (F - 0.2)/2; the upper one with F - 0.3, the lower with 0.1
        rates = {0.1: (0.0, 0.0), 0.25: (0.025, 0.025), 0.75: (0.45, 0.1)}[force]
        ends = [float(run[name][-1]) for name in ("v", "w")]
        assert ends == pytest.approx(rates, abs=1e-15)
        assert float(run["upper"][-1]) == pytest.approx(force - rates[0], abs=1e-15)
        assert float(run["lower"][-1]) == pytest.approx(force - sum(rates), abs=1e-15)


@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_no_friction_is_a_value_of_friction(mu):
    """With mu = 0 the force on the surface is 0/0, in a cell that is never entered."""
    flow = {"x": "v", "v": "-x - mu*sign(v - w)", "y": "w", "w": "-4*y + mu*sign(v - w)"}
    system = System(states=["x", "v", "y", "w"], parameters={"mu": mu}, equations=flow)
    run = ns.simulate(system, {"x": 1.0, "y": 0.1}, t_end=3.0)
    assert run.attrs["status"] == "completed"
    smooth = {"x": "v", "v": "-x", "y": "w", "w": "-4*y"}
    free = ns.simulate(System(states=["x", "v", "y", "w"], equations=smooth),
                       {"x": 1.0, "y": 0.1}, t_end=3.0)  # fmt: skip
    gap = abs(float(run["x"][-1] - free["x"][-1]))
    assert gap < 1e-13 if mu == 0.0 else gap > 1e-2


def test_motion_switched_by_time_runs_as_two_runs():
    """x'' = -x, then -2 x from t = 0.3 on: two oscillations, joined."""
    both = System(states=["x", "v"], equations={"x": "v", "v": "-x*where(t > 0.3, 2, 1)"})
    run = ns.simulate(both, {"x": 1.0}, t_end=1.0)
    parts = [System(states=["x", "v"], equations={"x": "v", "v": f"-{k}*x"}) for k in (1, 2)]
    half = ns.simulate(parts[0], {"x": 1.0}, t_end=0.3)
    middle = {name: float(half[name][-1]) for name in ("x", "v")}
    end = ns.simulate(parts[1], middle, t_end=0.7)
    assert float(run["x"][-1]) == pytest.approx(float(end["x"][-1]), abs=1e-14)


def test_resets_leave_the_surface_on_which_a_body_slides():
    """A block that is carried by its belt into a wall, and back: v = 0.3, then -0.15."""
    flow = {"x": "v", "v": "-x - 0.6*sign(v - 0.3)"}
    way = ns.Exit("0.4 - x", reset={"v": "-0.5*v"}, name="wall")
    system = System(states=["x", "v"], modes={"m": Mode(flow, exits=[way], cells={"0": "stick"})})
    run = ns.simulate(system, {"x": 0.0, "v": 0.3}, t_end=2.0)
    assert float(run["event_time"][1]) == pytest.approx(4 / 3, abs=1e-15)
    assert run["state_before"].values[1].tolist() == pytest.approx([0.4, 0.3], abs=1e-15)
    assert run["state_after"].values[1].tolist() == pytest.approx([0.4, -0.15], abs=1e-15)
    assert ns.phase_word(run) == ("stick", "m[-]")
