"""Spectra against Fourier series in closed form."""

import mpmath
import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns


def spring(zeta: float = 0.05) -> ns.System:
    return ns.System(
        name="spring",
        states=["x", "v"],
        parameters={"omega": 1.7, "zeta": zeta},
        period="2*pi/omega",
        equations={"x": "v", "v": "cos(omega*t) + 0.25*sin(3*omega*t) + 0.5 - 2*zeta*v - x"},
        describe={"time": "time [s]", "x": "displacement [mm]"},
    )


def over_harmonics(spectrum):
    return spectrum["amplitude"].swap_dims(frequency="harmonic")


@pytest.mark.parametrize("window", ["boxcar", "hann", "flattop"])
def test_two_harmonics(window):
    """Amplitudes of a linear oscillator by its transfer function; the window changes no peak."""
    run = ns.simulate(spring(), periods=150, samples_per_period=20)
    spectrum = ns.power_spectrum(run, "x", transient=130, window=window)

    def gain(w):
        return 1 / np.hypot(1 - w * w, 0.1 * w)

    amplitude = over_harmonics(spectrum)
    for order, size in ((0, 0.5), (1, gain(1.7)), (3, 0.25 * gain(5.1))):
        assert float(amplitude.sel(harmonic=order)) == pytest.approx(size, abs=1e-9)
    if window == "boxcar":
        rest = amplitude.where(~amplitude["harmonic"].isin([0, 1, 3]), 0.0)
        assert float(rest.max()) < 1e-9
    assert spectrum["frequency"][1] == pytest.approx(1.7 / (2 * np.pi) / 20, rel=1e-12)
    assert amplitude.attrs["units"] == "mm"
    assert spectrum["power_density"].attrs["units"] == "mm^2/Hz"
    assert spectrum["frequency"].attrs["units"] == "Hz"


def test_bilinear_oscillator():
    """Free, undamped, without a gap: half a sine at either stiffness, here 1 and 9."""
    system = ns.models.soft_impact(zeta=0, beta=8, e=0, a=0, omega=1.5)
    run = ns.simulate(system, {"v": 1.0}, periods=3, samples_per_period=2000)
    spectrum = ns.power_spectrum(run, "x")
    # at x > 0 the stiffness is 9
    soft, stiff, period = mpmath.pi, mpmath.pi / 3, 4 * mpmath.pi / 3

    def coefficient(w):
        first = mpmath.quad(lambda t: mpmath.sin(3 * t) / 3 * mpmath.expj(-w * t), [0, stiff])
        second = mpmath.quad(
            lambda t: -mpmath.sin(t - stiff) * mpmath.expj(-w * t), [stiff, stiff + soft]
        )
        return (1 if w == 0 else 2) * abs(first + second) / period

    for order in (0, 1, 2, 3, 5, 8):
        found = float(over_harmonics(spectrum).sel(harmonic=order))
        assert found == pytest.approx(float(coefficient(order * 1.5)), abs=1e-7), order


def test_power_is_the_mean_square():
    run = ns.simulate(ns.models.duffing(), periods=64, samples_per_period=32)
    for segments in (1, 4):
        spectrum = ns.power_spectrum(run, "x", segments=segments)
        total = float(spectrum["power_density"].sum()) * spectrum.attrs["resolution"]
        assert total == pytest.approx(float((run["x"][1:] ** 2).mean()), rel=1e-12)
    assert spectrum.attrs["n_samples"] == 512


@pytest.mark.parametrize("window", ["boxcar", "hann", "flattop"])
@pytest.mark.parametrize("spectrum_of", [ns.power_spectrum, ns.full_spectrum])
def test_a_window_leaves_the_mean_in_one_line(spectrum_of, window):
    """0.5 at zero and nothing beside it; the power is the mean square of the closed form."""
    run = ns.simulate(spring(), periods=150, samples_per_period=20)
    run["w"] = run["x"] * 0.0
    names = ["x"] if spectrum_of is ns.power_spectrum else ["x", "w"]
    found = spectrum_of(run, *names, transient=130, window=window)
    over = over_harmonics(found)
    assert float(over.sel(harmonic=0)) == pytest.approx(0.5, abs=1e-9)
    assert float(over.sel(harmonic=slice(0.01, 0.5)).max()) < 1e-7
    sizes = [1.0 / np.hypot(1.0 - (1.7 * n) ** 2, 0.1 * 1.7 * n) for n in (1, 3)]
    square = 0.25 + (sizes[0] ** 2 + (0.25 * sizes[1]) ** 2) / 2.0
    total = float(found["power_density"].sum()) * found.attrs["resolution"]
    assert total == pytest.approx(square, rel=1e-6)


def test_without_a_period():
    """A free oscillator that turns ten times in the record; the last sample begins the next."""
    free = ns.System(states=["x", "v"], equations={"x": "v", "v": "-4*x"})
    run = ns.simulate(free, {"x": 0.7}, times=np.arange(400) * np.pi / 40)
    spectrum = ns.power_spectrum(run, "x")
    assert int(np.argmax(spectrum["amplitude"].values)) == 10
    assert float(spectrum["amplitude"].max()) == pytest.approx(0.7, abs=1e-12)
    assert float(spectrum["frequency"][10]) == pytest.approx(1 / np.pi, rel=1e-9)
    assert "harmonic" not in spectrum.coords


def test_drift_is_taken_off():
    """The progression is a staircase; without its slope it repeats with the forcing."""
    run = ns.simulate(ns.models.moling(), periods=60, samples_per_period=64)
    spectrum = ns.power_spectrum(run, "v", transient=50)
    between = spectrum["amplitude"].where(spectrum["harmonic"] % 1 != 0, 0.0)
    assert float(between.max()) < 1e-10 < 1.0 < float(over_harmonics(spectrum).sel(harmonic=1))


def test_it_survives_a_file(tmp_path):
    run = ns.simulate(spring(), periods=20)
    spectrum = ns.power_spectrum(run, "x")
    spectrum.to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    loaded = xr.load_dataset(tmp_path / "a.nc", engine="h5netcdf")
    xr.testing.assert_identical(loaded, spectrum)
    assert loaded.attrs == spectrum.attrs


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"variable": "w"}, "unknown variable 'w'"),
        ({"variable": "mode"}, "its numbers stand for names"),
        ({"variable": "event_time"}, r"unknown variable .*known: v, x\)"),
        ({"window": "square"}, "window = 'square'"),
        ({"segments": 50}, "too few for 50 segments"),
        ({"segments": 0}, "segments = 0"),
        ({"transient": -1}, "transient = -1"),
    ],
)
def test_wrong_options(options, text):
    run = ns.simulate(spring(), periods=20, samples_per_period=10)
    with pytest.raises(ns.OptionError, match=text):
        ns.power_spectrum(run, **({"variable": "x"} | options))


def test_samples_that_do_not_fit():
    run = ns.simulate(spring(), times=np.arange(0, 40, 0.1))
    with pytest.raises(ns.OptionError, match="must hold a whole number"):
        ns.power_spectrum(run, "x")
    with pytest.raises(ns.OptionError, match="not equidistant"):
        ns.power_spectrum(ns.simulate(spring(), times=[0, 1, 3, 4, 9]), "x")
    with pytest.raises(ns.OptionError, match="give a result of simulate"):
        ns.power_spectrum(np.ones(300), "x")


@pytest.mark.parametrize(
    ("values", "said"),
    [([1.0], "1 samples are too few"), (1e200 * np.ones(400), "whose squares no double holds")],
)
def test_series_of_which_there_is_no_spectrum(values, said):
    data = xr.Dataset({"x": ("time", values)}, {"time": np.arange(len(values)) / 10.0})
    with pytest.raises(ns.OptionError, match=said):
        ns.power_spectrum(data, "x")


def test_the_mean_has_its_sign_and_the_line_at_zero_its_size():
    """The record is a cosine about -0.5 in x, about 0.25 in y."""
    time = 2 * np.pi * np.arange(321) / 32
    run = xr.Dataset(
        {"x": ("time", np.cos(time) - 0.5), "y": ("time", np.sin(time) + 0.25)},
        {"time": time},
        {"period": 2 * np.pi},
    )
    one, both = ns.power_spectrum(run, "x"), ns.full_spectrum(run, "x", "y")
    assert one.attrs["mean"] == pytest.approx(-0.5, abs=1e-14)
    assert float(over_harmonics(one).sel(harmonic=0)) == pytest.approx(0.5, abs=1e-14)
    means = both.attrs["mean"], both.attrs["second_mean"]
    assert means == pytest.approx((-0.5, 0.25), abs=1e-14)
    middle = float(over_harmonics(both).sel(harmonic=0))
    assert middle == pytest.approx(np.hypot(*means), abs=1e-14)
