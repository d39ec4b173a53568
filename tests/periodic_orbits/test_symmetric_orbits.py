"""Symmetric orbits, their images and where they lose their symmetry, by routes of their own.

Closed forms of an oscillator between two rigid walls; half-period maps integrated by DOP853.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve

import nonsmooth as ns
from nonsmooth import Exit, Mode, OptionError, System
from nonsmooth.periodic_orbits.equations import OrbitEquations
from nonsmooth.periodic_orbits.legs import Legs
from nonsmooth.periodic_orbits.symmetric import _carried, half_turn_later
from nonsmooth.periodic_orbits.word import Word

ODD = {"x": "-x", "v": "-v"}
R, GAP = 0.8, 0.2


def between_walls(omega, **words):
    """x'' + x = cos(omega t) between walls at x = -GAP and GAP with restitution R."""
    exits = [
        Exit("gap - x", reset={"v": "-r*v"}, name="right"),
        Exit("x + gap", reset={"v": "-r*v"}, name="left"),
    ]
    given = {"symmetry": ODD} | words
    return System(
        states=["x", "v"],
        period="2*pi/omega",
        parameters={"omega": omega, "r": R, "gap": GAP},
        modes={"free": Mode({"x": "v", "v": "cos(omega*t) - x"}, exits=exits)},
        **given,
    )


class ClosedForm:
    """The orbit that hits each wall once per period, in closed form.

    It leaves the left wall with the speed V at forcing phase phi and comes to the right one half a
    period h later: x = A cos t + B sin t + C cos(omega t + phi). Four conditions at both ends give
    B = -A k with k = cot(h/2), V = -2 A k r/(1 + r), C cos phi = -gap - A and
    C omega sin phi = -A k (1 - r)/(1 + r), so A solves a quadratic equation.
    """

    def __init__(self, omega):
        self.omega, self.half = omega, np.pi / omega
        self.C, self.k = 1.0 / (1.0 - omega**2), 1.0 / np.tan(0.5 * self.half)
        tilt = self.k * (1.0 - R) / (1.0 + R)
        # the larger root leaves the left wall the wrong way where omega is above 1
        self.A = min(np.roots([1.0 + (tilt / omega) ** 2, 2.0 * GAP, GAP**2 - self.C**2]).real)
        self.V = -2.0 * self.A * self.k * R / (1.0 + R)
        cosine, sine = (-GAP - self.A) / self.C, -self.A * tilt / (self.C * omega)
        self.phi = np.arctan2(sine, cosine)
        self.pull = -GAP - cosine  # acceleration at the right wall

    def at_phase_zero(self):
        """State where the force is largest, which is where a turn begins."""
        t, sign = (-self.phi) % (2.0 * np.pi) / self.omega, 1.0
        if t > self.half:
            t, sign = t - self.half, -1.0
        angle, B = self.omega * t + self.phi, -self.A * self.k
        x = self.A * np.cos(t) + B * np.sin(t) + self.C * np.cos(angle)
        v = -self.A * np.sin(t) + B * np.cos(t) - self.C * self.omega * np.sin(angle)
        return sign * x, sign * v

    def trace(self):
        """Trace of half a turn followed by the symmetry; its determinant is R**2."""
        saltation = -(1.0 + R) * self.pull / (self.V / R)
        return 2.0 * R * np.cos(self.half) + saltation * np.sin(self.half)

    def multipliers(self):
        """Multipliers of that map."""
        return np.sort_complex(np.roots([1.0, -self.trace(), R**2]).astype(complex))

    def broken(self):
        """Zero where one of them is -1."""
        return 1.0 + self.trace() + R**2


@pytest.mark.parametrize("omega", [2.45, 2.5, 2.7, 2.8, 3.1])
def test_the_orbit_between_two_walls(omega):
    truth = ClosedForm(omega)
    x, v = truth.at_phase_zero()
    orbit = ns.find_orbit(between_walls(omega), {"x": x + 1e-4, "v": v - 1e-4})
    assert orbit["admissible"].item()
    assert orbit["symmetric"].item()
    # Newton's method leaves some units of rounding, beside numbers of order one
    assert float(orbit["x"]) == pytest.approx(x, abs=1e-13)
    assert float(orbit["v"]) == pytest.approx(v, abs=1e-13)
    half = np.sort_complex(orbit["half_multipliers"].values)
    np.testing.assert_allclose(half, truth.multipliers(), rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        np.sort_complex(half**2), np.sort_complex(orbit["multipliers"].values), rtol=0, atol=1e-12
    )


@pytest.mark.parametrize("late", [0.0, 1e-16, -1e-16, 3e-15, -3e-15, 1e-13, -1e-13])
@pytest.mark.parametrize("period", [1, 2, 3])
def test_the_orbit_between_two_walls_with_an_impact_at_the_section(late, period):
    """Rounding decides on which side of the impact the section lies, and of its image at half."""
    omega = 2.8
    truth = ClosedForm(omega)
    phase = truth.phi / (2.0 * np.pi) % 1.0 + late
    start = dict(zip("xv", truth.at_phase_zero(), strict=True))
    orbit = ns.find_orbit(between_walls(omega), start, phase=phase, period=period)
    assert orbit["symmetric"].item()
    np.testing.assert_allclose(np.abs(orbit["x"].item()), GAP, rtol=0, atol=1e-12)
    # each strobe is on the same side of its impact
    strobes = orbit["strobes"].values
    np.testing.assert_allclose(strobes - strobes[:1], 0.0, rtol=0, atol=1e-12)
    if period == 1:
        half = np.sort_complex(orbit["half_multipliers"].values)
        np.testing.assert_allclose(half, truth.multipliers(), rtol=0, atol=1e-11)


def test_the_pitchfork_between_two_walls():
    """The branch finds it where the closed form has the multiplier -1, and two orbits leave it."""
    truth = brentq(lambda omega: ClosedForm(omega).broken(), 2.55, 2.65, xtol=1e-15)
    x, v = ClosedForm(2.8).at_phase_zero()
    system = between_walls(2.8)
    branch = ns.continue_orbit(system, "omega", (2.5, 2.9), initial={"x": x, "v": v})
    kinds = branch["special_kind"].values.tolist()
    assert [kind for kind in kinds if kind != "bound"] == ["symmetry_breaking"]
    which = kinds.index("symmetry_breaking")
    assert float(branch["special_value"][which]) == pytest.approx(truth, abs=1e-11)
    at = branch.isel(point=int(branch["special_point"][which]))
    assert np.min(np.abs(at["half_multipliers"].values + 1.0)) < 1e-9
    assert branch["symmetric"].values.all()
    other = ns.continue_orbit(system, "omega", (2.5, 2.9), initial=branch, special=which, steps=6)
    symmetric = other["symmetric"].values
    begin = int(np.argmin(np.abs(other["arclength"].values)))
    assert symmetric[begin]
    assert not np.delete(symmetric, begin).any()


def test_images_of_the_orbits_that_leave_the_pitchfork():
    """The image of an orbit is minus its state half a period later; its image is the orbit."""
    x, v = ClosedForm(2.8).at_phase_zero()
    system = between_walls(2.8)
    branch = ns.continue_orbit(system, "omega", (2.5, 2.9), initial={"x": x, "v": v})
    which = branch["special_kind"].values.tolist().index("symmetry_breaking")
    other = ns.continue_orbit(system, "omega", (2.5, 2.9), initial=branch, special=which, steps=6)
    orbit = other.isel(point=0)
    image = ns.mirrored_orbit(orbit)
    assert image["admissible"].item()
    assert image.attrs["phase_of_period"] == orbit.attrs["phase_of_period"]
    again = ns.mirrored_orbit(image)
    for name in ("x", "v"):
        assert abs(float(image[name] - orbit[name])) > 1e-3
        assert float(again[name]) == pytest.approx(float(orbit[name]), abs=1e-12)
    omega = float(orbit["omega"])
    there = ns.simulate(between_walls(omega), orbit, t_end=np.pi / omega)
    assert float(image["x"]) == pytest.approx(-float(there["x"][-1]), abs=1e-12)


# ---------------------------------------------------------------- Duffing


DELTA, OMEGA = 0.2, 1.0


def duffing(gamma, **words):
    """A hardening spring of the library."""
    return ns.models.duffing(delta=DELTA, alpha=1.0, beta=1.0, omega=OMEGA, gamma=gamma, **words)


def flow(start, gamma, span, begin=0.0):
    """State and tangent after a time by DOP853, (2 + 4)."""

    def rates(t, y):
        x, v, tangent = y[0], y[1], y[2:].reshape(2, 2)
        force = gamma * np.cos(OMEGA * t) - DELTA * v - x - x**3
        matrix = np.array([[0.0, 1.0], [-1.0 - 3.0 * x**2, -DELTA]])
        return np.concatenate([[v, force], (matrix @ tangent).ravel()])

    begin_at = np.concatenate([start, np.eye(2).ravel()])
    run = solve_ivp(rates, (begin, begin + span), begin_at, method="DOP853", rtol=1e-13, atol=1e-14)
    return run.y[:2, -1], run.y[2:, -1].reshape(2, 2)


def test_the_pitchfork_of_duffing():
    """Where the fixed point of -flow(half a period) has the multiplier -1."""
    half = np.pi / OMEGA

    def conditions(unknowns):
        end, tangent = flow(unknowns[:2], unknowns[2], half)
        return [*(unknowns[:2] + end), np.linalg.det(-tangent + np.eye(2))]

    branch = ns.continue_orbit(duffing(1.0), "gamma", (0.9, 3.5))
    which = branch["special_kind"].values.tolist().index("symmetry_breaking")
    at = branch.isel(point=int(branch["special_point"][which]))
    guess = [round(float(at["x"]), 2), round(float(at["v"]), 2), round(float(at["gamma"]), 2)]
    truth = fsolve(conditions, guess, xtol=1e-13)
    assert float(at["gamma"]) == pytest.approx(truth[2], abs=1e-9)
    # where branches cross, orbits are found to half the digits
    assert float(at["x"]) == pytest.approx(truth[0], abs=1e-6)


@pytest.mark.slow
def test_folds_of_symmetric_orbits_are_folds():
    """Half a turn followed by the symmetry has the multiplier 1 there, and -1 at pitchforks."""
    branch = ns.continue_orbit(duffing(1.0), "gamma", (0.9, 30.0), largest_step=0.02)
    kinds = branch["special_kind"].values
    assert set(kinds) >= {"fold", "symmetry_breaking"}
    for kind, critical in (("fold", 1.0), ("symmetry_breaking", -1.0)):
        for k in branch["special_point"].values[kinds == kind]:
            half = branch["half_multipliers"].values[k]
            assert np.min(np.abs(half - critical)) < 1e-4
            assert np.min(np.abs(half + critical)) > 1e-2


def test_the_image_of_an_unsymmetric_orbit_of_duffing():
    """Minus the state half a period later, by another integrator."""
    well = ns.models.duffing(gamma=0.2)
    orbit = ns.find_orbit(well, {"x": 1.0})
    values = well.parameter_values

    def rates(t, y):
        force = values["gamma"] * np.cos(values["omega"] * t)
        return [y[1], force - values["delta"] * y[1] + y[0] - y[0] ** 3]

    begin = [float(orbit["x"]), float(orbit["v"])]
    run = solve_ivp(rates, (0, np.pi / 1.2), begin, method="DOP853", rtol=1e-12, atol=1e-13)
    for phase in (0.0, 0.3):
        orbit = ns.find_orbit(well, {"x": 1.0}, phase=phase)
        image = ns.mirrored_orbit(orbit)
        assert image["stable"].item()
        assert not image["symmetric"].item()
        assert image.attrs["phase_of_period"] == phase
        if phase == 0.0:
            np.testing.assert_allclose([image["x"], image["v"]], -run.y[:, -1], atol=1e-10)
        # multipliers of a motion and of its image are the same
        np.testing.assert_allclose(
            np.sort_complex(image["multipliers"].values),
            np.sort_complex(orbit["multipliers"].values), atol=1e-12,
        )  # fmt: skip


@pytest.mark.parametrize("period", [2, 3])
def test_turns_that_repeat_a_symmetric_orbit_are_symmetric(period):
    orbit = ns.find_orbit(duffing(1.0), {"x": 0.0}, period=period, transient=100)
    assert int(orbit["primitive_parts"]) == period
    assert orbit["symmetric"].item()


# ---------------------------------------------------------------- without a force, and swaps


def test_a_limit_cycle_is_its_own_image_half_a_turn_later():
    """The multiplier of van der Pol's cycle is the square of that of half a turn."""
    cycle = System(states=["x", "v"], equations={"x": "v", "v": "(1 - x**2)*v - x"}, symmetry=ODD)
    orbit = ns.find_orbit(cycle, {"x": 2.0})
    assert orbit["symmetric"].item()
    (half,) = orbit["half_multipliers"].values
    assert half**2 == pytest.approx(orbit["multipliers"].values[0], abs=1e-12)
    image = ns.mirrored_orbit(orbit)
    assert float(image["x"]) == pytest.approx(-float(orbit["x"]), abs=1e-9)


def test_the_pair_of_cycles_of_chuas_circuit():
    circuit = ns.models.chua(alpha=8.4)
    orbit = ns.find_orbit(circuit, {"x": 1.6, "y": 0.1, "z": -1.6}, transient=200)
    assert orbit["word"].item().startswith("inner right")
    assert not orbit["symmetric"].item()
    image = ns.mirrored_orbit(orbit)
    assert image["word"].item() == orbit["word"].item().replace("right", "left")
    assert float(image["length"]) == pytest.approx(float(orbit["length"]), rel=1e-12)
    np.testing.assert_allclose(image["leg_states"], -orbit["leg_states"], atol=1e-11)


def coupled(k):
    """Two equal hardening springs in one force, with a coupling that pushes them apart."""
    rate = "gamma*cos(t) - 0.2*{v} - {x} - {x}**3 - k*({x} - {other})"
    return System(
        states=["x", "v", "y", "w"],
        period="2*pi",
        parameters={"k": k, "gamma": 1.0},
        equations={
            "x": "v", "v": rate.format(x="x", v="v", other="y"),
            "y": "w", "w": rate.format(x="y", v="w", other="x"),
        },
        symmetry={"x": "y", "y": "x", "v": "w", "w": "v"},
    )  # fmt: skip


def test_two_springs_that_move_alike_lose_it_in_a_pitchfork():
    """Their difference obeys d'' + 0.2 d' + (1 + 3 x**2 + 2 k) d = 0 with the x of one of them.

    Its multiplier comes to 1 at some negative k; the orbit itself does not depend on k.
    """
    one = ns.find_orbit(duffing(1.0))
    begin = np.array([float(one["x"]), float(one["v"])])

    def apart(k):
        def rates(t, y):
            force = np.cos(t) - DELTA * y[1] - y[0] - y[0] ** 3
            matrix = np.array([[0.0, 1.0], [-1.0 - 3.0 * y[0] ** 2 - 2.0 * k, -DELTA]])
            return np.concatenate([[y[1], force], (matrix @ y[2:].reshape(2, 2)).ravel()])

        start = np.concatenate([begin, np.eye(2).ravel()])
        run = solve_ivp(rates, (0, 2 * np.pi), start, method="DOP853", rtol=1e-12, atol=1e-13)
        return np.linalg.det(run.y[2:, -1].reshape(2, 2) - np.eye(2))

    truth = brentq(apart, -1.5, -0.6, xtol=1e-12)
    start = dict(zip("xvyw", [*begin, *begin], strict=True))
    branch = ns.continue_orbit(coupled(-0.6), "k", (-1.5, -0.5), initial=start)
    kinds = branch["special_kind"].values.tolist()
    which = kinds.index("symmetry_breaking")
    assert float(branch["special_value"][which]) == pytest.approx(truth, abs=1e-8)
    assert branch["symmetric"].values.all()
    other = ns.continue_orbit(
        coupled(-0.6), "k", (-1.5, -0.5), initial=branch, special=which, steps=5
    )
    orbit = other.isel(point=0)
    image = ns.mirrored_orbit(orbit)
    for one_name, other_name in (("x", "y"), ("v", "w")):
        assert float(image[one_name]) == pytest.approx(float(orbit[other_name]), abs=1e-10)
        assert abs(float(orbit[one_name] - orbit[other_name])) > 1e-3


# ---------------------------------------------------------------- cells, friction, stops


def test_stick_and_slip_and_its_image():
    """Cells that slide are images of themselves, those beside them of each other."""
    block = ns.models.friction_oscillator(omega=0.4, f=0.5)
    orbit = ns.find_orbit(block, {"x": 0.0})
    assert "stick" in orbit["word"].item()
    assert orbit["symmetric"].item()
    image = ns.mirrored_orbit(orbit)
    assert image["admissible"].item()
    assert float(image["x"]) == pytest.approx(float(orbit["x"]), abs=1e-12)


@pytest.mark.parametrize("text", ["clip(8*x, -0.5, 0.5)", "0.5*tanh(2*x) + max(min(x, 1), -1)"])
def test_images_of_orbits_through_cells(text):
    """Motions in the wells of a bent spring, with cells that one side splits and the other not."""
    system = System(
        states=["x", "v"],
        period="2*pi",
        equations={"x": "v", "v": f"0.1*cos(t) - 0.3*v + x - x**3 + 0.1*({text})"},
        symmetry=ODD,
    )
    orbit = ns.find_orbit(system, {"x": 1.0}, transient=200)
    image = ns.mirrored_orbit(orbit)
    there = ns.find_orbit(system, {"x": -1.0}, transient=200)
    assert image["word"].item() == there["word"].item()
    for name in ("x", "v"):
        assert float(image[name]) == pytest.approx(float(there[name]), abs=1e-11)


def test_a_centre_that_moves_with_the_parameter():
    """The map x -> 2 c - x is that of each value of c along a branch."""
    system = System(
        states=["x", "v"],
        period="2*pi",
        parameters={"c": 0.5},
        equations={"x": "v", "v": "cos(t) - 0.2*v - (x - c) - (x - c)**3"},
        symmetry={"x": "2*c - x", "v": "-v"},
    )
    branch = ns.continue_orbit(system, "c", (0.4, 1.0), steps=5)
    assert branch["symmetric"].values.all()
    at = branch.isel(point=-1)
    assert float(at["c"]) > 0.55
    assert float(ns.mirrored_orbit(at)["x"]) == pytest.approx(float(at["x"]), abs=1e-11)


def test_what_has_no_image_is_refused():
    plain = ns.find_orbit(ns.models.soft_impact())
    assert "symmetric" not in plain
    with pytest.raises(OptionError, match="declares no symmetry"):
        ns.mirrored_orbit(plain)
    with pytest.raises(OptionError, match="give a result of find_orbit"):
        ns.mirrored_orbit(3)
    branch = ns.continue_orbit(duffing(1.0), "gamma", (0.9, 1.1), steps=3)
    with pytest.raises(OptionError, match="take one"):
        ns.mirrored_orbit(branch)


def test_an_event_without_a_rate_is_told_in_silence():
    """At a graze the derivative of an event is infinite; a product with it would warn."""
    flows = np.eye(2)[None].repeat(2, axis=0)
    events = np.array([[[np.inf, 0.0], [0.0, 1.0]], np.eye(2)])
    with np.errstate(all="raise"):
        assert np.all(np.isnan(_carried(flows, events)))
        np.testing.assert_array_equal(_carried(flows, events[[1, 1]]), np.eye(2))


def test_a_test_of_an_orbit_without_events_has_no_image():
    """Two cells alike at rest: nothing is half a turn later."""
    forced = System(
        states=["x", "v"], parameters={"F": 0.1}, period="2*pi", symmetry={"x": "-x", "v": "-v"},
        equations={"x": "v", "v": "F*cos(t) - 2*x - 0.1*v - x + clip(x, -1, 1)"},
    )  # fmt: skip
    equations = OrbitEquations(Legs(forced), Word((1,), ((),)), period=1)
    assert half_turn_later(equations, "graze:0:0") == ""
    assert half_turn_later(equations, "border:0:0") == ""


def stiff_stops() -> System:
    """A mass of 2 kg between two stops, contacts with which last a hundredth of a turn."""
    force = "-1e5*x - 30*v - 1e8*(x - clip(x, -1e-3, 1e-3)) + 150*cos(2*pi*f*t)"
    return System(
        states=["x", "v"], parameters={"f": 20.5}, period="1/f",
        symmetry={"x": "-x", "v": "-v"}, equations={"x": "v", "v": f"({force})/2"},
    )  # fmt: skip


@pytest.mark.slow
def test_a_symmetry_breaks_among_short_contacts():
    """Half a turn followed by x -> -x has a multiplier of -1 there."""
    stops = stiff_stops()
    branch = ns.continue_orbit(stops, "f", (17.5, 20.5), transient=300, direction="down")
    kinds = branch["special_kind"].values
    assert kinds.tolist() == ["bound", "symmetry_breaking", "symmetry_breaking"]
    at = branch.isel(point=branch["special_point"].values[1:])

    def half_turn(state, f):
        def field(t, y):
            beyond = y[0] - np.clip(y[0], -1e-3, 1e-3)
            force = 150.0 * np.cos(2.0 * np.pi * f * t)
            return [y[1], (-1e5 * y[0] - 30.0 * y[1] - 1e8 * beyond + force) / 2.0]

        found = solve_ivp(
            field, (0.0, 0.5 / f), state, method="DOP853", rtol=1e-11, atol=1e-14, max_step=2e-5
        )
        return -found.y[:, -1]

    for k in range(2):
        f, state = float(at["f"][k]), np.array([float(at["x"][k]), float(at["v"][k])])
        assert half_turn(state, f) == pytest.approx(state, abs=1e-8)
        steps = np.diag([1e-8, 1e-5])
        columns = [
            (half_turn(state + step, f) - half_turn(state - step, f)) / (2.0 * step.sum())
            for step in steps
        ]
        assert np.abs(np.linalg.eigvals(np.array(columns).T) + 1.0).min() < 1e-4


@pytest.mark.slow
def test_a_long_step_does_not_lead_back_along_a_branch():
    """Beyond the fold at f = 6.3788 the branch passes near where it has been."""
    begin = ns.find_orbit(stiff_stops(), parameters={"f": 25.0})
    branch = ns.continue_orbit(stiff_stops(), "f", (5.0, 60.0), initial=begin, direction="down")
    kinds = branch["special_kind"].values
    assert "symmetry_breaking" in kinds and "branch_point" not in kinds
    folds = branch["special_value"].values[kinds == "fold"]
    assert np.sort(np.abs(folds - 7.268261))[0] < 1e-6  # found with steps of a twentieth too
    assert np.sort(np.abs(folds - 7.246596))[0] < 1e-6
