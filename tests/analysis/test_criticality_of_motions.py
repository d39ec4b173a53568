"""What normal forms of machines say, beside integrations by scipy and orbits that are found."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.integrate import solve_ivp

import nonsmooth as ns
from periodic_orbits.references.doubling import flip
from periodic_orbits.references.oscillators import SoftImpact
from periodic_orbits.systems import ORBITS

SOFT = {"omega": "0.85", "zeta": "0.01", "beta": "29", "e": "1.26"}

DUFFING = {"delta": 0.2, "gamma": 0.2, "omega": 1.2}
PERIOD = 2 * np.pi / DUFFING["omega"]


@pytest.fixture(scope="module")
def duffing():
    system = ns.System(
        states=["x", "v"],
        equations={"x": "v", "v": "-delta*v + x - x**3 + gamma*cos(omega*t)"},
        parameters=DUFFING,
        period="2*pi/omega",
    )
    branch = ns.continue_orbit(system, "gamma", (0.05, 0.5), initial={"x": 1.0, "v": 0.0})
    return branch, ns.criticality(branch)


def strobe(state, gamma):
    """Image of a state after one period, by an explicit method of order eight."""

    def rates(t, y):
        force = gamma * np.cos(DUFFING["omega"] * t)
        return [y[1], -DUFFING["delta"] * y[1] + y[0] - y[0] ** 3 + force]

    run = solve_ivp(rates, (0.0, PERIOD), state, method="DOP853", rtol=1e-13, atol=1e-14)
    return run.y[:, -1]


# central differences on nine points, of order eight for the first and second derivative and of
# order six for the third
PLACES = np.arange(-4, 5)
FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
THIRD = np.array([-7, 72, -338, 488, 0, -488, 338, -72, 7]) / 240
# the integration is good to some 1e-12, which the third derivative divides by H^3; derivatives grow
# by some ten from order to order, so that truncation is less than that
H = 0.01


def derivative(weights, order, state, gamma, direction):
    images = [strobe(state + k * H * direction, gamma) for k in PLACES]
    return weights @ np.array(images) / H**order


def matrix(state, gamma):
    return np.column_stack([derivative(FIRST, 1, state, gamma, e) for e in np.eye(2)])


def eigenvectors(jacobian, target):
    values, right = np.linalg.eig(jacobian)
    q = right[:, np.argmin(np.abs(values - target))].real
    values, left = np.linalg.eig(jacobian.T)
    p = left[:, np.argmin(np.abs(values - target))].real
    return q, p / (p @ q)


def special_of(branch, found, k):
    """State and parameter of the k-th point of the result."""
    point = branch.isel(point=int(branch["special_point"][int(found["special"][k])]))
    name = branch.attrs["parameter"]
    return np.array([float(point["x"]), float(point["v"])]), float(point[name])


def test_folds_of_duffing_by_differences_of_dop853(duffing):
    branch, found = duffing
    folds = np.flatnonzero(found["special_kind"].values == "fold")
    assert folds.size == 2
    for k in folds:
        state, gamma = special_of(branch, found, k)
        q, p = eigenvectors(matrix(state, gamma), 1.0)
        a = p @ derivative(SECOND, 2, state, gamma, q) / 2
        images = [strobe(state, gamma + j * H) for j in PLACES]
        b = p @ (FIRST @ np.array(images)) / H
        assert abs(float(found["coefficient"][k])) == pytest.approx(abs(a), rel=1e-6)
        product = float(found["coefficient"][k] * found["parameter_coefficient"][k])
        assert product == pytest.approx(a * b, rel=1e-6)
        assert found["side"].values[k] == ("above" if a * b < 0 else "below")
        assert found["criticality"].values[k] == "nondegenerate"


def test_flip_of_duffing_by_differences_of_dop853(duffing):
    branch, found = duffing
    k = found["special_kind"].values.tolist().index("flip")
    state, gamma = special_of(branch, found, k)
    jacobian = matrix(state, gamma)
    q, p = eigenvectors(jacobian, -1.0)
    square = derivative(SECOND, 2, state, gamma, q)
    shift = np.linalg.solve(np.eye(2) - jacobian, square)
    mixed = (
        derivative(SECOND, 2, state, gamma, q + shift)
        - derivative(SECOND, 2, state, gamma, q - shift)
    ) / 4
    c = p @ (derivative(THIRD, 3, state, gamma, q) + 3 * mixed) / 6
    assert float(found["coefficient"][k]) == pytest.approx(c, rel=1e-4)
    assert found["criticality"].values[k] == ("supercritical" if c > 0 else "subcritical")


MACHINES = {
    "mole": (ns.models.moling(), "b", (0.1, 0.2)),
    "soft impact": (ns.models.soft_impact(a=0.4), "a", (0.3, 0.9)),
    # a state that is wiped out on the way, as 1e-200 in the derivative of the return map
    "fatigue rig": (ns.models.fatigue_rig(), "f1", (3.0, 4.6)),
}


@pytest.fixture(scope="module", params=MACHINES)
def machine(request):
    system, parameter, between = MACHINES[request.param]
    branch = ns.continue_orbit(system, parameter, between)
    return system, branch, ns.criticality(branch)


def orbits_beside(system, branch, found, k, beyond, **options):
    """Orbits from either side along the eigenvector, at a distance of the parameter.

    With the deviation of each from the orbit of the special point.
    """
    name = branch.attrs["parameter"]
    value = float(found["special_value"][k])
    point = branch.isel(point=int(branch["special_point"][int(found["special"][k])]))
    states = [str(state) for state in found["state"].values]
    middle = np.array([float(point[state]) for state in states])
    q = found["eigenvector"].values[k].real
    away = float(found["amplitude_factor"][k]) * np.sqrt(beyond)
    sign = 1.0 if found["side"].values[k] == "above" else -1.0
    orbits, deviations = [], []
    for way in (1.0, -1.0):
        start = dict(zip(states, middle + way * away * q, strict=True))
        orbit = ns.find_orbit(
            system, start, parameters={name: value + sign * beyond}, transient=0, **options
        )
        orbits.append(orbit)
        deviations.append(np.array([float(orbit[state]) for state in states]) - middle)
    moving = np.abs(q) > 0.0
    return orbits, [each[moving] for each in deviations], q[moving], away


@pytest.mark.slow
def test_supercritical_flips_have_stable_doubled_orbits_of_the_amplitude(machine):
    """The half difference of the two points of the doubled orbit, to the order of the distance."""
    system, branch, found = machine
    flips = np.flatnonzero(found["special_kind"].values == "flip")
    assert flips.size
    for k in flips:
        assert found["criticality"].values[k] == "supercritical"
        # a hundredth of the part of the parameter for which the itinerary is known, at most 1e-7
        within = (float(found["reach"][k]) / float(found["amplitude_factor"][k])) ** 2
        beyond = 0.01 * min(within, 1e-5)
        (one, _), deviations, q, away = orbits_beside(system, branch, found, k, beyond, period=2)
        assert one.attrs["status"] == "completed"
        assert int(one["primitive_parts"]) == 1
        assert bool(one["stable"]) == (int(found["unstable_directions"][k]) == 0)
        half = (deviations[0] - deviations[1]) / 2
        assert half == pytest.approx(away * q, abs=0.05 * away)
        # near the flip the multiplier of the doubled orbit is 1 + 4 rate * distance
        values = one["multipliers"].values
        multiplier = values[np.argmin(np.abs(values - 1.0))].real
        slope = -4.0 * abs(float(found["parameter_coefficient"][k])) * beyond
        assert multiplier - 1.0 == pytest.approx(slope, rel=0.2)


@pytest.mark.slow
def test_the_flip_of_the_mole_has_the_curvature_of_its_reference():
    """Doubled orbits lie at value + curvature * amplitude^2, in 25 digits for an amplitude of 1e-4.

    It is small beside the orbit, so all six digits that are kept of the curvature stand.
    """
    kept = ORBITS["mole_points"]["flip_1"]
    found = ns.criticality(ns.continue_orbit(*MACHINES["mole"]), "flip").isel(special=0)
    assert float(found["special_value"]) == pytest.approx(float(kept["value"]), rel=1e-12)
    curvature = float(kept["curvature"])
    made = 1.0 / float(found["amplitude_factor"]) ** 2
    assert made == pytest.approx(abs(curvature), rel=2e-6)
    assert found["side"].item() == ("above" if curvature > 0 else "below")
    assert (found["criticality"].item() == "supercritical") == kept["supercritical"]


@pytest.mark.slow
def test_the_flip_of_the_soft_impact_oscillator_has_the_curvature_of_two_amplitudes():
    """It lies close to a graze, so the curvature of the reference is extrapolated to none."""
    kept = ORBITS["soft_points"]["flip"]
    near = mpf(kept["value"]) * (1 - mpf(10) ** -9)
    curvatures = []
    with mp.workdps(60):
        for amplitude in (mpf(10) ** -5, mpf(10) ** -6):
            found = flip(
                lambda a: SoftImpact(**SOFT, a=a).course("free contact free"),
                (near, near + mpf(10) ** -7), (kept["free"], kept["durations"]), amplitude,
            )  # fmt: skip
            curvatures.append(found.curvature)
        exact = float((100 * curvatures[1] - curvatures[0]) / 99)
    told = ns.criticality(ns.continue_orbit(*MACHINES["soft impact"]), "flip").isel(special=0)
    # twice the relative errors of coefficient and rate, and eight digits of the location so close
    assert 1.0 / float(told["amplitude_factor"]) ** 2 == pytest.approx(exact, rel=2e-8)
    assert told["side"].item() == "above"


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["lower", "upper"])
def test_symmetry_breaking_of_a_trilinear_oscillator(name):
    """The branch of unsymmetric orbits leaves on that side, and by the root of the distance."""
    branch = ns.continue_orbit(ns.models.trilinear(omega=1.1), "omega", (0.7, 1.2))
    found = ns.criticality(branch, "symmetry_breaking")
    value = float(ORBITS["trilinear_points"][name]["value"])
    k = int(np.argmin(np.abs(found["special_value"].values - value)))
    assert float(found["special_value"][k]) == pytest.approx(value, rel=1e-9)
    number = int(found["special"][k])
    other = ns.continue_orbit(
        ns.models.trilinear(), "omega", (0.7, 1.2), initial=branch, special=number, step=1e-3,
        largest_step=1e-3, steps=4, direction="up",
    )  # fmt: skip
    middle = branch.isel(point=int(branch["special_point"][number]))
    distances = other["omega"].values - float(middle["omega"])
    moved = np.abs(distances) > 1e-9
    assert np.count_nonzero(moved) >= 2
    assert np.all((distances[moved] > 0.0) == (found["side"].values[k] == "above"))
    assert np.all(other["stable"].values[moved])
    assert found["criticality"].values[k] == "supercritical"
    q = found["eigenvector"].values[k].real
    away = np.column_stack([other[s].values - float(middle[s]) for s in ("x", "v")]) @ q
    factor = np.abs(away[moved]) / np.sqrt(np.abs(distances[moved]))
    # the next term along the branch is by the amplitude smaller
    assert factor[0] == pytest.approx(float(found["amplitude_factor"][k]), rel=0.03)


def test_on_the_other_side_of_a_flip_there_is_no_doubled_orbit(machine):
    system, branch, found = machine
    k = int(np.flatnonzero(found["special_kind"].values == "flip")[0])
    other = found.copy(deep=True)
    swapped = {"above": "below", "below": "above"}[str(found["side"].values[k])]
    other["side"].values[k] = swapped
    within = (float(found["reach"][k]) / float(found["amplitude_factor"][k])) ** 2
    beyond = 0.01 * min(within, 1e-5)
    orbits, *_ = orbits_beside(system, branch, other, k, beyond, period=2)
    assert all(
        orbit.attrs["status"] != "completed" or int(orbit["primitive_parts"]) == 2
        for orbit in orbits
    )


def test_a_pitchfork_of_cycles_without_events():
    """z' = mu z - z^3 beside a cycle of time 2 pi: z becomes z/sqrt(1 + 4 pi z^2) at mu = 0."""
    system = ns.System(
        states=["x", "y", "z"],
        equations={
            "x": "x*(1 - x**2 - y**2) - y",
            "y": "y*(1 - x**2 - y**2) + x",
            "z": "mu*z - z**3",
        },
        parameters={"mu": -0.1},
    )
    branch = ns.continue_orbit(system, "mu", (-0.2, 0.2), initial={"x": 1.0, "y": 0.0, "z": 0.0})
    found = ns.criticality(branch)
    assert found["criticality"].item() == "supercritical"
    for name, exact in (("coefficient", -2 * np.pi), ("parameter_coefficient", 2 * np.pi)):
        assert abs(found[name].item() - exact) <= found[f"{name}_error"].item() <= 1e-8
    assert np.abs(found["eigenvector"].values[0]) == pytest.approx([0.0, 0.0, 1.0], abs=1e-9)
    assert found["amplitude_factor"].item() == pytest.approx(1.0, rel=1e-9)


@pytest.mark.slow
def test_folds_of_the_mole_have_two_orbits_of_the_distance():
    system, parameter, between = MACHINES["mole"]
    branch = ns.continue_orbit(system, parameter, between)
    found = ns.criticality(branch, "fold")
    assert found.sizes["special"] == 2
    for k in range(2):
        within = (float(found["reach"][k]) / float(found["amplitude_factor"][k])) ** 2
        beyond = 0.01 * min(within, 1e-5)
        orbits, deviations, q, away = orbits_beside(system, branch, found, k, beyond)
        assert [orbit.attrs["status"] for orbit in orbits] == ["completed"] * 2
        assert sorted(bool(orbit["stable"]) for orbit in orbits) == [False, True]
        half = (deviations[0] - deviations[1]) / 2
        assert half == pytest.approx(away * q, abs=0.05 * away)
