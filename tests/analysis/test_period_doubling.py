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


def specials(branch, kind: str) -> list[float]:
    return branch["special_value"].values[branch["special_kind"].values == kind].tolist()


@pytest.mark.slow
def test_a_doubled_branch_ends_where_it_comes_to_a_shorter_orbit_at_a_graze():
    """Beyond, its orbits would be those of period one passed twice, whose branch has that graze."""
    stops = ns.System(
        states=["x", "v"],
        period="2*pi/w",
        parameters={"w": 1.35},
        modes={
            "free": ns.Mode(
                {"x": "v", "v": "0.9*cos(w*t) - 0.12*v - x - 0.3*x**3"},
                exits=[
                    ns.Exit("0.9 - x", reset={"v": "-0.7*v"}, name="right"),
                    ns.Exit("x + 1.4", reset={"v": "-0.7*v"}, name="left"),
                ],
            )
        },
    )
    one = ns.continue_orbit(stops, "w", (0.6, 2.8), initial=ns.find_orbit(stops))
    flip = max(range(one.sizes["special"]), key=lambda k: one["special_kind"].values[k] == "flip"
               and one["special_value"].values[k])  # fmt: skip
    two = ns.continue_orbit(stops, "w", (0.6, 2.8), initial=one, special=flip)
    assert two.attrs["end_last"] == "halving"
    assert "a shorter period, passed more than once" in two.attrs["message"]
    graze = specials(two, "grazing")[-1]
    assert min(abs(graze - value) for value in specials(one, "grazing")) < 1e-7
    # but for the ends, where it meets that branch, no orbit comes back after one period
    for k in range(1, two.sizes["point"] - 1):
        point = two.isel(point=k)
        run = ns.simulate(stops, point, periods=1, parameters={"w": float(point["w"])})
        assert np.abs(run["end_state"].values - point[["x", "v"]].to_array().values).max() > 1e-5


@pytest.mark.slow
def test_a_doubled_branch_is_halved_where_it_turns_back():
    """It ends at a flip of the orbit that it doubles, which is no fold, and is not passed twice."""
    gear = ns.System(
        states=["q", "w"],
        period="60/rpm",
        parameters={"rpm": 8000.0},
        equations={
            "q": "w",
            "w": "(6 + 14*cos(2*pi*rpm/60*t) - 0.9*w - 2e4*(q - clip(q, -2e-3, 2e-3)))/0.012",
        },
    )
    one = ns.continue_orbit(gear, "rpm", (2000, 14000))
    flips = specials(one, "flip")
    flip = one["special_value"].values.tolist().index(min(flips, key=lambda v: abs(v - 3159.869)))
    two = ns.continue_orbit(gear, "rpm", (2000, 14000), initial=one, special=flip, steps=400)
    assert two.attrs["end_last"] == "halving"
    (halving,) = specials(two, "halving")
    assert min(abs(halving - value) for value in flips) < 1e-6
    values = np.round(two["special_value"].values, 5).tolist()
    assert len(values) == len(set(values))
