"""Times in another unit than those of the model are told before the fit, and it ends soon."""

import itertools
import warnings

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from fitting.truth import dataset
from nonsmooth.fitting.channels import check_free
from nonsmooth.fitting.course import Course
from nonsmooth.fitting.cuts import Cut, GivenRecord
from nonsmooth.fitting.shooting import Shooting
from nonsmooth.fitting.time_scales import said_of_times, time_scales
from nonsmooth.progress import Progress

TIMES = np.linspace(0.0, 20.0, 200)
FREE = {"k": (2.0, 8.0), "c": (0.01, 0.6)}


def spring(**options):
    return ns.System(
        states=["x", "v"], parameters={"k": 3.0, "c": 0.1}, equations={"x": "v", "v": "-k*x - c*v"},
        **options,
    )  # fmt: skip


def decay(times, seed=1):
    x = np.exp(-0.05 * times) * np.cos(np.sqrt(4.0 - 0.05**2) * times)
    return x + 0.02 * np.random.default_rng(seed).standard_normal(times.size)


@pytest.fixture
def motions(monkeypatch):
    """How many motions through the record are computed."""
    count = [0]
    plain = Shooting.evaluate

    def counted(self, *args):
        count[0] += 1
        return plain(self, *args)

    monkeypatch.setattr(Shooting, "evaluate", counted)
    return count


def test_time_scales_of_a_spring_are_those_of_the_closed_form():
    """A natural motion within the bounds takes 2 pi/sqrt(k)."""
    system = spring()
    found = time_scales(system, check_free(system, FREE), np.zeros(2))
    np.testing.assert_allclose(found, [2 * np.pi / np.sqrt(8), 2 * np.pi / np.sqrt(2)], rtol=1e-9)


def test_time_scales_count_all_modes_and_the_forcing():
    stop = ns.System(
        states=["x", "v"], parameters={"k": 4.0, "w": 0.1}, period="2*pi/w",
        equations={"x": "v", "v": "-k*x - 96*max(x - 1, 0) + cos(w*t)"},
    )  # fmt: skip
    found = time_scales(stop, check_free(stop, {"w": (0.05, 0.2)}), np.zeros(2))
    np.testing.assert_allclose(found, [2 * np.pi / 10.0, 2 * np.pi / 0.05], rtol=1e-9)


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_time_scales_of_a_nonlinear_mode_are_those_about_the_start(unit):
    """A pendulum with damping about its rest: lambda^2 + c lambda + g = 0, in any unit of time."""
    pendulum = ns.System(
        states=["q", "w"], parameters={"g": 9.0, "c": 2.0},
        equations={"q": f"w*{1 / unit}", "w": f"(-g*sin(q) - c*w)*{1 / unit}"},
    )  # fmt: skip
    found = time_scales(pendulum, check_free(pendulum, {"c": (1, 3)}), np.zeros(2))
    np.testing.assert_allclose(found, 2 * np.pi / 3.0 * unit, rtol=1e-4)
    hung = time_scales(pendulum, check_free(pendulum, {"g": (4, 9)}), np.zeros(2))
    np.testing.assert_allclose(hung, [2 * np.pi / 3.0 * unit, 2 * np.pi / 2.0 * unit], rtol=1e-4)


def test_a_straight_line_has_no_time_scale():
    ramp = ns.System(states=["x"], parameters={"k": 1.0}, equations={"x": "k"})
    assert time_scales(ramp, check_free(ramp, {"k": (0, 2)}), np.zeros(1)) is None


@pytest.mark.parametrize(
    ("ours", "theirs", "told"),
    [
        ("ms", "[s]", "its times are in ms, and those of the model in s: give both in one unit"),
        ("ms", "", "its times are in ms, and those of the model in a unit that is not told"),
        ("", "[s]", "give both in one unit of time"),
    ],
)
def test_units_of_both_are_told(ours, theirs, told):
    data = dataset(1000.0 * TIMES, x=decay(TIMES))
    data["time"].attrs["units"] = ours
    system = spring(describe={"time": f"time {theirs}"} if theirs else {})
    given, cut = GivenRecord("run", system, [], data["time"].values), Cut(0.1, None, None, np.nan)
    words = said_of_times([given], [data], [cut], check_free(system, FREE), np.zeros(2))
    assert len(words) == 1
    assert words[0].startswith("record 'run': its samples are 100.5 apart, and no motion of the")
    assert told in words[0]
    steady = cut._replace(cycle=1)
    assert not said_of_times([given], [data], [steady], check_free(system, FREE), np.zeros(2))


def test_samples_slower_than_any_motion_end_the_fit_soon(motions):
    record = dataset(1000.0 * TIMES, x=decay(TIMES))
    with pytest.warns(ns.ResultWarning) as seen:
        found = ns.fit(spring(), record, FREE, starts=1)
    first = str(seen[0].message)
    assert "its samples are 100.5 apart" in first and "lasts longer than 4.443" in first
    assert found.attrs["status"] == "not_converged"
    assert "its samples are 100.5 apart" in found.attrs["message"]
    assert "segments do not join after" in found.attrs["message"]
    # three looks of 25 motions at most in the first stage, and a hundred along profiles, with the
    # 60 of the minimisation in which these end; before, there were thousands
    assert motions[0] < 3 * 25 + 100 + 60


def test_a_record_that_is_over_before_anything_moves_is_told():
    record = dataset(0.001 * TIMES, x=decay(TIMES))
    with pytest.warns(ns.ResultWarning, match="it lasts 0.02, and the shortest motion .* 2.221"):
        found = ns.fit(spring(), record, FREE, starts=1)
    assert "it lasts 0.02" in found.attrs["message"]


def test_times_of_the_model_are_not_remarked_upon():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = ns.fit(spring(), dataset(TIMES, x=decay(TIMES)), FREE, starts=1)
    assert found.attrs["status"] == "completed"
    assert "one unit of time" not in found.attrs["message"]


def test_a_steady_motion_may_be_sampled_once_in_many_periods():
    """Samples at any phases make up the cycle."""
    driven = ns.System(
        states=["x"], parameters={"c": 1.0}, period="2*pi", equations={"x": "cos(t) - c*x"}
    )
    times = np.arange(150) * 7.9
    x = (np.exp(1j * times) / (2.0 + 1j)).real
    x += 0.01 * np.random.default_rng(1).standard_normal(150)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = ns.fit(driven, dataset(times, x=x), {"c": (1.0, 3.0)}, form="steady", starts=1)
    assert float(found["estimate"][0]) == pytest.approx(2.0, abs=0.02)


@pytest.mark.slow
def test_bounds_far_from_the_truth_end_the_fit_soon(motions):
    """A negative stiffness, of a spring that swings against a stop."""

    def rates(_, y):
        return [y[1], -4.0 * y[0] - 0.15 * y[1] - 30.0 * max(y[0] - 0.3, 0.0)]

    x = solve_ivp(rates, (0.0, 20.0), [-1.0, 0.5], "DOP853", TIMES, rtol=1e-9, atol=1e-9).y[0]
    stop = ns.System(
        states=["x", "v"], parameters={"k": 3.0},
        equations={"x": "v", "v": "-k*x - 0.15*v - 30*max(x - 0.3, 0)"},
    )  # fmt: skip
    record = dataset(TIMES, x=x + 0.02 * np.random.default_rng(7).standard_normal(TIMES.size))
    with pytest.warns(ns.ResultWarning, match=r"segments do not join after \d+ motions"):
        ns.fit(stop, record, {"k": (-8, -2)}, starts=1)
    # one search of 75, 3 * 25 and 7 * 60 motions at most, as many along profiles with the last
    # minimisations there, and three trials that end in their first stage
    assert motions[0] < 2 * (75 + 3 * 25 + 7 * 60) + 2 * 7 * 60 + 3 * 75


def test_the_bar_of_a_fit_moves_with_each_motion(monkeypatch):
    seen = []
    monkeypatch.setattr("nonsmooth.progress.Progress.update", lambda _, done: seen.append(done))
    ns.fit(spring(), dataset(TIMES, x=decay(TIMES)), FREE, starts=2)
    assert len(seen) > 200
    assert all(one < other for one, other in itertools.pairwise(seen))
    assert seen[-1] == 3.0  # two starts and the intervals


def test_a_course_never_passes_the_end_of_a_phase(monkeypatch):
    seen = []
    monkeypatch.setattr("nonsmooth.progress.Progress.update", lambda _, done: seen.append(done))
    with Progress("fit", 2) as bar:
        course = Course(bar)
        for _ in range(10_000):
            course.move(0.5)
        assert max(seen) <= 1.0
        course.end_phase()
        course.move(1.0)
    assert 1.0 < seen[-1] < 1.1
