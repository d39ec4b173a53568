"""Manifolds of saddles of a pendulum, whose angle counts up to whole turns.

Motions are those of scipy's DOP853, forwards and backwards, of which no part is the library's.
"""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns

OMEGA = 1.5
PERIOD = 2.0 * np.pi / OMEGA
TURN = 2.0 * np.pi


def pendulum(T: float, m: float = 0.0, d: float = 0.2) -> ns.System:
    return ns.System(
        states=["q", "w"],
        parameters={"T": T, "m": m, "d": d},
        drift={"q": "2*pi"},
        period="2*pi/1.5",
        equations={"q": "w", "w": "T*cos(1.5*t) + m - d*w - sin(q)"},
    )


def moved(system: ns.System, state, periods: int):
    """The state after some periods, or so many before."""
    T, m, d = (system.parameter_values[name] for name in ("T", "m", "d"))
    found = solve_ivp(
        lambda t, y: [y[1], T * np.cos(OMEGA * t) + m - d * y[1] - np.sin(y[0])],
        (0.0, periods * PERIOD), state, method="DOP853", rtol=1e-13, atol=1e-13,
    )  # fmt: skip
    return found.y[:, -1]


def upright(system: ns.System, turns: int = 0):
    """The saddle that swings around q = pi."""
    sway = system.parameter_values["T"] / (1.0 + OMEGA**2)
    return ns.find_orbit(system, {"q": np.pi - sway + turns * TURN, "w": 0.0})


@pytest.fixture(scope="module")
def rotation():
    """The saddle on the border of two rotations, which itself turns over once per period."""
    system = pendulum(0.8, 0.42)
    # on one side there is one turn in each period, on the other there are ten in eight
    sides = {"q": 0.0, "w": 1.5}, {"q": 2.58242207, "w": 1.69921339}
    return system, ns.edge_state(system, *sides)


@pytest.mark.slow
def test_an_edge_state_tells_how_far_it_turns(rotation):
    _, edge = rotation
    assert edge["period"].item() == 1
    assert float(edge["q_per_iterate"]) == pytest.approx(TURN, rel=1e-12)


def test_the_unstable_manifold_of_a_rotation_comes_from_it(rotation):
    system, edge = rotation
    orbit = ns.find_orbit(system, edge.isel(point=0))
    found = ns.manifold(system, orbit, length=3.0)
    assert float(found["q_per_iterate"]) == pytest.approx(TURN, rel=1e-15)
    saddle = found["saddle"].values[0]
    assert np.abs(saddle - [float(orbit["q"]), float(orbit["w"])]).max() < 1e-12
    for image in (1, 2, 3):
        at = found.isel(point=np.flatnonzero(found["image"].values == image)[-1])
        back = moved(system, [float(at["q"]), float(at["w"])], -image)
        back += np.array([image * TURN, 0.0])
        curve = int(at["curve_of_point"])
        along = found["saddle_direction"].values[curve]
        along = along / np.linalg.norm(along)
        away = back - saddle
        # backwards, errors of 1e-13 grow by 1/0.12 in each period; the first piece is off by 1e-11
        assert abs(away[0] * along[1] - away[1] * along[0]) < 1e-9
        assert 0.0 < away @ along <= float(found["first_length"][curve]) + 1e-9


@pytest.mark.slow
def test_the_stable_manifold_of_a_rotation_comes_to_it(rotation):
    system, edge = rotation
    orbit = ns.find_orbit(system, edge.isel(point=0))
    found = ns.manifold(system, orbit, which="stable", length=3.0)
    saddle = found["saddle"].values[0]
    for image in (1, 2, 3):
        at = found.isel(point=np.flatnonzero(found["image"].values == image)[0])
        onto = moved(system, [float(at["q"]), float(at["w"])], image) - [image * TURN, 0.0]
        along = found["saddle_direction"].values[int(at["curve_of_point"])]
        along = along / np.linalg.norm(along)
        away = onto - saddle
        # forwards they grow by 3.6; points are put onto the manifold to the deviation of 1e-11
        assert abs(away[0] * along[1] - away[1] * along[0]) < 1e-9
        assert np.linalg.norm(away) < 0.31


@pytest.mark.slow
def test_motions_from_one_top_come_to_the_next_one():
    """An undamped pendulum that is not driven would just reach it."""
    system = pendulum(1.6)
    orbit = upright(system, 1)
    found = ns.homoclinic_points(system, orbit, length=9.0, largest_step=0.05)
    assert found.attrs["unrefined"] == 0 and found.attrs["n_orbits"] == 4
    saddle = np.array([float(orbit["q"]), float(orbit["w"])])
    assert set(np.abs(found["q_turns"].values).tolist()) == {1}
    for k in range(found.sizes["crossing"]):
        at = found.isel(crossing=k)
        state = np.array([float(at["q"]), float(at["w"])])
        before = moved(system, state, -int(at["images"]))
        after = moved(system, state, int(at["ahead"]))
        # both are on the straight first pieces, some 1e-5 long, but for errors of 1e-13 that the
        # multipliers of 39 and 1/90 make 1e-5 in four periods, or 1e-3 backwards in five
        there = saddle + np.array([float(at["q_turns"]) * TURN, 0.0])
        assert np.abs(before - saddle).max() < 1e-2
        assert np.abs(after - there).max() < 1e-3


@pytest.mark.slow
def test_tops_are_joined_from_the_force_of_melnikov_on():
    """T = 4 d cosh(pi omega / 2) / pi, to second order in the damping d."""
    off = []
    for d in (0.03, 0.02):
        force = 4.0 * d / np.pi * np.cosh(np.pi * OMEGA / 2.0)
        system = pendulum(force, d=d)
        found = ns.homoclinic_tangency(
            system, "T", (0.8 * force, 1.2 * force), upright(system), length=8.0, side="+",
            largest_step=0.05, bumps=2,
        )  # fmt: skip
        off.append(abs(float(found["T"][0]) / force - 1.0))
    assert off[1] < 0.02**2
    assert off[0] == pytest.approx(2.25 * off[1], rel=0.1)


def test_a_picture_shows_one_turn():
    system = pendulum(1.6)
    found = ns.manifold(system, upright(system), length=9.0, largest_step=0.05)
    assert np.ptp(found["q"].values) > TURN
    ax = ns.plot.manifold(found, within_turn=True)
    assert ax.get_xlim() == pytest.approx((-np.pi, np.pi))
    drawn = np.concatenate([line.get_xdata() for line in ax.get_lines()])
    drawn = drawn[np.isfinite(drawn)]
    # steps over the end of the turn are drawn at both ends
    assert np.all((drawn > -np.pi - 0.051) & (drawn < np.pi + 0.051))
    plt.close(ax.figure)
