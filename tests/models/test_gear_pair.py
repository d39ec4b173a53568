"""The gear pair against closed forms, symmetry, and scipy where the mesh stiffness varies."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.models import gear_pair

EPS = np.finfo(float).eps


def dead_zone(x, b):
    return np.where(x > b, x - b, np.where(x < -b, x + b, 0.0))


def modes(run):
    return [run["event_to"].attrs["flag_meanings"].split()[int(m)] for m in run["event_to"]]


@pytest.mark.parametrize(("mean", "b"), [(0.1, 1.0), (-0.3, 0.5), (0.2, 0.0)])
def test_a_mean_force_rests_on_one_flank(mean, b):
    system = gear_pair(F_a=0.0, F_m=mean, b=b)
    run = ns.simulate(system, periods=20)
    exact = mean + np.copysign(b, mean)
    assert run.attrs["n_events"] == 0
    assert np.abs(run["x"].values - exact).max() < 4 * EPS
    damped = ns.simulate(system.with_parameters(zeta=0.5), {"x": 0.0}, t_end=200)
    assert float(damped["x"][-1]) == pytest.approx(exact, abs=1e-13)


@pytest.mark.parametrize("Omega", [0.5, 1.0, 2.0])
def test_without_separation_the_response_is_linear(Omega):
    zeta, mean, error = 0.1, 0.5, 0.06
    response = error * Omega**2 / (1 - Omega**2 + 2j * zeta * Omega)
    system = gear_pair(Omega=Omega, zeta=zeta, F_m=mean, F_a=error)
    start = {"x": 1.0 + mean + response.real, "v": (1j * Omega * response).real}
    run = ns.simulate(system, start, periods=20)
    exact = 1.0 + mean + (response * np.exp(1j * Omega * run["time"].values)).real
    assert abs(response) < mean
    assert run.attrs["n_events"] == 0
    assert np.abs(run["x"].values - exact).max() < 1e-13


@pytest.mark.parametrize(("b", "speed"), [(1.0, 0.5), (0.01, 2.0), (1.0, 1e-3)])
def test_period_between_two_flanks(b, speed):
    """Free and undamped: half a circle on either flank and two flights at constant speed."""
    system = gear_pair(zeta=0.0, F_m=0.0, F_a=0.0, b=b)
    exact = 2 * np.pi + 4 * b / speed
    run = ns.simulate(system, {"x": b, "v": speed}, t_end=8.5 * exact, mode="drive")
    hits = run["event_time"].values[run["event_name"].values == "drive_impact"]
    assert len(hits) == 8
    # sixteen arcs and flights, each with some roundings of its time
    assert np.abs(hits - exact * np.arange(1, 9)).max() < 32 * 16 * EPS * exact
    assert set(modes(run)) == {"drive", "separated", "back"}


def test_energy_is_kept_under_a_mean_force():
    mean, b = 0.1, 1.0
    run = ns.simulate(
        gear_pair(zeta=0.0, F_m=mean, F_a=0.0),
        {"x": 0.0, "v": 2.0},
        t_end=300,
        samples_per_period=9,
    )
    x, v = run["x"].values, run["v"].values
    energy = v**2 / 2 + dead_zone(x, b) ** 2 / 2 - mean * x
    assert set(modes(run)) == {"drive", "separated", "back"}
    assert run.attrs["n_events"] > 100
    # a few roundings of the energy at each event
    assert np.abs(energy / energy[0] - 1).max() < 4 * EPS * run.attrs["n_events"]


def test_mirrored_force_gives_the_mirrored_motion():
    words = {"Omega": 0.5, "F_a": 0.9, "zeta": 0.1}
    system = gear_pair(F_m=0.1, **words)
    half = system.period_value / 2
    one = ns.simulate(system, {"x": 0.2, "v": 0.1}, t_end=8 * half, tangent=True)
    two = ns.simulate(
        gear_pair(F_m=-0.1, **words), {"x": -0.2, "v": -0.1}, t_start=half, t_end=9 * half
    )
    mirrored = {"drive": "back", "back": "drive", "separated": "separated"}
    assert [mirrored[name] for name in modes(one)] == modes(two)
    assert set(modes(one)) == set(mirrored)
    growth = np.abs(one["tangent"].values).max()
    apart = two["event_time"].values - half - one["event_time"].values
    assert np.abs(apart).max() < 64 * EPS * 9 * half * growth


def flow_kinds(system, capsys):
    system.explain()
    lines = capsys.readouterr().out.splitlines()
    return dict(line.removeprefix("mode ").split(": ") for line in lines if line[:5] == "mode ")


def test_constant_stiffness_is_linear_and_varying_is_not(capsys):
    assert set(flow_kinds(gear_pair(), capsys).values()) == {"exact linear"}
    assert flow_kinds(gear_pair(k=0.2), capsys) == {
        "drive": "Taylor series",
        "separated": "exact linear",
        "back": "Taylor series",
    }


def test_varying_stiffness_through_zero_is_the_constant_one():
    start = {"x": 0.5, "v": 0.4}
    one = ns.simulate(gear_pair(Omega=0.5, F_a=0.9), start, periods=3, tangent=True)
    two = ns.simulate(gear_pair(Omega=0.5, F_a=0.9, k=0.1).with_parameters(k=0), start, periods=3)
    growth = np.abs(one["tangent"].values).max()
    assert modes(one) == modes(two) and len(modes(one)) > 5
    # two flows, each exact to some roundings in each of a few dozen segments
    assert np.abs(one["event_time"].values - two["event_time"].values).max() < 1e-14 * 40 * growth
    assert np.abs(one["x"].values - two["x"].values).max() < 1e-14 * 40 * growth


def dop853(p, start, end):
    """Events and end of a run by scipy, restarted at each crossing of a flank."""
    b = p["b"]

    def field(t, z):
        mesh = 1 + p["k"] * np.cos(p["Omega"] * t + p["phi"])
        force = p["F_m"] + p["F_a"] * p["Omega"] ** 2 * np.cos(p["Omega"] * t)
        stretch = {0: 0.0, 1: z[0] - b, -1: z[0] + b}[side]
        return [z[1], force - 2 * p["zeta"] * z[1] - mesh * stretch]

    def upper(t, z):
        return z[0] - b

    def lower(t, z):
        return z[0] + b

    upper.terminal = lower.terminal = True
    t, z, times = 0.0, np.array(start), []
    side = int(np.sign(dead_zone(z[0], b)))
    while True:
        # just left a flank: let the way off it begin before looking for the next crossing
        upper.direction = -1 if side == 1 else 1
        lower.direction = 1 if side == -1 else -1
        found = solve_ivp(
            field, (t, end), z, method="DOP853", rtol=1e-13, atol=1e-15, events=[upper, lower]
        )
        if found.status == 0:
            return times, found.y[:, -1]
        which = 0 if len(found.t_events[0]) else 1
        t, z = found.t_events[which][0], found.y_events[which][0].copy()
        times.append(t)
        side = 0 if side else 1 - 2 * which
        z[0] = b if which == 0 else -b


@pytest.mark.parametrize(
    ("changes", "start", "events"),
    [
        ({"F_m": 0.5, "F_a": 0.0, "k": 0.3, "zeta": 0.02, "Omega": 0.9}, (1.6, 0.0), 0),
        ({"F_m": 0.1, "F_a": 0.2, "k": 0.2, "phi": 0.7, "Omega": 0.8}, (1.2, 0.1), 2),
        ({"F_m": 0.1, "F_a": 0.9, "k": 0.4, "Omega": 0.5, "b": 0.5}, (0.0, 0.3), 6),
    ],
)
def test_varying_stiffness_against_scipy(changes, start, events):
    """Mathieu's equation with a load; DOP853 at its tightest tolerance is good for 1e-11."""
    system = gear_pair(**changes)
    p = {"b": 1.0, "phi": 0.0} | system.parameter_values
    end = 3 * system.period_value
    times, last = dop853(p, start, end)
    run = ns.simulate(system, dict(zip("xv", start, strict=True)), t_end=end, tangent=True)
    growth = np.abs(run["tangent"].values).max()
    assert run.attrs["n_events"] == len(times) >= events
    assert np.abs(run["event_time"].values[1:] - times).max(initial=0.0) < 1e-11 * growth
    assert np.abs(run["end_state"].values - last).max() < 1e-11 * growth


@pytest.mark.parametrize(
    ("argument", "value", "said"),
    [("Omega", 0.0, "Omega >"), ("zeta", -0.1, "zeta >"), ("b", -1, "b >"), ("k", 1.0, "k")],
)
def test_impossible_parameters_are_refused(argument, value, said):
    with pytest.raises(ns.ModelError, match=said):
        gear_pair(**{argument: value})
