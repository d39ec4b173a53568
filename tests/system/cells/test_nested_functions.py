"""Piecewise functions inside each other: each one doubles the cells, and few of these meet."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.errors import ModelError


def folded(depth):
    """abs(... abs(abs(x - 1/2) - 1/4) ... ), a zigzag of x with 2^depth pieces."""
    text = "x"
    for k in range(depth):
        text = f"abs({text} - {0.5 ** (k + 1)!r})"
    return text


@pytest.mark.parametrize("depth", [2, 4, 6])
def test_a_continuous_zigzag_has_no_cells_to_slide_in(depth):
    """Its sides never point at each other: all cells lie between surfaces, none on one."""
    system = ns.System(states=["x"], equations={"x": f"-{folded(depth)}"})
    assert all(not family.split.sliding for family in system.structure.families.values())
    assert len(system.structure.running) <= 2**depth


def test_the_number_of_pairs_that_are_compared(monkeypatch):
    """Six deep there are sixty cells; far fewer pairs than 60^2 / 2 need more than a look."""
    from nonsmooth.system.cells import sliding

    looked_at, original = [], sliding.vanishes
    monkeypatch.setattr(
        sliding, "vanishes", lambda *given, **more: looked_at.append(1) or original(*given, **more)
    )
    system = ns.System(states=["x"], equations={"x": f"-{folded(6)}"})
    assert len(looked_at) <= 6 * len(system.structure.running)


def test_motion_down_a_zigzag():
    """x' = -||x - 1| - 1/4| from x = 2: towards x = 5/4, where the slope is one, by exp(-t)."""
    system = ns.System(states=["x"], equations={"x": "-abs(abs(x - 1) - 0.25)"})
    run = ns.simulate(system, {"x": 2.0}, t_end=3.0)
    assert np.allclose(run["x"], 1.25 + 0.75 * np.exp(-run["time"]), rtol=1e-14)


def test_motion_through_the_pieces():
    """x' = 1 - ||x| - 1|/2 from x = -2: in pieces, each an exponential.

    Below -1 the rate is (3 + x)/2, so x + 3 = exp(t/2), until t1 = 2 ln 2; then 1/2 - x/2 until 0.
    """
    system = ns.System(states=["x"], equations={"x": "1 - abs(abs(x) - 1)/2"})
    run = ns.simulate(system, {"x": -2.0}, t_end=2.0)
    t1 = 2 * np.log(2.0)
    first = run["time"].values <= t1
    t = run["time"].values
    assert np.allclose(run["x"].values[first], -3 + np.exp(t[first] / 2), rtol=1e-13, atol=1e-14)
    rest = 1 - 2 * np.exp(-(t[~first] - t1) / 2)
    assert np.allclose(run["x"].values[~first], rest, rtol=1e-13, atol=1e-14)


def test_jumps_of_nested_functions_are_still_slid_on():
    """x' = -sign(|x| - 1) slides at x = 1, and x = -1 is left to both sides."""
    system = ns.System(states=["x"], equations={"x": "-sign(abs(x) - 1)"})
    run = ns.simulate(system, {"x": 3.0}, t_end=5.0)
    expected = np.maximum(1.0, 3.0 - run["time"].values)
    assert np.allclose(run["x"], expected, atol=1e-14)


def test_too_deep(monkeypatch):
    monkeypatch.setattr("nonsmooth.system.cells.cells.MOST_MODES", 64)
    with pytest.raises(ModelError, match="more than 64 cells; write some"):
        ns.System(states=["x"], equations={"x": f"-{folded(8)}"})


SATURATED = [
    "abs(where(v < x, x, 0.5*v))",
    "clip(where(v + x > 0, -2*x, -v), -1, 1)",
    "clip(-2*sign(v + x) - x, -1, 1)",
    "-x - abs(sign(v - 0.3)*0.4 + 0.1*x)",
    "-x - 0.1*v + min(1, where(v < x*x, x, 2*x))",
]


@pytest.mark.parametrize("text", SATURATED)
def test_a_jump_within_a_function(text):
    """On its surface the value between the sides lies on no known side of the outer function."""
    system = ns.System(states=["x", "v"], equations={"x": "v", "v": text})
    assert any("0" in name for name in system.mode_names)


def test_a_saturated_switch_slides_and_tells_its_force():
    """Sliding on v + 2 x = 0: x decays as exp(-2 t), and v' = 4 x = -x - v + u gives u = 3 x.

    The equivalent value of the sign, put into clip(-3 sign - x/2), would give 4 x.
    """
    system = ns.System(
        states=["x", "v"],
        equations={"x": "v", "v": "-x - v + u"},
        definitions={"u": "clip(-3*sign(v + 2*x) - 0.5*x, -2, 2)"},
        outputs={"force": "u", "power": "u*u"},
    )
    run = ns.simulate(system, {"x": 0.4, "v": -0.2}, times=[0.0, 0.5, 1.0, 2.0])
    x, late = run["x"].values, slice(1, None)
    assert x[late] == pytest.approx(x[1] * np.exp([0.0, -1.0, -3.0]), rel=1e-12)
    assert run["force"].values[late] == pytest.approx(3.0 * x[late], rel=1e-12)
    # a function of the force that stands in no equation of motion is one of that force
    assert run["power"].values[late] == pytest.approx(9.0 * x[late] ** 2, rel=1e-12)


def test_a_jump_within_the_function_of_a_guard_alone():
    """On the surface the guard is the mean of its sides: 2 - clip(+-3, -1, 1) gives 2 at v = 0."""
    ends = ns.Exit("2 - clip(3*sign(v), -1, 1) - t", to="stop", name="late")
    system = ns.System(states=["v"], modes={"run": ns.Mode({"v": "-sign(v)"}, exits=[ends])})
    run = ns.simulate(system, {"v": 0.5}, t_end=5.0)
    assert run.attrs["status"] == "stopped"
    assert float(run["event_time"][-1]) == pytest.approx(2.0, rel=1e-12)


def test_a_force_on_a_curved_surface():
    """On the circle the force that keeps motion there is the mean of both sides: none of 1 and -1.

    r' = clip(-3 sign(r^2 - 1) + 1/2, -2, 2) r is kept at r = 1 by shares of one half each.
    """
    system = ns.System(
        states=["x", "y"],
        equations={"x": "u*x - y", "y": "u*y + x"},
        definitions={"u": "clip(-3*sign(x**2 + y**2 - 1) + 0.5, -2, 2)"},
        outputs={"force": "u"},
    )
    run = ns.simulate(system, {"x": 1.5, "y": 0.0}, times=[0.0, 2.0, 3.0])
    assert np.hypot(run["x"], run["y"]).values[1:] == pytest.approx([1.0, 1.0], abs=1e-9)
    assert run["force"].values[1:] == pytest.approx([0.0, 0.0], abs=1e-9)


def test_functions_of_a_friction_force_that_holds():
    """Where a mass sticks to a belt, the size of the force is that of the spring."""
    system = ns.System(
        states=["x", "v"],
        parameters={"v_b": 0.3},
        equations={"x": "v", "v": "-x + friction"},
        definitions={"friction": "-0.4*sign(slip)"},
        outputs={"force": "friction", "size": "abs(friction)", "square": "friction**2"},
        surfaces={"slip": ns.Surface("v - v_b", below="lag", on="stick", above="lead", hold="1.5")},
    )
    run = ns.simulate(system, {"x": -0.5, "v": 0.3}, times=np.linspace(0.0, 3.0, 31), mode="stick")
    assert set(run["mode"].values) == {system.mode_names.index("stick")}
    assert run["force"].values == pytest.approx(run["x"].values, abs=1e-12)
    assert run["size"].values == pytest.approx(np.abs(run["x"].values), abs=1e-12)
    assert run["square"].values == pytest.approx(run["x"].values ** 2, abs=1e-12)


def test_a_rate_with_the_square_of_a_jump():
    """x' = -sign(x) + sign(x)**2 - 3/4 slides at x = 0, where its mean is zero and the square 1."""
    system = ns.System(
        states=["x"],
        equations={"x": "-sign(x) + sign(x)**2 - 0.75"},
        outputs={"pull": "-sign(x)", "square": "sign(x)**2"},
    )
    run = ns.simulate(system, {"x": 0.0}, times=[0.0, 1.0])
    assert run["x"].values.tolist() == [0.0, 0.0]
    assert run["square"].values == pytest.approx([1.0, 1.0])
    assert run["pull"].values == pytest.approx([-0.25, -0.25])


@pytest.mark.parametrize(("pull", "rest"), [(1.9, 0.0), (2.1, 0.05)])
def test_two_saturated_switches_hold_as_far_as_their_sides_allow(pull, rest):
    """x = 0 needs u = 0, and so y is held against a pull of 2: beyond it rests at (pull - 2)/2.

    Cells that come no nearer to x = y = 0 than |x| = 4 have no part in that.
    """
    system = ns.System(
        states=["x", "y"],
        parameters={"pull": pull},
        equations={"x": "-x + u", "y": "-2*y + 0.3*u - 2*sign(y) + pull"},
        definitions={"u": "clip(-3*sign(x) - 3*sign(y) - 0.5*x, -2, 2)"},
        outputs={"U": "u"},
    )
    run = ns.simulate(system, {"x": 0.4, "y": 0.3}, times=[0.0, 20.0, 30.0])
    assert run["x"].values[1:] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert run["U"].values[1:] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert run["y"].values[1:] == pytest.approx([rest, rest], abs=1e-12)
