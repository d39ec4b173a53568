"""A simulated rotor, recorded as a rig would have it, is found again within the derived error."""

import numpy as np
import pytest

import nonsmooth as ns
from measured import rigs

GAP, NATURAL = 0.5, 90.24  # mm and rad/s
PER_PERIOD, PERIODS, SKIPPED = 397.37, 80, 40  # no whole number of samples in a revolution
SENSITIVITY, DIGITS = 7.87, 1e-6  # V/mm; the file has six digits
ETA = {"eta": 2.442}


@pytest.fixture(scope="module")
def run():
    system = ns.models.rotor(**ETA)
    period = 2 * np.pi / ETA["eta"]
    first = SKIPPED * period - 20.4 * period / PER_PERIOD
    return ns.simulate(
        system, times=first + np.arange(int(PERIODS * PER_PERIOD)) * period / PER_PERIOD
    )


def recorded(run, folder, rise):
    """File of the run in s and V, with pulses whose edges last some samples."""
    period = run.attrs["period"] / NATURAL
    # the file begins a little before a strobe, at a time of its own
    times = np.arange(run.sizes["time"]) * period / PER_PERIOD
    marks = 20.4 / PER_PERIOD * period + np.arange(PERIODS) * period
    pulse = rigs.pulses(times, marks, rise=rise * period / PER_PERIOD, width=0.05 * period)
    volts = [-9.0 + SENSITIVITY * GAP * run[name].values for name in ("x", "y")]
    table = np.column_stack([times, *volts, pulse])
    np.savetxt(
        folder / "rig.csv", table, fmt=["%.9f", "%.6f", "%.6f", "%.6f"], delimiter=";",
        header="time [s];X [V];Y [V];key [V]", comments="",
    )  # fmt: skip
    probe = {"sensitivity": SENSITIVITY, "offset": -9.0, "units": "mm"}
    record = ns.measured.read_csv(
        folder / "rig.csv",
        {n: ns.measured.Channel(n.upper(), **probe) for n in ("x", "y")},
        mark="key",
    )
    record = ns.measured.dimensionless(record, length=GAP, natural_frequency=NATURAL)
    return ns.measured.velocities(record, highest=20 * ETA["eta"] / 2 / np.pi)


def bounds_of_motion(run, axis):
    """Largest rate of the acceleration, largest jump of it, and most events in some samples."""
    step = run.attrs["period"] / PER_PERIOD
    shake = 0.0017 * 70 * 2.442**2 * (np.cos if axis == "x" else np.sin)(2.442 * run["time"].values)
    rest = 0.9 if axis == "x" else 0.0
    acceleration = shake - 0.25 * run[f"v{axis}"].values - (run[axis].values - rest)
    acceleration -= run[f"force_{axis}"].values
    changes = np.abs(np.diff(acceleration))
    at_event = np.zeros(changes.size, bool)
    since = run["event_time"].values - float(run["time"][0])
    places = np.floor(since[since > 0] / step).astype(int)
    for shift in (-1, 0, 1):
        at_event[np.clip(places + shift, 0, changes.size - 1)] = True
    jerk = 1.1 * changes[~at_event].max() / step
    return jerk, changes.max() + jerk * step, places


@pytest.mark.parametrize("rise", [8, 1e-6])
def test_the_section_is_that_of_the_model(run, tmp_path, rise):
    record = recorded(run, tmp_path, rise)
    points = ns.measured.section(record, transient=1)
    truth = ns.stroboscopic_map(
        ns.models.rotor(**ETA), transient=SKIPPED + 1, record=points.sizes["point"]
    )
    step = run.attrs["period"] / PER_PERIOD
    filter = ns.measured.Differentiator(step, record["vx"].attrs["window"])
    # marks: what the edges leave open, and the digits of the file on their slopes
    late = record.attrs["mark_error"] if rise < 1 else 1e-3 * step
    assert rise >= 1 or late == pytest.approx(0.5 * step, rel=0.01)
    rounding = 0.5 * DIGITS / SENSITIVITY / GAP
    for axis in ("x", "y"):
        jerk, jump, places = bounds_of_motion(run, axis)
        near = (places[None, :] >= places[:, None]) & (
            places[None, :] < places[:, None] + filter.window + 3
        )
        jumps = jump * near.sum(axis=1).max()
        speed = float(abs(run[f"v{axis}"]).max())
        # acceleration: one part with a bounded rate, and jumps within the window
        bound = filter.truncation(3, jerk) + filter.truncation(2, jumps)
        bound += np.abs(filter.coefficients).sum() * rounding
        bound = 1.25 * bound + step * jumps + 0.5 * jerk * step**2  # of the interpolation
        # the force on the ring is at most that by its springs
        acceleration = float(abs(run[f"force_{axis}"]).max()) + 3.0
        away = np.abs(points[f"v{axis}"].values - truth[f"v{axis}"].values)
        assert away.max() < bound + acceleration * late
        assert bound < 0.15 * speed  # worst case: every event at once, in the worst place
        assert np.median(away) < 2e-3 * speed or rise < 1
        away = np.abs(points[axis].values - truth[axis].values)
        assert away.max() < 1.25 * rounding + 0.2 * step**2 * jumps + step**3 * jerk + speed * late
        assert away.max() < 1e-5 or rise < 1


def test_speed_and_time_are_those_of_the_model(run, tmp_path):
    record = recorded(run, tmp_path, 8)
    assert record.attrs["speed"] == pytest.approx(2.442, rel=1e-6)
    assert record.attrs["speed_spread"] < 1e-4
    assert record.attrs["system_name"] == "rig"


def test_orders_are_those_of_the_model(run, tmp_path):
    """Samples at equal angles are those that a simulation gives, whatever the recorder did."""
    even = ns.measured.synchronous(recorded(run, tmp_path, 8), 64)
    first = int(np.argmax(even["phase"].values == 0.0))
    even = even.isel(time=slice(first, None))
    wanted = ns.simulate(
        ns.models.rotor(**ETA), periods=SKIPPED + PERIODS, samples_per_period=64, events=False
    )
    # the first revolution within the record is that of the second mark
    begin = 64 * (SKIPPED + (1 if first else 0))
    wanted = wanted.isel(time=slice(begin, begin + even.sizes["time"]))
    np.testing.assert_allclose(even["x"], wanted["x"], atol=2e-5)
    found, truth = (
        ns.power_spectrum(one, "x")["amplitude"].swap_dims(frequency="harmonic")
        for one in (even, wanted)
    )
    np.testing.assert_allclose(found["harmonic"], truth["harmonic"])
    np.testing.assert_allclose(found, truth, atol=2e-5)
