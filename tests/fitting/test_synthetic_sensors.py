"""The sensor of synthetic records beside what is known of its parts in closed form."""

import numpy as np
import pytest
from synthetic_sensors import FINER, Sensor, by_marks, coloured, fine_times, record


@pytest.mark.parametrize(("order", "share"), [(1, 0.1), (2, 0.1), (2, 0.2)])
def test_a_sine_comes_through_as_its_frequency_response_says(order, share):
    """Amplitude and phase of 1/(1 + s) and 1/(1 + 1.4 s + s^2), after the filter has settled."""
    step, count, omega = 0.05, 4000, 2.0 * np.pi
    times = fine_times(0.0, step, count)
    sensor = {"x": Sensor(noise=0.0, band=share, order=order, gain=1.5)}
    shown = record(step, 1.0, {"x": np.sin(omega * times)}, sensor, times, np.random.default_rng(1))
    s = 1j * omega / (2.0 * np.pi * share / step)
    response = 1.5 / (1.0 + s if order == 1 else 1.0 + 1.4 * s + s**2)
    known = np.imag(response * np.exp(1j * omega * shown["time"].values))
    # the bilinear transform moves frequencies by (omega step / FINER)^2 / 12, here 1.3e-4
    assert np.abs(shown["x"].values - known)[1000:].max() < 4e-4
    assert shown["time"].values[0] == 0.0
    assert times.size == FINER * count + 1


def test_noise_remembers_as_it_should():
    noise = coloured(200_000, 0.7, np.random.default_rng(2))
    assert noise.std() == pytest.approx(1.0, abs=0.02)  # correlated: five standard errors
    for lag in (1, 2, 4):
        measured = np.mean(noise[lag:] * noise[:-lag])
        assert measured == pytest.approx(0.7**lag, abs=0.025)


def test_marks_that_jitter_shift_times_and_nothing_else():
    times = np.linspace(3.0, 503.0, 20_001)
    read = by_marks(times, 1.0, 0.01, np.random.default_rng(3))
    assert np.all(np.diff(read) > 0.0)
    at_marks = (read - times)[::40]
    assert at_marks.std() == pytest.approx(0.01, rel=0.13)  # of 500 values: four standard errors
    assert by_marks(times, 1.0, 0.0, np.random.default_rng(3)) is times


def test_delay_and_rounding():
    step, times = 0.1, fine_times(0.0, 0.1, 100)
    sensor = {"x": Sensor(noise=0.0, delay=0.5, offset=0.25, bits=4)}
    shown = record(step, 1.0, {"x": times}, sensor, times, np.random.default_rng(4))["x"].values
    known = step * (np.arange(100) - 0.5) + 0.25 * times.std()
    levels = np.unique(np.round(shown / (2.5 * known.max() / 16), 9))
    assert np.all(levels == np.round(levels))
    assert np.abs(shown - known).max() <= 1.25 * known.max() / 16 * (1.0 + 1e-12)
