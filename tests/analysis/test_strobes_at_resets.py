"""Strobes that fall on a reset or a switch up to rounding hold the state before it.

A clock c' = 1/T that is reset at c = 1 comes to its reset a rounding before the strobe or behind
it. The truth is the map of the sampled system written by hand, and closed forms.
"""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.errors import OptionError
from nonsmooth.plot.trace import curve

DECAY = np.exp(-1.0)  # of x over a period
ENDS = [1.0, 1.0 / 3.0, 0.37, 4e-4, 7e-4]  # lengths of a period


def sampled(T, k=4.5):
    """Once per period x jumps by the logistic map; in between it goes towards 1."""
    flow = {"x": "(1-x)/T", "c": "1/T"}
    clock = ns.Exit("1-c", to="low", reset={"c": "0", "x": "k*x*(1-x)"}, name="clock")
    return ns.System(
        states=["x", "c"],
        parameters={"k": k, "T": T},
        period="T",
        initial={"x": 0.3},
        modes={
            "low": ns.Mode(flow, exits=[ns.Exit("0.5-x", to="high", name="middle"), clock]),
            "high": ns.Mode(flow, exits=[clock]),
        },
    )


def by_hand(k, x, count):
    """States just before the jumps."""
    points = []
    for _ in range(count):
        points.append(1.0 - (1.0 - x) * DECAY)
        x = k * points[-1] * (1.0 - points[-1])
    return np.array(points)


def square_wave(T):
    """A low pass filter driven by a square wave whose edges lie at the phases 0 and 1/2."""
    return ns.System(
        states=["x"],
        parameters={"T": T, "k": 2.0},
        period="T",
        modes={
            "on": ns.Mode({"x": "(k-x)/T"}, exits=[ns.Exit("sin(2*pi*t/T)", to="off")]),
            "off": ns.Mode({"x": "-x/T"}, exits=[ns.Exit("-sin(2*pi*t/T)", to="on")]),
        },
    )


def buck(V):
    """A buck converter in voltage mode, whose ramp is a clock that is reset (Hamill et al.)."""
    clock = {"reset": {"c": "0"}, "name": "clock"}

    def flow(switch):
        return {"vc": "il/C - vc/(R*C)", "il": f"({switch} - vc)/L", "c": "1/T"}

    return ns.System(
        states=["vc", "il", "c"],
        parameters={"V": V, "R": 22.0, "L": 0.02, "C": 47e-6, "T": 400e-6},
        initial={"vc": 12.0, "il": 0.55},
        definitions={"ahead": "3.8 + 4.4*c - 8.4*(vc - 11.3)"},
        period="T",
        modes={
            "on": ns.Mode(
                flow("V"), exits=[ns.Exit("1-c", to="on", **clock), ns.Exit("ahead", to="off")]
            ),
            "off": ns.Mode(
                flow("0"), exits=[ns.Exit("1-c", to="off", **clock), ns.Exit("-ahead", to="on")]
            ),
        },
    )


def wave_at(phase):
    """Its periodic motion at the phases 0 and 1/2, in closed form."""
    half = np.exp(-0.5)
    low = 2.0 * (1.0 - half) * half / (1.0 - half**2)
    return low if phase == 0.0 else low / half


@pytest.mark.parametrize("T", ENDS)
@pytest.mark.parametrize("k", [4.5, 5.5])
def test_strobes_are_those_of_the_map_by_hand(T, k):
    system = sampled(T, k)
    found = ns.stroboscopic_map(system, transient=500, record=8)
    expected = by_hand(k, 0.3, 520)[-16:]
    # a cycle of period two or four, whichever strobe comes first
    assert np.allclose(np.sort(found["x"]), np.sort(expected[-8:]), rtol=0, atol=1e-9)
    assert np.allclose(found["c"], 1.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("T", ENDS)
def test_a_clock_that_drifts_stays_before_its_reset(T):
    run = ns.simulate(sampled(T), periods=20_000, samples_per_period=1)
    # 1/T is off by half a rounding, so the clock by as much in each period
    assert np.allclose(run["c"].values[1:], 1.0, rtol=0, atol=20_000 * np.finfo(float).eps)


@pytest.mark.parametrize("T", ENDS)
def test_periods_and_multipliers_are_those_of_the_map_by_hand(T):
    system = sampled(T)
    a, b = by_hand(4.5, 0.3, 600)[-2:]
    multiplier = DECAY**2 * 4.5**2 * (1.0 - 2.0 * a) * (1.0 - 2.0 * b)
    seen = ns.regime(system)
    assert (seen["regime"].item(), seen["period"].item()) == ("periodic", 2)
    assert seen["multiplier_modulus"].values[0] == pytest.approx(abs(multiplier), abs=1e-9)
    assert seen["events"].item() == pytest.approx(1.5)  # x passes 1/2 in every other period


def test_columns_of_a_diagram_are_all_alike():
    # beside the length of a period the motion is the same at all of them
    lengths = np.linspace(1e-4, 1e-3, 200)
    found = ns.bifurcation_diagram(sampled(1e-3), "T", lengths, transient=300, record=40)
    assert np.unique(found["period"]).tolist() == [2]
    pair = np.sort(by_hand(4.5, 0.3, 600)[-2:])
    points = np.sort(found["x"].values[:, 0, :2], axis=1)
    assert np.allclose(points, pair, rtol=0, atol=1e-9)
    assert np.allclose(found["events"], 1.5, rtol=0, atol=1e-12)


@pytest.mark.parametrize(("V", "period"), [(23.0, 1), (24.0, 1), (28.0, 2), (30.5, 2)])
def test_the_buck_converter_has_the_same_regime_at_any_phase(V, period):
    for phase in (0.0, 0.5):  # nothing falls on the second one
        seen = ns.regime(buck(V), phase=phase)
        assert (seen["regime"].item(), seen["period"].item()) == ("periodic", period)


@pytest.mark.parametrize("T", ENDS)
def test_runs_that_go_on_at_a_reset_lose_and_double_no_event(T):
    system = sampled(T)
    whole = ns.simulate(system, periods=40, samples_per_period=1)
    run = ns.simulate(system, periods=1, samples_per_period=1)
    times, names, ends = ([run[each].values] for each in ("event_time", "event_name", "x"))
    for _ in range(39):
        run = ns.simulate(system, run, periods=1, samples_per_period=1)
        times.append(run["event_time"].values[1:])
        names.append(run["event_name"].values[1:])
        ends.append(run["x"].values)
    assert np.array_equal(np.concatenate(times), whole["event_time"])
    # the one at the very end comes behind it
    assert np.count_nonzero(np.concatenate(names) == "clock") == 39
    ends = [each[-1] for each in ends]
    assert np.array_equal(ends, whole["x"].values[1:])
    assert np.allclose(ends, by_hand(4.5, 0.3, 40), rtol=0, atol=1e-10)


@pytest.mark.parametrize("T", ENDS)
def test_the_curve_of_a_clock_falls_at_its_resets_alone(T):
    run = ns.simulate(sampled(T), periods=50, samples_per_period=4)
    found = curve(run, ["c"])
    falls = np.diff(found.values[0]) < -1e-9
    assert np.all(found.jumps[:-1][falls])
    assert falls.sum() == 49


@pytest.mark.parametrize("T", ENDS)
def test_words_of_single_periods_are_all_alike(T):
    run = ns.simulate(square_wave(T), periods=60, samples_per_period=1)
    words = {ns.phase_word(run, k * T, (k + 1) * T) for k in range(10, 59)}
    assert words == {("on", "off")}
    assert run.attrs["phase_word"] == "on off"


@pytest.mark.parametrize("T", ENDS)
@pytest.mark.parametrize("phase", [0.0, 0.5])
def test_the_orbit_of_a_square_wave_begins_at_an_edge(T, phase):
    system = square_wave(T)
    orbit = ns.find_orbit(system, phase=phase)
    assert orbit.attrs["status"] == "completed"
    assert orbit["x"].item() == pytest.approx(wave_at(phase), abs=1e-13)
    assert orbit["multipliers"].values == pytest.approx([DECAY], abs=1e-12)
    seen = ns.regime(system, phase=phase)
    assert (seen["regime"].item(), seen["period"].item()) == ("periodic", 1)
    assert seen["events"].item() == 2.0


def test_the_branch_of_a_square_wave_begins_at_an_edge():
    branch = ns.continue_orbit(square_wave(0.4), "k", (1.0, 3.0))
    assert (branch.attrs["end_first"], branch.attrs["end_last"]) == ("bound", "bound")
    expected = wave_at(0.0) * branch["k"].values / 2.0
    assert np.allclose(branch["x"], expected, rtol=0, atol=1e-12)


def test_all_orbits_of_a_square_wave():
    found = ns.orbits(square_wave(1.0), longest=2, samples=10)
    assert found["period"].values.tolist() == [1]
    assert found["x"].values.ravel()[0] == pytest.approx(wave_at(0.0), abs=1e-12)


def test_a_sample_that_is_behind_by_more_than_rounding_holds_the_state_after():
    system = sampled(1.0)
    for late in (1e-12, 1e-9):
        run = ns.simulate(system, times=[1.0, 1.0 + late, 2.0])
        assert run["c"].values[1] == pytest.approx(late, rel=1e-3)


def test_the_window_of_a_system_without_a_period_sets_no_bound_for_quick_events():
    # walls 1e-12 apart are hit every 1e-12: the window is 64
    gap = 1e-12
    reset = {"v": "-v"}
    system = ns.System(
        states=["x", "v"],
        modes={
            "m": ns.Mode(
                {"x": "v", "v": "0"},
                exits=[ns.Exit(f"{gap} - x", reset=reset), ns.Exit("x", reset=reset)],
            )
        },
    )
    times = np.array([0.25, 0.75, 1.75, 2.75]) * gap
    run = ns.simulate(system, {"x": 0.5 * gap, "v": 1.0}, times=times)
    assert run["v"].values.tolist() == [1.0, -1.0, 1.0, -1.0]


@pytest.mark.slow
@pytest.mark.parametrize("phase", [0.0, 0.5])
def test_what_repeats_at_a_phase_that_nothing_holds_is_no_torus(phase):
    # two starts a little apart in c stay so: a family of cycles, each of period two
    found = ns.attractors(
        ns.StroboscopicMap(buck(28.0), phase=phase),
        {"vc": (11.5, 12.5), "il": (0.4, 0.8)},
        completion={"c": phase},
        samples=20,
        record=2000,
    )
    assert found.sizes["attractor"] == 0
    assert "PoincareMap" in found.attrs["message"]
    section = ns.attractors(
        ns.PoincareMap(buck(28.0), "clock"), {"vc": (11.5, 12.5), "il": (0.4, 0.8)}, samples=20
    )
    assert section["kind"].values.tolist() == ["periodic"]
    assert section["period"].values.tolist() == [2]


def thrown(T=1.0):
    """A ball on a table that throws it up whenever the clock says so."""
    throw = ns.Exit("T-c", to="up", reset={"c": "c-T", "x": "0", "v": "g*T/2"}, name="throw")
    return ns.System(
        states=["x", "v", "c"],
        parameters={"T": T, "g": 9.81},
        period="T",
        initial={"c": "T/4", "v": "g*T/4", "x": "3*g*T*T/32"},
        modes={"up": ns.Mode({"x": "v", "v": "-g", "c": "1"}, exits=[throw])},
    )


@pytest.mark.parametrize("T", ENDS)
def test_orbits_with_a_clock_have_the_strobes_of_the_map_by_hand(T):
    orbit = ns.find_orbit(sampled(T))
    strobes = orbit["strobes"].values
    assert np.allclose(np.sort(strobes[:, 0]), np.sort(by_hand(4.5, 0.3, 600)[-2:]), atol=1e-9)
    assert np.allclose(strobes[:, 1], 1.0, rtol=0, atol=1e-12)  # before the reset
    assert np.allclose(np.diff(orbit["strobe_times"]), T, rtol=1e-12)


@pytest.mark.parametrize("phase", [0.0, 0.1, 0.7])
def test_strobes_with_a_clock_are_those_of_a_run_from_the_declared_start(phase):
    for system in (buck(28.0), thrown()):
        orbit = ns.find_orbit(system, phase=phase)
        run = ns.stroboscopic_map(
            system, phase=phase, transient=4000, record=orbit["strobes"].shape[0]
        )
        for i, name in enumerate(system.states):
            found, motion = np.sort(orbit["strobes"].values[:, i]), np.sort(run[name].values)
            assert np.allclose(found, motion, rtol=1e-9, atol=1e-12), name


def test_a_velocity_under_gravity_is_no_clock_though_impacts_set_it_back_by_as_much():
    # v falls by g in a unit of time, and each throw adds g*T: but the throw reads the clock
    strobes = ns.find_orbit(thrown())["strobes"].values
    t = 0.25  # the clock at the start of a run
    expected = [[9.81 * t * (1.0 - t) / 2.0, 9.81 * (0.5 - t), t]]
    assert np.allclose(strobes, expected, rtol=0, atol=1e-12)


def test_a_cycle_that_no_clock_holds_has_no_strobes():
    belt = ns.models.belt_oscillator()
    length = float(ns.find_orbit(belt)["length"])
    texts = belt.to_toml().splitlines()
    texts.insert(2, f"period = {length!r}")
    assert "strobes" not in ns.find_orbit(ns.System.from_toml("\n".join(texts) + "\n"))


def test_a_branch_with_a_clock_over_a_diagram_has_a_curve_for_each_strobe():
    system = buck(24.0)
    first = ns.continue_orbit(system, "V", (24.0, 26.0))
    branch = ns.continue_orbit(system, "V", (24.0, 26.0), initial=first, special=1)
    behind = ns.bifurcation_diagram(system, "V", [25.0, 25.5, 26.0], transient=2000, record=8)
    ax = ns.plot.branch(branch, "vc", diagram=behind)
    drawn = [line.get_xydata() for line in ax.lines if line.get_gid() == "branch 0"]
    for k, value in enumerate(behind["parameter"].values):
        for point in np.unique(np.round(behind["vc"].values[k], 9)):
            near = [np.interp(value, *xy.T) for xy in map(_in_order, drawn) if xy.size]
            # between its points a curve is drawn within a part of a percent of what it spans
            assert np.min(np.abs(np.array(near) - point)) < 1e-3
    plt.close(ax.figure)


def _in_order(xy):
    xy = xy[np.isfinite(xy).all(axis=1)]
    return xy[np.argsort(xy[:, 0])]


def test_a_bifurcation_picture_of_a_system_with_a_clock_says_what_to_draw():
    with pytest.raises(OptionError, match=r"reads the time.*plot\.branch"):
        ns.bifurcation_picture(buck(24.0), "V", (22.0, 28.0), {"vc": (11.0, 13.0)})
