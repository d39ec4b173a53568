"""Full spectra of circles and ellipses in closed form."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from analysis.shafts import shaft, whirl


def over_harmonics(spectrum):
    return spectrum["amplitude"].swap_dims(frequency="harmonic")


@pytest.mark.parametrize("window", ["boxcar", "hann", "flattop"])
@pytest.mark.parametrize(
    "case", [{}, {"sense": -1.0}, {"k_y": 4.0}, {"k_y": 4.0, "sense": -1.0}, {"k_x": 7.0, "c": 0.5}]
)
def test_circles_and_ellipses(case, window):
    run = ns.simulate(shaft(**case), periods=170, samples_per_period=16)
    found = over_harmonics(ns.full_spectrum(run, "x", "y", transient=150, window=window))
    forward, backward = whirl(1.7, **case)
    assert float(found.sel(harmonic=1.0)) == pytest.approx(forward, abs=1e-9)
    assert float(found.sel(harmonic=-1.0)) == pytest.approx(backward, abs=1e-9)
    if window == "boxcar":
        rest = found.where(abs(found["harmonic"]) != 1.0, 0.0)
        assert float(rest.max()) < 1e-9


def test_half_axes_of_the_ellipse():
    """Their sum and difference, against the largest and the smallest distance on the orbit."""
    run = ns.simulate(shaft(k_y=4.0), periods=60, samples_per_period=4000)
    last = run.isel(time=slice(-4001, None))
    radius = np.hypot(last["x"], last["y"])
    found = over_harmonics(ns.full_spectrum(run, "x", "y", transient=59))
    forward, backward = (float(found.sel(harmonic=h)) for h in (1.0, -1.0))
    assert forward + backward == pytest.approx(float(radius.max()), rel=1e-5)
    assert abs(forward - backward) == pytest.approx(float(radius.min()), rel=1e-4)


@pytest.mark.parametrize("segments", [1, 3])
def test_power_is_the_mean_square_of_the_radius(segments):
    run = ns.simulate(ns.models.rotor(), periods=90, samples_per_period=33)
    found = ns.full_spectrum(run, "x", "y", segments=segments)
    total = float(found["power_density"].sum()) * found.attrs["resolution"]
    mean = float((run["x"][1:] ** 2 + run["y"][1:] ** 2).mean())
    assert total == pytest.approx(mean, rel=1e-12)


def test_it_agrees_with_the_spectrum_of_one_variable():
    """Of a real motion either side has half of the amplitude."""
    run = ns.simulate(ns.models.rotor().with_parameters(eta=3.0), periods=64)
    run = run.assign(none=0.0 * run["x"])
    one = ns.power_spectrum(run, "x")
    both = ns.full_spectrum(run, "x", "none")["amplitude"]
    for k in (1, 7, 32, 64):
        f = float(one["frequency"][k])
        for side in (f, -f):
            value = float(both.sel(frequency=side, method="nearest"))
            assert 2.0 * value == pytest.approx(float(one["amplitude"][k]), abs=1e-14)


def test_labels_and_units():
    run = ns.simulate(shaft(), periods=20)
    found = ns.full_spectrum(run, "x", "y")
    assert found["amplitude"].attrs == {
        "long_name": "amplitude of x + i y",
        "units": "mm",
    }
    assert found["power_density"].attrs["units"] == "mm^2/Hz"
    assert found["frequency"].attrs["units"] == "Hz"
    assert np.all(np.diff(found["frequency"]) > 0.0)
    np.testing.assert_allclose(
        found["frequency"], found["harmonic"] * 1.7 / (2 * np.pi), rtol=1e-12
    )


def test_without_a_period():
    """A free circle passed backward ten times."""
    free = ns.System(states=["x", "y"], equations={"x": "2*y", "y": "-2*x"})
    run = ns.simulate(free, {"x": 0.7}, times=np.arange(400) * np.pi / 40)
    found = ns.full_spectrum(run, "x", "y")
    place = int(found["amplitude"].argmax("frequency"))
    assert float(found["frequency"][place]) == pytest.approx(-1 / np.pi, rel=1e-9)
    assert float(found["amplitude"][place]) == pytest.approx(0.7, abs=1e-12)
    assert "harmonic" not in found.coords


def test_it_survives_a_file(tmp_path):
    found = ns.full_spectrum(ns.simulate(shaft(), periods=20), "x", "y")
    found.to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    xr.testing.assert_identical(xr.load_dataset(tmp_path / "a.nc", engine="h5netcdf"), found)


def test_wrong_options():
    run = ns.simulate(shaft(), periods=20)
    with pytest.raises(ns.OptionError, match="'x' is in mm and 'u' in mm/s"):
        ns.full_spectrum(run, "x", "u")
    with pytest.raises(ns.OptionError, match="unknown variable 'z'"):
        ns.full_spectrum(run, "x", "z")
    with pytest.raises(ns.OptionError, match="segments = 0"):
        ns.full_spectrum(run, "x", "y", segments=0)
