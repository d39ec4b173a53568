"""The trilinear oscillator against the closed form of its free motion and its symmetry."""

import numpy as np
import pytest
from mpmath import mp

import nonsmooth as ns
from nonsmooth.models import trilinear
from periodic_orbits.systems import ORBITS

EPS = np.finfo(float).eps


def free_period(kappa, delta, amplitude):
    """Undamped and unforced, as a function of the amplitude: four arcs and two crossings."""
    with mp.workdps(40):
        kappa, delta, amplitude = mp.mpf(kappa), mp.mpf(delta), mp.mpf(amplitude)
        if amplitude <= delta:
            return float(2 * mp.pi)
        stiff = mp.sqrt(1 + kappa)
        centre = kappa * delta / (1 + kappa)
        arc = mp.acos((delta - centre) / (amplitude - centre))
        speed = (amplitude - centre) * stiff * mp.sin(arc)
        return float(4 * (arc / stiff + mp.atan2(delta, speed)))


@pytest.mark.parametrize("delta", [0.0, 0.5])
@pytest.mark.parametrize(("kappa", "amplitude"), [
    (-0.75, 2.0), (0.0, 2.0), (8.0, 0.5000001), (8.0, 0.75), (8.0, 20.0), (1e5, 0.6)])  # fmt: skip
def test_free_period(kappa, delta, amplitude):
    system = trilinear(zeta=0.0, F=0.0, kappa=kappa, delta=delta)
    exact = free_period(kappa, delta, amplitude)
    run = ns.simulate(system, {"x": amplitude}, t_end=10 * exact)
    assert run.attrs["status"] == "completed"
    # out of the upper stop once a period, each arc with some roundings of a time below 100
    falls = run["event_time"].values[
        np.char.startswith(run["event_path"].values.astype(str), "release")
        & (run["guard_rate"].values != 0.0)
        & (run["state_before"].values[:, 1] < 0.0)
    ]
    assert len(falls) == 10
    assert np.abs(np.diff(falls) - exact).max() < 6 * 16 * EPS * 10 * exact


def test_energy_is_kept_over_many_impacts():
    kappa, delta = 8.0, 0.5
    run = ns.simulate(trilinear(zeta=0.0, F=0.0), {"x": 1.7, "v": -0.4}, t_end=500)
    x, v = run["x"].values, run["v"].values
    energy = v**2 + x**2 + kappa * np.maximum(np.abs(x) - delta, 0.0) ** 2
    assert run.attrs["n_events"] > 500
    # a few roundings of the energy at each event
    assert np.abs(energy / energy[0] - 1).max() < 4 * EPS * run.attrs["n_events"]


def test_mirrored_and_half_a_period_later_is_a_motion():
    system = trilinear(omega=1.3, zeta=0.1)
    half = system.period_value / 2
    one = ns.simulate(system, {"x": 0.3, "v": 0.9}, t_end=5 * half, tangent=True)
    two = ns.simulate(system, {"x": -0.3, "v": -0.9}, t_start=half, t_end=6 * half)
    assert one.attrs["n_events"] == two.attrs["n_events"] > 5
    growth = np.abs(one["tangent"].values).max()
    apart = two["event_time"].values - half - one["event_time"].values
    assert np.abs(apart).max() < 64 * EPS * 6 * half * growth
    mirrored = {"upper": "lower", "lower": "upper", "free": "free"}
    assert ns.phase_word(two) == tuple(mirrored[name] for name in ns.phase_word(one, half * 3)) or (
        [mirrored[str(n)] for n in names(one)] == names(two)
    )


@pytest.mark.parametrize("omega", [1.5, 1.8])
def test_a_symmetric_orbit_is_a_fixed_point_of_half_a_period(omega):
    """Mirrored after half a period it is where it began; that map twice is that of a period."""
    zeta = 0.02
    system = trilinear(omega=omega, zeta=zeta)
    orbit = ns.find_orbit(system)
    half = system.period_value / 2
    run = ns.simulate(system, orbit, times=[0.0, half], tangent=True)
    for name in "xv":
        assert abs(float(run[name][1]) + float(orbit[name])) < 1e-10
    folded = -run["tangent"].values[-1]
    assert abs(np.linalg.det(folded) - np.exp(-2 * zeta * half)) < 1e-10
    squares = sorted(np.linalg.eigvals(folded) ** 2, key=lambda m: (m.real, m.imag))
    found = sorted(orbit["multipliers"].values, key=lambda m: (m.real, m.imag))
    assert np.abs(np.array(squares) - found).max() < 1e-8


@pytest.mark.parametrize("place", ["lower", "upper"])
def test_symmetry_breaks_where_half_a_period_has_the_multiplier_minus_one(place):
    """The orbit and its frequency by Newton's method in 60 digits."""
    kept = ORBITS["trilinear_points"][place]
    system = trilinear(omega=float(kept["value"]))
    start = {name: float(value) for name, value in zip("xv", kept["state"], strict=True)}
    half = system.period_value / 2
    run = ns.simulate(system, start, times=[0.0, half], tangent=True)
    for name, value in start.items():
        assert abs(float(run[name][1]) + value) < 1e-10
    multipliers = np.linalg.eigvals(-run["tangent"].values[-1])
    assert np.abs(multipliers + 1).min() < 1e-8
    assert abs(np.prod(multipliers) - np.exp(-2 * 0.02 * half)) < 1e-10


def names(run):
    return [run["event_to"].attrs["flag_meanings"].split()[int(m)] for m in run["event_to"]]


@pytest.mark.parametrize("omega", [0.6, 1.5])
def test_areas_shrink_with_the_damping_alone(omega):
    zeta = 0.02
    run = ns.simulate(
        trilinear(omega=omega, zeta=zeta), periods=6, samples_per_period=1, tangent=True
    )
    assert run.attrs["n_events"] > 12
    for time, tangent in zip(run["time"].values, run["tangent"].values, strict=True):
        exact = np.exp(-2 * zeta * time)
        # the determinant is a difference of products of entries, each off by some roundings
        assert abs(np.linalg.det(tangent) - exact) < 200 * EPS * np.abs(tangent).max() ** 2


@pytest.mark.parametrize(
    ("argument", "value"), [("omega", 0.0), ("zeta", -0.1), ("kappa", -1.0), ("delta", -0.1)]
)
def test_impossible_parameters_are_refused(argument, value):
    with pytest.raises(ns.ModelError, match=f"{argument} >"):
        trilinear(**{argument: value})
