"""Motions of structures with contacts by scipy alone, in the coordinates of the full model.

Nothing of the library is used: matrices are numpy's, pieces are integrated by DOP853, and the end
of each piece is a root of the dense output, polished by short integrations.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

TOLERANCE = {"rtol": 3e-14, "atol": 1e-15}


@dataclass(frozen=True)
class Spring:
    """k (b q - gap) + c b q' along b, where b q > gap and the force pushes."""

    along: np.ndarray
    gap: float
    stiffness: float
    damping: float = 0.0


@dataclass(frozen=True)
class Wall:
    """b q <= gap, with restitution."""

    along: np.ndarray
    gap: float
    restitution: float


class Event(NamedTuple):
    time: float
    state: np.ndarray
    springs: list[str]


Guard = tuple[Callable[[np.ndarray], float], int, str]


class Bench:
    """A structure M q'' + C q' + K q = f(t) with springs and walls."""

    def __init__(
        self,
        mass: np.ndarray,
        damping: np.ndarray,
        stiffness: np.ndarray,
        force: Callable[[float], np.ndarray],
        springs: Sequence[Spring] = (),
        walls: Sequence[Wall] = (),
    ) -> None:
        self.n = len(mass)
        self.inverse = np.linalg.inv(mass)
        self.damping, self.stiffness, self.force = damping, stiffness, force
        self.springs, self.walls = springs, walls

    def depth(self, spring: Spring, state: np.ndarray) -> float:
        return float(spring.along @ state[: self.n]) - spring.gap

    def push(self, spring: Spring, state: np.ndarray) -> float:
        rate = float(spring.along @ state[self.n :])
        return spring.stiffness * self.depth(spring, state) + spring.damping * rate

    def state_of(self, spring: Spring, state: np.ndarray) -> str:
        """A spring is free, closed, or relaxed: within its gap, where it would have to pull."""
        if self.depth(spring, state) <= 0.0:
            return "free"
        return "closed" if self.push(spring, state) > 0.0 else "relaxed"

    def rates(self, time: float, state: np.ndarray, springs: Sequence[str]) -> np.ndarray:
        q, v = state[: self.n], state[self.n :]
        total = self.force(time) - self.damping @ v - self.stiffness @ q
        for spring, each in zip(self.springs, springs, strict=True):
            if each == "closed":
                total = total - spring.along * self.push(spring, state)
        return np.concatenate([v, self.inverse @ total])

    def guards(self, springs: Sequence[str]) -> list[Guard]:
        """Positive inside the piece, with what becomes of which spring, or which wall is hit."""
        found: list[Guard] = []
        for i, (spring, each) in enumerate(zip(self.springs, springs, strict=True)):
            if each == "free":
                found.append((lambda y, s=spring: -self.depth(s, y), i, "closed"))
            elif each == "closed" and spring.damping:
                found.append((lambda y, s=spring: self.push(s, y), i, "relaxed"))
            else:
                found.append((lambda y, s=spring: self.depth(s, y), i, "free"))
            if each == "relaxed":
                found.append((lambda y, s=spring: -self.push(s, y), i, "closed"))
        for i, wall in enumerate(self.walls):
            found.append((lambda y, w=wall: w.gap - float(w.along @ y[: self.n]), i, "hit"))
        return found

    def run(self, state: np.ndarray, events: int, until: float) -> list[Event]:
        """Events one after the other, with the states behind them."""
        time, log = 0.0, []
        springs = [self.state_of(s, state) for s in self.springs]
        while len(log) < events:
            step = self._piece(time, state, springs, until)
            if step is None:
                break
            time, state, which, becomes = step
            if becomes == "hit":
                wall = self.walls[which]
                push = self.inverse @ wall.along
                speed = float(wall.along @ state[self.n :])
                state = state.copy()
                state[self.n :] -= (1 + wall.restitution) * speed * push / (wall.along @ push)
            else:
                springs = [becomes if i == which else s for i, s in enumerate(springs)]
            log.append(Event(time, state, springs))
        return log

    def _piece(
        self, time: float, state: np.ndarray, springs: Sequence[str], until: float
    ) -> tuple[float, np.ndarray, int, str] | None:
        guards = self.guards(springs)
        short = 1e-6  # behind an event its own guard is zero

        solved = solve_ivp(
            self.rates,
            (time, until),
            state,
            method="DOP853",
            args=(springs,),
            events=[_falling(guard, time + short) for guard, *_ in guards],
            max_step=0.02,
            **TOLERANCE,
        )
        if solved.status != 1:
            return None
        found = next(i for i, times in enumerate(solved.t_events) if len(times))
        guard, which, becomes = guards[found]
        near, begin, at = float(solved.t_events[found][0]), solved.t[-2], solved.y[:, -2]

        def after(t: float) -> np.ndarray:
            if t == begin:
                return at
            part = solve_ivp(
                self.rates, (begin, t), at, method="DOP853", args=(springs,), **TOLERANCE
            )
            return part.y[:, -1]

        width = 1e-7
        low, high = max(near - width, begin), near + width
        root = brentq(lambda t: guard(after(t)), low, high, xtol=1e-15, rtol=1e-15)
        return root, after(root), which, becomes


def _falling(guard: Callable[[np.ndarray], float], since: float) -> Callable[..., float]:
    def event(t: float, y: np.ndarray, springs: Sequence[str]) -> float:
        return guard(y) if t > since else 1.0

    event.terminal, event.direction = True, -1  # type: ignore[attr-defined]  # scipy's way
    return event


def chain(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness of a rod of unit length, mass and stiffness, held at its left end."""
    stiffness = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    stiffness[-1, -1] = 1.0
    return np.eye(n) / n, n * stiffness


def beam(elements: int, length: float = 1.0) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Mass and stiffness of a cantilever of Euler and Bernoulli, EI = m = 1, and names.

    Cubic elements; the first node is held. Coordinates are ``1y 1rz 2y 2rz ...``.
    """
    h = length / elements
    inertia = h / 420 * np.array(
        [
            [156, 22 * h, 54, -13 * h],
            [22 * h, 4 * h**2, 13 * h, -3 * h**2],
            [54, 13 * h, 156, -22 * h],
            [-13 * h, -3 * h**2, -22 * h, 4 * h**2],
        ]
    )  # fmt: skip
    stiff = np.array(
        [
            [12, 6 * h, -12, 6 * h],
            [6 * h, 4 * h**2, -6 * h, 2 * h**2],
            [-12, -6 * h, 12, -6 * h],
            [6 * h, 2 * h**2, -6 * h, 4 * h**2],
        ]
    ) / h**3  # fmt: skip
    n = 2 * (elements + 1)
    mass, stiffness = np.zeros((n, n)), np.zeros((n, n))
    for i in range(elements):
        at = slice(2 * i, 2 * i + 4)
        mass[at, at] += inertia
        stiffness[at, at] += stiff
    names = [f"{i}{d}" for i in range(1, elements + 1) for d in ("y", "rz")]
    return mass[2:, 2:], stiffness[2:, 2:], names
