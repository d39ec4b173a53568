"""Orders and envelopes of runs whose speed changes, against the linear response."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from analysis.shafts import shaft, whirl


def run_up(rate=2e-5, **parameters):
    system = replace(shaft(**parameters), slow={"w": f"0.6 + {rate}*t"})
    return ns.simulate(system, t_end=1.4 / rate, samples_per_period=32)


@pytest.mark.slow  # thousands of periods; those of a constant speed are below
def test_orders_follow_the_unbalance_response():
    """Slow enough that it is settled at every speed, up to the rate of change."""
    found = ns.order_tracking(run_up(k_y=2.0), ("x", "y"), periods=10)
    speed = found["parameter"].values
    assert found.attrs["parameter"] == "w"
    assert speed[0] < 0.62 and speed[-1] > 1.98 and np.all(np.diff(speed) > 0.0)
    forward, backward = np.array([whirl(w, k_y=2.0) for w in speed]).T
    amplitude = found["amplitude"]
    settled = slice(10, None)
    size = forward.max()
    np.testing.assert_allclose(
        amplitude.sel(harmonic=1.0)[settled], forward[settled], atol=0.01 * size
    )
    np.testing.assert_allclose(
        amplitude.sel(harmonic=-1.0)[settled], backward[settled], atol=0.01 * size
    )
    # twice as slow, half as far away
    slower = ns.order_tracking(run_up(1e-5, k_y=2.0), ("x", "y"), periods=10)
    far = []
    for each in (found, slower):
        wanted = np.array([whirl(w, k_y=2.0)[0] for w in each["parameter"].values])
        far.append(np.abs(each["amplitude"].sel(harmonic=1.0).values - wanted)[20:].max())
    assert far[1] < 0.6 * far[0]


@pytest.mark.slow
def test_of_a_constant_speed_it_is_the_full_spectrum():
    run = ns.simulate(ns.models.rotor(), periods=30, samples_per_period=20)
    found = ns.order_tracking(run, ("x", "y"), periods=15, window="boxcar")
    assert found.attrs["parameter"] == "time"
    assert found.sizes["parameter"] == 2
    wanted = ns.full_spectrum(run, "x", "y", transient=15)
    away = found["harmonic"].values != 0.0
    for name in ("amplitude", "power_density"):
        np.testing.assert_allclose(found[name][1, away], wanted[name][away], atol=1e-12)
    np.testing.assert_allclose(found["frequency"][1], wanted["frequency"], rtol=1e-10)
    period = run.attrs["period"]
    np.testing.assert_allclose(found["time"], [7.5 * period, 22.5 * period], rtol=1e-12)


def test_a_start_within_a_period():
    run = ns.simulate(shaft(), periods=20, t_start=1.0, samples_per_period=20)
    with pytest.raises(ns.OptionError, match="not equal parts of a period"):
        ns.order_tracking(run, "x", periods=4)


@pytest.mark.slow
def test_envelope_of_a_run_up():
    run = run_up()
    found = ns.period_statistics(run, ["x", "u"])
    w = found["w"].values
    assert np.all(np.diff(w) > 0.0) and found.attrs["slow"] == "w"
    amplitude = np.array([whirl(each)[0] for each in w])
    settled = slice(60, None)
    np.testing.assert_allclose(
        found["x_amplitude"][settled], amplitude[settled], atol=0.01 * amplitude.max()
    )
    assert found["x_amplitude"].attrs["units"] == "mm"
    # the value that was in force, and the beginning of each period
    begin = found["begin"].values
    np.testing.assert_allclose(w, 0.6 + 2e-5 * begin, rtol=1e-12)
    np.testing.assert_allclose(np.diff(begin), (2 * np.pi / w)[:-1], rtol=1e-9)
    together = ns.period_statistics(run, "x", periods=7)
    count = together.sizes["period"]
    high = found["x_max"].values[: 7 * count].reshape(count, 7).max(axis=1)
    np.testing.assert_array_equal(together["x_max"], high)
    np.testing.assert_array_equal(together["begin"], begin[: 7 * count : 7])


@pytest.mark.parametrize("options", [{}, {"t_start": 1.0}, {"samples_per_period": 1}])
def test_contacts_by_own_counting(options):
    run = ns.simulate(ns.models.rotor(), periods=50, **options)
    found = ns.period_statistics(run, contact="contact")
    period = run.attrs["period"]
    time, name = run["event_time"].values, run["event_name"].values
    entered, left = time[name == "contact"], time[name == "release"]
    first = int(found["period"][0])
    assert found["period"].values.tolist() == list(range(first, first + found.sizes["period"]))
    for k in range(found.sizes["period"]):
        low, high = (first + k) * period, (first + k + 1) * period
        assert float(found["contacts"][k]) == np.count_nonzero((entered >= low) & (entered < high))
        spans = [
            min(high, left[left > t].min(initial=high)) - max(low, t)
            for t in entered
            if t < high and left[left > t].min(initial=high) > low
        ]
        assert float(found["contact_share"][k]) == pytest.approx(sum(spans) / period, abs=1e-9)


def test_extremes_include_the_states_at_impacts():
    ball = ns.System(
        states=["h", "u"],
        period="2",
        modes={
            "flight": ns.Mode(
                {"h": "u", "u": "-1"}, exits=[ns.Exit("h", reset={"u": "-u/2"}, name="impact")]
            )
        },
    )
    run = ns.simulate(ball, {"h": 0.5}, periods=1, samples_per_period=3)
    found = ns.period_statistics(run, "u")
    assert float(found["u_min"][0]) == pytest.approx(-1.0, abs=1e-12)
    assert float(found["u_max"][0]) == pytest.approx(0.5, abs=1e-12)


def test_they_survive_a_file(tmp_path):
    run = run_up(1e-3)
    for found in (
        ns.order_tracking(run, "x", periods=4),
        ns.period_statistics(run, "x", contact="flow"),
    ):
        found.to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
        xr.testing.assert_identical(xr.load_dataset(tmp_path / "a.nc", engine="h5netcdf"), found)


def test_wrong_options():
    run = run_up(1e-2)
    for options, text in (
        ({"variable": "z"}, "unknown variable 'z'"),
        ({"variable": "x", "over": "k_x"}, "unknown slow parameter"),
        ({"variable": "x", "periods": 999}, "too few for a block"),
        ({"variable": ("x", "u")}, "one unit"),
    ):
        with pytest.raises(ns.OptionError, match=text):
            ns.order_tracking(run, **options)
    free = ns.simulate(ns.System(states=["x"], equations={"x": "-x"}), {"x": 1.0}, t_end=9)
    with pytest.raises(ns.OptionError, match="no orders to track"):
        ns.order_tracking(free, "x")
    with pytest.raises(ns.OptionError, match="no period"):
        ns.period_statistics(free, "x")
    with pytest.raises(ns.OptionError, match="unknown variable 'z'"):
        ns.period_statistics(run, "z")
    with pytest.raises(ns.OptionError, match="contact: unknown mode"):
        ns.period_statistics(run, contact="rub")
    with pytest.raises(ns.OptionError, match="no event log"):
        quiet = ns.simulate(shaft(), periods=3, events=False)
        ns.period_statistics(quiet, contact="flow")
    with pytest.raises(ns.OptionError, match="fewer than 9 whole periods"):
        ns.period_statistics(ns.simulate(shaft(), periods=3), periods=9)
