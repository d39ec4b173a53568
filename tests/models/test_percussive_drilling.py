"""Percussive drilling against its closed forms, stitched with 40 digits by code of its own."""

import numpy as np
import pytest
from mpmath import mp

import nonsmooth as ns
from nonsmooth.models import percussive_drilling, progression

EPS = np.finfo(float).eps


def gained(t, t0, net, a):
    """Velocity gained under a constant force and a cos t."""
    return net * (t - t0) + a * (mp.sin(t) - mp.sin(t0))


def moved(t, t0, y0, net, a):
    """Displacement under the same force."""
    s = t - t0
    return y0 * s + net * s * s / 2 + a * (mp.cos(t0) - mp.cos(t) - s * mp.sin(t0))


def first_root(function, began, ended):
    """First root after began of a function that is not zero just behind it; ended without one."""
    step = mp.mpf("0.002")
    low = began + step
    while low < ended:
        if function(low) * function(low + step) <= 0:
            return mp.findroot(function, (low, low + step), solver="anderson", tol=mp.mpf("1e-60"))
        low += step
    return ended


def end_of_stick(a, b, t0):
    """Next time at which the force falls to zero or rises to one, and the mode behind it."""
    coming = []
    for level, side, mode in ((0, 1, "flight"), (1, -1, "progression")):
        if abs(level - b) < a:
            angle = side * mp.acos((level - b) / a)
            coming.append((angle + 2 * mp.pi * mp.ceil((t0 - angle) / (2 * mp.pi)), mode))
    return min(coming)


def drilled(a, b, periods):
    """Switches (mode, time) and progression at each period, for omega = 1 and from rest.

    Angles of slip and lift-off are arc cosines; the ends of a progression and of a flight are
    roots of a velocity and of a displacement that are explicit in time.
    """
    a, b = mp.mpf(a), mp.mpf(b)
    end = 2 * mp.pi * periods
    time, y, v = mp.mpf(0), mp.mpf(0), mp.mpf(0)
    mode = "progression" if a + b > 1 else "stick"
    log, gains = [], [0.0]
    while time < end:
        t0, y0, left = time, y, mode
        if mode == "stick":
            time, mode = end_of_stick(a, b, t0)
        elif mode == "flight":
            time = first_root(lambda t, t0=t0: moved(t, t0, 0, b, a), t0, end)
            y, mode = gained(time, t0, b, a), "progression"
        else:
            time = first_root(lambda t, t0=t0, y0=y0: y0 + gained(t, t0, b - 1, a), t0, end)
            y, mode = mp.mpf(0), "flight" if b + a * mp.cos(time) < 0 else "stick"
        for k in range(
            len(gains), int(mp.floor(min(time, end) / (2 * mp.pi) + mp.mpf("1e-30"))) + 1
        ):
            turn = 2 * mp.pi * k
            gains.append(float(v + (left == "progression") * moved(turn, t0, y0, b - 1, a)))
        v += (left == "progression") * moved(time, t0, y0, b - 1, a)
        if time < end:
            log.append((mode, float(time)))
    return log, gains


CASES = [
    (0.3, 0.15),  # flight, progression, stick
    (0.5, 0.6),  # never lifted off
    (1.0, 0.9),  # an impact at first, slip later
    (1.0, 0.5),  # no stick
    (0.3, 0.05),  # two motions of flight to a period
]


@pytest.mark.slow
@pytest.mark.parametrize(("a", "b"), CASES)
@pytest.mark.parametrize("omega", [1.0, 0.1])
def test_switches_and_progression(a, b, omega):
    periods = 5
    with mp.workdps(40):
        log, gains = drilled(a, b, periods)
    run = ns.simulate(percussive_drilling(a, b, omega), periods=periods, samples_per_period=1)
    names = ["flight", "progression", "stick"]
    assert [names[to] for to in run["event_to"].values[1:]] == [mode for mode, _ in log]
    # errors of a switch pass on to the next one, some tens of times larger in five periods
    times = run["event_time"].values[1:] * omega
    assert np.abs(times - [time for _, time in log]).max() < 1000 * EPS * 2 * np.pi * periods
    assert np.abs(run["v"].values * omega**2 - gains).max() < 1000 * EPS * max(1.0, gains[-1])


@pytest.mark.parametrize(("a", "b"), CASES)
def test_frequency_is_a_scale(a, b):
    """Powers of two scale without any rounding but in the sines."""
    runs = {
        omega: ns.simulate(percussive_drilling(a, b, omega), periods=6, samples_per_period=8)
        for omega in (1.0, 0.25, 4.0)
    }
    for omega in (0.25, 4.0):
        for name, power in (("p", 2), ("y", 1), ("v", 2)):
            scaled = runs[omega][name].values * omega**power
            exact = runs[1.0][name].values
            assert np.abs(scaled - exact).max() < 1000 * EPS * max(1.0, np.abs(exact).max())


def test_what_is_not_lifted_off_has_a_closed_form():
    """With b above a: slip at f = 1, and a first integral that is zero again at the stop."""
    a, b = 0.5, 0.6
    with mp.workdps(40):
        slip = -mp.acos((1 - mp.mpf(b)) / mp.mpf(a))
        stop = mp.findroot(
            lambda t: (b - 1) * (t - slip) + a * (mp.sin(t) - mp.sin(slip)), mp.mpf(1.13)
        )
        gain = float(
            mp.quad(lambda t: (b - 1) * (t - slip) + a * (mp.sin(t) - mp.sin(slip)), [slip, stop])
        )
    run = ns.simulate(percussive_drilling(a, b, 1.0), periods=10)
    assert run.attrs["phase_word"] == "progression stick progression"
    assert float(progression(run, periods=3)["per_period"]) == pytest.approx(gain, rel=1e-13)


def test_without_stick_the_share_of_contact_is_the_static_force():
    """Momentum over a period: the slider pushes back with one, the static force with b."""
    a, b = 0.9, 0.3
    run = ns.simulate(percussive_drilling(a, b, 1.0), periods=300)
    late = run["event_time"].values > 250 * run.attrs["period"]
    times, entered = run["event_time"].values[late], run["event_to"].values[late]
    assert set(entered) == {0, 1}
    first, last = np.flatnonzero(entered == 1)[[0, -1]]
    spent = np.diff(times[first : last + 1])
    share = spent[entered[first:last] == 1].sum() / spent.sum()
    assert share == pytest.approx(b, abs=1e-12)


def test_a_force_between_zero_and_the_limit_moves_nothing():
    run = ns.simulate(percussive_drilling(0.3, 0.5, 1.0), periods=5)
    assert run.attrs["n_events"] == 0
    assert not run["v"].values.any() and not run["y"].values.any()
    assert np.allclose(
        run["slider_force"].values, 0.5 + 0.3 * np.cos(run["time"].values), atol=1e-13
    )


def test_slider_only_pushes_and_never_comes_back():
    run = ns.simulate(percussive_drilling(1.5, 0.13, 1.0), periods=200, samples_per_period=50)
    force = run["slider_force"].values
    assert force.min() >= 0.0 and force.max() <= 1.0
    assert np.all(run["p"].values <= 0.0)
    assert np.diff(run["v"].values).min() > -8 * EPS * run["v"].values[-1]


def test_impossible_frequency_is_refused():
    with pytest.raises(ns.ModelError, match="omega >"):
        percussive_drilling(omega=0.0)


def by_surface(a, b, omega):
    """The drill with a stick that nobody wrote: friction of 0 or 1 switches with the velocity."""
    return ns.System(
        states=["p", "y", "v"],
        drift=["v"],
        period="2*pi/omega",
        parameters={"a": a, "b": b, "omega": omega},
        definitions={"f": "b + a*cos(omega*t)", "R": "heaviside(speed)"},
        outputs={"slider_force": "R"},
        surfaces={"speed": ns.Surface("y")},
        modes={
            "flight": ns.Mode(
                {"p": "y", "y": "f", "v": "0"},
                definitions={"R": "0"},
                exits=[ns.Exit("-p", to="contact")],
            ),
            "contact": ns.Mode(
                {"y": "f - R", "v": "y"},
                slaved={"p": "0"},
                cells={"+": "progression", "0": "stick", "-": "backward"},
                exits=[ns.Exit("y", to="flight")],
            ),
        },
    )


@pytest.mark.parametrize(("a", "b"), CASES)
def test_stick_is_filippovs(a, b):
    """The convex combination of both sides holds the bit while 0 <= f <= 1, and is f."""
    periods = 6
    hand = ns.simulate(percussive_drilling(a, b, 1.0), periods=periods, samples_per_period=40)
    found = ns.simulate(
        by_surface(a, b, 1.0), mode="contact", periods=periods, samples_per_period=40
    )
    assert found.attrs["status"] == "completed"
    assert ns.phase_word(found) == ns.phase_word(hand)
    assert found["event_time"].values == pytest.approx(hand["event_time"].values, abs=1e-11)
    for name in ("p", "y", "v"):
        assert np.abs(found[name].values - hand[name].values).max() < 1e-11
    force = hand["slider_force"].values
    assert found["slider_force"].values == pytest.approx(force, abs=1e-11)
