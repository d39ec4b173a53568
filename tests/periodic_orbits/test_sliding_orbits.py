"""Orbits that stick, slide and come to rest, against closed forms."""

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.linalg import expm
from scipy.optimize import fsolve

import nonsmooth as ns
from periodic_orbits.references import chatter


def belt(z: float = 0.0) -> ns.System:
    return ns.System(
        states=["x", "v"],
        parameters={"v_b": 0.3, "F_k": 0.4, "F_s": 0.6, "z": z},
        equations={"x": "v", "v": "-x - 2*z*v - F_k*sign(slip)"},
        surfaces={
            "slip": ns.Surface("v - v_b", below="lag", on="stick", above="lead", hold="F_s/F_k")
        },
    )


def wall(**changed) -> ns.System:
    values = {"F": 1.0, "omega": 0.3, "zeta": 0.0, "sigma": 0.0, "r": 0.8} | changed
    return ns.System(
        states=["x", "v"],
        parameters=values,
        period="2*pi/omega",
        modes={
            "free": ns.Mode(
                {"x": "v", "v": "F*cos(omega*t) - 2*zeta*v - x"},
                exits=[ns.Exit("sigma - x", reset={"v": "-r*v"}, sticks="stuck", name="impact")],
            )
        },
    )


@pytest.mark.parametrize("how", [{"initial": {"x": 0.0, "v": 0.0}}, {"word": "stick lag stick"}])
def test_belt(how):
    """Stick from x = F_k - D to F_k + D, then the arc of a circle about F_k, D = F_s - F_k."""
    orbit = ns.find_orbit(belt(), **how)
    assert orbit.attrs["status"] == "completed"
    assert orbit["word"].item() == "stick lag stick"
    D, v_b = 0.6 - 0.4, 0.3
    length = 2 * D / v_b + 2 * np.pi - 2 * np.arctan(D / v_b)
    assert float(orbit["length"]) == pytest.approx(length, rel=1e-13)
    assert orbit["durations"].values[0] == pytest.approx(2 * D / v_b, rel=1e-13)
    assert orbit["multipliers"].values.tolist() == [0.0]  # that of the motion is left out
    assert float(orbit["log_determinant"]) == -np.inf
    assert bool(orbit["stable"])


@pytest.mark.slow
@pytest.mark.parametrize(
    "how", [{"initial": {"x": -1.0, "v": 0.0}, "transient": 3}, {"word": "free stuck free"}]
)
def test_chatter_to_rest(how):
    """The section lies within rebounds; the state there is known to 40 digits."""
    system = wall()
    orbit = ns.find_orbit(system, **how)
    assert orbit.attrs["status"] == "completed"
    assert orbit["word"].item() == "free stuck free"  # however many rebounds are followed
    assert orbit.sizes["leg"] > 50
    x, v = chatter.state_at(0.3, 0.8, 2 * mp.pi / mpf("0.3"))
    assert float(orbit["x"]) == pytest.approx(float(x), abs=1e-12)
    assert float(orbit["v"]) == pytest.approx(float(v), abs=1e-12)
    assert orbit["multipliers"].values.tolist() == [0.0, 0.0]
    # release where the force changes its sign
    k = orbit["leg_exit"].values.tolist().index("release")
    assert float(orbit["leg_time"][k + 1]) == pytest.approx(np.pi / 2 / 0.3, rel=1e-12)


def test_a_section_at_rest():
    system = wall()
    orbit = ns.find_orbit(system, {"x": -1.0, "v": 0.3}, word="stuck free stuck", phase=0.15)
    assert orbit.attrs["status"] == "completed"
    assert float(orbit["x"]) == 0.0 and orbit.sizes["leg"] > 50


def test_a_branch_over_numbers_of_rebounds():
    """Their number and the section between them change; nothing happens, and nothing is said."""
    system = wall(zeta=0.02)
    start = {"x": -1.0, "v": 0.0}
    branch = ns.continue_orbit(system, "omega", (0.285, 0.31), initial=start, transient=3)
    assert (branch.attrs["end_first"], branch.attrs["end_last"]) == ("bound", "bound")
    assert set(branch["special_kind"].values) == {"bound"}
    assert bool(branch["admissible"].all()) and np.all(branch["multipliers"].values == 0.0)
    followed = np.isfinite(branch["durations"].values).sum(axis=1)
    assert np.ptp(followed) >= 1
    for k in range(0, branch.sizes["point"], 5):
        point = branch.isel(point=k)
        there = {"x": float(point["x"]), "v": float(point["v"])}
        if abs(there["x"]) < 1e-9:  # an impact at the section: the speed is before or behind it
            continue
        run = ns.simulate(system, there, periods=1, parameters={"omega": float(point["omega"])})
        assert float(run["x"][-1]) == pytest.approx(there["x"], abs=1e-11)
        assert float(run["v"][-1]) == pytest.approx(there["v"], abs=1e-11)


@pytest.mark.few(1)
@pytest.mark.parametrize("omega", [0.3118, 0.314])
def test_a_branch_through_the_end_of_rebounds(omega):
    """Infinitely many pass the section at omega = 0.31262: behind it, it lies at rest."""
    system = wall(zeta=0.02, omega=omega)
    start = {"x": -1.0, "v": 0.0}
    branch = ns.continue_orbit(system, "omega", (0.3115, 0.3145), initial=start, transient=3)
    assert (branch.attrs["end_first"], branch.attrs["end_last"]) == ("bound", "bound")
    assert set(branch["special_kind"].values) == {"bound"}
    assert bool(branch["admissible"].all())
    along = np.argsort(branch["omega"].values)
    at_rest = (branch["v"].values == 0.0)[along]
    assert not at_rest[0] and at_rest[-1]
    # one change only, and the flight over the section is gone with it
    assert np.count_nonzero(np.diff(at_rest.astype(int))) == 1


def fastest_with_stick(z: float) -> float:
    """The speed of the belt at which a damped block comes up to it once a turn, and no faster."""
    with mp.workdps(30):
        w, drop = mp.sqrt(1 - mpf(z) ** 2), mpf("0.6") - mpf("0.4")

        def speed_and_rate(t, v):
            y = drop - 2 * z * v  # from the middle of the slip, where stick ends
            e, c, s = mp.exp(-z * t), mp.cos(w * t), mp.sin(w * t) / w
            now, rate = e * (y * (c + z * s) + v * s), e * (v * (c - z * s) - y * s)
            return [rate - v, -2 * z * rate - now]

        return float(mp.findroot(speed_and_rate, (mpf("5.8"), mpf("0.37")))[1])


def test_the_last_stick_is_found_to_rounding_from_any_range():
    # the end is a fold of the equations as well, in whichever order rounding has both
    z = 0.02
    system = belt(z)
    orbit, truth = ns.find_orbit(system, transient=5), fastest_with_stick(z)
    for high in (0.57, 0.60, 0.81):
        branch = ns.continue_orbit(system, "v_b", (0.3, high), initial=orbit)
        ends = dict(zip(branch["special_kind"].values, branch["special_value"].values, strict=True))
        # states are known to rounding, and the parameter changes by the square of the rest time
        assert ends["grazing"] == pytest.approx(truth, rel=1e-11), high


def relays() -> ns.System:
    """Two of them: each holds its surface while its drive is weaker than the switch."""
    return ns.System(
        states=["x", "y"],
        period="2*pi",
        parameters={"a": 1.5, "b": 1.2, "lag": 0.7},
        equations={"x": "a*cos(t) - sign(x)", "y": "b*cos(t - lag) - 0.9*sign(y)"},
    )


def away(drive, switch):
    """How long such a relay is away from its surface, behind cos = switch/drive."""
    with mp.workdps(30):
        drive, switch = mpf(drive), mpf(switch)
        begin = -mp.acos(switch / drive)

        def x(t):
            return drive * (mp.sin(t) - mp.sin(begin)) - switch * (t - begin)

        return float(mp.findroot(x, (mpf("0.9"), mpf("2.5")), solver="anderson") - begin)


def test_two_surfaces_slide_one_by_one_and_together():
    orbit = ns.find_orbit(relays(), {"x": 0.3, "y": -0.2}, transient=2, phase=0.3)
    assert orbit.attrs["status"] == "completed"
    assert orbit["multipliers"].values.tolist() == [0.0, 0.0]
    names = orbit["word"].item().split()
    assert any(name.endswith("[00]") for name in names)
    # time away from each surface: two excursions in a turn, up and down
    durations, modes = orbit["durations"].values, orbit["leg_mode"]
    labels = modes.attrs["flag_meanings"].split()
    for place, (drive, switch) in enumerate(((1.5, 1.0), (1.2, 0.9))):
        off = [labels[m].split("[")[1][place] != "0" for m in modes.values]
        assert durations[off].sum() == pytest.approx(2 * away(drive, switch), rel=1e-11)


def test_a_superstable_orbit_says_so():
    for system, start in ((belt(), {"x": 0.0}), (wall(), {"x": -1.0})):
        orbit = ns.find_orbit(system, start, transient=2)
        assert "superstable" in orbit.attrs["message"]
        assert orbit.attrs["status"] == "completed"


def test_an_orbit_from_a_start_that_sticks_more_often():
    """Coulomb friction below the force: two turning points without rest, by the closed form.

    Between them x is odd half a period later, and v is zero where x = a: the solution of
    x'' = -x - c x' + F cos(w t) + mu on the way down from a to -a in half a period.
    """
    system = ns.System(
        states=["x", "v"],
        period="2*pi/w",
        parameters={"F": 1.0, "w": 0.7, "mu": 0.6, "c": 0.1},
        equations={"x": "v", "v": "-x - c*v + F*cos(w*t) - mu*sign(v)"},
        surfaces={"turn": ns.Surface("v")},
    )
    orbit = ns.find_orbit(system, {"x": 0.5, "v": 0.1})
    assert orbit.attrs["status"] == "completed"
    assert orbit["leg_mode"].size == 3
    half = np.pi / 0.7
    assert np.diff(orbit["leg_time"].values[1:])[0] == pytest.approx(half, abs=1e-12)
    A = np.array([[0.0, 1.0], [-1.0, -0.1]])
    # states are (x, v), cos, sin and 1, on the way down: friction pushes up
    whole = np.zeros((5, 5))
    whole[:2, :2], whole[1, 2], whole[1, 4] = A, 1.0, 0.6
    whole[2, 3], whole[3, 2] = -0.7, 0.7
    over = expm(whole * half)

    def gap(unknowns):
        a, phase = unknowns
        end = over @ [a, 0.0, np.cos(phase), np.sin(phase), 1.0]
        return [end[0] + a, end[1]]

    x, v = orbit["leg_states"].values[1]
    solution = fsolve(gap, [x, 0.7 * float(orbit["leg_time"][1])], xtol=1e-14)
    assert [x, v] == pytest.approx([solution[0], 0.0], abs=1e-11)
