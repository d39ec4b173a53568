"""Period doubling at a rigid wall, where closed forms put it."""

import mpmath
import numpy as np
import pytest

import nonsmooth as ns
from analysis.rigid_orbits import one_impact_orbit
from analysis.walls import rigid_wall

AWAY = 1e-3  # in omega on either side; the multiplier is then 1 % from -1
TRANSIENT = 6_000  # periods, in which a hundredth per period becomes nothing


def flip(near, **values):
    """Frequency at which a multiplier of the orbit is -1."""
    return mpmath.findroot(lambda w: one_impact_orbit(w, **values).flip, near)


@pytest.mark.parametrize("omega", [1.7, 2.3, 2.65, 3.1])
def test_the_closed_form_beside_a_formula_for_no_damping(omega):
    """At sigma = zeta = 0 the trace is -2 r cos T + (1 + r)^2 (1 - omega^2) (1 + cos T)/2."""
    orbit = one_impact_orbit(omega, zeta=0, sigma=0, r=0.8)
    c = np.cos(2 * np.pi / omega)
    trace = -1.6 * c + 1.8**2 * (1 - omega**2) * (1 + c) / 2
    assert float(orbit.trace) == pytest.approx(trace, abs=1e-12)
    assert float(orbit.determinant) == pytest.approx(0.64, abs=1e-12)


@pytest.mark.parametrize(
    ("near", "periods", "values"),
    [
        (2.65, 1, {"zeta": 0.0, "sigma": 0.0, "r": 0.8}),
        (2.66, 1, {"zeta": 0.02, "sigma": 0.0, "r": 0.8}),
        (2.45, 1, {"zeta": 0.02, "sigma": 0.1, "r": 0.8}),
        (2.26, 1, {"zeta": 0.05, "sigma": 0.2, "r": 0.7}),
        (4.64, 2, {"zeta": 0.02, "sigma": 0.0, "r": 0.8}),
    ],
)
def test_period_doubling(near, periods, values):
    omega = float(flip(near, periods=periods, **values))
    assert omega == pytest.approx(near, abs=0.03)
    system = rigid_wall(**values)
    settled = {"transient": TRANSIENT, "record": 40}
    for grid, found in ((omega - AWAY, periods), (omega + AWAY, 2 * periods)):
        orbit = one_impact_orbit(grid, periods=periods, **values)
        away = {"x": orbit.start["x"] - 1e-4, "v": orbit.start["v"]}
        column = ns.bifurcation_diagram(system, "omega", [grid], initial=away, **settled)
        assert column["status"].item() == "completed"
        assert column["period"].item() == found
        assert column["impacts"].item() == pytest.approx(1 / periods)
        if found == periods:
            strobes = column["x"].values[..., ::periods]
            assert strobes == pytest.approx(orbit.start["x"], abs=1e-9)
            hits = ns.bifurcation_diagram(
                system, "omega", [grid], initial=away, at="impact", side="before", **settled
            )
            assert hits["v"].values == pytest.approx(orbit.speed, abs=1e-9)


def test_the_determinant_of_the_orbit_is_the_sum_of_exponents():
    """Their product, in closed form, beside the sum of the exponents."""
    values = {"zeta": 0.02, "sigma": 0.1, "r": 0.8}
    orbit = one_impact_orbit(2.3, **values)
    spectrum = ns.lyapunov_spectrum(
        rigid_wall(omega=2.3, **values), orbit.start, transient=0, record=200
    )
    rate = float(mpmath.log(orbit.determinant)) * 2.3 / (2 * np.pi)
    assert float(spectrum["exponent_sum"]) == pytest.approx(rate, abs=1e-9)
