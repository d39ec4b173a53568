"""A curve of special points over two parameters, piece by piece, each with a word of its own.

Where another test of the word vanishes two things happen at once. Beyond, the orbits have another
word, and the same condition holds for them where it does not depend on what has changed: a soft
stop that is touched changes multipliers by little at first, a rigid wall at once without bound.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from nonsmooth.continuation.branch import Branch
from nonsmooth.continuation.point import Point
from nonsmooth.errors import NonsmoothError, RunError
from nonsmooth.periodic_orbits.admissibility import Admissibility
from nonsmooth.periodic_orbits.branch_part import BranchPart, ending_of_orbits, is_critical, kind_of
from nonsmooth.periodic_orbits.branch_tests import Looked, is_of_word
from nonsmooth.periodic_orbits.equations import OrbitEquations
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.in_words import in_words
from nonsmooth.periodic_orbits.legs import LegError, Legs
from nonsmooth.periodic_orbits.orbit import primitive_parts
from nonsmooth.periodic_orbits.special_change import CurvePiece, pieces_behind
from nonsmooth.periodic_orbits.special_condition import (
    OF_UNIT_CIRCLE,
    CurveOptions,
    CurveStart,
    SpecialCondition,
    pair_on_circle,
)

__all__ = ["SpecialCurve"]

Floats = npt.NDArray[np.float64]

_AGAIN = 1e-6  # arclength within which the start itself is seen again
_DOUBLE = 1e-3  # distance of two multipliers that are one, which are known to half the digits
_RESONANT = 1e-6  # of the sum of a pair of multipliers: beyond a resonance they are real
_SAID = {
    "cusp": "two curves of folds meet",
    "turning_point": "the second parameter turns back",
    "fold_flip": "multipliers are 1 and -1: a fold curve and a flip curve touch",
    "fold_torus": "a multiplier is 1 and two on the unit circle",
    "flip_torus": "a multiplier is -1 and two on the unit circle",
    "resonance_1_1": "two multipliers are 1: a torus curve ends on a fold curve",
    "resonance_1_2": "two multipliers are -1: a torus curve ends on a flip curve",
    "resonance_1_3": "a pair of multipliers at 120 degrees: orbits of three times the period",
    "generalised_flip": "flips with a stable orbit beyond turn into flips with an unstable one",
    "chenciner": "tori with a stable closed curve beyond turn into tori with an unstable one",
    "resonance_1_4": "a pair of multipliers at 90 degrees: orbits of four times the period",
}
_CRITICALITIES = ("generalised_flip", "chenciner")  # where a coefficient changes its sign
_BETWEEN = {
    "fold": "where a multiplier is 1: a fold curve ends there, or begins",
    "flip": "where a multiplier is -1: a flip curve ends there, or begins",
    "torus": "where two multipliers are on the unit circle: a torus curve ends there, or begins",
}
_BECOMES_SHORTER = (
    "the orbits come to one of half their period that is passed twice: on the flip curve of that"
    " orbit, flips with a stable orbit beyond turn into flips with an unstable one there"
)
_NEARLY = 0.05  # part of its size by which an orbit of half the period may be missed
_ENDS_TORUS = ("resonance_1_1", "resonance_1_2")  # beyond, the pair is real


@dataclass
class SpecialCurve:
    """Follows a curve; ``parts`` are its points so far, in order of the arclength."""

    asked: CurveOptions
    legs: Legs
    report: Callable[[int], None]
    parts: list[BranchPart] = field(default_factory=list)
    ended: str = ""
    message: str = ""
    _taken: int = 0  # steps, in all pieces

    def follow(self, guess: Guess, test: str, way: int) -> None:
        """Points in one direction of the second parameter, until the curve ends."""
        options = self.asked.options
        equations = OrbitEquations(
            self.legs, guess.word, period=options.period, phase=options.phase,
            autonomous=options.autonomous, origin=guess.turn.states[0],
            reference=guess.turn.states[0].copy(),
        )  # fmt: skip
        values = options.system.parameter_values
        condition = SpecialCondition(self.asked, self.legs, equations, test)
        p, q = float(values[self.asked.first]), float(values[options.parameter])
        start = CurveStart(equations.pack(guess.turn), p, q, way)
        following: CurvePiece | None = CurvePiece(condition, start)
        while following is not None:
            try:
                following = self._follow_piece(following, way)
            except NonsmoothError as fault:
                if not self.parts:
                    raise
                # what is known stays
                self.ended, following = "smallest_step", None
                self.message = self._at(f"the curve could not be followed further: {fault}")

    def _follow_piece(self, piece: CurvePiece, way: int) -> CurvePiece | None:
        """Points with one word; the piece with the next one, None where the curve has ended."""
        along = abs(self.parts[-1].arclength) if self.parts else 0.0
        left = self.asked.options.steps - self._taken
        if left <= 0 and self.parts:
            self.ended, self.message = "steps", self._used_up()
            return None
        curve = piece.condition.curve(piece.start, left)
        before = self._taken
        for point, part in self._points(piece, curve, along):
            self._taken = before + curve.taken
            self.parts.append(replace(part, arclength=way * part.arclength))
            if is_of_word(part.test):
                return self._behind(piece.condition, point, self.parts[-1])
            if part.special in _ENDS_TORUS and self.asked.kind == "torus":
                self.ended, self.message = part.special, self._at(_SAID[part.special])
                return None
        if not self.parts:
            raise RunError("the orbit there does not have the multipliers of such a curve")
        self.ended, self.message = curve.ended, self._why(curve)
        if curve.ended in ("smallest_step", "singular") and self._is_repeated(piece.condition):
            self.ended, self.message = "generalised_flip", self._at(_BECOMES_SHORTER)
        return None

    def _is_repeated(self, condition: SpecialCondition) -> bool:
        """Whether orbits on a fold curve have come to one of half their period, passed twice."""
        if self.asked.kind != "fold" or not self.parts:
            return False
        return primitive_parts(condition.equations, self.parts[-1].looked.turn, _NEARLY) > 1

    def _used_up(self) -> str:
        """How many steps were taken in all pieces, and where they have led."""
        p, q = self._place(self.parts[-1])
        return (
            f"{self.asked.options.steps} steps were taken, which is all that steps= allows, up to"
            f" {self.asked.options.parameter} = {q:.10g}, {self.asked.first} = {p:.10g}; allow more"
            " with steps=, or longer ones with largest_step="
        )

    def _points(
        self, piece: CurvePiece, curve: Branch, along: float
    ) -> Iterator[tuple[Point, BranchPart]]:
        """Points that count, with what happens there."""
        condition = piece.condition
        for point in curve:
            self.report(len(self.parts))
            try:
                looked = condition.look(point)
            except LegError:
                continue
            name = point.special
            again = point.arclength <= _AGAIN and (along > 0.0 or self._is_known(name))
            if again and (name or piece.located) and name not in ("bound", "closed"):
                continue  # it has been told
            # where the second parameter turns back nothing vanishes by which a curve might go on
            test = "" if name == "fold" else name.removeprefix("also:")
            special = self._kind_at(name, looked)
            if special is None or not self._is_on_curve(looked):
                continue
            yield point, BranchPart(
                condition.equations.word, looked, point.p, along + point.arclength, special,
                self._detail(condition, special, test), test,
            )  # fmt: skip

    def _is_known(self, name: str) -> bool:
        """Whether something is seen again where a curve begins at a point of codimension two."""
        return is_of_word(name) or name.startswith("also:")

    def _kind_at(self, name: str, looked: Looked) -> str | None:
        """What a special point is called; None where a test has vanished for another reason."""
        own, test = self.asked.kind, name.removeprefix("also:")
        if name == "fold":
            return "turning_point"
        if is_of_word(name):
            return "" if self._passes_section(name) else _both(own, kind_of(name))
        if test == name:
            return name
        if test in _CRITICALITIES:
            return test
        values = looked.multipliers.multipliers
        if own == "torus" and test not in OF_UNIT_CIRCLE:
            return f"resonance_{test}"
        if test == "torus" and own in ("fold", "flip"):
            at = 1.0 if own == "fold" else -1.0
            if np.count_nonzero(np.abs(values - at) <= _DOUBLE) > 1:
                return "resonance_1_1" if own == "fold" else "resonance_1_2"
        return _both(own, test) if is_critical(looked, test) else None

    def _passes_section(self, name: str) -> bool:
        """Whether a test tells that an event passes the section, where nothing happens."""
        return not self.asked.options.autonomous and name in ("leg:0", "leg:last")

    def _is_on_curve(self, looked: Looked) -> bool:
        """Whether the multipliers are what the curve is of.

        Equations are singular too where an excursion vanishes, and beyond a strong resonance the
        pair of a torus curve is real.
        """
        kind, values = self.asked.kind, looked.multipliers.multipliers
        if kind == "torus":
            i, j = pair_on_circle(values)
            return bool(abs((values[i] + values[j]).real) <= 2.0 + _RESONANT)
        return kind not in OF_UNIT_CIRCLE or is_critical(looked, kind)

    def _detail(self, condition: SpecialCondition, special: str, test: str) -> str:
        system, word = condition.legs.system, condition.equations.word
        if is_of_word(test):
            return in_words(system, word, test)
        if test in _BETWEEN and self.asked.kind not in OF_UNIT_CIRCLE:
            return f"{in_words(system, word, condition.test)} {_BETWEEN[test]}"
        return _SAID.get(special, "")

    def _behind(
        self, condition: SpecialCondition, point: Point, part: BranchPart
    ) -> CurvePiece | None:
        """The curve of orbits of a changed word; None where it ends, which is said."""
        for piece in pieces_behind(condition, point, part.looked, part.test):
            if not part.special:
                return piece
            name = piece.condition.equations.word.text(self.legs.system)
            part.detail += f"; the curve goes on as '{name}'"
            if piece.located is not None:  # from the regular side, where it is a simple zero
                part.word = piece.condition.equations.word
                part.looked, part.value = piece.condition.look(piece.located), piece.located.p
                # both words stand at the change, whatever rounding lets the engine find
                part.looked = replace(part.looked, admissibility=Admissibility(True))
                part.test = piece.located.special
            if self._was_here(part):
                self._close()
                return None
            return piece
        self.ended = part.special or "section"
        self.message = self._at(
            f"{part.detail} at the same time, and no orbits beyond were found that meet the same"
            " condition",
        )
        return None

    def _was_here(self, part: BranchPart) -> bool:
        """Whether the same change has been passed before, in the same direction."""
        sizes = self.asked.ranges
        here = self._place(part)
        return any(
            other.special == part.special and other.detail == part.detail
            and float(np.abs((self._place(other) - here) / sizes).max()) <= _AGAIN
            for other in self.parts[:-1]
        )  # fmt: skip

    def _close(self) -> None:
        """Leave out what was passed for a second time: the curve is closed."""
        start, word = self.parts[0], self.parts[0].word
        after = next(k for k, part in enumerate(self.parts) if part.word != word)
        apart = [
            float(np.abs((self._place(part) - self._place(start)) / self.asked.ranges).max())
            if part.word == word and k > after
            else np.inf
            for k, part in enumerate(self.parts)
        ]
        del self.parts[int(np.argmin(apart)) :]
        self.parts.append(replace(start, special="closed", arclength=self.parts[-1].arclength))
        self.ended = "closed"
        self.message = "the curve came back to its start: it is a closed curve"

    def _place(self, part: BranchPart) -> Floats:
        """Both parameters of a point."""
        names = list(self.asked.options.system.parameters)
        return np.array([part.looked.values[names.index(self.asked.first)], part.value])

    def _at(self, what: str) -> str:
        """What happens at the last point, with both parameters."""
        p, q = self._place(self.parts[-1])
        return f"at {self.asked.first} = {p:.10g}, {self.asked.options.parameter} = {q:.10g} {what}"

    def _why(self, curve: Branch) -> str:
        """Why the curve ends at the last point, by the names of both parameters."""
        if curve.ended == "steps":
            return self._used_up()
        parameter = self.asked.options.parameter
        p, q = map(float, self._place(self.parts[-1]))
        if curve.ended == "bound" and p in self.asked.first_bounds:
            return (
                f"{self.asked.first} reached its bound {p:.10g}, which is that of the branch, at"
                f" {parameter} = {q:.10g}; for more give a branch over a wider range"
            )
        if curve.ended == "bound":
            return f"{parameter} reached its bound {q:.10g}, at {self.asked.first} = {p:.10g}"
        return ending_of_orbits(curve.ended, curve.message, parameter, q)


def _both(own: str, other: str) -> str:
    """Name of a point at which two things happen: what happens to the word comes first."""
    if own == other:
        return f"double_{own}"

    def order(kind: str) -> tuple[int, str]:
        return (OF_UNIT_CIRCLE.index(kind) + 1 if kind in OF_UNIT_CIRCLE else 0), kind

    return "_".join(sorted((own, other), key=order))
