"""Multipliers against the tangent of a run, closed forms, and products in 60 digits."""

import mpmath
import numpy as np
import pytest
from scipy.integrate import simpson

import nonsmooth as ns
from nonsmooth.periodic_orbits.multipliers import _eigenvalues
from periodic_orbits.kinds import KINDS, is_among, relay, van_der_pol


@pytest.mark.parametrize(
    "kind", [kind for kind, (system, _, _) in KINDS.items() if system.period is not None]
)
def test_of_driven_systems_against_the_tangent_of_a_run(kind):
    """A drift adds a multiplier one to those of the tangent; what is left out is zero."""
    system, options, _ = KINDS[kind]
    orbit = ns.find_orbit(system, **options)
    start = {name: float(orbit[name]) for name in system.states}
    step = ns.simulate(system, start, periods=1, tangent=[])["tangent"].values[-1]
    whole = np.linalg.eigvals(step)
    found = orbit["multipliers"].values
    assert found.size == len(system.states) - len(system.drift_states)
    for value in found:
        assert is_among(value, whole, 1e-8), (value, whole)
    if system.drift_states:
        assert is_among(1.0, whole, 1e-8)
    if np.isfinite(orbit["log_determinant"]):
        assert float(orbit["log_determinant"]) == pytest.approx(
            np.linalg.slogdet(step)[1], abs=1e-8
        )


def test_of_the_free_oscillator_in_closed_form():
    omega, zeta = 0.8, 0.01
    orbit = ns.find_orbit(ns.models.soft_impact(omega=omega, zeta=zeta, a=0.3))
    T = 2 * np.pi / omega
    expected = np.exp(-zeta * T) * np.exp(1j * np.sqrt(1 - zeta**2) * T)
    for value in (expected, np.conj(expected)):
        assert is_among(value, orbit["multipliers"].values, 1e-13)
    assert float(orbit["log_determinant"]) == pytest.approx(-2 * zeta * T, rel=1e-12)


@pytest.mark.parametrize("turns", [1, 3])
def test_turns_multiply(turns):
    """An orbit passed three times has the cubes."""
    system, options, _ = KINDS["trilinear"]
    once = ns.find_orbit(system, **options)["multipliers"].values
    orbit = ns.find_orbit(system, period=turns, **options)
    assert int(orbit["primitive_parts"]) == turns
    for value in once**turns:
        assert is_among(value, orbit["multipliers"].values, 1e-10)


def test_of_a_smooth_cycle_by_its_divergence():
    """Liouville: the multiplier that is left is the exponential of the integrated divergence."""
    orbit = ns.find_orbit(van_der_pol())
    (value,) = orbit["multipliers"].values
    times = np.linspace(0.0, float(orbit["length"]), 2001)
    x = ns.simulate(van_der_pol(), {"x": orbit["x"].item(), "v": orbit["v"].item()}, times=times)
    mean = simpson(1.0 - x["x"].values ** 2, x=times)
    assert value == pytest.approx(np.exp(mean), rel=1e-8)


def test_of_a_relay_by_its_return_map():
    """From one switch to the next x is fixed: the slope of the return map of v is all there is."""
    orbit = ns.find_orbit(relay(), **KINDS["relay"][1])
    section = ns.PoincareMap(relay(), "top", side="after")
    found = ns.return_map(section, "v", (0.05, 3.0), completion={"x": "h"}, mode="pull", samples=9)
    (slope,) = found["fixed_slope"].values
    assert complex(orbit["multipliers"].item()) == pytest.approx(slope, abs=1e-9)


def test_speed_changes_no_multiplier_of_a_cycle():
    slow = ns.find_orbit(van_der_pol())
    fast = ns.find_orbit(van_der_pol(1000.0), {"x": 2.0}, transient=1)
    assert float(fast["length"]) * 1000.0 == pytest.approx(float(slow["length"]), rel=1e-10)
    assert complex(fast["multipliers"].values[0]) == pytest.approx(
        complex(slow["multipliers"].values[0]), rel=1e-8
    )


def test_a_cycle_of_two_turns_has_squares():
    once = ns.find_orbit(relay(), {"x": 0.1, "v": 0.5}, mode="push", transient=5)
    twice = ns.find_orbit(relay(), {"x": 0.1, "v": 0.5}, mode="push", transient=5, period=2)
    assert int(twice["primitive_parts"]) == 2
    assert complex(twice["multipliers"].values[0]) == pytest.approx(
        complex(once["multipliers"].values[0]) ** 2, rel=1e-9
    )


@pytest.mark.parametrize("count", [5, 60, 120])
def test_long_products_keep_small_multipliers(count):
    """Graded factors: formed as a product, all but the largest would be lost in rounding."""
    rng = np.random.default_rng(count)
    turned = [np.linalg.qr(rng.standard_normal((3, 3)))[0] for _ in range(count)]
    grades = np.diag([3.0, 0.5, 0.02])
    factors = np.array([turned[(k + 1) % count] @ grades @ turned[k].T for k in range(count)])
    # perturbed, so that the frame is not known beforehand
    factors = factors @ (np.eye(3) + 0.05 * rng.standard_normal((count, 3, 3)))
    with mpmath.workdps(60 + 3 * count):
        product = mpmath.eye(3)
        for factor in factors:
            product = mpmath.matrix(factor.tolist()) * product
        exact = sorted(mpmath.eig(product, left=False, right=False), key=lambda m: -abs(m))
        logs = [float(mpmath.log(abs(value))) for value in exact]
    found = _eigenvalues(np.ascontiguousarray(factors), np.ones(3, bool))
    found = found[np.argsort(-np.abs(found))]
    for value, log in zip(found, logs, strict=True):
        assert np.log(abs(value)) == pytest.approx(log, abs=1e-11 * count)


def test_only_free_states_count():
    assert _eigenvalues(np.full((1, 2, 2), 0.5), np.array([True, True])).size == 2
    (alone,) = _eigenvalues(np.diag([0.25, 3.0])[None], np.array([True, False]))
    assert alone == 0.25


def harvester(length, pace, volts):
    """A mass between two stops that drives a circuit; x, v, u in some units, one motion."""
    values = {"F": 0.6, "omega": 0.97, "X": length, "W": pace, "U": volts}
    flow = {
        "x": "v",
        "v": "X*W**2*F*cos(omega*W*t) - 0.06*W*v - W**2*x - 0.2*X*W**2*u/U",
        "u": "0.5*U/X*v - 0.3*W*u",
    }
    stops = [ns.Exit(f"X {sign} x", reset={"v": "-0.7*v"}) for sign in "-+"]
    return ns.System(
        states=["x", "v", "u"], parameters=values, period="2*pi/(omega*W)",
        modes={"free": ns.Mode(flow, exits=stops)},
    )  # fmt: skip


@pytest.mark.parametrize("units", [(1e-5, 3e5, 100.0), (2e-7, 3e6, 1e3), (1e3, 1e-3, 1e-6)])
def test_multipliers_do_not_depend_on_units(units):
    """Metres beside volts: no event wipes out a direction that is only small in its unit."""
    length, _, volts = units
    starts = {"x": 0.3, "v": 0.1, "u": 0.0}
    plain = ns.find_orbit(harvester(1.0, 1.0, 1.0), starts, transient=300)
    start = {"x": 0.3 * length, "v": 0.1 * length * units[1], "u": 0.0 * volts}
    other = ns.find_orbit(harvester(*units), start, transient=300)
    assert np.abs(plain["multipliers"].values).min() > 0.1
    np.testing.assert_allclose(other["multipliers"].values, plain["multipliers"].values, rtol=1e-12)


@pytest.mark.few(1)
@pytest.mark.parametrize("direction", ["down", "both"])
@pytest.mark.parametrize(("sign", "w"), [("+", 0.85), ("-", 1.5)])
def test_of_a_system_at_rest_on_a_surface(sign, w, direction):
    """A ship with quadratic damping p*abs(p), unforced: exp(-d T/2) at an angle of w T."""
    ship = ns.System(
        states=["q", "p"],
        parameters={"d": 0.05, "e": 0.2, "F": 0.01},
        period=f"2*pi/{w}",
        equations={"q": "p", "p": f"-q {sign} q**3 - d*p - e*p*abs(p) + F*cos({w}*t)"},
    )
    branch = ns.continue_orbit(ship, "F", (0.0, 0.02), direction=direction)
    assert branch["F"][0] == 0.0 and branch.attrs["end_first"] == "bound"
    expected = np.exp((-0.025 + 1j * np.sqrt(1.0 - 0.025**2)) * 2.0 * np.pi / w)
    found = branch["multipliers"].values[0]
    assert sorted(found, key=np.imag) == pytest.approx(
        sorted([expected, expected.conj()], key=np.imag), abs=1e-12
    )
