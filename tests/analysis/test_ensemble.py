"""Ensembles beside closed forms; what they promise about threads, files and lanes that fail."""

import os
import signal

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth import Exit, Mode, ModelError, OptionError, System
from nonsmooth.analysis.ensembles import work
from nonsmooth.runs import crew


def linear():
    """x'' + 2 zeta x' + x = cos(w t)."""
    return System(
        name="linear",
        states=["x", "v"],
        parameters={"w": 0.7, "zeta": 0.1},
        period="2*pi/w",
        equations={"x": "v", "v": "-x - 2*zeta*v + cos(w*t)"},
        outputs={"late": "x + t"},
        describe={"x": "displacement [mm]", "w": "frequency"},
    )


def motion(x, v, w, zeta, t):
    """Closed form of the linear oscillator from a state at time 0."""
    steady = 1.0 / (1.0 - w**2 + 2j * zeta * w)
    root = -zeta + 1j * np.sqrt(1.0 - zeta**2)
    # x(t) = Re(steady exp(iwt)) + Re(c exp(root t)) with c by the initial state
    x, v = x - steady.real, v - (1j * w * steady).real
    c = x - 1j * (v + zeta * x) / np.sqrt(1.0 - zeta**2)
    path = [
        (1j * w) ** k * steady * np.exp(1j * w * t) + root**k * c * np.exp(root * t)
        for k in range(2)
    ]
    return path[0].real, path[1].real


def test_strobes_of_linear_oscillators_in_a_grid():
    x, v = np.array([0.5, -1.0, 2.0]), np.array([0.0, 0.3, -0.7])
    w, zeta = np.array([0.4, 1.3]), np.array([0.05, 0.2, 0.6])
    runs = ns.ensemble(
        linear(), {"x": x, "v": v}, parameters={"w": w, "zeta": zeta}, transient=3, record=4,
        phase=0.25,
    )  # fmt: skip
    assert dict(runs.sizes) == {"lane": 18, "point": 4, "state": 2}
    assert runs.attrs["message"] == "completed"
    assert runs["point"].values.tolist() == [3, 4, 5, 6]
    lane = 0
    for each_w in w:
        for each_zeta in zeta:
            for start in zip(x, v, strict=True):
                run = runs.isel(lane=lane)
                assert (float(run["w"]), float(run["zeta"])) == (each_w, each_zeta)
                t = (np.arange(3, 7) + 0.25) * 2 * np.pi / each_w
                expected = motion(*start, each_w, each_zeta, t)
                assert run["x"].values == pytest.approx(expected[0], abs=1e-13)
                assert run["v"].values == pytest.approx(expected[1], abs=1e-13)
                assert run["late"].values == pytest.approx(expected[0] + t, abs=1e-13)
                assert run["end_state"].values == pytest.approx(
                    [e[-1] for e in expected], abs=1e-13
                )
                assert float(run["end_time"]) == pytest.approx(t[-1], rel=1e-15)
                assert run["initial_state"].values.tolist() == list(start)
                lane += 1
    assert np.all(runs["mode"] == 0)
    assert runs["x"].attrs == {"long_name": "displacement", "units": "mm"}
    assert runs["w"].attrs == {"long_name": "frequency"}


def test_times_of_pairs_without_a_period():
    decay = System(states=["x"], parameters={"a": 1.0}, equations={"x": "-a*x"})
    times = [0.0, 0.5, 0.5, 3.0]
    a, x = np.linspace(0.1, 2, 7), np.linspace(-1, 1, 7)
    runs = ns.ensemble(decay, {"x": x}, parameters={"a": a}, times=times, combine="pairs")
    assert runs["x"].dims == ("lane", "time")
    assert runs["x"].values == pytest.approx(x[:, None] * np.exp(-np.outer(a, times)), abs=1e-15)
    one = ns.ensemble(decay, {"x": 0.5}, parameters={"a": a}, times=times, combine="pairs")
    assert one["x"].values == pytest.approx(0.5 * np.exp(-np.outer(a, times)), abs=1e-15)


def test_lanes_are_the_runs_of_simulate():
    """Also where a state of rest depends on a parameter, and in a mode of piecewise text."""
    system = System(
        states=["x", "v"],
        parameters={"w": 0.9, "g": 0.2},
        initial={"x": "-g"},
        period="2*pi/w",
        equations={"x": "v", "v": "-x - 0.1*v - 4*max(x - g, 0) + cos(w*t)"},
    )
    starts = [{"v": 0.0}, {"v": 0.5}, {"v": -1.0}]
    runs = ns.ensemble(system, starts, parameters={"g": [0.1, 0.3], "w": 0.8}, record=30)
    for i, g in enumerate((0.1, 0.3)):
        for k, start in enumerate(starts):
            run = ns.simulate(
                system, start, periods=29, samples_per_period=1, parameters={"g": g, "w": 0.8}
            )
            lane = runs.isel(lane=3 * i + k)
            for name in ("x", "v", "mode"):
                assert lane[name].values.tobytes() == run[name].values.tobytes()
            assert float(lane["initial_state"].sel(state="x")) == -g


KINDS = {
    "soft_impact": {"x": np.linspace(-0.5, 0.5, 67)},
    "moling": {"q": np.linspace(0, 0.1, 67)},
    "duffing": {"x": np.linspace(-1, 1, 67)},
}


@pytest.mark.few(1)
@pytest.mark.parametrize("model", KINDS)
def test_neither_threads_nor_files_nor_chunks_change_a_digit(model, tmp_path, monkeypatch):
    system, initial = getattr(ns.models, model)(), KINDS[model]
    options = {"transient": 20, "record": 3}
    one = ns.ensemble(system, initial, threads=1, **options)
    assert set(one["status"].values) == {"completed"}
    assert ns.ensemble(system, initial, threads=3, **options).identical(one)
    with ns.ensemble(system, initial, store=tmp_path / "s", threads=2, **options) as stored:
        assert stored["x"].variable._in_memory is False  # read when needed
        xr.testing.assert_identical(stored.load(), one)
    monkeypatch.setattr(work, "_FEWEST", 3)
    assert ns.ensemble(system, initial, threads=2, **options).identical(one)
    alone = ns.ensemble(system, {k: v[40] for k, v in initial.items()}, **options)
    assert alone["x"].values.tobytes() == one["x"].values[40].tobytes()


def test_lanes_that_end_early_say_how():
    """x'' = -x stops where x = -cos(t) reaches 0.5; a growing one diverges; others go on."""
    system = System(
        states=["x", "v"],
        parameters={"k": 1.0},
        period="2*pi",
        modes={"m": Mode({"x": "v", "v": "-k*x"}, exits=[Exit("0.5 - x", to="stop")])},
        require={"k < 9": "the spring is soft"},
    )
    runs = ns.ensemble(
        system, {"x": [-1.0, -0.4, 0.9]}, parameters={"k": [1.0, -4.0, 9.5]}, record=50
    )
    assert runs["status"].values.tolist() == [
        "stopped", "completed", "inadmissible",
        "diverged", "diverged", "inadmissible",
        "refused", "refused", "refused",
    ]  # fmt: skip
    assert runs.attrs["status"] == "completed"
    assert runs.attrs["message"].endswith("see status: stopped, diverged, inadmissible, refused")
    assert float(runs["end_time"][0]) == pytest.approx(2 * np.pi / 3, abs=1e-14)
    end = runs["end_state"].values
    assert end[0] == pytest.approx([0.5, np.sqrt(0.75)], abs=1e-14)
    # -0.4 cosh(2t) reaches -1e30 at t = ln(2e30/0.4)/2
    assert float(runs["end_time"][4]) == pytest.approx(np.log(2e30 / 0.4) / 2, abs=2 * np.pi)
    assert np.all(np.isnan(end[[2, 5, 6, 7, 8]]))
    assert runs["initial_state"].values[8].tolist()[0] == 0.9
    x = runs["x"].values
    assert x[0, 0] == -1.0
    assert np.all(np.isnan(x[0, 1:]))
    assert np.all(runs["mode"].values[0, 1:] == -1)
    assert x[1] == pytest.approx(-0.4, abs=1e-12)
    assert np.all(np.isnan(x[6:]))


def test_a_mode_of_the_starts():
    """The name of a mode that is split into cells stands for all of them."""
    system = System(
        states=["x"],
        modes={
            "a": Mode({"x": "-abs(x)"}, exits=[Exit("2 - x", to="b")]),
            "b": Mode({"x": "-1"}, exits=[Exit("x + 9", to="a")]),
        },
    )
    x = [-0.5, 0.5, 5.0]
    found = {
        mode: ns.ensemble(system, {"x": x}, times=[1.0], mode=mode) for mode in (None, "a", "b")
    }
    assert found["a"]["status"].values.tolist() == ["completed", "completed", "inadmissible"]
    decay = [-0.5 * np.e, 0.5 / np.e]
    assert found["a"]["x"].values[:2, 0] == pytest.approx(decay, abs=1e-14)
    assert found[None]["x"].values[:, 0] == pytest.approx([*decay, 4.0], abs=1e-14)
    assert found["b"]["x"].values[:, 0] == pytest.approx([-1.5, -0.5, 4.0], abs=1e-14)


def slow_work(**options):
    return ns.ensemble(
        ns.models.soft_impact(), {"x": np.linspace(-1, 1, 50_000)}, transient=2000, record=1,
        **options,
    )  # fmt: skip


@pytest.mark.parametrize("stored", [False, True])
def test_an_interruption_keeps_what_is_done(stored, tmp_path, monkeypatch, interrupts):
    """A true Ctrl-C; of half an hour of work no more is done than was begun."""
    taken, take = [], crew.take

    def interrupted(results):
        if len(taken) == 3:
            os.kill(os.getpid(), signal.SIGINT)
        taken.append(take(results))
        return taken[-1]

    monkeypatch.setattr(crew, "take", interrupted)
    runs = slow_work(threads=2, **({"store": tmp_path / "s"} if stored else {}))
    assert runs.attrs["status"] == "interrupted"
    done = runs["status"].values == "completed"
    assert set(runs["status"].values[~done]) == {"interrupted"}
    # tasks of 24 runs: three that were taken, and eight for each thread that may have been given
    assert 24 * 3 <= done.sum() <= 24 * (3 + 8 * 2)
    assert np.all(np.isfinite(runs["x"].values[done]))
    assert np.all(np.isnan(runs["x"].values[~done]))
    runs.close()


def test_what_does_not_fit_into_memory_is_refused():
    with pytest.raises(OptionError, match=r"of 1000000 runs takes \d+ TB.* give store= a folder"):
        ns.ensemble(linear(), {"x": np.zeros(1_000_000)}, record=10_000_000)


@pytest.mark.parametrize(
    ("initial", "options", "message"),
    [
        ({"y": 1.0}, {}, "unknown state 'y'"),
        ({"x": [1.0, np.inf]}, {}, r"initial\['x'\]\[1\] = inf is not a finite number"),
        ({"x": []}, {}, "non-empty"),
        ({"x": [[1.0]]}, {}, "shape"),
        ({"x": "abc"}, {}, "list of numbers"),
        ({"x": [1.0, 2.0], "v": [1.0, 2.0, 3.0]}, {}, "x has 2, v has 3"),
        ([], {}, "empty list"),
        ([{"x": 1.0}, {"v": 1.0}], {}, r"initial\[1\] names v, and initial\[0\] x"),
        ([{"x": 1.0}, 3.0], {}, r"initial\[1\] = 3.0 is not a mapping"),
        (3.0, {}, "such as"),
        ("x", {}, "such as"),
        (None, {"parameters": {"q": [1.0]}}, "unknown parameter 'q'"),
        (None, {"parameters": {"w": [1.0, np.nan]}}, r"parameters\['w'\]\[1\] = nan"),
        (None, {"parameters": [1.0]}, "mapping of names"),
        (None, {"parameters": {"w": -1.0}}, "period"),
        (None, {"combine": "zip"}, "combine = .zip.: give one of "),
        (
            {"x": [1.0, 2.0]},
            {"parameters": {"w": [1.0, 2.0, 3.0]}, "combine": "pairs"},
            "w has 3, initial has 2",
        ),
        (None, {"transient": -1}, "transient"),
        (None, {"record": 0}, "record"),
        (None, {"phase": 1.0}, "phase = 1"),
        (None, {"times": [1.0], "record": 3}, "not both"),
        (None, {"times": [-1.0]}, "before the start"),
        (None, {"times": [2.0, 1.0]}, "must not decrease"),
        (None, {"tolerance": 1.0}, "tolerance"),
        (None, {"mode": "none"}, "unknown mode"),
        (None, {"threads": 0}, "threads"),
        (None, {"store": 5}, "path of a folder"),
    ],
)
def test_wrong_use(initial, options, message):
    with pytest.raises((OptionError, ModelError), match=message):
        ns.ensemble(linear(), initial, **options)


def test_systems_that_cannot():
    with pytest.raises(OptionError, match="has no period"):
        ns.ensemble(ns.models.chua())
    with pytest.raises(OptionError, match="not a System"):
        ns.ensemble("wall", parameters={"w": [1.0]})
    clash = System(states=["status"], period="1", equations={"status": "-status"})
    with pytest.raises(OptionError, match="'status' is a name of the result"):
        ns.ensemble(clash)


def test_sets_with_a_lane_each_are_the_runs_of_their_parameters():
    """Lanes that the engine sets up together have the states of single runs, to the last digit."""
    system = ns.models.soft_impact()
    omegas, gaps = np.linspace(0.7, 0.9, 40), np.linspace(1.0, 1.3, 40)
    starts = np.linspace(-0.1, 0.1, 40)
    found = ns.ensemble(
        system, {"x": starts}, parameters={"omega": omegas, "e": gaps}, combine="pairs", record=12
    )
    for i in (0, 17, 39):
        run = ns.simulate(
            system, {"x": float(starts[i])}, periods=11, samples_per_period=1,
            parameters={"omega": float(omegas[i]), "e": float(gaps[i])},
        )  # fmt: skip
        np.testing.assert_array_equal(found["x"].values[i], run["x"].values)
        np.testing.assert_array_equal(found["stop_force"].values[i], run["stop_force"].values)


def test_sets_that_the_system_refuses_are_told_beside_the_others():
    found = ns.ensemble(
        ns.models.soft_impact(), parameters={"omega": [0.8, -1.0, 0.9, 0.0]}, record=5
    )
    status = [str(each) for each in found["status"].values.ravel()]
    assert status == ["completed", "refused", "completed", "refused"]
