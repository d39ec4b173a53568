from math import factorial

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.errors import OptionError

Differentiator = ns.measured.Differentiator


@pytest.mark.parametrize("half", [1, 3, 20])
def test_noise_gain_of_straight_lines_is_known(half):
    """Slope of a line through 2M + 1 points: variance 3 / (M (M + 1) (2 M + 1)), per step."""
    found = Differentiator(0.01, 2 * half + 1, 2)
    closed = np.sqrt(3 / (half * (half + 1) * (2 * half + 1))) / 0.01
    assert found.noise_gain == pytest.approx(closed, rel=1e-12)


@pytest.mark.parametrize("order", [2, 4, 6])
def test_noise_gain_is_that_of_random_samples(order):
    found = Differentiator(1 / 2000, 31, order)
    noise = np.random.default_rng(order).normal(0, 1e-3, 400_000)
    # 400,000 values in windows of 31: at least 13,000 independent ones, so 4 sigma are 2.5 %
    assert found(noise).std() == pytest.approx(1e-3 * found.noise_gain, rel=0.025)


@pytest.mark.parametrize(("order", "frequency"), [(2, 20.0), (4, 35.0), (4, 90.0), (6, 60.0)])
def test_bias_is_that_of_a_sampled_sine(order, frequency):
    found = Differentiator(1 / 2000, 25, order)
    t = np.arange(3000) / 2000
    omega = 2 * np.pi * frequency
    rates = found(np.sin(omega * t + 0.4))
    wanted = omega * np.cos(omega * t[12:-12] + 0.4)
    np.testing.assert_allclose(rates, (1 + found.bias(frequency)) * wanted, atol=1e-9 * omega)


@pytest.mark.parametrize("order", [2, 4, 6, 8])
def test_polynomials_are_exact(order):
    found = Differentiator(0.1, 15, order)
    t = 0.1 * np.arange(40)
    for power in range(order + 1):
        wanted = power * t[7:-7] ** max(power - 1, 0)
        np.testing.assert_allclose(found(t**power), wanted, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(("window", "order"), [(5, 4), (9, 8), (31, 6), (201, 4)])
def test_coefficients_are_those_of_scipy(window, order):
    from scipy.signal import savgol_coeffs

    wanted = savgol_coeffs(window, order, deriv=1, delta=0.3, use="dot")
    found = Differentiator(0.3, window, order).coefficients
    np.testing.assert_allclose(found, wanted, atol=1e-9 * np.abs(wanted).max())


def test_long_windows_keep_their_digits():
    """The variance of slopes tends to 75/4 of 1/(window^3 step^2) for cubics."""
    long = Differentiator(1e-4, 20_001, 4)
    assert long.noise_gain == pytest.approx(np.sqrt(75 / 20_001**3) / 1e-4, rel=1e-3)


def test_bandwidth_and_band():
    found = Differentiator.for_band(1 / 5000, 150.0, bias=0.02)
    assert 1 + found.bias(found.bandwidth) == pytest.approx(np.sqrt(0.5), rel=1e-9)
    assert abs(found.bias(found.highest(0.02))) == pytest.approx(0.02, rel=1e-9)
    assert found.highest(0.02) >= 150.0
    longer = Differentiator(found.step, found.window + 2, found.order)
    assert abs(longer.bias(150.0)) > 0.02  # the longest window, so the least noise
    assert longer.noise_gain < found.noise_gain


@pytest.mark.parametrize(("window", "order"), [(9, 2), (21, 4)])
@pytest.mark.parametrize("q", [2, 3])
def test_truncation_is_reached_and_never_passed(window, order, q):
    """By the odd motion whose derivative of order q jumps with the sign of Peano's kernel."""
    step, size = 0.02, 7.0
    found = Differentiator(step, window, order)
    half = window // 2
    k = np.arange(1, half + 1)
    n = 400  # pieces per step
    s = (np.arange(half * n) + 0.5) / n
    ahead = np.maximum(k[:, None] - s, 0.0) ** (q - 1)
    kernel = found.coefficients[half + 1 :] @ ahead

    def error(top):  # of the odd motion with these values of its derivative ahead of the middle
        values = (ahead @ top) / n * step**q / factorial(q - 1)
        return 2 * abs(found.coefficients[half + 1 :] @ values)

    bound = found.truncation(q, size)
    assert error(size * np.sign(kernel)) == pytest.approx(bound, rel=2e-3)
    rng = np.random.default_rng(0)
    for _ in range(30):
        assert error(size * rng.choice([-1.0, 1.0], half).repeat(n)) <= bound * (1 + 1e-9)


def test_an_offset_costs_no_digits():
    found = Differentiator(1e-4, 501, 4)
    t = 1e-4 * np.arange(5000)
    one, other = found(np.sin(9 * t)), found(1e6 + np.sin(9 * t))
    np.testing.assert_allclose(one, other, atol=1e-16 * 1e6 * found.noise_gain * 30)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Differentiator(0.1, 4), "odd"),
        (lambda: Differentiator(0.1, 3, 4), "from 5"),
        (lambda: Differentiator(0.1, 9, 3), "order = 3"),
        (lambda: Differentiator(-1.0, 9), "step"),
        (lambda: Differentiator.for_band(0.01, 40.0), "times faster"),
        (lambda: Differentiator.for_band(0.01, 60.0), "times faster"),
        (lambda: Differentiator.for_band(0.01, -1.0), "highest"),
        (lambda: Differentiator.for_band(0.01, 1.0, bias=2.0), "bias"),
        (lambda: Differentiator(0.1, 9)(np.zeros(5)), "fewer than a window"),
        (lambda: Differentiator(0.1, 9).truncation(7, 1.0), "derivative = 7"),
    ],
)
def test_wrong_use(make, message):
    with pytest.raises(OptionError, match=message):
        make()


@pytest.mark.parametrize(("window", "order"), [(5, 4), (7, 2), (31, 4), (31, 8), (301, 6)])
@pytest.mark.parametrize("bias", [1e-4, 0.01, 0.2])
def test_the_whole_band_is_kept(window, order, bias):
    """The bias falls from zero at rest, and its side lobes stay below the band."""
    found = Differentiator(0.001, window, order)
    top = found.highest(bias)
    inside = [found.bias(f) for f in np.linspace(0, top, 200)]
    assert np.all(np.diff(inside) < 1e-9) and inside[-1] == pytest.approx(-bias, rel=1e-6)
    if 2 * order < window:  # those with few samples reach their band's end at the end of all
        beyond = [found.bias(f) for f in np.linspace(1.001 * top, 500.0, 400)]
        assert max(beyond) < -bias
