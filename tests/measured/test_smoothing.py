"""The low-pass filter does to sines what its formula says, and nothing to lines."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from measured import rigs

RATE = 1000.0


def data(values, **more) -> xr.Dataset:
    t = np.arange(len(values)) / RATE
    return xr.Dataset({"x": ("time", values, more)}, {"time": ("time", t, {"units": "s"})})


def response(f: float, cutoff: float, order: int) -> float:
    """Of the Butterworth filter with the bilinear transform, both ways; -3 dB at the cut-off."""
    ratio = np.tan(np.pi * f / RATE) / np.tan(np.pi * cutoff / RATE)
    return 1 / (1 + (np.sqrt(2) - 1) * ratio ** (2 * order))


@pytest.mark.parametrize("order", [1, 2, 4, 8])
@pytest.mark.parametrize("cutoff", [20.0, 100.0, 300.0, 480.0])
def test_sines_come_out_as_high_as_the_formula_says_and_in_phase(order, cutoff):
    t = np.arange(6000) / RATE
    for f in (7.3, 0.5 * cutoff, cutoff, min(1.3 * cutoff, 490.0)):
        sine = np.cos(2 * np.pi * f * t + 0.4)
        found = ns.measured.low_pass(data(sine), cutoff, order=order)["x"].values
        middle = slice(2000, 4000)
        np.testing.assert_allclose(
            found[middle], response(f, cutoff, order) * sine[middle], atol=2e-7
        )


def test_half_the_power_is_left_at_the_cutoff():
    assert response(123.0, 123.0, 4) == pytest.approx(1 / np.sqrt(2), rel=1e-12)


def test_lines_pass_unchanged_to_their_ends():
    line = 3.0 - 0.2 * np.arange(800.0)
    found = ns.measured.low_pass(data(line), 50.0)["x"]
    np.testing.assert_allclose(found, line, rtol=0, atol=1e-6)


def test_what_an_edge_does_stays_within_it():
    """Two records that differ in what comes next agree to a thousandth of it behind the edge."""
    t = np.arange(1000) / RATE
    whole = data(np.where(t < 0.6, np.sin(40 * t), 1.0))
    part = whole.isel(time=slice(0, 600))
    cut = ns.measured.low_pass(part, 30.0, edges="cut")
    long = ns.measured.low_pass(whole, 30.0)["x"].sel(time=cut["time"][1:])
    edge = cut["x"].attrs["edge"]
    assert cut.sizes["time"] == 600 - 2 * round(edge * RATE)
    assert abs(cut["x"][1:] - long)[: -round(edge * RATE)].max() < 3e-3
    assert abs(cut["x"][1:] - long).max() < 3e-3 * 2


def test_a_record_keeps_units_marks_and_all_that_follows():
    t = np.arange(5000) / 5000.0
    rng = np.random.default_rng(1)
    noisy = rigs.derivative(t, 0) + rng.normal(0, 0.01, t.size)
    record = ns.measured.from_arrays(
        {"x": noisy}, times=t, marks=rigs.jittering_marks(12), units="mm"
    )
    smooth = ns.measured.low_pass(record, 150.0)
    assert smooth["x"].attrs["units"] == "mm" and smooth["x"].attrs["low_pass"] == 150.0
    assert smooth.sizes["mark"] == record.sizes["mark"]
    assert smooth.attrs["speed"] == record.attrs["speed"]
    points = ns.measured.section(ns.measured.velocities(smooth, highest=100))
    truth = rigs.derivative(points["time"].values, 0)
    assert np.std(points["x"] - truth) < 0.6 * 0.01
    # noise below the cut-off is what is left: sqrt(150 / 2500) of it, nearly
    away = (smooth["x"] - rigs.derivative(t, 0))[500:-500]
    assert float(away.std()) == pytest.approx(0.01 * np.sqrt(150 / 2500), rel=0.15)
    assert smooth["x"].attrs["noise"] == pytest.approx(float(away.std()), rel=0.1)
    again = ns.measured.velocities(smooth, highest=100)
    assert again["x"].attrs["noise"] == smooth["x"].attrs["noise"]


def test_a_run_without_its_event_log():
    run = ns.simulate(ns.models.soft_impact(), periods=20)
    smooth = ns.measured.low_pass(run, 2.0, variables="v")
    assert list(smooth.data_vars) == ["v"] and "event" not in smooth.dims
    assert "phase" in smooth.coords
    ns.plot.time_history(smooth, "v")


@pytest.mark.parametrize(
    ("cutoff", "options", "words"),
    [
        (500.0, {}, r"below half the sample rate, 500: .* leave the filter out"),
        (800.0, {}, "below half the sample rate"),
        (-1.0, {}, "must be positive"),
        ("fast", {}, "is not a finite number"),
        (50.0, {"order": 9}, "from 1 to 8"),
        (50.0, {"edges": "none"}, "'reflect' or 'cut'"),
        (50.0, {"variables": "y"}, "'y'"),
        (0.5, {}, "higher cutoff= or a lower order="),
    ],
)
def test_errors(cutoff, options, words):
    with pytest.raises(ns.OptionError, match=words):
        ns.measured.low_pass(data(np.zeros(500)), cutoff, **options)


def test_uneven_and_missing_samples_are_refused():
    even = data(np.zeros(100))
    uneven = even.isel(time=[*range(50), *range(51, 100)])
    with pytest.raises(ns.OptionError, match="not equidistant"):
        ns.measured.low_pass(uneven, 50.0)
    even["x"][3] = np.nan
    with pytest.raises(ns.OptionError, match="x: some samples are not finite"):
        ns.measured.low_pass(even, 50.0)
    with pytest.raises(ns.OptionError, match="too few"):
        ns.measured.low_pass(even.isel(time=slice(5)), 50.0)
    with pytest.raises(ns.OptionError, match="give a record"):
        ns.measured.low_pass(np.zeros(100), 50.0)
