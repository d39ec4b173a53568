"""Branches that come back to their start, on whose way events pass the strobe."""

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

import nonsmooth as ns
from nonsmooth.continuation import follow

_DECAY = 1 - np.exp(-1.0)
_FROM = 10.0  # where the room cools to, without its sine


def folds(branch) -> list[float]:
    chosen = branch["special_kind"].values == "fold"
    return sorted(branch["special_value"].values[chosen].tolist())


@pytest.mark.parametrize(
    ("current", "phase", "direction"),
    [(1.58, 0.0, "both"), (1.6, 0.37, "up"), (1.54, 0.0, "down")],
)
def test_a_neuron_that_spikes_once_per_period(current, phase, direction):
    """Over the phase of the spike its current is a sine: one loop, which passes every strobe.

    From 0 behind a spike at s the solution comes to 1 a period later where
    (1 - 1/e) (I + A p(s)) = 1, with p = (cos 2 pi s + 2 pi sin 2 pi s) / (1 + 4 pi^2).
    """
    neuron = ns.System(
        states=["v"],
        period=1.0,
        parameters={"I": current, "A": 0.3},
        modes={
            "charging": ns.Mode(
                {"v": "I - v + A*cos(2*pi*t)"},
                exits=[ns.Exit("1 - v", reset={"v": "0"}, name="spike")],
            )
        },
    )
    chosen = ns.StroboscopicMap(neuron, phase=phase)
    branch = ns.continue_orbit(chosen, "I", (1.1, 3.0), transient=300, direction=direction)
    assert "closed" in (branch.attrs["end_first"], branch.attrs["end_last"])
    swing = 0.3 / np.sqrt(1 + 4 * np.pi**2)
    assert folds(branch) == pytest.approx([1 / _DECAY - swing, 1 / _DECAY + swing], abs=1e-9)
    # both ends are one orbit, and no other one stands twice
    assert branch["v"].values[0] == pytest.approx(branch["v"].values[-1], abs=1e-9)
    steps = np.diff(branch["I"].values)
    ways = np.sign(steps[np.abs(steps) > 1e-12])  # orbits with a spike at the strobe stand twice
    assert np.count_nonzero(np.diff(ways)) == 2


def _room(time, base, frequency):
    """Temperature to which a room without memory of its start comes; it loses 1/5 per time."""
    by = frequency * 5.0
    swing = 4.0 * (np.cos(frequency * time) + by * np.sin(frequency * time)) / (1 + by**2)
    return base + swing


def _cycle_after(time, frequency):
    """How long a thermostat takes from one switching off at 22 to the next, past one on at 18."""

    def first(begin, base, start, end):
        def beyond(wait):
            settled = _room(begin + wait, base, frequency)
            return settled + (start - _room(begin, base, frequency)) * np.exp(-wait / 5.0) - end

        waits = np.linspace(1e-9, 6.0, 2000)
        signs = np.sign(beyond(waits))
        k = int(np.flatnonzero(signs != signs[0])[0])
        return begin + brentq(beyond, waits[k - 1], waits[k], xtol=1e-14)

    on = first(time, _FROM, 22.0, 18.0)
    return first(on, _FROM + 20.0, 18.0, 22.0) - time


def _tongue_edge(sign, between):
    """Frequency at which the longest or shortest cycle of the thermostat lasts one period."""

    def apart(frequency):
        times = np.linspace(0.0, 2 * np.pi / frequency, 60)
        cycles = [sign * _cycle_after(time, frequency) for time in times]
        best, step = times[int(np.argmin(cycles))], times[1]
        found = minimize_scalar(
            lambda time: sign * _cycle_after(time, frequency),
            bounds=(best - step, best + step), method="bounded", options={"xatol": 1e-7},
        )  # fmt: skip
        return sign * found.fun - 2 * np.pi / frequency

    return brentq(apart, *between, xtol=1e-10)


def test_a_thermostat_locked_to_the_day():
    """Its loop lies between the edges of a tongue of its switching map in closed form."""
    thermostat = ns.System(
        states=["T"],
        period="2*pi/om",
        parameters={"om": 1.55},
        initial={"T": 20.0},
        modes={
            "heat": ns.Mode(
                {"T": "(30 + 4*cos(om*t) - T)/5"}, exits=[ns.Exit("22 - T", to="cool", name="off")]
            ),
            "cool": ns.Mode(
                {"T": "(10 + 4*cos(om*t) - T)/5"}, exits=[ns.Exit("T - 18", to="heat", name="on")]
            ),
        },
    )
    branch = ns.continue_orbit(thermostat, "om", (0.8, 2.5), transient=200, steps=60)
    assert branch.attrs["end_last"] == "closed"
    assert len(set(branch["word"].values.tolist())) == 2  # the loop passes the strobe
    edges = [_tongue_edge(-1, (1.1, 1.2)), _tongue_edge(1, (1.9, 2.0))]
    assert folds(branch) == pytest.approx(edges, abs=1e-7)


def test_the_rest_of_a_curve_closes_where_that_began():
    """Half of the unit circle lies between the two points."""
    half = follow(lambda u, p: u**2 + p**2 - 1, -1.0, 0.0, direction=-1)
    half.begun_at(np.array([1.0]), 0.0, (np.array([0.0]), 1.0))
    points = list(half)
    assert half.ended == "closed"
    assert points[-1].u[0] == pytest.approx(1.0, abs=1e-9)
    assert points[-1].arclength == pytest.approx(np.pi, rel=1e-4)


def test_a_loop_that_leads_once_around_an_angle():
    """A rotation number of zero: sin(2 pi th) = 2 pi Om/K, with folds at Om = K/(2 pi)."""
    reset = {"c": "0", "th": "th + Om - K/(2*pi)*sin(2*pi*th)"}
    circle = ns.System(
        states=["th", "c"], parameters={"Om": 0.1, "K": 0.9}, period=1, drift={"th": "1"},
        modes={"hold": ns.Mode({"th": "0", "c": "1"}, exits=[ns.Exit("1 - c", reset=reset)])},
    )  # fmt: skip
    branch = ns.continue_orbit(circle, "Om", (-0.5, 0.5), initial={"th": 0.1})
    assert branch.attrs["end_first"] == "start" and branch.attrs["end_last"] == "closed"
    edge = 0.9 / (2.0 * np.pi)
    assert sorted(folds(branch)) == pytest.approx([-edge, edge], abs=1e-12)
    assert float(np.ptp(branch["th"].values)) == pytest.approx(1.0, abs=1e-9)
