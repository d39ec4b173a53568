"""A branch passes the corner of two surfaces, which are crossed in the other order beyond it.

A block on a belt that is held by two coupled springs: it loses the contact and comes back to it,
slower or faster than the belt (mode coupling, as of a brake that squeals).
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.periodic_orbits import branch_change

VALUES = {"c": 0.02, "k11": 2.1, "k12": 0.4, "k22": 1.0, "kc": 1.2, "F0": 0.3}


def brake(mu: float, vb: float) -> ns.System:
    return ns.System(
        states=["x", "vx", "y", "vy"],
        parameters=VALUES | {"mu": mu, "vb": vb},
        initial={"y": 0.2, "x": 0.1},
        definitions={"N": "kc*max(y, 0)"},
        equations={
            "x": "vx",
            "vx": "-c*vx - k11*x - k12*y - mu*N*sign(slip)",
            "y": "vy",
            "vy": "-c*vy - k12*x - k22*y - N + F0",
        },
        surfaces={"slip": ns.Surface("vx - vb", below="slip", on="stick", above="over")},
    )


def after_a_turn(mu: float, vb: float, state: np.ndarray, length: float) -> np.ndarray:
    """State a turn later by DOP853, piece by piece between crossings of both surfaces."""
    c, k11, k12, k22, kc, F0 = VALUES.values()

    def slip(t, u, *_):
        return u[1] - vb

    def contact(t, u, *_):
        return u[2]

    def rates(t, u, slides, touches):
        x, vx, y, vy = u
        N = kc * y if touches > 0 else 0.0
        return [
            vx,
            -c * vx - k11 * x - k12 * y - mu * N * slides,
            vy,
            -c * vy - k12 * x - k22 * y - N + F0,
        ]

    def piece(begin, end, u, signs, events):
        run = solve_ivp(
            rates, (begin, end), u, args=signs, events=events, method="DOP853", rtol=1e-12,
            atol=1e-14,
        )  # fmt: skip
        return run.t[-1], run.y[:, -1], run.t_events

    slip.terminal = contact.terminal = True
    t, u = 0.0, np.array(state)
    ahead = u + 1e-7 * np.array(rates(0.0, u, np.sign(slip(0, u)), u[2]))
    signs = [np.sign(slip(0, ahead)), np.sign(contact(0, ahead))]
    while t < length:
        t, u, _ = piece(t, min(t + 1e-6, length), u, signs, None)  # away from the last surface
        t, u, crossed = piece(t, length, u, signs, [slip, contact])
        signs = [-sign if len(at) else sign for sign, at in zip(signs, crossed, strict=True)]
    return u


@pytest.mark.parametrize("mu", [0.8577, 0.8578, 0.88])
def test_contact_and_belt_in_either_order(mu):
    system = brake(0.855, 0.5)
    orbit = ns.find_orbit(system, transient=30)
    branch = ns.continue_orbit(system, "mu", (0.8, mu), initial=orbit, direction="up")
    assert branch.attrs["end_last"] == "bound"
    kinds = branch["special_kind"].values.tolist()
    assert kinds == (["bound"] if mu == 0.8577 else ["corner", "bound"])
    last = branch.isel(point=-1)
    state = np.array([float(last[name]) for name in system.states])
    # rounding of DOP853 at 1e-12, and what its steps make of it over a turn
    assert after_a_turn(mu, 0.5, state, float(last["length"])) == pytest.approx(state, abs=1e-9)


def test_slides_and_corners_close_to_each_other():
    """Four changes of the word within a thousandth of the belt's speed."""
    system = brake(0.6, 0.25)
    orbit = ns.find_orbit(system, transient=30)
    branch = ns.continue_orbit(system, "vb", (0.21, 0.6), initial=orbit, direction="down")
    assert branch.attrs["end_first"] == "bound"
    kinds = branch["special_kind"].values.tolist()
    assert kinds == ["bound", "crossing_sliding", "corner", "switching_sliding", "grazing_sliding"]
    first = branch.isel(point=0)
    state = np.array([float(first[name]) for name in system.states])
    assert after_a_turn(0.6, 0.21, state, float(first["length"])) == pytest.approx(state, abs=1e-9)


def test_the_motion_beyond_is_followed_where_no_change_is_known(monkeypatch):
    """As it is for a driven orbit: the cycle that joins the last one is found all the same."""
    monkeypatch.setattr(branch_change, "changes_of_word", lambda *_: [])
    system = brake(0.855, 0.5)
    orbit = ns.find_orbit(system, transient=30)
    branch = ns.continue_orbit(system, "mu", (0.8, 0.88), initial=orbit, direction="up")
    assert branch.attrs["end_last"] == "bound"
    assert "the branch goes on" in branch["special_detail"].values[0]
    last = branch.isel(point=-1)
    state = np.array([float(last[name]) for name in system.states])
    assert after_a_turn(0.88, 0.5, state, float(last["length"])) == pytest.approx(state, abs=1e-9)
