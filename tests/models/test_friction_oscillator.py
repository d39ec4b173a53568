"""The friction oscillator against its free decay, Den Hartog's motion and hand-written modes."""

from fractions import Fraction
from itertools import groupby

import numpy as np
import pytest
from mpmath import mp

import nonsmooth as ns
from models.friction_truth import Leg, followed
from nonsmooth.models import friction_oscillator

EPS = np.finfo(float).eps


def kinds(run) -> list[str]:
    return [str(kind) for kind in run["event_kind"].values]


# ---------------------------------------------------------------- free decay


@pytest.mark.parametrize(("f", "x"), [(0.1, 1.05), (0.3, 10.0), (0.01, 3.017), (0.2, 0.1)])
def test_free_decay_loses_twice_the_limit_per_half_cycle_and_stops(f, x):
    limit, exact = Fraction(f), [Fraction(x)]
    while abs(exact[-1]) > limit:
        left = abs(exact[-1]) - 2 * limit
        exact.append(-left if exact[-1] > 0 else left)
    turns = [float(each) for each in exact]
    count = len(turns) - 1
    run = ns.simulate(friction_oscillator(f=f, a=0), {"x": x}, t_end=(count + 3) * np.pi)
    assert kinds(run) == (["start"] + ["switch"] * (count - 1) + ["slide_entry"])[: count + 1]
    # a rounding of the first displacement and of the time at each turning point
    off = 16 * EPS * x * (count + 1)
    assert np.abs(run["state_after"].values[:, 0] - turns).max() < off
    turned = run["event_time"].values / np.pi
    assert np.abs(turned - range(count + 1)).max() <= 16 * EPS * count
    stopped = run["time"].values > run["event_time"].values[-1]
    assert stopped.sum() > 50
    assert np.all(run["v"].values[stopped] == 0.0)
    assert np.all(run["x"].values[stopped] == run["state_after"].values[-1, 0])
    # friction is what balances the spring, not its limit
    assert np.all(run["friction"].values[stopped] == pytest.approx(turns[-1], abs=off))
    assert np.all(run["acceleration"].values[stopped] == 0.0)


def test_free_decay_with_viscous_damping():
    zeta, f, x = 0.05, 0.07, 1.4
    half = np.pi / np.sqrt(1 - zeta**2)
    shrink = np.exp(-zeta * half)
    turns = [x]
    while abs(turns[-1]) > f:
        turns.append(-np.sign(turns[-1]) * ((abs(turns[-1]) - f) * shrink - f))
    run = ns.simulate(friction_oscillator(zeta=zeta, f=f, a=0), {"x": x}, t_end=60)
    assert len(turns) > 4
    assert run["state_after"].values[:, 0] == pytest.approx(turns, abs=1e-14)
    assert run["event_time"].values == pytest.approx(half * np.arange(len(turns)), abs=1e-13)
    assert run["v"].values[-1] == 0.0


def test_a_force_below_the_limit_moves_nothing():
    run = ns.simulate(friction_oscillator(f=0.5, a=0.45), periods=5)
    assert run.attrs["n_events"] == 0
    assert np.all(run["v"].values == 0.0)
    drive = 0.45 * np.cos(0.7 * run["time"].values)
    assert run["friction"].values == pytest.approx(-drive, abs=1e-14)


# ---------------------------------------------------------------- Den Hartog


def den_hartog(omega, f):
    """Amplitude, displacement and velocity at phase zero, and multipliers, for a = 1.

    From the turning point X = V cos(phi) on, with V sin(phi) = -f U; across a turning point
    accelerations differ by twice f, so tangents change by the ratio of both.
    """
    omega, f = mp.mpf(omega), mp.mpf(f)
    half = mp.pi / omega
    V = 1 / (1 - omega**2)
    U = mp.sin(half) / (omega * (1 + mp.cos(half)))
    X = mp.sqrt(V**2 - (f * U) ** 2)
    phase = mp.atan2(-f * U / V, X / V)  # of the force at the upper turning point
    ratio = (X * omega**2 - f) / (X * omega**2 + f)
    c, s = mp.cos(half), mp.sin(half)
    turn = mp.matrix([[c, s], [-ratio * s, ratio * c]])
    values = mp.eig(turn * turn, left=False, right=False)

    def back(t):
        """Displacement and velocity a time t behind the upper turning point."""
        a = X - f - V * mp.cos(phase)
        b = omega * V * mp.sin(phase)
        return (
            f + V * mp.cos(omega * t + phase) + a * mp.cos(t) + b * mp.sin(t),
            -V * omega * mp.sin(omega * t + phase) - a * mp.sin(t) + b * mp.cos(t),
        )

    since = mp.fmod(-phase, 2 * mp.pi) / omega  # until the force has phase zero
    since += 2 * half if since < 0 else 0
    x, v = back(since) if since <= half else tuple(-part for part in back(since - half))
    return float(X), (float(x), float(v)), sorted((complex(z) for z in values), key=by_parts)


def by_parts(z):
    return round(z.real, 9), z.imag


def limit_of_no_stop(omega):
    """Friction, over the force, at which X omega^2 = f."""
    V = 1 / (1 - omega**2)
    U = np.sin(np.pi / omega) / (omega * (1 + np.cos(np.pi / omega)))
    return abs(V) / np.sqrt(U**2 + omega**-4)


@pytest.mark.parametrize(("omega", "f"), [
    (0.7, 0.1), (0.7, 0.3), (0.7, 0.722), (0.85, 0.6), (1.3, 0.2), (1.3, 0.68),
    (2.0, 0.5)])  # fmt: skip
def test_den_hartogs_motion_without_stops(omega, f):
    with mp.workdps(40):
        X, start, multipliers = den_hartog(omega, f)
    orbit = ns.find_orbit(friction_oscillator(omega=omega, f=f))
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    assert set(str(orbit["word"].values).split()) == {"forth", "back"}
    turning = orbit["leg_states"].values[1:]
    assert np.abs(turning[:, 0]) == pytest.approx([X, X], abs=1e-10)
    assert turning[:, 1] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert (float(orbit["x"]), float(orbit["v"])) == pytest.approx(start, abs=1e-10)
    found = sorted(orbit["multipliers"].values.astype(complex), key=by_parts)
    assert np.abs(np.array(found) - multipliers).max() < 1e-8


@pytest.mark.parametrize("omega", [0.7, 1.3])
def test_the_motion_begins_to_stop_where_friction_can_hold_it(omega):
    limit = limit_of_no_stop(omega)
    branch = ns.continue_orbit(
        friction_oscillator(omega=omega, f=0.6 * limit), "f", (0.5 * limit, 1.2 * limit)
    )
    special = dict(
        zip(branch["special_kind"].values.astype(str), branch["special_value"].values, strict=True)
    )
    assert special["crossing_sliding"] == pytest.approx(limit, abs=1e-10)
    just_below = ns.simulate(friction_oscillator(omega=omega, f=limit * (1 - 1e-4)), periods=600)
    above = ns.simulate(friction_oscillator(omega=omega, f=limit * (1 + 1e-2)), periods=600)
    period = just_below.attrs["period"]
    assert "stick" not in ns.phase_word(just_below, 590 * period, 600 * period)
    assert "stick" in ns.phase_word(above, 590 * period, 600 * period)


def stopping(omega, f):
    """Amplitude of the motion with two stops a period, and its multiplier, by Newton's method.

    A half period: stick at X until the force has fallen to X - f at the time t1, then back
    until the velocity is zero at t2, at -X.
    """
    omega, f = mp.mpf(omega), mp.mpf(f)
    V = 1 / (1 - omega**2)

    def stroke(X):
        t1 = mp.acos(X - f) / omega
        a = X - f - V * mp.cos(omega * t1)
        b = omega * V * mp.sin(omega * t1)

        def speed(t):
            return -V * omega * mp.sin(omega * (t1 + t)) - a * mp.sin(t) + b * mp.cos(t)

        low = mp.mpf("0.05")
        while speed(low) < 0:
            low += mp.mpf("0.05")
        t = mp.findroot(speed, (low - mp.mpf("0.05"), low), solver="anderson")
        return f + V * mp.cos(omega * (t1 + t)) + a * mp.cos(t) + b * mp.sin(t)

    X = mp.findroot(lambda X: stroke(X) + X, (mp.mpf(1.40), mp.mpf(1.42)), solver="secant")
    return float(X), float(mp.diff(stroke, X) ** 2)


def test_the_motion_with_two_stops_per_period():
    with mp.workdps(40):
        X, multiplier = stopping(0.7, 0.75)
    orbit = ns.find_orbit(friction_oscillator(f=0.75))
    assert orbit.attrs["status"] == "completed", orbit.attrs["message"]
    assert str(orbit["word"].values) == "forth stick back stick forth"
    assert np.abs(orbit["leg_states"].values[1:, 0]) == pytest.approx([X] * 4, abs=1e-10)
    found = sorted(np.abs(orbit["multipliers"].values))
    assert found == pytest.approx([0.0, multiplier], abs=1e-8)


# ---------------------------------------------------------------- a load that grows

FEENY = {"omega": 1.25, "zeta": 0.015, "f": 1.0, "a": 1.9, "k": 1.5}


def by_hand(omega, zeta, f, a, k) -> dict[str, Leg]:
    """Modes of the oscillator, with the mass held by hand where friction can hold it."""

    def load(x):
        return 1 + k * x

    def pull(t, x):
        return a * np.cos(omega * t) - x

    def moving(sign, loaded):
        def rates(t, z):
            drag = f * load(z[0]) * sign if loaded else 0.0
            return [z[1], pull(t, z[0]) - 2 * zeta * z[1] - drag]

        return rates

    def stopped(t, z):
        z = np.array([z[0], 0.0])
        if abs(pull(t, z[0])) <= f * load(z[0]):
            return "stick", z
        return ("forth" if pull(t, z[0]) > 0 else "back"), z

    def to(name):
        return lambda t, z: (name, z)

    held = [
        (lambda t, z: f * load(z[0]) - pull(t, z[0]), to("forth")),
        (lambda t, z: f * load(z[0]) + pull(t, z[0]), to("back")),
    ]
    return {
        "forth": Leg(moving(1, True), [(lambda t, z: z[1], stopped)]),
        "back": Leg(
            moving(-1, True),
            [(lambda t, z: -z[1], stopped), (lambda t, z: load(z[0]), to("lifted"))],
        ),
        "lifted": Leg(moving(0, False), [(lambda t, z: -load(z[0]), to("forth"))]),
        "stick": Leg(lambda t, z: [0.0, 0.0], held),
    }


def test_a_load_that_grows_with_the_displacement():
    system = friction_oscillator(**FEENY)
    times = np.linspace(0, 10 * system.period_value, 401)
    run = ns.simulate(system, {"x": 0.5, "v": 0.1}, times=times)
    states, log = followed(by_hand(**FEENY), "forth", [0.5, 0.1], times)
    entered = [name for name, _ in groupby(["forth", *(name for name, _ in log)])]
    assert [name for name, _ in groupby(ns.phase_word(run))] == entered
    assert set(entered) == {"forth", "back", "stick", "lifted"} and len(entered) > 20
    assert np.abs(run["x"].values - states[:, 0]).max() < 1e-9
    assert np.abs(run["v"].values - states[:, 1]).max() < 1e-9


def test_friction_stays_within_its_limit_and_is_the_equivalent_one_in_stick():
    run = ns.simulate(friction_oscillator(**FEENY), periods=200, samples_per_period=200)
    x, v, friction = (run[name].values for name in ("x", "v", "friction"))
    limit = np.maximum(1 + 1.5 * x, 0)
    stuck = (v == 0.0) & (run["acceleration"].values == 0.0)
    assert 1000 < stuck.sum() < 30000
    drive = 1.9 * np.cos(1.25 * run["time"].values)
    assert friction[stuck] == pytest.approx((x - drive)[stuck], abs=1e-11)  # phase of 200 periods
    assert np.all(np.abs(friction) <= limit * (1 + 8 * EPS) + 8 * EPS)
    moving = v != 0.0
    assert friction[moving] == pytest.approx((-limit * np.sign(v))[moving], abs=1e-14)


def test_chaos_of_a_map_with_one_coordinate():
    """Stick leaves one coordinate of two: nothing is left of the other."""
    found = ns.lyapunov_spectrum(friction_oscillator(**FEENY), transient=100, record=400)
    first, second = found["lyapunov_exponent"].values
    assert first > 10 * found["standard_error"].values[0] > 0
    assert second == -np.inf


@pytest.mark.parametrize(("argument", "value"), [("omega", 0.0), ("zeta", -0.1), ("f", -0.1)])
def test_impossible_parameters_are_refused(argument, value):
    with pytest.raises(ns.ModelError, match=f"{argument} >"):
        friction_oscillator(**{argument: value})
