"""Runs against closed forms, and against impacts found by mpmath from the printed solution."""

import mpmath as mp
import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, System
from reference.linear import exact_flow

EPS = 2.0**-52


def test_unforced_rigid_impacts():
    # x'' = -x, wall at s, v -> -r v. Leaving with -u, the mass is back after
    # 2 pi - 2 atan2(u, s) with speed u; so v_k = r^k v_0 and times add up.
    s, r, n = 0.3, 0.9, 20
    system = System(
        states=["x", "v"],
        parameters={"s": s, "r": r},
        modes={
            "free": Mode(
                {"x": "v", "v": "-x"},
                exits=[Exit("s - x", reset={"v": "-r*v"}, name="impact")],
            )
        },
    )
    with mp.workdps(40):
        wall, factor = mp.mpf(s), mp.mpf(r)
        speed = mp.sqrt(1 - wall**2)  # from x = 0, v = 1
        times, speeds = [mp.asin(wall)], [speed]
        for _ in range(n - 1):
            speed *= factor
            times.append(times[-1] + 2 * mp.pi - 2 * mp.atan2(speed, wall))
            speeds.append(speed)
    run = ns.simulate(system, {"x": 0.0, "v": 1.0}, times=[float(times[-1]) + 1e-3])
    assert run.attrs["n_events"] == n
    assert bool(run["certified"].all())
    assert set(run["event_kind"].values[1:]) == {"impact"}
    # Each flight of some 6 rad turns with errors of a few eps, a time is off by that over
    # the speed, at least 0.13; later flights inherit it: 20 * 10 eps / 0.13.
    tolerance = 20 * 10 * EPS / float(speed)
    assert np.allclose(run["event_time"][1:], [float(t) for t in times], rtol=0, atol=tolerance)
    before = run["state_before"].sel(state="v")[1:]
    assert np.allclose(before, [float(v) for v in speeds], rtol=0, atol=tolerance)
    assert np.array_equal(run["state_after"].sel(state="v")[1:], -r * before)
    # the reset leaves x alone, and x is on the wall up to an ulp
    assert np.allclose(run["state_after"].sel(state="x")[1:], s, rtol=4 * EPS)


def forced_impacts(w, s, r, x, v, n):
    """First n impacts of x'' + x = cos(w t) at the wall s, by mpmath from the solution."""
    t0, times, speeds = mp.mpf(0), [], []
    gain = 1 / (1 - w**2)
    for _ in range(n):
        # x = a cos(t - t0) + b sin(t - t0) + gain cos(w t)
        a = x - gain * mp.cos(w * t0)
        b = v + gain * w * mp.sin(w * t0)

        def gap(t, a=a, b=b, t0=t0):
            return s - a * mp.cos(t - t0) - b * mp.sin(t - t0) - gain * mp.cos(w * t)

        # Steps of 1/200 are short beside the shortest oscillation, 2.2; a step that holds
        # two roots would need a speed below 0.05 at contact, which is asserted against.
        t = t0 + mp.mpf(1) / 200
        while gap(t) > 0:
            t += mp.mpf(1) / 200
        t = mp.findroot(gap, (t - mp.mpf(1) / 200, t), solver="anderson")
        speed = -mp.diff(gap, t)
        assert speed > 0.05
        times.append(t)
        speeds.append(speed)
        t0, x, v = t, s, -r * speed
    return times, speeds


@pytest.mark.slow
def test_forced_rigid_impacts():
    w, s, r, n = 2.8, 0.1, 0.8, 20
    system = System(
        states=["x", "v"],
        parameters={"w": w, "s": s, "r": r},
        period="2*pi/w",
        modes={
            "free": Mode(
                {"x": "v", "v": "cos(w*t) - x"}, exits=[Exit("s - x", reset={"v": "-r*v"})]
            )
        },
    )
    with mp.workdps(30):
        exact = [mp.mpf(value) for value in (w, s, r)]
        times, speeds = forced_impacts(*exact, mp.mpf(0), mp.mpf(0.5), n)
        nearby, _ = forced_impacts(*exact, mp.mpf(0), mp.mpf(0.5) + mp.mpf(10) ** -15, n)
        # how much an error at the start has grown when an impact is reached
        growth = [
            abs(float((b - a) * mp.mpf(10) ** 15)) for a, b in zip(times, nearby, strict=True)
        ]
    run = ns.simulate(system, {"x": 0.0, "v": 0.5}, times=[float(times[-1]) + 1e-3])
    assert run.attrs["n_events"] == n
    # n errors of a few eps each, carried along at most as an error at the start is
    allowed = 20 * n * EPS * np.maximum.accumulate(np.maximum(1.0, growth))
    assert np.all(np.abs(run["event_time"].values[1:] - np.array(times, float)) < allowed)
    found = run["state_before"].sel(state="v").values[1:]
    assert np.all(np.abs(found - np.array(speeds, float)) < 10 * allowed)


def test_two_incommensurate_frequencies():
    # x' = cos t + cos(sqrt 2 t), no period: x = sin t + sin(sqrt 2 t)/sqrt 2
    system = System(
        states=["x"],
        parameters={"w": "sqrt(2)"},
        modes={"m": Mode({"x": "cos(t) + cos(w*t)"}, exits=[Exit("1.68 - x", to="stop")])},
    )
    with mp.workdps(30):
        w = mp.mpf(float(np.sqrt(2.0)))

        def gap(t):
            return mp.mpf(1.68) - mp.sin(t) - mp.sin(w * t) / w

        # x has slope below two, so steps of gap/2 cannot pass the first root
        t = mp.mpf(0)
        while (value := gap(t)) > mp.mpf(10) ** -20:
            t += value / 2
        first = float(t)
    run = ns.simulate(system, t_end=10 * first)
    assert run.attrs["status"] == "stopped"
    t = run["time"].values
    # angles up to some hundred: errors of 100 eps in the sines, twice
    assert first < 400
    expected = np.sin(t) + np.sin(float(w) * t) / float(w)
    assert np.allclose(run["x"], expected, rtol=0, atol=400 * EPS)
    # the rate there is of the order of sqrt of the excess over 1.707...
    rate = float(np.cos(first) + np.cos(float(w) * first))
    assert abs(float(run["event_time"][-1]) - first) < 1e-13 / rate


def test_polynomial_forcing():
    # x' = t^3 - 2 t + 1 from x(0) = 3; every term is a power that doubles hold
    system = System(states=["x"], modes={"m": Mode({"x": "t**3 - 2*t + 1"})})
    times = np.array([0.0, 0.5, 2.0, 31.0, 64.0, 200.0, 1000.0])
    run = ns.simulate(system, {"x": 3.0}, times=times)
    assert np.allclose(run["x"], 3 + times**4 / 4 - times**2 + times, rtol=20 * EPS)


def test_an_oscillator_under_a_polynomial():
    # x'' = t^2 - x: x = t^2 - 2 + 2 cos t from rest, at times where t^2 dwarfs cos
    system = System(states=["x", "v"], modes={"m": Mode({"x": "v", "v": "t**2 - x"})})
    times = np.array([0.1, 3.0, 50.0, 200.0])
    run = ns.simulate(system, times=times)
    # the forced part is carried with the size of t^2 and is read again each window
    expected = times**2 - 2 + 2 * np.cos(times)
    assert np.allclose(run["x"], expected, rtol=0, atol=50 * EPS * 200**2)


def test_an_autonomous_oscillator():
    # damped: x = exp(-zeta t) cos(d t) and its rate, d^2 = 1 - zeta^2
    zeta = 0.01
    system = System(
        states=["x", "v"],
        parameters={"zeta": zeta},
        modes={"m": Mode({"x": "v", "v": "-2*zeta*v - x"})},
    )
    run = ns.simulate(system, {"x": 1.0, "v": -zeta}, t_end=500.0)
    t, d = run["time"].values, np.sqrt(1 - zeta**2)
    # the angle d t has error t eps in both; damped by exp(-zeta t): largest at 1/zeta
    assert np.allclose(run["x"], np.exp(-zeta * t) * np.cos(d * t), rtol=0, atol=100 * EPS)
    assert run.attrs["phase_word"] == "m"
    assert run.attrs["n_events"] == 0


def steady_state(zeta, w, t):
    """x and v of x'' + 2 zeta x' + x = cos(w t) after all transients, angles of w t only."""
    transfer = 1 / (1 - w**2 + 2j * zeta * w)
    turn = np.exp(1j * w * np.asarray(t))
    return np.real(transfer * turn), np.real(1j * w * transfer * turn)


def test_a_million_periods():
    # The steady state repeats each period; whole periods must not blur the phase.
    zeta, w, periods = 0.05, 1.3, 1_000_000
    system = System(
        states=["x", "v"],
        parameters={"zeta": zeta, "w": w},
        period="2*pi/w",
        modes={"m": Mode({"x": "v", "v": "cos(w*t) - 2*zeta*v - x"})},
    )
    x, v = steady_state(zeta, w, 0.0)
    long = ns.simulate(system, {"x": x, "v": v}, periods=periods, samples_per_period=1)
    last = ns.simulate(system, long, periods=1, samples_per_period=8)
    assert int(last["period_number"][0]) == periods
    assert np.allclose(last["phase"][:-1], np.arange(8) * 2 * np.pi / w / 8, rtol=1e-15, atol=0)
    expected = np.stack(steady_state(zeta, w, last["phase"]))
    found = np.stack([last["x"], last["v"]])
    size = np.abs(1 / (1 - w**2 + 2j * zeta * w)) * w
    # a phase error e moves the state by e times its size
    assert np.max(np.abs(found - expected)) / size < 1e-12
    assert np.allclose(long["x"], x, rtol=0, atol=1e-12 * size)


def test_outputs_after_a_million_periods():
    # the forcing that is recorded beside the states must be the one that acts
    system = System(
        states=["x"],
        parameters={"w": 1.3},
        period="2*pi/w",
        modes={"m": Mode({"x": "-x + cos(w*t)"})},
        outputs={"force": "cos(w*t)", "speed": "rate(x)"},
    )
    start = ns.simulate(system, periods=1, samples_per_period=8)
    late = ns.simulate(system, {"x": 0.0}, periods=1, t_start=1e6 * start.attrs["period"])
    assert int(late["period_number"][0]) == 10**6
    expected = np.cos(1.3 * late["phase"].values)
    assert np.allclose(late["force"], expected, rtol=0, atol=1e-12)
    speed = expected - late["x"].values
    assert np.allclose(late["speed"], speed, rtol=0, atol=1e-12)


@pytest.mark.parametrize("shift", [0.0, 1e-3, 1e-6, 1e-9, 1e-12, -1e-9])
def test_resonance_of_an_undamped_oscillator(shift):
    # x'' + x = cos(w t) from rest with w = 1 + shift: x = 2 sin(d t) sin(s t)/((w-1)(w+1)),
    # d, s half the difference and the sum of the frequencies; t sin(t)/2 in the limit.
    w = 1.0 + shift
    system = System(
        states=["x", "v"],
        parameters={"w": w},
        modes={"m": Mode({"x": "v", "v": "cos(w*t) - x"})},
    )
    times = np.array([1.0, 10.0, 100.0, 300.0])
    run = ns.simulate(system, times=times)
    half = (w - 1.0) / 2
    beat = times / 2 if half == 0.0 else np.sin(half * times) / (2 * half)
    expected = 2 * beat * np.sin((1 + w) / 2 * times) / (1 + w)
    # x grows like t/2 and its angle is off by t eps
    assert np.allclose(run["x"], expected, rtol=0, atol=10 * EPS * 300**2)


SYSTEMS = {
    "critical damping": [[0, 1], [-1, -2]],
    "nearly critical": [[0, 1], [-1, -2 * (1 - 1e-9)]],
    "two identical oscillators": [[0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1], [0, 0, -1, 0]],
    "one drives its twin": [[0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1], [1, 0, -1, 0]],
    "free-free pair of masses": [
        [0, 1, 0, 0],
        [-1, -0.1, 1, 0.1],
        [0, 0, 0, 1],
        [1, 0.1, -1, -0.1],
    ],
    "undamped free-free pair": [[0, 1, 0, 0], [-1, 0, 1, 0], [0, 0, 0, 1], [1, 0, -1, 0]],
    "stiffness 1e9": [[0, 1], [-1e9, -1e3]],
    "stiff and slow": [[-1e6, 1], [0, -1]],
    "a cycle of three": [[0, 1, 0], [0, 0, 1], [-1, 0, 0]],
    "nothing moves": [[0, 0], [0, 0]],
    "integrators": [[0, 1, 0], [0, 0, 1], [0, 0, 0]],
}


@pytest.mark.parametrize("name", SYSTEMS)
def test_motions_of_every_kind(name):
    matrix = SYSTEMS[name]
    n = len(matrix)
    states = [f"x{i}" for i in range(n)]
    rows = {
        f"x{i}": " + ".join(f"({a!r})*x{j}" for j, a in enumerate(row))
        for i, row in enumerate(matrix)
    }
    start = [1.0, -0.5, 0.25, 2.0][:n]
    system = System(states=states, modes={"m": Mode(rows)})
    speed = max(1.0, max(abs(a) for row in matrix for a in row) ** (0.5 if n == 2 else 1.0))
    t_end = 20.0 / speed
    run = ns.simulate(system, dict(zip(states, start, strict=True)), times=[0.0, t_end])
    truth = [float(x) for x in exact_flow(matrix, start, t_end, digits=20)]
    found = [float(run[state][-1]) for state in states]
    # sizes of the terms behind each state: energy-like for oscillators, so 20 turns of eps
    sizes = np.abs(np.array(truth)) + np.array([np.abs(run[s]).max() for s in states])
    assert np.all(
        np.abs(np.array(found) - truth) < 200 * EPS * np.maximum(sizes, max(sizes) / speed)
    )


def test_a_huge_gap_and_names_of_one_letter():
    # E, I and e are ordinary names; free fall of 1e9 takes sqrt(2e9)
    system = System(
        states=["E", "e"],
        parameters={"I": "1/1", "S": "1e9", "N": "0.5"},
        modes={"Q": Mode({"E": "e", "e": "I"}, exits=[Exit("S - E", reset={"e": "-N*e"})])},
    )
    run = ns.simulate(system, times=[0.0, 4.5e4])
    assert float(run["event_time"][1]) == pytest.approx(np.sqrt(2e9), rel=1e-13)


@pytest.mark.parametrize(
    ("condition", "turns", "end"),
    [
        ("x > 1 and y > 0.5", 2.0, 4.0),  # x = 1 at t = 1, y = 0.5 at t = 2
        ("x > 1 or y > 0.5", 1.0, 5.0),
        ("not (x < 1 or y < 0.5)", 2.0, 4.0),
        ("0.25 < y < 0.5", 1.0, 4.0),  # twice as fast from t = 1 to t = 2
    ],
)
def test_regions_of_joined_conditions(condition, turns, end):
    flow = {"x": f"where({condition}, 2, 1)", "y": "0.25"}
    run = ns.simulate(System(states=["x", "y"], equations=flow), times=[0.0, 3.0])
    times = run["event_time"].values
    assert np.abs(times - turns).min() < 8 * EPS
    assert float(run["x"][-1]) == pytest.approx(end, abs=32 * EPS)
