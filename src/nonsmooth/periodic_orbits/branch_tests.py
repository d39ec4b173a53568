"""What is watched along a branch of orbits: multipliers, and everything that keeps its word valid.

Each is a number without unit whose sign changes where something happens. Names tell what:
``flip`` and ``torus`` for multipliers; ``graze:k:g``, guard g comes down to zero within leg k;
``corner:k:g``, it is zero at the end of leg k, where another guard is; ``short:k``, leg k is about
to vanish in a graze, or together with the next one at a corner; ``leg:k``, it vanishes otherwise;
``rate:k``, the exit of leg k is passed without a rate; ``gain:k:j``, exit j of a path is no longer
passed at once; ``over:k:g``, the impact that ends leg k throws over the surface of guard g;
``slide:k``, both sides of the surface at the end of leg k point at it;
``enter:k:g``, guard g of the cell on a surface that leg k ends at lets motion off it at once;
``shrink``, a cycle without events touches the plane on which it begins, or shrinks to a point;
``motion``, the engine finds another motion although none of these has changed its sign.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.orbits import LegResults
from nonsmooth.engine.tables import DERIVATIVES, Wiring
from nonsmooth.periodic_orbits.admissibility import Admissibility, check_admissible
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.excursions import is_graze, path_at_corner
from nonsmooth.periodic_orbits.guards_behind import EntryGuards, JumpedGuards, KeptGuards
from nonsmooth.periodic_orbits.in_words import in_words
from nonsmooth.periodic_orbits.legs import LegError, Minima
from nonsmooth.periodic_orbits.multipliers import Floquet, floquet, multipliers_at_touch
from nonsmooth.periodic_orbits.newton import AT_ZERO, scale_of, solve_orbit
from nonsmooth.periodic_orbits.onto import (
    chatters,
    crosses,
    is_onto,
    kind_of_excursion,
    modes_along,
)
from nonsmooth.periodic_orbits.rebounds import with_rebounds_of_engine
from nonsmooth.periodic_orbits.rest_margin import RestMargins
from nonsmooth.periodic_orbits.strobes import NO_STROBES, Strobes, strobes_of
from nonsmooth.periodic_orbits.symmetric import Reflection, half_turn_later, reflection
from nonsmooth.periodic_orbits.touches import lowest_at_section
from nonsmooth.periodic_orbits.word import Word

__all__ = [
    "BranchTests",
    "Looked",
    "broken_tests",
    "is_of_word",
    "largest_along",
    "states_along",
    "tests_of_multipliers",
    "what_of",
]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_WITHIN = 8  # places in each leg at which states are looked at for their size
_RESTS = 1e-9  # of the terms of a guard: what the states make of it on an orbit that rests
_EPS = float(np.finfo(float).eps)
# roundings in the terms of a guard: those of the flow, and of the equations that are solved. Up to
# 20 were seen in guards that are zero by construction
_ROUNDINGS = 500.0
_OF_WORD = (
    "graze", "corner", "short", "leg", "rate", "gain", "over", "slide", "enter", "shrink",
    "rest", "border", "motion",
)  # fmt: skip
# part of the turn: a contact of this duration counts as a graze. It is as long as the root of the
# distance from the graze, so this is 1e-10 away; shorter ones make Newton's matrix singular
_SHORT = 1e-5
# likewise of an excursion from a surface on which motion slides: it leaves and comes back with the
# square of its duration as rate, so an instant is known to rounding over that
_SHORT_OF_SLIDE = 1e-3
_REMEMBERED = 100  # orbits: those of a step, with the trials for its special points
_AT_CHANGE = 1e-9  # of a test: the word is about to change
# a margin of rest counts by this: rebounds before rest are followed until flights are as low as
# 1e-12 of the terms of their guard, of which rounding leaves 1e-4, so 1e-3 of it is about to change
_OF_REST = 1e-6
_OF_GUARDS = ("graze", "corner", "gain", "over", "border")  # not rates nor durations
_TOUCHES = 1e-6  # speed of an impact beside the rates of all states
# of tests: some tens of roundings over the distance of a multiplier from 1, and at most: 1e-6 was
# seen at a distance of 1e-9
_ROUNDING, _MOST_ROUNDING = 1e-14, 1e-5
_INSIDE = np.array([0.25, 0.6])  # of a turn, where an equilibrium has the same states
_STILL = 1e-9  # of the size of a state, by which it does not move
_NEARLY_ONE = 1e-4  # distance of a multiplier from 1 at which rounding begins to be seen
_ZERO = 1e-10  # a test that is never more than that is zero by construction


def what_of(name: str) -> str:
    """What a test is about: its name without the legs and guards behind it."""
    return name.split(":")[0]


def is_of_word(name: str) -> bool:
    """Whether a test is one of those that keep the word of an orbit valid."""
    return what_of(name) in _OF_WORD


def broken_tests(looked: Looked, below: float = 0.0) -> set[str]:
    """Tests of the word behind whose zeros an orbit lies."""
    return {name for name, value in looked.tests.items() if is_of_word(name) and value < below}


class _GuardSizes(NamedTuple):
    """Numbers for each guard of each leg; shapes (L, e)."""

    value: Floats  # what it comes to for states as large as those of the orbit
    rounding: Floats  # what rounding leaves of it where it should be zero


def _guard_sizes(
    equations: OrbitEquations, turn: Turn, found: LegResults, largest: Floats
) -> _GuardSizes:
    """Sizes for states of a given size and legs that are passed."""
    tables, n = equations.legs.tables, equations.legs.n
    guards = DERIVATIVES * tables.sizes.exits
    rows = np.abs(tables.affine[equations.word.mode_array, :guards:DERIVATIVES])
    sizes = rows[:, :, :n] @ largest
    # with 1 and the harmonics; an orbit has no powers of time, and signals count for nothing
    first, last = n + 1 + tables.sizes.powers, tables.sizes.first_of_signals
    terms = sizes + rows[:, :, n] + rows[:, :, first:last].sum(axis=2)
    rate = np.einsum("kgi,ki->kg", rows[:, :, :n], np.abs(found.end_rates))
    late = float(np.abs(turn.instants).max())
    rounding = _EPS * (_ROUNDINGS * terms + late * rate)
    # a guard of time alone, and an orbit that rests, where rounding would be the measure
    sizes = np.where(sizes > _RESTS * terms, sizes, terms)
    sizes = np.where(sizes > 0.0, sizes, max(float(largest.max(initial=0.0)), 1e-300))
    return _GuardSizes(sizes, rounding)


def states_along(equations: OrbitEquations, turn: Turn) -> Floats:
    """States along an orbit, within the legs too, without how far the drifts have come."""
    legs, count = equations.legs, len(equations.word)
    leg = np.repeat(np.arange(count), _WITHIN)
    begins = turn.instants[leg]
    ends = begins + np.tile(np.arange(1, _WITHIN + 1) / _WITHIN, count) * turn.durations[leg]
    open_word = Word(tuple(equations.word.modes[k] for k in leg), ((),) * leg.size)
    states = turn.states
    try:
        within = legs.follow_each(open_word, turn.states[leg], begins, ends).ends
        states = np.concatenate([states, within])
    except LegError:  # those at the events have to do
        pass
    return np.asarray(states - np.where(equations.drifting, turn.states[0], 0.0))


def largest_along(equations: OrbitEquations, turn: Turn) -> Floats:
    """Largest size of each state along an orbit, within the legs too, drifts left out."""
    return np.asarray(np.abs(states_along(equations, turn)).max(axis=0))


def _from_one(multipliers: Floquet) -> float:
    """Distance of the nearest multiplier from 1, at most 1."""
    return float(np.abs(multipliers.multipliers - 1.0).min(initial=1.0))


@dataclass
class Looked:
    """An orbit on a branch, looked at."""

    turn: Turn
    end: Floats
    values: Floats
    window: float
    residual: float
    multipliers: Floquet
    admissibility: Admissibility
    tests: dict[str, float]
    # those of guards that are met at one instant, of which there has been no more than rounding
    quiet: dict[str, float]
    other: tuple[OrbitEquations, Floats] | None = None  # with the rebounds that the engine follows
    reflection: Reflection | None = None  # under the declared symmetry
    strobes: Strobes = NO_STROBES

    @property
    def rounding(self) -> float:
        """What tests are known to: rounding moves an orbit far that has a multiplier close to 1."""
        return min(_MOST_ROUNDING, _ROUNDING / max(_from_one(self.multipliers), 1e-300))


def _shortest(wiring: Wiring, mode: int, k: int, word: Word) -> float:
    """Part of the turn below which leg k counts as an excursion that is about to vanish."""
    last = k - 2 if k == 0 and not word.closes_at_event and len(word) > 2 else k - 1
    kind = kind_of_excursion(wiring, word.modes[last % len(word)], mode)
    return _SHORT_OF_SLIDE if kind == "adding_sliding" else _SHORT


class _Beside(NamedTuple):
    """What is told of an orbit beside the results of its legs."""

    entered: dict[tuple[int, int], float]  # guards of cells on surfaces, where they are entered
    jumped: dict[tuple[int, int], float]  # guards of surfaces that impacts jump over
    kept: dict[tuple[int, int], float]  # guards of surfaces that impacts do not jump over
    rests: dict[int, float]  # margins of rebounds before rest
    lowest: Floats  # value of each guard within each leg


class BranchTests:
    """Looks at the orbits of one word; the last ones are remembered."""

    def __init__(
        self, equations: OrbitEquations, tolerance: float, *, whole: bool = True, grows: str = ""
    ) -> None:
        """``grows``: the test that is zero where the stretch begins and counts all the same."""
        self.equations, self.tolerance, self.whole = equations, tolerance, whole
        # tests that have been more than what rounding or a decay leaves
        self._clear = {grows}
        self._told: set[str] | None = None
        self._quiet: dict[str, float] = {}  # of the last orbit
        self._largest: Floats | None = None
        word, wiring = equations.word, equations.legs.tables.wiring
        self._wiring = wiring
        self._grazing = [is_graze(word, wiring, k) for k in range(len(word))]
        self._corners = [path_at_corner(word, wiring, k) is not None for k in range(len(word))]
        self._short = [_shortest(wiring, mode, k, word) for k, mode in enumerate(word.modes)]
        self._resets = np.array(
            [
                bool(path) and wiring.resets(mode, path[0])
                for mode, path in zip(word.modes, word.paths, strict=True)
            ]
        )
        families = equations.legs.tables.families
        self._surface = [  # legs that end at a surface which is crossed without a reset
            crosses(wiring, families, word.modes[k], path) for k, path in enumerate(word.paths)
        ]
        self._kept, self._rests = KeptGuards(equations), RestMargins(equations)
        self._entries, self._jumped = EntryGuards(equations), JumpedGuards(equations)
        self._seen: dict[bytes, Looked] = {}
        # legs in which the engine has found an event that the search for minima has missed
        self.closely: set[int] = set()
        # leg and guard of a graze that is followed, and the part of the leg at which it was last
        self.followed: tuple[int, int, float] | None = None
        # those of rebounds before rest, whose number changes although nothing happens
        self._rebounds = {k for each in chatters(word.modes, word.paths, wiring) for k in each}

    def look(self, unknowns: Floats) -> Looked:
        """The orbit of these unknowns, for the parameter values that the legs have."""
        equations, legs = self.equations, self.equations.legs
        key = unknowns.tobytes() + legs.values.tobytes()
        if key in self._seen:
            return self._seen[key]
        turn = equations.unpack(unknowns)
        beside = _Beside(
            self._entries.values(turn), self._jumped.values(turn), self._kept.values(turn),
            self._rests.values(turn), self._lowest(turn),
        )  # fmt: skip
        found = legs.follow(equations.word, turn.states, turn.instants)
        residual = equations.gap(turn, found)
        turn = Turn(found.starts.copy(), turn.instants)
        multipliers = floquet(equations, found)
        if self._is_slow_at_events(turn, found):
            multipliers = multipliers_at_touch(equations, turn)
            found = legs.follow(equations.word, turn.states, turn.instants)
        tests = self._of_multipliers(multipliers)
        end, admissibility = found.nexts[-1].copy(), Admissibility(True)
        at_rest = bool(equations.word.n_events) and self._is_at_zero(turn, found)
        # guards that vanish all along tell of rounding
        near, self._quiet = _from_one(multipliers), {}
        kept, faded = ({}, set()) if at_rest else self._of_word(turn, found, beside, near)
        image = reflection(equations, turn)
        if image is not None and image.later == 0.5 and near < _NEARLY_ONE:
            kept = self._alike(kept)
        tests |= kept
        other = None
        if self.whole and not at_rest:
            told = self._told_of(kept)
            least = min(kept, key=lambda name: kept[name], default="")
            if any(kept[name] < 0.0 for name in kept.keys() - told):
                tests["motion"] = -1.0
            if "motion" in tests or (least and kept[least] < -_AT_CHANGE):
                admissibility = Admissibility(False, self._broken(least))
            elif self._quiet and near < _NEARLY_ONE:
                pass  # rounding parts what is met at one instant
            elif all(kept[name] > _AT_CHANGE for name in kept.keys() & told - faded):
                admissibility = check_admissible(equations, turn, self.tolerance)
                leg = admissibility.leg if admissibility.path else -1
                if leg >= 0 and leg not in self.closely | self._rebounds:
                    self.closely.add(leg)
                    self._seen.clear()
                    return self.look(unknowns)
                if not admissibility.admissible:
                    other = self._with_other_rebounds(turn)
                    admissibility = admissibility if other is None else Admissibility(True)
                tests["motion"] = 1.0 if admissibility.admissible else -1.0
            # else the word is about to change, and rounding decides what the engine finds
        looked = Looked(
            turn, end, legs.values.copy(), legs.window, residual, multipliers, admissibility, tests,
            self._quiet, other, image, strobes_of(equations, turn),
        )  # fmt: skip
        if len(self._seen) >= _REMEMBERED:
            del self._seen[next(iter(self._seen))]
        self._seen[key] = looked
        return looked

    def _of_multipliers(self, multipliers: Floquet) -> dict[str, float]:
        """Their tests; that of a torus says nothing while all it has been is rounding.

        Where nothing is lost, pairs of multipliers have the product one all along.
        """
        tests = tests_of_multipliers(multipliers)
        if abs(tests.get("torus", 0.0)) > _ZERO:
            self._clear.add("torus")
        elif "torus" not in self._clear:
            tests.pop("torus", None)
        return tests

    def _is_slow_at_events(self, turn: Turn, found: LegResults) -> bool:
        """Whether few digits are known of the speed with which an orbit comes to its events.

        As of a cycle that hardly touches a wall, and of an orbit at rest on a surface.
        """
        if not self.equations.autonomous:
            return self._is_at_zero(turn, found)
        n = self.equations.legs.n
        rows = np.linalg.norm(found.guard_row[:, :n], axis=1)
        fast = np.linalg.norm(found.end_rates, axis=1) * rows
        return bool(np.any(self._resets & (np.abs(found.guard_rate) <= _TOUCHES * fast)))

    def _is_at_zero(self, turn: Turn, found: LegResults) -> bool:
        """Whether an orbit without size, as nothing drives it, lies on the surfaces of its events.

        Their guards have no part that the states do not make, as those of walls that move have.
        """
        states = np.abs(np.vstack([turn.states, found.ends])[:, ~self.equations.drifting])
        if states.max(initial=0.0) > AT_ZERO:
            return False
        word, legs = self.equations.word, self.equations.legs
        guards = [
            legs.tables.affine[mode, DERIVATIVES * path[0], legs.n :]
            for mode, path in zip(word.modes, word.paths, strict=True)
            if path
        ]
        return not np.abs(guards).max(initial=0.0) > AT_ZERO

    def _broken(self, name: str) -> str:
        """What has happened before an orbit, in words."""
        return f"beyond where {in_words(self.equations.legs.system, self.equations.word, name)}"

    def _lowest(self, turn: Turn) -> Floats:
        """Lowest value of each guard within each leg. It overwrites results that the legs hold."""
        word, legs = self.equations.word, self.equations.legs
        lowest = legs.minima(word, turn.states, turn.instants).values
        for k in self.closely:
            begin, end = turn.instants[k : k + 2]
            lowest[k] = legs.closer_minima(word.modes[k], turn.states[k], begin, end).values
        at_strobe = lowest_at_section(self.equations, turn)
        alone = np.isnan(lowest[0]) & np.isnan(lowest[-1])
        lowest[0] = np.where(alone, at_strobe, lowest[0])
        if self.followed is not None:
            k, g, part = self.followed
            lowest[k, g] = self._followed_minima(turn, k, part).values[g]
        return lowest

    def _followed_minima(self, turn: Turn, k: int, part: float) -> Minima:
        begin, end = turn.instants[k : k + 2]
        mode, place = self.equations.word.modes[k], part * (end - begin)
        return self.equations.legs.minima_near(mode, turn.states[k], begin, end, place)

    def follow_graze(self, unknowns: Floats, k: int, g: int) -> None:
        """Look at guard g in leg k near where it is lowest now, or was when it was followed before.

        Elsewhere in the leg it may become lower.
        """
        turn, legs = self.equations.unpack(unknowns), self.equations.legs
        if self.followed is None:
            places = legs.minima(self.equations.word, turn.states, turn.instants).places[k]
        else:
            places = self._followed_minima(turn, k, self.followed[2]).places
        duration = float(turn.durations[k])
        if np.isfinite(places[g]) and duration > 0.0:
            self.followed = (k, g, float(places[g]) / duration)

    def _of_word(
        self, turn: Turn, found: LegResults, beside: _Beside, near: float
    ) -> tuple[dict[str, float], set[str]]:
        """What keeps the word valid, positive where it is, from the results of its legs.

        And the names of those of which only rounding is left, whose sign says nothing. ``near`` is
        the distance of the nearest multiplier from 1.
        """
        equations, word = self.equations, self.equations.word
        length = float(turn.instants[-1] - turn.instants[0])
        tests: dict[str, float] = {}
        sizes = _guard_sizes(equations, turn, found, self._largest_so_far(turn))
        if self._is_equilibrium(turn):
            values, size = found.others[0], sizes.value[0]
            for guard in self._still_guards(turn, size):  # they have no lowest value
                tests[f"border:0:{guard}"] = float(values[guard] / size[guard])
                beside.lowest[0, guard] = np.nan
        for k, path in enumerate(word.paths):
            for g in np.flatnonzero(np.isfinite(beside.lowest[k])):
                tests[f"graze:{k}:{g}"] = float(beside.lowest[k, g] / sizes.value[k, g])
            if not path:
                continue
            duration, e = float(turn.durations[k]), path[0]
            cut = k == 0 and not word.closes_at_event  # by the section
            if self._grazing[k]:
                whole = duration + (float(turn.durations[-1]) if cut else 0.0)
                speed = abs(float(found.guard_rate[k])) / float(sizes.value[k, e])
                # a slip between long rests is short beside the turn, and its guard is large in it
                tests[f"short:{k}"] = max(whole / length, speed * whole) - self._short[k]
            if self._corners[k]:
                both = float(turn.durations[k : k + 2].sum())
                tests[f"short:{k}"] = both / length - self._short[k]
            if cut or not self._grazing[k]:
                tests[f"leg:{k}"] = duration / length
            size = float(sizes.value[k, e])
            tests[f"rate:{k}"] = -float(found.guard_rate[k]) * length / size
            if self._surface[k]:
                tests[f"slide:{k}"] = self._into_next(found, k) * length / size
            modes = modes_along(self._wiring, word.modes[k], path)
            for j in range(1, len(path)):
                if not is_onto(self._wiring, modes[j], path[j]):
                    passed = beside.jumped.get((k, j), float(found.passed[k, j]))
                    tests[f"gain:{k}:{j}"] = -passed / size
            for g in np.flatnonzero(np.isfinite(found.others[k])):
                if g != e:
                    tests[f"corner:{k}:{g}"] = float(found.others[k, g] / sizes.value[k, g])
        for (k, guard), value in beside.kept.items():
            tests[f"over:{k}:{guard}"] = value / float(sizes.value[(k + 1) % len(word), guard])
        for (k, guard), value in beside.entered.items():
            size = float(sizes.value[(k + 1) % len(word), guard])
            tests[f"enter:{k}:{guard}"] = value / size
        tests |= {f"rest:{k}": _OF_REST * margin for k, margin in beside.rests.items()}
        if word.paths[-1] == ():
            tests["leg:last"] = float(turn.durations[-1]) / length
        if equations.is_smooth_cycle:
            tests["shrink"] = equations.forwards(turn, found)
        return self._with_margins(tests, sizes, near)

    def _is_equilibrium(self, turn: Turn) -> bool:
        """Whether no state changes in a turn without events."""
        if self.equations.word.n_events or self.equations.is_smooth_cycle:
            return False
        inside = turn.instants[0] + _INSIDE * float(np.ptp(turn.instants))
        states = self.equations.states_along(turn, inside)
        apart = np.where(self.equations.drifting, 0.0, np.abs(states - turn.states[0]))
        scale = scale_of(self.equations, self.equations.pack(turn))[: turn.states.shape[1]]
        return bool(np.all(apart.max(axis=0) <= _STILL * scale))

    def _still_guards(self, turn: Turn, sizes: Floats) -> list[int]:
        """Guards that do not change along an equilibrium, as those of walls that move do."""
        first, length = float(turn.instants[0]), float(np.ptp(turn.instants))
        ends = first + np.append(_INSIDE, 1.0) * length
        word = Word(self.equations.word.modes[:1] * ends.size, ((),) * ends.size)
        states, begins = np.tile(turn.states[0], (ends.size, 1)), np.full(ends.size, first)
        guards = self.equations.legs.follow_each(word, states, begins, ends).others
        still = np.ptp(guards, axis=0) <= _STILL * sizes
        return np.flatnonzero(still & np.all(np.isfinite(guards), axis=0)).tolist()

    def _with_margins(
        self, tests: dict[str, float], sizes: _GuardSizes, near: float
    ) -> tuple[dict[str, float], set[str]]:
        """Tests of guards change their sign where they come below what rounding leaves of zero.

        A guard may fade along a branch, as one of a motion that decays; its sign is rounding then.
        Guards that are met at one instant all along, as those of equal machines, part by rounding
        that grows where an orbit has a multiplier near 1.
        """
        relative, faded = sizes.rounding / sizes.value, set()
        word = self.equations.word
        for name in tests:
            kind, *numbers = name.split(":")
            if kind in _OF_GUARDS:
                k, g = map(int, numbers)
                if kind == "over":  # it is one of the next leg
                    k = (k + 1) % len(self.equations.word)
                if kind == "gain":  # it is measured by the exit before it
                    g = self.equations.word.paths[k][0]
                margin = float(relative[k, g])
                # where it comes below, which is at -margin, it does say something
                if abs(tests[name]) <= 0.5 * margin:
                    faded.add(name)
                elif kind in ("gain", "corner") and len(word.paths[k]) > 1:
                    apart = min(margin / max(near, _EPS), _MOST_ROUNDING)
                    tests[name] = 0.0 if abs(tests[name]) <= apart else tests[name]
                tests[name] += margin
        # rounding parts what is met at one instant by more where a multiplier is near 1
        apart = min(_ZERO / max(near, _EPS), _MOST_ROUNDING)
        several = {
            name
            for name in tests
            if what_of(name) in ("gain", "corner")
            if len(word.paths[int(name.split(":")[1])]) > 1
        }
        self._clear |= {
            name
            for name, value in tests.items()
            if abs(value) > (apart if name in several else _ZERO)
        }
        kept = {name: value for name, value in tests.items() if name in self._clear}
        self._quiet = {name: tests[name] for name in several - kept.keys()}
        return kept, faded

    def counts(self, name: str) -> bool:
        """Whether a test has been more than what rounding leaves of it."""
        return name in self._clear

    def _alike(self, tests: dict[str, float]) -> dict[str, float]:
        """Tests of an orbit that is its own image, the same in both halves of its turn.

        Where a perturbation that breaks the symmetry hardly decays, rounding makes halves differ.
        Their mean is left.
        """
        later = {name: half_turn_later(self.equations, name) for name in tests}
        return {
            name: 0.5 * (value + tests[later[name]]) if later[name] in tests else value
            for name, value in tests.items()
        }

    def _told_of(self, kept: dict[str, float]) -> set[str]:
        """Names of the tests that were there before, or are clear of zero.

        One that is there for the first time, and negative, never changed its sign. Such is the
        lowest value of a guard that has faded where a leg begins, and falls there.
        """
        # what comes behind such a change can be asked of a driven motion only
        everything = self._told is None or self.equations.autonomous
        new = {name for name, value in kept.items() if everything or value > _AT_CHANGE}
        self._told = new if self._told is None else self._told | new
        return self._told

    def _largest_so_far(self, turn: Turn) -> Floats:
        """Sizes of the states, by those of the first orbit at least: tests that scale with it."""
        if self._largest is None:
            self._largest = largest_along(self.equations, turn)
        apart = turn.states - np.where(self.equations.drifting, turn.states[0], 0.0)
        self._largest = np.maximum(self._largest, np.abs(apart).max(axis=0))
        return self._largest

    def _with_other_rebounds(self, turn: Turn) -> tuple[OrbitEquations, Floats] | None:
        """The orbit of the word whose rebounds before rest are those of the engine."""
        guess = with_rebounds_of_engine(self.equations, turn, self.tolerance)
        if guess is None or guess.word == self.equations.word:
            return None
        equations = self.equations.of_word(guess.word, guess.turn.states[0])
        try:
            solution = solve_orbit(equations, equations.pack(guess.turn))
            if solution.status != "completed":
                return None
            found = equations.unpack(solution.unknowns)
            admissible = check_admissible(equations, found, self.tolerance).admissible
        except LegError:
            return None
        return (equations, solution.unknowns) if admissible else None

    def _into_next(self, found: LegResults, k: int) -> float:
        """How fast the guard that ends leg k goes on falling behind the surface."""
        n, row = self.equations.legs.n, found.guard_row[k]
        of_time = found.guard_rate[k] - row[:n] @ found.end_rates[k]
        behind = found.start_rates[(k + 1) % len(self.equations.word)]
        return -float(row[:n] @ behind + of_time)


def tests_of_multipliers(multipliers: Floquet) -> dict[str, float]:
    """What vanishes where a multiplier is -1, or two of them have the product one."""
    values = multipliers.multipliers
    if not np.all(np.isfinite(values)):
        return {}
    poles = multipliers.poles
    tests = {"flip": float(np.prod(values + 1.0).real) * poles.determinant}
    if values.size > 1:
        i, j = np.triu_indices(values.size, 1)
        tests["torus"] = float(np.prod(values[i] * values[j] - 1.0).real) * poles.pairs
    return tests
