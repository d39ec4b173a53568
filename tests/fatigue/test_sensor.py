"""Calibration of the sensor: known lines, errors over many records, faults that are told."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.fatigue import Calibration, Specimen, calibrate

STEPS = np.concatenate([np.linspace(0.0, 0.5, 11), np.linspace(0.45, 0.05, 9)])  # up and down


def voltages(seed=0, noise=0.002, gain=200.0, offset=0.12):
    rng = np.random.default_rng(seed)
    return offset + 1000.0 * STEPS / gain + noise * rng.standard_normal(STEPS.size)


def test_exact_steps():
    sensor = calibrate(STEPS, voltages(noise=0.0, gain=-125.0))
    assert sensor.gain == pytest.approx(-125.0, rel=1e-12)
    assert sensor.offset == pytest.approx(0.12, rel=1e-12)
    assert sensor.outliers == ()
    assert sensor.steps == STEPS.size
    assert max(sensor.gain_error, sensor.nonlinearity) < 1e-10


def test_against_normal_equations():
    y = voltages()
    sensor = calibrate(STEPS, y)
    matrix = np.stack([np.ones_like(STEPS), STEPS], axis=1)
    inverse = np.linalg.inv(matrix.T @ matrix)
    constant, slope = inverse @ matrix.T @ y
    variance = np.sum((y - matrix @ [constant, slope]) ** 2) / (y.size - 2)
    assert sensor.gain == pytest.approx(1000.0 / slope, rel=1e-10)
    assert sensor.offset == pytest.approx(constant, rel=1e-10)
    assert sensor.residual == pytest.approx(math.sqrt(variance), rel=1e-10)
    assert sensor.offset_error == pytest.approx(math.sqrt(variance * inverse[0, 0]), rel=1e-10)
    relative = math.sqrt(variance * inverse[1, 1]) / slope
    assert sensor.gain_error / sensor.gain == pytest.approx(relative, rel=1e-10)


@pytest.mark.filterwarnings("ignore::nonsmooth.ResultWarning")
def test_errors_and_false_alarms_over_many_records():
    """Scores have the spread of Student's t with 18 degrees, sqrt(18/16); alarms are 1 % each."""
    found = [calibrate(STEPS, voltages(seed)) for seed in range(1000)]
    for name, true in (("gain", 200.0), ("offset", 0.12)):
        scores = [(getattr(f, name) - true) / getattr(f, f"{name}_error") for f in found]
        assert abs(np.mean(scores)) < 4 * math.sqrt(18 / 16 / 1000)
        assert np.std(scores) == pytest.approx(math.sqrt(18 / 16), rel=0.1)
    # binomial of 1000 at 1 %: 10 +- 3.2
    assert sum(f.curvature_p < 0.01 for f in found) < 10 + 4 * 3.2
    assert 0 < sum(bool(f.outliers) for f in found) < 10 + 4 * 3.2


def test_a_slip_is_told():
    y = voltages()
    y[7] += 0.02
    with pytest.warns(ns.ResultWarning, match=r"step 7 \(from 0\) lies off the line.*at 0.35 mm"):
        sensor = calibrate(STEPS, y)
    assert sensor.outliers == (7,)
    exact = voltages(noise=0.0)
    exact[3] += 1e-6
    with pytest.warns(ns.ResultWarning, match="step 3"):
        assert calibrate(STEPS, exact).outliers == (3,)


def test_a_curved_sensor_is_told():
    """A parabola b d (D - d) leaves its best line by about b D^2/8 at the middle and the ends."""
    bent = voltages() + 0.4 * STEPS * (0.5 - STEPS)
    with pytest.warns(ns.ResultWarning, match="not linear"):
        sensor = calibrate(STEPS, bent)
    assert sensor.curvature_p < 1e-6
    assert 0.3 < sensor.nonlinearity < 0.8  # 0.4*0.5**2/8 = 0.0125 of 2.5 V: 0.5 %


def test_load_and_voltage():
    specimen, sensor = Specimen(), Calibration(gain=200.0, offset=-0.3)
    assert sensor.deflection(0.2) == pytest.approx(0.1)
    loads = sensor.load([0.2, -0.3], specimen, 6.4)
    np.testing.assert_allclose(loads, [0.1 * specimen.stiffness(6.4), 0.0], atol=1e-12)
    assert sensor.voltage(loads[0], specimen, 6.4) == pytest.approx(0.2, rel=1e-14)
    # the amplitude that section 3.1 sets: Eq. (33) for the difference of two voltages
    amplitude = sensor.voltage(100.0, specimen, 6.4) - sensor.voltage(0.0, specimen, 6.4)
    assert amplitude == pytest.approx(specimen.voltage(100.0, 200.0, 6.4), rel=1e-13)


@pytest.mark.parametrize(
    ("displacement", "voltage", "says"),
    [
        ([0, 1, 2], [0, 1, 2], "3 readings at 3 displacements are too few.*give 4"),
        ([0, 0, 1, 1], [0, 0, 1, 1], "4 readings at 2 displacements"),
        ([0, 1, 2, 3], [0, 1, 2], r"shapes \(4,\) and \(3,\)"),
        ([0, 1, 2, 3], [0, 1, math.nan, 2], r"voltage\[2\] = nan is not finite"),
        ([0, 1, 2, 3], [5, 5, 5, 5], "all voltages are 5 V"),
        (STEPS, np.sin(1e4 * STEPS), "no more than their noise"),
    ],
)
def test_records_without_a_gain(displacement, voltage, says):
    with pytest.raises(ns.OptionError, match=says):
        calibrate(displacement, voltage)


def test_a_gain_of_zero():
    with pytest.raises(ns.OptionError, match="gain = 0"):
        Calibration(gain=0.0)
