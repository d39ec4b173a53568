"""Guards that are zero by construction after an event, where flows, guards or resets are curved."""

import numpy as np
import pytest
from mpmath import mp
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth import Exit, Mode, System
from runs.flows import EPS, crossings

# ---------------------------------------------------------------- release by force

PAD = {"k": 3.0, "c": 0.4, "gap": 0.1, "a": 1.0, "w": 2.0}


def padded():
    """A mass and a massless pad with a hardening spring and a damper: they part by force.

    At release the force c y + q + k q^3 is zero, so the pad relaxes with the speed of the mass:
    the distance leaves zero with its second derivative.
    """
    force = {"load": "a*cos(w*t) - p", "F": "c*y + q + k*q**3"}
    return System(
        states=["p", "y", "q"],
        parameters=PAD,
        period="2*pi/w",
        definitions=force,
        modes={
            "free": Mode(
                {"p": "y", "y": "load", "q": "-(q + k*q**3)/c"},
                exits=[Exit("q + gap - p", to="touch")],
            ),
            "touch": Mode(
                {"y": "load - F", "q": "y"},
                slaved={"p": "q + gap"},
                exits=[Exit("F", to="free", name="release")],
            ),
        },
    )


def padded_events(count):
    """Times of its events by an integrator of order 8, restarted a little after each."""
    k, c, gap, a, w = (PAD[name] for name in ("k", "c", "gap", "a", "w"))

    def force(s):
        return c * s[1] + s[2] + k * s[2] ** 3

    def free(t, s):
        return [s[1], a * np.cos(w * t) - s[0], -(s[2] + k * s[2] ** 3) / c]

    def touch(t, s):
        return [s[1], a * np.cos(w * t) - s[0] - force(s), s[1]]

    def distance(t, s):
        return s[2] + gap - s[0]

    def pressure(t, s):
        return force(s)

    distance.terminal = pressure.terminal = True
    distance.direction = pressure.direction = -1.0
    words = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-13}
    state, t, times, touching = [0.0, 0.0, 0.0], 0.0, [], False
    while len(times) < count:
        rate, event = (touch, pressure) if touching else (free, distance)
        away = solve_ivp(rate, (t, t + 1e-3), state, **words)
        flight = solve_ivp(rate, (t + 1e-3, t + 50.0), away.y[:, -1], events=event, **words)
        t, state = float(flight.t_events[0][0]), flight.y_events[0][0]
        times.append(t)
        touching = not touching
    return np.array(times)


def test_a_release_by_a_nonlinear_force():
    run = ns.simulate(padded(), times=np.linspace(0.0, 60.0, 601))
    log = crossings(run)
    assert log.sizes["event"] > 20
    assert log["event_name"].values.tolist() == ["touch", "release"] * (log.sizes["event"] // 2)
    assert bool(log["certified"].all())
    expected = padded_events(12)
    # the integrator's tolerance, grown by the forced motion over some turns
    assert np.allclose(log["event_time"][:12], expected, rtol=0, atol=1e-9)
    distance = (run["q"] + PAD["gap"] - run["p"]).values
    touching = run["mode"].values == 1
    assert np.all(np.abs(distance[touching]) < 4 * EPS)
    assert distance[~touching].min() > 0.0


# ---------------------------------------------------------------- slaved by a nonlinear relation


def wire():
    """A bead falls onto the wire y = x^2, keeps its speed along it, and slides on without friction.

    The third exit is zero along the wire, by the relation; the second is not.
    """
    along = "(u + 2*x*v)/(1 + 4*x**2)"
    on = Mode(
        {"x": "u", "u": "-(4*u**2 + 2)*x/(1 + 4*x**2)"},
        slaved={"y": "x**2", "v": "2*x*u"},
        exits=[Exit("x + 5", to="stop"), Exit("x**2 - y", to="stop"), Exit("y - x**2", to="stop")],
    )
    land = Exit("y - x**2", to="on", reset={"u": along, "v": "v"}, name="land")
    free = Mode({"x": "u", "y": "v", "u": "0", "v": "-1"}, exits=[land])
    return System(states=["x", "y", "u", "v"], modes={"free": free, "on": on})


def test_a_bead_slides_on_its_wire():
    run = ns.simulate(wire(), {"x": 0.6, "y": 1.0}, times=np.linspace(0.0, 50.0, 101))
    log = crossings(run)
    assert log["event_name"].values.tolist() == ["land"]
    assert run.attrs["n_uncertain"] == 0
    # falls by 1 - 0.36; of its speed the part along (1, 2 x) is left
    fall = np.sqrt(2 * (1 - 0.36))
    assert float(log["event_time"][0]) == pytest.approx(fall, rel=4 * EPS)
    tangential = 2 * 0.6 * -fall / np.sqrt(1 + 4 * 0.36)
    after = log["state_after"].isel(event=0)
    speed = np.hypot(float(after.sel(state="u")), float(after.sel(state="v")))
    assert speed == pytest.approx(abs(tangential), rel=8 * EPS)
    on = run.isel(time=run["mode"].values == 1)
    energy = (on["u"] ** 2 + on["v"] ** 2) / 2 + on["y"]
    assert on.sizes["time"] > 90
    assert np.allclose(energy, tangential**2 / 2 + 0.36, rtol=0, atol=1e-13)
    assert np.array_equal(on["y"].values, on["x"].values ** 2) or np.allclose(
        on["y"], on["x"] ** 2, rtol=4 * EPS, atol=0
    )


# ---------------------------------------------------------------- curved guards and resets


def billiard():
    normal = "(x*u + y*v)/(x**2 + y**2)"
    bounce = Exit(
        "R**2 - x**2 - y**2",
        reset={"u": f"u - 2*x*{normal}", "v": f"v - 2*y*{normal}"},
        name="bounce",
    )
    mode = Mode({"x": "u", "y": "v", "u": "0", "v": "0"}, exits=[bounce])
    return System(states=["x", "y", "u", "v"], parameters={"R": 1.0}, modes={"m": mode})


@pytest.mark.parametrize(
    "start",
    [
        {"x": 0.3, "y": 0.1, "u": 0.7, "v": 0.4},
        {"x": 0.0, "y": 0.0, "u": 0.6, "v": 0.8},  # through the centre, there and back
        {"x": 0.99, "y": 0.0, "u": 0.05, "v": 1.0},  # many short chords
    ],
)
def test_a_circular_billiard(start):
    """All chords are equal and turn by the same angle: 1000 bounces in closed form."""
    x, y, u, v = (mp.mpf(start[name]) for name in "xyuv")
    with mp.workdps(30):
        speed = mp.sqrt(u * u + v * v)
        along = (x * u + y * v) / speed
        half = mp.sqrt(along**2 + 1 - x * x - y * y)  # half a chord
        first = (half - along) / speed
        angle = mp.atan2(y + v * first, x + u * first)
        # the direction of flight turns by twice the angle of incidence from the tangent
        side = 1 if x * v - y * u >= 0 else -1
        turn = side * 2 * mp.asin(half)
        times = np.array([float(first + k * 2 * half / speed) for k in range(1000)])
        places = [angle + k * turn for k in range(1000)]
        expected = np.array([[float(mp.cos(p)), float(mp.sin(p))] for p in places])
    run = ns.simulate(billiard(), start, times=[times[-1] + 0.1 * float(half / speed)])
    log = crossings(run)
    assert log.sizes["event"] == 1000
    assert bool(log["certified"].all())
    after = log["state_after"]
    velocity = after.sel(state=["u", "v"]).values
    energy = (velocity**2).sum(axis=1)
    assert np.allclose(energy, float(speed) ** 2, rtol=1e-12, atol=0)
    # roundings of each bounce turn all later chords: k of them by up to k eps each, sqrt(k)
    # together, over the sine of the chord's angle with the wall
    steps = np.arange(1, 1001)
    slope = float(half)
    error = np.abs(after.sel(state=["x", "y"]).values - expected).max(axis=1)
    assert np.all(error < 10 * EPS * steps**1.5 / slope)
    late = np.abs(log["event_time"].values - times)
    assert np.all(late < 10 * EPS * steps**1.5 / slope / float(speed))


@pytest.mark.parametrize("r", [1.0, 0.7])
def test_a_pendulum_hits_a_stop(r):
    """From rest at -1 to the stop at 1/2: all times from integrals of the energy."""
    mode = Mode(
        {"th": "w", "w": "-sin(th)"}, exits=[Exit("0.5 - th", reset={"w": "-r*w"}, name="hit")]
    )
    system = System(states=["th", "w"], parameters={"r": r}, modes={"m": mode})
    times, now, lowest = [], mp.mpf(0), mp.mpf(1)
    with mp.workdps(20):
        for k in range(8):
            # between the stop and the turning point -lowest, by th = s^2 - lowest
            def slow(s, lowest=lowest):
                return s / mp.sqrt(mp.sin(lowest - s * s / 2) * mp.sin(s * s / 2))

            way = mp.quad(slow, [0, mp.sqrt(lowest + mp.mpf(0.5))])
            now += way if k == 0 else 2 * way
            times.append(float(now))
            half_square = r**2 * (mp.cos(mp.mpf(0.5)) - mp.cos(lowest))
            lowest = mp.acos(mp.cos(mp.mpf(0.5)) - half_square)
    run = ns.simulate(system, {"th": -1.0}, times=[times[-1] + 0.01])
    log = crossings(run)
    assert np.allclose(log["event_time"], times, rtol=0, atol=1e-13)
    assert bool(log["certified"].all())


@pytest.mark.parametrize("reset", ["x", "sin(x)", "x*(2 + v)", "x**3", "exp(x) - 1", "tanh(x)*v"])
def test_a_reset_that_keeps_the_guard_at_zero(reset):
    """Whatever it makes of x, zero stays zero: bounces at sqrt 2 (1 + 2 (r + r^2 + ..))."""
    bounce = Exit("x", reset={"x": reset, "v": "-v/2"}, name="bounce")
    mode = Mode({"x": "v", "v": "-1"}, exits=[bounce])
    run = ns.simulate(System(states=["x", "v"], modes={"m": mode}), {"x": 1.0}, times=[4.2])
    log = crossings(run)
    times = np.sqrt(2.0) * (1 + 2 * (1 - 0.5 ** np.arange(10)))
    times = times[times < 4.2]
    assert log.sizes["event"] == times.size > 5
    assert np.allclose(log["event_time"], times, rtol=0, atol=1e-13)
    assert np.all(log["state_after"].sel(state="x").values == 0.0)
