"""A hundred synthetic records of six machines, each with what made it and a start far off.

`case(k)` draws the k-th one: a machine with some parameters, a length of 10 to 100 events, noise
of 1 to 5 %, one of four kinds of sensors, and a start of a fit within 50 % of each parameter. Kinds
differ in what a fit knows of them:

- ``white``: white noise, as the fit assumes;
- ``coloured``: noise that remembers, which the fit does not know;
- ``sensor``: a filter, a gain, coloured noise, marks that jitter, a recorder of 12 bits; the fit is
  told that gain and delay are open, and knows of nothing else;
- ``model``: coloured noise, and a machine with a small mass or a cubic spring of which the model
  knows nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import synthetic_motions as motions
import xarray as xr
from synthetic_sensors import Sensor, fine_times, record

KINDS = ("white", "coloured", "sensor", "model")
NOISE = (0.01, 0.02, 0.05)
PER_PERIOD = 60
CUBIC = 0.002  # over the linear stiffness, at a displacement of one


class Plan(NamedTuple):
    """A machine, what is drawn of it, and what is recorded and fitted."""

    name: str
    draw: Callable[[np.random.Generator], dict[str, float]]
    free: tuple[str, ...]
    observe: dict[str, str]
    shows: Callable[[motions.Motion], dict[str, np.ndarray]]
    start: tuple[float, ...]
    events: float  # per period, about
    errors: tuple[str, ...]  # of the model that this machine may have


class Case(NamedTuple):
    """A record, and all that a fit is given."""

    number: int
    plan: Plan
    kind: str
    noise: float
    parameters: dict[str, float]
    record: xr.Dataset
    free: dict[str, tuple[float, float]]
    options: dict[str, Any]
    n_events: int

    @property
    def truth(self) -> dict[str, float]:
        """True values of the parameters that a fit finds."""
        return {name: self.parameters[name] for name in self.plan.free}


def _position(found: motions.Motion) -> dict[str, np.ndarray]:
    return {"x": found.states[:, 0]}


PLANS = (
    Plan(
        "soft_impact",
        lambda rng: {
            "beta": rng.uniform(10, 40), "e": rng.uniform(0.4, 0.9),
            "zeta": rng.uniform(0.01, 0.05), "omega": rng.uniform(0.7, 1.0),
        },
        ("beta", "e", "zeta"), {"x": "x"}, _position, (0.3, 0.1), 2.0, ("small", "cubic"),
    ),
    Plan(
        "impact_oscillator",
        lambda rng: {
            "r": rng.uniform(0.5, 0.85), "sigma": rng.uniform(0.1, 0.5),
            "zeta": rng.uniform(0.02, 0.1), "omega": rng.uniform(0.9, 1.5),
        },
        ("r", "sigma", "zeta"), {"x": "x"}, _position, (-0.2, 0.1), 1.0, ("small", "cubic"),
    ),
    Plan(
        "fatigue_rig",
        lambda rng: {
            "eta": rng.uniform(2.5, 3.2), "lambda1": rng.uniform(1.8, 2.5),
            "lambda2": rng.uniform(1.8, 2.5), "theta": rng.uniform(7.0, 9.0),
            "f1": rng.uniform(3.5, 4.5), "f2": rng.uniform(3.0, 4.0),
        },
        ("theta", "xi_p1", "lambda1"), {"x1": "X1", "x2": "X4"},
        lambda found: {"x1": found.states[:, 0], "x2": found.states[:, 3]},
        (0.0, 0.0, 0.0, 0.0, 0.0), 4.0, ("cubic",),
    ),
    Plan(
        "breathing_crack",
        lambda rng: {"crack": rng.uniform(9.0, 13.0), "eta": rng.uniform(1.0, 1.3)},
        ("crack", "xi", "s"), {"x": "u"}, _position, (0.3, 0.0), 4.0, ("small", "cubic"),
    ),
    Plan(
        "rotor",
        lambda rng: {
            "eta": rng.uniform(1.8, 2.3), "delta_x": rng.uniform(0.05, 0.12),
            "delta_y": rng.uniform(0.05, 0.12), "K": rng.uniform(20.0, 40.0),
            "eps_x": rng.uniform(0.85, 0.95),
        },
        ("K", "nu1", "eps_x"), {"x": "x", "y": "y"},
        lambda found: {"x": found.states[:, 0], "y": found.states[:, 1]},
        (0.0, 0.0, 0.0, 0.0), 2.0, ("cubic",),
    ),
    Plan(
        "moling",
        lambda rng: {
            "a": rng.uniform(0.25, 0.4), "b": rng.uniform(0.1, 0.2), "xi": rng.uniform(0.03, 0.1),
            "omega": rng.uniform(0.25, 0.5),
        },
        ("a", "b", "xi"), {"x": "p + v", "a": "acceleration"},  # of the slider nothing is seen
        lambda found: {"x": found.states[:, 0] + found.states[:, 3], "a": found.rates[:, 1]},
        (0.0, 0.0, 0.0, 0.0), 4.0, ("small",),
    ),
)  # fmt: skip


def sensor_of(kind: str, noise: float, rng: np.random.Generator) -> Sensor:
    """A sensor of one of the kinds."""
    if kind == "white":
        return Sensor(noise)
    if kind == "sensor":
        return Sensor(
            noise, colour=rng.uniform(0.3, 0.8), band=rng.uniform(0.3, 0.5), jitter=1e-3,
            gain=rng.uniform(0.9, 1.1), delay=rng.uniform(0.0, 0.8), bits=12,
        )  # fmt: skip
    return Sensor(noise, colour=rng.uniform(0.5, 0.9))


def kind_of(number: int) -> tuple[Plan, str]:
    """Machine and kind of a record by its number."""
    return PLANS[number % len(PLANS)], KINDS[number // len(PLANS) % len(KINDS)]


def case(number: int) -> Case:
    """A record by its number; the same one whenever it is asked for."""
    rng = np.random.default_rng([number, 113])
    plan, kind = kind_of(number)
    noise = NOISE[number // (len(PLANS) * len(KINDS)) % len(NOISE)]
    drawn = plan.draw(rng)
    error: dict[str, Any] = {}
    if kind == "model":
        what = plan.errors[rng.integers(len(plan.errors))]
        error = {what: CUBIC if what == "cubic" else motions.SMALL_MASS}
    machine = getattr(motions, plan.name)(**drawn, **error)
    wanted = np.exp(rng.uniform(np.log(10.0), np.log(100.0)))
    periods = max(5, round(wanted / plan.events))
    step = machine.period / PER_PERIOD
    times = fine_times(0.0, step, PER_PERIOD * periods)
    small = (plan.start[0], 0.0) if "small" in error else ()
    found = motions.motion(machine, times, plan.start + small)
    sensors = {name: sensor_of(kind, noise, rng) for name in plan.observe}
    options: dict[str, Any] = {}
    if kind == "sensor":
        options = {"gain": (0.7, 1.4), "delay": (-2.0 * step, 4.0 * step)}
    parameters = getattr(motions, plan.name.upper()) | drawn
    return Case(
        number, plan, kind, noise, parameters,
        record(step, machine.period, plan.shows(found), sensors, times, rng),
        {name: bounds_of(parameters[name], name, rng) for name in plan.free},
        options, found.event_times.size,
    )  # fmt: skip


def with_noise_again(number: int, colour: float, seed: int) -> Case:
    """The machine and the motion of a record, right in all but the noise, which is drawn anew.

    Bounds are near the truth, so that each fit comes to the right optimum.
    """
    known = case(number)
    machine = getattr(motions, known.plan.name)(
        **{key: known.parameters[key] for key in known.plan.draw(np.random.default_rng(0))}
    )
    step, count = machine.period / PER_PERIOD, known.record.sizes["time"]
    times = fine_times(0.0, step, count)
    found = _motion_again(number, machine, count)
    sensors = dict.fromkeys(known.plan.observe, Sensor(known.noise, colour=colour))
    rng = np.random.default_rng([number, seed, 7])
    free = {
        key: (0.75 * true, min(1.25 * true, 0.99) if key == "r" else 1.25 * true)
        for key, true in known.truth.items()
    }
    return known._replace(
        kind="coloured" if colour else "white", free=free, options={},
        record=record(step, machine.period, known.plan.shows(found), sensors, times, rng),
    )  # fmt: skip


_MOTIONS: dict[int, motions.Motion] = {}


def _motion_again(number: int, machine: motions.Machine, count: int) -> motions.Motion:
    """Motion of a record, integrated once for all its noises."""
    if number not in _MOTIONS:
        plan = PLANS[number % len(PLANS)]
        times = fine_times(0.0, machine.period / PER_PERIOD, count)
        _MOTIONS[number] = motions.motion(machine, times, plan.start)
    return _MOTIONS[number]


def bounds_of(truth: float, name: str, rng: np.random.Generator) -> tuple[float, float]:
    """Bounds of a parameter whose middle, where a fit starts, is off by up to 50 %."""
    middle, half = truth * (1.0 + rng.uniform(-0.5, 0.5)), 0.75 * truth
    low, high = max(middle - half, 0.02 * truth), middle + half
    if name == "r":  # no impact feeds energy in
        return low, min(high, 0.99)
    if name == "crack":  # of the specimen of this law, in mm
        return max(low, 5.1), min(high, 18.0)
    return low, high
