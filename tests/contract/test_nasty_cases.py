"""The cases that break solvers of piecewise-smooth systems, one named test each.

Each answer is derived in its test. Cases that have tests of their own elsewhere, for motion without
rest and slides, are these: narrow slabs in `test_corners.test_a_narrow_slab_is_not_jumped_over` and
`test_a_slab_of_cells`; two walls 1e-12 apart, without loss, in
`test_corners.test_two_walls_that_nearly_touch`; elastic three-ball impacts in
`test_corners.test_three_balls_meet_at_one_instant`; a start on a guard with zeros up to the fifth
order in `test_starts_on_guards.test_the_order_of_the_zero`; near tangencies of a cosine in
`test_complaints.test_1_no_double_root_is_missed_scipy_9228`.
"""

import warnings

import numpy as np
import pytest
from mpmath import mp, mpf

import nonsmooth as ns
from contract.taylor_twin import taylor_twin
from nonsmooth import Exit, Mode, ModelError, OptionError, RunWarning, Surface, System
from runs.flows import EPS, crossings, on_both_flows


def ends_early(system, start, **words):
    """A run that does not reach its end, with the warning that says so taken."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RunWarning)
        return ns.simulate(system, start, **words)


# ---------------------------------------------------------------- balls

FLOOR = Exit("x", reset={"v": "-r*v"}, sticks="rest", name="floor")


def ball(r):
    mode = Mode({"x": "v", "v": "-1"}, exits=[FLOOR])
    return System(states=["x", "v"], parameters={"r": r}, modes={"flight": mode})


@on_both_flows
@pytest.mark.parametrize("r", [0.05, 0.3, 0.5, 0.7, 0.8, 0.9])
def test_ball_to_rest(flow, r):
    """From h = 1 under g = 1 it lands after sqrt 2; flights of 2 r^k sqrt 2 follow, to infinity."""
    run = ns.simulate(flow(ball(r)), {"x": 1.0}, times=[60.0])
    with mp.workdps(30):
        end = mp.sqrt(2) * (1 + 2 * mpf(r) / (1 - mpf(r)))
    last = crossings(run).isel(event=-1)
    assert (str(last["event_kind"].values), run.attrs["status"]) == ("chatter", "completed")
    assert abs(float(last["event_time"]) / float(end) - 1) < 1e-12
    assert run["end_state"].values.tolist() == [0.0, 0.0]
    assert ns.phase_word(run)[-1] == "rest"
    assert run.attrs["n_uncertain"] == 0
    # no sample is below the floor, at any time
    long = ns.simulate(flow(ball(r)), {"x": 1.0}, t_end=60.0)
    assert float(long["x"].min()) == 0.0


@pytest.mark.parametrize("r", [0.95, 0.99])
def test_ball_to_rest_with_little_loss(r):
    """Hundreds and thousands of rebounds; their roundings add up to sqrt(n) eps at most n eps."""
    with mp.workdps(30):
        end = float(mp.sqrt(2) * (1 + 2 * mpf(r) / (1 - mpf(r))))
    run = ns.simulate(ball(r), {"x": 1.0}, times=[2 * end])
    last = crossings(run).isel(event=-1)
    assert str(last["event_kind"].values) == "chatter"
    assert abs(float(last["event_time"]) / end - 1) < 1e-12
    assert run["end_state"].values.tolist() == [0.0, 0.0]


def two_balls():
    """Two balls that know nothing of each other."""
    exits = [
        Exit("x", reset={"v": "-r*v"}, sticks="one", name="first"),
        Exit("y", reset={"w": "-r*w"}, sticks="two", name="second"),
    ]
    mode = Mode({"x": "v", "v": "-1", "y": "w", "w": "-1"}, exits=exits)
    return System(states=["x", "v", "y", "w"], parameters={"r": 0.5}, modes={"flight": mode})


@on_both_flows
@pytest.mark.parametrize("height", [1.0, 0.5, 0.3, 1.7])
def test_two_identical_balls_dropped_together(flow, height):
    """Both bounce at the same times, and both come to rest at sqrt(2 h) (1 + 2 r/(1 - r))."""
    start = {"x": height, "y": height}
    run = ns.simulate(flow(two_balls()), start, times=[0.5, 2.9, 60.0])
    assert (run.attrs["status"], run.attrs["n_uncertain"]) == ("completed", 0)
    log = crossings(run)
    fall = np.sqrt(2 * height)
    for name in ("first", "second"):
        passed = np.array([name in path.split(">") for path in log["event_path"].values])
        times = log["event_time"].values[passed][:8]
        expected = fall * (1 + 2 * (1 - 0.5 ** np.arange(8)))
        assert np.allclose(times, expected, rtol=0, atol=200 * EPS * expected[-1])
    assert float(log["event_time"][-1]) == pytest.approx(3 * fall, rel=1e-12)
    assert ns.phase_word(run)[-1] == "one+two"
    assert run["end_state"].values.tolist() == [0.0] * 4
    assert run["x"].values.tolist() == run["y"].values.tolist()


@pytest.mark.parametrize("height", [1.0, 0.3])
def test_two_identical_balls_land_in_one_row(height):
    run = ns.simulate(two_balls(), {"x": height, "y": height}, times=[1.6 * np.sqrt(2 * height)])
    assert crossings(run)["event_kind"].values.tolist() == ["corner"]


def test_two_balls_from_other_heights_come_to_rest_apart():
    """Each at its own time: sqrt(2 h) (1 + 2 r/(1 - r)) = 3 sqrt(2 h) for r = 1/2."""
    run = ns.simulate(two_balls(), {"x": 1.0, "y": 0.31}, times=[60.0])
    log = crossings(run)
    ends = log["event_time"].values[log["event_kind"].values == "chatter"]
    assert np.allclose(ends, [3 * np.sqrt(0.62), 3 * np.sqrt(2.0)], rtol=1e-12, atol=0)
    assert run["end_state"].values.tolist() == [0.0] * 4


# ---------------------------------------------------------------- tangencies


def parabola():
    mode = Mode({"y": "w", "w": "2"}, exits=[Exit("y", reset={"w": "-w"}, name="hit")])
    return System(states=["y", "w"], modes={"m": mode})


@on_both_flows
@pytest.mark.parametrize("eps", [1e-8, 1e-9, 1e-10, 1e-11, 1e-12])
def test_grazing_parabola_that_hits(flow, eps):
    """y = (1 - t)^2 - eps is zero at 1 - sqrt(eps), with the rate -2 sqrt(eps).

    Heights have errors of some eps of a double, times of that over the rate.
    """
    run = ns.simulate(flow(parabola()), {"y": 1 - eps, "w": -2.0}, times=[2.0])
    depth = float(1 - mpf(1 - eps))  # as rounded
    log = crossings(run)
    assert log["event_name"].values.tolist() == ["hit"]
    assert bool(log["certified"].all())
    error = abs(float(log["event_time"][0]) - (1 - np.sqrt(depth)))
    assert error < 4 * EPS / np.sqrt(depth)
    # up again at 2 sqrt(eps) from there: y(2) = u^2 + 2 u s with u = 1 + sqrt(eps)
    late = 1 + np.sqrt(depth)
    expected = late**2 + 2 * np.sqrt(depth) * late
    assert float(run["y"][-1]) == pytest.approx(expected, abs=20 * EPS / np.sqrt(depth))


@on_both_flows
@pytest.mark.parametrize("eps", [1e-13, 1e-14])
def test_grazing_parabola_within_rounding(flow, eps):
    """Either answer is right, if flagged: a hit of depth d leads to (1 + sqrt d)(1 + 3 sqrt d).

    Flagged is what rounding may hide, at most 1e-12 of the terms of the guard, which add up to 4.
    """
    run = ns.simulate(flow(parabola()), {"y": 1 - eps, "w": -2.0}, times=[2.0])
    assert (run.attrs["status"], run.attrs["n_uncertain"]) == ("completed", 1)
    depth = np.sqrt(eps + 4e-12)
    assert 1 - eps - 4 * EPS <= float(run["y"][-1]) <= (1 + depth) * (1 + 3 * depth)


@on_both_flows
def test_grazing_parabola_that_touches(flow):
    """Zero and no less: no impact, and y(2) = 1, w(2) = 2. The log says that it was near."""
    run = ns.simulate(flow(parabola()), {"y": 1.0, "w": -2.0}, times=[2.0])
    assert ns.phase_word(run) == ("m",)
    assert crossings(run)["event_kind"].values.tolist() == ["graze"]
    assert np.allclose(run["end_state"], [1.0, 2.0], rtol=0, atol=4 * EPS)


@on_both_flows
def test_grazing_parabola_that_misses(flow):
    run = ns.simulate(flow(parabola()), {"y": 1 + 1e-12, "w": -2.0}, times=[2.0])
    assert (run.attrs["n_events"], run.attrs["n_uncertain"]) == (0, 0)
    assert float(run["y"][-1]) == pytest.approx(1 + 1e-12, abs=4 * EPS)


@on_both_flows
def test_cubic_tangency_is_a_crossing(flow):
    """y = (1 - t)^3 goes through zero, flagged. What rounding may hide moves the place by its root.

    That is at most 1e-12 of the terms of the guard, 8 in all; y is moved by no more.
    """
    rates = {"y": "w", "w": "a", "a": "-6"}
    modes = {
        "above": Mode(rates, exits=[Exit("y", to="below", name="through")]),
        "below": Mode(rates, exits=[Exit("-y", to="above", name="back")]),
    }
    start = {"y": 1.0, "w": -3.0, "a": 6.0}
    run = ns.simulate(flow(System(states=["y", "w", "a"], modes=modes)), start, times=[2.0])
    log = crossings(run)
    passed = log["event_kind"].values == "switch"
    assert ns.phase_word(run) == ("above", "below")
    assert run.attrs["n_uncertain"] > 0
    assert log["event_name"].values[passed].tolist() == ["through"]
    assert float(log["event_time"][passed][0]) == pytest.approx(1.0, abs=8e-12 ** (1 / 3))
    assert np.allclose(run["end_state"], [-1.0, -3.0, -6.0], rtol=0, atol=8e-12)


@on_both_flows
@pytest.mark.parametrize("gap", [1e-6, 1e-9, 1e-12])
def test_grazing_a_wall_at_which_it_could_rest(flow, gap):
    """As the parabola that misses, with a mode at rest: a touch is no rest, for nothing presses."""
    exits = [Exit("y", reset={"w": "-r*w"}, sticks="rest")]
    system = System(
        states=["y", "w"],
        parameters={"r": 0.0},
        modes={"m": Mode({"y": "w", "w": "2"}, exits=exits)},
    )
    for sign in (1.0, -1.0):
        run = ns.simulate(flow(system), {"y": 1 + sign * gap, "w": -2.0}, times=[2.0])
        assert ns.phase_word(run)[-1] == "m"
        # plastic: from the hit at 1 - sqrt(gap) it leaves with speed zero
        late = 1.0 if sign > 0 else 1 + np.sqrt(gap)
        left = gap if sign > 0 else 0.0
        assert float(run["y"][-1]) == pytest.approx(late**2 + left, abs=20 * EPS / np.sqrt(gap))


# ---------------------------------------------------------------- starts on a guard


@pytest.mark.parametrize(
    ("below", "above", "word", "x"),
    [
        (1, 2, ("flow[+]",), 1.0),  # through it, upward
        (-1, -2, ("flow[-]",), -0.5),  # through it, downward
        (3, -1, ("flow[0]",), 0.0),  # both sides point at it
        (-1, 2, None, 0.0),  # both sides lead away
    ],
)
def test_start_on_a_guard_four_sign_cases(below, above, word, x):
    """x' is constant on both sides of x = 0; by half a unit of time x is half the rate."""
    system = System(states=["x"], equations={"x": f"where(x > 0, {above}, {below})"})
    run = ends_early(system, {"x": 0.0}, times=[0.5])
    if word is None:
        assert run.attrs["status"] == "nonunique"
        assert "both sides" in run.attrs["message"]
        return
    assert (run.attrs["status"], ns.phase_word(run)) == ("completed", word)
    assert float(run["x"][-1]) == pytest.approx(x, abs=EPS)
    assert run.attrs["n_uncertain"] == 0


@on_both_flows
@pytest.mark.parametrize("speed", [1.0, 0.0, -1.0])
@pytest.mark.parametrize("gravity", [1.0, -1.0])
def test_start_on_a_guard_at_which_it_may_rest(flow, gravity, speed):
    """Speed and force, each towards the floor or away: up, rest, a bounce, or off."""
    mode = Mode({"x": "v", "v": "-g"}, exits=[Exit("x", reset={"v": "-v/2"}, sticks="rest")])
    system = System(states=["x", "v"], parameters={"g": gravity}, modes={"flight": mode})
    run = ns.simulate(flow(system), {"v": speed}, times=[0.5])
    if speed == 0.0 and gravity > 0.0:
        assert ns.phase_word(run) == ("rest",)
        assert run["end_state"].values.tolist() == [0.0, 0.0]
        return
    up = -speed / 2 if speed < 0.0 else speed
    assert ns.phase_word(run)[0] == "flight"
    assert float(run["x"][-1]) == pytest.approx(up * 0.5 - gravity / 8, abs=4 * EPS)


# ---------------------------------------------------------------- narrow places and corners


def bent_force(system):
    """Taylor twin with the term that is zero in the last rate."""
    return taylor_twin(system, -1)


@pytest.mark.parametrize("flow", [lambda system: system, bent_force], ids=["exact", "Taylor"])
@pytest.mark.parametrize("gap", [1e-3, 1e-12])
def test_two_walls_close_together_at_which_it_comes_to_rest(flow, gap):
    """Between a floor and a ceiling, r = 1/2, in units in which the gap is one.

    From the floor at the speed 2 it meets the ceiling at sqrt(4 - 2), comes down with half of that
    from there, to the speed sqrt(1/2 + 2), and goes up with half of it: not to the ceiling.
    All is over 2 (u/2)/(1 - r) = 2 u after the first landing, at the speed u.
    """
    exits = [
        Exit("gap - x", reset={"v": "-v/2"}, sticks="top", name="ceiling"),
        Exit("x", reset={"v": "-v/2"}, sticks="bottom", name="floor"),
    ]
    mode = Mode({"x": "v", "v": "-gap"}, exits=exits)
    system = System(states=["x", "v"], parameters={"gap": gap}, modes={"flight": mode})
    run = ns.simulate(flow(system), {"v": 2 * gap}, times=[20.0])
    up, back = 2 - np.sqrt(2.0), np.sqrt(2.5) - np.sqrt(0.5)
    log = crossings(run)
    assert log["event_name"].values[:3].tolist() == ["ceiling", "floor", "floor"]
    expected = [up, up + back, up + back + np.sqrt(2.5)]
    assert np.allclose(log["event_time"][:3], expected, rtol=0, atol=40 * EPS)
    assert float(log["event_time"][-1]) == pytest.approx(up + back + 2 * np.sqrt(2.5), rel=1e-12)
    assert ns.phase_word(run)[-1] == "bottom"
    assert run["end_state"].values.tolist() == [0.0, 0.0]


@on_both_flows
def test_a_slab_of_1e_6_with_rest_on_its_far_side(flow):
    """A drop through a layer that brakes, 1e-6 above the floor, without loss of either.

    From 1 + 1e-6 it reaches the layer at v^2 = 2; there -1 + 1e5 acts, so v^2 falls by
    2e-6 (1e5 - 1) to 1.800002 at the floor. A plastic impact ends it there.
    """
    layer = "where(x < 1e-6, 1e5, 0)"
    mode = Mode(
        {"x": "v", "v": f"-1 + {layer}"}, exits=[Exit("x", reset={"v": "0"}, sticks="rest")]
    )
    system = System(states=["x", "v"], modes={"m": mode})
    run = ends_early(flow(system), {"x": 1 + 1e-6}, times=[2.0])
    log = crossings(run)
    assert log["event_kind"].values[:2].tolist()[0] == "switch"
    speed = float(log["state_before"].sel(state="v")[1])
    # the layer is known to an ulp of one, of 1e-6
    assert speed == pytest.approx(-np.sqrt(1.800002), abs=1e-9)
    inside = (np.sqrt(2.0) - np.sqrt(1.800002)) / (1e5 - 1)
    assert float(log["event_time"][1] - log["event_time"][0]) == pytest.approx(inside, abs=1e-15)


@on_both_flows
@pytest.mark.parametrize("r", [0.0, 0.5])
def test_corner_of_two_guards_at_which_it_comes_to_rest(flow, r):
    """Pressed into a corner of a box with unit force on both axes from (1/2, 1/2), at rest.

    Both walls are met at 1, and at rest 2 r/(1 - r) later.
    """
    exits = [
        Exit("x", reset={"u": "-r*u"}, sticks="left", name="left"),
        Exit("y", reset={"v": "-r*v"}, sticks="down", name="down"),
    ]
    mode = Mode({"x": "u", "y": "v", "u": "-1", "v": "-1"}, exits=exits)
    system = System(states=["x", "y", "u", "v"], parameters={"r": r}, modes={"m": mode})
    run = ns.simulate(flow(system), {"x": 0.5, "y": 0.5}, times=[10.0])
    log = crossings(run)
    assert float(log["event_time"][0]) == pytest.approx(1.0, abs=2 * EPS)
    assert float(log["event_time"][-1]) == pytest.approx(1 + 2 * r / (1 - r), rel=1e-12)
    assert ns.phase_word(run)[-1] == "left+down"
    assert run["end_state"].values.tolist() == [0.0] * 4
    assert log["event_path"].values[0].split(">")[0] == "left"


@on_both_flows
@pytest.mark.parametrize("names", [("left", "right"), ("right", "left")])
def test_three_ball_impact_is_pairwise_in_declared_order(flow, names):
    """Newton's cradle with r = 1/2: pairs collide in turn, the first declared pair that closes.

    Equal masses: a pair with speeds (a, b) goes on with its mean -+ r/2 (a - b). From (1, 0, 0):
    left (1/4, 3/4, 0), right (1/4, 3/16, 9/16), left, since 1/4 > 3/16: mean 7/32 -+ 1/64 =
    (13/64, 15/64, 9/16). Then all part: 13/64 < 15/64 < 36/64. With one pair closed at a time
    the declared order has no say.
    """
    flow_of_balls = {"x": "u", "y": "v", "z": "w", "u": "0", "v": "0", "w": "0"}

    def pair(a, b):
        return {
            a: f"({a} + {b})/2 - ({a} - {b})/4",
            b: f"({a} + {b})/2 + ({a} - {b})/4",
        }

    ways = {
        "left": Exit("y - x", reset=pair("u", "v"), name="left"),
        "right": Exit("z - y", reset=pair("v", "w"), name="right"),
    }
    mode = Mode(flow_of_balls, exits=[ways[name] for name in names])
    system = System(states=["x", "y", "z", "u", "v", "w"], modes={"m": mode})
    run = ns.simulate(flow(system), {"x": -1.0, "u": 1.0}, times=[1.5])
    log = crossings(run)
    assert log["event_path"].values.tolist() == ["left>right>left"]
    assert run["end_state"].values[3:].tolist() == [13 / 64, 15 / 64, 36 / 64]
    assert float(run["x"][-1]) == pytest.approx(13 / 128, abs=8 * EPS)


# ---------------------------------------------------------------- stiff contact


@pytest.mark.parametrize("zeta", [0.05, 0.3])
def test_stiff_contact_is_released_by_force(zeta):
    """A mass meets a pad with k = 1e8 and c = 2 zeta w, w = 1e4; the pad relaxes by itself.

    In contact x = v0/d exp(-zeta w s) sin(d s), d = w sqrt(1 - zeta^2). The force k x + c v is
    zero where tan(d s) = -2 zeta sqrt(1 - zeta^2)/(1 - 2 zeta^2), so d s = pi - 2 asin(zeta):
    before x is zero again, at x = -c v/k, and there the gap opens with a double zero. At release
    v = -v0 exp(-zeta w s).
    """
    meets = Exit("q - x", to="contact", name="on")
    parts = Exit("force", to="free", name="off")
    system = System(
        states=["x", "v", "q"],
        parameters={"k": 1e8, "zeta": zeta},
        definitions={"c": "2*zeta*sqrt(k)", "force": "k*x + c*v"},
        modes={
            "free": Mode({"x": "v", "v": "0", "q": "-k*q/c"}, exits=[meets]),
            "contact": Mode({"x": "v", "v": "-force"}, slaved={"q": "x"}, exits=[parts]),
        },
    )
    run = ns.simulate(system, {"x": -0.5, "v": 1.0}, times=[1.0])
    log = crossings(run)
    assert log["event_name"].values.tolist() == ["on", "off"]
    assert bool(log["certified"].all())
    d = 1e4 * np.sqrt(1 - zeta**2)
    stay = (np.pi - 2 * np.arcsin(zeta)) / d
    on, off = log["event_time"].values
    # times are known to an ulp of 1/2, of the 3e-4 of the contact
    assert on == pytest.approx(0.5, abs=2 * EPS)
    assert off - on == pytest.approx(stay, abs=4 * EPS)
    x, v, q = log["state_after"].values[-1]
    leaving = -np.exp(-zeta * 1e4 * stay)
    assert v == pytest.approx(leaving, rel=1e-11)
    assert x == pytest.approx(-2 * zeta * leaving * 1e-4, rel=1e-11, abs=0)
    assert q == pytest.approx(x, rel=1e-13, abs=0)
    assert float(run["v"][-1]) == pytest.approx(leaving, rel=1e-11)


# ---------------------------------------------------------------- folds


def test_visible_fold_is_left_exactly_where_it_is():
    """Below (3, 1), above (1, x): sliding on y = 0 until x = 0, where the upper field turns away.

    There x' = (1 - 3 x)/(1 - x), so from -1 it takes 1/3 + (2/9) log 4, and then y = x^2/2.
    """
    system = System(
        states=["x", "y"], equations={"x": "where(y > 0, 1, 3)", "y": "where(y > 0, x, 1)"}
    )
    run = ns.simulate(system, {"x": -1.0}, times=[2.0])
    end = 1 / 3 + 2 / 9 * np.log(4.0)
    log = crossings(run)
    assert log["event_kind"].values.tolist() == ["slide_exit"]
    assert log["state_after"].values.tolist() == [[0.0, 0.0]]
    assert float(log["event_time"][0]) == pytest.approx(end, rel=1e-14)
    x = 2.0 - end
    assert np.allclose(run["end_state"], [x, x**2 / 2], rtol=1e-14, atol=0)


def test_visible_fold_is_met_exactly():
    """From above down to the fold itself: y = x^2/2 touches the surface at x = 0 and goes on."""
    system = System(states=["x", "y"], equations={"x": "1", "y": "where(y > 0, x, 1)"})
    run = ns.simulate(system, {"x": -1.0, "y": 0.5}, times=[2.0])
    assert run.attrs["status"] == "completed"
    # either answer about the touch leads to the same motion within rounding
    assert np.allclose(run["end_state"], [1.0, 0.5], rtol=0, atol=1e-7)
    assert run.attrs["n_uncertain"] > 0 or run.attrs["n_events"] == 0


def test_invisible_fold_is_come_round():
    """Below (1, 1), above (1, -x): y = (x0^2 - x^2)/2 leads from x0 < 0 to -x0, to slide there."""
    system = System(states=["x", "y"], equations={"x": "1", "y": "where(y > 0, -x, 1)"})
    run = ns.simulate(system, {"x": -1.5, "y": -0.5}, times=[4.0])
    log = crossings(run)
    assert log["event_kind"].values.tolist() == ["switch", "slide_entry"]
    assert np.allclose(log["event_time"], [0.5, 2.5], rtol=0, atol=4 * EPS)
    assert np.allclose(log["state_after"].sel(state="x"), [-1.0, 1.0], rtol=0, atol=4 * EPS)
    assert float(run["y"][-1]) == 0.0


@pytest.mark.parametrize("start", [{}, {"x": -1.0, "y": -1.0}])
def test_invisible_fold_itself_slides_at_once(start):
    """At (0, 0) the upper field falls back at once, as -t^2/2, and the lower one points up."""
    system = System(states=["x", "y"], equations={"x": "1", "y": "where(y > 0, -x, 1)"})
    run = ns.simulate(system, start, times=[4.0])
    assert ns.phase_word(run)[-1] == "flow[0]"
    assert float(run["y"][-1]) == 0.0
    assert run.attrs["n_uncertain"] == 0


# ---------------------------------------------------------------- meetings of surfaces


def test_spiral_into_the_meeting_of_two_surfaces():
    """x' = -sign(x) + 2 sign(y), y' = -2 sign(x) - sign(y): |x| + |y| shrinks at the rate 2.

    So from (0.3, 0.4) all is over at 0.35, after infinitely many switches: each turn takes a
    fixed part of what is left, 3^-4 remains.
    """
    system = System(
        states=["x", "y"],
        equations={"x": "-sign(x) + 2*sign(y)", "y": "-2*sign(x) - sign(y)"},
    )
    run = ends_early(system, {"x": 0.3, "y": 0.4}, times=[10.0])
    assert run.attrs["status"] in ("completed", "event_limit")
    if run.attrs["status"] == "event_limit":
        assert "winds itself into the meeting of two surfaces" in run.attrs["message"]
    assert float(run["event_time"][-1]) == pytest.approx(0.35, rel=1e-12)
    assert np.allclose(run["end_state"], 0.0, rtol=0, atol=1e-15)
    # |x| + |y| at every event
    sizes = np.abs(run["state_after"].values).sum(axis=1)
    assert np.allclose(sizes, 0.7 - 2 * run["event_time"], rtol=0, atol=4 * EPS)


def test_twisting_controller():
    """x'' = -2 sign(x) - sign(v): from one side to the other the speed falls by sqrt 3.

    From (1, 0): sqrt(2/3) to x = 0 at the speed sqrt(6); v/1 from there to v = 0 at v^2/2, and so
    on. All times and lengths are sums of powers of 1/sqrt 3.
    """
    system = System(states=["x", "v"], equations={"x": "v", "v": "-2*sign(x) - sign(v)"})
    run = ends_early(system, {"x": 1.0}, times=[100.0])
    # a way in at 2 - 1 = 1 (v opposes), out at 3: in takes sqrt(2 x) to v = sqrt(2 x), out v/3
    # with x' = v^2/6 = x/3: each half turn takes (1 + 1/3) sqrt(2 x), then x is a third
    end = 4 / 3 * np.sqrt(2.0) / (1 - np.sqrt(1 / 3))
    assert run.attrs["status"] in ("completed", "event_limit")
    assert float(run["event_time"][-1]) == pytest.approx(end, rel=1e-12)
    assert np.allclose(run["end_state"], 0.0, rtol=0, atol=1e-15)
    halves = run["event_time"].values[2:20:2]
    k = np.arange(1, len(halves) + 1)
    expected = 4 / 3 * np.sqrt(2.0) * (1 - 3.0 ** (-k / 2)) / (1 - np.sqrt(1 / 3))
    assert np.allclose(halves, expected, rtol=1e-13, atol=0)


# ---------------------------------------------------------------- not unique


@pytest.mark.parametrize(("choice", "x"), [(None, 0.0), ("above", 0.5), ("below", -1.0)])
def test_escaping_region(choice, x):
    """Above x' = 1, below x' = -2: from 0 two motions begin, and one stays. Declared or not."""
    system = System(
        states=["x"],
        equations={"x": "where(gate > 0, 1, -2)"},
        surfaces={"gate": Surface("x", on_nonunique=choice)},
    )
    run = ends_early(system, {"x": 0.0}, times=[0.5])
    assert run.attrs["status"] == ("completed" if choice else "nonunique")
    assert float(run["end_state"][0]) == x
    if choice is None:
        assert "on_nonunique" in run.attrs["message"]


TWO_FOLDS = {
    "linear": {"x": "1", "y": "where(gate > 0, x, -x)"},
    "linear, another speed": {"x": "where(gate > 0, 1, 2)", "y": "where(gate > 0, x, -3*x)"},
    "nonlinear": {"x": "1", "y": "where(gate > 0, sin(x) + x**2, -x - x**3)"},
}


@pytest.mark.parametrize("name", TWO_FOLDS)
def test_start_at_a_visible_two_fold(name):
    """Both fields are tangent at (0, 0) and both turn away from it: two motions begin there."""
    system = System(states=["x", "y"], equations=TWO_FOLDS[name], surfaces={"gate": Surface("y")})
    assert ends_early(system, {}, times=[1.0]).attrs["status"] == "nonunique"


@pytest.mark.parametrize("name", TWO_FOLDS)
def test_slide_into_a_visible_two_fold(name):
    """Where x < 0 both sides point at y = 0; at x = 0 both begin to lead away at once."""
    system = System(states=["x", "y"], equations=TWO_FOLDS[name], surfaces={"gate": Surface("y")})
    run = ends_early(system, {"x": -0.5}, times=[2.0])
    assert run.attrs["status"] == "nonunique"
    assert np.allclose(run["end_state"], 0.0, rtol=0, atol=1e-9)


def test_slide_past_a_two_fold_in_space():
    """With folds that cross, x = 0 and y = 0 on z = 0, a slide that meets one of them leaves there.

    On z = 0 with z' = x above and -y below: u = -(x - y)/(x + y) moves with rates between the two
    fields, and the exit is where y or x is zero first.
    """
    system = System(
        states=["x", "y", "z"],
        equations={
            "x": "where(z > 0, 1, -0.3)",
            "y": "where(z > 0, 0.4, 1)",
            "z": "where(z > 0, x, -y)",
        },
    )
    run = ns.simulate(system, {"x": -0.5, "y": -0.5}, times=[2.0])
    log = crossings(run)
    assert log["event_kind"].values.tolist() == ["slide_exit"]
    with mp.workdps(30):
        # alpha = y/(x + y) above: x' and y' over the common divisor, by the time of x + y
        def rates(t, z):
            x, y = z
            alpha = y / (x + y)
            return [
                alpha - mpf("0.3") * (1 - alpha),
                mpf("0.4") * alpha + 1 - alpha,
            ]

        motion = mp.odefun(rates, 0, [mpf("-0.5"), mpf("-0.5")], tol=mpf(10) ** -18)
        end = mp.findroot(lambda t: motion(t)[1], mpf("0.63"), tol=1e-14)
        x = motion(end)[0]
    # 0.3 and 0.4 as doubles are off by 1e-17
    assert float(log["event_time"][0]) == pytest.approx(float(end), abs=1e-13)
    assert np.allclose(log["state_after"].values[0], [float(x), 0.0, 0.0], rtol=0, atol=1e-13)


# ---------------------------------------------------------------- Painleve's paradox


def rod(mu, **words):
    """A rod of mass 1, half-length 1 and inertia 1/3 whose lower end slides to the left, u < 0.

    The end on the floor has the vertical acceleration p N - b, with the normal force N and
    friction mu N to the right: p = 1 + 3 cos(th) (cos(th) - mu sin(th)), b = 1 - w^2 sin(th). So
    N = b/p. Where p < 0 there is no force at all for b > 0, and two motions for b < 0: that is
    Painleve's paradox. It takes mu > 4/3, for the least p is 1 + 3/2 (1 - sqrt(1 + mu^2)).
    """
    exits = [
        Exit("p", to="stop", name="jam"),
        Exit("b", to="stop", name="lift"),
        Exit("-u", to="stop", name="stick"),
    ]
    flow = {
        "th": "w",
        "w": "-3*N*(cos(th) - mu*sin(th))",
        "u": "mu*N - 3*N*(cos(th) - mu*sin(th))*sin(th) + w**2*cos(th)",
    }
    definitions = {
        "p": "1 + 3*cos(th)*(cos(th) - mu*sin(th))",
        "b": "1 - w**2*sin(th)",
        "N": "b/p",
    }
    return System(
        states=["th", "w", "u"],
        parameters={"mu": mu},
        definitions=definitions,
        outputs={"normal": "N"},
        modes={"sliding": Mode(flow, exits=exits)},
        **words,
    )


def test_painleve_is_refused_by_require():
    """A model may refuse the friction with which it could come to the paradox."""
    require = {"mu < 4/3": "a rod with more friction has no motion in some positions"}
    rod(1.3, require=require)
    with pytest.raises(ModelError, match="no motion in some positions"):
        rod(1.4, require=require)


def test_painleve_start_inside_is_refused():
    """At th = 1 with mu = 1.6, p = -0.307: no mode admits it, and the message names the guard."""
    with pytest.raises(OptionError, match=r"guard 'p' is -0\.306"):
        ns.simulate(rod(1.6), {"th": 1.0, "u": -5.0}, times=[1.0])


def test_painleve_is_approached_only_where_the_load_vanishes_too():
    """Motions reach p = 0 only together with b = 0, with a finite force (Genot and Brogliato).

    There N = 0/0, so the run ends as singular and says so; the place is where both vanish:
    1 + 3 c (c - mu s) = 0 and w = 1/sqrt(s), with the sine s and cosine c of the angle.
    """
    run = ends_early(rod(1.6), {"th": 0.3, "w": 1.0, "u": -5.0}, t_end=3.0)
    assert run.attrs["status"] == "singular"
    assert "division by zero" in run.attrs["message"]
    # with T = tan(th): T^2 - 3 mu T + 4 = 0, the smaller root
    th = np.arctan((4.8 - np.sqrt(4.8**2 - 16)) / 2)
    assert float(run["end_state"][0]) == pytest.approx(th, abs=1e-3)
    assert float(run["end_state"][1]) == pytest.approx(1 / np.sqrt(np.sin(th)), abs=1e-3)
    assert 0 < float(run["normal"].values[-1]) < 10


def test_painleve_is_avoided_by_lifting_off():
    """A rod that turns fast enough leaves the floor first, where the load b vanishes."""
    run = ns.simulate(rod(1.6), {"th": 0.3, "w": 1.5, "u": -5.0}, t_end=3.0)
    assert run.attrs["status"] == "stopped"
    assert str(run["event_name"].values[-1]) == "lift"
    th, w, _ = run["end_state"].values
    assert w**2 * np.sin(th) == pytest.approx(1.0, abs=1e-14)
    assert 1 + 3 * np.cos(th) * (np.cos(th) - 1.6 * np.sin(th)) > 1
