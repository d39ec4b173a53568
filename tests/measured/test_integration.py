"""Double integrals of known accelerations: closed forms, and runs of the two-mass rig."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns

OMEGA = 2 * np.pi * 19.15  # rad/s, as the chapter's rig
FIG_25 = {"eta": 2.5, "lambda1": 4.36, "lambda2": 4.36, "f1": 5.44, "f2": 3.52}


def motion(t, order: int):
    """Motion of mean zero with three harmonics, or a derivative of it."""
    return sum(
        a * (j * OMEGA) ** order * np.cos(j * OMEGA * t + phase + order * np.pi / 2)
        for j, a, phase in ((1, 2.8, 0.3), (2, 0.4, -1.0), (5, 0.1, 2.0))
    )


def data(t, values, units="mm/s^2") -> xr.Dataset:
    return xr.Dataset(
        {"acceleration1": ("time", values, {"units": units})},
        {"time": ("time", t, {"units": "s"})},
    )


@pytest.mark.parametrize("rate", [997.0, 19.15 * 64, 5000.0])
@pytest.mark.parametrize("periods", [2.0, 7.37, 40.0])
def test_periodic_accelerations_with_offset_and_drift_are_integrated_exactly(rate, periods):
    """Also where samples do not fit the period; 1e-10 is rounding times 1/(1 rad/sample)^2."""
    t = 3.0 + np.arange(int(np.ceil(periods * rate / 19.15)) + 1) / rate
    wrong = motion(t, 2) + 5e3 - 40.0 * t
    found = ns.measured.displacements(data(t, wrong), "acceleration1", period=1 / 19.15)
    np.testing.assert_allclose(found["x1"], motion(t, 0), atol=1e-9)
    np.testing.assert_allclose(found["vx1"], motion(t, 1), atol=1e-7)
    assert found["x1"].attrs["residual"] < 1e-6
    assert found["x1"].attrs["units"] == "mm" and found["vx1"].attrs["units"] == "mm/s"


def test_a_mean_remains_unknown_in_a_single_period():
    t = np.arange(64) / 64 / 19.15
    found = ns.measured.displacements(
        data(t, motion(t, 2) + 7.0), "acceleration1", period=1 / 19.15
    )
    np.testing.assert_allclose(found["x1"], motion(t, 0), atol=1e-11)


def test_noise_of_a_periodic_record_is_that_of_its_gain():
    t = np.arange(4000) / 1000.0
    errors, noise = [], []
    for seed in range(12):
        added = np.random.default_rng(seed).normal(0, 500.0, t.size)
        found = ns.measured.displacements(
            data(t, motion(t, 2) + added), "acceleration1", period=1 / 19.15
        )["x1"]
        errors.append(np.mean((found - motion(t, 0)) ** 2))
        noise.append(found.attrs["noise"])
    truth = np.sqrt(np.mean(errors))
    assert found.attrs["noise_gain"] * 500.0 == pytest.approx(truth, rel=0.25)
    assert np.mean(noise) == pytest.approx(truth, rel=0.3)


@pytest.mark.parametrize("bias", [0.01, 0.5])
@pytest.mark.parametrize("times", [1.0, 2.0, 10.0, 50.0])
def test_sines_lose_what_the_bias_says(bias, times):
    """1/(1 + b/(1 - b) (lowest/f)^4) of a sine is left, b at the lowest frequency itself."""
    lowest, rate = 2.0, 2000.0
    t = np.arange(24_000) / rate
    omega = 2 * np.pi * lowest * times
    record = data(t, -(omega**2) * np.cos(omega * t + 0.4) + 10 * omega**2)
    found = ns.measured.displacements(record, "acceleration1", lowest=lowest, bias=bias)
    inner = found.sel(time=slice(4.0, 8.0))  # two edges away from the ends: 1e-4 of an end is left
    left = 1 / (1 + bias / (1 - bias) / times**4)
    assert found["x1"].attrs["edge"] < 2.0
    numerical = (omega / rate) ** 4 / 240
    sine = np.cos(omega * inner["time"] + 0.4)
    np.testing.assert_allclose(inner["x1"], left * sine, atol=2e-4 + 2 * numerical)
    slope = -np.sin(omega * inner["time"] + 0.4)
    np.testing.assert_allclose(inner["vx1"] / omega, left * slope, atol=2e-4 + 8 * numerical)


@pytest.mark.parametrize("lasts", [8.0, 30.0])
def test_an_offset_and_a_straight_drift_change_nothing(lasts):
    """Not the ends either; 1e-7 is rounding of 1e6 mm/s^2 over the square of the corner, 100/s^2.

    Without it the drift would leave 9810 mm/s^2 / (10/s)^2 at an end, and a hundredth behind the
    edge, the more the longer it lasts.
    """
    t = np.arange(int(1000 * lasts)) / 1000.0
    for edges in ("keep", "cut"):
        options = {"lowest": 5.0, "edges": edges}
        plain, *others = (
            ns.measured.displacements(data(t, motion(t, 2) + more), "acceleration1", **options)
            for more in (0.0, 9810.0, 9810.0 * (t / 20.0), 500.0 - 20.0 * t)
        )
        for other in others:
            np.testing.assert_allclose(other["x1"], plain["x1"], atol=1e-7)
            np.testing.assert_allclose(other["vx1"], plain["vx1"], atol=1e-5)


@pytest.mark.parametrize("phase", [0.0, 1.0, 2.0])
@pytest.mark.parametrize("lasts", [1.5, 2.0, 2.05])
def test_a_motion_of_no_whole_period_makes_no_drift(lasts, phase):
    """A sine of f loses l = r/(1 + r) of itself, r = b/(1 - b) (lowest/f)^4, and no more inside.

    Second and third derivatives of the displacement agree with those of the reading at an end, so
    the end does up to sqrt(2) l (f/f_c)^3 with the corner f_c, and a hundredth behind the edge.
    """
    t = np.arange(int(1000 * lasts)) / 1000.0
    f, corner = 5.3, 5.0 * (0.01 / 0.99) ** 0.25
    sine = np.cos(2 * np.pi * f * t + phase)
    record = data(t, -((2 * np.pi * f) ** 2) * sine)
    found = ns.measured.displacements(record, "acceleration1", lowest=5.0)["x1"]
    ratio = (corner / f) ** 4
    lost = ratio / (1 + ratio)
    kept = np.isin(np.round(1000 * t), np.round(1000 * found["time"]))
    error = np.abs(found.values - sine[kept])
    assert error.max() < lost * (1 + 0.01 * np.sqrt(2) * (f / corner) ** 3)


def test_a_flaw_that_is_flagged_makes_no_drift():
    """It is felt about itself only, and an end is far away."""
    t = np.arange(20_000) / 1000.0
    spiked = motion(t, 2)
    spiked[15_000] += 1e7
    flags = np.zeros(t.size, np.uint8)
    flags[15_000] = 1
    records = [data(t, motion(t, 2)), data(t, spiked)]
    for record in records:
        record["acceleration1_quality"] = ("time", flags)
    options = {"lowest": 5.0, "edges": "keep"}
    plain, found = (
        ns.measured.displacements(each, "acceleration1", **options)["x1"] for each in records
    )
    np.testing.assert_allclose(found[:5000], plain[:5000], atol=1e-6)


def test_noise_of_an_aperiodic_record_is_that_of_its_gain():
    t = np.arange(200_000) / 1000.0
    noise = np.random.default_rng(0).normal(0, 1.0, t.size)
    for lowest, bias in ((5.0, 0.01), (5.0, 0.5), (20.0, 0.2)):
        both = ns.measured.displacements(data(t, noise), "acceleration1", lowest=lowest, bias=bias)
        for found in (both["x1"], both["vx1"]):
            gain = found.attrs["noise_gain"]
            assert float(found.std()) == pytest.approx(gain, rel=0.1)
            assert found.attrs["noise"] == pytest.approx(gain, rel=0.02)


def test_noise_that_a_low_pass_has_smoothed_still_counts():
    """Below the cut-off it is as strong as before, and there the integral takes it from."""
    t = np.arange(60_000) / 1000.0
    noise = np.random.default_rng(2).normal(0, 1.0, t.size)
    smooth = ns.measured.low_pass(data(t, noise), 100.0)
    found = ns.measured.displacements(smooth, "acceleration1", lowest=5.0)["x1"]
    assert float(found.std()) == pytest.approx(found.attrs["noise"], rel=0.15)


def test_scaling_before_and_after_integration_is_the_same():
    """What has been integrated in mm and s, then scaled, against integration without units."""
    t = np.arange(4000) / 1000.0
    noisy = motion(t, 2) + np.random.default_rng(0).normal(0, 50.0, t.size)
    marks = np.arange(0.1, 3.9, 1 / 19.15)
    record = ns.measured.from_arrays({"a": noisy}, times=t, marks=marks, units="mm/s^2")
    length, rate = 2.8, 50.0
    bare = ns.measured.from_arrays(
        {"a": noisy / length / rate**2}, times=t * rate, marks=marks * rate
    )
    for options in ({"lowest": 5.0}, {"period": 1 / 19.15}):
        later = ns.measured.dimensionless(
            ns.measured.displacements(record, "a", **options),
            length=length,
            natural_frequency=rate,
        )
        units = {"lowest": 1 / rate, "period": rate}
        first = ns.measured.displacements(
            bare, "a", **{key: value * units[key] for key, value in options.items()}
        )
        for name in ("x_a", "vx_a"):
            np.testing.assert_allclose(later[name], first[name], atol=1e-9)
            for key in {"noise_gain", "noise", "lowest", "edge", "period", "residual"} & set(
                first[name].attrs
            ):
                assert later[name].attrs[key] == pytest.approx(first[name].attrs[key], rel=1e-6)


@pytest.fixture(scope="module")
def held():
    """Steady motion of the rig whose masses stay on the specimen: smooth accelerations."""
    rig = ns.models.fatigue_rig(f1=60.0, f2=60.0)
    run = ns.simulate(rig, periods=120, samples_per_period=128)
    steady = run.isel(time=slice(80 * 128, None))
    assert float(steady["contact1"].min()) > 0 and float(steady["contact2"].min()) > 0
    return steady


def with_faults(run: xr.Dataset, noise: float) -> xr.Dataset:
    """Readings with noise, an offset and a drift."""
    rng = np.random.default_rng(5)
    found = run.copy()
    for name in ("acceleration1", "acceleration2"):
        size = noise * float(np.abs(run[name]).max())
        added = rng.normal(0, size, run.sizes["time"]) + 2.0 - 0.01 * run["time"].values
        found[name] = run[name] + added
    return found


def test_masses_that_stay_on_the_specimen(held):
    """Periodic to rounding by then, and harmonics fade: the displacements are those of the run."""
    readings = with_faults(held, 0.0)
    found = ns.measured.displacements(
        readings, {"acceleration1": "x1", "acceleration2": "x4"}, period=held.attrs["period"]
    )
    for name, truth in (("x1", "X1"), ("x4", "X4")):
        middle = held[truth] - held[truth][:-1].mean()
        np.testing.assert_allclose(found[name], middle, atol=1e-6)
    np.testing.assert_allclose(found["vx1"], held["X2"], atol=1e-5)
    assert found["x1"].attrs["units"] == "A_b" and found["vx1"].attrs["units"] == "A_b omega_Ls"


@pytest.mark.parametrize("route", [{}, {"low_pass": True}, {"lowest": True}])
def test_the_route_of_fig_25(route):
    """Relative accelerations with 1 % of noise, offset and drift, against the displacements."""
    rig = ns.models.fatigue_rig(**FIG_25)
    period = rig.period_value
    run = ns.simulate(rig, periods=140, samples_per_period=128).isel(time=slice(80 * 128, None))
    readings = with_faults(run, 0.01)
    if "low_pass" in route:
        readings = ns.measured.low_pass(readings, 30 / period, variables="acceleration1")
    how = {"lowest": 0.5 / period} if "lowest" in route else {"period": period}
    found = ns.measured.displacements(readings, "acceleration1", **how)
    # away from the ends, and compared without the mean, which accelerations do not tell
    found = found.isel(time=slice(1000, -1000))
    truth = run["X1"].sel(time=found["time"])
    away = (found["x1"] - found["x1"].mean()) - (truth - truth.mean())
    assert float(away.std()) < 1.2 * found["x1"].attrs["noise"] + 1e-3 * float(np.ptp(truth.values))
    assert float(away.std()) < 0.03 * float(np.ptp(truth.values))
    rate = run["X2"].sel(time=found["time"])
    assert float(np.abs(found["vx1"] - rate).max()) < 0.04 * float(np.ptp(rate.values))


@pytest.mark.parametrize(
    ("unit", "time", "first", "second"),
    [
        ("m/s^2", "s", "m", "m/s"),
        ("mm/s2", "s", "mm", "mm/s"),
        ("m/s²", "s", "m", "m/s"),
        ("mm s^-2", "s", "mm", "mm/s"),
        ("mm s⁻²", "s", "mm", "mm/s"),
        ("A_b omega^2", "", "A_b", "A_b omega"),
        ("m/s/s", "s", "m", "m/s"),
        ("mm/s**2", "", "mm", "mm/s"),
        ("µm·s⁻²", "s", "µm", "µm/s"),
        ("g", "s", "m", "m/s"),
        ("g_n", "s", "m", "m/s"),
        ("", "s", "", ""),
    ],
)
def test_units(unit, time, first, second):
    t = np.arange(200) / 1000.0
    record = data(t, motion(t, 2), unit)
    record["time"].attrs["units"] = time
    found = ns.measured.displacements(record, "acceleration1", period=1 / 19.15)
    assert found["x1"].attrs.get("units", "") == first
    assert found["vx1"].attrs.get("units", "") == second


@pytest.mark.parametrize(
    ("unit", "time", "words"),
    [
        ("mm", "s", "is in 'mm', which is no unit of an acceleration; known are g, .*m/s"),
        ("m/s", "s", "no unit of an acceleration"),
        ("V", "s", "no unit of an acceleration"),
        ("mg", "s", "no unit of an acceleration"),
        ("mm s^2", "s", "no unit of an acceleration"),
        ("m/s^2", "ms", "the time in 'ms'; give the time in s"),
        ("g", "ms", "give the time in s"),
    ],
)
def test_units_of_no_acceleration_are_refused(unit, time, words):
    t = np.arange(200) / 1000.0
    record = data(t, motion(t, 2), unit)
    record["time"].attrs["units"] = time
    with pytest.raises(ns.OptionError, match=words):
        ns.measured.displacements(record, "acceleration1", period=1 / 19.15)


@pytest.mark.parametrize("how", [{"lowest": 5.0}, {"period": 1 / 19.15}])
def test_readings_in_g_are_those_in_metres(how):
    """Standard gravity is 9.80665 m/s^2 by definition; what noise costs is told per m/s^2."""
    t = np.arange(4000) / 1000.0
    noisy = motion(t, 2) + np.random.default_rng(0).normal(0, 50.0, t.size)
    metres = ns.measured.displacements(data(t, noisy, "m/s^2"), "acceleration1", **how)
    gravities = ns.measured.displacements(data(t, noisy / 9.80665, "g"), "acceleration1", **how)
    for name in ("x1", "vx1"):
        np.testing.assert_allclose(gravities[name], metres[name], rtol=1e-9, atol=1e-9)
        assert gravities[name].attrs["units"] == metres[name].attrs["units"]
        for key in {"noise", "noise_gain", "residual"} & set(metres[name].attrs):
            assert gravities[name].attrs[key] == pytest.approx(metres[name].attrs[key], rel=1e-9)


def test_the_unit_is_that_of_the_acceleration_from_arrays_and_files(tmp_path):
    t = np.arange(400) / 1000.0
    for unit, length in (("m/s²", "m"), ("mm/s²", "mm"), ("g", "m")):
        rows = "\n".join(f"{a:.3f},{b:.6f}" for a, b in zip(t, motion(t, 2), strict=True))
        (tmp_path / "a.csv").write_text(f"time [s],A [{unit}]\n{rows}", encoding="utf-8")
        for record in (
            ns.measured.read_csv(tmp_path / "a.csv", {"a": "A"}),
            ns.measured.from_arrays({"a": motion(t, 2)}, times=t, units=unit),
        ):
            found = ns.measured.displacements(record, {"a": "z"}, period=1 / 19.15)
            assert found["z"].attrs["units"] == length
            assert found["vz"].attrs["units"] == f"{length}/s"


def test_names_that_the_data_have_are_refused():
    t = np.arange(400) / 1000.0
    record = ns.measured.from_arrays({"a": motion(t, 2), "vy": motion(t, 1)}, times=t)
    for given, taken in (({"a": "a"}, "a"), ({"a": "vy"}, "vy"), ({"a": "y"}, "vy")):
        with pytest.raises(ns.OptionError, match=f"have '{taken}' already.* such as .'a': 'z1'"):
            ns.measured.displacements(record, given, period=1 / 19.15)


def test_a_record_goes_on_to_its_section():
    t = np.arange(4000) / 1000.0
    record = ns.measured.from_arrays(
        {"a": motion(t, 2)}, times=t, marks=np.arange(0.1, 3.9, 1 / 19.15), units="mm/s^2"
    )
    found = ns.measured.displacements(record, "a", lowest=5.0)
    assert {"x_a", "vx_a"} == set(found.data_vars)
    points = ns.measured.section(found)
    np.testing.assert_allclose(points["x_a"], motion(points["time"].values, 0), atol=0.03)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, "give lowest=.* or period="),
        ({"lowest": 5.0, "period": 0.05}, "give lowest=.* or period="),
        ({"lowest": 300.0}, "below a quarter of the sample rate, 250"),
        ({"lowest": 0.0}, "must be positive"),
        ({"lowest": 0.5}, "not sure at the ends"),
        ({"lowest": 1e-3}, "too low for 1000 samples"),
        ({"lowest": 5.0, "bias": 1.0}, "between 0 and 1"),
        ({"lowest": 5.0, "drift": 1}, "go with period="),
        ({"lowest": 5.0, "edges": "reflect"}, "'cut' or 'keep'"),
        ({"period": 5.0}, "longer than the data"),
        ({"period": 0.002}, "holds 2 samples"),
        ({"period": 0.05, "highest": 600.0}, "below half the sample rate"),
        ({"period": 0.05, "drift": 7}, "from 0 to 5"),
        ({"period": 0.7, "drift": 1}, "less than two periods"),
    ],
)
def test_errors(options, words):
    t = np.arange(1000) / 1000.0
    with pytest.raises(ns.OptionError, match=words):
        ns.measured.displacements(data(t, motion(t, 2)), "acceleration1", **options)
    with pytest.raises(ns.OptionError, match="accelerations"):
        ns.measured.displacements(data(t, motion(t, 2)), "acceleration3", period=0.05)
