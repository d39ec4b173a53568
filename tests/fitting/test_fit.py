"""Fits of records that another integrator or a closed form has made."""

import dataclasses

import numpy as np
import pytest
import synthetic_motions as machines
from scipy import stats
from scipy.signal import lfilter

import nonsmooth as ns
from fitting.truth import RIGID, SOFT, dataset, noisy, rigid_motion, soft_motion

PERIOD = 2.0 * np.pi / SOFT["omega"]
RANGES = {"beta": (15.0, 45.0), "e": (0.9, 1.6), "zeta": (0.002, 0.05)}


def soft_record(periods, share, seed, per_period=60, **changed):
    """Record of the soft impact oscillator on its way to its attractor."""
    rng = np.random.default_rng(seed)
    times = np.arange(0.0, periods * PERIOD, PERIOD / per_period)
    x, _, acceleration, events = soft_motion(times, [0.3, 0.1], **changed)
    record = dataset(times, x=noisy(x, share, rng), a=noisy(acceleration, share, rng))
    return record, events


def within(found, truth):
    """Whether every interval holds its true value."""
    low, high = found["interval_low"], found["interval_high"]
    return {
        name: bool(low.sel(parameter=name) <= value <= high.sel(parameter=name))
        for name, value in truth.items()
        if name in found["parameter"]
    }


def line(k=0.7, offset=0.3, count=50, level=0.05, seed=1):
    """A straight line with noise: the fit is then linear regression, known in closed form."""
    rng = np.random.default_rng(seed)
    times = np.linspace(0.0, 2.0, count)
    ramp = ns.System(states=["x"], parameters={"k": 1.0}, equations={"x": "k"})
    return ramp, dataset(times, x=offset + k * times + level * rng.standard_normal(count))


@pytest.fixture(scope="module")
def long_record():
    """40 periods with 2 % of noise."""
    return soft_record(40, 0.02, 1)


@pytest.mark.few(1)
@pytest.mark.parametrize("segments", [1, 5])
def test_a_straight_line_is_linear_regression(segments):
    """Slope, its error and its t-interval are those of the closed form, in any segments."""
    ramp, record = line()
    found = ns.fit(ramp, record, {"k": (-5, 5)}, hold_back=0.0, starts=1, segments=segments)
    known = stats.linregress(record["time"], record["x"])
    assert float(found["estimate"][0]) == pytest.approx(known.slope, rel=1e-6)
    assert float(found["standard_error"][0]) == pytest.approx(known.stderr, rel=1e-3)
    half = stats.t.ppf(0.975, 48) * known.stderr
    # an end is found to 1 % of the rise of the cost, so to 0.5 % of the distance
    assert float(found["interval_high"][0]) == pytest.approx(known.slope + half, abs=0.006 * half)
    assert float(found["interval_low"][0]) == pytest.approx(known.slope - half, abs=0.006 * half)


@pytest.mark.slow
def test_many_segments_become_fewer_and_the_regression_stays():
    """120 segments would do for 6000 samples; no error grows in them, so half of them are left."""
    ramp, record = line(count=6000)
    found = ns.fit(ramp, record, {"k": (-5, 5)}, hold_back=0.0, starts=1)
    assert found.sizes["segment"] == 60
    known = stats.linregress(record["time"], record["x"])
    assert float(found["estimate"][0]) == pytest.approx(known.slope, rel=1e-6)
    assert float(found["standard_error"][0]) == pytest.approx(known.stderr, rel=1e-3)


@pytest.mark.slow
def test_forty_periods_are_fitted(long_record):
    """From all starts, spread over ranges of a factor of three, to the one optimum."""
    record, events = long_record
    assert len(events) > 30
    found = ns.fit(ns.models.soft_impact(), record, RANGES, {"x": "x"}, starts=3)
    assert found.attrs["status"] == "completed"
    assert found["start_agrees"].all()
    errors = found["estimate"] - [SOFT[name] for name in RANGES]
    assert (np.abs(errors) < 3.0 * found["standard_error"]).all()
    assert found.attrs["largest_gap"] < 1e-6
    # the standard deviation of 2400 normal values is known to 1.5 %; four of these
    level = 0.02 * record["x"].std()
    assert float(found["noise"][0]) == pytest.approx(float(level), rel=0.06)
    # 240 samples that the fit has not seen are as far off as the noise, to 4.6 %; four of these
    assert float(found["prediction_error"][0]) == pytest.approx(1.0, abs=0.2)
    assert float(found["whiteness"][0]) > 0.01


@pytest.mark.slow
def test_single_shooting_fails_on_forty_periods(long_record):
    """The same record in one segment: this is what multiple shooting is for.

    The start leads to a wrong minimum. Residuals there are as if forces were wrong, so that the
    interval is wide and its profile comes by a lower minimum, which the fit then takes and tells.
    """
    record, _ = long_record
    found = ns.fit(ns.models.soft_impact(), record, RANGES, {"x": "x"}, segments=1, starts=1)
    led = found["start_estimate"].isel(start=0).sel(parameter="beta")
    assert abs(float(led) - SOFT["beta"]) > 5.0
    assert not found["start_agrees"].any()
    assert "a profile led to this minimum and no start did" in found.attrs["message"]


@pytest.mark.slow
def test_acceleration_with_gain_offset_and_delay():
    """A sensor that shows 0.9 times the acceleration 0.05 late, and 0.2 more."""
    rng = np.random.default_rng(3)
    times = np.arange(0.0, 15 * PERIOD, PERIOD / 80)
    *_, late, _ = soft_motion(np.append(0.0, times + 0.05), [0.3, 0.1])
    shown = dataset(times + 0.1, a=noisy(0.9 * late[1:] + 0.2, 0.02, rng))
    found = ns.fit(
        ns.models.soft_impact(), shown, {"beta": (20, 40), "e": (1.1, 1.4)}, {"a": "acceleration"},
        gain="free", offset={"a": (-1.0, 1.0)}, delay={"a": (-0.1, 0.2)}, starts=2,
    )  # fmt: skip
    truth = {"beta": 29.0, "e": 1.26, "a gain": 0.9, "a offset": 0.2, "a delay": 0.05}
    assert list(found["parameter"].values) == list(truth)
    errors = np.abs(found["estimate"] - list(truth.values()))
    assert (errors < 4.0 * found["standard_error"]).all()


@pytest.mark.slow
def test_rigid_impacts_are_fitted():
    """Coefficient of restitution and place of the wall, from positions with 2 % of noise."""
    rng = np.random.default_rng(5)
    period = 2.0 * np.pi / RIGID["omega"]
    times = np.arange(0.0, 20 * period, period / 50)
    x, _, _, events = rigid_motion(times, [0.1, 0.2])
    assert len(events) > 10
    free = {"r": (0.5, 0.95), "sigma": (0.2, 0.6), "zeta": (0.01, 0.1)}
    found = ns.fit(
        ns.models.impact_oscillator(**RIGID), dataset(times, x=noisy(x, 0.02, rng)), free, starts=2
    )  # fmt: skip
    errors = np.abs(found["estimate"] - [RIGID[name] for name in free])
    assert (errors < 4.0 * found["standard_error"]).all()


@pytest.mark.slow
def test_a_mole_with_a_hidden_slider_is_fitted():
    """Nothing is seen of the slider, on which the mass lies where segments begin."""
    machine, truth = machines.moling(), {"a": 0.3, "b": 0.15, "xi": 0.05}
    times = np.arange(8 * 60) * machine.period / 60
    found = machines.motion(machine, times, [0.0, 0.0, 0.0, 0.0])
    assert {"contact", "progression"} <= set(found.modes)
    rng = np.random.default_rng(8)
    x = noisy(found.states[:, 0] + found.states[:, 3], 0.02, rng)
    record = dataset(times, x=x, a=noisy(found.rates[:, 1], 0.02, rng))
    free = {"a": (0.1, 0.6), "b": (0.05, 0.4), "xi": (0.01, 0.15)}
    system = ns.models.moling(omega=machines.MOLING["omega"])
    fitted = ns.fit(system, record, free, {"x": "p + v", "a": "acceleration"}, starts=1)
    errors = np.abs(fitted["estimate"] - list(truth.values()))
    assert (errors < 4.0 * fitted["standard_error"]).all()
    assert fitted.attrs["status"] == "completed"


@pytest.mark.slow
def test_a_rotor_in_its_ring_is_fitted():
    """Stiffness of the ring and damping of the rotor, from a start a third off."""
    changed = {"eta": 2.0, "delta_x": 0.05, "delta_y": 0.05}
    machine, truth = machines.rotor(**changed), {"K": 30.0, "nu1": 0.125}
    times = np.arange(6 * 50) * machine.period / 50
    found = machines.motion(machine, times, [0.0, 0.0, 0.0, 0.0])
    assert {"free", "II"} <= set(found.modes)
    rng = np.random.default_rng(9)
    shown = {name: noisy(found.states[:, k], 0.02, rng) for k, name in enumerate("xy")}
    free = {"K": (15, 65), "nu1": (0.05, 0.3)}
    system = ns.models.rotor(**changed)
    fitted = ns.fit(system, dataset(times, **shown), free, starts=1)
    errors = np.abs(fitted["estimate"] - list(truth.values()))
    assert (errors < 4.0 * fitted["standard_error"]).all()


def random_case(seed):
    """Record of a soft or rigid oscillator with parameters, length and noise by chance."""
    rng = np.random.default_rng(seed)
    share, periods = (0.01, 0.02, 0.05)[seed % 3], (5, 12, 40)[seed // 2 % 3]
    if seed % 2:
        truth = {
            "r": rng.uniform(0.5, 0.9), "sigma": rng.uniform(0.1, 0.5),
            "zeta": rng.uniform(0.02, 0.1), "omega": rng.uniform(0.9, 1.5),
        }  # fmt: skip
        motion, model, start = rigid_motion, ns.models.impact_oscillator, [-0.2, 0.1]
    else:
        truth = {
            "beta": rng.uniform(10, 40), "e": rng.uniform(0.4, 0.8),
            "zeta": rng.uniform(0.01, 0.05), "omega": rng.uniform(0.7, 1.0),
        }  # fmt: skip
        motion, model, start = soft_motion, ns.models.soft_impact, [0.3, 0.1]
    period = 2.0 * np.pi / truth["omega"]
    times = np.arange(0.0, periods * period, period / 50)
    x, _, _, events = motion(times, start, **truth)
    system = model(omega=truth.pop("omega"))
    return system, truth, dataset(times, x=noisy(x, share, rng)), len(events)


def is_right(seed):
    """Whether the fit of a case, in ranges of +-50 %, is within five standard errors."""
    system, truth, record, n_events = random_case(seed)
    assert n_events
    free = {name: (0.5 * each, min(1.5 * each, 0.99 if name == "r" else np.inf))
            for name, each in truth.items()}  # fmt: skip
    found = ns.fit(system, record, free, {"x": "x"}, starts=3, seed=seed)
    off = np.abs(found["estimate"] - list(truth.values())) / found["standard_error"]
    return bool(found.attrs["status"] == "completed" and (off < 5.0).all())


@pytest.mark.slow
def test_a_cut_near_an_impact_is_moved():
    """40 periods at a rigid wall with 5 % of noise: some impacts are at the ends of segments."""
    assert is_right(5)


@pytest.mark.slow
def test_nearly_all_records_lead_to_the_right_optimum():
    """At least 95 % of 40, with 3 to 80 impacts and 1 to 5 % of noise."""
    wrong = [seed for seed in range(40) if not is_right(seed)]
    assert len(wrong) <= 2, wrong


def two_springs():
    """A mass on two springs side by side."""
    return ns.System(
        states=["x", "v"], parameters={"k1": 1.0, "k2": 1.0, "c": 0.1},
        equations={"x": "v", "v": "-(k1 + k2)*x - c*v"},
    )  # fmt: skip


@pytest.mark.slow
def test_two_springs_are_not_told_apart():
    """Of k1 and k2 the sum alone counts."""
    times = np.linspace(0.0, 20.0, 300)
    rate = np.sqrt(4.0 - 0.05**2)
    x = np.exp(-0.05 * times) * np.cos(rate * times)
    record = dataset(times, x=noisy(x, 0.02, np.random.default_rng(2)))
    free = {"k1": (0.5, 4), "k2": (0.5, 3), "c": (0.01, 0.5)}
    found = ns.fit(two_springs(), record, free, starts=2)
    assert found["identified"].values.tolist() == [False, False, True]
    assert "determines k1 and k2 only together" in found.attrs["open_parameters"]
    assert "k1 rises by 1, k2 falls by 1" in found.attrs["message"]
    together = float(found["estimate"][:2].sum())
    assert together == pytest.approx(4.0, abs=0.02)  # the frequency is known to 1e-3
    assert abs(float(found["correlation"].sel(parameter="k1", parameter_0="k2"))) > 0.999


@pytest.mark.slow
def test_a_spring_that_is_never_met_is_not_determined():
    record, events = soft_record(8, 0.02, 1, e=100.0)
    assert not len(events)
    system = ns.models.soft_impact(e=100.0)
    found = ns.fit(system, record, {"beta": (15, 45), "zeta": (0.002, 0.05)}, {"x": "x"}, starts=1)
    assert found.attrs["open_parameters"] == "the record does not determine beta"
    assert found["identified"].values.tolist() == [False, True]
    assert found["interval_low"].values[0] == 15.0
    assert found["interval_high"].values[0] == 45.0


@pytest.mark.slow
def test_what_is_not_determined_is_open_in_coloured_noise_too():
    """A stop that is never met, beside residuals in which each sample remembers the one before."""
    times = np.linspace(0.0, 30.0, 600)
    noise = 0.01 * lfilter([0.6], [1.0, -0.8], np.random.default_rng(3).standard_normal(600))
    x = 0.5 * np.exp(-0.1 * times) * np.cos(2.0 * times) + noise
    stop = ns.System(
        states=["x", "v"],
        parameters={"k": 4.0, "gap": 5.0},
        equations={"x": "v", "v": "-k*x - 0.2*v - 30*max(x - gap, 0)"},
    )
    found = ns.fit(stop, dataset(times, x=x), {"k": (2, 6), "gap": (3, 9)}, starts=1)
    assert float(found["variance_ratio"].sel(parameter="k")) > 2.0
    assert found["identified"].values.tolist() == [True, False]
    assert "gap" in found.attrs["open_parameters"]
    gap = found.sel(parameter="gap")
    assert [float(gap["interval_low"]), float(gap["interval_high"])] == pytest.approx([3.0, 9.0])


@pytest.mark.slow
def test_samples_that_are_nan_are_left_out():
    """As if the record had no such samples."""
    ramp, record = line()
    holes = record.copy(deep=True)
    holes["x"][10:20] = np.nan
    options = {"hold_back": 0.0, "starts": 1, "segments": 2}
    one = ns.fit(ramp, holes, {"k": (-5, 5)}, **options)
    other = ns.fit(ramp, record.isel(time=np.r_[:10, 20:50]), {"k": (-5, 5)}, **options)
    assert np.allclose(one["estimate"], other["estimate"], rtol=1e-9)
    assert np.isnan(one["residual"][0, 10:20]).all()
    assert one.attrs["n_fitted"] == 40


@pytest.mark.slow
def test_samples_that_a_check_has_flagged_are_left_out():
    """A channel that freezes for a fifth of the record: the mask does what nan does."""
    ramp, record = line(count=400)
    record["x"][100:180] = float(record["x"][100])
    checked = ns.measured.check(record, leave_out="drift")
    assert checked["kind"].values.tolist() == ["frozen"]
    flagged = ns.measured.flagged(record, checked)
    gone = record.assign(x=record["x"].where(flagged["x_quality"] == 0))
    one, other = (ns.fit(ramp, each, {"k": (-5, 5)}, starts=1) for each in (flagged, gone))
    assert one["estimate"].item() == other["estimate"].item()
    low, high = one["interval_low"].item(), one["interval_high"].item()
    assert low < 0.7 < high


def test_outliers_count_less_with_a_robust_loss():
    """One sample in ten is off by 20 times the noise."""
    ramp, record = line(count=200)
    record["x"][::10] += 1.0 * np.linspace(0.0, 2.0, 20)
    options = {"hold_back": 0.0, "starts": 1, "segments": 1}
    plain, robust = (
        abs(float(ns.fit(ramp, record, {"k": (-5, 5)}, loss=loss, **options)["estimate"][0]) - 0.7)
        for loss in ("linear", "cauchy")
    )
    assert plain > 0.05
    assert robust < 0.02


def test_a_fit_that_has_not_converged_warns(monkeypatch):
    """No gap is as small as zero."""
    monkeypatch.setattr("nonsmooth.fitting.solver._CLOSED", 0.0)
    ramp, record = line()
    with pytest.warns(ns.ResultWarning, match="has not converged: segments do not join.*starts="):
        found = ns.fit(ramp, record, {"k": (-5, 5)}, starts=1)
    assert found.attrs["status"] == "not_converged"
    assert found.attrs["message"].startswith("not_converged: segments do not join")


@pytest.mark.parametrize("loss", ["soft_l1", "huber", "arctan"])
def test_every_loss_comes_near(loss):
    ramp, record = line()
    found = ns.fit(ramp, record, {"k": (-5, 5)}, loss=loss, starts=1, segments=2)
    assert float(found["estimate"][0]) == pytest.approx(0.7, abs=0.1)


def test_values_that_the_system_refuses_are_passed_by():
    """Half of the range is negative damping, at which the model refuses to run."""
    record, _ = soft_record(8, 0.01, 4)
    free = {"zeta": (-0.07, 0.06), "beta": (20, 40)}
    with pytest.warns(ns.ResultWarning, match=r"\(-0.07, 0.06\): zeta .* does not hold at -0.07: "):
        found = ns.fit(ns.models.soft_impact(), record, free, {"x": "x"}, starts=3)
    assert np.isinf(found["start_cost"]).any()
    errors = np.abs(found["estimate"] - [SOFT[name] for name in free])
    assert (errors < 4.0 * found["standard_error"]).all()


def test_bounds_in_which_the_system_is_not_allowed_are_told_before_the_fit():
    """k must be positive and less than m: a bound may lie on the border, or leave a corner out."""
    _, record = line()
    ramp = ns.System(
        states=["x"], parameters={"k": 1.0, "m": 2.0}, equations={"x": "k + 0*m"},
        require={"k > 0": "it grows", "k < m": "m is larger"},
    )  # fmt: skip
    with pytest.raises(ns.OptionError, match="free: k > 0 is required, and holds nowhere within"):
        ns.fit(ramp, record, {"k": (-2, -1)})
    with pytest.raises(ns.OptionError, match=r"k < m is required, .* of k, m: m is larger"):
        ns.fit(ramp, record, {"k": (3, 4), "m": (1, 3)})
    with pytest.warns(ns.ResultWarning, match="k < m is required, and does not hold at 3: m is"):
        ns.fit(ramp, record, {"k": (0, 3)}, starts=1)
    found = ns.fit(ramp, record, {"k": (0, 1.9)}, starts=1)
    assert float(found["estimate"][0]) == pytest.approx(0.7, abs=0.1)


def test_a_minimum_to_which_no_start_led_is_told():
    """The middle of the bounds is far from k = 4, and a profile of the minimum there finds it."""
    times = np.linspace(0.0, 6.0, 120)
    x = np.cos(2.0 * times) + np.random.default_rng(0).normal(0.0, 0.02, times.size)
    spring = ns.System(states=["x", "v"], parameters={"k": 4.0}, equations={"x": "v", "v": "-k*x"})
    record, options = dataset(times, x=x), {"initial": {"x": 1.0}, "segments": 1, "starts": 1}
    found = ns.fit(spring, record, {"k": (1, 20)}, {"x": "x"}, **options)
    assert float(found["estimate"][0]) == pytest.approx(4.0, abs=0.1)
    assert not found["start_agrees"].any() and float(found["start_estimate"][0, 0]) > 10.0
    assert "starts agree" not in found.attrs["message"]
    assert (
        "a profile led to this minimum and no start did: give more starts="
        in (found.attrs["message"])
    )


@pytest.mark.slow
def test_block_bootstrap_is_that_of_regression():
    """Blocks of residuals drawn by hand, and a line through them by another function.

    Both ends of an interval of 200 draws are known to about 10 % of its width.
    """
    ramp, record = line(count=200)
    found = ns.fit(ramp, record, {"k": (-5, 5)}, bootstrap=200, starts=1, segments=1)
    kept = ~found["held_back"].values[0]
    times, residual = found["time"].values[kept], found["residual"].values[0, kept]
    rng, length, drawn = np.random.default_rng(7), 11, []
    for _ in range(1000):
        first = rng.integers(0, residual.size, residual.size // length + 1)
        place = (first[:, None] + np.arange(length)).ravel()[: residual.size] % residual.size
        drawn.append(np.polyfit(times, residual[place], 1)[0])
    low, high = np.quantile(drawn, [0.025, 0.975])
    width = float((found["bootstrap_high"] - found["bootstrap_low"])[0])
    assert width == pytest.approx(high - low, rel=0.3)


@pytest.mark.slow
def test_noise_that_is_given_or_bounded_stays():
    ramp, record = line()
    one = ns.fit(ramp, record, {"k": (-5, 5)}, noise=0.2, starts=1)
    assert one["noise"].values.tolist() == [0.2]
    other = ns.fit(ramp, record, {"k": (-5, 5)}, noise={"x": (0.1, 0.3)}, starts=1)
    assert other["noise"].values.tolist() == [0.1]


@pytest.mark.parametrize(("noise", "told"), [(0.02, True), (0.05, False), (0.2, False)])
def test_residuals_larger_than_the_noise_that_is_given_are_told(noise, told):
    """The noise of the record is 0.05; 4.55 % of its residuals are more than twice that."""
    ramp, record = line()
    found = ns.fit(ramp, record, {"k": (-5, 5)}, noise=noise, starts=1, segments=1)
    assert ("more than twice the noise that noise= gives" in found.attrs["message"]) == told


@pytest.mark.slow
def test_a_result_comes_back_from_a_file(tmp_path):
    import xarray as xr

    ramp, record = line()
    found = ns.fit(ramp, record, {"k": (-5, 5)}, starts=2)
    again = ns.fit(ramp, record, {"k": (-5, 5)}, starts=2)
    assert found.identical(again)
    found.to_netcdf(tmp_path / "fit.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "fit.nc", engine="h5netcdf") as read:
        assert read["estimate"].values.tolist() == found["estimate"].values.tolist()


def in_units(model, record, gain=None, times="s"):
    """A fit of the line whose state is described in some unit to a record in another."""
    ramp, data = line()
    described = {"x": f"height [{model}]", "time": "time [s]"}
    ramp = ns.System(states=["x"], parameters={"k": 1.0}, equations={"x": "k"}, describe=described)
    data["x"].attrs["units"], data["time"].attrs["units"] = record, times
    return ns.fit(ramp, data, {"k": (-5, 5)}, gain=gain, starts=1, segments=1)


@pytest.mark.slow
def test_units_of_record_and_model_that_differ_are_told():
    said = in_units("mm", "um").attrs["message"]
    assert "x is in um and x of the model in mm, with a gain of 1: give gain=" in said
    said = in_units("mm", "mm", times="ms").attrs["message"]
    assert "times of the record are in ms and those of the model in s" in said
    for same in (
        ("mm", "mm"),
        ("um", "\N{MICRO SIGN}m"),
        ("1", "mm"),
        ("mm", ""),
        ("mm", "V", 2.0),
    ):
        assert "of the model" not in in_units(*same).attrs["message"]


def test_a_fit_keeps_the_units_of_the_record():
    found = in_units("mm", "um")
    for name in ("measured", "fitted", "residual"):
        assert found[name].attrs["units"] == "um"
    assert found["time"].attrs["units"] == found["segment_time"].attrs["units"] == "s"
    assert found["channel_units"].values.tolist() == ["um"]


def test_a_fit_says_what_each_channel_shows():
    """The words of the record, else those of the model for what it observes."""
    ramp, record = line()
    ramp = dataclasses.replace(ramp, describe={"x": "height of the ramp [m]"})
    record["probe"], record["sum"] = record["x"], record["x"]
    record["x"].attrs["long_name"] = "reading of the scale"
    shown = {"x": "x", "probe": "x", "sum": "x + k - k"}
    found = ns.fit(ramp, record, {"k": (-5, 5)}, shown, starts=1, segments=1)
    said = dict(zip(found["channel"].values, found["channel_quantity"].values, strict=True))
    assert said == {"x": "reading of the scale", "probe": "height of the ramp", "sum": ""}


def test_channels_in_units_of_their_own_have_no_common_one():
    ramp, record = line()
    record["x"].attrs["units"] = "mm"
    record["y"] = record["x"].assign_attrs(units="V")
    found = ns.fit(ramp, record, {"k": (-5, 5)}, {"x": "x", "y": "x"}, starts=1, segments=1)
    assert found["channel_units"].values.tolist() == ["mm", "V"]
    assert "units" not in found["measured"].attrs


BAD = [
    ({"free": {}}, "give the bounds of each parameter to be found"),
    ({"free": {"q": (0, 1)}}, r"free: unknown parameter 'q' \(known: k\)"),
    ({"parameters": {"k": 3.0}}, "the value of 'k' counts for nothing, since free gives its"),
    ({"free": {"k": 3.0}}, r"free\['k'\] = 3.0: give two numbers, \(low, high\)"),
    ({"free": {"k": (2, 1)}}, "the first must be below the second"),
    ({"free": {"k": (0, np.inf)}}, "not a finite number"),
    ({"record": 3}, "give a dataset over time"),
    ({"observe": {"y": "x"}}, r"observe: unknown channel 'y' \(known: x\)"),
    ({"observe": {"x": "y + 1"}}, "no expression of states, outputs, parameters and rates"),
    ({"observe": {"x": 1}}, "give an expression as a text"),
    ({"observe": "x"}, "give an expression of states, outputs and rates for each channel"),
    ({"gain": {"y": 1.0}}, r"gain: unknown channel 'y' \(known: x\)"),
    ({"gain": "loose"}, r"give a number, \(low, high\), free"),
    ({"gain": 0}, r"gain\['x'\] = 0: the channel would show nothing of the motion"),
    ({"delay": "free"}, r"delay\['x'\] = 'free': give a number or \(low, high\)"),
    ({"noise": 0.0}, "noise is a standard deviation, above zero"),
    ({"segments": 0}, "segments = 0 must be a whole number of at least 1"),
    ({"segments": 40}, "at most 22, half the samples that are fitted"),
    ({"hold_back": 0.95}, "hold_back = 0.95 must lie between 0 and 0.9"),
    ({"loss": "square"}, "give one of linear, soft_l1, huber, cauchy, arctan"),
    ({"starts": 0}, "starts = 0 must be a whole number of at least 1"),
    ({"seed": -1}, "seed = -1 must be a whole number, not negative"),
    ({"initial": {"z": 1}}, r"initial: unknown state 'z' \(known: x\)"),
    ({"form": "chaotic"}, "form = 'chaotic': give one of transient, steady"),
    ({"cycle": 2, "form": "transient"}, "cycle = 2: form='transient' has no cycle"),
    ({"cycle": 0}, "cycle = 0 must be a whole number of at least 1"),
    ({"form": "steady"}, "has no period, so nothing says after which time the motion repeats"),
]  # fmt: skip


@pytest.mark.parametrize(("options", "words"), BAD, ids=lambda each: str(each)[:30])
def test_bad_input_is_named_with_what_is_allowed(options, words):
    ramp, record = line()
    given = {"record": record, "free": {"k": (-5, 5)}} | options
    with pytest.raises(ns.OptionError, match=words):
        ns.fit(ramp, **given)


def test_records_that_cannot_be_fitted_are_refused():
    ramp, record = line()
    with pytest.raises(ns.OptionError, match="called like a state or an output"):
        ns.fit(ramp, record.rename(x="a1"), {"k": (-5, 5)})
    with pytest.raises(ns.OptionError, match="its times must be finite numbers that increase"):
        ns.fit(ramp, record.isel(time=slice(None, None, -1)), {"k": (-5, 5)})
    empty = record.copy(deep=True)
    empty["x"][5:] = np.nan
    with pytest.raises(ns.OptionError, match="5 samples are numbers without a flaw"):
        ns.fit(ramp, empty, {"k": (-5, 5)})
    with pytest.raises(ns.OptionError, match=r"'x'\]: 1e\+200 .* far too large beside any motion"):
        ns.fit(ramp, record.assign(x=("time", np.full(record.sizes["time"], 1e200))), {"k": (0, 1)})


@pytest.mark.parametrize(
    "options",
    [
        {"observe": {"x": "0*x + 1"}},
        {"observe": {"x": "k"}},
        {"gain": (-1, 0), "free": {"k": (1, 5)}},  # the record rises, so the gain goes to zero
    ],
    ids=["constant", "a parameter", "gain to zero"],
)
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_a_channel_that_shows_nothing_of_the_motion(options):
    """The state is not determined, nor is what only the motion tells of."""
    ramp, record = line()
    given = {"free": {"k": (-5, 5)}} | options
    found = ns.fit(ramp, record, starts=1, segments=1, **given)
    assert np.isfinite(found["estimate"]).all()
    undetermined = options.get("observe") != {"x": "k"}
    assert ("does not determine k" in found.attrs["message"]) == undetermined


def test_a_motion_that_begins_nowhere_is_an_error():
    """A root of a negative number all over the range."""
    ball = ns.System(
        states=["x", "v"], parameters={"d": -2.0}, equations={"x": "v", "v": "-sqrt(-1 - d)"}
    )
    record = dataset(np.linspace(0.0, 1.0, 40), x=np.linspace(1.0, 2.0, 40))
    with pytest.raises(ns.RunError, match="no motion could be computed from any of 2 starts"):
        ns.fit(ball, record, {"d": (0.1, 0.9)}, starts=2)


@pytest.mark.slow
def test_intervals_cover_as_often_as_they_say():
    """Of 80 intervals of 40 records 95 % hold the truth.

    The two of a record are nearly independent. A binomial number of 80 with 0.95 lies between 69
    and 80 with a probability above 0.998, whose lower end is checked; a coverage of 80 % would
    pass with 7 %.
    """
    least = int(stats.binom.ppf(0.001, 80, 0.95))
    hits = 0
    for seed in range(40):
        record, _ = soft_record(5, 0.03, 100 + seed, per_period=40)
        found = ns.fit(
            ns.models.soft_impact(), record, {"beta": (20, 40), "e": (1.1, 1.4)}, {"x": "x"},
            starts=1, hold_back=0.0,
        )  # fmt: skip
        hits += sum(within(found, SOFT).values())
    assert hits >= least


@pytest.mark.slow
def test_the_noise_of_a_channel_with_few_samples_is_not_too_small():
    """Two channels show one line; the second has eleven samples, by which two unknowns are found.

    The mean of 150 squares over their expectation, of nine degrees of freedom each, is known to
    0.039: three of these. Divided by the number of samples it would be 0.85.
    """
    ramp, _ = line()
    times = np.linspace(0.0, 2.0, 61)
    squares = []
    for seed in range(150):
        rng = np.random.default_rng(seed)
        shown = 0.3 + 0.7 * times + 0.05 * rng.standard_normal(61)
        few = np.where(np.arange(61) % 6 == 0, 0.3 + 0.7 * times, np.nan)
        few += 0.002 * rng.standard_normal(61)
        found = ns.fit(
            ramp, dataset(times, x=shown, few=few), {"k": (-5, 5)}, {"x": "x", "few": "x"},
            hold_back=0.0, starts=1, segments=1,
        )  # fmt: skip
        squares.append((float(found["noise"][1]) / 0.002) ** 2)
    assert np.mean(squares) == pytest.approx(1.0, abs=0.117)
    assert "the noise of few is found from 11 data" in found.attrs["message"]
