"""Fits of periodic orbits to records of motions that have settled."""

import numpy as np
import pytest
import xarray as xr
from scipy.optimize import curve_fit

import nonsmooth as ns
from fitting.truth import RIGID, SOFT, dataset, noisy, rigid_motion, soft_motion
from nonsmooth.fitting.channels import read_channels
from nonsmooth.fitting.repetition import repeats_after

SPEED = 1.7
SENSOR = {"gain": None, "offset": None, "delay": None}


def driven():
    """A linear oscillator, whose response to the forcing is known in closed form."""
    return ns.System(
        states=["x", "v"],
        parameters={"k": 2.0, "c": 0.2, "omega": SPEED},
        equations={"x": "v", "v": "cos(omega*t) - k*x - c*v"},
        period="2*pi/omega",
    )


def response(times, k, c):
    """Real part of exp(i w t) / (k - w^2 + i w c)."""
    return np.real(np.exp(1j * SPEED * times) / (k - SPEED**2 + 1j * SPEED * c))


def linear_record(periods=30, per_period=24, late=0.0):
    """Samples of the response with noise."""
    times = np.arange(periods * per_period) * 2.0 * np.pi / SPEED / per_period
    return dataset(times, x=noisy(response(times - late, 1.5, 0.3), 0.05, np.random.default_rng(4)))


@pytest.mark.parametrize(("cycle", "segments"), [(1, 1), (1, 3), (2, None)])
def test_a_linear_oscillator_gives_the_regression_of_its_response(cycle, segments):
    record = linear_record()
    found = ns.fit(
        driven(), record, {"k": (0.5, 2.5), "c": (0.05, 0.6)}, hold_back=0.0, starts=1,
        form="steady", cycle=cycle, segments=segments,
    )  # fmt: skip
    known, covariance = curve_fit(response, record["time"], record["x"], [1.4, 0.2])
    # the solver ends at a relative change of 1e-9 of unknowns, and the gaps are closed to 2e-6 of
    # the states, against a standard error of 1e-3
    np.testing.assert_allclose(found["estimate"], known, rtol=1e-5)
    np.testing.assert_allclose(found["standard_error"], np.sqrt(np.diag(covariance)), rtol=2e-3)
    # multipliers are exp(-c T/2) in size, for an oscillator that swings
    growth = np.exp(-0.5 * known[1] * cycle * 2.0 * np.pi / SPEED)
    assert found.attrs["largest_multiplier"] == pytest.approx(growth, rel=1e-4)
    assert found.attrs["status"] == "completed"


def test_a_delay_shifts_samples_around_the_cycle():
    """Samples before the end of the cycle are folded to its beginning where they are late."""
    found = ns.fit(
        driven(), linear_record(late=0.2), {"k": (0.5, 2.5)}, delay=(0.0, 0.5), starts=1,
        parameters={"c": 0.3}, form="steady",
    )  # fmt: skip
    for name, truth in (("k", 1.5), ("x delay", 0.2)):
        one = found.sel(parameter=name)
        # four standard errors fail once in 16,000 records
        assert abs(float(one["estimate"]) - truth) < 4.0 * float(one["standard_error"])


@pytest.fixture(scope="module")
def settled():
    """30 periods of the soft impact oscillator after 60, which repeat every second period."""
    period = 2.0 * np.pi / SOFT["omega"]
    times = np.arange(90 * 40) * period / 40
    x = soft_motion(times, [0.3, 0.1])[0]
    return dataset(times[60 * 40 :], x=noisy(x[60 * 40 :], 0.02, np.random.default_rng(7)))


def fit_settled(record, **options):
    machine = ns.models.soft_impact(zeta=SOFT["zeta"], omega=SOFT["omega"])
    return ns.fit(machine, record, {"beta": (15, 45), "e": (0.9, 1.6)}, starts=2, **options)


@pytest.mark.slow
def test_steady_impacts_are_fitted_as_well_as_the_whole_record(settled):
    steady = fit_settled(settled, form="steady", cycle=2)
    whole = fit_settled(settled, form="transient")
    assert steady["start_agrees"].all()
    for name in ("beta", "e"):
        one, other = steady.sel(parameter=name), whole.sel(parameter=name)
        assert one["interval_low"] <= SOFT[name] <= one["interval_high"]
        # the start that a transient leaves free costs a little of what 1620 samples say
        ratio = float(one["standard_error"] / other["standard_error"])
        assert ratio == pytest.approx(1.0, abs=0.05)
        difference = abs(float(one["estimate"] - other["estimate"]))
        assert difference < float(one["standard_error"])
    # of 120 samples a root mean square has a spread of 1 / sqrt(240) = 0.065: three of them
    assert float(steady["prediction_error"][0]) == pytest.approx(1.0, abs=0.2)
    assert float(steady["whiteness"][0]) > 0.01
    assert steady.attrs["largest_multiplier"] < 1.0


@pytest.mark.slow
def test_the_data_choose_the_form(settled):
    """A record that repeats every second period, against the first periods of the same motion."""
    found = fit_settled(settled)
    assert (found.attrs["form"], found.attrs["cycle"]) == ("steady", "2")
    period = 2.0 * np.pi / SOFT["omega"]
    times = np.arange(30 * 40) * period / 40
    x = soft_motion(times, [0.3, 0.1])[0]
    early = fit_settled(dataset(times, x=noisy(x, 0.02, np.random.default_rng(7))))
    assert (early.attrs["form"], early.attrs["cycle"]) == ("transient", "none")


def chaotic(times):
    """Position of the soft impact oscillator at a force where it is chaotic."""
    return soft_motion(times, [0.3, 0.1], a=1.2, e=0.5, omega=1.0)[0]


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("motion", "expected"),
    [
        (lambda t: np.cos(t) + np.cos(3 * t) ** 5, 1),
        (lambda t: np.cos(t) + 0.2 * np.cos(t / 3), 3),
        (lambda t: np.cos(t) + 0.1 * np.cos(np.sqrt(2) * t), None),
        pytest.param(
            lambda t: np.cos(t) + np.exp(-0.02 * t) * np.cos(1.3 * t), None, marks=pytest.mark.slow
        ),
        pytest.param(lambda t: np.cos(t) * (1.0 + 0.02 * t / 250), None, marks=pytest.mark.slow),
        (chaotic, None),
    ],
    ids=["period one", "period three", "two frequencies", "decaying", "growing", "chaotic"],
)
def test_what_repeats_is_told(motion, expected):
    """With 2 % of noise; 1 % of steady records are taken for others by each of the two tests."""
    times = np.arange(0.0, 40 * 2.0 * np.pi, 2.0 * np.pi / 60)
    right, values = 0, motion(times)
    for seed in range(6):
        record = dataset(times, x=noisy(values, 0.02, np.random.default_rng(seed)))
        channels = read_channels(driven(), record, None, SENSOR, None)
        right += repeats_after(channels, times, 2.0 * np.pi) == expected
    # by chance 2 % each: two in six happen once in 170 times
    assert right >= 5


@pytest.mark.slow
def test_the_phase_of_the_forcing_is_found():
    """A record that begins at an unknown time of the forcing, 2.3 after its phase zero."""
    record = linear_record(late=-2.3)
    found = ns.fit(
        driven(), record, {"k": (0.5, 2.5), "c": (0.05, 0.6)}, form="steady", starts=4,
        shift=(0.0, 2.0 * np.pi / SPEED),
    )  # fmt: skip
    assert list(found["parameter"].values) == ["k", "c", "shift"]
    errors = np.abs(found["estimate"] - [1.5, 0.3, 2.3])
    assert (errors < 4.0 * found["standard_error"]).all()


@pytest.mark.slow
def test_a_transient_begins_at_an_unknown_phase():
    times = np.arange(0.0, 60.0, 0.1)
    x, *_ = soft_motion(np.append(0.0, times + 1.1), [0.3, 0.1])
    record = dataset(times, x=noisy(x[1:], 0.02, np.random.default_rng(8)))
    found = ns.fit(
        ns.models.soft_impact(**SOFT), record, {"e": (0.9, 1.6)}, shift=(0.0, 2.0), starts=3,
        form="transient",
    )  # fmt: skip
    errors = np.abs(found["estimate"] - [SOFT["e"], 1.1])
    assert (errors < 4.0 * found["standard_error"]).all()


@pytest.mark.slow
def test_steady_events_are_fitted():
    """Impacts of a settled motion: all periods share one instant of the cycle."""
    period = 2.0 * np.pi / RIGID["omega"]
    times = np.arange(130 * 30) * period / 30
    events = rigid_motion(times, [0.0, 0.0])[3]
    last = events[events > 90 * period]
    assert np.abs(np.diff(last) - period).max() < 1e-6  # one in each period
    instants = last + 0.01 * np.random.default_rng(4).standard_normal(last.size)
    record = xr.Dataset({"impact": ("hit", instants)})
    found = ns.fit(
        ns.models.impact_oscillator(**RIGID), record, {"sigma": (0.2, 0.6)}, form="steady",
        cycle=1, starts=2, hold_back=0.0,
    )  # fmt: skip
    assert found["segment_time"].size == 1
    error = abs(float(found["estimate"][0]) - RIGID["sigma"])
    assert error < 4.0 * float(found["standard_error"][0])
    # the mean of 40 instants says as much as the 40 instants: a hundredth over their root
    assert float(found["noise"][0]) == pytest.approx(0.01, rel=0.35)


@pytest.mark.slow
def test_a_wrong_cycle_leaves_residuals_that_are_no_noise(settled):
    found = fit_settled(settled, form="steady", cycle=1)
    assert float(found["whiteness"][0]) < 1e-6
    assert "residuals of x are correlated" in found.attrs["message"]


@pytest.mark.slow
def test_rigid_impacts_repeat_too():
    period = 2.0 * np.pi / RIGID["omega"]
    times = np.arange(100 * 50) * period / 50
    x = rigid_motion(times, [0.0, 0.0])[0]
    last = x[-50 * 30 :]
    assert np.abs(last[50:] - last[:-50]).max() < 1e-8  # period one
    record = dataset(times[-50 * 30 :], x=noisy(last, 0.02, np.random.default_rng(2)))
    system = ns.models.impact_oscillator(**RIGID)
    free = {"r": (0.5, 0.95), "sigma": (0.2, 0.6)}
    found = ns.fit(system, record, free, form="steady", starts=2)
    for name in ("r", "sigma"):
        one = found.sel(parameter=name)
        assert abs(float(one["estimate"]) - RIGID[name]) < 4.0 * float(one["standard_error"])
    assert found.attrs["status"] == "completed"


def fit_of_forced(acceleration, truth, amplitude, bounds):
    """Steady fit of ``k`` to 20 noisy periods of the response to cos(t), and its estimate held
    against the truth."""
    system = ns.System(
        states=["x", "v"],
        parameters={"k": sum(bounds) / 2},
        equations={"x": "v", "v": f"cos(t) + {acceleration}"},
        period="2*pi",
    )
    times = np.arange(20 * 30) * 2.0 * np.pi / 30
    response = np.real(amplitude * np.exp(1j * times))
    record = dataset(times, x=noisy(response, 0.02, np.random.default_rng(1)))
    found = ns.fit(system, record, {"k": bounds}, form="steady", starts=1)
    one = found.isel(parameter=0)
    assert abs(float(one["estimate"]) - truth) < 4.0 * float(one["standard_error"])
    return found


def test_an_orbit_that_is_unstable_is_told():
    """A pendulum that stands on its head has a steady motion that no machine would keep."""
    found = fit_of_forced("k*x - 0.1*v", 1.2, 1.0 / (-1.0 - 1.2 + 0.1j), (0.5, 2.0))
    assert found.attrs["largest_multiplier"] > 1.0
    assert "unstable" in found.attrs["message"]


def test_an_orbit_without_damping_is_not_called_unstable():
    """Its multipliers are 1 in size but for rounding."""
    found = fit_of_forced("-k*x", 2.3, 1.0 / 1.3, (1.5, 3.0))
    assert found.attrs["largest_multiplier"] == pytest.approx(1.0, abs=1e-9)
    assert "unstable" not in found.attrs["message"]


def test_what_need_not_repeat_is_refused():
    record = linear_record()
    with pytest.raises(ns.OptionError, match="the period depends on 'omega', which is in free="):
        ns.fit(driven(), record, {"omega": (1.0, 2.0)}, form="steady")
    with pytest.raises(ns.OptionError, match="less than one cycle of"):
        ns.fit(driven(), record, {"k": (0.5, 2.5)}, form="steady", cycle=40)
    drifting = ns.System(
        states=["x", "s"],
        parameters={"k": 1.0},
        equations={"x": "cos(t) - k*x", "s": "x"},
        drift=["s"],
        period="2*pi",
    )
    with pytest.raises(ns.OptionError, match="s may drift"):
        ns.fit(drifting, record, {"k": (0.5, 2.5)}, form="steady")
