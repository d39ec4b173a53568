"""The print hammer: bounces in closed form, and a whole print by matrix exponentials."""

import numpy as np
import pytest
from mpmath import matrix, mp, mpf

import nonsmooth as ns
from models.rebounds import Instant, of_rounding, of_the_end, rebounds
from nonsmooth.models import print_hammer

EPS = np.finfo(float).eps


def over(run):
    """Times at which rebounds have accumulated."""
    return run["event_time"].values[run["event_kind"].values.astype(str) == "chatter"]


def named(run, name):
    return run["event_time"].values[run["event_name"].values == name]


def singly(run):
    """Times and speeds of the impacts that are followed one by one."""
    alone = run["event_kind"].values.astype(str) == "impact"
    return run["event_time"].values[alone], -run["guard_rate"].values[alone]


@pytest.mark.parametrize("r", [0.3, 0.5, 0.7, 0.9])
@pytest.mark.parametrize("v", [1e-3, 0.9])
def test_bounces_without_damping_in_closed_form(r, v):
    """A flight from the speed v lasts 2 artanh(v / p) and ends with the speed v."""
    p = 1.5
    with mp.workdps(40):
        a, q = mpf(v) / mpf(p), mpf(r)
        exact = float(mp.log(mp.qp(-a, q) / mp.qp(a, q)))
        assert abs(exact - mp.nsum(lambda k: 2 * mp.atanh(q**k * a), [0, mp.inf])) < 1e-15
    system = print_hammer(F=0.0, zeta=0.0, p=p, r=r)
    run = ns.simulate(system, {"x": 0.0, "v": v}, t_end=60)
    assert over(run).size == 1 and "print" not in run.attrs["phase_word"]
    _, speeds = singly(run)
    assert abs(over(run)[0] - exact) < of_the_end(speeds, r, system.period_value)
    assert np.all(run["end_state"].values == 0.0)
    assert float(run["backstop_force"][-1]) == pytest.approx(p, rel=4 * EPS)


def flight_of(p, zeta):
    """Flights without a pulse: x - p decays and grows with the roots of s^2 + 2 zeta s - 1."""

    def flight(began, rate):
        root = mp.sqrt(1 + zeta**2)

        def motion(t):
            s = t - began
            c, h = mp.cosh(root * s), mp.sinh(root * s) / root
            decay = mp.exp(-zeta * s)
            x = decay * (-p * c + (rate - zeta * p) * h)
            v = decay * (rate * c - (zeta * rate + p) * h)
            return Instant(p + x, v, x - 2 * zeta * v)

        return motion

    return flight


@pytest.mark.parametrize(("p", "zeta", "r", "v"), [(1.5, 0.02, 0.5, 0.8), (1.1, 0.3, 0.8, 0.5)])
def test_damped_bounces_one_by_one(p, zeta, r, v):
    with mp.workdps(40):
        times, rest = rebounds(flight_of(mpf(p), mpf(zeta)), 0, mpf(v), r)
    system = print_hammer(F=0.0, zeta=zeta, p=p, r=r)
    run = ns.simulate(system, {"x": 0.0, "v": v}, t_end=60)
    hits, speeds = singly(run)
    assert 5 < hits.size < len(times)
    assert np.all(np.abs(hits - times[: hits.size]) < of_rounding(speeds))
    assert abs(over(run)[0] - rest) < of_the_end(speeds, r, system.period_value)


def released(omega, p, F, d):
    """When a pulse, the tip of a cosine, exceeds the preload."""
    return (np.pi * d - np.arccos(np.cos(np.pi * d) + p / F * (1 - np.cos(np.pi * d)))) / omega


@pytest.mark.parametrize(("F", "d"), [(4.0, 0.25), (1.6, 0.5), (9.0, 0.1)])
def test_a_pulse_frees_the_hammer(F, d):
    system = print_hammer(F=F, d=d, omega=0.5)
    run = ns.simulate(system, periods=3)
    freed = named(run, "release")
    exact = released(0.5, 1.5, F, d) + system.period_value * np.arange(3)
    assert np.abs(freed - exact).max() < 1e-12
    pulse = run["pulse_force"].values
    phase = run["time"].values % system.period_value / system.period_value
    assert np.all(pulse[(phase > d + 1e-9)] == 0.0) and pulse.max() <= F
    if d == 0.5:
        half_sine = F * np.maximum(np.sin(0.5 * run["time"].values), 0.0)
        assert np.abs(pulse - half_sine).max() < 1e-13 * F


def test_a_pulse_below_the_preload_does_nothing():
    run = ns.simulate(print_hammer(F=1.49), periods=20)
    assert named(run, "release").size == 0
    assert np.all(run["x"].values == 0.0)


def linear(d, contact, pulse):
    """Rates of (x, v, cos, sin, 1) on or off the paper, in a pulse or not; numbers by default."""
    k, c = (mpf(100), 2 * mpf(2)) if contact else (mpf(0), mpf(0))
    tip = mp.pi * mpf(d)
    on = mpf(4) / (1 - mp.cos(tip)) if pulse else mpf(0)
    push = k - mpf(1.5) - on * mp.cos(tip)
    w = mpf(0.8)
    return matrix(
        [
            [0, 1, 0, 0, 0],
            [1 - k, -2 * mpf(0.02) - c, on * mp.cos(tip), on * mp.sin(tip), push],
            [0, 0, 0, -w, 0],
            [0, 0, w, 0, 0],
            [0, 0, 0, 0, 0],
        ]
    )


def passed(leg, level, near):
    """Duration of a leg until x has a level."""
    return mp.findroot(lambda t: leg(t)[0] - level, near)


@pytest.mark.few(1)
@pytest.mark.parametrize("d", [0.25, 0.4])
def test_a_print_by_matrix_exponentials(d):
    """Each leg of a linear mode is exp(A t) of its start."""
    run = ns.simulate(print_hammer(d=d), periods=1)
    names = list(run["event_name"].values.astype(str))
    rows = range(names.index("release") + 1, names.index("release") + 8)
    assert {names[row] for row in rows} == {"print", "off_paper", "impact", "s1"}
    with mp.workdps(40):
        time = mpf(released(0.8, 1.5, 4.0, d))
        state = matrix([0, 0, mp.cos(mpf(0.8) * time), mp.sin(mpf(0.8) * time), 1])
        contact, pulse = False, True
        for row in rows:
            name, found = names[row], float(run["event_time"][row])

            field = linear(d, contact, pulse)

            def leg(t, field=field, start=state):
                return mp.expm(field * t) * start

            if name == "s1":
                lasted = 2 * mp.pi * mpf(d) / mpf(0.8) - time
            else:
                lasted = passed(leg, 0 if name == "impact" else 1, found - time)
            time, state = time + lasted, leg(lasted)
            assert abs(found - time) < 1e-12
            before = run["state_before"].values[row]
            assert abs(before[0] - state[0]) < 1e-12 and abs(before[1] - state[1]) < 1e-12
            contact = {"print": True, "off_paper": False}.get(name, contact)
            pulse = pulse and name != "s1"
            if name == "impact":
                state[1] *= -mpf(0.5)


def test_the_paper_takes_energy_and_the_backstop_holds():
    run = ns.simulate(print_hammer(), periods=10)
    names = run["event_name"].values.astype(str)
    speeds = run["state_before"].sel(state="v").values
    assert np.sum(names == "print") == 10
    assert np.all(np.abs(speeds[names == "off_paper"]) < speeds[names == "print"])
    assert run["x"].values.min() > -1e-13
    assert run["backstop_force"].values.min() >= 0.0


@pytest.mark.parametrize(
    ("argument", "value"),
    [("omega", 0.0), ("p", 1.0), ("d", 0.0), ("d", 1.0), ("zeta", -0.1), ("r", -0.1), ("r", 1.1),
     ("kappa", -1.0), ("mu", -1.0)],
)  # fmt: skip
def test_impossible_parameters_are_refused(argument, value):
    with pytest.raises(ns.ModelError, match=f"{argument} [<>]"):
        print_hammer(**{argument: value})
