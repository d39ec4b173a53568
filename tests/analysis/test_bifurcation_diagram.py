"""Bifurcation diagrams beside closed forms, and what they promise about protocols."""

import threading

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth import Exit, Mode, ModelError, OptionError, System


def linear():
    """x'' + 2 zeta x' + x = cos(w t), with its steady state as output."""
    return System(
        name="linear",
        states=["x", "v"],
        parameters={"w": 0.7, "zeta": 0.1},
        period="2*pi/w",
        equations={"x": "v", "v": "-x - 2*zeta*v + cos(w*t)"},
        outputs={"twice": "2*x + w"},
    )


def steady(w, zeta, t):
    """Displacement of the steady state."""
    transfer = 1.0 / (1.0 - w**2 + 2j * zeta * w)
    return (transfer * np.exp(1j * w * t)).real


@pytest.mark.parametrize("start", ["restart", "follow up", "follow down"])
@pytest.mark.parametrize("phase", [0.0, 0.25])
def test_steady_states_of_a_linear_oscillator(start, phase):
    grid = np.array([0.5, 1.4, 0.9, 1.1])
    found = ns.bifurcation_diagram(
        linear(), "w", grid, transient=60, record=5, phase=phase, start=start
    )
    assert found.attrs["message"] == "completed"
    for i, w in enumerate(grid):
        # exp(-0.1 * 60 * 2 pi / w) is below 1e-11
        expected = steady(w, 0.1, phase * 2 * np.pi / w)
        assert found["x"].values[i, 0] == pytest.approx(np.full(5, expected), abs=1e-10)
        assert found["twice"].values[i, 0] == pytest.approx(2 * expected + w, abs=1e-10)
    assert np.all(found["period"] == 1)
    assert np.all(found["events"] == 0)


def ball(gamma):
    """A ball on a table at gamma sin t that keeps 0.8 of its speed, started on the orbit
    of one impact per period (N. Tufillaro's), whose impact is at cos(phi) = pi (1-r)/(gamma (1+r)).
    """
    r = 0.8
    angle = "acos(pi*(1 - r)/(gamma*(1 + r)))"
    flown = f"(2*pi - {angle})"
    return System(
        name="ball",
        states=["x", "v"],
        parameters={"gamma": gamma, "r": r},
        period="2*pi",
        initial={
            "x": f"gamma*sin({angle}) + pi*{flown} - {flown}**2/2 + 1e-7",
            "v": f"pi - {flown}",
        },
        modes={
            "flight": Mode(
                {"x": "v", "v": "-1"},
                exits=[
                    Exit(
                        "x - gamma*sin(t)",
                        to="flight",
                        reset={"v": "-r*v + (1 + r)*gamma*cos(t)"},
                        name="impact",
                    )
                ],
            )
        },
    )


def test_period_doubling_of_a_bouncing_ball():
    """The orbit loses stability at gamma^2 = (pi (1-r)/(1+r))^2 + (2 (1+r^2)/(1+r)^2)^2."""
    r = 0.8
    doubling = np.hypot(np.pi * (1 - r) / (1 + r), 2 * (1 + r**2) / (1 + r) ** 2)
    grid = doubling + np.array([-0.02, -0.01, 0.01, 0.02])
    found = ns.bifurcation_diagram(ball(1.0), "gamma", grid, transient=1500, record=40)
    assert found["status"].values.ravel().tolist() == ["completed"] * 4
    assert found["period"].values.ravel().tolist() == [1, 1, 2, 2]
    assert np.all(found["impacts"] == 1.0)
    at_impact = ns.bifurcation_diagram(
        ball(1.0), "gamma", grid[:2], transient=1500, record=40, at="impact", side="after"
    )
    assert at_impact["v"].values == pytest.approx(np.pi, abs=1e-6)
    before = ns.bifurcation_diagram(
        ball(1.0), "gamma", grid[:2], transient=1500, record=40, at="impact"
    )
    assert before["v"].values == pytest.approx(-np.pi, abs=1e-6)


def test_following_finds_both_branches_of_a_hysteresis():
    """The response of a hardening spring bends over: up and down differ between its folds."""
    duffing = System(
        name="hardening",
        states=["x", "v"],
        parameters={"w": 1.0},
        period="2*pi/w",
        equations={"x": "v", "v": "-x - x**3 - 0.05*v + 0.2*cos(w*t)"},
    )
    grid = np.linspace(0.9, 2.0, 23)
    up, down = (
        ns.bifurcation_diagram(duffing, "w", grid, transient=200, record=4, start=start)
        for start in ("follow up", "follow down")
    )
    size = [np.hypot(d["x"].values[:, 0, 0], d["v"].values[:, 0, 0]) for d in (up, down)]
    apart = np.abs(size[0] - size[1]) > 0.3
    assert 3 < np.count_nonzero(apart) < 20
    assert not apart[0]
    assert not apart[-1]


def test_the_mole_drifts_as_a_run_says():
    mole = ns.models.moling(omega=1.0)
    found = ns.bifurcation_diagram(
        mole, "b", [0.05, 0.2], initial=[None, {"q": 0.1}], transient=100, record=20
    )
    for i, b in enumerate((0.05, 0.2)):
        for lane, start in enumerate((None, {"q": 0.1})):
            run = ns.simulate(mole, start, periods=120, samples_per_period=1, parameters={"b": b})
            way = float(run["v"][120] - run["v"][100]) / 20
            assert float(found["v_per_period"][i, lane]) == pytest.approx(way, abs=1e-12)
            assert float(found["v_per_time"][i, lane]) == pytest.approx(
                way / (2 * np.pi), abs=1e-12
            )
            assert found["q"].values[i, lane] == pytest.approx(run["q"].values[100:120], abs=1e-12)


def test_the_number_of_threads_changes_no_digit(tmp_path):
    grid = np.linspace(0.7, 0.9, 41)
    one, two = (
        ns.bifurcation_diagram(
            ns.models.soft_impact(), "omega", grid, transient=50, record=30, threads=threads
        )
        for threads in (1, 3)
    )
    assert one.identical(two)
    one.to_netcdf(tmp_path / "d.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "d.nc", engine="h5netcdf") as again:
        xr.testing.assert_identical(again.load(), one)


def test_a_column_that_ends_early_is_told():
    """A tongue of motions that come to the stop; the others are complete."""
    system = System(
        states=["x", "v"],
        parameters={"a": 1.0},
        period="2*pi",
        modes={
            "m": Mode({"x": "v", "v": "-4*x - v + a*cos(t)"}, exits=[Exit("0.5 - x", to="stop")])
        },
    )
    found = ns.bifurcation_diagram(system, "a", [0.5, 3.0], transient=20, record=5)
    assert found["status"].values.ravel().tolist() == ["completed", "stopped"]
    assert np.all(np.isnan(found["x"].values[1]))
    assert "stopped" in found.attrs["message"]


def test_a_value_that_the_system_refuses():
    system = System(
        states=["x"],
        parameters={"a": 1.0},
        period="2*pi",
        equations={"x": "-x + a*cos(t)"},
        require={"a < 2": "the force is small"},
    )
    for start in ("restart", "follow up"):
        found = ns.bifurcation_diagram(system, "a", [1.0, 3.0, 1.5], record=5, start=start)
        assert found["status"].values.ravel().tolist() == ["completed", "refused", "completed"]


def test_outputs_take_the_parameter_of_their_column():
    """Of a motion that is sampled at times of its own: x + cos(w*t) at t = 20, 21, ..."""
    system = ns.System(
        states=["x"],
        parameters={"w": 1.0},
        equations={"x": "-w*x"},
        outputs={"sum": "x + cos(w*t)", "slope": "rate(x)"},
    )
    w = np.linspace(0.1, 0.9, 5)
    found = ns.bifurcation_diagram(
        ns.StroboscopicMap(system, period=1.0), "w", w, initial={"x": 1.0}, transient=20, record=10
    )
    x = np.exp(-np.outer(w, 20 + np.arange(10)))
    assert np.abs(found["x"].values[:, 0] - x).max() < 1e-12
    expected = x + np.cos(np.outer(w, 20 + np.arange(10)))
    assert np.abs(found["sum"].values[:, 0] - expected).max() < 1e-12
    assert np.abs(found["slope"].values[:, 0] + w[:, None] * x).max() < 1e-12


def test_columns_start_at_their_own_rest_state():
    system = ns.System(
        states=["x"],
        parameters={"k": 1.0, "T": 1.0},
        period="T",
        equations={"x": "0"},
        initial={"x": "2*k"},
    )
    found = ns.bifurcation_diagram(system, "k", [1.0, 3.0], transient=1, record=4)
    assert found["x"].values[:, 0].tolist() == [[2.0] * 4, [6.0] * 4]


def test_an_interruption_keeps_what_is_done(monkeypatch):
    from nonsmooth.runs import crew
    from nonsmooth.runs.sweep_runner import motions_per_task, seconds_of_motion

    calls = []
    take = crew.take

    def interrupted(*arguments, **options):
        result = take(*arguments, **options)
        calls.append(threading.current_thread())
        if len(calls) == 4:
            raise KeyboardInterrupt
        return result

    monkeypatch.setattr(crew, "take", interrupted)
    found = ns.bifurcation_diagram(
        ns.models.soft_impact(), "omega", np.linspace(0.7, 0.9, 400), transient=400, threads=1
    )
    assert found.attrs["status"] == "interrupted"
    assert set(found["status"].values.ravel()) == {"completed"}
    done = found.sizes["parameter"]
    size = motions_per_task(400, seconds_of_motion(ns.models.soft_impact(), 400))
    assert size <= done <= 4 * size  # as many tasks as were taken at most
    assert found.attrs["message"].endswith(f"{done} of 400 columns are done and kept")
    ns.plot.bifurcation(found, "x")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"parameter": "q"}, "unknown parameter 'q'"),
        ({"values": []}, "non-empty list"),
        ({"values": [0.1, np.nan]}, "finite numbers"),
        ({"values": "abc"}, "list of numbers"),
        ({"start": "follow"}, "follow up"),
        ({"side": "between"}, "before"),
        ({"at": "hit"}, "unknown event 'hit'"),
        ({"side": "after"}, "side = 'after' is that of an event"),
        ({"parameters": {"w": 0.7}}, "the value of 'w' counts for nothing, since values gives"),
        ({"transient": -1}, "transient"),
        ({"record": 0}, "record"),
        ({"phase": 2.0}, "phase = 2: give a part of the period, from 0 to less than 1$"),
        ({"match": 0.0}, "match = 0"),
        ({"threads": 0}, "threads"),
        ({"initial": []}, "empty list"),
        ({"initial": {"y": 1.0}}, "unknown state 'y'"),
    ],
)
def test_wrong_use(options, message):
    given = {"parameter": "w", "values": [0.5]} | options
    with pytest.raises((OptionError, ModelError), match=message):
        ns.bifurcation_diagram(linear(), given.pop("parameter"), given.pop("values"), **given)


def test_a_phase_is_none_of_events():
    with pytest.raises(OptionError, match=r"phase = 0.5 is that of strobes"):
        ns.bifurcation_diagram(ball(1.0), "gamma", [3.0], at="impact", phase=0.5)


def test_a_value_stays_without_which_others_are_refused():
    """Every e must be below w, so a call with e = 2 needs some w above 2 to begin with."""
    system = System(
        states=["x"],
        parameters={"w": 1.0, "e": 0.5},
        period="2*pi/w",
        require={"e < w": "e is the smaller one"},
        equations={"x": "cos(w*t) - x"},
    )
    found = ns.bifurcation_diagram(
        system, "w", [3.0], parameters={"w": 4.0, "e": 2.0}, transient=20, record=2
    )
    assert found["status"].values.item() == "completed"


def test_a_system_without_a_period():
    """What the message advises can be followed."""
    chua, start = ns.models.chua(), {"x": 0.1, "y": 0.0, "z": 0.0}
    with pytest.raises(
        OptionError, match=r"no period .* ns.StroboscopicMap\(system, period="
    ) as told:
        ns.bifurcation_diagram(chua, "alpha", [9.0])
    assert "ns.PoincareMap" in str(told.value)
    assert "give period=" not in str(told.value)
    for of_chua in (ns.StroboscopicMap(chua, period=2.0), ns.PoincareMap(chua, "z")):
        found = ns.bifurcation_diagram(
            of_chua, "alpha", [9.0], initial=start, transient=5, record=5
        )
        assert found["status"].values.tolist() == [["completed"]]
    with pytest.raises(OptionError, match=r"no period .*; give times=, or give the system"):
        ns.ensemble(chua)
    with pytest.raises(OptionError, match="period") as told:
        ns.waterfall(chua, "alpha", [9.0], variable="x")
    assert "PoincareMap" not in str(told.value)


def test_columns_without_the_event_stay_in_sight():
    """A wall at 1/2 and critical damping: the free amplitude 1/(1 + w^2) reaches it below w = 1."""
    struck = System(
        states=["x", "v"],
        parameters={"w": 0.3},
        period="2*pi/w",
        modes={
            "free": Mode(
                {"x": "v", "v": "-x - 2*v + cos(w*t)"},
                exits=[Exit("1 - 2*x", to="free", reset={"v": "-0.5*v"}, name="hit")],
            )
        },
    )
    grid = np.array([0.6, 0.8, 0.9, 1.1, 1.3, 1.6])
    found = ns.bifurcation_diagram(struck, "w", grid, transient=20, record=10, at="hit")
    hits = np.isfinite(found["x"].values[:, 0]).any(axis=1)
    assert hits.tolist() == [True, True, True, False, False, False]
    assert (
        "; 3 of 6 motions pass no 'hit' in the periods that are recorded" in found.attrs["message"]
    )
    ax = ns.plot.bifurcation(found, "v")
    low, high = ax.get_xlim()
    assert low < 0.6
    assert high > 1.6
    none = ns.bifurcation_diagram(struck, "w", grid[3:], transient=20, record=10, at="hit")
    assert none.attrs["message"].startswith("completed; 3 of 3 motions pass no 'hit'")
    low, high = ns.plot.bifurcation(none, "v").get_xlim()
    assert (low < 1.1, high > 1.6) == (True, True)


@pytest.mark.parametrize("verb", [ns.bifurcation_diagram, ns.waterfall, ns.contact_statistics])
def test_a_tuple_of_two_values_is_taken_for_a_range_and_refused(verb):
    """`continue_orbit` takes it as one; two columns would be a surprise."""
    more = {"variable": "x"} if verb is ns.waterfall else {}
    with pytest.raises(ns.OptionError, match=r"such as np.linspace\(0.7, 0.9, 400\)"):
        verb(ns.models.soft_impact(), parameter="omega", values=(0.7, 0.9), **more)


def test_a_state_that_is_zero_at_the_strobes_has_no_period_of_its_rounding():
    """A ball that rides on A sin(t) at the strobes: its height is zero there, up to 1e-16."""
    ball = System(
        states=["y", "v"],
        period="2*pi",
        parameters={"A": 1.2, "r": 0.3},
        initial={"y": 1.0},
        definitions={"s": "A*sin(t)", "u": "A*cos(t)"},
        modes={
            "flight": Mode(
                {"y": "v", "v": "-1"},
                exits=[
                    Exit("y - s", reset={"v": "-r*v + (1 + r)*u"}, sticks="rides", name="impact")
                ],
            )
        },
    )
    amplitudes = [1.17966, 1.25, 1.30932]
    found = ns.bifurcation_diagram(ball, "A", amplitudes, transient=100, record=60)
    assert found["period"].values.ravel().tolist() == [1, 1, 1]
    assert np.abs(found["y"].values).max() < 1e-13


def test_states_that_are_all_zero_at_the_strobes_have_no_period_of_their_rounding():
    """A follower that rides on its cam, at rest at the strobes; below w = 3.4597 it never lifts."""
    cam = System(
        states=["y", "v"],
        period="2*pi/w",
        parameters={"w": 2.0},
        definitions={"s": "(1 - cos(w*t))/2", "u": "w*sin(w*t)/2"},
        modes={
            "air": Mode(
                {"y": "v", "v": "-4*(y + 0.5) - 0.2*v"},
                exits=[Exit("y - s", reset={"v": "u - 0.3*(v - u)"}, sticks="rides", name="land")],
            )
        },
    )
    found = ns.bifurcation_diagram(cam, "w", np.linspace(1.5, 3.4, 9), transient=60, record=50)
    assert np.abs(found["v"].values).max() < 1e-13
    assert np.ptp(found["v"].values, axis=-1).max() > 0.0  # rounding, and no zeros
    assert found["period"].values.ravel().tolist() == [1] * 9
