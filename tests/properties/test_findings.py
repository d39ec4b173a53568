"""What random systems have brought to light, each as the smallest system that shows it."""

import numpy as np
import pytest

import nonsmooth as ns
from properties.cases import drawn_of, judge


def kinds(run):
    return run["event_kind"].values.tolist()


def last_row(run, name):
    return run[name].values[-1]


# ---------------------------------------------------------------- rest beside other things


@pytest.mark.parametrize("speed", [-0.1, 0.0, 0.2])
def test_friction_beside_a_wall_that_sticks(speed):
    """In the cell where friction holds the speed there is no rest, elsewhere there is."""
    flow = {"x": "v", "v": f"2 - x - 0.3*sign(v - ({speed}))"}
    wall = ns.Exit("1 - x", reset={"v": "-0.5*v"}, sticks="rest")
    system = ns.System(states=["x", "v"], modes={"m": ns.Mode(flow, exits=[wall])})
    run = ns.simulate(system, {"x": 0.0}, t_end=10)
    assert run.attrs["status"] == "completed"
    # the push at the wall is 1 and friction at most 0.3, so the mass comes to rest there
    assert kinds(run)[-1] == "chatter"
    assert run["end_state"].values.tolist() == [1.0, 0.0]


def test_a_reset_takes_motion_off_its_surface():
    """A belt carries a mass against a wall: behind the impact it slips."""
    flow = {"x": "v", "v": "1 - x - 2*sign(v - 0.2)"}
    wall = ns.Exit("1 - x", reset={"v": "-0.5*v"}, name="impact")
    system = ns.System(states=["x", "v"], modes={"m": ns.Mode(flow, exits=[wall])})
    run = ns.simulate(system, {"x": 0.9, "v": 0.2}, t_end=0.52)
    assert run.attrs["status"] == "completed"
    assert run["event_path"].values[1] == "impact>s1"
    assert run["state_after"].values[1] == pytest.approx([1.0, -0.1], abs=1e-15)


def test_two_walls_of_one_mass():
    """They are never at rest together, so no mode says what both reactions are."""
    walls = [
        ns.Exit(guard, reset={"v": "-0.4*v"}, sticks=name)
        for guard, name in (("1 - x", "up"), ("1 + x", "down"))
    ]
    mode = ns.Mode({"x": "v", "v": "2*cos(0.3*t)"}, exits=walls)
    system = ns.System(states=["x", "v"], period="2*pi/0.3", modes={"m": mode})
    assert system.mode_names == ("m", "up", "down")
    run = ns.simulate(system, periods=3)
    assert run.attrs["status"] == "completed"
    assert {"chatter", "release"} <= set(kinds(run))
    assert float(np.abs(run["x"]).max()) <= 1.0 + 1e-12


@pytest.mark.parametrize("text", ["", " + 0.4*cos(v)*x"])
def test_a_factor_of_a_guard_is_no_matter(text):
    """Rest at a moving wall whose distance is written in other units."""

    def run(guard):
        flow = {"x": "v", "v": f"1.7 - 0.3*v - 3*x - 1.8*cos(w*t){text}"}
        reset = {"v": "-r*v + (1 + r)*a*w*cos(w*t)"}
        mode = ns.Mode(flow, exits=[ns.Exit(guard, reset=reset, sticks="rest")])
        parameters = {"w": 1.6, "r": 0.2, "a": 0.1, "k": 1.7}
        system = ns.System(states=["x", "v"], parameters=parameters, modes={"m": mode})
        return ns.simulate(system, {"x": 0.4}, t_end=12)

    plain, scaled = run("0.5 + a*sin(w*t) - x"), run("k*(0.5 + a*sin(w*t) - x)")
    assert {"chatter", "release"} <= set(kinds(plain))
    assert kinds(plain) == kinds(scaled)
    assert np.allclose(plain["event_time"], scaled["event_time"], rtol=0, atol=1e-9)


def test_a_slaved_state_comes_to_rest_too():
    flow = {"x": "v", "v": "1 - 0.3*z"}
    wall = ns.Exit("1 - x", reset={"v": "-0.5*v", "z": "z"}, sticks="rest")
    mode = ns.Mode(flow, slaved={"z": "x - 0.3*v"}, exits=[wall])
    run = ns.simulate(ns.System(states=["x", "v", "z"], modes={"m": mode}), t_end=10)
    assert run.attrs["status"] == "completed"
    assert run["end_state"].values == pytest.approx([1.0, 0.0, 1.0], abs=1e-15)


def test_an_impact_elsewhere_leaves_at_rest_what_is_at_rest():
    walls = [
        ns.Exit("x", reset={"v": "-0.5*v"}, sticks="rest", name="one"),
        ns.Exit("y", reset={"w": "-0.9*w"}, name="other"),
    ]
    flow = {"x": "v", "v": "-1", "y": "w", "w": "-1"}
    system = ns.System(states=list(flow), modes={"m": ns.Mode(flow, exits=walls)})
    run = ns.simulate(system, {"x": 0.01, "y": 1.0}, t_end=6.5)
    others = run["event_name"].values == "other"
    assert others.sum() == 3  # at sqrt 2 (1, 1 + 1.8, 1 + 1.8 + 1.62)
    assert set(run["event_path"].values[others]) == {"other"}
    assert set(run["event_kind"].values[others]) == {"impact"}
    assert float(run["x"][-1]) == 0.0


# ---------------------------------------------------------------- rest of several things


def test_masses_that_meet_keep_their_momentum():
    """Ways onto a surface have resets too, which a curved mode linearises with its exits only."""
    hit = {"v": "v + 0.7*(w - v)", "w": "w - 0.7*(w - v)"}
    flow = {"x": "v", "v": "1 + 0.1*sin(x)", "y": "w", "w": "-1 - 0.1*sin(x)"}
    mode = ns.Mode(flow, exits=[ns.Exit("y - x", reset=hit, sticks="together")])
    system = ns.System(states=list(flow), modes={"m": mode})
    run = ns.simulate(system, {"x": 0, "v": 2, "y": 1, "w": 2}, t_end=8)
    assert kinds(run)[-1] == "chatter"
    before, after = last_row(run, "state_before"), last_row(run, "state_after")
    assert after[1] + after[3] == pytest.approx(before[1] + before[3], rel=1e-12)


def test_rest_at_a_curved_wall_that_moves():
    """The speed at rest is that of the wall; at last the guard was off by 4."""
    reset = {"v": "-0.4*v + 1.4*0.6*cos(2*t)/(1 + 0.3*x**2)"}
    guard = "0.1 + 0.3*sin(2*t) - x - 0.1*x**3"
    mode = ns.Mode({"x": "v", "v": "1.7"}, exits=[ns.Exit(guard, reset=reset, sticks="rest")])
    run = ns.simulate(ns.System(states=["x", "v"], modes={"m": mode}), {"x": -0.8}, t_end=4)
    x, t = run["x"].values, run["time"].values
    assert kinds(run)[-1] == "chatter"
    resting = t > last_row(run, "event_time")
    distance = 0.1 + 0.3 * np.sin(2 * t) - x - 0.1 * x**3
    assert np.abs(distance[resting]).max() < 1e-9


def test_a_rate_that_only_rounding_makes_is_no_growth():
    """The linear part has rank 1: its eigenvalue 1e-17 is nothing, and no window of 2e18."""
    rate = "-y - 0.4*z"
    system = ns.System(states=["y", "z"], equations={"y": rate, "z": f"0.6*({rate}) + z*z"})
    run = ns.simulate(system, {"y": 0.3, "z": 0.2}, t_end=1)
    assert run.attrs["status"] == "completed"


@pytest.mark.parametrize("hold", [1.0, 1.5])
@pytest.mark.parametrize("text", ["", " + 0*sin(x)**2"])
@pytest.mark.parametrize("reset", ["-0.3", "v - 0.8"])
def test_a_reset_that_jumps_over_a_surface_that_holds(reset, text, hold):
    """Motion that jumps from 0.5 to -0.3 never was on the surface at 0."""
    flow = {"x": "v", "v": f"1 - x - 0.4*sign(slip){text}"}
    mode = ns.Mode(flow, exits=[ns.Exit("0.5 - v", reset={"v": reset}, name="kick")])
    surfaces = {"slip": ns.Surface("v", hold=hold)}
    system = ns.System(states=["x", "v"], surfaces=surfaces, modes={"m": mode})
    run = ns.simulate(system, {"v": 0.1}, t_end=1.0)
    assert kinds(run) == ["start", "impact"]
    assert last_row(run, "state_after")[1] == pytest.approx(-0.3, abs=1e-14)
    # beyond it friction turns round: x about 1.4 with frequency 1
    t = run["time"].values[-1] - last_row(run, "event_time")
    x = 1.4 + (last_row(run, "state_after")[0] - 1.4) * np.cos(t) - 0.3 * np.sin(t)
    assert run["end_state"].values[0] == pytest.approx(x, abs=1e-12)


@pytest.mark.parametrize(("push", "end"), [(0.3, 0.2), (0.7, 0.2 + 0.3 * 0.4)])
def test_a_reset_onto_a_surface_that_holds(push, end):
    """What a reset puts on the surface is held there by up to 0.6, or goes on against 0.4."""
    flow = {"v": f"{push} - 0.4*sign(slip)", "y": "-1"}
    mode = ns.Mode(flow, exits=[ns.Exit("y", reset={"v": "0.2", "y": "9"}, name="brake")])
    surfaces = {"slip": ns.Surface("v - 0.2", hold=1.5)}
    system = ns.System(states=["v", "y"], surfaces=surfaces, modes={"m": mode})
    run = ns.simulate(system, {"v": 1.0, "y": 0.1}, t_end=0.5)
    assert run["end_state"].values[0] == pytest.approx(end, abs=1e-14)


def test_a_surface_whose_gradient_vanishes_at_rest():
    """The window is that of the oscillation, 32 radians of 2 a second, not that of rounding."""
    flow = {"x": "v", "v": "-4*x + 0.1*sign(v - sin(v + 0.3*y))", "y": "-y"}
    system = ns.System(states=["x", "v", "y"], equations=flow)
    run = ns.simulate(system, {"x": -0.6, "v": 0.8, "y": 0.5}, t_end=1)
    assert run.attrs["status"] == "completed"
    assert run.attrs["window"] == 16.0


def test_a_chirp_ends_by_its_steps():
    """The sine of an x that grows to 5e16 has as many turns; until x = pi it has half a one."""
    system = ns.System(states=["x", "y"], equations={"x": "x", "y": "sin(x)"})
    with pytest.warns(ns.RunWarning, match="hardly advances"):
        run = ns.simulate(system, {"x": 1e8}, t_end=20)
    assert run.attrs["status"] == "step_limit"
    x = run["end_state"].values[0]
    assert x == pytest.approx(1e8 * np.exp(run.attrs["end_phase"]), rel=1e-9)
    assert ns.simulate(system, {"x": 1.0}, t_end=np.log(np.pi)).attrs["status"] == "completed"


def test_when_rebounds_with_friction_are_over():
    """Flights fall with another acceleration than they rise with.

    Up at 1.3 and down at 0.7: a flight that leaves with u takes u (1/1.3 + 1/sqrt(0.91)), and the
    next one leaves with q u, q = sqrt(0.7/1.3)/2. To 1e-9, of 4: 17 rebounds add up their rounding.
    """
    bounce = ns.Exit("x", reset={"v": "-0.5*v"}, sticks="rest")
    mode = ns.Mode({"x": "v", "v": "-1 - 0.3*sign(v)"}, exits=[bounce])
    run = ns.simulate(ns.System(states=["x", "v"], modes={"m": mode}), {"x": 1.0}, t_end=8)
    fall, first = np.sqrt(2 / 0.7), np.sqrt(1.4) / 2
    flights = first * (1 / 1.3 + 1 / np.sqrt(0.91)) / (1 - np.sqrt(0.7 / 1.3) / 2)
    assert kinds(run)[-1] == "chatter"
    assert last_row(run, "event_time") == pytest.approx(fall + flights, rel=0, abs=1e-9)


@pytest.mark.parametrize("more", ["", " + 0*sin(y)**2"], ids=["linear", "taylor"])
@pytest.mark.parametrize("start", [-0.5, 0.5])
@pytest.mark.parametrize(
    ("text", "last"),
    [
        ("where(y > 0 or x > 1, -1, 1)", -2.0),
        ("where(x > 1 or y > 0, -1, 1)", -2.0),
        ("where(not (y > 0 or x > 1), 1, -1)", -2.0),
        ("where(y < 0 and x < 1, 1, -1)", -2.0),
        ("where(y > 0 and x < 1, -1, 1)", 2.0),
    ],
)
def test_sliding_where_a_second_condition_does_not_matter_on_one_side(text, last, start, more):
    """On y = 0 from t = 0.5 to x = t = 1, where both sides turn one way, to t = 3.

    The cell where x does not matter hands over to one in which x has the wrong sign. That was taken
    for a meeting of the surfaces y = 0 and x = 1, which lie half a unit apart.
    """
    system = ns.System(states=["x", "y"], equations={"x": "1", "y": text + more})
    run = ns.simulate(system, {"y": start}, t_end=3.0)
    assert run.attrs["status"] == "completed" and run.attrs["certified"] == 1
    assert run["event_time"].values.tolist() == [0.0, 0.5, 1.0]
    assert kinds(run) == ["start", "slide_entry", "slide_exit"]
    assert run["end_state"].values == pytest.approx([3.0, last], abs=1e-14)


# ---------------------------------------------------------------- modes that hand over


@pytest.mark.parametrize("text", ["y - 2", "2 - y", "y + 2", "-2 - y"])
def test_modes_in_a_circle_beside_a_surface(text):
    """Two modes that push at each other are no motion along a surface that lies elsewhere."""
    up = ns.Mode({"y": f"1 + 0.2*sign({text})"}, exits=[ns.Exit("0.1 - y", to="down", name="e0")])
    down = ns.Mode({"y": "-1"}, exits=[ns.Exit("y - 0.1", to="up", name="e1")])
    system = ns.System(states=["y"], modes={"up": up, "down": down})
    with pytest.warns(ns.RunWarning, match="hand over in a circle"):
        run = ns.simulate(system, {"y": 0.0}, t_end=1)
    assert run.attrs["status"] == "undecided"
    speed = 1.2 if text in ("2 - y", "y + 2") else 0.8
    assert last_row(run, "event_time") == pytest.approx(0.1 / speed, rel=1e-15)


def test_a_mode_puts_the_mass_behind_a_wall():
    """No rebound leads back from there, and nothing rests on a wall at which it is not."""
    free = ns.Mode({"x": "v", "v": "0"}, exits=[ns.Exit("2 - x", to="walled", name="into")])
    wall = ns.Exit("1 - x", reset={"v": "-0.5*v"}, sticks="rest", name="wall")
    walled = ns.Mode({"x": "v", "v": "1"}, exits=[wall])
    system = ns.System(states=["x", "v"], modes={"free": free, "walled": walled})
    with pytest.warns(ns.RunWarning, match="behind the surface"):
        run = ns.simulate(system, {"x": 0.0, "v": 1.0}, t_end=5, mode="free")
    assert run.attrs["status"] == "event_limit"
    assert last_row(run, "event_time") == 2.0
    assert last_row(run, "event_path").startswith("into>wall>wall")


@pytest.mark.slow
def test_cells_that_never_meet_make_no_motion_where_surfaces_do():
    """Where v0 = -0.181 the mode has no cell with v0 > 0.369: such a corner belongs to no meeting.

    Three cells had one name, and exits led to modes that did not exist.
    """
    system = drawn_of(2195).system()
    exits = system.compiled.program.wiring.exits
    named = {mode.name for mode in system.structure.running}
    assert len(named) == len(system.mode_names) > exits["target"].max()
    assert not judge(2195).complaints


def test_sliding_where_a_high_power_of_one_state_is_zero():
    """A speed that is held at c = -0.1**(10/19), until the force on both sides turns one way.

    The rate of the speed, which is zero, was left with rounding that coupled it to the place, and
    what is nearly defective has half its digits: the end was off by 2e-9.
    """
    force = "-1.769*x - 0.352*v + 0.538*cos(2.58*t) - 0.954*heaviside(1e6*(v**19 + 1e-10))"
    system = ns.System(states=["x", "v"], equations={"x": "v", "v": force})
    run = ns.simulate(system, {"x": -0.883, "v": -0.377}, t_end=6.0)
    assert kinds(run)[2:] == ["slide_entry", "slide_exit"]
    begin, end = run["event_time"].values[2:]
    x, c = run["state_after"].values[2, 0], -(0.1 ** (10 / 19))
    assert run["state_before"].values[3] == pytest.approx([x + c * (end - begin), c], abs=1e-15)
    push = -1.769 * (x + c * (end - begin)) - 0.352 * c + 0.538 * np.cos(2.58 * end) - 0.954
    assert push == pytest.approx(0.0, abs=1e-14)
