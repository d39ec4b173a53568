"""Fits of machines whose states fit two modes, as those of a latch or a thermostat."""

from math import cos, pi

import numpy as np
import pytest
import synthetic_motions as machines

import nonsmooth as ns
from fitting.truth import dataset
from nonsmooth.fitting.restart import fitted_shooting

SPEED = 0.9
PERIOD = 2.0 * pi / SPEED
LATCH = {"k": 3.0, "a": 0.8, "b": 0.2, "z": 0.05}
LATCH_FREE = {"k": (1.0, 6.0), "a": (0.5, 1.2), "b": (0.0, 0.45), "z": (0.005, 0.2)}
ROOM = {"c": 0.25, "q": 6.0}  # loss to the outside and heater, per hour
ROOM_NOISE = 0.02
LIMIT = 4.0  # standard errors: one estimate in 16 000 is further off


def latch_motion(times, start, begin):
    """A mass that a second spring catches at ``a`` and leaves at ``b``, by DOP853."""

    def spring(x, stiffness):
        return x + stiffness * (x - LATCH["b"])

    def mode(name):
        stiffness, place, to = {
            "loose": (0.0, LATCH["a"], "latched"), "latched": (LATCH["k"], LATCH["b"], "loose"),
        }[name]  # fmt: skip
        return machines.Mode(
            name,
            lambda t, y: (y[1], cos(SPEED * t) - 2.0 * LATCH["z"] * y[1] - spring(y[0], stiffness)),
            (machines.Exit(lambda t, y: y[0] - place, 1 if name == "loose" else -1,
                           lambda t, y: (mode(to), y)),),
        )  # fmt: skip

    machine = machines.Machine(lambda t, y: mode(begin), PERIOD, 2, machines.EXPLICIT)
    return machines.motion(machine, times, start)


def latch():
    return ns.System(
        states=["x", "v"], parameters=LATCH | {"k": 2.0, "w": SPEED}, period="2*pi/w",
        modes={
            "loose": ns.Mode(
                {"x": "v", "v": "cos(w*t) - 2*z*v - x"}, exits=[ns.Exit("a - x", to="latched")]
            ),
            "latched": ns.Mode(
                {"x": "v", "v": "cos(w*t) - 2*z*v - x - k*(x - b)"},
                exits=[ns.Exit("x - b", to="loose")],
            ),
        },
    )  # fmt: skip


def room_motion(times, begin):
    """A room that a heater warms from 19 to 21 degrees, by DOP853; outside it is 8 ± 4."""

    def mode(name):
        heat, place, to = {"on": (ROOM["q"], 21.0, "off"), "off": (0.0, 19.0, "on")}[name]
        return machines.Mode(
            name,
            lambda t, y: (heat - ROOM["c"] * (y[0] - 8.0 - 4.0 * cos(pi * t / 12.0)),),
            (machines.Exit(lambda t, y: y[0] - place, 1 if name == "on" else -1,
                           lambda t, y: (mode(to), y)),),
        )  # fmt: skip

    machine = machines.Machine(lambda t, y: mode(begin), 24.0, 1, machines.EXPLICIT)
    return machines.motion(machine, times, [20.0])


def room():
    outside = "8 + 4*cos(2*pi*t/24)"
    return ns.System(
        states=["T"], parameters={"c": 0.2, "q": 5.0}, period=24.0, initial={"T": 20.0},
        modes={
            "off": ns.Mode({"T": f"-c*(T - ({outside}))"}, exits=[ns.Exit("T - 19", to="on")]),
            "on": ns.Mode({"T": f"q - c*(T - ({outside}))"}, exits=[ns.Exit("21 - T", to="off")]),
        },
    )  # fmt: skip


def latch_record(motion, seed, share=0.02):
    x = motion.states[:, 0]
    noise = np.random.default_rng(seed).standard_normal(x.size)
    return dataset(motion.times, probe=x + share * x.std() * noise)


def room_record(begin):
    times = np.arange(0.0, 96.0, 0.1)
    noise = np.random.default_rng(1).standard_normal(times.size)
    return dataset(times, T=room_motion(times, begin).states[:, 0] + ROOM_NOISE * noise)


def check_truth(found, truth):
    off = found["estimate"] - [truth[str(name)] for name in found["parameter"].values]
    assert np.all(np.abs(off) < LIMIT * found["standard_error"])
    assert found.attrs["status"] == "completed"


@pytest.mark.slow
def test_segments_of_a_latch_give_what_one_segment_gives():
    """Most of the segments begin where the mass fits both modes."""
    times = np.arange(12 * 60) * PERIOD / 60
    record = latch_record(latch_motion(times, [0.3, 0.1], "loose"), 103)
    whole, cut = (
        ns.fit(latch(), record, LATCH_FREE, {"probe": "x"}, starts=1, segments=segments)
        for segments in (1, None)
    )
    check_truth(cut, LATCH)
    # the solver ends where the cost falls by less than 1e-10 of itself, which is near 300: that is
    # 2e-4 standard errors, and gaps within their limit move the motion as little
    errors = whole["standard_error"]
    assert np.all(np.abs(cut["estimate"] - whole["estimate"]) < 0.01 * errors)
    np.testing.assert_allclose(cut["standard_error"], errors, rtol=0.01)


@pytest.mark.parametrize("begin", ["off", "on"])
@pytest.mark.parametrize("segments", [None, 1])
def test_a_thermostat_may_begin_on_or_off(begin, segments):
    """The first temperature fits both, and only the data tell in which one it begins."""
    record = room_record(begin)
    free = {"c": (0.24, 0.26), "q": (5.8, 6.2)}
    found = ns.fit(room(), record, free, starts=1, segments=segments)
    check_truth(found, ROOM)
    # relative error of a standard deviation of n normal values: 1/sqrt(2 n)
    limit = LIMIT / np.sqrt(2.0 * found.sizes["time"])
    assert found["noise"].item() == pytest.approx(ROOM_NOISE, rel=limit)
    ahead = found["residual"].where(found["held_back"]).values
    assert np.nanstd(ahead) < 1.5 * ROOM_NOISE


@pytest.mark.few(1)
@pytest.mark.parametrize("begin", ["off", "on"])
def test_modes_of_a_thermostat_are_found_far_from_its_parameters(begin):
    """At first each segment begins in the mode that its own data want."""
    found = ns.fit(room(), room_record(begin), {"c": (0.1, 0.5), "q": (3.0, 9.0)}, starts=1)
    check_truth(found, ROOM)


def test_what_goes_on_from_a_fit_begins_in_its_mode():
    found = ns.fit(room(), room_record("on"), {"c": (0.24, 0.26), "q": (5.8, 6.2)}, starts=1)
    shooting, u, noise = fitted_shooting(found)
    again = shooting.evaluate(u, noise)
    fitted = found["residual"].values[~found["held_back"].values]
    np.testing.assert_allclose(again.rows.residual * noise[0], -fitted, atol=1e-9)


def settled_latch():
    """A steady motion that begins while the mass is latched, on its way from ``a`` to ``b``."""
    times = np.arange(60 * 60) * PERIOD / 60
    before = latch_motion(times, [0.3, 0.1], "loose")
    late = np.flatnonzero(times > 40.0 * PERIOD)
    inside = (before.modes == "latched") & (before.states[:, 0] < LATCH["a"])
    first = late[inside[late]][0]
    return machines.Motion(
        times[first:], before.states[first:], before.rates[first:], before.modes[first:],
        before.event_times, before.event_modes,
    )  # fmt: skip


@pytest.mark.few(1)
@pytest.mark.parametrize("segments", [None, 1])
def test_a_cycle_of_a_latch_begins_in_the_mode_of_its_end(segments):
    motion = settled_latch()
    found = ns.fit(
        latch(), latch_record(motion, 5, 0.002), LATCH_FREE, {"probe": "x"}, form="steady",
        starts=1, segments=segments,
    )  # fmt: skip
    check_truth(found, LATCH)
