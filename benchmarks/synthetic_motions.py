"""Motions of six machines for synthetic records, from integrators of scipy: no code of the engine.

The equations are written by hand from the physics, each mode by itself: DOP853, or for the rig,
whose massless specimen is stiff, LSODA. An event ends a mode where its guard passes zero, and the
next mode starts there. `tests/fitting/test_synthetic_motions.py` holds each machine beside the
engine. A motion may have an error that no model of it knows: a small mass on a spring, with its
own natural mode, and a spring that is slightly cubic.
"""

from __future__ import annotations

from collections.abc import Callable
from math import copysign, cos, exp, hypot, log, pi, sin
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

SOFT_IMPACT = {"omega": 0.85, "zeta": 0.01, "beta": 29.0, "e": 1.26, "a": 0.7}
IMPACT_OSCILLATOR = {"omega": 1.3, "zeta": 0.05, "F": 1.0, "sigma": 0.4, "r": 0.8}
BREATHING_CRACK = {"xi": 0.014, "eta": 1.1475, "crack": 11.3, "d": 0.0, "s": 1.0}
FATIGUE_RIG = {
    "eta": 2.5, "lambda1": 4.36, "lambda2": 4.36, "theta": 7.828, "eps": 0.002012, "f1": 5.44,
    "f2": 3.52, "xi_Ls": 0.00255, "xi_s": 0.002, "xi_p1": 0.4, "xi_p2": 0.4,
}  # fmt: skip
ROTOR = {
    "eta": 2.442, "nu1": 0.125, "nu2": 0.002, "K": 30.0, "eta_m": 0.0017, "rho": 70.0,
    "eps_x": 0.9, "eps_y": 0.0, "delta_x": 0.1, "delta_y": 0.1, "phi0": 0.0,
}  # fmt: skip
MOLING = {"a": 0.3, "b": 0.15, "xi": 0.05, "omega": 0.3, "g": 0.02, "phi": pi / 2}

# relative and absolute errors of a step; those of a motion are held beside the engine
EXPLICIT = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-12}
STIFF = {"method": "LSODA", "rtol": 1e-11, "atol": 1e-13}
LONGEST = 0.02  # step, in periods: a visit to a wall is seldom so short as to lie within one
SMALL_MASS = (0.02, 4.7, 0.02)  # over that of the machine; natural frequency; damping ratio


class Exit(NamedTuple):
    """Where a mode ends, and how the motion goes on."""

    guard: Callable[[float, Any], float]
    direction: int  # in which the guard passes zero
    follow: Callable[[float, Any], tuple[Mode, Any]]


class Mode(NamedTuple):
    """Smooth equations with their ends."""

    name: str
    rates: Callable[[float, Any], Any]
    exits: tuple[Exit, ...]
    blind: float = 0.0  # time without exits, where a guard begins with a double root at zero


class Machine(NamedTuple):
    """What a motion needs."""

    begin: Callable[[float, Any], Mode]
    period: float
    n_states: int  # without those of a small mass
    accuracy: dict[str, Any]


class Motion(NamedTuple):
    """States and rates at K instants, and all events."""

    times: np.ndarray  # (K,)
    states: np.ndarray  # (K, n)
    rates: np.ndarray  # (K, n)
    modes: np.ndarray  # (K,) names
    event_times: np.ndarray
    event_modes: np.ndarray  # names of the modes that follow


def motion(machine: Machine, times: np.ndarray, start: Any) -> Motion:
    """The motion from the first of some times on, from event to event."""
    t, y, end = float(times[0]), np.array(start, float), float(times[-1])
    mode, done, events = machine.begin(t, y), 0, []
    step = LONGEST * machine.period
    states, rates, modes = [], [], []
    while done < times.size:
        blind = mode.blind > 0.0 and t + mode.blind < end
        guards = [] if blind else [_terminal(each) for each in mode.exits]
        piece = solve_ivp(
            mode.rates, (t, t + mode.blind if blind else end + 1e-9), y, events=guards or None,
            dense_output=True, max_step=step, **machine.accuracy,
        )  # fmt: skip
        if piece.status < 0:
            raise RuntimeError(f"{mode.name}: {piece.message}")
        t, y = float(piece.t[-1]), piece.y[:, -1]
        here = times[done:][times[done:] <= t]
        if here.size:
            found = piece.sol(here).T
            states.append(found)
            rates += [mode.rates(when, each) for when, each in zip(here, found, strict=True)]
            modes += [mode.name] * here.size
            done += here.size
        if blind:
            mode = mode._replace(blind=0.0)
        elif piece.status == 1:
            fired = next(k for k, each in enumerate(piece.t_events) if each.size)
            t, y = float(piece.t_events[fired][0]), piece.y_events[fired][0]
            mode, y = mode.exits[fired].follow(t, y)
            events.append((t, mode.name))
        else:
            break
    return Motion(
        times, np.concatenate(states), np.array(rates), np.array(modes),
        np.array([each[0] for each in events]), np.array([each[1] for each in events]),
    )  # fmt: skip


def _terminal(given: Exit) -> Callable[[float, Any], float]:
    def guard(t: float, y: Any) -> float:
        return given.guard(t, y)

    guard.terminal, guard.direction = True, given.direction  # type: ignore[attr-defined]
    return guard


class Body(NamedTuple):
    """Rates of a mass under a force, with a small mass on it if there is one."""

    small: tuple[float, float, float] | None

    def rates(self, y: Any, force: float) -> tuple[float, ...]:
        """Of position, velocity, and those of the small mass, which come last in the state."""
        if self.small is None:
            return y[1], force
        ratio, frequency, damping = self.small
        w, u = y[-2], y[-1]
        pull = frequency**2 * (w - y[0]) + 2.0 * damping * frequency * (u - y[1])
        return y[1], force + ratio * pull, u, -pull


def _two_sided(
    names: tuple[str, str], rates: Callable[[bool], Any], guard: Any
) -> Callable[[float, Any], Mode]:
    """Modes on both sides of a surface that a continuous force crosses."""

    def mode(inside: bool) -> Mode:
        leave = Exit(guard, -1 if inside else 1, lambda t, y: (mode(not inside), y))
        return Mode(names[int(inside)], rates(inside), (leave,))

    return lambda t, y: mode(guard(t, y) > 0.0)


def soft_impact(cubic: float = 0.0, small: Any = None, **changed: float) -> Machine:
    """A mass that meets a second spring."""
    p, body = SOFT_IMPACT | changed, Body(small)
    drive, damping, omega, e = p["a"] * p["omega"] ** 2, 2.0 * p["zeta"], p["omega"], p["e"]

    def rates(contact: bool) -> Any:
        beta = p["beta"] if contact else 0.0

        def of(t: float, y: Any) -> Any:
            x = y[0]
            force = drive * sin(omega * t) - damping * y[1] - x - cubic * x**3 - beta * (x - e)
            return body.rates(y, force)

        return of

    begin = _two_sided(("free", "contact"), rates, lambda t, y: y[0] - e)
    return Machine(begin, 2.0 * pi / omega, 2, EXPLICIT)


def breathing_crack(cubic: float = 0.0, small: Any = None, **changed: float) -> Machine:
    """A mass on a beam that is softer while its crack is open."""
    p, body = BREATHING_CRACK | changed, Body(small)
    drive, damping, eta = p["eta"] ** 2, 2.0 * p["xi"], p["eta"]
    stiffness = p["s"] * 4.245e-3 * (20.0 - p["crack"]) ** 3, p["s"] * 14.327

    def rates(is_open: bool) -> Any:
        spring = 1.0 + stiffness[0 if is_open else 1]

        def of(t: float, y: Any) -> Any:
            u = y[0]
            force = p["d"] + drive * sin(eta * t) - damping * y[1] - spring * u - cubic * u**3
            return body.rates(y, force)

        return of

    return Machine(
        _two_sided(("closed", "open"), rates, lambda t, y: y[0]), 2.0 * pi / eta, 2, EXPLICIT
    )


def impact_oscillator(cubic: float = 0.0, small: Any = None, **changed: float) -> Machine:
    """A mass that rebounds from a rigid wall; the motion must not come to rest there."""
    p, body = IMPACT_OSCILLATOR | changed, Body(small)
    omega, sigma = p["omega"], p["sigma"]

    def rates(t: float, y: Any) -> Any:
        x = y[0]
        force = p["F"] * cos(omega * t) - 2.0 * p["zeta"] * y[1] - x - cubic * x**3
        return body.rates(y, force)

    def rebound(t: float, y: Any) -> tuple[Mode, Any]:
        if y[1] < 1e-4:
            raise RuntimeError("impacts accumulate, which this motion does not know")
        return free, np.array([sigma, -p["r"] * y[1], *y[2:]])

    free = Mode("free", rates, (Exit(lambda t, y: y[0] - sigma, 1, rebound),))
    return Machine(lambda t, y: free, 2.0 * pi / omega, 2, EXPLICIT)


def fatigue_rig(cubic: float = 0.0, **changed: float) -> Machine:
    """Two masses on a massless specimen between two contacts; the leaf springs may be cubic."""
    p = FATIGUE_RIG | changed
    eta, theta, eps = p["eta"], p["theta"], p["eps"]
    gamma = (p["f1"] - p["f2"]) / (2.0 + theta**2 * (1.0 + eps))
    gap1 = eps * (p["f1"] - gamma) / (1.0 + eps)
    gap2 = -eps * (p["f2"] + gamma) / (1.0 + eps)
    steady1, steady2 = p["f1"] - gamma - gap1, -p["f2"] - gamma - gap2
    springs = 1.0 + p["lambda1"] ** 2, 1.0 + p["lambda2"] ** 2
    dampers = [2.0 * (p["xi_Ls"] + p[f"xi_p{k}"] * p[f"lambda{k}"]) for k in (1, 2)]
    viscous = 2.0 * theta * p["xi_s"]

    def above(t: float, y: Any) -> float:
        return y[0] - y[2] + gap1

    def below(t: float, y: Any) -> float:
        return y[2] - y[3] - gap2

    def mode(first: bool, second: bool) -> Mode:
        def rates(t: float, y: Any) -> Any:
            x1, v1, x3, x4, v4 = y
            push1 = (x1 - x3 + gap1) / eps if first else 0.0
            push2 = (x3 - x4 - gap2) / eps if second else 0.0
            shaking = eta**2 * sin(eta * t)
            return (
                v1,
                shaking + steady1 - push1 - springs[0] * x1 - cubic * x1**3 - dampers[0] * v1,
                (push1 - push2 - theta**2 * (x3 + gamma)) / viscous,
                v4,
                shaking + steady2 + push2 - springs[1] * x4 - cubic * x4**3 - dampers[1] * v4,
            )

        names = {(1, 1): "i", (0, 1): "ii", (1, 0): "iii", (0, 0): "iv"}
        exits = (
            Exit(above, -1 if first else 1, lambda t, y: (mode(not first, second), y)),
            Exit(below, -1 if second else 1, lambda t, y: (mode(first, not second), y)),
        )
        return Mode(names[first, second], rates, exits)

    def begin(t: float, y: Any) -> Mode:
        return mode(above(t, y) > 0.0, below(t, y) > 0.0)

    return Machine(begin, 2.0 * pi / eta, 5, STIFF)


def moling(small: Any = None, **changed: float) -> Machine:
    """A mass that strikes a slider of two plates, which friction holds: state p, y, q, v."""
    p, body = MOLING | changed, Body(small)
    viscous, g = 2.0 * p["xi"], p["g"]

    def forcing(t: float) -> float:
        return p["b"] + p["a"] * cos(p["omega"] * t + p["phi"])

    def push(t: float, y: Any) -> float:
        return viscous * y[1] + y[2]

    def of(y: Any, force: float, p_rate: float, q_rate: float, v_rate: float) -> Any:
        moved = (y[0] + y[3], *y[1:])  # the small mass feels where the mass is
        _, rate, *rest = body.rates(moved, force)
        return (p_rate, rate, q_rate, v_rate, *rest)

    def flight(t: float, y: Any) -> Any:
        return of(y, forcing(t), y[1], -y[2] / viscous, 0.0)

    def contact(t: float, y: Any) -> Any:
        return of(y, forcing(t) - push(t, y), y[1], y[1], 0.0)

    def progression(t: float, y: Any) -> Any:
        slide = (1.0 - y[2]) / viscous
        return of(y, forcing(t) - 1.0, slide, slide, y[1] - slide)

    def impact(t: float, y: Any) -> tuple[Mode, Any]:
        y = np.array([y[2] + g, *y[1:]])
        return (pushed if push(t, y) > 1.0 else held), y

    gone = Exit(lambda t, y: y[0] - y[2] - g, 1, impact)
    free = Mode("no_contact", flight, (gone,))
    # at release gap and its rate are both zero; the gap closes again only after the force has risen
    released = Mode("no_contact", flight, (Exit(push, 1, lambda t, y: (free, y)),))
    pushed: Mode
    held = Mode(
        "contact", contact,
        (Exit(push, -1, lambda t, y: (released, y)),
         Exit(lambda t, y: push(t, y) - 1.0, 1, lambda t, y: (pushed, y))),
    )  # fmt: skip
    pushed = Mode(
        "progression", progression,
        (Exit(lambda t, y: push(t, y) - 1.0, -1, lambda t, y: (held, y)),),
    )  # fmt: skip
    return Machine(lambda t, y: free, 2.0 * pi / p["omega"], 4, EXPLICIT)


class Ring(NamedTuple):
    """A massless ring on the rotor, with one or two springs at work along each axis."""

    place: tuple[float, float]
    normal: tuple[float, float]
    force: tuple[float, float]

    @property
    def pressing(self) -> float:
        """Part of the force along the normal."""
        return self.normal[0] * self.force[0] + self.normal[1] * self.force[1]


def ring_on(y: Any, a: int, b: int, p: dict[str, float]) -> Ring:
    """The ring of least elastic energy at a distance of one from the rotor."""
    far = (
        abs(y[0]) + (p["delta_x"] if a == 1 else 0.0),
        abs(y[1]) + (p["delta_y"] if b == 1 else 0.0),
    )
    mu = hypot(*far) - 1.0
    for _ in range(60):  # Newton's method goes up to the root
        square = (a * far[0] / (a + mu)) ** 2, (b * far[1] / (b + mu)) ** 2
        step = 0.5 * (sum(square) - 1.0) / (square[0] / (a + mu) + square[1] / (b + mu))
        mu += step
        if abs(step) < 1e-15 * (1.0 + abs(mu)):
            break
    d = copysign(a * far[0] / (a + mu), y[0]), copysign(b * far[1] / (b + mu), y[1])
    s = y[0] - d[0], y[1] - d[1]
    weight = 1.0 / (a + mu), 1.0 / (b + mu)
    along = sum(d[k] * y[2 + k] * (1.0 - mu * weight[k]) for k in (0, 1))
    growth = along / sum(weight[k] * d[k] ** 2 for k in (0, 1))
    force = []
    for k, (springs, delta) in enumerate(((a, p["delta_x"]), (b, p["delta_y"]))):
        rate = weight[k] * (growth * d[k] + mu * y[2 + k])
        pull = springs * s[k] + (2 - springs) * copysign(delta, s[k])
        force.append(p["K"] * pull + 2.0 * p["nu2"] * springs * rate)
    return Ring(s, d, (force[0], force[1]))


def rotor(cubic: float = 0.0, **changed: float) -> Machine:
    """A rotor in a ring on preloaded springs; its shaft may be slightly cubic.

    A free ring goes back in closed form, since its rate is in the thousands.
    """
    p = ROTOR | changed
    deltas = p["delta_x"], p["delta_y"]
    unbalance, back = p["eta_m"] * p["rho"] * p["eta"] ** 2, p["K"] / (2.0 * p["nu2"])

    def shaft(t: float, y: Any, fx: float, fy: float) -> Any:
        angle, bent = p["eta"] * t + p["phi0"], (y[0] - p["eps_x"], y[1] - p["eps_y"])
        stiffness = 1.0 + cubic * (bent[0] ** 2 + bent[1] ** 2)
        return (
            y[2],
            y[3],
            unbalance * cos(angle) - 2.0 * p["nu1"] * y[2] - stiffness * bent[0] - fx,
            unbalance * sin(angle) - 2.0 * p["nu1"] * y[3] - stiffness * bent[1] - fy,
        )

    def relaxed(s: float, delta: float, time: float) -> float:
        size, longer = abs(s), 0.0
        if size > delta:  # one spring, whose rest lies at the opposite preload
            longer = log((size + delta) / (2.0 * delta)) / back
            if time < longer:
                return copysign((size + delta) * exp(-back * time) - delta, s)
            size = delta
        return copysign(size * exp(-back * (time - longer)), s)

    def free(since: float, ring: tuple[float, float], blind: float = 0.0) -> Mode:
        def outside(t: float, y: Any) -> float:
            s = [relaxed(ring[k], deltas[k], t - since) for k in (0, 1)]
            return hypot(y[0] - s[0], y[1] - s[1]) - 1.0

        return Mode(
            "free", lambda t, y: shaft(t, y, 0.0, 0.0),
            (Exit(outside, 1, lambda t, y: (touched(t, y), y)),), blind,
        )  # fmt: skip

    def touched(t: float, y: Any) -> Mode:
        for a in (2, 1):
            for b in (2, 1):
                place = ring_on(y, a, b, p).place
                if all((abs(s) <= d) == (n == 2) for s, d, n in zip(place, deltas, (a, b),
                                                                    strict=True)):  # fmt: skip
                    return contact(a, b)
        raise RuntimeError("the ring stands nowhere")

    def switched(t: float, y: Any, a: int, b: int) -> tuple[Mode, Any]:
        """The other number of dampers may leave a force that no longer presses."""
        ring = ring_on(y, a, b, p)
        return (contact(a, b) if ring.pressing > 0.0 else free(t, ring.place, 1e-6)), y

    def contact(a: int, b: int) -> Mode:
        names = {(2, 2): "II", (1, 2): "III", (2, 1): "IV", (1, 1): "V"}
        return Mode(
            names[a, b], lambda t, y: shaft(t, y, *ring_on(y, a, b, p).force),
            (
                Exit(lambda t, y: ring_on(y, a, b, p).pressing, -1,
                     lambda t, y: (free(t, ring_on(y, a, b, p).place, 1e-6), y)),
                Exit(lambda t, y: abs(ring_on(y, a, b, p).place[0]) - deltas[0],
                     1 if a == 2 else -1, lambda t, y: switched(t, y, 3 - a, b)),
                Exit(lambda t, y: abs(ring_on(y, a, b, p).place[1]) - deltas[1],
                     1 if b == 2 else -1, lambda t, y: switched(t, y, a, 3 - b)),
            ),
        )  # fmt: skip

    def begin(t: float, y: Any) -> Mode:
        return free(t, (0.0, 0.0)) if hypot(y[0], y[1]) < 1.0 else touched(t, y)

    return Machine(begin, 2.0 * pi / p["eta"], 4, EXPLICIT)
