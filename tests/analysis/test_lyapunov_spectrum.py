"""Exponents against closed forms: sums from divergence and impacts, linear systems, ranks."""

import math

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from analysis.walls import (
    beside_duffing,
    beside_soft_impact,
    damped,
    kicked,
    mole_determinant_rate,
    rigid_wall,
    stick_and_slip,
)


@pytest.mark.parametrize("omega", [2.2, 3.2])  # periodic, chaotic
def test_sum_counts_impacts(omega):
    """Each impact multiplies areas by r^2, damping by exp(-2 zeta t)."""
    spectrum = ns.lyapunov_spectrum(rigid_wall(omega=omega), transient=100, record=500)
    rate = spectrum.attrs["n_impacts"] / spectrum.attrs["duration"]
    assert spectrum.attrs["n_impacts"] > 200
    assert float(spectrum["exponent_sum"]) == pytest.approx(
        2 * math.log(0.8) * rate - 0.04, abs=1e-9
    )


def test_impacts_are_those_of_the_run():
    """The trajectory is that of simulate, bit for bit, however often columns are exchanged."""
    spectrum = ns.lyapunov_spectrum(rigid_wall(), transient=0, record=200, interval=0.3)
    assert spectrum.attrs["n_impacts"] == ns.simulate(rigid_wall(), periods=200).attrs["n_events"]


@pytest.mark.parametrize(
    ("system", "total"),
    [
        (ns.models.soft_impact(omega=0.905), -0.02),
        (ns.models.soft_impact(omega=0.905, zeta=0.07), -0.14),
        (ns.models.duffing(), -0.3),
    ],
)
def test_sum_is_the_divergence(system, total):
    spectrum = ns.lyapunov_spectrum(system, transient=50, record=300)
    assert float(spectrum["exponent_sum"]) == pytest.approx(total, abs=1e-9)


def test_sum_is_the_mean_divergence_of_chua():
    """From the times that a run of its own spends on either slope of the resistor."""
    system = ns.models.chua()
    start = ns.simulate(system, t_end=100).isel(time=-1)
    spectrum = ns.lyapunov_spectrum(system, start, transient=0, record=30, t_start=0.0)
    run = ns.simulate(system, start, t_end=30.0, t_start=0.0)
    times = np.append(run["event_time"].values, 30.0)
    names = run["event_to"].attrs["flag_meanings"].split()
    inner = sum(
        last - first
        for first, last, mode in zip(times[:-1], times[1:], run["event_to"].values, strict=True)
        if names[mode] == "inner"
    )
    assert 5.0 < inner < 25.0
    divergence = (inner * (9 / 7 - 1) + (30 - inner) * (-18 / 7 - 1)) / 30
    assert float(spectrum["exponent_sum"]) == pytest.approx(divergence, abs=1e-9)


@pytest.mark.parametrize("zeta", [0.01, 0.3])
def test_linear_oscillator(zeta):
    """Over a period of the damped motion the columns are multiplied by exp(-zeta T)."""
    spectrum = ns.lyapunov_spectrum(damped(zeta), transient=3, record=20)
    np.testing.assert_allclose(spectrum["lyapunov_exponent"], [-zeta, -zeta], rtol=0, atol=1e-13)
    assert np.all(spectrum["standard_error"] < 1e-13)
    assert float(spectrum["kaplan_yorke_dimension"]) == 0.0


@pytest.mark.parametrize(
    ("system", "rate", "total"),
    [
        (beside_duffing, 5.0, -0.3),
        (beside_duffing, 100.0, -0.3),
        (beside_soft_impact, 5.0, -0.02),
        (beside_soft_impact, 2000.0, -0.02),  # exp(-2000 T) is no number of 64 bits
    ],
)
def test_contraction_is_a_number_however_strong(system, rate, total):
    """The exponents of the oscillator stand unspoiled beside it."""
    spectrum = ns.lyapunov_spectrum(system(rate), transient=10, record=10)
    values = spectrum["lyapunov_exponent"].values
    assert values[2] == pytest.approx(-rate, abs=1 / spectrum.attrs["duration"])
    assert values.sum() == pytest.approx(total - rate, abs=1e-11 * rate)
    alone = ns.lyapunov_spectrum(system(rate), transient=10, record=10, exponents=2)
    np.testing.assert_allclose(values[:2], alone["lyapunov_exponent"], rtol=0, atol=1e-6)


def test_the_mole_loses_one_direction():
    """A slaved state is minus infinity; the drift is neutral; the rest follows by hand."""
    mole = ns.models.moling()
    spectrum = ns.lyapunov_spectrum(mole, transient=60, record=40)
    values = spectrum["lyapunov_exponent"].values
    assert values[0] == pytest.approx(0.0, abs=1e-14)  # v
    assert values[3] == -np.inf and np.isnan(spectrum["standard_error"][3])
    by_hand = mole_determinant_rate(mole, ns.simulate(mole, periods=70))
    assert values[1] + values[2] == pytest.approx(by_hand, abs=1e-10)
    assert float(spectrum["exponent_sum"]) == -np.inf
    assert float(spectrum["kaplan_yorke_dimension"]) == 1.0


def test_exponents_of_the_mole_are_its_multipliers():
    mole = ns.models.moling()
    orbit = ns.simulate(mole, ns.simulate(mole, periods=60), periods=1, tangent=[])
    sizes = np.sort(np.abs(np.linalg.eigvals(orbit["tangent"].values[-1])))[::-1]
    spectrum = ns.lyapunov_spectrum(mole, transient=60, record=40)
    wanted = np.log(sizes[:2]) / orbit.attrs["period"]
    np.testing.assert_allclose(spectrum["lyapunov_exponent"][:2], wanted, rtol=0, atol=1e-10)


def test_sticking_loses_every_direction_but_the_motion():
    """Whoever sticks leaves the belt as all others do; only time along the orbit is left."""
    values = ns.lyapunov_spectrum(stick_and_slip(), transient=50, record=100)["lyapunov_exponent"]
    assert values[0] == pytest.approx(0.0, abs=0.02)
    assert values[1] == -np.inf


@pytest.mark.parametrize("count", [None, 1])
@pytest.mark.parametrize("fall", ["-1", "-1 - 1e-6*y**2"])  # in closed form, by series
def test_what_a_transient_loses_is_not_lost(fall, count):
    """A ball rests on its table once, in the fourth period, and hops chaotically for good."""
    shaken = ns.System(
        name="shaken table",
        states=["y", "v"],
        period="2*pi",
        parameters={"A": 3.2777, "r": 0.3},
        modes={
            "flight": ns.Mode(
                {"y": "v", "v": fall},
                exits=[
                    ns.Exit(
                        "y - A*sin(t)",
                        reset={"v": "-r*v + (1 + r)*A*cos(t)"},
                        sticks="rides",
                        name="impact",
                    )
                ],
            )
        },
    )
    start = {"y": 10.06}
    run = ns.simulate(shaken, start, periods=200)
    rests = run["event_time"].values[run["event_kind"].values == "chatter"]
    assert rests.size > 0 and rests[-1] < 2 * math.pi * 50
    found = ns.lyapunov_spectrum(shaken, start, transient=50, record=150, exponents=count)
    assert float(found["lyapunov_exponent"][0]) > 0.01
    if count is None:  # flights keep areas, and each impact multiplies them by r^2
        rate = found.attrs["n_impacts"] / found.attrs["duration"]
        assert float(found["exponent_sum"]) == pytest.approx(2 * math.log(0.3) * rate, abs=1e-9)


def test_a_graze_is_no_loss():
    """An impact at a speed of 1e-7 stretches by 1e7 and contracts by as much."""
    graze = ns.System(
        name="graze",
        states=["x", "v"],
        parameters={"r": 0.5},
        modes={
            "free": ns.Mode(
                {"x": "v", "v": "1"}, exits=[ns.Exit("c - x", reset={"v": "-r*v"}, name="impact")]
            )
        },
        definitions={"c": "1e-14/2"},
    )
    start = {"x": 0.0, "v": 0.0}
    spectrum = ns.lyapunov_spectrum(graze, start, transient=0, record=1.5e-7)
    assert spectrum.attrs["n_impacts"] == 1
    assert np.all(np.isfinite(spectrum["lyapunov_exponent"]))


def test_a_velocity_that_is_set_is_lost():
    """Instants of impact differ still, so the other exponent is a number."""
    spectrum = ns.lyapunov_spectrum(kicked(), transient=20, record=20)
    assert spectrum.attrs["n_impacts"] > 20
    assert np.isfinite(spectrum["lyapunov_exponent"][0])
    assert spectrum["lyapunov_exponent"][1] == -np.inf


def test_fewer_exponents_are_the_leading_ones():
    whole, part = (
        ns.lyapunov_spectrum(rigid_wall(), transient=100, record=200, exponents=count)
        for count in (2, 1)
    )
    assert part.sizes["exponent"] == 1
    np.testing.assert_allclose(
        part["lyapunov_exponent"], whole["lyapunov_exponent"][:1], rtol=0, atol=1e-9
    )
    assert np.isnan(part["exponent_sum"]) and np.isnan(part["kaplan_yorke_dimension"])


def test_the_interval_changes_the_bookkeeping_only():
    coarse, fine = (
        ns.lyapunov_spectrum(rigid_wall(), transient=20, record=40, interval=interval)
        for interval in (2.0, 0.25)
    )
    assert (coarse.sizes["time"], fine.sizes["time"]) == (20, 160)
    np.testing.assert_allclose(
        coarse["lyapunov_exponent"], fine["lyapunov_exponent"], rtol=0, atol=1e-10
    )
    np.testing.assert_allclose(
        fine["running_exponent"].sel(time=coarse["time"], method="nearest"),
        coarse["running_exponent"],
        rtol=0,
        atol=1e-9,
    )


def test_kaplan_yorke_dimension_of_duffing():
    spectrum = ns.lyapunov_spectrum(ns.models.duffing(), transient=50, record=300)
    first, second = spectrum["lyapunov_exponent"].values
    assert first > 0.05
    assert float(spectrum["kaplan_yorke_dimension"]) == pytest.approx(1 - first / second)


def test_starts_from_results_and_slaved_modes():
    """A start in contact, where a state is slaved, has lost that direction already."""
    mole = ns.models.moling()
    run = ns.simulate(mole, periods=60)
    spectrum = ns.lyapunov_spectrum(mole, run, transient=0, record=10)
    assert spectrum["lyapunov_exponent"][3] == -np.inf
    inside = run.isel(time=int(np.flatnonzero(run["mode"].values == 1)[-1]))
    spectrum = ns.lyapunov_spectrum(mole, inside, transient=0, record=10)
    assert np.all(np.isneginf(spectrum["running_exponent"][:, 3]))


def test_it_survives_a_file(tmp_path):
    spectrum = ns.lyapunov_spectrum(
        ns.models.moling(), transient=5, record=5, parameters={"b": 0.12}, seed=3
    )
    spectrum.to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    xr.testing.assert_identical(xr.load_dataset(tmp_path / "a.nc", engine="h5netcdf"), spectrum)
    assert spectrum.attrs["transient"] == 5.0 and spectrum.attrs["seed"] == 3
    assert ns.System.from_toml(spectrum.attrs["system"]).parameter_values["b"] == 0.12


def test_an_early_end_is_told():
    with pytest.warns(ns.RunWarning, match="impacts accumulate"):
        spectrum = ns.lyapunov_spectrum(rigid_wall(omega=3.0, sigma=-0.05), record=1000)
    assert spectrum.attrs["status"] == "event_limit"
    assert np.all(np.isnan(spectrum["lyapunov_exponent"]))


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"exponents": 3}, "has 2 states"),
        ({"exponents": 0}, "at least 1"),
        ({"record": 0}, "record = 0 must be positive"),
        ({"transient": -1}, "transient = -1 must not be negative"),
        ({"interval": 0}, "interval = 0 must be positive"),
        ({"seed": -1}, "seed = -1 must be a whole number"),
        ({"initial": {"y": 1}}, "unknown state 'y'"),
        ({"initial": {"x": 1.0}}, "fits no mode"),
        ({"mode": "stuck"}, "unknown mode 'stuck'"),
        ({"parameters": {"q": 1}}, "unknown parameter 'q'"),
    ],
)
def test_wrong_options(options, text):
    with pytest.raises((ns.OptionError, ns.ModelError), match=text):
        ns.lyapunov_spectrum(rigid_wall(), **options)


def test_slow_parameters_are_refused():
    system = ns.System(
        states=["x", "v"],
        parameters={"omega": 1.0},
        period="2*pi/omega",
        slow={"omega": "1 + 0.001*t"},
        equations={"x": "v", "v": "cos(omega*t) - x - v"},
    )
    with pytest.raises(ns.OptionError, match=r"slow= varies 'omega'"):
        ns.lyapunov_spectrum(system)


def test_a_run_that_ends_early_tells_when():
    """A ball from the height 1 with r = 1/2 has come to rest after 3 sqrt(2), by a sum of falls."""
    ball = ns.System(
        states=["h", "u"],
        modes={
            "flight": ns.Mode(
                {"h": "u", "u": "-1"}, exits=[ns.Exit("h", reset={"u": "-0.5*u"}, name="impact")]
            )
        },
    )
    with pytest.warns(ns.RunWarning, match=r"event_limit at t = 4\.2426406"):
        ns.lyapunov_spectrum(ball, {"h": 1.0})


@pytest.mark.parametrize("record", [1000, 1500, 2000])
def test_standard_errors_count_the_cycle_that_the_record_cuts_off(record):
    """A neuron that bursts: blocks of 31 intervals hold nearly one cycle of 31.2 each.

    One exponent of a cycle is zero, the other one follows from its multiplier.
    """
    neuron = ns.System(
        states=["v", "u"],
        parameters={"I": 10.0},
        initial={"v": -55.0, "u": -5.0},
        modes={
            "rest": ns.Mode(
                {"v": "0.04*v**2 + 5*v + 140 - u + I", "u": "0.02*(0.2*v - u)"},
                exits=[ns.Exit("30 - v", reset={"v": "-55", "u": "u + 4"}, name="spike")],
            )
        },
    )
    cycle = ns.find_orbit(neuron, transient=300)
    moduli = np.abs(cycle["multipliers"].values)
    slower = math.log(np.sort(moduli)[0] if moduli.max() > 0.9 else moduli.max())
    truth = np.array([0.0, slower / float(cycle["length"])])
    found = ns.lyapunov_spectrum(neuron, transient=500, record=record)
    errors = found["standard_error"].values
    assert np.all(np.abs(found["lyapunov_exponent"].values - truth) < 4.0 * errors)
    assert np.all(errors < 1e-2)
