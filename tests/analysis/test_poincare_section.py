"""Points on sections against closed forms and independent integration."""

import mpmath
import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.system.section import with_section

section = ns.poincare_section


def oscillator(damping: float = 0.0) -> ns.System:
    return ns.System(
        states=["x", "v"], parameters={"c": damping}, equations={"x": "v", "v": "-x - c*v"}
    )


def ball(r: float = 0.5, **more) -> ns.System:
    bounce = ns.Exit("h", reset={"u": "-r*u"}, name="impact")
    return ns.System(
        states=["h", "u"],
        parameters={"r": r},
        modes={"flight": ns.Mode({"h": "u", "u": "-1"}, exits=[bounce])},
        initial={"h": 0.5},
        **more,
    )


# ------------------------------------------------------------------ closed forms


def test_harmonic_oscillator():
    points = section(oscillator(), {"x": 1.0}, section="v", direction=0, record=6)
    np.testing.assert_allclose(points["time"], np.pi * np.arange(1, 7), rtol=1e-14)
    np.testing.assert_allclose(points["x"], [-1, 1, -1, 1, -1, 1], rtol=1e-14)
    assert points["direction"].values.tolist() == [1, -1, 1, -1, 1, -1]
    assert np.all(points["v"] == 0.0)  # exactly on the section
    assert points["certified"].values.all() and points.attrs["certified"] == 1
    assert points.attrs["status"] == points.attrs["message"] == "completed"


@pytest.mark.parametrize(("direction", "first"), [(1, 1.0), (None, 1.0), (-1, 2.0)])
def test_direction(direction, first):
    points = section(oscillator(), {"x": 1.0}, section="v", direction=direction, record=4)
    np.testing.assert_allclose(points["time"], np.pi * (first + 2 * np.arange(4)), rtol=1e-14)


def test_damped_oscillator():
    """Maxima: v = 0 once in 2 pi / wd, each smaller by exp(-2 pi zeta / sqrt(1 - zeta^2))."""
    zeta = 0.1
    wd = np.sqrt(1 - zeta**2)
    points = section(oscillator(2 * zeta), {"v": 1.0}, section="v", direction=-1, record=20)
    first = np.arctan2(wd, zeta) / wd  # v(t) ~ cos(wd t) - zeta/wd sin(wd t)
    times = first + 2 * np.pi / wd * np.arange(20)
    np.testing.assert_allclose(points["time"], times, rtol=1e-13)
    np.testing.assert_allclose(points["x"], np.exp(-zeta * times), rtol=1e-12)


def test_impact_velocities_of_a_bouncing_ball():
    before = section(ball(), section="impact", record=12)
    after = section(ball(), section="impact", side="after", record=12)
    np.testing.assert_allclose(before["u"], -(0.5 ** np.arange(12)), rtol=1e-12)
    np.testing.assert_allclose(after["u"], 0.5 ** np.arange(1, 13), rtol=1e-12)
    times = 1.0 + 2.0 * np.cumsum(np.append(0.0, 0.5 ** np.arange(1, 12)))
    np.testing.assert_allclose(before["time"], times, rtol=1e-13)
    assert "direction" not in before
    assert before.attrs["section_kind"] == "event"


def test_a_jump_over_the_section_is_no_crossing():
    """Each impact takes u from below zero to above it; only the tops go through zero."""
    points = section(ball(), section="u", direction=0, t_end=2.8)
    tops = [1.0 + 0.5, 1.0 + 1.0 + 0.25, 1.0 + 1.5 + 0.125, 1.0 + 1.75 + 0.0625][:3]
    np.testing.assert_allclose(points["time"], tops, rtol=1e-13)
    np.testing.assert_allclose(points["h"], 0.5 * 0.25 ** np.arange(1, 4), rtol=1e-12)
    assert np.all(points["direction"] == -1)


def test_a_circle_is_crossed_by_a_spiral():
    """A section that is not linear in the states: the mode runs by Taylor series."""
    spiral = ns.System(states=["x", "y"], equations={"x": "0.1*x - 3*y", "y": "3*x + 0.1*y"})
    points = section(spiral, {"x": 0.2}, section="x**2 + y**2 = 1", t_end=60.0)
    t = np.log(5.0) / 0.1
    assert points.sizes["point"] == 1
    np.testing.assert_allclose(points["time"], [t], rtol=1e-13)
    np.testing.assert_allclose(points["x"], [np.cos(3 * t)], atol=1e-11)
    np.testing.assert_allclose(points["y"], [np.sin(3 * t)], atol=1e-11)
    none = section(spiral, {"x": 0.2}, section="1 - x**2 - y**2", direction=0, t_end=60.0)
    assert none["direction"].values.tolist() == [-1]


def test_forced_oscillator_against_mpmath():
    """x'' + 2 z x' + x = cos(w t): roots of x - cos(w t) / 2, which has t in it."""
    values = {"z": 0.05, "w": 1.7}
    system = ns.System(
        states=["x", "v"],
        parameters=values,
        period="2*pi/w",
        equations={"x": "v", "v": "cos(w*t) - 2*z*v - x"},
    )
    points = section(system, section="x - 0.5*cos(w*t)", direction=0, record=30)
    with mpmath.workdps(40):
        z, w = (mpmath.mpf(values[name]) for name in "zw")
        wd = mpmath.sqrt(1 - z**2)
        amplitude = 1 / (1 - w**2 + 2j * z * w)

        def state(t):
            steady = amplitude * mpmath.expj(w * t)
            a = -amplitude.real
            b = (-(1j * w * amplitude).real + z * a) / wd
            free = mpmath.exp(-z * t) * (a * mpmath.cos(wd * t) + b * mpmath.sin(wd * t))
            return steady.real + free

        def value(t):
            return state(t) - mpmath.cos(w * t) / 2

        grid = [mpmath.mpf(k) / 50 for k in range(1, 4000)]
        signs = [mpmath.sign(value(t)) for t in grid]
        brackets = [k for k in range(len(grid) - 1) if signs[k] != signs[k + 1]][:30]
        roots = [
            mpmath.findroot(value, (grid[k], grid[k + 1]), solver="anderson") for k in brackets
        ]
        truth = np.array([[float(t), float(state(t))] for t in roots])
    np.testing.assert_allclose(points["time"], truth[:, 0], rtol=1e-13)
    np.testing.assert_allclose(points["x"], truth[:, 1], atol=1e-13)
    period = 2 * np.pi / values["w"]
    assert points.attrs["period"] == pytest.approx(period, rel=1e-15)
    together = points["period_number"] * period + points["phase"]
    np.testing.assert_allclose(together, points["time"], rtol=1e-15)


def test_chua_against_scipy():
    chua = ns.models.chua()
    p = chua.parameter_values
    start = {"x": 0.1, "y": 0.05, "z": -0.1}
    points = section(chua, start, section="y - 0.02", direction=0, record=12)
    names = list(chua.states)
    assert names == ["x", "y", "z"]

    def field(_, s):
        x, y, z = s
        f = p["m1"] * x + 0.5 * (p["m0"] - p["m1"]) * (abs(x + 1) - abs(x - 1))
        return [p["alpha"] * (y - x - f), x - y + z, -p["beta"] * y]

    def event(_, s):
        return s[1] - 0.02

    found = solve_ivp(
        field, (0, float(points["time"][-1]) + 0.1), [0.1, 0.05, -0.1], method="DOP853",
        rtol=1e-13, atol=1e-14, events=event, max_step=0.02,
    )  # fmt: skip
    np.testing.assert_allclose(points["time"], found.t_events[0][:12], atol=1e-8)
    truth = found.y_events[0][:12]
    for k, name in enumerate(names):
        np.testing.assert_allclose(points[name], truth[:, k], atol=1e-8)


# ------------------------------------------------------------------ modes, cells, slaved states


def test_a_section_at_a_switch_meets_every_switch():
    """The section and the stop lie at the same place: as many crossings as impacts."""
    system = ns.models.soft_impact()
    points = section(system, section="x - e", transient=20, record=100)
    impacts = section(system, section="impact", transient=20, record=100)
    np.testing.assert_allclose(points["time"], impacts["time"], rtol=1e-11)
    np.testing.assert_allclose(points["v"], impacts["v"], rtol=1e-7)
    assert set(points["mode"].values) == {0}  # free, just before


def test_a_section_in_the_wall_is_not_crossed():
    wall = ball()
    with pytest.warns(ns.RunWarning, match="nothing crosses"):
        points = section(wall, section="h", direction=0, t_end=2.9)
    assert points.sizes["point"] == 0


PIECEWISE = ns.System(
    states=["x", "v"],
    parameters={"w": 1.1},
    period="2*pi/w",
    outputs={"push": "8*max(x - 1, 0)"},
    modes={
        "flow": ns.Mode(
            {"x": "v", "v": "3*cos(w*t) - 0.1*v - x - push - 0.2*sign(x + 2)"},
            cells={"++": "right", "-+": "middle"},
        )
    },
)


@pytest.mark.parametrize("text", ["v", "x - 1", "abs(x) - 0.4", "rate(v)", "push - 0.3"])
def test_names_are_those_of_the_system(text):
    run = ns.simulate(PIECEWISE, periods=30, samples_per_period=4000)
    points = section(PIECEWISE, section=text, direction=0, t_end=float(run["time"][-1]))
    assert points["mode"].attrs["flag_meanings"] == run["mode"].attrs["flag_meanings"]
    value = {
        "v": run["v"],
        "x - 1": run["x"] - 1,
        "abs(x) - 0.4": abs(run["x"]) - 0.4,
        "rate(v)": 3 * np.cos(1.1 * run["time"])
        - 0.1 * run["v"]
        - run["x"]
        - run["push"]
        - 0.2 * np.sign(run["x"] + 2),
        "push - 0.3": run["push"] - 0.3,
    }[text].values
    sign = np.sign(value)
    sign[sign == 0] = 1
    k = np.flatnonzero(np.diff(sign))
    if text == "rate(v)":  # jumps over zero at x = -2 are none
        jumps = np.abs(np.diff(value))[k] > 0.1
        k = k[~jumps]
    assert k.size == points.sizes["point"] > 10
    time = run["time"].values
    assert np.all((time[k] <= points["time"]) & (points["time"] <= time[k + 1]))
    assert np.array_equal(np.sign(np.diff(sign)[k]), points["direction"])
    # just before an instant the mode may differ from a sample's only where a switch comes between
    same = run["mode"].values[k] == run["mode"].values[k + 1]
    assert same.sum() > 10 or text in ("x - 1",)
    assert np.array_equal(points["mode"].values[same], run["mode"].values[k][same])


def test_slaved_modes_and_drift():
    mole = ns.models.moling(a=0.3, b=0.15, xi=0.05, omega=0.1)
    run = ns.simulate(mole, periods=20, samples_per_period=2000)
    for text in ("y", "p + 0.1*y"):
        points = section(mole, section=text, direction=0, t_end=float(run["time"][-1]))
        value = run["y"].values if text == "y" else (run["p"] + 0.1 * run["y"]).values
        changes = np.flatnonzero(np.diff(np.sign(value[1:])))
        assert points.sizes["point"] == changes.size > 10
    late = ns.simulate(mole, times=points["time"].values)
    for name in (*mole.states, *mole.outputs):
        np.testing.assert_allclose(points[name], late[name], atol=1e-9)
    once = section(mole, section="v - 100", direction=0, t_end=float(run["time"][-1]))
    assert once.sizes["point"] == 1
    assert float(once["v"][0]) == 100.0


STICKS = ns.System(
    states=["x", "v"],
    parameters={"N": 1.0, "rest": 1.6, "belt": 0.5},
    definitions={"spring": "-x"},
    modes={
        "back": ns.Mode(
            {"x": "v", "v": "-x + N"}, exits=[ns.Exit("belt - v", to="stick", name="catch")]
        ),
        "stick": ns.Mode(
            {"x": "belt"}, slaved={"v": "belt"}, exits=[ns.Exit("rest - x", to="back", name="slip")]
        ),
    },
)


def test_motion_that_stays_on_the_section_does_not_cross_it():
    """Relative velocity is negative, then zero while the block sticks, then negative again."""
    start = {"x": 1.6, "v": 0.5}
    with pytest.warns(ns.RunWarning, match="nothing crosses"):
        points = section(STICKS, start, mode="stick", section="v - belt", direction=0, t_end=60.0)
    assert points.sizes["point"] == 0
    catches = section(STICKS, start, mode="stick", section="catch", record=5)
    entered = section(STICKS, start, mode="stick", section="stick", record=5)
    np.testing.assert_array_equal(catches["time"], entered["time"])
    assert np.all(np.abs(catches["v"] - 0.5) < 1e-14)


def test_a_section_that_is_constant_in_some_modes():
    """Where the block sticks, v - 0.2 does not change; elsewhere it is crossed as ever."""
    start = {"x": 1.6, "v": 0.5}
    points = section(STICKS, start, mode="stick", section="v = 0.2", direction=0, record=6)
    assert points["direction"].values.tolist() == [-1, 1] * 3
    # on the circle around x = 1 through (1.6, 0.5)
    radius = np.hypot(points["x"] - 1.0, points["v"])
    np.testing.assert_allclose(radius, np.hypot(0.6, 0.5), rtol=1e-12)


def test_the_start_may_choose_its_mode():
    both = ns.System(
        states=["x", "v"],
        modes={
            "slow": ns.Mode({"x": "v", "v": "-x"}, exits=[ns.Exit("x + 9", to="stop")]),
            "fast": ns.Mode({"x": "v", "v": "-4*x"}, exits=[ns.Exit("x + 9", to="stop")]),
        },
    )
    for mode, period in [("slow", 2 * np.pi), ("fast", np.pi), (None, 2 * np.pi)]:
        points = section(both, {"v": 1.0}, mode=mode, section="x", record=3)
        np.testing.assert_allclose(points["time"], period * np.arange(1, 4), rtol=1e-14)


# ------------------------------------------------------------------ definitions, signals, contacts


def test_definitions_and_outputs_are_sections():
    system = ns.System(
        states=["x", "v"],
        definitions={"energy": "0.5*v**2 + 0.5*x**2"},
        outputs={"half": "0.5*x"},
        equations={"x": "v", "v": "-x - 0.2*v"},
    )
    points = section(system, {"x": 1.0}, section="half", direction=0, record=4)
    assert np.all(np.abs(points["half"]) < 1e-16)
    falling = section(system, {"x": 1.0}, section="energy - 0.1", direction=0, t_end=40.0)
    assert falling["direction"].values.tolist() == [-1]
    x, v = float(falling["x"][0]), float(falling["v"][0])
    assert 0.5 * (x**2 + v**2) == pytest.approx(0.1, rel=1e-14)


def test_signals():
    """x' = base, so x is the integral of the signal: x = (1 - cos t) up to the spline."""
    knots = np.linspace(0.0, 20.0, 4001)
    base = ns.Signal(knots, np.sin(knots))
    system = ns.System(states=["x"], equations={"x": "base"}, signals={"base": base})
    with pytest.warns(ns.RunWarning, match="of 1000 points until t = 20"):
        points = section(system, section="base", direction=0)  # until the signal ends
    np.testing.assert_allclose(points["time"], np.pi * np.arange(1, 7), atol=1e-10)
    points = section(system, section="x - 0.5", direction=1, t_end=19.0)
    times = np.arccos(0.5) + 2 * np.pi * np.arange(3)
    np.testing.assert_allclose(points["time"], times, atol=1e-9)


def test_a_rate_that_jumps_over_zero_at_a_knot_is_no_crossing():
    saw = ns.Signal([0.0, 1.0, 3.0, 5.0], [0.0, 1.0, -1.0, 1.0], method="linear")
    system = ns.System(states=["x"], equations={"x": "saw"}, signals={"saw": saw})
    with pytest.warns(ns.RunWarning, match="nothing crosses"):
        points = section(system, section="rate(saw)", direction=0, t_end=4.9)
    assert points.sizes["point"] == 0


def test_contacts_are_flagged_and_not_invented():
    with pytest.warns(ns.RunWarning, match="touches section = 'x - 1' 5 times"):
        points = section(oscillator(), {"v": 1.0}, section="x - 1", direction=0, t_end=30.0)
    assert points.sizes["point"] == 0
    assert points.attrs["n_uncertain"] == points.attrs["n_grazes"] == 5
    assert points.attrs["certified"] == 0
    inside = section(oscillator(), {"v": 1.0}, section="x - 0.999999", direction=0, t_end=30.0)
    assert inside["certified"].values.all()
    near = np.repeat(np.pi / 2 + 2 * np.pi * np.arange(5), 2)
    near += np.tile([-1.0, 1.0], 5) * np.arccos(0.999999)
    np.testing.assert_allclose(inside["time"], near, atol=1e-9)


# ------------------------------------------------------------------ protocol


def test_a_start_on_the_section_does_not_count():
    for initial in ({"v": 1.0}, {"v": -1.0}):
        points = section(oscillator(), initial, section="x", direction=0, record=2)
        np.testing.assert_allclose(points["time"], [np.pi, 2 * np.pi], rtol=1e-14)


def test_the_transient_is_dropped_and_changes_nothing():
    duffing = ns.models.duffing()
    whole = section(duffing, section="v", record=400)
    late = section(duffing, section="v", transient=10.25, record=100)
    first = int(np.searchsorted(whole["time"], 10.25 * whole.attrs["period"]))
    for name in ("x", "v", "time", "phase"):
        assert np.array_equal(late[name], whole[name][first : first + 100])
    bell = oscillator(0.1)
    late = section(bell, {"x": 1.0}, section="v", transient=10.0, record=3)
    assert float(late["time"][0]) > 10.0 > float(late["time"][0]) - 2.1 * np.pi


def test_more_points_begin_with_the_same():
    chua = ns.models.chua()
    few = section(chua, {"x": 0.1}, section="y", record=50)
    many = section(chua, {"x": 0.1}, section="y", record=500)
    for name in chua.states:
        assert np.array_equal(few[name], many[name][:50])


def test_runs_and_points_are_starts():
    system = ns.models.soft_impact()
    run = ns.simulate(system, periods=7.3)
    whole = section(system, section="v", record=30)
    rest = section(system, run, section="v", record=10)
    first = int(np.searchsorted(whole["time"], run.attrs["end_number"] * run.attrs["window"]))
    while float(whole["time"][first]) < 7.3 * run.attrs["period"]:
        first += 1
    np.testing.assert_allclose(rest["time"], whole["time"][first : first + 10], rtol=1e-10)
    events = section(system, run, section="release", record=3)
    assert float(events["time"][0]) > 7.3 * run.attrs["period"]
    point = whole.isel(point=4)
    again = ns.simulate(system, point, times=whole["time"].values[4:8])
    np.testing.assert_allclose(again["x"], whole["x"][4:8], rtol=1e-9)


def test_results_survive_a_file(tmp_path):
    points = section(
        ns.models.duffing(), section="v", record=20, parameters={"damping": 0.3}
        if "damping" in ns.models.duffing().parameters else None,
    )  # fmt: skip
    file = tmp_path / "points.nc"
    points.to_netcdf(file, engine="h5netcdf")
    xr.testing.assert_identical(xr.load_dataset(file, engine="h5netcdf"), points)


def test_parameters_are_changed_and_noted():
    points = section(oscillator(), {"v": 1.0}, section="x", parameters={"c": 0.2}, record=2)
    assert points.attrs["changed_parameters"] == "{'c': 0.2}"
    wd = np.sqrt(1 - 0.01)
    np.testing.assert_allclose(points["time"], 2 * np.pi / wd * np.arange(1, 3), rtol=1e-14)


def test_nothing_found_is_an_empty_result():
    with pytest.warns(ns.RunWarning, match=r"'x - 5' upward.*direction=0 or a later t_end="):
        points = section(oscillator(), {"x": 1.0}, section="x - 5")
    assert points.sizes["point"] == 0
    assert points.attrs["status"] == "time_limit"
    assert set(points.data_vars) == {"x", "v", "mode", "direction", "certified"}


def test_runs_that_end_early_keep_what_is_there():
    with pytest.warns(ns.RunWarning, match="event_limit"):
        points = section(ball(), section="impact")
    assert points.attrs["status"] == "event_limit"
    np.testing.assert_allclose(points["u"][:15], -(0.5 ** np.arange(15)), rtol=1e-9)
    stops = ns.System(
        states=["x"], modes={"go": ns.Mode({"x": "1"}, exits=[ns.Exit("2 - x", to="stop")])}
    )
    with pytest.warns(ns.RunWarning, match=r"stopped at t = 2, 1 of 1000"):
        points = section(stops, section="x - 1")
    assert points["time"].values.tolist() == [1.0]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"section": "w"}, "unknown variable or event 'w'.*known: c, t, v, x"),
        ({"section": "x - w"}, "unknown name 'w'"),
        ({"section": "x -"}, "section"),
        ({"section": ""}, "give an expression, such as 'x'"),
        ({"section": 3}, "give an expression, such as 'x'"),
        ({"section": "c - 1"}, "does not change along the motion in any mode"),
        ({"section": "x - x"}, "does not change along the motion in any mode"),
        ({"section": "sin(x)**2 + cos(x)**2"}, "does not change along the motion in any mode"),
        ({"section": "rate(x) - v"}, "does not change along the motion in any mode"),
        ({"section": "v", "direction": 2}, "direction = 2: give 1"),
        ({"section": "v", "side": "both"}, "side = 'both'"),
        ({"section": "v", "record": 0}, "record = 0"),
        ({"section": "v", "transient": -1}, "transient = -1"),
        ({"section": "v", "transient": 5.0, "t_end": 4.0}, "points count from t = 5"),
        ({"section": "v", "mode": "flight"}, "unknown mode 'flight'"),
        ({"section": "1/c - x"}, "c|finite"),
    ],
)
def test_wrong_options(options, message):
    with pytest.raises((ns.OptionError, ns.ModelError), match=message):
        section(oscillator(), **options)


@pytest.mark.parametrize("count", [2, 3, 7])
@pytest.mark.parametrize("period", ["0.7", "2*pi"])
def test_a_point_at_the_end_of_a_period_begins_the_next(period, count):
    decay = ns.System(states=["x"], period=period, equations={"x": "-x"})
    found = section(decay, {"x": 1.0}, section=f"t - {count}*({period})", record=1)
    assert int(found["period_number"][0]) == count
    assert float(found["phase"][0]) < 1e-14


def test_more_wrong_options():
    with pytest.raises(ns.OptionError, match="the event 'impact' has no direction"):
        section(ball(), section="impact", direction=1)
    with pytest.raises(
        ns.OptionError, match="fits no mode of 'system':\n  flight: guard 'h' is -1"
    ):
        section(ball(), {"h": -1.0}, section="u")
    rotor = ns.models.clearance_rotor()
    with pytest.raises(ns.OptionError, match="at the start it has no finite value or derivative"):
        section(rotor, section="radius - 0.5")
    forced = ns.models.duffing()
    with pytest.raises(ns.OptionError, match=r"section = .*: with it, period = .* is not") as e:
        section(forced, section="x - cos(0.3*t)")
    assert "__above" not in str(e.value)


def test_an_interruption_keeps_what_is_there(monkeypatch):
    from nonsmooth.runs import section_search

    calls = []
    run_plan = section_search.run_plan

    def interrupted(*arguments, **options):
        calls.append(1)
        if len(calls) == 4:
            raise KeyboardInterrupt
        return run_plan(*arguments, **options)

    monkeypatch.setattr(section_search, "run_plan", interrupted)
    with pytest.warns(ns.RunWarning, match="interrupted at t"):
        points = section(oscillator(), {"x": 1.0}, section="v", record=100_000)
    assert points.attrs["status"] == "interrupted"
    n = points.sizes["point"]
    assert n > 10
    np.testing.assert_allclose(points["time"], np.pi * (1 + 2 * np.arange(n)), rtol=1e-13)


def test_a_start_later_than_zero():
    forced = ns.System(
        states=["x", "v"],
        period="2*pi/w",
        parameters={"w": 2.0},
        equations={"x": "v", "v": "cos(w*t) - x - 0.1*v"},
    )
    points = section(forced, {"x": 0.3}, t_start=5.0, section="x", direction=0, record=8)
    assert np.all(points["time"] > 5.0)
    run = ns.simulate(forced, {"x": 0.3}, t_start=5.0, times=points["time"].values)
    np.testing.assert_allclose(run["x"], 0.0, atol=1e-14)
    np.testing.assert_allclose(run["v"], points["v"], atol=1e-13)


def test_sections_of_one_system_do_not_depend_on_each_other():
    """Each has the modes that it has in a system that was made for it alone."""
    system = ns.models.percussive_drilling()
    names = (*system.states, *system.outputs)
    for name in names:
        alone = with_section(ns.models.percussive_drilling(), f"{name} - 0.123")
        found = with_section(system, f"{name} - 0.123")
        assert list(found.system.modes) == list(alone.system.modes), name
        assert found.side.tolist() == alone.side.tolist(), name
    accelerations = with_section(system, "acceleration - 0.123")
    assert {"flight__above", "progression__above", "stick"} <= set(accelerations.system.modes)


def test_what_a_surface_keeps_crosses_nothing_on_it():
    """The chip does not slip on the tool where it sticks, whatever its long rate looks like."""
    slip = with_section(ns.models.metal_cutting(), "v_f - 0.1")
    names = [forms.name for forms in slip.system.structure.running]
    kept = [name for name, side in zip(names, slip.side, strict=True) if side == 0]
    assert kept == [f"flow__{side}[+{v_r}0]" for side in ("above", "below") for v_r in "+0"]


def test_too_many_cells_are_refused(monkeypatch):
    monkeypatch.setattr("nonsmooth.system.compile.structure.MOST_MODES", 10)
    many = " + ".join(f"abs(x - {k})" for k in range(6))
    system = ns.System(states=["x", "v"], equations={"x": "v", "v": f"-({many})"})
    with pytest.raises(ns.OptionError, match=r"section = 'v': with it, mod.*14.*at most 10"):
        section(system, section="v")


def test_a_motion_that_comes_to_rest_on_the_section():
    """Its amplitude falls by exp(-0.1 t): below the last digit of x at t = 370."""
    bell = ns.System(states=["x", "v"], equations={"x": "v", "v": "1 - x - 0.2*v"})
    with pytest.warns(ns.RunWarning, match="comes to rest on the section"):
        points = section(bell, section="x - 1", direction=0)
    assert points.attrs["status"] == "at_rest"
    sure = points["time"].values[points["certified"].values]
    wd = np.sqrt(0.99)
    first = (np.pi - np.arctan2(wd, 0.1)) / wd  # of cos(wd t) + 0.1/wd sin(wd t) = 0
    assert sure.size > 80
    early = sure[:60]
    truth = first + np.pi / wd * np.arange(60)
    np.testing.assert_allclose(early, truth, atol=1e-5)
    np.testing.assert_allclose(early[:20], truth[:20], atol=1e-11)


# ------------------------------------------------------------------ at rest


def test_a_force_of_rest_against_its_closed_form():
    """1 - Gamma sin(t) on a table that never throws the ball; the mode it flies in has none."""
    table = ns.models.bouncing_ball(Gamma=0.5)
    start = {"y": 0.0, "v": 0.5}
    points = section(table, start, section="table_force = 1.25", direction=0, record=4)
    first = np.pi + np.arcsin(0.5)  # sin(t) = -1/2
    expected = [first, 3 * np.pi - first, first + 2 * np.pi, 5 * np.pi - first]
    np.testing.assert_allclose(points["time"], expected, rtol=1e-14)
    assert points["direction"].values.tolist() == [1, -1, 1, -1]
    assert set(points["mode"].values) == {1}  # at rest before and behind


def test_a_crossing_at_rest_is_no_new_arrival():
    """What stands on the table is not struck again where the section is crossed."""
    split = with_section(ns.models.bouncing_ball(Gamma=0.5), "table_force = 1.25")
    run = ns.simulate(split.system, {"y": 0.0, "v": 0.5}, t_end=10.0)
    crossed = run["event_name"].values == "section"
    assert crossed.sum() == 3
    assert set(run["event_path"].values[crossed]) == {"section"}
    assert set(run["event_kind"].values[crossed]) == {"switch"}


def test_contacts_that_differ_are_not_taken_for_each_other():
    """Behind a switch to another wall what rested is free, and here the new wall is elsewhere."""
    hit = {"reset": {"v": "-r*v"}, "sticks": "rest", "name": "impact"}
    there = {**hit, "sticks": "lower"}
    system = ns.System(
        states=["y", "v"],
        parameters={"r": 0.5},
        period="2*pi",
        modes={
            "above": ns.Mode(
                {"y": "v", "v": "-1"}, exits=[ns.Exit("y", **hit), ns.Exit("cos(t)", to="below")]
            ),
            "below": ns.Mode({"y": "v", "v": "-1"}, exits=[ns.Exit("y + 2", **there)]),
        },
    )
    run = ns.simulate(system, {"y": 0.0, "v": 0.0}, times=[1.0, np.pi / 2 + 1.0])
    np.testing.assert_allclose(run["y"], [0.0, -0.5], atol=1e-14)
