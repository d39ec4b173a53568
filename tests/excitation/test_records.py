"""Records of base acceleration: powers in closed form, Parseval, spectra by another route."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import welch

import nonsmooth as ns
from nonsmooth.errors import OptionError
from nonsmooth.excitation import Excitation, band_noise, duffing, equal_power, harmonic, power_ratio


@pytest.fixture(scope="module")
def wave():
    return duffing(20.0, rms=3.0, duration=30.0)


@pytest.mark.parametrize(
    ("measure", "order"), [("acceleration", 0), ("velocity", 1), ("displacement", 2)]
)
def test_powers_of_a_sine(measure, order):
    sine = harmonic(20.0, 3.0, duration=5.0, phase=0.7)
    exact = 4.5 / (2 * np.pi * 20) ** (2 * order)
    assert sine.power(measure) == pytest.approx(exact, rel=1e-12)


@pytest.mark.slow
def test_parseval(wave):
    """The sum over frequencies is the mean square over time."""
    for record in (harmonic(20.0, 2.0), band_noise(5.0, 60.0, 2.0), wave):
        _, lines = record.spectrum()
        mean_square = np.dot(record.acceleration, record.acceleration) / record.acceleration.size
        assert lines.sum() == pytest.approx(mean_square, rel=1e-12)


def test_velocity_of_noise_by_its_derivative():
    """Noise made as a velocity: its derivative line by line has that velocity again."""
    speed = band_noise(10.0, 30.0, 0.02, duration=10.0, seed=3)
    lines = np.fft.rfft(speed.acceleration)
    frequency = np.fft.rfftfreq(speed.acceleration.size, speed.step)
    rate = np.fft.irfft(2j * np.pi * frequency * lines, speed.acceleration.size)
    record = Excitation(speed.times, rate, periodic=True)
    assert record.power("velocity") == pytest.approx(0.02**2, rel=1e-10)


def test_noise_lies_in_its_band_and_is_gaussian():
    noise = band_noise(15.0, 25.0, 2.0, duration=40.0, seed=4)
    frequency, lines = noise.spectrum()
    inside = (frequency >= 15 - 1e-9) & (frequency <= 25 + 1e-9)
    assert lines[~inside].sum() < 1e-24 * lines.sum()
    # 800 independent numbers: the fourth moment of a normal variable within its error, 10 %
    assert np.mean(noise.acceleration**4) / 16.0 == pytest.approx(3.0, rel=0.2)
    again, other = (band_noise(15.0, 25.0, 2.0, duration=40.0, seed=s) for s in (4, 5))
    np.testing.assert_array_equal(noise.acceleration, again.acceleration)
    assert np.abs(noise.acceleration - other.acceleration).max() > 1.0


def test_dominant_frequency_of_the_duffing_wave_by_welch(wave):
    frequency, density = welch(wave.acceleration, 1 / wave.step, nperseg=8192)
    top = float(frequency[np.argmax(density)])
    assert top == pytest.approx(20.0, abs=frequency[1])
    assert wave.dominant_frequency == pytest.approx(20.0, abs=1 / wave.duration)
    assert wave.details["exponent"] > 5 * wave.details["exponent_error"]
    assert wave.power() == pytest.approx(9.0, rel=1e-12)
    assert abs(wave.acceleration.mean()) < 1e-12


def test_the_duffing_wave_is_that_of_scipy(wave):
    """From the state in its details, in the oscillator's own time, for six periods."""
    of = wave.details

    def flow(t, y):
        force = of["gamma"] * np.cos(of["omega"] * t) - of["delta"] * y[1]
        return [y[1], force - of["alpha"] * y[0] - of["beta"] * y[0] ** 3]

    times = wave.times[:193] * of["time_scale"]
    truth = solve_ivp(flow, (0, times[-1]), [of["x0"], of["v0"]], "DOP853", times,
                      rtol=1e-12, atol=1e-12)  # fmt: skip
    base = of["gain"] * (truth.y[0] - of["offset"])
    np.testing.assert_allclose(wave.acceleration[:193], base, atol=1e-7 * 3.0)


@pytest.mark.slow
def test_a_period_of_the_force_spans_the_samples(wave):
    assert wave.step * 32 * wave.details["time_scale"] == pytest.approx(2 * np.pi, rel=1e-9)
    slower = duffing(5.0, 1.0, duration=4.0, samples_per_period=16)
    assert slower.dominant_frequency == pytest.approx(5.0, abs=1 / slower.duration)


@pytest.mark.parametrize("measure", ["acceleration", "velocity", "displacement"])
def test_equal_power(wave, measure):
    sine = harmonic(20.0, 5.0)
    scaled = equal_power(wave, sine, measure, lowest=2.0)
    assert scaled.power(measure, lowest=2.0) == pytest.approx(sine.power(measure), rel=1e-12)
    assert power_ratio(scaled, sine, measure, lowest=2.0) == pytest.approx(1.0, rel=1e-12)
    gain = scaled.details["gain"] / wave.details["gain"]
    np.testing.assert_allclose(scaled.acceleration, gain * wave.acceleration, rtol=1e-12)


@pytest.mark.parametrize("lowest", [0.1, 1.0, 10.0])
def test_a_sine_between_lines_does_not_leak_into_its_displacement(lowest):
    """Not periodic in the record, so that its line falls between two; exact in closed form."""
    t = np.arange(20 * 1280) / 1280
    record = Excitation(t, np.sin(2 * np.pi * 20.013 * t + 0.3))
    exact = 0.5 / (2 * np.pi * 20.013) ** 4
    assert record.power("displacement", lowest=lowest) == pytest.approx(exact, rel=5e-4)


def test_slow_parts_of_the_wave_are_its_own(wave):
    """Density below the band by Welch over another window: it does not vanish there."""
    frequency, density = welch(wave.acceleration, 1 / wave.step, "blackmanharris",
                               nperseg=wave.times.size // 3, detrend="linear")  # fmt: skip
    slow = (frequency > 0.5) & (frequency < 4.0)
    turns = (2 * np.pi * frequency[slow]) ** 4
    exact = float(np.sum(density[slow] / turns) * frequency[1])
    found = wave.power("displacement", lowest=0.5) - wave.power("displacement", lowest=4.0)
    assert 0.3 < found / exact < 3.0  # a chaotic record of 30 s, few lines of which count
    assert density[slow].min() > 1e-4 * density.max()


def test_periodic_records_count_whole_but_for_their_mean():
    noise = band_noise(0.5, 30.0, duration=10.0, seed=3)
    whole = noise.power("displacement")
    assert whole == pytest.approx(noise.power("displacement", lowest=0.05), rel=1e-12)
    moved = Excitation(noise.times, noise.acceleration + 3.0, periodic=True)
    assert moved.power("displacement") == pytest.approx(whole, rel=1e-9)


@pytest.mark.parametrize("duration", [5.0, 3.3, 7.01])
def test_noise_lasts_as_long_as_wanted(duration):
    noise = band_noise(10.0, 13.7, 5.0, duration=duration, seed=1)
    assert noise.duration == pytest.approx(duration, rel=1e-12)
    assert noise.power() == pytest.approx(25.0, rel=1e-12)


def test_equal_power_of_a_load_that_answers_out_of_proportion():
    """Load a + a^3/10 of acceleration a: the mean square of a sine in closed form."""

    def response(record):
        return record.acceleration + record.acceleration**3 / 10

    small, large = harmonic(20.0, 1.0), harmonic(20.0, 4.0)
    scaled = equal_power(small, large, "load", response=response)
    assert scaled.details["gain"] == pytest.approx(4.0, rel=1e-9)


def test_signals_pass_through_the_samples():
    noise = band_noise(15.0, 25.0, duration=2.0)
    signal = noise.as_signal()
    assert isinstance(signal, ns.Signal) and signal.span == (0.0, pytest.approx(2.0))
    np.testing.assert_array_equal(signal(noise.times), noise.acceleration)
    sine = harmonic(20.0, 1.0, duration=1.0).as_signal()
    t = np.linspace(0.1, 0.9, 1001)
    assert np.abs(sine(t) - np.sin(40 * np.pi * t)).max() < 5e-7


def test_datasets_go_to_the_spectrum_of_the_library():
    lines = ns.power_spectrum(harmonic(20.0, 3.0, duration=5.0).to_dataset(), "acceleration")
    assert float(lines["amplitude"].max()) == pytest.approx(3.0, rel=1e-2)


T = np.arange(100) / 100.0


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: Excitation(T, np.where(T == 0.5, np.nan, 1.0)), "first at index 50"),
        (lambda: Excitation(T**2, T), "not even"),
        (lambda: Excitation(T[:5], T[:5]), "too few"),
        (lambda: Excitation(T, T).power("force"), "measure = 'force'"),
        (lambda: Excitation(T, T).power("velocity", lowest=1e3), "nothing of the record"),
        (lambda: Excitation(T, 0 * T, periodic=True).dominant_frequency, "constant"),
        (lambda: equal_power(Excitation(T, 0 * T), harmonic()), "power of the record"),
        (lambda: equal_power(harmonic(), Excitation(T, 0 * T)), "power of the reference"),
        (lambda: power_ratio(harmonic(), Excitation(T, 0 * T)), "is zero"),
        (lambda: equal_power(harmonic(), harmonic(), "load"), "needs response="),
        (lambda: equal_power(5, harmonic()), "record = 5: give an Excitation"),
        (lambda: equal_power(harmonic(), None), "reference = None: give an Excitation"),
        (lambda: power_ratio(T, harmonic()), "record = .*give an Excitation"),
        (lambda: Excitation(T, T).power("displacement"), "displacement .* give lowest="),
        (lambda: equal_power(Excitation(T, T), harmonic(), "velocity"), "give lowest="),
        (lambda: Excitation(T, T).power("velocity", lowest="low"), "lowest = 'low'"),
        (lambda: band_noise(10, 10.0001, 5, seed=1), "1 of them .*longer duration or a wider band"),
        (lambda: band_noise(20.0, 20.0), "1 of them between 20 and 20 Hz"),
        (lambda: Excitation(T, ["1"] * 100), "as numbers"),
        (lambda: equal_power(harmonic(), harmonic(), "power"), "known are"),
        (lambda: harmonic(20.0, 0.0), "amplitude = 0"),
        (lambda: harmonic(20.0, 1.0, duration=0.33), "whole number"),
        (lambda: harmonic(20.0, 1.0, samples_per_period=4), "8 in a period"),
        (lambda: band_noise(25.0, 15.0), "below its beginning"),
        (lambda: band_noise(15.01, 15.02, duration=1.0), "no of them .*longer duration"),
        (lambda: duffing(variable="y"), "unknown variable"),
        (lambda: duffing(alpha=1.0, gamma=0.1), "not chaotic"),
        (lambda: duffing(duration=1e5), "190,000"),
    ],
)
def test_bad_input(make, text):
    with pytest.raises(OptionError, match=text):
        make()
