"""The shaken specimen against closed forms, scipy, and the cascade against the record."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from fatigue.bending import bent_beam
from nonsmooth.errors import ModelError, OptionError
from nonsmooth.excitation import (
    Excitation,
    ShakenSpecimen,
    band_noise,
    duffing,
    harmonic,
    lives_under_shaking,
    spread_of_life_ratio,
)
from nonsmooth.fatigue import Paris, Specimen, Walker

CLOSED = 1177.0  # N/mm


def ligament(crack):
    return CLOSED * ((20.0 - crack) / 15.0) ** 3


def test_without_a_crack_it_answers_like_a_linear_oscillator():
    rig = ShakenSpecimen(lambda crack: CLOSED, CLOSED, 18.0, 0.1, 3.0, mean_load=80.0)
    base = harmonic(20.0, 5.0, duration=12.0)
    load = rig.load(base, 5.0, transient=10.0)
    omega, drive = 2 * np.pi * 18.0, 2 * np.pi * 20.0
    factor = -5000.0 / (omega**2 * 4 - drive**2 + 2j * 0.1 * omega * drive)
    exact = 80.0 + CLOSED * (factor * np.exp(1j * drive * load["time"].values)).imag
    assert np.abs(load.values - exact).max() < 2e-6 * np.abs(exact).max()


@pytest.mark.slow
@pytest.mark.parametrize("mean", [0.0, 150.0, -60.0])
def test_breathing_against_scipy(mean):
    rig = ShakenSpecimen(ligament, CLOSED, mean_load=mean)
    base = band_noise(10.0, 30.0, 8.0, duration=1.0, seed=2)
    load = rig.load(base, 9.0, transient=0.0)
    springs = CLOSED / rig.closed_ratio
    omega, signal = 2 * np.pi * rig.natural_frequency, base.as_signal()
    at_rest = mean / (ligament(9.0) if mean >= 0 else CLOSED)

    def flow(t, y):
        own = ligament(9.0) if y[0] > 0 else CLOSED
        force = mean + springs * at_rest - (springs + own) * y[0]
        return [y[1], omega**2 * force / springs - 2 * rig.damping * omega * y[1]
                - 1000 * float(signal(t))]  # fmt: skip

    times = load["time"].values[:400]
    truth = solve_ivp(flow, (0, times[-1]), [at_rest, 0.0], "RK45", times, rtol=1e-9,
                      atol=1e-12, max_step=2e-4).y[0]  # fmt: skip
    exact = np.where(truth > 0, ligament(9.0), CLOSED) * truth
    assert np.abs(load.values[:400] - exact).max() < 1e-5 * np.abs(exact).max()


@pytest.mark.slow
def test_the_cascade_moves_as_the_record_does():
    """Chaos and the curve through the samples part them later on."""
    rig = ShakenSpecimen(ligament, CLOSED, damping=0.1)
    wave = duffing(20.0, 5.0, duration=2.0, samples_per_period=128).scaled(1.5)
    times = np.linspace(0.0, 0.4, 201)  # eight periods of the force
    cascade = ns.simulate(rig.cascade(wave, 8.0), times=times, events=False)
    record = ns.simulate(rig.system(wave, 8.0), times=times, events=False)
    base = wave.as_signal()(times)
    assert np.abs(cascade["base"].values - base).max() < 1e-5 * np.abs(base).max()
    size = np.abs(record["load"].values).max()
    assert np.abs(cascade["load"].values - record["load"].values).max() < 1e-4 * size


@pytest.mark.slow
@pytest.mark.parametrize("variable", ["v", "acceleration"])
def test_the_cascade_takes_other_variables(variable):
    rig = ShakenSpecimen(ligament, CLOSED)
    wave = duffing(20.0, 5.0, duration=2.0, samples_per_period=128, variable=variable)
    cascade = ns.simulate(rig.cascade(wave, 8.0), times=[0.0, 0.05, 0.1], events=False)
    base = wave.as_signal()(np.array([0.0, 0.05, 0.1]))
    assert np.abs(cascade["base"].values - base).max() < 1e-4 * np.abs(wave.acceleration).max()


def test_without_a_mean_load_it_is_in_proportion():
    rig = ShakenSpecimen(ligament, CLOSED)
    base = harmonic(20.0, 1.0, duration=10.0, samples_per_period=32)
    one, two = (rig.load_values(base.scaled(f), 8.0) for f in (1.0, 2.0))
    np.testing.assert_allclose(two, 2 * one, atol=1e-9 * np.abs(two).max())


SINE = harmonic(20.0, duration=12.0, samples_per_period=32)
LAW = Walker(1.42e-8, 3.59, 0.68)


def test_equal_records_have_equal_lives():
    rig = ShakenSpecimen(ligament, CLOSED, mean_load=150.0)
    found = lives_under_shaking(rig, SINE, SINE.scaled(7.0), bent_beam, LAW, cracks=[6.4, 8.0])
    assert float(found["ratio"]) == pytest.approx(1.0, rel=1e-8)
    assert float(found["reference_load_amplitude"][0]) == pytest.approx(100.0, rel=1e-5)


@pytest.mark.parametrize("measure", ["acceleration", "velocity", "displacement", "load"])
def test_powers_are_equal_on_the_records_used(measure):
    rig = ShakenSpecimen(ligament, CLOSED, damping=0.36, mean_load=150.0)
    noise = band_noise(15.0, 25.0, duration=12.0)
    found = lives_under_shaking(
        rig, SINE, noise, bent_beam, LAW, measure=measure, cracks=[6.4, 8.0]
    )
    assert float(found["power_ratio"]) == pytest.approx(1.0, rel=1e-9)
    if measure == "load":
        assert float(found["load_rms"][0] / found["reference_load_rms"][0]) == pytest.approx(1.0)


@pytest.mark.slow
def test_one_cell_of_the_spread_is_the_single_comparison():
    rig = ShakenSpecimen(ligament, CLOSED, damping=0.2, mean_load=150.0)
    wave = duffing(20.0, duration=12.0)
    one = lives_under_shaking(rig, SINE, wave, bent_beam, LAW, cracks=[6.4, 9.0])
    spread = spread_of_life_ratio(
        ShakenSpecimen(ligament, CLOSED), SINE, {"ueda": wave}, bent_beam,
        {"walker": LAW, "paris": Paris(1e-8, 3.0)}, mean_loads=[0.0, 150.0], dampings=[0.2],
        measures=["acceleration"], cracks=[6.4, 9.0],
    )  # fmt: skip
    cell = spread["ratio"].sel(mean_load=150.0, damping=0.2, record="ueda", law="walker")
    assert float(cell.squeeze()) == float(one["ratio"])
    assert np.isfinite(spread["ratio"]).all()


def test_bad_input():
    with pytest.raises(OptionError, match="closed_stiffness = -5"):
        ShakenSpecimen(ligament, -5.0)
    with pytest.raises(OptionError, match="give a function"):
        ShakenSpecimen(1000.0, CLOSED)
    rig = ShakenSpecimen(lambda crack: 100.0 * (10.0 - crack), CLOSED)
    with pytest.raises(ModelError, match=r"at a crack of 12 mm is -200 N/mm"):
        rig.load(SINE, 12.0)
    with pytest.raises(OptionError, match="leave a tenth"):
        rig.load(SINE, 6.0, transient=11.9)
    with pytest.raises(OptionError, match="needs a result of duffing"):
        rig.cascade(SINE, 6.0)
    beam = ShakenSpecimen(Specimen().stiffness, CLOSED, damping=0.1)
    with pytest.raises(OptionError, match="crack = 25 mm is longer than the specimen's width"):
        beam.load(harmonic(20.0, duration=2.0), crack=25)
    for shake in (rig.load, rig.system, rig.cascade):
        with pytest.raises(OptionError, match="= 5: give an Excitation"):
            shake(5, 6.0)


def test_bad_input_of_lives_is_told_before_the_rig_runs():
    def never(crack):
        raise AssertionError

    rig = ShakenSpecimen(never, CLOSED)
    wave = Excitation(SINE.times, SINE.acceleration)
    for bad, says in (
        ((5, SINE, SINE, bent_beam, LAW), "rig = 5: give a ShakenSpecimen"),
        ((rig, SINE, 5, bent_beam, LAW), "record = 5: give an Excitation"),
        ((rig, SINE, SINE, bent_beam, "paris"), "law = 'paris'"),
        ((rig, SINE, wave, bent_beam, LAW), "give lowest="),
    ):
        with pytest.raises(OptionError, match=says):
            lives_under_shaking(*bad, cracks=[6.0, 8.0], measure="displacement")
    grid = {"dampings": [0.2], "mean_loads": [0.0], "measures": ["displacement"]}
    with pytest.raises(OptionError, match="give lowest="):
        spread_of_life_ratio(rig, SINE, {"wave": wave}, bent_beam, {"walker": LAW}, **grid)
    for wrong in ([6.4], 6.4, []):
        with pytest.raises(OptionError, match=r"cracks = .*: give two lengths in mm or more"):
            lives_under_shaking(rig, SINE, SINE, bent_beam, LAW, cracks=wrong)
    with pytest.raises(OptionError, match="cracks must increase"):
        lives_under_shaking(rig, SINE, SINE, bent_beam, LAW, cracks=[8.0, 6.0])
