"""Branches over a parameter against closed forms and against Newton's method in 90 digits."""

import numpy as np
import pytest
from mpmath import mp

import nonsmooth as ns
from nonsmooth.structures import Force, GapSpring, machine
from periodic_orbits.references.mole_grazing import touching_b
from periodic_orbits.references.oscillators import soft_grazing_amplitude
from periodic_orbits.references.rigid_wall import RigidWall
from periodic_orbits.references.table_ball import TableBall
from periodic_orbits.sampler import mole_penetration, wall_penetration
from periodic_orbits.systems import ORBITS, ball_on_table, rigid_wall
from periodic_orbits.test_mole_orbits import CASES, DEFAULTS, KEPT, POINTS, start_of

# periodic.references.mole_grazing.touching_b, of the orbit that came back from the fold
GRAZING = 0.1509775028568871206701931
SOFT = {"omega": 0.85, "zeta": 0.01, "beta": 29.0, "e": 1.26}
FOLDED = {"omega": 0.6, "zeta": 0.02, "beta": 29.0, "e": 1.26}


def free_start(words: dict, a: float) -> dict[str, float]:
    """Phase 0 of the motion that does not touch the second spring."""
    omega = words["omega"]
    x = -1j * a * omega**2 / (1 - omega**2 + 2j * words["zeta"] * omega)
    return {"x": x.real, "v": (1j * omega * x).real}


def specials(branch, *kinds: str) -> list[float]:
    """Parameter values of the special points of these kinds, ascending."""
    rows = zip(branch["special_kind"].values, branch["special_value"].values, strict=True)
    return sorted(float(value) for kind, value in rows if str(kind) in kinds)


def nearest(branch, value: float, *kinds: str) -> float:
    """Distance of the nearest special point of these kinds."""
    found = specials(branch, *kinds)
    assert found, f"none of {kinds}; there are {set(branch['special_kind'].values.tolist())}"
    return min(abs(each - value) for each in found)


@pytest.mark.slow
def test_mole_flip_and_fold_of_the_period_one_branch():
    """Both ends of the stable period-one motion, to 1e-9 by two routes."""
    system = ns.models.moling(**DEFAULTS)
    orbit = ns.find_orbit(system, start_of(KEPT["four_phases"]))
    branch = ns.continue_orbit(system, "b", (0.1, 0.18), initial=orbit)
    assert nearest(branch, float(POINTS["flip_1"]["value"]), "flip") < 1e-9
    assert nearest(branch, float(POINTS["fold"]["value"]), "fold") < 1e-9
    assert nearest(branch, GRAZING, "grazing") < 1e-9
    # between flip and fold there is a stable orbit; the branch comes back below it, unstable
    low, high = float(POINTS["flip_1"]["value"]), float(POINTS["fold"]["value"])
    b, stable = branch["b"].values, branch["stable"].values
    assert np.all(~stable[b < low - 1e-9])
    fold = int(np.argmin(abs(b - high) + (b > high)))
    first = slice(int(np.flatnonzero(b > low + 1e-9)[0]), fold)
    assert np.all(stable[first])
    after = stable[fold + 1 :][b[fold + 1 :] > GRAZING + 1e-3]
    assert not after[: np.flatnonzero(b[fold + 1 :] < GRAZING + 1e-3)[0]].any()


@pytest.mark.slow
def test_the_grazing_again():
    """From the orbit behind the fold, at b = 0.1516, in 50 digits."""
    with mp.workdps(50):
        b, _ = touching_b(
            CASES["flip_passed"].word,
            ("-0.92", "-0.187", "0"),
            ("50.06", "0.0916", "8.28", "1.913", "2.485"),
            near=("0.151", "0.15099"),
        )
    assert abs(float(b) - GRAZING) < 1e-16


@pytest.mark.few(1)
@pytest.mark.parametrize("periods", [2, 4, 8])
def test_mole_cascade(periods):
    name = {2: "two_periods", 4: "four_periods", 8: "eight_periods"}[periods]
    b0 = float(CASES[name].parameters["b"])
    system = ns.models.moling(**DEFAULTS | {"b": b0})
    orbit = ns.find_orbit(system, start_of(KEPT[name]), period=periods)
    assert orbit.attrs["status"] == "completed"
    target = float(POINTS[f"flip_{periods}"]["value"])
    branch = ns.continue_orbit(system, "b", (target - 1e-4, b0 + 1e-4), initial=orbit)
    assert nearest(branch, target, "flip") < 1e-9


def test_no_point_of_a_branch_goes_through_the_slider():
    system = ns.models.moling(**DEFAULTS)
    orbit = ns.find_orbit(system, start_of(KEPT["four_phases"]))
    branch = ns.continue_orbit(system, "b", (0.12, 0.165), initial=orbit)
    for k in range(0, branch.sizes["point"], max(1, branch.sizes["point"] // 12)):
        point = branch.isel(point=k)
        if bool(point["admissible"]):
            legs = point.isel(leg=point["leg_mode"].values >= 0)
            deepest, joint = mole_penetration(legs, **DEFAULTS | {"b": float(point["b"])})
            assert deepest < 1e-11 * 30 and joint < 1e-9 * 30


def wall_branch(n: int, force: float, between: tuple[float, float], **words):
    wall = RigidWall.of(**words, n=n)
    system = rigid_wall(F=force, **words)
    orbit = ns.find_orbit(system, wall.start(wall.speeds(force)[0]), period=n)
    assert orbit.attrs["status"] == "completed"
    return wall, ns.continue_orbit(system, "F", between, initial=orbit)


@pytest.mark.slow
def test_rigid_wall_fold_flip_and_grazing():
    """The two-period orbit: fold, back to grazing at speed zero; flip, then a second touch."""
    words = {"omega": 2.8, "zeta": 0.02, "sigma": 0.1, "r": 0.8}
    wall, branch = wall_branch(2, 0.3, (0.05, 2.2), **words)
    assert nearest(branch, float(wall.force(wall.fold_speed)), "fold") < 1e-10
    assert nearest(branch, float(wall.force(wall.flip_speed)), "flip") < 1e-9
    # RigidWall.touching: see test_rigid_wall.py
    assert nearest(branch, 1.928925317900750545320119, "grazing", "gained") < 1e-9
    assert nearest(branch, float(wall.grazing_force), "grazing", "lost") < 1e-10


@pytest.mark.slow
def test_no_admissible_point_goes_through_the_wall():
    words = {"omega": 2.8, "zeta": 0.02, "sigma": 0.1, "r": 0.8}
    _, branch = wall_branch(2, 0.3, (0.05, 2.2), **words)
    for k in range(branch.sizes["point"]):
        point = branch.isel(point=k)
        legs = point.isel(leg=point["leg_mode"].values >= 0)
        deepest, joint = wall_penetration(legs, F=float(point["F"]), **words)
        assert joint < 1e-9
        # dense samples miss the top of an arc by far less than 1e-6
        assert (deepest < 1e-9) == bool(point["admissible"]) or abs(deepest) < 1e-6, (
            k,
            float(point["F"]),
            deepest,
        )


@pytest.mark.slow
def test_rigid_wall_ends_at_grazing_from_above():
    """With one impact per period the speed falls to zero at F_g; the branch goes on without."""
    words = {"omega": 0.8, "zeta": 0.05, "sigma": 0.5, "r": 0.7}
    wall, branch = wall_branch(1, 0.3, (0.1, 0.6), **words)
    assert nearest(branch, float(wall.force(wall.flip_speed)), "flip") < 1e-9
    grazing = float(wall.grazing_force)
    assert nearest(branch, grazing, "grazing", "lost") < 1e-10
    for k in range(branch.sizes["point"]):
        point = branch.isel(point=k)
        legs = point.isel(leg=point["leg_mode"].values >= 0)
        force = float(point["F"])
        if bool(point["admissible"]):
            deepest, _ = wall_penetration(legs, F=force, **words)
            assert deepest < 1e-11
        if legs.sizes["leg"] == 1:
            assert force <= grazing * (1 + 1e-10)
        elif force > grazing * (1 + 1e-6):
            speed = float(wall.speeds(force)[0])
            assert abs(float(legs["leg_states"].sel(state="v")[1]) + 0.7 * speed) < 1e-9


def test_rigid_wall_from_below_grazing():
    words = {"omega": 0.8, "zeta": 0.05, "sigma": 0.5, "r": 0.7}
    wall = RigidWall.of(**words)
    system = rigid_wall(F=0.1, **words)
    branch = ns.continue_orbit(system, "F", (0.05, 0.3))
    assert nearest(branch, float(wall.grazing_force), "grazing", "gained") < 1e-10


def test_soft_impact_through_grazing_to_the_flip():
    system = ns.models.soft_impact(**SOFT, a=0.3)
    branch = ns.continue_orbit(system, "a", (0.2, 0.49), initial=free_start(SOFT, 0.3))
    grazing = float(soft_grazing_amplitude(omega="0.85", zeta="0.01", e="1.26"))
    assert nearest(branch, grazing, "grazing", "gained") < 1e-10
    assert nearest(branch, float(ORBITS["soft_points"]["flip"]["value"]), "flip") < 1e-9
    words = set(branch["word"].values.tolist())
    assert {"free", "free contact free"} <= words


def test_soft_impact_through_grazing_to_the_fold():
    system = ns.models.soft_impact(**FOLDED, a=2.0)
    branch = ns.continue_orbit(system, "a", (1.5, 2.3), initial=free_start(FOLDED, 2.0))
    grazing = float(soft_grazing_amplitude(omega="0.6", zeta="0.02", e="1.26"))
    assert nearest(branch, grazing, "grazing", "gained") < 1e-10
    assert nearest(branch, float(ORBITS["soft_points"]["fold"]["value"]), "fold") < 1e-9


def test_trilinear_symmetry_breaking():
    system = ns.models.trilinear(omega=1.5)
    branch = ns.continue_orbit(system, "omega", (0.7, 1.6))
    for name in ("upper", "lower"):
        value = float(ORBITS["trilinear_points"][name]["value"])
        assert nearest(branch, value, "symmetry_breaking", "branch_point") < 1e-9


@pytest.mark.parametrize(("r", "n"), [("0.8", 1), ("0.5", 1)])
def test_bouncing_ball_saddle_node_and_period_doubling(r, n):
    ball = TableBall(r, n)
    low, high = float(ball.saddle_node), float(ball.period_doubling)
    gamma = (low + high) / 2
    system, start = ball_on_table(gamma, float(r)), ball.start(gamma)
    orbit = ns.find_orbit(system, {"h": start["h"], "w": start["w"]}, period=n)
    branch = ns.continue_orbit(system, "Gamma", (0.5 * low, 1.2 * high), initial=orbit)
    assert nearest(branch, low, "fold") < 1e-10
    assert nearest(branch, high, "flip") < 1e-9


@pytest.mark.slow  # 90 orbits and their changes, some ten seconds
def test_a_resonance_with_a_damped_stop_begins_and_ends_without_contact():
    """It leaves the linear motion where that reaches the stop, and comes back to it.

    At both places F is gap sqrt((1 - omega^2)^2 + (2 zeta omega)^2). At the second one two legs
    vanish at once, and the parameter turns back.
    """
    F, zeta = 0.15, 0.01
    stop = GapSpring("x", gap=1.0, stiffness=3.0, damping=1.0)
    mass = ns.Structure([[1.0]], [[1.0]], damping=[[2 * zeta]], coordinates=["x"])
    system = machine(
        mass,
        [stop],
        [Force("x", "F*cos(omega*t)")],
        parameters={"F": F, "omega": 0.9},
        period="2*pi/omega",
    )
    branch = ns.continue_orbit(system, "omega", (0.9, 1.6), direction="up")
    assert branch.attrs["end_last"] == "bound"
    kinds, values = branch["special_kind"].values.tolist(), branch["special_value"].values
    assert kinds[:2] == ["grazing", "fold"] and len(kinds) == 4
    omega2 = (1 - 2 * zeta**2) + np.array([-1, 1]) * np.sqrt(
        (1 - 2 * zeta**2) ** 2 - 1 + F**2
    )  # of the squares
    assert np.abs(values[[0, 2]] - np.sqrt(omega2)).max() < 1e-9
    assert branch["word"].values[-1] == "free"


@pytest.mark.slow  # 60 orbits and their changes, some five seconds
def test_teeth_come_off_one_side_of_their_play():
    """They do where the amplitude of their force is the mean one, which is a closed form.

    Behind the surface of the spring that is left lies the gap here, and not the other spring.
    """
    F, mean, zeta = 0.2, 0.5, 0.05
    teeth = GapSpring({"x": -1.0}, gap=1.0, stiffness=1.0, side="both")
    mass = ns.Structure([[1.0]], [[0.0]], damping=[[2 * zeta]], coordinates=["x"])
    system = machine(
        mass,
        [teeth],
        [Force("x", "F*cos(omega*t) - mean")],
        parameters={"mean": mean, "F": F, "omega": 0.5},
        period="2*pi/omega",
    )
    branch = ns.continue_orbit(
        system, "omega", (0.5, 1.6), initial={"x": -1.5}, direction="up", largest_step=0.1
    )
    assert branch.attrs["end_last"] == "bound"
    # the response is linear until then: F = mean |1 - omega^2 + 2 i zeta omega|
    middle = 1 - 2 * zeta**2
    away = np.sqrt(middle**2 - 1 + (F / mean) ** 2)
    for omega in np.sqrt([middle - away, middle + away]):
        assert nearest(branch, omega, "grazing") < 1e-9
    assert branch["word"].values[-1] == "above"
