"""Where the motion parts from an orbit that is no motion, in words.

A leg ends by its exit. A motion parts from it because another exit comes first, because its own
one comes at another time, or because its own guard is only touched there, so that the motion goes
on; what comes after that is no reason, but tells where it goes.
"""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.engine.status import Status
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.runs.labels import labels_of

__all__ = ["Departure"]

_DIGITS = (9, 12, 15, 17)  # of times in messages: as many as tell two of them apart


@dataclass(frozen=True)
class Departure:
    """A leg at whose end the engine has not passed its exits.

    Times of the engine may be a turn before or after those of the orbit; messages give those of
    the orbit.
    """

    equations: OrbitEquations
    turn: Turn
    ending: int  # the leg with these exits
    end: float  # when it should end, as the engine counts time
    allowed: float  # by which the engine may be off that instant
    touches: list[tuple[int, float]]  # exits whose guards it has only touched, and when

    def time(self, instant: float) -> float:
        """An instant of the engine as the orbit counts time."""
        if self._is_before_section(instant):
            return instant - self._section + float(self.turn.instants[-1])
        return instant - self.end + float(self.turn.instants[self.ending + 1])

    def leg_at(self, instant: float) -> int:
        """Leg of the orbit at an instant of the engine up to the end of the leg.

        The stay before the first event begins in the last leg of the turn before, unless the orbit
        begins at an event.
        """
        return len(self.equations.word) - 1 if self._is_before_section(instant) else self.ending

    def by_event(self, mode: int, path: int, passes: int, instant: float) -> str:
        """Why an orbit is no motion, which leaves the mode by some exits at an instant instead."""
        taken = repr(labels_of(self.equations.legs.system).path(mode, path, passes))
        if not self._own or instant < self.end - self.allowed:
            return self._too_early(taken, instant)
        if instant <= self.end + self.allowed:
            if taken == self._own:
                return f"{self._not_so()} as the word says: the motion goes on in another mode"
            return f"{self._not_so()}: the motion leaves by {taken} there"
        when, end = _told(self.time(instant), self._own_end)
        later = "only" if taken == self._own else f"by {taken}"
        return (
            f"{self._not_so(end)}: {self._not_taken}, and the motion leaves {later} at t = {when}"
        )

    def _too_early(self, taken: str, instant: float) -> str:
        """Why an orbit is no motion, which leaves by some exits before a leg ends."""
        of_turn = not self._own or self._is_before_section(instant)
        last = float(self.turn.instants[-1]) if of_turn else self._own_end
        when, end = _told(self.time(instant), last)
        left = f"in {self._name(instant)} the motion leaves by {taken} at t = {when}"
        if of_turn:
            return f"{left}, before the turn ends at t = {end}"
        by = "" if taken == self._own else f" by {self._own}"
        return f"{left}, before the leg ends{by} at t = {end}"

    def without_event(self, status: Status, instant: float) -> str:
        """Why an orbit is no motion, which leaves by no exit until an instant."""
        where = self._name(instant)
        if status == Status.INADMISSIBLE:
            return f"{where} runs where a guard of its mode is negative"
        if not self._own:
            return f"{where} does not come to the end of the turn: {status.word}"
        if status == Status.COMPLETED:
            return f"{self._not_so()}: {self._not_taken}, and the motion goes on in this mode"
        return f"{self._not_so()}: the motion ends before an exit is taken, as {status.word}"

    def _not_so(self, end: str = "") -> str:
        """The end that the leg does not have, at a time that is told with some digits."""
        end = end or _told(self._own_end)[0]
        return f"{self._name(self.end)} does not end by {self._own} at t = {end}"

    @property
    def _own(self) -> str:
        """Names of the exits that should be taken, "" at the section."""
        text = self.equations.word.exit_text(self.equations.legs.system, self.ending)
        return repr(text) if text else ""

    @property
    def _own_end(self) -> float:
        return float(self.turn.instants[self.ending + 1])

    @property
    def _not_taken(self) -> str:
        """What happens at the end of the leg instead of its exits."""
        first = self.equations.word.paths[self.ending][0]
        touched = any(
            e == first and abs(instant - self.end) <= self.allowed for e, instant in self.touches
        )
        return "its guard is only touched there" if touched else "its guard is not met there"

    @property
    def _section(self) -> float:
        """When the turn begins, as the engine counts time."""
        return self.end - float(self.turn.instants[self.ending + 1] - self.turn.instants[0])

    def _is_before_section(self, instant: float) -> bool:
        word = self.equations.word
        return self.ending == 0 and not word.closes_at_event and instant < self._section

    def _name(self, instant: float) -> str:
        k = self.leg_at(instant)
        system = self.equations.legs.system
        return f"leg {k} ({system.mode_names[self.equations.word.modes[k]]})"


def _told(*times: float) -> list[str]:
    """Times with as many digits as tell them apart."""
    for digits in _DIGITS:
        texts = [f"{time:.{digits}g}" for time in times]
        if len(set(texts)) == len(set(times)):
            break
    return texts
