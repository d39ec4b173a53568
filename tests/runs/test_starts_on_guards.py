"""A start where a guard is zero: its first derivative that is not zero decides."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, OptionError, RunWarning, System
from runs.flows import on_both_flows

# ---------------------------------------------------------------- hand-declared modes


def chain(order, sign):
    """x0 leaves zero as sign t^order / order!."""
    states = [f"x{i}" for i in range(order)]
    flow = {f"x{i}": f"x{i + 1}" for i in range(order - 1)} | {states[-1]: "c"}
    modes = {
        "inside": Mode(flow, exits=[Exit("x0", to="outside")]),
        "outside": Mode(dict.fromkeys(states, "0")),
    }
    return System(states=states, parameters={"c": sign}, modes=modes)


@on_both_flows
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("order", [1, 2, 3, 4, 5])
def test_the_order_of_the_zero(flow, order, sign):
    run = ns.simulate(flow(chain(order, sign)), {}, times=[0.5])
    assert ns.phase_word(run, 0.0, 0.5) == ("inside" if sign > 0 else "outside",)
    assert run.attrs["n_uncertain"] == 0
    if sign > 0:
        expected = 0.5**order / float(np.prod(np.arange(1, order + 1)))
        assert float(run["x0"][-1]) == pytest.approx(expected, rel=1e-15)


@on_both_flows
@pytest.mark.parametrize("order", [6, 7, 12])
def test_the_order_of_a_zero_beyond_the_coefficients_of_a_look(flow, order):
    run = ns.simulate(flow(chain(order, -1)), {}, times=[0.5])
    assert ns.phase_word(run, 0.0, 0.5) == ("outside",)
    run = ns.simulate(flow(chain(order, 1)), {}, times=[0.5])
    assert ns.phase_word(run, 0.0, 0.5) == ("inside",)
    assert run.attrs["n_uncertain"] == 0


def leaving(guard, flow, start, **words):
    modes = {
        "inside": Mode(flow, exits=[Exit(guard, to="outside")]),
        "outside": Mode(dict.fromkeys(flow, "0")),
    }
    return ns.simulate(System(states=list(flow), modes=modes, **words), start, times=[0.5])


@pytest.mark.parametrize(
    ("guard", "word"),
    [
        # along x = 1, y = t
        ("x**2 + y**2 - 1", "inside"),
        ("1 - x**2 - y**2", "outside"),
        ("sqrt(x**2 + y**2) - 1", "inside"),
        ("1 - sqrt(x**2 + y**2)", "outside"),
        ("log(x**2 + y**2)", "inside"),
        ("atan(x**2 + y**2 - 1)", "inside"),
        ("cos(y) - x", "outside"),
        ("sin(y) - y*x", "outside"),  # -t^3/6
        ("y*x - sin(y)", "inside"),
        ("y - y**3 - sin(y)", "outside"),
        ("(x - 1)*y", "inside"),  # identically zero holds
        ("1 - x", "inside"),
        ("(y*x)**2", "inside"),
        ("-y**4", "outside"),
        ("y**5*x", "inside"),
    ],
)
def test_nonlinear_guards(guard, word):
    run = leaving(guard, {"x": "0", "y": "1"}, {"x": 1.0})
    assert ns.phase_word(run, 0.0, 0.5) == (word,)
    assert run.attrs["n_uncertain"] == 0


@pytest.mark.parametrize("angle", [0.0, 0.3, 0.9])
def test_a_guard_that_the_motion_conserves(angle):
    """On the circle x^2 + y^2 = 1 the guard is identically zero, by cancellation only."""
    start = {"x": float(np.cos(angle)), "y": float(np.sin(angle))}
    for guard in ("x**2 + y**2 - 1", "1 - x**2 - y**2"):
        run = leaving(guard, {"x": "-y", "y": "x"}, start)
        assert ns.phase_word(run, 0.0, 0.5) == ("inside",)


@on_both_flows
@pytest.mark.parametrize("off", [-3e-13, -1e-13, 1e-13, 3e-13])
def test_a_guard_that_the_tolerance_declares_zero(flow, off):
    """Within 1e-12 of a constant guard, but beyond rounding: the start is taken.

    Where the guard is negative the exit may fire later, if flagged.
    """
    mode = Mode({"x": "0", "v": "0"}, exits=[Exit("1 - x", to="stop")])
    run = ns.simulate(flow(System(states=["x", "v"], modes={"m": mode})), {"x": 1 + off}, t_end=3.0)
    assert run.attrs["status"] == "completed" or (off > 0.0 and run.attrs["n_uncertain"] == 1)
    assert float(run["end_state"][0]) == pytest.approx(1 + off, abs=abs(off))


@on_both_flows
def test_identically_zero_holds_for_ever(flow):
    """A mass at rest on its stop stays there, while another bounces for many windows.

    y = cos t until -1/2, where it turns back: bounces come 4 pi / 3 apart.
    """
    exits = [Exit("x", to="stop"), Exit("y + 0.5", reset={"w": "-w"}, name="bounce")]
    mode = Mode({"x": "v", "v": "0", "y": "w", "w": "-y"}, exits=exits)
    system = System(states=["x", "v", "y", "w"], period=1.0, modes={"m": mode})
    run = ns.simulate(flow(system), {"y": 1.0}, t_end=300.0)
    assert (run.attrs["status"], run.attrs["n_uncertain"]) == ("completed", 0)
    expected = 2 * np.pi / 3 + 4 * np.pi / 3 * np.arange(run.attrs["n_events"])
    # each of 300 periods rounds the time within it
    assert np.allclose(run["event_time"][1:], expected, rtol=0, atol=300 * 64 * 2.0**-52)
    assert expected[-1] > 295.0


@on_both_flows
def test_two_oscillators_in_step_stay_together(flow):
    """x - y is zero by cancellation, along a whole motion."""
    exits = [Exit("x - y", to="stop"), Exit("y - x", to="stop")]
    mode = Mode({"x": "v", "v": "-x", "y": "w", "w": "-y"}, exits=exits)
    system = System(states=["x", "v", "y", "w"], modes={"m": mode})
    run = ns.simulate(flow(system), {"x": 1.0, "y": 1.0}, t_end=100.0)
    assert (run.attrs["status"], run.attrs["n_uncertain"]) == ("completed", 0)


# ---------------------------------------------------------------- starts off by rounding

ROUNDED = 0.3 - (0.1 + 0.2)  # a zero that was computed, -5.55e-17


def floor_at(place, reset, **words):
    """A ball above a floor, thrown up at speed 1: x = place + t - t^2 / 2."""
    mode = Mode({"x": "v", "v": "-1"}, exits=[Exit("x - place", reset=reset, name="hit", **words)])
    return System(states=["x", "v"], parameters={"place": place}, modes={"m": mode})


@on_both_flows
@pytest.mark.parametrize("off", [-1e-17, ROUNDED])
@pytest.mark.parametrize(("v", "up"), [(1.0, 1.0), (-1.0, 0.5)])
def test_a_start_behind_a_wall_by_rounding_is_one_on_the_wall(flow, off, v, up):
    """Thrown up it flies at once, thrown down it bounces at once with half of its speed."""
    run = ns.simulate(flow(floor_at(0.0, {"v": "-0.5*v"})), {"x": off, "v": v}, times=[0.0, 0.25])
    assert run["x"].values.tolist() == pytest.approx([0.0, up / 4 - 1 / 32], rel=4 * 2.0**-52)
    assert float(run["x"][0]) == 0.0
    assert run.attrs["n_events"] == 0


def test_a_start_behind_a_wall_by_rounding_rests_there():
    """Weight presses what has no speed, and only by it is the size of the motion known."""
    system = floor_at(0.0, {"v": "-0.5*v"}, sticks="rest")
    run = ns.simulate(system, {"x": ROUNDED}, times=[0.0, 2.0])
    assert ns.phase_word(run, 0.0, 2.0) == ("rest",)
    assert run["x"].values.tolist() == [0.0, 0.0]


@on_both_flows
def test_many_starts_behind_a_wall_by_rounding(flow):
    system = flow(floor_at(0.0, {"v": "-0.5*v"}))
    runs = ns.ensemble(system, {"x": [0.0, ROUNDED], "v": [1.0, 1.0]}, times=[0.25])
    assert runs["status"].values.tolist() == ["completed"] * 2
    assert np.ptp(runs["x"].values) == 0.0


@pytest.mark.parametrize("place", [0.0, 0.3])
def test_the_derivatives_of_a_start_behind_a_wall_by_rounding(place):
    """Derivatives of an event: from d above the wall the ball hits at d with the speed 1 + d.

    It flies up as x = (1 + d)(t - d) / 2 - (t - d)^2 / 2, so dx/dd = 3 t / 2 - 1 / 2; and
    dx/dv0 = -t / 2.
    """
    system = floor_at(place, {"v": "-0.5*v"})
    run = ns.simulate(system, {"x": place + ROUNDED, "v": -1.0}, times=[0.25], tangent=True)
    found = run["tangent"].sel(state="x").values.ravel()
    assert found == pytest.approx([-0.125, -0.125], abs=8 * 2.0**-52)


@on_both_flows
@pytest.mark.parametrize("off", [-1e-9, -1e-11])
def test_a_start_behind_a_wall_by_more_is_refused(flow, off):
    with pytest.raises(OptionError, match="guard 'x - place' is -1e-"):
        ns.simulate(flow(floor_at(0.0, {"v": "-0.5*v"})), {"x": off, "v": 1.0}, times=[0.25])


@on_both_flows
def test_rounding_is_that_of_the_motion(flow):
    """A motion of a millionth: 1e-22 is rounding of it, 1e-17 is not."""
    mode = Mode({"x": "v", "v": "-1e-6"}, exits=[Exit("x", reset={"v": "-v"}, name="hit")])
    system = flow(System(states=["x", "v"], period=1.0, modes={"m": mode}))
    run = ns.simulate(system, {"x": -1e-22, "v": 1e-6}, times=[0.0])
    assert float(run["x"][0]) == 0.0
    with pytest.raises(OptionError, match="guard 'x'"):
        ns.simulate(system, {"x": -1e-17, "v": 1e-6}, times=[0.0])


# ---------------------------------------------------------------- cells


@pytest.fixture(params=["exact", "Taylor"])
def cells(request):
    """Run a mode that is piecewise in x from the surface x = 0."""

    def run(rate, start=None, states=("x",), t_end=0.5, **words):
        bend = " + tiny*other*other" if request.param == "Taylor" else ""
        flow = {"x": rate + bend} if states == ("x",) else {"x": "v", "v": rate + bend}
        system = System(
            states=[*states, "other"],
            parameters={"tiny": 0.0},
            modes={"m": Mode(flow | {"other": "0"})},
            **words,
        )
        return ns.simulate(system, start or {}, times=[t_end])

    return run


@pytest.mark.parametrize("states", [("x",), ("x", "v")], ids=["first order", "second order"])
@pytest.mark.parametrize(
    ("rate", "label", "end"),
    [("1 + 0.5*sign(x)", "m[+]", 1.5), ("-1 - 0.5*sign(x)", "m[-]", -0.5)],
)
def test_both_sides_cross(cells, states, rate, label, end):
    run = cells(rate, states=states)
    assert ns.phase_word(run, 0.0, 0.5) == (label,)
    assert float(run["x"][-1]) == pytest.approx(end * (0.5 if len(states) == 1 else 0.125))
    assert run.attrs["n_events"] == 0


@pytest.mark.parametrize("bias", ["", " + 0.3", " - 0.9"])
def test_both_sides_point_at_the_surface(cells, bias):
    """-u + bias = 0 keeps x where it is."""
    run = cells("-sign(x)" + bias, outputs={"u": "sign(x)"})
    assert run.attrs["status"] == "completed"
    assert ns.phase_word(run) == ("m[0]",)
    assert float(run["x"][-1]) == 0.0
    assert float(run["u"][-1]) == pytest.approx(float(bias.replace(" ", "") or 0), abs=1e-15)


@pytest.mark.parametrize("bias", ["", " + 0.3", " - 0.9"])
def test_both_sides_turn_around_at_the_surface(cells, bias):
    """The speed passes through x = 0: no motion along it, but for the origin itself."""
    with pytest.warns(RunWarning, match="sliding"):
        run = cells("-sign(x)" + bias, states=("x", "v"))
    assert run.attrs["status"] == "sliding"
    assert not [name for name in run["mode"].attrs["flag_meanings"].split() if "0" in name]


@pytest.mark.parametrize("states", [("x",), ("x", "v")], ids=["first order", "second order"])
@pytest.mark.parametrize("bias", ["", " + 0.3", " - 0.9"])
def test_both_sides_point_away(cells, states, bias):
    with pytest.warns(RunWarning, match="nonunique"):
        assert cells("sign(x)" + bias, states=states).attrs["status"] == "nonunique"


def test_a_side_that_is_asked_for():
    system = System(states=["x"], modes={"m": Mode({"x": "sign(x)"})})
    for mode, end in (("m[+]", 0.5), ("m[-]", -0.5)):
        run = ns.simulate(system, {"x": 0.0}, times=[0.5], mode=mode)
        assert (run.attrs["status"], float(run["x"][-1])) == ("completed", end)


@pytest.mark.parametrize(
    ("force", "label"),
    [("cos(t)", "m[+]"), ("-cos(t)", "m[-]"), ("sin(t)", "m[+]"), ("-sin(t)", "m[-]")],
)
def test_a_breathing_crack_from_rest_on_its_surface(cells, force, label):
    """With the force sin t position, speed and acceleration are zero: the third derivative picks.

    v' = sin t - 0.02 v - k x, with k = 0.7 open and 1 closed, against its series in t.
    """
    rate = f"{force} - 0.02*v - x*where(x > 0, 0.7, 1)"
    run = cells(rate, states=("x", "v"), period="2*pi", t_end=0.25)
    assert ns.phase_word(run, 0.0, 0.25) == (label,)
    assert run.attrs["n_events"] == 0
    stiffness = 0.7 if label == "m[+]" else 1.0
    sign = -1.0 if force.startswith("-") else 1.0
    assert float(run["x"][-1]) == pytest.approx(sign * _series(force, stiffness, 0.25), rel=1e-13)


def _series(force, stiffness, t):
    """x'' + 0.02 x' + k x = cos t or sin t from rest, by the recurrence of its series."""
    x, factor = [0.0, 0.0], 1.0
    for k in range(30):
        if k > 0:
            factor /= k
        even = "cos" in force
        forcing = factor * (-1.0) ** (k // 2) * ((k % 2 == 0) == even)
        x.append((forcing - 0.02 * (k + 1) * x[k + 1] - stiffness * x[k]) / ((k + 1) * (k + 2)))
    return sum(value * t**k for k, value in enumerate(x))


@pytest.mark.parametrize(
    ("outside", "inside", "answer"),
    [
        # (x^2 + v^2)' = 2 v (x + v'), so the damping decides the side
        ("x + 0.3*v", "x + 0.5*v", "m[-]"),
        ("x - 0.3*v", "x - 0.5*v", "m[+]"),
        ("x - 0.3*v", "x + 0.3*v", "nonunique"),
    ],
)
@pytest.mark.parametrize("start", [{"x": 0.6, "v": 0.8}, {"x": 1.0, "v": 0.0}])
def test_a_curved_surface(outside, inside, answer, start):
    """At (1, 0) the rate of x^2 + v^2 and its rate are zero too: the third derivative decides."""
    flow = {"x": "v", "v": f"-where(x**2 + v**2 > 1, {outside}, {inside})"}
    system = System(states=["x", "v"], modes={"m": Mode(flow)})
    if answer.startswith("m"):
        run = ns.simulate(system, start, times=[0.01])
        assert ns.phase_word(run, 0.0, 0.01) == (answer,)
    else:
        with pytest.warns(RunWarning, match=answer):
            assert ns.simulate(system, start, times=[0.01]).attrs["status"] == answer


@pytest.mark.parametrize("inside", [0.3, 0.1])
@pytest.mark.parametrize("start", [{"x": 0.6, "v": 0.8}, {"x": 1.0, "v": 0.0}])
def test_motion_along_a_curved_surface(inside, start):
    """Damping outside, its opposite inside: round the circle like the oscillator without both.

    (x^2 + v^2)' is -0.6 v^2 outside and 2 c v^2 inside, so u = (c - 0.3)/(c + 0.3) at every
    place, and what is left is x'' = -x. Where v = 0 both sides touch the circle to third order.
    """
    text = f"-x - v*where(x**2 + v**2 > 1, 0.3, -{inside})"
    system = System(
        states=["x", "v"],
        outputs={"u": "sign(x**2 + v**2 - 1)"},
        modes={"m": Mode({"x": "v", "v": text})},
    )
    run = ns.simulate(system, start, t_end=20.0)
    assert run.attrs["status"] == "completed"
    assert ns.phase_word(run) == ("m[0]",)
    t = run["time"].values
    exact = start["x"] * np.cos(t) + start["v"] * np.sin(t)
    # the circle is kept by the rates alone: rounding of each of some 100 steps adds up
    assert np.allclose(run["x"], exact, rtol=0, atol=100 * 64 * 2.0**-52)
    assert np.allclose(run["u"], (inside - 0.3) / (inside + 0.3), rtol=0, atol=1e-14)


# ---------------------------------------------------------------- impacts


@on_both_flows
@pytest.mark.parametrize("gravity", [1.0, -1.0])
@pytest.mark.parametrize("speed", [1.0, 0.0, -1.0])
def test_a_start_on_the_floor(flow, speed, gravity):
    mode = Mode({"x": "v", "v": "-g"}, exits=[Exit("x", reset={"v": "-v/2"}, name="bounce")])
    system = System(states=["x", "v"], parameters={"g": gravity}, modes={"m": mode})
    if speed == 0.0 and gravity > 0.0:  # rests there, as at the end of accumulating impacts
        with pytest.warns(RunWarning, match="impacts accumulate"):
            run = ns.simulate(flow(system), {"v": speed}, times=[0.5])
        assert float(run["end_state"][0]) == 0.0
        return
    run = ns.simulate(flow(system), {"v": speed}, times=[0.5])
    up = -speed / 2 if speed < 0.0 else speed  # the bounce is part of the start
    assert run["event_kind"].values.tolist() == ["start"]
    assert run["event_path"].values[0] == ("bounce" if speed < 0.0 else "")
    assert float(run["x"][-1]) == pytest.approx(up * 0.5 - gravity / 8, abs=1e-15)


# ---------------------------------------------------------------- times


@on_both_flows
@pytest.mark.parametrize("periods", [0, 1, 7])
def test_a_start_at_a_period_boundary(flow, periods):
    """x = sin t from x(0) = 0: on its guard, at the beginning of a period, moving inward."""
    mode = Mode({"x": "cos(t)"}, exits=[Exit("x", reset={"x": "0"}, name="back")])
    system = System(states=["x"], period="2*pi", modes={"m": mode})
    start = periods * system.period_value
    run = ns.simulate(flow(system), {"x": 0.0}, t_start=start, times=[start + 3.0])
    assert run.attrs["n_events"] == 0
    assert float(run["x"][-1]) == pytest.approx(np.sin(3.0), abs=1e-14)


@on_both_flows
def test_a_run_that_ended_at_an_event_goes_on(flow):
    """The bounce at 1 is passed once, by the first run or by the second."""
    mode = Mode({"x": "v", "v": "0"}, exits=[Exit("1 - x", reset={"v": "-v"}, name="bounce")])
    system = flow(System(states=["x", "v"], modes={"m": mode}))
    first = ns.simulate(system, {"x": 0.0, "v": 1.0}, times=[0.0, 1.0])
    second = ns.simulate(system, first, times=[1.0, 1.5])
    assert first.attrs["n_events"] + second.attrs["n_events"] == 1
    assert second["x"].values.tolist() == [1.0, 0.5]
    assert ns.simulate(system, second, times=[2.0])["x"].values.tolist() == [0.0]
