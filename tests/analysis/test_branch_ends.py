"""Where branches of orbits end, close and turn into others; what is no orbit."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

import nonsmooth as ns
from nonsmooth.analysis.orbit_search.branches import _telling
from periodic_orbits.systems import rigid_wall


def kinds(branch) -> list[str]:
    return branch["special_kind"].values.tolist()


def value(branch, kind: str) -> float:
    return float(branch["special_value"][kinds(branch).index(kind)])


def test_a_point_at_rest_is_no_orbit():
    damped = ns.System(
        states=["x", "v"], parameters={"k": 1.0}, equations={"x": "v", "v": "-k*x - 0.1*v"}
    )
    orbit = ns.find_orbit(damped, {"x": 1.0})
    assert orbit.attrs["status"] == "no_orbit"
    assert np.isnan(orbit["x"])


def test_a_branch_ends_where_a_requirement_fails():
    forced = ns.System(
        states=["x", "v"],
        parameters={"z": 0.1},
        require={"z > 0.05": "damping"},
        period="2*pi",
        equations={"x": "v", "v": "cos(t) - x - z*v"},
    )
    branch = ns.continue_orbit(forced, "z", (0.0, 0.5))
    assert branch.attrs["end_first"] == "domain"
    message = branch.attrs["message"]
    assert "the system refuses the parameters: z > 0.05 is required, z = 0.05" in message
    assert "was given: damping" in message and "guard" not in message
    assert float(branch["z"].min()) == pytest.approx(0.05, abs=1e-8)


@pytest.mark.slow
def test_a_branch_through_grazes_is_closed():
    """An isola: two folds, and two grazes at which an impact comes and goes."""
    wall = rigid_wall()
    first = ns.orbits(wall, longest=2).isel(orbit=1)
    branch = ns.continue_orbit(wall, "omega", (1.5, 4.0), initial=first)
    assert branch.attrs["end_last"] == "closed"
    assert branch.sizes["point"] < 200
    assert bool(branch["admissible"].all())


def test_resonance_does_not_use_up_the_steps():
    linear = ns.System(
        states=["x", "v"],
        parameters={"omega": 0.8},
        period="2*pi/omega",
        equations={"x": "v", "v": "cos(omega*t) - x - 0.02*v"},
    )
    branch = ns.continue_orbit(linear, "omega", (0.5, 2.0))
    assert (branch.attrs["end_first"], branch.attrs["end_last"]) == ("bound", "bound")
    omega = branch["omega"].values
    response = 1.0 / (1.0 - omega**2 + 0.02j * omega)
    assert branch["x"].values == pytest.approx(response.real, abs=1e-9)


def test_static_friction_above_the_kinetic_one_ends_a_branch_where_the_belt_is_reached():
    """What touches the belt is held at once, until the force has grown: no orbit is beside it."""
    belt = ns.System(
        states=["x", "v"],
        parameters={"v_b": 1.0},
        period="pi",
        equations={"x": "v", "v": "cos(2*t) - x - 0.1*v - 0.3*sign(slip)"},
        surfaces={"slip": ns.Surface("v - v_b", below="lag", on="stick", above="lead", hold="2")},
    )
    branch = ns.continue_orbit(belt, "v_b", (0.05, 1.2), direction="down")
    assert branch.attrs["end_first"] == "grazing"
    touched = 2.0 / abs(1 - 4 + 0.2j)
    assert value(branch, "grazing") == pytest.approx(touched, rel=1e-12)
    assert "holds what touches it" in branch.attrs["message"]
    # the orbit that sticks ends where it is held no more, and where it reaches the belt no more
    sticks = ns.find_orbit(belt, transient=30, parameters={"v_b": 0.6})
    assert sticks["word"].item() == "lag stick lag"
    branch = ns.continue_orbit(belt, "v_b", (0.05, 1.2), initial=sticks, parameters={"v_b": 0.6})
    assert (branch.attrs["end_first"], branch.attrs["end_last"]) == ("sliding", "grazing")
    first, last = branch.isel(point=0), branch.isel(point=-1)
    t, x = float(first["leg_time"][1]), float(first["leg_states"][1, 0])
    held = np.cos(2.0 * t) - x - 0.1 * float(first["v_b"])
    assert held == pytest.approx(2.0 * 0.3, rel=1e-9)  # all that the surface holds
    t, x = float(last["leg_time"][1]), float(last["leg_states"][1, 0])
    rate = np.cos(2.0 * t) - x - 0.1 * float(last["v_b"]) + 0.3
    assert rate == pytest.approx(0.0, abs=1e-8)  # the mass just reaches the belt


def test_a_cycle_that_shrinks_to_a_point():
    hopf = ns.System(
        states=["x", "y"],
        parameters={"mu": 0.5},
        equations={"x": "mu*x - y - x*(x**2 + y**2)", "y": "x + mu*y - y*(x**2 + y**2)"},
    )
    branch = ns.continue_orbit(hopf, "mu", (-0.5, 1.0), initial={"x": 0.7}, transient=3)
    assert branch.attrs["end_first"] == "hopf"
    assert float(branch["mu"].min()) == pytest.approx(0.0, abs=1e-8)
    assert branch["length"].values == pytest.approx(2.0 * np.pi, rel=1e-9)


def test_units_do_not_matter():
    """The same wall in lengths of one and of 1e-9, at the same places."""
    found = []
    for unit in (1.0, 1e-9, 1e6):
        wall = rigid_wall(F=0.4 * unit, omega=0.8, sigma=0.5 * unit, zeta=0.05)
        start = {"x": -unit, "v": 0.0}
        branch = ns.continue_orbit(wall, "omega", (0.6, 0.9), initial=start, transient=300)
        found.append(list(zip(kinds(branch), branch["special_value"].values, strict=True)))
        assert bool(branch["admissible"].all())
    for other in found[1:]:
        assert [kind for kind, _ in other] == [kind for kind, _ in found[0]]
        assert [v for _, v in other] == pytest.approx([v for _, v in found[0]], rel=1e-9)


def test_a_turn_that_repeats_a_shorter_orbit_is_followed_as_that():
    wall = rigid_wall(F=0.4, omega=0.8, sigma=0.5, zeta=0.05)
    twice = ns.continue_orbit(wall, "omega", (0.7, 0.9), period=2)
    once = ns.continue_orbit(wall, "omega", (0.7, 0.9))
    assert twice.attrs["period"] == once.attrs["period"] == 1
    assert kinds(twice) == kinds(once)


def test_just_below_grazing_the_orbit_without_contact_is_found():
    touching = 1.26 * np.hypot(1 - 0.85**2, 2 * 0.01 * 0.85) / 0.85**2
    orbit = ns.find_orbit(ns.models.soft_impact(a=float(touching * (1 - 1e-9))))
    assert (orbit.attrs["status"], orbit["word"].item()) == ("completed", "free")


def test_an_event_exactly_at_the_section():
    wall = rigid_wall(F=0.4, omega=0.8, sigma=0.5, zeta=0.05)
    orbit = ns.find_orbit(wall)
    share = float(orbit["leg_time"][1]) / wall.period_value
    there = ns.find_orbit(wall, orbit, phase=share)
    assert there.attrs["status"] == "completed"
    assert there["multipliers"].values == pytest.approx(orbit["multipliers"].values, abs=1e-9)


def test_a_cycle_counts_once_although_a_state_vanishes_at_its_events():
    clock = ns.System(
        states=["x", "v"],
        modes={
            "right": ns.Mode({"x": "v", "v": "-0.2*v - x + 0.3"}, exits=[ns.Exit("v", to="left")]),
            "left": ns.Mode({"x": "v", "v": "-0.2*v - x - 0.3"}, exits=[ns.Exit("-v", to="right")]),
        },
    )
    found = ns.orbits(clock, {"x": (-1.0, 1.0), "v": (-1.0, 1.0)}, longest=2, samples=30)
    assert found.sizes["orbit"] == 1
    assert float(found["length"][0]) == pytest.approx(2 * np.pi / np.sqrt(1 - 0.01), rel=1e-12)


@pytest.mark.slow
def test_a_fold_just_before_a_graze_is_found():
    """Folds alternate: the branch rises at both ends, so their number is even.

    The third fold lies 1.5e-6 before a graze. Its place comes from a computation that shares no
    code with this one.
    """
    beam = ns.models.breathing_crack(crack=5.01, d=-0.5)
    branch = ns.continue_orbit(beam, "crack", (5.0, 19.9), steps=4000, transient=1500)
    kinds, values = branch["special_kind"].values, branch["special_value"].values
    folds = values[kinds == "fold"]
    assert folds.size == 6
    turns = np.diff(folds)
    assert np.all(turns[::2] < 0.0)
    assert np.all(turns[1::2] > 0.0)
    assert folds[2] == pytest.approx(8.160295712253212, abs=1e-12)
    graze = values[kinds == "grazing"]
    assert np.min(np.abs(graze - folds[2])) == pytest.approx(1.479e-6, abs=1e-9)


@pytest.mark.parametrize("start", [0.0, 1e-20, 1e-14, 1e-9])
def test_a_motion_at_rest_at_zero_is_followed(start):
    """Nothing has a size there; x -> -r x + x**3 flips where r = 1."""
    kick = ns.Exit("cos(2*pi*t)", to="late", reset={"x": "-r*x + x**3"}, name="kick")
    kicked = ns.System(
        states=["x"],
        period=1.0,
        parameters={"r": 0.9},
        modes={
            "early": ns.Mode({"x": "0"}, exits=[kick]),
            "late": ns.Mode({"x": "0"}, exits=[ns.Exit("-cos(2*pi*t)", to="early")]),
        },
    )
    branch = ns.continue_orbit(kicked, "r", (0.8, 1.3), initial={"x": start})
    assert (branch["r"].min(), branch["r"].max()) == (0.8, 1.3)
    flip = branch["special_value"].values[branch["special_kind"].values == "flip"]
    assert flip == pytest.approx([1.0], abs=1e-12)


@pytest.mark.slow
def test_no_fold_where_an_event_passes_the_section_behind_a_turn_at_a_graze():
    """Special points do not depend on the phase at which the orbit is cut.

    The branch of the mole turns back at a graze. Sections are placed so that an event passes them
    a little behind it.
    """
    mole = ns.models.moling()
    usual = ns.continue_orbit(mole, "b", (0.1, 0.17), direction="up")
    graze = usual["special_kind"].values.tolist().index("grazing")
    at = int(usual["special_point"][graze])
    instants = [
        (usual["leg_time"].values[k, 1:] / usual["length"].values[k]) % 1.0 for k in (at, at + 1)
    ]
    for phase in np.mean(instants, axis=0)[np.isfinite(instants).all(axis=0)]:
        other = ns.continue_orbit(mole, "b", (0.1, 0.17), direction="up", phase=float(phase))
        assert other["special_kind"].values.tolist() == usual["special_kind"].values.tolist()
        assert other["special_value"].values == pytest.approx(usual["special_value"].values)


@pytest.mark.slow
def test_no_fold_beside_rebounds_of_a_ball():
    """A ball with drag on a table, 18 impacts in a period: folds have the multiplier 1."""
    ball = ns.System(
        states=["h", "u"],
        period="1/25",
        parameters={"A": 5e-4},
        initial={"h": 0.002},
        definitions={"s": "A*sin(50*pi*t)", "sv": "50*pi*A*cos(50*pi*t)"},
        modes={
            "flight": ns.Mode(
                {"h": "u", "u": "-9.81 - 0.04*u*abs(u) - 4*h"},
                exits=[ns.Exit("h - s", reset={"u": "-0.7*u + 1.7*sv"}, sticks="rides",
                               name="bounce")],
            )
        },
    )  # fmt: skip
    branch = ns.continue_orbit(ball, "A", (3e-4, 1.2e-3), initial=ns.find_orbit(ball))
    folds = branch["special_kind"].values == "fold"
    assert np.all(np.abs(branch["special_multiplier"].values[folds] - 1.0) < 1e-3)


def test_a_closed_branch_ends_where_it_began():
    """A mass between two moving stops: each change is told once, and the last orbit is the first.

    The branch begins in the middle of a stretch of one word.
    """
    stops = {"reset": {"v": "-r*v + (1 + r)*cos(t)"}}
    rattle = ns.System(
        states=["y", "v"],
        period="2*pi",
        parameters={"b": 0.6, "r": 0.7, "c": 0.1},
        modes={
            "free": ns.Mode(
                {"y": "v", "v": "-c*v - 0.05"},
                exits=[
                    ns.Exit("b - (y - sin(t))", sticks="up", name="drive", **stops),
                    ns.Exit("b + (y - sin(t))", sticks="down", name="back", **stops),
                ],
            )
        },
    )
    branch = ns.continue_orbit(rattle, "b", (0.2, 1.0))
    assert branch.attrs["end_last"] == "closed"
    last, first = branch.isel(point=-1), branch.isel(point=0)
    for name in ("b", "y", "v"):
        assert float(last[name]) == float(first[name])
    kinds, values = branch["special_kind"].values[:-1], branch["special_value"].values[:-1]
    told = list(zip(kinds.tolist(), np.round(values, 7).tolist(), strict=True))
    assert len(told) == len(set(told)) >= 4
    folds = sorted(value for kind, value in told if kind == "fold")
    assert len(folds) % 2 == 0  # the parameter comes back to where it was


def relay_cycle() -> float:
    """Length of the cycle of 1/(s + 1)^3 with an ideal relay, by Tsypkin's condition.

    Half a turn takes the state to its negative, from the switch at which the output is zero.
    """
    flow = np.array([[-1.0, 1.0, 0.0], [0.0, -1.0, 1.0], [0.0, 0.0, -1.0]])

    def output(half: float) -> float:
        step = expm(half * flow)
        forced = np.linalg.solve(flow, (step - np.eye(3)) @ [0.0, 0.0, 1.0])
        return float(np.linalg.solve(np.eye(3) + step, -forced)[0])

    return 2.0 * brentq(output, 1.0, 3.0, xtol=1e-14)


@pytest.mark.parametrize("low", [-0.3, -1e-3])
def test_a_branch_ends_at_the_last_motion_however_long_the_step(low):
    """A relay whose two thresholds have come together chatters for ever beyond."""

    def plant(u: str) -> dict[str, str]:
        return {"a": "b - a", "b": "c - b", "c": f"{u} - c"}

    relay = ns.System(
        states=["a", "b", "c"],
        parameters={"h": 0.1},
        initial={"a": 0.3},
        modes={
            "down": ns.Mode(plant("-1"), exits=[ns.Exit("a + h", to="up", name="on")]),
            "up": ns.Mode(plant("1"), exits=[ns.Exit("h - a", to="down", name="off")]),
        },
    )
    branch = ns.continue_orbit(relay, "h", (low, 0.9), direction="down")
    assert branch.attrs["end_first"] == "word_change"
    assert value(branch, "word_change") == pytest.approx(0.0, abs=1e-9)
    assert bool(branch["admissible"][0])
    assert float(branch["length"][0]) == pytest.approx(relay_cycle(), rel=1e-9)
    assert "on>off" in branch.attrs["message"]  # what happens beyond


@pytest.mark.slow
def test_a_branch_ends_where_both_walls_are_only_touched():
    """A ball in a cavity rests where the cavity just reaches it on either side.

    Equations with one wall alone are solved there by balls at rest, which are no orbit that goes
    on: of F the branch has one end, and it is told within few steps.
    """
    before = "(v + m*u {0} m*r*(u - v))/(1 + m)", "(v + m*u {0} r*(u - v))/(1 + m)"
    impact = {"v": before[0].format("+"), "u": before[1].format("-")}
    values = {"m": 0.08, "d": 0.02, "F": 0.045, "w": 0.98, "b": 0.9, "r": 0.65}
    cavity = ns.System(
        states=["x", "v", "y", "u"],
        parameters=values,
        period="2*pi/w",
        modes={
            "flies": ns.Mode(
                {"x": "v", "v": "F*cos(w*t) - d*v - x", "y": "u", "u": "0"},
                exits=[
                    ns.Exit("b - (y - x)", reset=impact, sticks="right"),
                    ns.Exit("b + (y - x)", reset=impact, sticks="left"),
                ],
            )
        },
        symmetry={"x": "-x", "v": "-v", "y": "-y", "u": "-u"},
    )
    branch = ns.continue_orbit(cavity, "F", (0.005, 0.046), direction="down", transient=1000)
    assert branch.attrs["end_first"] == "grazing"
    assert "zero speed" in branch.attrs["message"]
    assert "no orbit of a changed word" in str(branch["special_detail"].values[0])
    # the cavity alone swings as far as it is wide
    width = values["b"] * np.hypot(1.0 - values["w"] ** 2, values["d"] * values["w"])
    assert value(branch, "grazing") == pytest.approx(width, rel=1e-6)
    assert branch.sizes["point"] < 60


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_multiplier_that_is_rounding_of_an_infinite_one_is_infinite(sign):
    """At a graze the rate of the guard is zero up to rounding, of either sign."""
    values = np.array([sign * 1.6e15, 0.1], complex)
    looked = SimpleNamespace(multipliers=SimpleNamespace(multipliers=values))
    part = SimpleNamespace(looked=looked, unbounded=False, special="grazing")
    assert _telling(part) == np.inf
    part.special = "fold"
    assert _telling(part) == 0.1


@pytest.mark.slow
def test_a_curve_of_special_points_ends_where_a_requirement_fails():
    """Grazes of a linear oscillator at a wall: F = d*sqrt((1 - w^2)^2 + (2 z w)^2)."""
    wall = ns.System(
        states=["x", "v"],
        parameters={"w": 0.7, "F": 0.3, "z": 0.1},
        period="2*pi/w",
        require={"w < 0.75": "the motor turns no faster"},
        modes={
            "free": ns.Mode(
                {"x": "v", "v": "F*cos(w*t) - x - 2*z*v"},
                exits=[ns.Exit("1 - x", reset={"v": "-0.8*v"}, name="impact")],
            )
        },
    )
    branch = ns.continue_orbit(wall, "F", (0.2, 0.8))
    kinds = branch["special_kind"].values.tolist()
    curve = ns.continue_special(branch, kinds.index("grazing"), "w", (0.3, 0.9))
    w, force = curve["w"].values, curve["F"].values
    assert np.allclose(force, np.hypot(1.0 - w**2, 0.2 * w), rtol=1e-9)
    assert w.max() == pytest.approx(0.75, abs=1e-7)  # by the smallest step
    assert "refuses the parameters: w < 0.75 is required, w = 0.75" in curve.attrs["message"]


@pytest.mark.slow
def test_a_closed_branch_of_cycles_without_events_ends_where_it_began():
    """(r - 2)**2 + p**2 = 1/4: cycles of radius r, which move across the plane of the first one.

    So planes are laid anew on the way, and the branch comes back on another one.
    """
    rings = ns.System(
        states=["x", "y"],
        parameters={"p": 0.0},
        definitions={"u": "y - 3*p", "g": "(sqrt(x**2 + u**2) - 2)**2 + p**2 - 0.25"},
        equations={"x": "x*g - u", "y": "u*g + x"},
    )
    orbit = ns.find_orbit(rings, {"x": 1.5, "y": 0.0})
    branch = ns.continue_orbit(rings, "p", (-1.0, 1.0), initial=orbit, steps=500)
    assert branch.attrs["end_last"] == "closed"
    radius = np.hypot(branch["x"], branch["y"] - 3.0 * branch["p"])
    off = np.abs((radius - 2.0) ** 2 + branch["p"] ** 2 - 0.25).values
    # one turn multiplies what is off by exp(4 pi r (r - 2)), up to 6e6 on the outer half
    stable = branch["stable"].values.astype(bool)
    assert stable.sum() > 10
    assert off[stable].max() < 1e-10
    assert off.max() < 1e-7
    assert radius.min() == pytest.approx(1.5, abs=1e-10)
    assert radius.max() > 2.49
    kinds = branch["special_kind"].values.tolist()
    assert kinds.count("fold") == 2
    folds = branch["special_value"].values[branch["special_kind"].values == "fold"]
    assert np.abs(np.abs(folds) - 0.5).max() < 1e-12
    # the last orbit is the first one, from whatever point of it
    assert float(branch["p"][-1]) == pytest.approx(0.0, abs=1e-12)
    assert float(radius[-1]) == pytest.approx(1.5, abs=1e-10)


def test_a_state_that_may_begin_anywhere_keeps_its_place():
    """A damper without a spring keeps u + (y - x)/5 what it is."""
    free = ns.System(
        states=["x", "v", "y", "u"], parameters={"F": 0.1}, period="2*pi",
        equations={"x": "v", "v": "F*cos(t) - x - 0.1*v", "y": "u", "u": "-0.2*(u - v)"},
    )  # fmt: skip
    branch = ns.continue_orbit(free, "F", (0.0, 0.5), initial={"y": 0.3}, transient=0)
    assert branch.attrs["end_first"] == branch.attrs["end_last"] == "bound"
    kept = branch["u"].values + 0.2 * (branch["y"].values - branch["x"].values)
    np.testing.assert_allclose(kept, kept[0], atol=1e-12)
    np.testing.assert_allclose(branch["x"], 0.0, atol=1e-12)  # F cos(t) is met by 0.1 v
    np.testing.assert_allclose(branch["v"], 10.0 * branch["F"], atol=1e-11)


def test_free_oscillations_that_repeat_with_the_period_fix_no_orbit():
    """Two free periods in one of the forcing: motions of any amplitude repeat."""
    free = ns.System(
        states=["x", "v"],
        parameters={"F": 0.1},
        period="4*pi",
        equations={"x": "v", "v": "F*cos(t/2) - x - max(x - 1, 0)"},
    )
    with pytest.raises(ns.RunError, match="do not fix one curve, as where branches cross, motions"):
        ns.continue_orbit(free, "F", (0.0, 0.2), initial={"x": 0.1 / 0.75}, transient=0)
