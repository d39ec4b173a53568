"""Points, velocities and diagrams against motions in closed form, and against a simulated rotor."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from measured import rigs
from nonsmooth.errors import OptionError
from nonsmooth.measured.sections import interpolated

RATE = 10_000.0
TIMES = np.arange(60_000) / RATE
MARKS = rigs.jittering_marks(85)
NOISE, STEP = 2e-3, 1e-3  # mm: standard deviation, and step of the digital reading
STEEP = 1.25  # sum of the sizes of the weights of a cubic through four samples
ROUGH = 3 / 128  # of the fourth derivative by the step, its error in the middle


def recorded(noise=0.0, step=0.0, seed=1):
    x = rigs.derivative(TIMES, 0) + noise * np.random.default_rng(seed).standard_normal(TIMES.size)
    x = np.round(x / step) * step if step else x
    return ns.measured.from_arrays({"x": x}, times=TIMES, marks=MARKS, units="mm")


def test_points_and_velocities_are_those_of_the_motion():
    """Without noise, what is left is truncation of filter and interpolation."""
    record = ns.measured.velocities(recorded(), highest=80.0)
    filter = ns.measured.Differentiator(1 / RATE, record["vx"].attrs["window"])
    points = ns.measured.section(record)
    np.testing.assert_array_equal(points["time"], MARKS[: points.sizes["point"]])
    bound = ROUGH / RATE**4 * rigs.largest(4) + 1e-13
    away = np.abs(points["x"].values - rigs.derivative(points["time"].values, 0))
    assert 0.1 * bound < away.max() < bound
    bound = STEEP * filter.truncation(5, rigs.largest(5)) + ROUGH / RATE**4 * rigs.largest(5)
    away = np.abs(points["vx"].values - rigs.derivative(points["time"].values, 1))
    assert 0.1 * bound < away.max() < bound


def test_a_record_without_marks_goes_as_far_as_it_can():
    """Rates and scales want no marks; what is taken once per revolution says that it does."""
    bare = ns.measured.from_arrays({"x": rigs.derivative(TIMES, 0)}, times=TIMES, units="mm")
    marked = recorded()
    for how in (
        {"highest": 80.0},
        {"differentiator": ns.measured.Differentiator(1 / RATE, 21)},
    ):
        rates = [ns.measured.velocities(one, **how)["vx"] for one in (bare, marked)]
        np.testing.assert_array_equal(*rates)
    scaled = [
        ns.measured.dimensionless(one, length=0.5, natural_frequency=50.0) for one in (bare, marked)
    ]
    np.testing.assert_array_equal(*(one["x"] for one in scaled))
    assert scaled[0].attrs["sample_rate"] == RATE / 50.0 and "speed" not in scaled[0].attrs
    np.testing.assert_array_equal(*(ns.measured.low_pass(one, 80.0)["x"] for one in (bare, marked)))
    with pytest.raises(OptionError, match=r"no marks .* give highest="):
        ns.measured.velocities(bare)
    for verb in (
        ns.measured.section,
        ns.measured.synchronous,
        lambda one: ns.measured.diagram([one]),
    ):
        with pytest.raises(OptionError, match=r"no marks of revolutions, and .* mark=.* marks="):
            verb(bare)
    with pytest.raises(OptionError, match="give a result of"):
        ns.measured.velocities(ns.measured.synchronous(marked), highest=80.0)


def test_harmonics_are_biased_as_stated():
    record = ns.measured.velocities(recorded(), highest=46.0, bias=0.02)
    filter = ns.measured.Differentiator(1 / RATE, record["vx"].attrs["window"])
    t = record["time"].values
    wanted = np.zeros_like(t)
    for j, a in rigs.AMPLITUDES.items():
        rate = -a * j * rigs.SPEED * np.sin(j * rigs.SPEED * t + rigs.PHASES[j])
        wanted += (1 + filter.bias(15.0 * j)) * rate
    np.testing.assert_allclose(record["vx"], wanted, atol=1e-9 * rigs.largest(1))
    assert record["vx"].attrs["highest"] >= 46.0
    assert 0.01 < -filter.bias(45.0) <= 0.02


@pytest.mark.parametrize("order", [2, 4, 6])
def test_noise_is_as_stated(order):
    """Standard deviations of points over many records, and the noise told of each."""
    errors, told = [], []
    for seed in range(12):
        record = ns.measured.velocities(recorded(NOISE, STEP, seed), highest=60.0, order=order)
        points = ns.measured.section(record)
        clean = ns.measured.section(ns.measured.velocities(recorded(), highest=60.0, order=order))
        errors.append([(points[n] - clean[n]).values for n in ("x", "vx")])
        told.append([record[n].attrs["noise"] for n in ("x", "vx")])
    sigma = np.hypot(NOISE, STEP / np.sqrt(12))  # the reading rounds to whole steps
    of_x, of_v = np.array(errors).std(axis=(0, 2))
    gain = record["vx"].attrs["noise_gain"]
    # 12 x 84 points: their standard deviation scatters by 2.2 %; interpolation takes off a little
    assert 0.7 * sigma < of_x < 1.07 * sigma
    assert of_v == pytest.approx(gain * sigma, rel=0.09)
    np.testing.assert_allclose(np.mean(told, axis=0), [sigma, gain * sigma], rtol=0.03)


def test_interpolation_is_as_good_as_told():
    """Of s**4 the cubic through four samples is off by 9/16 in the middle, and less elsewhere."""
    places = np.linspace(1, 8, 701)
    away = np.abs(interpolated(np.arange(10.0) ** 4, places) - places**4)
    assert away.max() == pytest.approx(24 * ROUGH, rel=1e-9)
    assert np.argmax(away) % 100 == 50
    ends = np.array([0.0, 0.3, 8.6, 9.0])
    cubic = interpolated(np.arange(10.0) ** 3, ends)
    np.testing.assert_allclose(cubic, ends**3, atol=1e-10)


def test_phase_and_transient():
    record = recorded()
    points = ns.measured.section(record, phase=0.25, transient=4)
    times = MARKS[4:-1] + 0.25 * np.diff(MARKS[4:])
    np.testing.assert_allclose(points["time"], times, rtol=1e-14)
    np.testing.assert_allclose(points["speed"], 2 * np.pi / np.diff(MARKS[4:]), rtol=1e-12)
    np.testing.assert_allclose(points["x"], rigs.derivative(times, 0), atol=1e-6)
    assert points.attrs["phase"] == 0.25 and points.attrs["transient"] == 4


def test_scaling_and_differentiation_commute():
    scale = {"length": 0.5, "natural_frequency": 90.0, "origin": {"x": 0.1}}
    record = recorded(NOISE)
    one = ns.measured.velocities(ns.measured.dimensionless(record, **scale), highest=60 / 90.0)
    other = ns.measured.dimensionless(ns.measured.velocities(record, highest=60.0), **scale)
    xr.testing.assert_allclose(one, other, rtol=1e-9)
    for name in ("x", "vx"):
        assert set(one[name].attrs) == set(other[name].attrs)
        for key, value in one[name].attrs.items():
            told = other[name].attrs[key]
            assert value == (told if isinstance(told, str) else pytest.approx(told, rel=1e-6))
    for key in ("speed", "speed_spread", "sample_rate", "mark_error"):
        assert one.attrs[key] == pytest.approx(other.attrs[key], rel=1e-12)
    assert one.attrs["speed"] == pytest.approx(record.attrs["speed"] / 90)
    assert "units" not in one["x"].attrs and "units" not in one["time"].attrs


def test_a_wandering_speed_leaves_lines_sharp():
    """Motion locked to the shaft: at equal angles its harmonics fall on single lines."""
    angle = rigs.SPEED * TIMES + 0.6 * np.sin(2.0 * TIMES)
    turns = 2 * np.pi * np.arange(1, 89)
    marks = np.interp(turns, angle, TIMES)
    for _ in range(5):  # Newton's method on the angle
        marks -= (rigs.SPEED * marks + 0.6 * np.sin(2 * marks) - turns) / (
            rigs.SPEED + 1.2 * np.cos(2 * marks)
        )
    x = 0.8 * np.cos(angle) + 0.25 * np.cos(3 * angle)
    record = ns.measured.velocities(
        ns.measured.from_arrays({"x": x}, times=TIMES, marks=marks), highest=100.0
    )
    even = ns.measured.synchronous(record, 128)
    found = ns.power_spectrum(even, "x")["amplitude"].swap_dims(frequency="harmonic")
    # within a revolution the speed is taken as constant: an angle off by at most |angle''| T^2/8
    off = 0.6 * 4.0 * (2 * np.pi / 92.0) ** 2 / 8
    assert float(found.sel(harmonic=1.0)) == pytest.approx(0.8, abs=0.8 * off + 2e-5)
    assert float(found.sel(harmonic=3.0)) == pytest.approx(0.25, abs=0.25 * 3 * off + 2e-5)
    others = found.where(~found["harmonic"].isin([1.0, 3.0]), 0.0)
    assert float(others.max()) < 2 * (0.8 + 0.25 * 3) * off
    number = even["period_number"].values
    assert np.all(np.diff(number[::128]) == 1) and even.attrs["period"] == pytest.approx(
        2 * np.pi / record.attrs["speed"]
    )
    np.testing.assert_allclose(
        even["time"], even["period_number"] * even.attrs["period"] + even["phase"], atol=1e-12
    )
    at_marks = even["measured_time"].values[even["phase"].values == 0.0]
    np.testing.assert_allclose(at_marks, marks[-at_marks.size :], atol=1e-12)


def run_up(rate=4000.0, seconds=4.0):
    """From 10 to 30 Hz, with an order 1 and an order 2.5; marks and speeds in closed form."""
    t = np.arange(int(rate * seconds)) / rate
    gain = 20.0 / seconds  # Hz/s
    angle = 2 * np.pi * (10.0 * t + 0.5 * gain * t**2)
    turns = np.arange(1, int(angle[-1] / 2 / np.pi))
    marks = (-10.0 + np.sqrt(100.0 + 2.0 * gain * turns)) / gain
    x = np.cos(angle) + 0.5 * np.cos(2.5 * angle)
    return ns.measured.from_arrays({"x": x}, times=t, marks=marks, units="mm"), marks


def test_blocks_of_a_measured_run_up_are_where_they_were():
    """Each has the frequency, the speed and the time of its own revolutions."""
    record, marks = run_up()
    even, count = ns.measured.synchronous(record), 8
    found = ns.order_tracking(even, "x", periods=count)
    assert found.attrs["parameter"] == "measured_time"
    ends = marks[: marks.size - (marks.size - 1) % count : count]
    np.testing.assert_allclose(found["time"], (ends[1:] + ends[:-1]) / 2, rtol=1e-12)
    first = found["frequency"].sel(harmonic=1.0)
    np.testing.assert_allclose(first, count / np.diff(ends), rtol=1e-9)
    assert first[0] < 12.5 and first[-1] > 27.0 and first.attrs["units"] == "Hz"
    np.testing.assert_allclose(found["amplitude"].sel(harmonic=[1.0, 2.5])[:, 0], 1.0, atol=0.01)
    np.testing.assert_allclose(found["amplitude"].sel(harmonic=[1.0, 2.5])[:, 1], 0.5, atol=0.01)

    over = ns.order_tracking(even, "x", over="speed", periods=count)
    speeds = 2 * np.pi / np.diff(marks)
    # a block begins one sample after its mark and ends at the next one, of the next revolution
    shift = (speeds[count] - speeds[0]) / (64 * count)
    assert over["parameter"][0] == pytest.approx(speeds[:count].mean() + shift, rel=1e-12)
    assert over["parameter"].attrs["units"] == "rad/s"
    same = ns.order_tracking(even, "x", over="time", periods=count)
    xr.testing.assert_identical(same, found)
    with pytest.raises(OptionError, match=r"unknown coordinate 'w' \(known: measured_time, speed"):
        ns.order_tracking(even, "x", over="w")


def test_orders_of_a_whole_record_have_the_frequency_of_the_mean_speed():
    record, _ = run_up()
    found = ns.power_spectrum(ns.measured.synchronous(record), "x")
    assert found["frequency"].attrs["long_name"] == "frequency at the mean speed"
    ax = ns.plot.spectrum(found)
    assert ax.get_xlabel() == "frequency at the mean speed [Hz]"


def test_periods_of_a_measured_run_up_begin_when_they_did():
    record, marks = run_up()
    found = ns.period_statistics(ns.measured.synchronous(record), "x")
    np.testing.assert_allclose(found["begin"], marks[: found.sizes["period"]], rtol=1e-12)
    np.testing.assert_allclose(
        found["speed"], 2 * np.pi / np.diff(marks)[: found.sizes["period"]], rtol=1e-9
    )
    ax = ns.plot.statistics(found, "x_amplitude", over="speed")
    assert ax.get_xlabel() == "speed [rad/s]"


def test_analyses_take_measured_points():
    """A circle map with an irrational turn per mark is regular; its section is a closed curve."""
    w = rigs.SPEED
    marks = np.arange(1, 1500) * 2 * np.pi / w
    t = np.arange(int(marks[-1] * 2000) + 40) / 2000
    x = np.cos(w * t) + 0.5 * np.cos(w * t / np.sqrt(3.0))
    record = ns.measured.velocities(ns.measured.from_arrays({"x": x}, times=t, marks=marks))
    points = ns.measured.section(record)
    assert abs(ns.zero_one_test(points, "x")["K"].item()) < 0.1
    assert abs(ns.zero_one_test(ns.measured.synchronous(record, 8), "x")["K"].item()) < 0.1
    found = ns.correlation_dimension(points)
    assert float(found["correlation_dimension"]) == pytest.approx(1.0, abs=0.1)
    boxes = ns.box_dimension(points)  # 1500 points are few for it, as its error says
    assert abs(float(boxes["box_dimension"]) - 1.0) < 2 * float(boxes["standard_error"])


def test_a_diagram_of_records():
    records = []
    for k, speed in enumerate((110.0, 90.0, 100.0)):
        marks = np.arange(1, 30 + 5 * k) * 2 * np.pi / speed
        t = np.arange(6000) / 2000
        x = speed / 100 * np.cos(speed * t)
        one = ns.measured.from_arrays({"x": x}, times=t, marks=marks, name=f"run {k}")
        records.append(ns.measured.velocities(one))
    found = ns.measured.diagram(records, unit="Hz", transient=3)
    np.testing.assert_allclose(found["parameter"], np.array([90, 100, 110]) / 2 / np.pi)
    assert found["parameter"].attrs == {"long_name": "speed", "units": "Hz"}
    assert found["x"].dims == ("parameter", "lane", "point")
    assert found["n_points"].values.ravel().tolist() == [31, 36, 26]
    assert found.attrs["sources"] == "run 1, run 2, run 0"
    for k, top in enumerate((0.9, 1.0, 1.1)):
        column = found["x"].values[k, 0]
        count = int(found["n_points"][k, 0])
        np.testing.assert_allclose(column[:count], top, atol=1e-5)
        assert np.all(np.isnan(column[count:]))
    assert float(found["speed_spread"].max()) < 1e-9
    ax = ns.plot.bifurcation(found, "x")
    assert ax.get_xlabel() == "speed [Hz]"
    same = ns.measured.diagram([ns.measured.section(r, transient=3) for r in records], unit="Hz")
    xr.testing.assert_allclose(found, same)
    gaps = ns.measured.diagram(records, values=[3.0, 1.0, 2.0], label="gap [mm]")
    assert gaps["parameter"].attrs == {"long_name": "gap", "units": "mm"}
    np.testing.assert_allclose(gaps["speed"].values.ravel(), [90, 100, 110])


RECORD = ns.measured.from_arrays(
    {"x": rigs.derivative(TIMES, 0)}, times=TIMES, marks=MARKS, units="mm"
)
SHORT = RECORD.isel(time=slice(0, 1000))
SCALED = ns.measured.dimensionless(RECORD, length=0.5, natural_frequency=90.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda m: m.section("run"), "give a result of measured.read_csv"),
        (lambda m: m.section(RECORD.isel(time=slice(None, None, 2))), "no longer one after"),
        (lambda m: m.velocities(RECORD.isel(time=[0, 1, 2, 9, 10])), "no longer one after"),
        (lambda m: m.section(RECORD.isel(time=slice(0))), "no samples"),
        (lambda m: m.section(m.synchronous(RECORD)), "give a result of measured.read_csv"),
        (lambda m: m.section(RECORD, phase=1.0), "phase = 1"),
        (lambda m: m.section(RECORD, transient=-1), "whole number of marks"),
        (lambda m: m.section(RECORD, transient=85), "no point of the section"),
        (lambda m: m.velocities(RECORD, highest=9000.0), "times faster"),
        (lambda m: m.velocities(SHORT, highest=0.5), "1000 samples, and a window"),
        (lambda m: m.velocities(RECORD, names={"z": "w"}), "unknown displacement 'z'"),
        (lambda m: m.velocities(RECORD, names={"x": "x"}), "named twice"),
        (lambda m: m.velocities(RECORD, names="v"), "give a mapping"),
        (lambda m: m.velocities(RECORD, differentiator=3), "give a Differentiator"),
        (lambda m: m.velocities(RECORD, differentiator=m.Differentiator(1.0, 9)), "steps of 1"),
        (lambda m: m.dimensionless(RECORD, length=0.0, natural_frequency=1.0), "length = 0"),
        (lambda m: m.dimensionless(RECORD, length=1.0, natural_frequency="a"), "a finite number"),
        (
            lambda m: m.dimensionless(RECORD, length=1, natural_frequency=1, origin={"q": 1}),
            "unknown displacement 'q'",
        ),
        (lambda m: m.dimensionless(SCALED, length=1, natural_frequency=1), "dimensionless already"),
        (lambda m: m.synchronous(RECORD, 0), "samples_per_period = 0"),
        (lambda m: m.synchronous(RECORD, 10**12), "of memory are free; give fewer, for more than"),
        (lambda m: m.diagram([]), "list is empty"),
        (lambda m: m.diagram(RECORD), "give a list"),
        (lambda m: m.diagram([RECORD], unit=["Hz"]), "known are rad/s"),
        (lambda m: m.diagram([RECORD], unit="1/s"), "known are rad/s"),
        (lambda m: m.diagram([RECORD], values=[1, 2]), "each of the 1 records"),
        (lambda m: m.diagram([RECORD], label="gap"), "belongs to values="),
        (lambda m: m.diagram([RECORD, m.velocities(RECORD)]), "records differ"),
        (lambda m: m.diagram([RECORD, RECORD.rename(x="y")]), "records differ"),
        (
            lambda m: m.diagram([RECORD, RECORD.assign(x=RECORD["x"].assign_attrs(units="um"))]),
            "differ in the units of x",
        ),
        (lambda m: m.diagram([m.section(RECORD)], transient=2), "those of the sections"),
    ],
)  # fmt: skip
def test_wrong_use(make, message):
    with pytest.raises(OptionError, match=message):
        make(ns.measured)


def test_samples_far_beyond_those_of_the_record_are_told():
    """Of 100 samples in a revolution orders up to 50 are known, however many are taken."""
    t = np.arange(500) / 100.0
    record = ns.measured.from_arrays({"x": np.cos(2 * np.pi * t)}, times=t, marks=np.arange(5.0))
    with pytest.warns(
        ns.ResultWarning,
        match=r"samples_per_period = 1000000: the record itself has 100 in its slowest revolution; "
        r".* orders beyond 50 are of the interpolation: give 100 or fewer",
    ):
        ns.measured.synchronous(record, 10**6)
    ns.measured.synchronous(record, 400)  # no warning
