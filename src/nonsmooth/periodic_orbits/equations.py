"""The equations of a periodic orbit of a given word, with their Jacobian.

Unknowns are the states at the start of every leg and the instants of the events between them; the
equations, that each leg leads to the start of the next one, that its guard vanishes at its end,
and that the last leg closes the orbit, but for drifts and whole turns of angles. States at every
leg as unknowns keep an orbit of a hundred legs, or one that is very unstable, within rounding
(multiple shooting); instants as unknowns keep the equations smooth where an orbit grazes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.orbits import Closing, LegResults, close_legs
from nonsmooth.periodic_orbits.legs import Legs, balanced_units
from nonsmooth.periodic_orbits.word import Word
from nonsmooth.runs.whole_turns import periods_of_states, whole_turns

__all__ = ["OrbitEquations", "Turn"]

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Turn:
    """Unknowns of an orbit as they are meant: states at leg starts, and instants of their ends."""

    states: Floats  # (L, n)
    instants: Floats  # (L + 1,)

    @property
    def durations(self) -> Floats:
        """Durations of the legs."""
        return np.diff(self.instants)


_CONSERVED = 1e-12  # singular value of the equations, in units that balance them, that is none
_WITHIN = 0.3819  # of a turn, no whole number of free oscillations
_KEPT = 1e-9  # change of a sum of states that is none
_STEADY = 1e-9  # derivative of the change over a turn, and change beside the state, that are none


class OrbitEquations:
    """Residual and Jacobian of the orbits of one word.

    A driven orbit begins at ``phase`` (part of the period) and lasts ``period`` periods. One of an
    autonomous system begins and ends at an event; where there is none, at the plane through
    ``reference`` across the flow there, or at one that goes along with the cycle (`across`). Values
    of drifting states at the start are those of ``origin``.
    """

    def __init__(
        self,
        legs: Legs,
        word: Word,
        *,
        period: int,
        phase: float = 0.0,
        autonomous: bool = False,
        origin: Floats | None = None,
        reference: Floats | None = None,
    ) -> None:
        self.legs, self.word = legs, word
        self.period, self.phase, self.autonomous = period, phase, autonomous
        n = legs.n
        names = legs.system.states
        self.drifting = np.array([name in legs.system.drift_states for name in names])
        self.angle_periods = periods_of_states(legs.system)  # (n,): zero of what is no angle
        self.origin = np.zeros(n) if origin is None else np.asarray(origin, float)
        self.reference = reference
        self._count = len(word)
        # instants that are unknown: all but the first, and the last of a driven orbit
        self.n_instants = self._count if autonomous else self._count - 1
        self.size = self._count * n + self.n_instants
        self._across = np.zeros(n)  # normal of the plane at the reference
        self._speed = 0.0  # of the flow there
        self._ahead: float | None = None  # height of a plane that goes along, else it stays
        self._may_conserve = True  # until a turn without events has been seen to keep nothing
        self.results: LegResults | None = None

    def of_word(self, word: Word, origin: Floats) -> OrbitEquations:
        """The same for another word, drifts beginning at a given state."""
        return OrbitEquations(
            self.legs, word, period=self.period, phase=self.phase, autonomous=self.autonomous,
            origin=origin, reference=np.array(origin),
        )  # fmt: skip

    def across(
        self, reference: Floats, normal: Floats, half_later: Floats | None = None
    ) -> OrbitEquations:
        """The same for a cycle without events that begins on another plane.

        With the state half a turn later the plane goes along with the cycle: its start is as far
        ahead of its own state half a turn later as it is at the reference.
        """
        other = self.of_word(self.word, reference)
        other.origin = self.origin
        other._across = normal / max(float(np.linalg.norm(normal)), 1e-300)
        if half_later is not None:
            other._ahead = float(other._across @ (reference - half_later))
        return other

    def heights(self, states: Floats) -> Floats:
        """How far ahead of its plane a cycle is, at an even number of places after equal times."""
        assert self.reference is not None
        if self._ahead is None:
            return np.asarray((states - self.reference) @ self._across)
        half_later = np.roll(states, -(len(states) // 2), axis=0)
        return np.asarray((states - half_later) @ self._across - self._ahead)

    def passing(self, turn: Turn, start_rate: Floats) -> Floats:
        """The rate at which the start of a smooth cycle passes its plane, (n,)."""
        if self._ahead is None:
            return start_rate
        return np.asarray(start_rate - self._half_later(turn).end_rates[0])

    def _half_later(self, turn: Turn) -> LegResults:
        """The first half of a smooth cycle; with a leg of no time, for results of one leg stay."""
        word = Word(self.word.modes[:1] * 2, ((),) * 2)
        begins = np.full(2, turn.instants[0])
        length = turn.instants[-1] - turn.instants[0]
        ends = begins + np.array([0.5, 0.0]) * length
        return self.legs.follow_each(word, np.tile(turn.states[0], (2, 1)), begins, ends)

    @property
    def is_smooth_cycle(self) -> bool:
        """Whether nothing drives the orbit and it passes no event."""
        return self.autonomous and not self.word.closes_at_event

    @property
    def normal(self) -> Floats:
        """Normal of the plane on which a cycle without events begins."""
        return self._across

    def pack(self, turn: Turn) -> Floats:
        """Unknowns as one vector."""
        return np.concatenate([turn.states.ravel(), turn.instants[1 : 1 + self.n_instants]])

    def states_along(self, turn: Turn, times: Floats, ahead: Floats | float = 0.0) -> Floats:
        """States of an orbit at some times within its turn, (K, n).

        Those behind events up to a time ``ahead``.
        """
        legs = np.searchsorted(turn.instants[1:-1], times + ahead, side="right")
        return self.states_in_legs(turn, legs, times)

    def states_in_legs(self, turn: Turn, legs: npt.NDArray[np.intp], times: Floats) -> Floats:
        """States at some times, each within a leg of an orbit, (K, n)."""
        word = Word(tuple(self.word.modes[k] for k in legs), ((),) * times.size)
        found = self.legs.follow_each(word, turn.states[legs], turn.instants[legs], times)
        return found.ends.copy()

    def unpack(self, unknowns: Floats) -> Turn:
        """Unknowns as states and instants, for the parameter values of the legs."""
        n, count = self.legs.n, self._count
        states = unknowns[: count * n].reshape(count, n)
        instants = np.zeros(count + 1)
        if not self.autonomous:
            instants[0] = self.phase * self.legs.window
            instants[-1] = (self.phase + self.period) * self.legs.window
        instants[1 : 1 + self.n_instants] = unknowns[count * n :]
        return Turn(states, instants)

    def evaluate(self, unknowns: Floats) -> tuple[Floats, Floats, Floats]:
        """Residual, its Jacobian by the unknowns, and by the chosen parameters.

        shapes: (size,), (size, size), (size, P)
        """
        turn = self.unpack(unknowns)
        found = self.results = self.legs.follow(self.word, turn.states, turn.instants)
        size, n_rates = self.size, self.legs.n_rates
        residual, jacobian = np.empty(size), np.empty((size, size))
        moved = np.empty((size, n_rates))
        rates = self.legs.period_rates
        closing = Closing(
            turn.states, self.n_instants, not self.autonomous, self.phase * rates,
            (self.phase + self.period) * rates, self.drifting, np.ascontiguousarray(self.origin),
            residual, jacobian, moved,
        )  # fmt: skip
        close_legs(found, closing)
        last = residual[(self._count - 1) * self.legs.n : self._count * self.legs.n]
        last -= whole_turns(last, self.angle_periods)
        if not self.autonomous and self.word.n_events == 0:
            self._keep_at_rest(turn, residual, jacobian, moved)
        if self.is_smooth_cycle:
            self._close_across_flow(turn, residual, jacobian, moved)
        return residual, jacobian, moved

    def steady_growth(self, unknowns: Floats) -> dict[str, float]:
        """States that change over a turn by the same amount wherever it begins, and by how much.

        No choice of unknowns closes such a turn. Gaps of the legs add up to the change, and their
        derivatives to nothing. Drifts are none of these.
        """
        residual, jacobian, _ = self.evaluate(unknowns)
        rows, n = self._count * self.legs.n, self.legs.n
        change = residual[:rows].reshape(self._count, n).sum(axis=0)
        slopes = np.abs(jacobian[:rows].reshape(self._count, n, -1).sum(axis=0)).max(axis=1)
        size = np.abs(self.unpack(unknowns).states).max(axis=0) + np.abs(change)
        grows = (slopes <= _STEADY) & (np.abs(change) > _STEADY * size) & ~self.drifting
        names = self.legs.system.states
        return {names[i]: float(change[i]) for i in np.flatnonzero(grows).tolist()}

    def forwards(self, turn: Turn, found: LegResults) -> float:
        """How fast a smooth cycle passes its plane, beside how fast it did at first."""
        speed = float(self._across @ self.passing(turn, found.start_rates[0]))
        return speed / self._speed if self._speed > 0.0 else 1.0

    @property
    def whole_turns(self) -> Floats:
        """What a turn of each angle adds to the unknowns, (angles, size)."""
        rows = np.diag(self.angle_periods)[self.angle_periods > 0.0]
        instants = np.zeros((len(rows), self.n_instants))
        return np.hstack([np.tile(rows, self._count), instants])

    def without_turns(self, change: Floats) -> Floats:
        """A change of the unknowns but for the whole turns of angles at the first leg."""
        n = self.legs.n
        turned = np.tile(whole_turns(change[:n], self.angle_periods), self._count)
        return change - np.append(turned, np.zeros(self.n_instants))

    def carried(self, change: Floats) -> Floats:
        """What a change over a turn leaves open: all of a drift, whole turns of an angle, (n,)."""
        return np.where(self.drifting, change, whole_turns(change, self.angle_periods))

    def gap(self, turn: Turn, found: LegResults) -> float:
        """Largest gap between the end of a leg and the start of the next, beside the states."""
        following = np.roll(turn.states, -1, axis=0)
        gaps = found.nexts - following
        gaps[-1] -= self.carried(gaps[-1])
        gaps = np.abs(gaps)
        moving = np.where(self.drifting, turn.states - turn.states[0], turn.states)
        size = np.abs(moving).max(axis=0)
        size = np.where(size > 1e-6 * size.max(), size, max(float(size.max()), 1e-12))
        return float((gaps / size).max())

    def _keep_at_rest(self, turn: Turn, residual: Floats, jacobian: Floats, moved: Floats) -> None:
        """What never moves, as a body that sticks for ever, stays at the origin.

        Any place would do: they are a family of orbits, of which one is meant.
        """
        n = self.legs.n
        still = ~np.any(jacobian[:n, :n] != 0.0, axis=1) & ~np.any(moved[:n] != 0.0, axis=1)
        for i in np.flatnonzero(still & (residual[:n] == 0.0)):
            residual[i] = turn.states[0, i] - self.origin[i]
            jacobian[i, i] = 1.0
        if self._may_conserve:
            self._may_conserve = self._keep_conserved(turn, residual, jacobian, moved)

    def _keep_conserved(
        self, turn: Turn, residual: Floats, jacobian: Floats, moved: Floats
    ) -> bool:
        """Let sums of states that the flow conserves stay what they are at the origin; if any are.

        As the force of a spring in series with a slider that sticks, beside its stretch. Left null
        vectors of the equations are such sums where they are those of a part of the turn too.
        """
        n = self.legs.n
        flow = jacobian[:n, :n] + np.eye(n)
        units = balanced_units(np.abs(flow))
        matrix = jacobian[:n, :n] * units / units[:, None]
        left, sizes, _ = np.linalg.svd(matrix)
        rows = left[:, sizes <= _CONSERVED * max(1.0, sizes[0])].T
        if not rows.size:
            return False
        # with a leg of no time, for results of one leg stay
        word, begins = Word(self.word.modes * 2, ((),) * 2), np.full(2, turn.instants[0])
        ends = begins + np.array([_WITHIN, 0.0]) * (turn.instants[-1] - turn.instants[0])
        states = np.tile(turn.states, (2, 1))
        found = self.legs.follow_each(word, states, begins, ends).flow[0, :n].T
        changed = rows @ (found * units / units[:, None]) - rows
        moves = np.abs(rows @ (moved[:n] / units[:, None])).max(axis=1, initial=0.0)
        size = np.abs(moved[:n] / units[:, None]).max(initial=0.0)
        open_ = np.abs(rows @ (residual[:n] / units))
        largest = np.abs(np.vstack([turn.states, self.origin, residual[:n]]) / units).max()
        kept = (np.abs(changed).max(axis=1) <= _KEPT) & (moves <= _KEPT * size)
        kept &= open_ <= _KEPT * largest
        for row in rows[kept]:
            apart = float(row @ ((turn.states[0] - self.origin) / units))
            residual[:n] += units * row * apart
            jacobian[:n, :n] += np.outer(units * row, row / units)
        return bool(kept.any())

    def _close_across_flow(
        self, turn: Turn, residual: Floats, jacobian: Floats, moved: Floats
    ) -> None:
        """Without any event, the orbit begins on a plane across the flow."""
        assert self.results is not None and self.reference is not None
        n, rate = self.legs.n, self.results.start_rates[0]
        if not self._across.any():
            self._across = np.where(self.drifting, 0.0, rate)
            self._across /= max(float(np.linalg.norm(self._across)), 1e-300)
        jacobian[-1], moved[-1] = 0.0, 0.0
        jacobian[-1, :n] = self._across
        if self._ahead is None:
            speed = float(self._across @ rate)
            residual[-1] = self._across @ (turn.states[0] - self.reference)
        else:
            half = self._half_later(turn)
            speed = float(self._across @ (rate - half.end_rates[0]))
            residual[-1] = self._across @ (turn.states[0] - half.ends[0]) - self._ahead
            jacobian[-1, :n] -= half.flow[0, :n] @ self._across
            jacobian[-1, n] = -0.5 * float(self._across @ half.end_rates[0])
            moved[-1] = -half.flow[0, n:] @ self._across
        if self._speed == 0.0:
            self._speed = max(speed, 1e-300)
