"""The ring with mass: closed forms, balances of momentum and energy, scipy, and small masses."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.models import massive_ring_rotor, rotor

QUIET = {"eta_m": 0.0, "nu1": 0.0, "nu2": 0.0}
STATES = ("x", "y", "vx", "vy", "sx", "sy", "svx", "svy")


def events(run, name):
    """States before and after the events of this name, by state."""
    rows = np.flatnonzero(run["event_name"].values == name)
    return (
        {s: run[key].sel(state=s).values[rows] for s in (*STATES, "nx", "ny", "w")}
        for key in ("state_before", "state_after")
    )


def elastic(s, delta):
    """Energy of the springs of one axis over their stiffness, from the chapter's (55)-(58)."""
    s = np.abs(s)
    return np.where(s <= delta, s**2, ((s + delta) ** 2 - 2 * delta**2) / 2)


def test_a_bounce_along_one_line_has_its_closed_form():
    K, m, eps = 30.0, 1 / 17, 1.1
    hit = np.arccos(0.1)  # x = 1.1 - cos(t)
    speed = np.sin(hit) / (1 + m)  # of both after the impact
    rate, centre = np.sqrt((1 + K) / (1 + m)), (eps + K) / (1 + K)
    leave = (K - m * rate**2 * centre) / (K - m * rate**2)  # m x'' + K (x - 1) = 0
    amplitude = np.hypot(1 - centre, speed / rate)
    top = np.arctan2(speed / rate, 1 - centre)
    span = (top + np.arccos((leave - centre) / amplitude)) / rate
    words = QUIET | {"eps_x": eps, "delta_x": 0.0, "delta_y": 0.0, "K": K}
    run = ns.simulate(massive_ring_rotor(**words), {"x": 0.1}, t_end=hit + span + 0.01)
    names = run["event_name"].values.tolist()
    first, last = names.index("contact"), names.index("release")
    assert abs(run["event_time"].values[first] - hit) < 1e-14
    assert abs(run["event_time"].values[last] - hit - span) < 1e-13
    after = dict(zip(run["state"].values, run["state_after"].values[last], strict=True))
    assert abs(after["x"] - leave) < 1e-13
    assert abs(
        after["vx"] + amplitude * rate * np.sqrt(1 - ((leave - centre) / amplitude) ** 2)
    ) < (1e-12)
    assert after["svx"] == pytest.approx(after["vx"], abs=1e-14)


@pytest.mark.parametrize("f", [0.0, 0.15])
def test_impacts_keep_momentum_and_take_the_energy_that_they_must(f):
    m = 0.2
    run = ns.simulate(massive_ring_rotor(m_s=m, f=f, radius=70.0), periods=60)
    before, after = events(run, "contact")
    assert len(before["x"]) > 50
    n = np.array([before["x"] - before["sx"], before["y"] - before["sy"]])
    t = np.array([-n[1], n[0]])
    change_r = np.array([after["vx"] - before["vx"], after["vy"] - before["vy"]])
    change_s = np.array([after["svx"] - before["svx"], after["svy"] - before["svy"]])
    relative = np.array([before["vx"] - before["svx"], before["vy"] - before["svy"]])
    approach = (n * relative).sum(0)
    assert (approach > 0).all()
    assert np.abs(change_r + m * change_s).max() < 1e-14
    impulse = approach * m / (1 + m)
    assert np.abs((n * change_r).sum(0) + impulse).max() < 1e-14
    assert np.abs((t * change_r).sum(0) + f * impulse).max() < 1e-14
    left = np.array([after["vx"] - after["svx"], after["vy"] - after["svy"]])
    assert np.abs((n * left).sum(0)).max() < 1e-14
    if f == 0:
        kinetic = {
            key: (s["vx"] ** 2 + s["vy"] ** 2 + m * (s["svx"] ** 2 + s["svy"] ** 2)) / 2
            for key, s in (("before", before), ("after", after))
        }
        loss = kinetic["before"] - kinetic["after"]
        assert np.abs(loss - impulse * approach / 2).max() < 1e-14


def test_energy_changes_at_impacts_alone():
    m, K, eps = 0.1, 20.0, (0.3, 0.2)
    words = QUIET | {"K": K, "m_s": m, "eps_x": eps[0], "eps_y": eps[1]}
    run = ns.simulate(
        massive_ring_rotor(**words, delta_x=0.1, delta_y=0.02),
        {"x": 0.3, "y": 0.2, "vx": 2.0, "vy": -1.1},
        t_end=60,
    )
    before, _ = events(run, "contact")
    approach = before["nx"] * (before["vx"] - before["svx"]) + before["ny"] * (
        before["vy"] - before["svy"]
    )
    lost = np.concatenate([[0.0], np.cumsum(approach**2 * m / (1 + m) / 2)])
    times = run["event_time"].values[run["event_name"].values == "contact"]
    energy = (
        (run["vx"] ** 2 + run["vy"] ** 2 + m * (run["svx"] ** 2 + run["svy"] ** 2)) / 2
        + ((run["x"] - eps[0]) ** 2 + (run["y"] - eps[1]) ** 2) / 2
        + K * (elastic(run["sx"], 0.1) + elastic(run["sy"], 0.02))
    ).values
    assert len(times) > 20
    assert lost[-1] > 0.1 * energy[0]
    balance = energy + lost[np.searchsorted(times, run["time"].values)]
    assert np.abs(balance - energy[0]).max() < 1e-12
    ring = K * (elastic(run["sx"], 0.1) + elastic(run["sy"], 0.02))
    assert np.abs(run["energy"] - ring).max() < 1e-12


def field(p, f):
    """Motion by Eqs. (55)-(58) as printed, both bodies rigid; apart where ``touching`` is false."""

    def spring(s, ds, delta):
        force = 0.0
        if s > -delta or (delta == 0 and s >= 0):
            force += p["K"] * (delta + s) + 2 * p["nu2"] * ds
        if s < delta:
            force -= p["K"] * (delta - s) - 2 * p["nu2"] * ds
        return force

    def rates(t, z, touching):
        r, dr, s, ds = z[0:2], z[2:4], z[4:6], z[6:8]
        angle = p["eta"] * t
        pull = p["eta_m"] * p["rho"] * p["eta"] ** 2 * np.array([np.cos(angle), np.sin(angle)])
        a = pull - 2 * p["nu1"] * dr - (r - [p["eps_x"], p["eps_y"]])
        held = [spring(s[0], ds[0], p["delta_x"]), spring(s[1], ds[1], p["delta_y"])]
        b = -np.array(held) / p["m_s"]
        if touching:
            n = (r - s) / np.hypot(*(r - s))
            v = dr - ds
            normal = (n @ (a - b) + v @ v) / (1 + 1 / p["m_s"])
            push = normal * (n + f * np.array([-n[1], n[0]]))
            a, b = a - push, b + push / p["m_s"]
        return np.concatenate([dr, a, ds, b])

    return rates


@pytest.mark.slow
@pytest.mark.parametrize("f", [0.0, 0.1])
def test_all_regimes_against_scipy(f):
    """Segment by segment between the events, impacts by the law of impulse."""
    system = massive_ring_rotor(eps_x=0.75, eps_y=0.5, delta_x=0.08, delta_y=0.03, eta_m=0.004, f=f)
    p = system.parameter_values
    run = ns.simulate(system, periods=4, tangent=True)
    assert {"free", "II", "III", "IV", "V"} <= set(ns.phase_word(run))
    m, z, rates = p["m_s"], np.zeros(8), field(p, f)
    cuts = [*run["event_time"].values, float(run["time"][-1])]
    names = [str(name) for name in run["event_name"].values]
    words = run["event_to"].attrs["flag_meanings"].split()
    free = [
        words[mode] == "free" for mode in run["event_to"].values
    ]  # also where contact and release are one
    for name, apart, (begin, end) in zip(names, free, pairwise(cuts), strict=True):
        if name == "contact":
            n, v = z[0:2] - z[4:6], z[2:4] - z[6:8]
            assert abs(np.hypot(*n) - 1) < 1e-9
            impulse = n @ v * m / (1 + m) * (n + f * np.array([-n[1], n[0]]))
            z[2:4] -= impulse
            z[6:8] += impulse / m
        options = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15, "args": (not apart,)}
        z = solve_ivp(rates, (begin, end), z, **options).y[:, -1]
    growth = np.abs(run["tangent"].values).max()
    final = run["end_state"].sel(state=list(STATES)).values
    assert np.abs(final - z).max() < 1e-11 * growth


def test_without_mass_it_is_the_massless_ring_where_forces_lie_on_one_line():
    """Along an axis the error falls in proportion to the mass."""
    words = {"eta_m": 0.0, "nu2": 0.5, "eps_x": 0.5}
    start = {"vx": 2.0}
    exact = ns.simulate(rotor(**words), start, t_end=5)
    off = []
    for m_s in (1e-3, 1e-4, 1e-5):
        run = ns.simulate(massive_ring_rotor(**words, m_s=m_s), start, t_end=5)
        off.append(abs(float(run["x"][-1] - exact["x"][-1])))
    assert off[0] < 1e-2
    assert all(7 < a / b < 13 for a, b in pairwise(off))


def test_in_the_plane_the_damping_decides_how_near_the_massless_ring_is():
    """The chapter leaves dampers out of the ring's position; then forces lie off the normal."""

    def off(nu2, m_s):
        words = {"nu2": nu2, "eta": 2.0}
        ends = [
            ns.simulate(system, t_end=4)["x"][-1]
            for system in (rotor(**words), massive_ring_rotor(**words, m_s=m_s))
        ]
        return abs(float(ends[1] - ends[0]))

    assert 8 < off(0.002, 1e-4) / off(0.002, 1e-5) < 12  # the mass alone
    assert off(0.2, 1e-5) > 3 * off(0.02, 1e-5)  # what stays, growing with the damping


def segments(system, run):
    """Name of the event, sign of the slip in the cell entered (. while free), begin and end."""
    cells = [cell.name for cell in system.structure.running]
    entered = [cells[m] for m in run["event_to"].values]
    slips = [c[len("contact[++")] if c.startswith("contact") else "." for c in entered]
    times = [*run["event_time"].values, float(run["time"][-1])]
    return zip(run["event_name"].values, slips, pairwise(times), strict=True)


def test_rolling_against_scipy():
    """Friction by the condition that the slip stays zero, integrated between the events."""
    f, radius = 0.4, 0.5
    system = massive_ring_rotor(f=f, radius=radius)
    p = system.parameter_values
    run = ns.simulate(system, {"vy": -3.0}, periods=3, tangent=True)
    m, rates, z = p["m_s"], field(p, f), np.array([0, 0, 0, -3.0, 0, 0, 0, 0])
    backward = field(p, -f)

    def rolling(t, z):
        """Slip w = n x v has the rate n x (a - b) without friction."""
        free = field(p, 0.0)(t, z, True)
        n = z[0:2] - z[4:6]
        a, b = free[2:4], free[6:8]
        friction = (n[0] * (a - b)[1] - n[1] * (a - b)[0]) * m / (1 + m)
        push = friction * np.array([-n[1], n[0]])
        return np.concatenate([free[:2], a - push, free[4:6], b + push / m])

    lasted = dict.fromkeys(".+-0", 0.0)
    for name, slip, (begin, end) in segments(system, run):
        lasted[slip] += end - begin
        if name == "contact":
            n, v = z[0:2] - z[4:6], z[2:4] - z[6:8]
            t = np.array([-n[1], n[0]])
            normal = n @ v * m / (1 + m)
            halt = (p["eta"] * radius + t @ v) * m / (1 + m)
            impulse = normal * n + np.clip(halt, -f * normal, f * normal) * t
            z[2:4] -= impulse
            z[6:8] += impulse / m
        motion = {
            ".": lambda t, z: rates(t, z, False),
            "+": lambda t, z: rates(t, z, True),
            "-": lambda t, z: backward(t, z, True),
            "0": rolling,
        }[slip]
        z = solve_ivp(motion, (begin, end), z, method="DOP853", rtol=1e-13, atol=1e-15).y[:, -1]
    assert min(lasted.values()) > 0.05, lasted
    growth = np.abs(run["tangent"].values).max()
    final = run["end_state"].sel(state=list(STATES)).values
    assert np.abs(final - z).max() < 1e-11 * growth


def test_rolling_needs_no_more_friction_than_there_is():
    f, radius = 0.4, 0.5
    system = massive_ring_rotor(f=f, radius=radius)
    run = ns.simulate(system, {"vy": -3.0}, periods=20)
    assert run.attrs["status"] == "completed"
    cells = [cell.name for cell in system.structure.running]
    rolls = np.array([cells[m].startswith("contact[") and cells[m][10] == "0"
                      for m in run["mode"].values])  # fmt: skip
    assert rolls.sum() > 50
    assert np.abs(run["slip"].values[rolls]).max() < 1e-12
    limit = f * run["normal_force"].values
    across = run["force_y"] * run["nx"] - run["force_x"] * run["ny"]
    size = np.abs(across.values)
    assert (size[rolls] <= limit[rolls] * (1 + 1e-12)).all()
    assert np.median(size[rolls] / limit[rolls]) < 0.9
    touches = (limit > 0) & ~rolls
    assert np.allclose(size[touches], limit[touches], rtol=1e-12, atol=0)
    assert np.allclose(run["force"], np.hypot(run["force_x"], run["force_y"]), rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("argument", "value"),
    [("eta", 0), ("nu2", -0.1), ("K", 0), ("m_s", 0), ("f", -0.1), ("radius", 0), ("delta_x", -1)],
)
def test_impossible_parameters_are_refused(argument, value):
    with pytest.raises(ns.ModelError, match=f"{argument} >"):
        massive_ring_rotor(**{argument: value})
