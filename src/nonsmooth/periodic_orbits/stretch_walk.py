"""A walk along a stretch of a branch of orbits: what its points are, and where it leads."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from nonsmooth.continuation.point import Point
from nonsmooth.errors import RunError
from nonsmooth.periodic_orbits.admissibility import Admissibility
from nonsmooth.periodic_orbits.branch_change import (
    SHRINKS,
    broken_test,
    change_at,
    end_at,
)
from nonsmooth.periodic_orbits.branch_part import (
    OF_MULTIPLIERS,
    BranchPart,
    Followed,
    ending_of_orbits,
    is_critical,
    kind_of,
    kind_of_crossing,
    part_of,
)
from nonsmooth.periodic_orbits.branch_start import is_crossed, tangent_at
from nonsmooth.periodic_orbits.branch_tests import Looked, broken_tests, is_of_word, what_of
from nonsmooth.periodic_orbits.crossing_place import at_crossing
from nonsmooth.periodic_orbits.cycle_end import (
    NEARLY,
    NOTHING,
    boundary_of_cycles,
    end_of_cycles,
    is_nothing,
    smaller_cycles,
)
from nonsmooth.periodic_orbits.cycle_plane import is_flat
from nonsmooth.periodic_orbits.equations import OrbitEquations
from nonsmooth.periodic_orbits.legs import LegError
from nonsmooth.periodic_orbits.newton import solve_orbit
from nonsmooth.periodic_orbits.orbit import primitive_parts
from nonsmooth.periodic_orbits.other_rebounds import past_rebounds
from nonsmooth.periodic_orbits.passing_strobes import orbits_at_strobes
from nonsmooth.periodic_orbits.step_check import VERTICAL, StepCheck
from nonsmooth.periodic_orbits.stretch import (
    MODULUS,
    BranchOptions,
    BranchStart,
    BranchStretch,
    spread_along,
)

__all__ = ["BY_ROUNDING", "StretchWalk"]

Floats = npt.NDArray[np.float64]

_AGAIN = 1e-6  # arclength from the start of a stretch within which its own change is seen again
_NEAR_GRAZE = 1e-4  # part of the turn: branches cross there as an excursion vanishes
_HALVING = "the turn passes twice through the orbit that doubles its period here"
_SHORTER = (
    "orbits beyond it are those of a shorter period, passed more than once; their branch is that of"
    " find_orbit with a smaller period="
)
_AT_HALVING = ("branch_point", "fold")  # a doubled branch turns back where it has come back
_REPEATED = 1e-5  # part of its size within which a turn repeats a shorter orbit
_ONCE, _NEAR_ONCE = 1e-6, 1e-3  # of the range and by arclength: crossings that are one
_IN_PROPORTION = 0.05  # part by which sizes of cycles differ from their distance from an end
_CLOSE = 1e-4  # of a test that is about to vanish where no step succeeds any more
_AS_FAR = 0.1  # of the way of another test, at least, of one that rises together with it
BY_ROUNDING = 1e-8  # of a test that vanishes together with another one, by rounding
_BESIDE = (1e-10, 1e-8, 1e-6, 1e-4)  # of the last step: how far from a change orbits are looked at
_UNCLEAR = 20  # points behind a change that rounding may leave open
_NEVER_AGAIN = ("", "bound", "flip", "torus")


class StretchWalk:
    """Walks along a stretch; behind it, ``following`` or ``ended`` says how the branch goes on.

    Neither is set where the steps are used up. ``begin`` is the arclength so far, 0 for the first
    stretch; ``first`` the spread of each state of the first orbit; ``home`` is where the branch
    began.
    """

    def __init__(
        self, stretch: BranchStretch, start: BranchStart, begin: float, first: Floats,
        home: BranchStart,
    ) -> None:  # fmt: skip
        self.stretch, self.start, self.home = stretch, start, home
        self.begin, self.along, self.first = begin, begin, first
        self.done = 0
        self.check = StepCheck(stretch, start, behind_change=begin > 0.0)
        self.following: BranchStart | None = None
        self.ended: Followed | None = None
        self._stands: tuple[Point, Looked] | None = None  # the last motion
        # tests of the last point that was a motion; behind a change until then of the first point
        self._before: Mapping[str, float] = {}
        self._begun: Mapping[str, float] = {}
        self._direction = start.direction  # at the last point that is not special
        self._is_located = not start.located
        self._unclear = 0  # points that rounding has left open so far
        self._grows = what_of(start.grows)
        self._crossed: Point | None = None  # the last point where branches cross

    def points(self, steps: int, report: Callable[[int], None]) -> Iterator[BranchPart]:
        """Points that count, in order."""
        name = self.stretch.options.parameter
        try:
            branch = self.stretch.branch(self.start, steps, self.check, self.home)
        except RunError as fault:
            crossed = self._is_crossed(self.start.unknowns, self.start.value)
            ended = "singular" if crossed else "smallest_step"
            message = ending_of_orbits(ended, str(fault), name, self.start.value)
            if self.begin == 0.0:  # the first orbit of all
                system = self.stretch.options.system.name
                raise RunError(f"{system}: {message}", status=ended) from None
            self.ended = Followed(ended, message)
            return
        first: tuple[Point, Looked] | None = None
        for point in self._telling(branch):
            self.along = self.begin + point.arclength
            report(self.done)
            try:
                looked = self.stretch.look(point)
            except LegError:
                continue
            if first is None:
                first = point, looked
                self._begun = looked.tests if self.begin > 0.0 else {}
            if self._is_again(point, looked):
                if self._locates(point):
                    # a graze that was approached along an excursion, from its regular side
                    self._is_located = True
                    yield self._part(looked, point, self.start.kind, self.start.detail)
                if self.leads_nowhere:
                    return
                continue
            if not self._is_located and first is not None:
                # the start is the change itself, to rounding: no sign has changed behind it
                self._is_located = True
                there = replace(first[0], special=self.start.grows)
                begun = self._part(first[1], there, self.start.kind, self.start.detail)
                yield replace(begun, arclength=self.begin + there.arclength)
            yield from self._counted(point, looked)
            if self.following is not None or self.ended is not None:
                return
        if branch.ended in ("smallest_step", "singular"):
            yield from self._past_end()
            if self.following is not None or self.ended is not None:
                return
        if branch.ended != "steps":
            ended = branch.ended
            if ended == "smallest_step" and self._is_crossed(point.u, point.p):
                ended = "singular"  # Newton's method has no curve to settle to
            message = ending_of_orbits(ended, branch.message, name, point.p)
            self.ended = Followed(ended, message)

    def _telling(self, points: Iterable[Point]) -> Iterator[Point]:
        """The points, but for those beside others that tell more of what happens there.

        The engine may find a slow impact to be another motion where its speed squared is rounding.
        A multiplier that is followed by itself may cross the unit circle together with others.
        """
        waits: Point | None = None
        told = -np.inf  # arclength of the last special point
        for point in points:
            name, is_one = point.special, point.special.startswith(MODULUS)
            if is_one:
                point = replace(point, special=kind_of_crossing(self.stretch.look(point)))
            tells = bool(name) and not _is_spurious(point, self.stretch.look(point))
            if waits is not None:
                near = point.arclength - waits.arclength <= _AGAIN
                if is_one and near:
                    continue
                if not (near and tells and (waits.special != "motion" or is_of_word(name))):
                    yield waits
                    told = waits.arclength
                waits = None
            if is_one and (point.arclength - told <= _AGAIN or not point.special):
                continue
            if name == "motion" or is_one:
                waits = point
            else:
                yield point
                told = point.arclength if tells else told
        if waits is not None:
            yield waits

    def _is_crossed(self, u: Floats, p: float) -> bool:
        """Whether the equations of an orbit do not fix one curve."""
        self.stretch.set_parameter(p)
        try:
            return is_crossed(self.stretch.equations, u)
        except LegError:
            return False

    @property
    def leads_nowhere(self) -> bool:
        """Whether orbits behind a change solve the equations of their word and are no motions."""
        return self._unclear > _UNCLEAR

    def _past_end(self) -> Iterator[BranchPart]:
        """What is just ahead where no step succeeds.

        A change of the word, since a leg that vanishes spoils the step; or the rest of cycles that
        move as they shrink: rounding of the parameter then moves them by much of their size.
        """
        if self._stands is None:
            return
        point, looked = self._stands
        if self.stretch.equations.is_smooth_cycle and self._is_nothing(point, NEARLY):
            rest = self._end_of(point)
            if rest is not None:
                self.ended = end_at("shrink", looked, self.stretch)
                yield self._at_rest(*rest)
                return
        end = self._onto_boundary(point, looked, NEARLY)
        if end is not None:
            yield end
            return
        self.following = past_rebounds(self.stretch, looked, point)
        if self.following is not None:
            return
        close = {
            name: value
            for name, value in looked.tests.items()
            if is_of_word(name) and abs(value) <= _CLOSE
        }
        for name in sorted(close, key=lambda each: close[each]):
            self.following, part = change_at(
                self.stretch, replace(point, special=name), looked, self.along
            )
            if self.following is not None:
                if part is not None:
                    yield part
                return

    def _is_again(self, point: Point, looked: Looked) -> bool:
        """Whether a point only repeats the change behind which the stretch begins."""
        name, tests, start = point.special, looked.tests, self.start
        if name not in _NEVER_AGAIN and self.begin > 0.0 and point.arclength <= _AGAIN:
            return True
        if name == "branch_point" and _at_graze(looked):
            return True
        if not name and start.located and tests.get(start.grows, 1.0) <= 0.0:
            self._before = tests
            return True  # before the graze, on its other side
        stands = _may_stand(self.stretch.options, looked)
        if not name and self.begin > 0.0 and not self._before and not stands:
            self._unclear += 1
            return True  # where the word has just changed rounding decides what the engine finds
        # a test of the word that rises; one that has just come to zero, with a fold, has fallen
        before = self._before or self._begun
        return is_of_word(name) and before.get(name, 1.0) < -self._risen(before)

    def _risen(self, before: Mapping[str, float]) -> float:
        """How far behind its zero a test has been that rises; as far as the one that is located."""
        located = abs(before.get(self.start.grows, np.inf)) if self.start.located else np.inf
        return min(BY_ROUNDING, _AS_FAR * located)

    def _locates(self, point: Point) -> bool:
        """Whether a point is the graze on whose other side the stretch begins."""
        return not self._is_located and what_of(point.special) in ("graze", self._grows)

    def _counted(self, point: Point, looked: Looked) -> Iterator[BranchPart]:
        """A point of the branch, and where that leads."""
        name = point.special
        if name in _AT_HALVING and self.along > _AGAIN and self._is_repeated(looked):
            yield replace(self._part(looked, point, "halving", _HALVING), test="flip")
            self.ended = Followed("halving", f"the branch ends where {_HALVING}")
            return
        if not is_of_word(name):
            if _may_stand(self.stretch.options, looked):
                yield from self._ordinary(point, looked)
                return
            name = broken_test(looked)
            point = replace(point, special=name)
        if name == "shrink":
            if self._is_nothing(point):
                self.ended = end_at("shrink", looked, self.stretch)
                yield self._shrunk(point, looked)
            else:  # it only touches its plane, where the tangent is that of the flow
                self.following = self._goes_on_at(point, self._direction)
            return
        end = self._onto_boundary(point, looked)
        if end is not None:  # a long step has come to the end of the cycles, where all tests vanish
            yield end
            return
        self.stretch.remember(point)
        try:
            self.following, part = change_at(self.stretch, point, looked, self.along)
        except Exception as fault:  # whatever it is, the points so far are kept
            self.ended = Followed("fault", _fault_at(self.stretch, point, fault))
            return
        told = looked
        if part is not None and name == "motion" and self.following is None:
            stands = looked.admissibility.admissible
            beside = self._beside(looked, point.p, admissible=not stands)
            if beside is not None and stands:
                told = beside
            elif beside is not None:
                value = float(beside.values[self.stretch.place])
                part = replace(part, looked=beside, value=value)
        if self.following is not None and self._becomes_shorter(self.following):
            detail = self.following.detail or "a shorter orbit, passed several times"
            part = part or self._part(looked, point, kind_of(name), detail)
            self.following = None
            self.ended = Followed("halving", f"the branch ends ({kind_of(name)}): {_SHORTER}")
        if self.following is None and self.ended is None:
            part = self._onto_boundary(point, looked, NEARLY) or part
        if part is not None:
            yield part
        if self.following is None and self.ended is None:
            self.ended = end_at(name, told, self.stretch)

    def _beside(self, looked: Looked, p: float, *, admissible: bool) -> Looked | None:
        """The nearest motion before a change that the engine alone tells, or what is none beyond.

        The last point before may be a long step away.
        """
        if self._stands is None:
            return None
        u, before = self.stretch.equations.pack(looked.turn), self._stands[0]
        for share in _BESIDE:
            share = share if admissible else -share
            value = p + share * (before.p - p)
            try:
                self.stretch.set_parameter(value)
                found = solve_orbit(self.stretch.equations, u + share * (before.u - u))
                there = self.stretch.look(replace(before, u=found.unknowns, p=value))
            except LegError:
                continue
            if found.status == "completed" and there.admissibility.admissible == admissible:
                return there
        return None

    def _is_repeated(self, looked: Looked) -> bool:
        """Whether a turn passes twice through a shorter orbit, to what a fold is located."""
        self.stretch.set_parameter(float(looked.values[self.stretch.place]))
        return primitive_parts(self.stretch.equations, looked.turn, _REPEATED) > 1

    def _becomes_shorter(self, following: BranchStart) -> bool:
        """Whether orbits behind a change repeat a shorter one, and those before it do not."""
        if self._stands is None or self._is_repeated(self._stands[1]):
            return False
        self.stretch.set_parameter(following.value)
        turn = following.equations.unpack(following.unknowns)
        return primitive_parts(following.equations, turn, _REPEATED) > 1

    def _ordinary(self, point: Point, looked: Looked) -> Iterator[BranchPart]:
        """A point at which the word stays; the stretch ends where its orbits have outgrown it."""
        self._before = looked.tests
        point, looked = self._at_its_place(point, looked)
        if self._is_told(point):
            return
        if self._stands is not None:
            for there, at_strobe in orbits_at_strobes(self.stretch, self._stands, (point, looked)):
                part = self._part(at_strobe, there, "", "")
                yield replace(part, arclength=self.begin + there.arclength)
        self._stands = point, looked
        self.stretch.remember(point)
        if not point.special:
            self._direction = point.tangent_u, point.tangent_p
        # a stretch that only has another scale begins at the last point of the one before
        if not _is_spurious(point, looked) and not (
            self.begin > 0.0 and point.arclength == 0.0 and not self.start.kind
        ):
            yield self._part(looked, point, point.special, "")
            self.done += not point.special
        if looked.other is not None and not point.special and not self.stretch.options.inadmissible:
            self.following = self._with_other_rebounds(looked.other, point)
        elif not point.special:
            end = self._down_to_rest(point, looked)
            new = end is None and point.arclength > 0.0 and self._needs_new_measures(point)
            if new:
                end = self._onto_boundary(point, looked)
            if end is not None:
                yield end
            elif new:
                self.following = self._goes_on_at(point, (point.tangent_u, point.tangent_p))

    def _is_told(self, point: Point) -> bool:
        """Whether branches cross where they did just before: rounding has told it twice."""
        if point.special != "branch_point":
            return False
        before, (low, high) = self._crossed, self.stretch.options.bounds
        self._crossed = point
        return before is not None and (
            abs(point.p - before.p) <= _ONCE * (high - low)
            and point.arclength - before.arclength <= _NEAR_ONCE
        )

    def _at_its_place(self, point: Point, looked: Looked) -> tuple[Point, Looked]:
        """A crossing of branches as exactly as orbits beside it tell; others as they are."""
        if point.special != "branch_point" or self._stands is None:
            return point, looked
        self.stretch.set_parameter(point.p)
        equations, turn = self.stretch.equations, looked.turn
        found = equations.legs.follow(equations.word, turn.states, turn.instants)
        if not self.stretch.each_multiplier and not found.passed_rate.any():
            return point, looked  # there are equations that are regular there
        there = at_crossing(self.stretch, point, self._stands[0])
        self.stretch.set_parameter(point.p if there is None else there.p)
        return (point, looked) if there is None else (there, self.stretch.look(there))

    def _needs_new_measures(self, point: Point) -> bool:
        """Whether steps are measured by another size, or the cycle passes its plane too flat."""
        if self.stretch.outgrown(point):
            return True
        equations = self.stretch.equations
        self.stretch.set_parameter(point.p)
        return equations.is_smooth_cycle and is_flat(equations, point.u)

    def _down_to_rest(self, point: Point, looked: Looked) -> BranchPart | None:
        """The rest to which a cycle without events has shrunk, or does with nothing on the way."""
        if not self.stretch.equations.is_smooth_cycle:
            return None
        if self._is_nothing(point):
            self.ended = end_at("shrink", looked, self.stretch)
            return self._shrunk(point, looked)
        rest = self._end_of(point) if self._leads_straight_to_rest(point) else None
        if rest is None:
            return None
        self.ended = end_at("shrink", looked, self.stretch)
        return self._at_rest(*rest)

    def _leads_straight_to_rest(self, point: Point) -> bool:
        """Whether the cycles on the way to the rest are this one, scaled.

        At one value of the parameter cycles of a linear mode have any size. They are all alike, and
        the branch along them is a straight line.
        """
        low, high = self.stretch.options.bounds
        if not abs(point.tangent_p) <= VERTICAL * (high - low):
            return False
        self.stretch.set_parameter(point.p)
        smaller, scale = smaller_cycles(self.stretch.equations, point.u), self.stretch.scale
        if not smaller or (smaller[0] - point.u) / scale @ (point.tangent_u / scale) <= 0.0:
            return False
        found = [self.stretch.look(replace(point, u=each)) for each in smaller]
        return all(each.admissibility.admissible and not broken_tests(each) for each in found)

    def _is_nothing(self, point: Point, below: float = NOTHING) -> bool:
        """Whether a cycle has shrunk to a point."""
        self.stretch.set_parameter(point.p)
        return is_nothing(self.stretch.equations, point.u, self.first, below)

    def _shrunk(self, point: Point, looked: Looked) -> BranchPart:
        """The point to which cycles shrink: the rest there, or the last cycle if none is found."""
        return self._at_rest(*(self._end_of(point) or (point, looked)))

    def _end_of(self, point: Point) -> tuple[Point, Looked] | None:
        """The rest to which cycles shrink."""
        equations, bounds = self.stretch.equations, self.stretch.options.bounds
        end = end_of_cycles(equations, point, self.stretch.set_parameter, bounds)
        self.stretch.set_parameter(point.p)
        return None if end is None else (end, self.stretch.look(end))

    def _at_rest(self, point: Point, looked: Looked) -> BranchPart:
        self.stretch.set_parameter(point.p)
        return self._part(looked, replace(point, special="shrink"), "hopf", SHRINKS)

    def _onto_boundary(
        self, point: Point, looked: Looked, below: float = NOTHING
    ) -> BranchPart | None:
        """The boundary equilibrium to which cycles with events have shrunk; None if not yet.

        Multipliers and durations are those of the last cycle, and hardly change from there on; of
        one that is large enough to have some where the step has come as close as rounding.
        """
        equations, options = self.stretch.equations, self.stretch.options
        if equations.is_smooth_cycle or not self._is_nothing(point, below):
            return None
        found = boundary_of_cycles(equations, point, self.stretch.set_parameter, options.bounds)
        self.stretch.set_parameter(point.p)
        if found is None or (below > NOTHING and not self._shrinks_to(found[0], point)):
            return None
        p, rest, leg = found
        if below > NOTHING and self._stands is not None:
            looked = self._stands[1]  # few digits of smaller ones are known
        elif point.special:
            looked = self._next_to_end(p, rest) or looked
        name = equations.word.exit_text(options.system, leg)
        detail = f"{SHRINKS}, the rest of a mode on the surface of {name!r}"
        message = f"the branch ends at {options.parameter} = {p:.10g}: {detail}"
        self.ended = Followed("boundary_equilibrium", message)
        values = looked.values.copy()
        values[self.stretch.place] = p
        turn = replace(looked.turn, states=np.tile(rest, (len(equations.word), 1)))
        stands = Admissibility(True)  # as the cycles before it do
        looked = replace(looked, turn=turn, values=values, admissibility=stands)
        there = replace(point, p=p, special="shrink")
        return self._part(looked, there, "boundary_equilibrium", detail)

    def _shrinks_to(self, p: float, point: Point) -> bool:
        """Whether cycles are as large as their distance from a value of the parameter."""
        if self._stands is None or point.p in (p, self._stands[0].p):
            return False
        ratios = []
        for each in (point, self._stands[0]):
            self.stretch.set_parameter(each.p)
            size = (spread_along(self.stretch.equations, each.u) / self.first).max()
            ratios.append(float(size) / (each.p - p))
        self.stretch.set_parameter(point.p)
        return abs(ratios[1] / ratios[0] - 1.0) <= _IN_PROPORTION

    def _next_to_end(self, p: float, rest: Floats) -> Looked | None:
        """A cycle that is nothing beside the first, from the last motion; None if not found.

        Cycles at a boundary equilibrium are alike: states go on as the parameter does.
        """
        if self._stands is None:
            return None
        (before, looked), equations = self._stands, self.stretch.equations
        self.stretch.set_parameter(before.p)
        size = float((spread_along(equations, before.u) / self.first).max())
        share = min(1.0, NOTHING / size)
        end = equations.pack(replace(looked.turn, states=np.tile(rest, (len(equations.word), 1))))
        value = p + share * (before.p - p)
        self.stretch.set_parameter(value)
        found = solve_orbit(equations, end + share * (before.u - end))
        if found.status != "completed":
            return looked
        return self.stretch.look(replace(before, u=found.unknowns, p=value))

    def _goes_on_at(self, point: Point, direction: tuple[Floats, float]) -> BranchStart:
        """The branch goes on at the same orbit with new measures."""
        return BranchStart(self.stretch.equations, point.u, point.p, direction)

    def _with_other_rebounds(
        self, other: tuple[OrbitEquations, Floats], point: Point
    ) -> BranchStart:
        """The branch goes on as that of the word in which the engine's rebounds are."""
        equations, unknowns = other
        self.stretch.set_parameter(point.p)
        du, dp = tangent_at(equations, unknowns)
        way = 1.0 if dp * point.tangent_p >= 0.0 else -1.0
        return BranchStart(equations, unknowns, point.p, (way * du, way * dp))

    def _part(self, looked: Looked, point: Point, special: str, detail: str) -> BranchPart:
        return part_of(self.stretch, looked, point, self.along, special, detail)


def _fault_at(stretch: BranchStretch, point: Point, fault: Exception) -> str:
    """What is said where a change of the word meets an error of the library itself."""
    return (
        f"the branch ends at {stretch.options.parameter} = {point.p:.10g}, where its word changes"
        f" ({kind_of(point.special)}), by an error within nonsmooth, which should not be:"
        f" {type(fault).__name__}: {fault}; the points until there are kept; begin anew with an"
        " orbit beyond it, from find_orbit with other parameters="
    )


def _is_spurious(point: Point, looked: Looked) -> bool:
    """Whether multipliers are not what the test of a point has called them.

    A pole of the test, two real multipliers whose product is one, a graze next to it.
    """
    return point.special in OF_MULTIPLIERS and not is_critical(looked, point.special)


def _may_stand(options: BranchOptions, looked: Looked) -> bool:
    """Whether an orbit is a motion, or need not be one."""
    return options.inadmissible or looked.admissibility.admissible


def _at_graze(looked: Looked) -> bool:
    """Whether branches cross only because an excursion has no duration."""
    return any(
        name.startswith("short") and value < _NEAR_GRAZE for name, value in looked.tests.items()
    )
