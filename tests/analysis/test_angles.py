"""Rotations repeat up to whole turns of an angle: regimes, diagrams, orbits, attractors, basins.

A driven, damped pendulum turns over once per period of the forcing, three times in two, and so on.
Its orbits and Floquet multipliers are found anew by Newton's method on scipy's DOP853 with the
variational equations, which shares no code with the library.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns

PERIOD = 2.0 * np.pi / 1.5
START = {"q": 0.0, "w": 1.5}


def pendulum(T: float, m: float) -> ns.System:
    return ns.System(
        states=["q", "w"],
        parameters={"T": T, "m": m},
        drift={"q": "2*pi"},
        period="2*pi/1.5",
        equations={"q": "w", "w": "T*cos(1.5*t) + m - 0.2*w - sin(q)"},
    )


def image(T, m, state, periods):
    """State after some periods with its derivative by the state, by DOP853."""

    def rates(t, y):
        q, w, flow = y[0], y[1], y[2:].reshape(2, 2)
        slope = np.array([[0.0, 1.0], [-np.cos(q), -0.2]])
        own = [w, T * np.cos(1.5 * t) + m - 0.2 * w - np.sin(q)]
        return np.concatenate([own, (slope @ flow).ravel()])

    begin = np.concatenate([state, np.eye(2).ravel()])
    found = solve_ivp(
        rates, (0.0, periods * PERIOD), begin, method="DOP853", rtol=1e-13, atol=1e-13
    )
    return found.y[:2, -1], found.y[2:, -1].reshape(2, 2)


def rotation(T, m, state, periods, turns):
    """Orbit that makes so many turns in some periods, and its multipliers."""
    state = np.array(state)
    for _ in range(8):
        end, tangent = image(T, m, state, periods)
        gap = end - state - [2.0 * np.pi * turns, 0.0]
        state = state - np.linalg.solve(tangent - np.eye(2), gap)
    return state, np.linalg.eigvals(tangent)


LOCKED = [(0.8, 0.42, 1, 1), (1.6, 0.4, 4, 4), (1.6, 0.5, 2, 3)]


@pytest.mark.parametrize(("T", "m", "periods", "turns"), LOCKED)
def test_a_locked_rotation_is_periodic(T, m, periods, turns):
    found = ns.regime(pendulum(T, m), START)
    assert (found["regime"].item(), found["period"].item()) == ("periodic", periods)
    assert found["progresses"].item() == 1
    # strobes repeat to the match of 1e-6 of a few radians
    assert found["q_per_period"].item() == pytest.approx(2 * np.pi * turns / periods, abs=1e-6)
    assert f"q makes {turns} turn" in found.attrs["message"]


@pytest.mark.parametrize(("T", "m", "periods", "turns"), LOCKED)
def test_orbits_close_up_to_whole_turns(T, m, periods, turns):
    system = pendulum(T, m)
    orbit = ns.find_orbit(system, START, transient=1000, period=periods)
    assert orbit.attrs["status"] == "completed"
    here = [float(orbit["q"]), float(orbit["w"])]
    state, multipliers = rotation(T, m, here, periods, turns)
    # DOP853 at 1e-13 over four periods, and Newton's method on it, are good to some 1e-12; the
    # orbit of four periods amplifies that in its multipliers by tens
    assert np.abs(state - here).max() < 1e-10
    own = np.sort_complex(orbit["multipliers"].values)
    assert np.abs(own - np.sort_complex(multipliers.astype(complex))).max() < 1e-9
    assert orbit["drift"].values / (2 * np.pi) == pytest.approx([turns], abs=1e-14)
    assert -np.pi <= here[0] <= np.pi


def test_a_diagram_shows_rotations_as_points():
    found = ns.bifurcation_diagram(
        pendulum(0.8, 0.35), "m", [0.35, 0.42, 0.45], transient=600, record=40, initial=START
    )
    assert found["period"].values.ravel().tolist() == [1, 1, 1]
    turns = found["q_per_period"].values.ravel() / (2 * np.pi)
    assert turns == pytest.approx([0.0, 1.0, 1.0], abs=1e-9)
    assert np.ptp(found["q"].values, axis=-1).max() < 1e-6


def test_a_diagram_that_follows_takes_angles_from_near_zero():
    found = ns.bifurcation_diagram(
        pendulum(0.8, 0.42), "m", np.linspace(0.42, 0.45, 4), transient=300, record=40,
        initial=START, start="follow up",
    )  # fmt: skip
    assert found["period"].values.ravel().tolist() == [1, 1, 1, 1]
    assert np.abs(found["q"].values).max() < 2 * np.pi


def test_a_branch_of_rotations_turns_at_a_fold():
    system = pendulum(0.8, 0.45)
    orbit = ns.find_orbit(system, START, transient=600)
    branch = ns.continue_orbit(system, "m", (0.3, 0.6), initial=orbit)
    fold = int(branch["special_point"].values[branch["special_kind"].values == "fold"][0])
    there = branch.isel(point=fold)
    state, _ = rotation(0.8, 0.45, [float(orbit["q"]), float(orbit["w"])], 1, 1)
    assert np.abs(state - [float(orbit["q"]), float(orbit["w"])]).max() < 1e-12
    # at the fold the map of DOP853 closes, and one multiplier is 1
    end, tangent = image(0.8, float(there["m"]), [float(there["q"]), float(there["w"])], 1)
    gap = end - [float(there["q"]) + 2 * np.pi, float(there["w"])]
    assert np.abs(gap).max() < 1e-10
    assert np.abs(np.linalg.eigvals(tangent) - 1.0).min() < 1e-5  # a fold is found to 1e-10 in m


def test_the_branch_that_a_doubling_sheds_makes_twice_the_turns():
    system = pendulum(0.8, 0.45)
    orbit = ns.find_orbit(system, START, transient=600)
    branch = ns.continue_orbit(system, "T", (0.3, 2.0), initial=orbit)
    flip = int(np.flatnonzero(branch["special_kind"].values == "flip")[0])
    doubled = ns.continue_orbit(system, "T", (0.3, 2.0), initial=branch, special=flip)
    assert doubled["drift"].values[:, 0] / (2 * np.pi) == pytest.approx(2.0, abs=1e-14)


def test_a_rotation_without_forcing_has_its_period_in_closed_form():
    """q' = m - sin(q) turns once in 2 pi / sqrt(m^2 - 1)."""
    system = ns.System(
        states=["q", "y"],
        parameters={"m": 1.25},
        drift={"q": "2*pi"},
        equations={"q": "m - sin(q)", "y": "-0.1*y"},
    )
    orbit = ns.find_orbit(system, {"q": 0.3, "y": 0.0})
    length = 2 * np.pi / 0.75
    assert float(orbit["length"]) == pytest.approx(length, rel=1e-13)
    assert orbit["multipliers"].values == pytest.approx([np.exp(-0.1 * length)], rel=1e-12)
    assert float(orbit["q_per_time"]) == pytest.approx(0.75, rel=1e-13)


def test_one_angle_alone_is_a_limit_cycle():
    system = ns.System(
        states=["q"], parameters={"m": 1.25}, drift={"q": "2*pi"}, equations={"q": "m - sin(q)"}
    )
    assert ns.regime(system, {"q": 0.3}, period=1.0)["regime"].item() == "limit-cycle"


def test_attractors_tell_how_far_angles_turn():
    found = ns.attractors(pendulum(1.6, 0.5), {"q": (-3, 3), "w": (-2, 3)}, samples=20)
    assert set(found["kind"].values.tolist()) == {"periodic"}
    turns = found["period"].values * found["q_per_iterate"].values / (2 * np.pi)
    assert np.abs(turns - np.rint(turns)).max() < 1e-9
    for k, period in enumerate(found["period"].values.tolist()):
        end, _ = image(1.6, 0.5, found["points"].values[k, 0], period)
        gap = end - found["points"].values[k, 0] - [2 * np.pi * round(turns[k]), 0.0]
        assert np.abs(gap).max() < 1e-9


def test_an_upright_pendulum_is_one_attractor():
    """It rests at q = pi, where a circle from -pi to pi would be cut open."""
    system = ns.System(
        states=["q", "w"],
        drift={"q": "2*pi"},
        period="2*pi/20",
        equations={"q": "w", "w": "-(1 - 45*cos(20*t))*sin(q) - 0.4*w"},
    )
    found = ns.attractors(system, {"q": (-3.1, 3.1), "w": (-1, 1)}, samples=30)
    assert found["period"].values.tolist() == [1, 1]
    assert np.abs(np.abs(found["points"].values[:, 0, 0]) - [0.0, np.pi]).max() < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("method", ["recurrences", "cell mapping", "generalised cell mapping"])
def test_basins_agree_with_an_integration_of_their_own(method):
    T, m = 0.8, 0.42  # borders are wide apart, so that a point of a cell speaks for it
    grid = {"q": np.linspace(-np.pi, np.pi, 31)[:-1], "w": np.linspace(-2.0, 3.0, 25)}
    found = ns.basins_of_attraction(pendulum(T, m), grid, method=method)
    labels, turns = found["label"].values, found["q_per_iterate"].values / (2 * np.pi)
    rng, wrong = np.random.default_rng(0), 0
    for _ in range(20):
        i, j = rng.integers(30), rng.integers(25)
        motion = solve_ivp(
            lambda t, y: [y[1], T * np.cos(1.5 * t) + m - 0.2 * y[1] - np.sin(y[0])],
            (0.0, 120 * PERIOD), [grid["q"][i], grid["w"][j]], method="DOP853", rtol=1e-10,
            atol=1e-10, t_eval=[80 * PERIOD, 120 * PERIOD],
        )  # fmt: skip
        mean = (motion.y[0, 1] - motion.y[0, 0]) / (80 * np.pi)
        wrong += abs(mean - turns[labels[j, i] - 1]) > 0.05
    # mappings of cells take a cell for its centre, or for the most of its points: on a border of
    # basins one in twenty may be off, and a grid of random labels would be off in ten
    assert wrong <= (0 if method == "recurrences" else 1)


@pytest.mark.slow
@pytest.mark.parametrize("turns", [0, 1, 2])
def test_the_border_of_rest_and_rotation_is_found_from_any_turn(turns):
    """Its saddle is one of scipy, with the multipliers of its variational equations."""
    system = pendulum(0.8, 0.42)
    begin = {"q": 2 * np.pi * turns, "w": 0.0}
    edge = ns.edge_state(system, begin, {"q": 0.0, "w": 1.5})
    assert (edge["kind"].item(), edge["period"].item()) == ("periodic", 1)
    assert edge["outcome"].values.tolist() == ["periodic", "periodic"]
    here = [float(edge["q"][0]), float(edge["w"][0])]
    state, multipliers = rotation(0.8, 0.42, here, 1, 0)
    # the map multiplies an error of 1e-13 of DOP853 by 35
    assert np.abs(state - here).max() < 1e-11
    own = np.sort(edge["multipliers"].values.real)
    assert np.abs(own - np.sort(multipliers.real)).max() < 1e-9


@pytest.mark.slow
def test_the_border_of_two_rotations_is_a_rotation():
    system = pendulum(0.8, 0.42)
    found = ns.attractors(system, {"q": (-3, 3), "w": (-2, 3)}, samples=20)
    edge = ns.edge_state(system, found.sel(attractor=2), found.sel(attractor=3))
    assert edge["kind"].item() == "periodic"
    here, period = np.array([float(edge["q"][0]), float(edge["w"][0])]), edge["period"].item()
    end, tangent = image(0.8, 0.42, here, period)
    turns = (end - here)[0] / (2 * np.pi)
    assert round(turns) > 0
    gap = end - here - [2 * np.pi * round(turns), 0.0]
    largest = np.abs(np.linalg.eigvals(tangent)).max()
    assert largest > 1.0
    assert np.abs(gap).max() < 1e-11 * largest  # an error of 1e-13 of DOP853 grows by that


@pytest.mark.slow
def test_a_picture_has_one_branch_where_the_vertical_turns():
    """In q - s nothing depends on s: one motion, which s takes along for more than a turn."""
    tilted = ns.System(
        states=["q", "w"],
        parameters={"s": 0.0},
        drift={"q": "2*pi"},
        period="2*pi/1.5",
        equations={"q": "w", "w": "0.3*cos(1.5*t) - 0.4*w - sin(q - s)"},
    )
    found = ns.bifurcation_picture(
        tilted, "s", (-4, 5), {"q": (-3, 3), "w": (-1, 1)}, columns=5, samples=6, searches=0,
        longest=1,
    )  # fmt: skip
    assert found.sizes["branch"] == 1
    assert found["period"].values.tolist() == [[1]] * 5


@pytest.mark.parametrize(("T", "m", "periods", "turns"), LOCKED)
def test_local_regimes_take_angles_that_are_whole_turns_apart_for_one(T, m, periods, turns):
    run = ns.simulate(pendulum(T, m), START, periods=600, samples_per_period=1)
    run = run.isel(time=slice(300, None))
    more = np.random.default_rng(0).integers(-3, 4, run.sizes["time"])
    run["q"] = run["q"] + 2 * np.pi * more
    assert ns.local_regimes(run)["stretch_period"].values.tolist() == [periods]
