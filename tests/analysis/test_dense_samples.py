"""Samples of orbits follow what the flow does in a leg: straight lines between them, and truth."""

import warnings

import numpy as np
import pytest

import nonsmooth as ns

OFF = 1e-3  # of the range of a variable: what straight lines may be off


def ring(rate="{}"):
    """A spring with 30 rad/s whose end jumps up and down, every 6 units of time."""
    flow = "-900*x - 0.5*v"
    modes = {
        "up": ns.Mode(
            {"x": "v", "v": rate.format(f"{flow} + 180"), "u": "1"},
            exits=[ns.Exit("3 - u", to="down", name="top")],
        ),
        "down": ns.Mode(
            {"x": "v", "v": rate.format(f"{flow} - 180"), "u": "-1"},
            exits=[ns.Exit("u + 3", to="up", name="bottom")],
        ),
    }
    return ns.System(states=["x", "v", "u"], modes=modes)


def ringing(t):
    """Its motion from the beginning of 'up': after half a turn it is the opposite."""
    root = -0.25 + 1j * np.sqrt(900.0 - 0.0625)
    # x = 0.2 + Re(c exp(root t)) with x(6) = -x(0) and v(6) = -v(0)
    turned = np.exp(6.0 * root)
    both = np.array([1.0 + turned, root * (1.0 + turned)])
    matrix = np.stack([both.real, -both.imag], axis=1)
    a, b = np.linalg.solve(matrix, [-0.4, 0.0])
    t = np.mod(t, 12.0)
    half = (a + 1j * b) * np.exp(root * np.mod(t, 6.0))
    return np.where(t < 6.0, 1.0, -1.0) * (0.2 + half.real)


def worst(samples, name, truth, begin=0.0):
    """How far straight lines between samples are off, by the range."""
    time, values = samples["time"].values, samples[name].values
    dense = np.linspace(time[0], time[-1], 400_001)[1:-1]
    off = np.abs(np.interp(dense, time, values) - truth(dense - begin))
    return off.max() / np.ptp(values)


@pytest.mark.parametrize("rate", ["{}", "{} + 0*x**2"])
def test_a_leg_with_many_oscillations(rate):
    """29 of them in each leg, in closed form and by Taylor series."""
    orbit = ns.find_orbit(ring(rate), transient=10)
    samples = ns.orbit_samples(orbit)
    begin = float(samples["time"].values[samples["mode"].values == 0][0])
    assert worst(samples, "x", ringing, begin) < 1.1 * OFF
    dense = ringing(np.linspace(0.0, 12.0, 400_001))
    assert float(samples["x"].max()) == pytest.approx(dense.max(), rel=OFF)
    assert samples.sizes["time"] < 60 * 2 * 29
    # the samples themselves are those of the motion, both ends of legs among them
    np.testing.assert_allclose(
        samples["x"], ringing(samples["time"].values - begin), rtol=0.0, atol=1e-10
    )
    ends = np.cumsum([0.0, *orbit["durations"].values]) + float(orbit["time"])
    times = samples["time"].values[np.flatnonzero(np.diff(samples["leg"].values))]
    np.testing.assert_allclose(times, ends[1:-1], rtol=1e-13)


@pytest.mark.parametrize("harmonic", [50, 200, 400])
def test_forcing_that_is_fast_beside_the_period(harmonic):
    """Also where it is the same at all samples to begin with: x = sin t + 0.5 sin(h t)."""
    text = f"-x + sin(t) + cos(t) + 0.5*sin({harmonic}*t) + {0.5 * harmonic}*cos({harmonic}*t)"
    system = ns.System(states=["x"], period="2*pi", equations={"x": text})
    samples = ns.orbit_samples(ns.find_orbit(system, {"x": 0.0}))
    assert float(samples["x"].max()) > 1.49
    assert worst(samples, "x", lambda t: np.sin(t) + 0.5 * np.sin(harmonic * t)) < 1.1 * OFF


def test_an_output_that_is_faster_than_the_states():
    system = ns.System(
        states=["x"], period="2*pi", equations={"x": "-x + cos(t)"},
        outputs={"table": "cos(40*t)"},
    )  # fmt: skip
    samples = ns.orbit_samples(ns.find_orbit(system))
    assert worst(samples, "table", lambda t: np.cos(40.0 * t)) < 1.1 * OFF


def test_what_fades_at_once_takes_samples_where_it_fades():
    """y jumps at each impact and forgets it in a millionth of the leg."""

    def mode(rate, guard, to):
        return ns.Mode({"u": rate, "y": "-1e6*y"}, exits=[ns.Exit(guard, to=to, reset={"y": "1"})])

    modes = {"up": mode("1", "1 - u", "down"), "down": mode("-1", "u", "up")}
    system = ns.System(states=["u", "y"], modes=modes)
    samples = ns.orbit_samples(ns.find_orbit(system, {"u": 0.5}, transient=2))
    for leg in (0, 1):
        part = samples.isel(time=samples["leg"].values == leg)
        since = part["time"].values - part["time"].values[0]
        dense = np.append(np.geomspace(1e-9, 1.0, 2000), 1.0)
        off = np.abs(np.interp(dense, since, part["y"].values) - np.exp(-1e6 * dense))
        assert off.max() < 1.5 * OFF
    assert samples.sizes["time"] < 600


def test_what_stays_for_rounding_takes_no_more():
    """The difference of two equal masses is zero but for rounding; a state at rest is."""
    mass = {"x1": "v1", "v1": "-x1 - 0.1*v1 - k*(x1 - x2) + cos(t)"}
    system = ns.System(
        states=["x1", "v1", "x2", "v2", "z"], period="2*pi", parameters={"k": 3.7},
        equations={**mass, "x2": "v2", "v2": "-x2 - 0.1*v2 - k*(x2 - x1) + cos(t)", "z": "-z"},
        outputs={"spring": "k*(x1 - x2)"},
    )  # fmt: skip
    assert ns.orbit_samples(ns.find_orbit(system)).sizes["time"] == 201


def test_a_jump_of_an_output_is_no_oscillation():
    system = ns.System(
        states=["x"], period="2*pi", equations={"x": "-x + cos(t)"}, outputs={"side": "sign(x)"}
    )
    assert ns.orbit_samples(ns.find_orbit(system)).sizes["time"] < 500


def test_samples_have_a_bound_and_it_is_told():
    """1500 oscillations over the whole range would take 75000."""
    text = "-x + sin(1500*t) + 1500*cos(1500*t)"
    system = ns.System(states=["x"], period="2*pi", equations={"x": text})
    orbit = ns.find_orbit(system, {"x": 0.0})
    with pytest.warns(ns.ResultWarning, match="% of the range of a variable off"):
        samples = ns.orbit_samples(orbit)
    assert 10_000 < samples.sizes["time"] <= 20_000
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert ns.orbit_samples(orbit, per_leg=75_000).sizes["time"] == 75_001
