"""At an event the state is put on the guard by what moved there, and by no more than rounding."""

import mpmath as mp
import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, System

ROUNDING = 1e-14  # some units in the last place of states of size 1 to 5


def jumps(run):
    """Largest change of a state at an event."""
    return float(np.abs(run["state_after"] - run["state_before"]).max())


def test_a_product_of_both_states():
    """x v changes sign at x = 0 and at v = 0; the gradient of the other factor is rounding."""
    same = {"x": "v", "v": "-x"}
    a, b = Mode(same, exits=[Exit("x*v", to="b")]), Mode(same, exits=[Exit("-x*v", to="a")])
    run = ns.simulate(
        System(states=["x", "v"], modes={"a": a, "b": b}), {"x": 1, "v": 0.5}, t_end=9
    )
    # sin(t + p) and cos(t + p) with tan(p) = 1/0.5 vanish every quarter of a turn
    first = np.pi - np.arctan2(1.0, 0.5)
    times = np.sort(
        np.concatenate([first + np.pi * np.arange(3), first + np.pi * (np.arange(3) - 0.5)])
    )
    assert run["event_time"].values[1:] == pytest.approx(times[times > 0], abs=1e-13)
    assert jumps(run) < ROUNDING
    assert run["end_state"].values == pytest.approx(
        [np.cos(9) + 0.5 * np.sin(9), 0.5 * np.cos(9) - np.sin(9)], abs=1e-13
    )


@pytest.mark.parametrize("share", ["1e-20", "1e-16", "1e-12", "1e-8", "1e-5", "0"])
def test_a_guard_led_by_time(share):
    """cos(3 t) + share x with x = t: at 1e-12 the state must not make up for a rounding of t."""
    first = Mode({"x": "1"}, exits=[Exit(f"cos(3*t) + {share}*x", to="b")])
    run = ns.simulate(System(states=["x"], modes={"a": first, "b": Mode({"x": "1"})}), t_end=2)
    with mp.workdps(30):
        time = mp.findroot(lambda t: mp.cos(3 * t) + mp.mpf(share) * t, 0.5)
    assert float(run["event_time"][1]) == pytest.approx(float(time), abs=1e-15)
    assert run["end_state"].item() == pytest.approx(2.0, abs=1e-15)


def test_a_factor_in_the_guard():
    """A ball above x (1 + v/2) lands where x = 0, not where v = -2."""
    for factor in ("1 + 0.5*v", "1 + 0.5*v**2"):
        bounce = Exit(f"x*({factor})", to="air", reset={"v": "-0.8*v"})
        ball = System(
            states=["x", "v"], modes={"air": Mode({"x": "v", "v": "-9.81"}, exits=[bounce])}
        )
        run = ns.simulate(ball, {"x": 0.1}, t_end=0.75)
        speed = np.sqrt(2 * 9.81 * 0.1)
        # 1 + v/2 vanishes on the way down from higher speeds, which are not reached here
        after = run["state_after"].sel(state="v").values[1:]
        assert after == pytest.approx(speed * 0.8 ** np.arange(1, after.size + 1), abs=1e-13)
        assert after.size >= 2


@pytest.mark.parametrize(
    ("rate", "truth"),
    [
        # x' = cos(t)(2 + x) until pi/2: x = 2 exp(sin t) - 2, then rest
        ("max(cos(t)*(2 + x), 0)", 2 * np.e - 2),
        # the mean value of |cos| acts; the truth is that of scipy below
        ("abs(cos(1.3*t)/(2 + x**2)) - x", None),
    ],
)
def test_texts_switched_by_time(rate, truth):
    run = ns.simulate(System(states=["x"], equations={"x": rate}), t_end=3)
    if truth is None:
        truth = by_pieces(lambda t, x: abs(np.cos(1.3 * t) / (2 + x**2)) - x, np.pi / 2.6)
    assert run["end_state"].item() == pytest.approx(truth, abs=1e-11)
    assert run.attrs["n_uncertain"] == 0


def by_pieces(rate, switch):
    """State at 3 from 0, by scipy on both sides of the switch."""
    from scipy.integrate import solve_ivp

    x = [0.0]
    for span in ((0.0, switch), (switch, 3.0)):
        x = solve_ivp(rate, span, x, method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    return float(x[0])


@pytest.mark.parametrize("force", ["-x*(1 - 0.02*v)", "-x*exp(0.1*v)", "-x*(2 + v**2)", "-x"])
def test_release_onto_the_next_guard(force):
    """Where the contact force vanishes the flight begins on its own guard, whatever the law."""
    flight = Mode({"x": "v", "v": "-9.81"}, exits=[Exit("x", to="contact")])
    contact = Mode({"x": "v", "v": "-9.81 - 1e3*x*(1 - 0.02*v)"}, exits=[Exit(force, to="flight")])
    ball = System(states=["x", "v"], modes={"flight": flight, "contact": contact})
    for height in np.linspace(0.9, 1.1, 21):
        run = ns.simulate(ball, {"x": height}, t_end=3)
        assert run.attrs["status"] == "completed", (force, height)
        assert run.attrs["n_events"] >= 6
        assert jumps(run) < ROUNDING
