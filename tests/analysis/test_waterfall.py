"""Spectra over a speed against the response of linear shafts."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from analysis.shafts import shaft, vectors, whirl
from nonsmooth.runs import crew

SPEEDS = np.linspace(0.6, 2.5, 9)
QUICK = {"transient": 150, "record": 8, "samples_per_period": 12}


@pytest.mark.parametrize("window", ["boxcar", "hann"])
def test_unbalance_response(window):
    """Forward whirl at the first order only, by the transfer function."""
    found = ns.waterfall(shaft(), "w", SPEEDS, ("x", "y"), window=window, **QUICK)
    amplitude = found["amplitude"]
    radius = [whirl(w)[0] for w in SPEEDS]
    np.testing.assert_allclose(amplitude.sel(harmonic=1.0), radius, rtol=1e-8)
    assert float(amplitude.sel(harmonic=-1.0).max()) < 1e-9
    assert float(amplitude.sel(harmonic=[0.0, 2.0, 3.0]).max()) < 1e-9
    np.testing.assert_allclose(
        found["frequency"].sel(harmonic=2.0), 2.0 * SPEEDS / (2 * np.pi), rtol=1e-14
    )
    np.testing.assert_allclose(found["period"], 2 * np.pi / SPEEDS, rtol=1e-14)
    assert found["amplitude"].attrs["units"] == "mm"
    assert found["period"].attrs["units"] == "s"


@pytest.mark.parametrize("window", ["boxcar", "hann"])
def test_phases(window):
    """Of forward and backward vectors, and of one coordinate."""
    system = shaft(k_y=3.0)
    both = ns.waterfall(system, "w", SPEEDS, ("x", "y"), window=window, **QUICK)
    one = ns.waterfall(system, "w", SPEEDS, "x", window=window, **QUICK)
    for k, w in enumerate(SPEEDS):
        forward, backward = vectors(w, k_y=3.0)
        x = forward + np.conj(backward)
        for found, harmonic, wanted in ((both, 1, forward), (both, -1, backward), (one, 1, x)):
            line = found.isel(parameter=k).sel(harmonic=harmonic)
            vector = float(line["amplitude"]) * np.exp(1j * float(line["phase"]))
            assert vector == pytest.approx(wanted, abs=1e-8)
    assert "phase" not in ns.waterfall(system, "w", [1.0], "x", segments=2, **QUICK)


def test_the_phase_at_zero_is_the_direction_of_the_mean():
    """A dead load of -0.3 on a unit spring moves the middle of its motion to -0.3."""
    loaded = ns.System(
        states=["x", "v"],
        parameters={"g": 0.3},
        period="pi",
        equations={"x": "v", "v": "cos(2*t) - 0.5*v - x - g"},
    )
    line = ns.waterfall(loaded, "g", [0.3, -0.2], "x", **QUICK).sel(harmonic=0)
    means = (line["amplitude"] * np.cos(line["phase"])).values
    np.testing.assert_allclose(means, [-0.3, 0.2], atol=1e-12)


def test_ellipse_over_a_stiffness():
    stiffness = np.array([0.5, 1.0, 2.0, 5.0])
    found = ns.waterfall(shaft(), "k_y", stiffness, ("x", "y"), **QUICK)["amplitude"]
    for k, value in enumerate(stiffness):
        wanted = whirl(1.7, k_y=value)
        assert found.sel(harmonic=[1.0, -1.0])[k].values == pytest.approx(wanted, abs=1e-9)


@pytest.mark.slow
def test_one_sided_is_the_spectrum_of_the_run():
    system = ns.models.rotor()
    found = ns.waterfall(
        system, "eta", [2.442, 3.0], "x", transient=30, record=24, samples_per_period=20,
        segments=2, window="boxcar",
    )  # fmt: skip
    for k, eta in enumerate((2.442, 3.0)):
        run = ns.simulate(system, periods=54, samples_per_period=20, parameters={"eta": eta})
        wanted = ns.power_spectrum(run, "x", transient=30, segments=2)
        for name in ("amplitude", "power_density"):
            chosen = slice(1, None)  # the mean of all against that of each segment
            np.testing.assert_allclose(found[name][k, chosen], wanted[name][chosen], atol=1e-11)
        np.testing.assert_allclose(found["frequency"][k], wanted["frequency"], rtol=1e-12)
        mean = float(run["x"].values[-480:].mean())
        assert float(found["amplitude"][k, 0]) == pytest.approx(abs(mean), rel=1e-9)


@pytest.mark.slow
def test_no_window_spreads_the_mean():
    found = ns.waterfall(ns.models.rotor(eps_x=0.2, delta_x=0.0), "eta", [0.5], "x", **QUICK)
    amplitude = found["amplitude"].isel(parameter=0)
    assert float(amplitude.sel(harmonic=0.0)) == pytest.approx(0.2, abs=1e-9)
    assert float(amplitude.sel(harmonic=[0.125, 0.25]).max()) < 1e-9


def test_following_finds_the_other_branch():
    """Both branches of a bent resonance."""
    spring = ns.models.duffing(alpha=1.0, beta=1.0, delta=0.05, gamma=0.2, omega=1.5)
    grid = np.linspace(0.9, 1.6, 29)
    up, down = (
        ns.waterfall(spring, "omega", grid, "x", start=start, **QUICK)["amplitude"]
        for start in ("follow up", "follow down")
    )
    assert float(up.sel(parameter=1.6, harmonic=1.0, method="nearest")) > 0.8
    assert float(down.sel(parameter=1.6, harmonic=1.0, method="nearest")) < 0.3
    assert float(abs(up - down).sel(parameter=0.9, method="nearest").max()) < 1e-3


@pytest.mark.parametrize("start", ["restart", "follow up"])
def test_threads_and_stores_change_nothing(tmp_path, start):
    call = (ns.models.rotor(), "eta", np.linspace(2.2, 3.0, 19), ("x", "y"))
    options = {"transient": 10, "record": 6, "start": start}
    plain = ns.waterfall(*call, **options, threads=1)
    xr.testing.assert_identical(plain, ns.waterfall(*call, **options, threads=2))
    kept = ns.waterfall(*call, **options, threads=2, store=tmp_path / "s")
    xr.testing.assert_identical(plain, kept)
    for path in sorted((tmp_path / "s").glob("0*.npz"))[::2]:
        path.unlink()
    xr.testing.assert_identical(plain, ns.waterfall(*call, **options, store=tmp_path / "s"))
    with pytest.raises(ns.OptionError, match="window"):
        ns.waterfall(*call, **options, store=tmp_path / "s", window="boxcar")


def test_a_transient_is_told():
    """A decaying transient, whose line is at the natural frequency, is no motion with a period.

    From rest it decays as exp(-c t/2) beside a circle of its size. After 20 periods of 2 pi/1.7
    that is 0.69 for c = 0.01, and 1e-16 for c = 1; after 1200 periods it is 3e-10 for c = 0.01.
    """
    calls = shaft(), "c", [0.01, 1.0], ("x", "y")
    options = {"record": 24, "samples_per_period": 12}
    early = ns.waterfall(*calls, transient=20, **options)
    assert float(early["amplitude"][0].sel(harmonic=1 / 1.7, method="nearest")) > 0.01
    assert early["motion_period"].values.tolist() == [0, 1]
    assert early.attrs["message"] == (
        "completed; 1 of 2 motions have not settled to a period of at most 12 within 44 periods:"
        " chaos, quasi-periodic motion, a longer period or a long transient, which a larger"
        " transient= or regime tells"
    )
    late = ns.waterfall(*calls, transient=1200, **options)
    assert float(late["amplitude"][0].sel(harmonic=1 / 1.7, method="nearest")) < 1e-8
    assert late["motion_period"].values.tolist() == [1, 1]
    assert late.attrs["message"] == "completed"


def test_periods_of_motions():
    """A circle has the period of its strobes, or none where these are in no whole ratio to it."""
    free = ns.System(
        states=["x", "y"], parameters={"n": 3.0}, equations={"x": "-y", "y": "x"},
        initial={"x": 0.4, "y": 0.3},
    )  # fmt: skip
    chosen = ns.StroboscopicMap(free, period="2*pi/n")
    found = ns.waterfall(chosen, "n", [1.0, 2.0, 3.0, np.sqrt(2.0)], "x", **QUICK)
    assert found["motion_period"].values.tolist() == [1, 2, 3, 0]
    assert "1 of 4 motions have not settled to a period of at most 4" in found.attrs["message"]
    short = ns.waterfall(chosen, "n", [1.0], "x", record=1)
    assert short.attrs["message"] == (
        "completed; record = 1 is too short to tell whether motions settled"
    )


def test_periods_are_those_of_the_diagram():
    call = (ns.models.rotor(), "eta", np.linspace(2.2, 3.4, 13))
    options = {"transient": 200, "record": 16, "start": "follow up"}
    found = ns.waterfall(*call, "x", **options)
    periods = ns.bifurcation_diagram(*call, **options)["period"].isel(lane=0)
    np.testing.assert_array_equal(found["motion_period"], periods)
    assert {0, 1} <= set(found["motion_period"].values.tolist())  # chaos too


def test_values_that_are_refused():
    found = ns.waterfall(shaft(), "w", [-1.0, 1.0], "x", **QUICK)
    assert found["status"].values.tolist() == ["refused", "completed"]
    assert found["motion_period"].values.tolist() == [0, 1]
    assert np.all(np.isnan(found["amplitude"][0]))
    assert found.attrs["message"] == "some motions ended early, see status: refused"


def test_a_map_gives_the_period():
    """A free circle whose speed is a parameter, strobed at that speed."""
    free = ns.System(
        states=["x", "y"],
        parameters={"w": 2.0},
        equations={"x": "-w*y", "y": "w*x"},
        initial={"x": 0.5},
    )
    chosen = ns.StroboscopicMap(free, period="2*pi/w")
    found = ns.waterfall(chosen, "w", [1.0, 2.5], ("x", "y"), **QUICK)["amplitude"]
    np.testing.assert_allclose(found.sel(harmonic=1.0), 0.5, rtol=1e-9)
    with pytest.raises(ns.OptionError, match="no period"):
        ns.waterfall(free, "w", [1.0], "x")


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"variable": "z"}, "unknown variable 'z'"),
        ({"variable": ("x", "y", "u")}, "give the name of a state or output, or two"),
        ({"variable": ("x", "u")}, "one unit"),
        ({"window": "square"}, "window = 'square'"),
        ({"record": 2, "segments": 3}, "too few"),
        ({"start": "upward"}, "start = .upward.: give one of "),
        ({"values": []}, "non-empty"),
        ({"parameters": {"w": 2.0}}, "the value of 'w' counts for nothing"),
        ({"parameter": "q"}, "unknown parameter"),
    ],
)
def test_wrong_options(options, text):
    call = {"parameter": "w", "values": [1.0], "variable": "x"} | options
    with pytest.raises(ns.OptionError, match=text):
        ns.waterfall(shaft(), **call)


def test_an_interruption_keeps_what_is_done_and_no_more(monkeypatch):
    """Values that were not computed take no room."""
    take, calls = crew.take, []

    def interrupted(*arguments, **options):
        result = take(*arguments, **options)
        calls.append(result)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return result

    monkeypatch.setattr(crew, "take", interrupted)
    speeds = np.linspace(0.7, 0.9, 400)
    found = ns.waterfall(ns.models.soft_impact(), "omega", speeds, "x", transient=200, threads=1)
    assert found.attrs["status"] == "interrupted"
    assert set(found["status"].values) <= {"completed"} and found.sizes["parameter"] <= 32
    np.testing.assert_array_equal(found["parameter"], speeds[: found.sizes["parameter"]])
