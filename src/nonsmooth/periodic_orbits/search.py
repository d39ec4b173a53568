"""From what a user gives to an orbit: guess, Newton's method, and words for what goes wrong."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import RunError
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.excursions import is_graze
from nonsmooth.periodic_orbits.family import member_of_family
from nonsmooth.periodic_orbits.guess import (
    Guess,
    cycle_guesses,
    driven_guess,
    from_nearest_strobe,
    guesses_in_motion,
    part_of_turn,
    random_guesses,
    strobe_of_start,
)
from nonsmooth.periodic_orbits.legs import LegError, Legs
from nonsmooth.periodic_orbits.newton import Solution, null_vector, solve_orbit
from nonsmooth.periodic_orbits.orbit import Orbit, OrbitRequest, OrbitResult, make_orbit
from nonsmooth.periodic_orbits.rebounds import with_rebounds_of_engine
from nonsmooth.periodic_orbits.restart import (
    guess_of_dataset,
    is_orbit,
    parameters_elsewhere,
    values_of_orbit,
    walk_to,
)
from nonsmooth.periodic_orbits.word_change import changes_at_once, changes_of_word
from nonsmooth.runs.strobe_times import is_driven
from nonsmooth.runs.whole_turns import periods_of_states, whole_turns

__all__ = [
    "equations_for",
    "fitted",
    "is_autonomous",
    "other_ways",
    "search_orbit",
    "solve_guess",
]

Floats = npt.NDArray[np.float64]

_RANDOM = 200  # durations tried for a given word
_PERIODS = 200  # of the motion in which a given word is looked for
_STRETCHES = 20  # of that motion that are tried, those that nearly close first
_STEPS = 25  # of Newton's method from random durations, of which most lead nowhere
_SEED = 1
_AT_REST = 1e-7  # of the size of the guess or of what it leads to, in one turn
_NEUTRAL = 1e-9  # distance of a multiplier from 1
_NEARLY_NEUTRAL = 1e-6  # likewise, of one that is double there: the root of its rounding
_OFF_FOLD = (1e-4, 1e-3, 1e-2, 0.1, 0.5)  # of the size of an orbit, along the direction of a fold


def is_autonomous(legs: Legs) -> bool:
    """Whether nothing drives a system."""
    return not is_driven(legs.tables)


def search_orbit(wanted: OrbitRequest, legs: Legs) -> OrbitResult:
    """Find the orbit that is wanted, after a longer transient where the first one is too short."""
    found = _search_word(wanted, legs) if wanted.words else _search_motion(wanted, legs)
    if found.status == "completed" or wanted.longest <= wanted.transient:
        return found
    settled = _search_motion(replace(wanted, transient=wanted.longest), legs)
    if settled.status != "completed":
        return found
    return replace(settled, transient=wanted.longest)


def _search_motion(wanted: OrbitRequest, legs: Legs) -> OrbitResult:
    """The orbit to which the motion from the start comes."""
    known = _from_orbit(wanted, legs)
    if known is not None and known.status == "completed":
        return _passed_once(wanted, legs, known)
    found = OrbitResult(
        None, None, "no_orbit",
        "the motion does not come back to where it was: it rests, or its cycle is longer than"
        " the stretch that is looked at; begin nearer to the cycle, or give transient=",
    )  # fmt: skip
    try:
        best: OrbitResult | None = None
        for guess in _guesses(wanted, legs):
            found = solve_guess(wanted, legs, guess)
            best = _better(best, found)
            if found.status == "completed":
                break
        found = _passed_once(wanted, legs, best or found)
        if found.orbit is not None:
            found = _near_start(wanted, legs, found)
    except RunError as fault:
        return known or OrbitResult(None, None, fault.status or "no_orbit", str(fault))
    return known if known is not None and found.orbit is None else found


def _passed_once(wanted: OrbitRequest, legs: Legs, found: OrbitResult) -> OrbitResult:
    """The orbit without more turns than are wanted, where nothing drives the system.

    A motion that decays slowly while it turns about its cycle comes back nearest after many turns,
    from where Newton's method leads to the cycle, passed as often.
    """
    orbit = found.orbit
    if orbit is None or not orbit.autonomous:
        return found
    more = orbit.primitive // math.gcd(orbit.primitive, wanted.period)
    if more == 1:
        return found
    shorter = solve_guess(wanted, legs, part_of_turn(orbit.word, orbit.turn, more))
    return shorter if shorter.status == found.status else found


def _near_start(wanted: OrbitRequest, legs: Legs, found: OrbitResult) -> OrbitResult:
    """The orbit told from the one of its strobes that is nearest to the start."""
    assert found.orbit is not None and found.equations is not None
    if is_autonomous(legs) or wanted.period == 1:
        return found
    state = strobe_of_start(
        wanted.system, wanted.initial, phase=wanted.phase, transient=wanted.transient,
        mode=wanted.mode, tolerance=wanted.tolerance,
    )  # fmt: skip
    guess = from_nearest_strobe(found.equations, found.orbit.turn, state)
    if guess is None:
        return found
    turned = solve_guess(wanted, legs, guess)
    return turned if turned.status == found.status else found


def _from_orbit(wanted: OrbitRequest, legs: Legs) -> OrbitResult | None:
    """The orbit from one that was found before, at other parameters or at these."""
    initial = wanted.initial
    if not is_orbit(initial) or wanted.transient > 0:
        return None
    if int(initial.attrs.get("period", wanted.period)) != wanted.period:
        return None
    guess = guess_of_dataset(wanted.system, initial)

    def solve(there: OrbitRequest, legs: Legs, guess: Guess) -> OrbitResult:
        return solve_guess(there, legs, fitted(guess, there, legs))

    found = solve(wanted, legs, guess)
    if found.status == "completed":
        return found
    begin = values_of_orbit(wanted.system, initial)
    walked = None if begin is None else walk_to(wanted, legs, guess, begin, solve)
    return walked or found


def fitted(guess: Guess, wanted: OrbitRequest, legs: Legs) -> Guess:
    """Legs of an orbit for other parameters: instants stretched to the period there."""
    turn = guess.turn
    if is_autonomous(legs) or guess.word.closes_at_event:
        return guess
    begin, length = wanted.phase * legs.window, wanted.period * legs.window
    share = (turn.instants - turn.instants[0]) / (turn.instants[-1] - turn.instants[0])
    return Guess(guess.word, Turn(turn.states, begin + share * length))


def equations_for(wanted: OrbitRequest, legs: Legs, guess: Guess) -> OrbitEquations:
    """Equations of the word of a guess."""
    return OrbitEquations(
        legs, guess.word, period=wanted.period, phase=wanted.phase,
        autonomous=is_autonomous(legs), origin=guess.turn.states[0],
        reference=guess.turn.states[0].copy(),
    )  # fmt: skip


def solve_guess(wanted: OrbitRequest, legs: Legs, guess: Guess) -> OrbitResult:
    """Newton's method from a guess; drifts begin at zero, angles within half a turn of it."""
    drifting = np.array([name in wanted.system.drift_states for name in wanted.system.states])
    begin = guess.turn.states[0]
    over = whole_turns(begin, periods_of_states(wanted.system))
    states = guess.turn.states - np.where(drifting, begin, over)
    guess = Guess(guess.word, Turn(states, guess.turn.instants))
    equations = equations_for(wanted, legs, guess)
    unknowns = equations.pack(guess.turn)
    solution = solve_orbit(equations, unknowns)
    if solution.status != "completed":
        member = member_of_family(equations, unknowns) if equations.autonomous else None
        if member is not None:
            return finish(wanted, equations, member)
        solution = _off_fold(equations, unknowns) or solution
    if solution.status != "completed":
        return OrbitResult(None, equations, solution.status, _failure(wanted, equations, solution))
    if _has_come_to_rest(equations, solution, guess):
        return OrbitResult(
            None, equations, "no_orbit",
            "Newton's method comes to a point at rest, which has no period: the motion settles"
            " there, or its amplitude is not determined; begin nearer to a cycle",
        )  # fmt: skip
    for _ in range(len(guess.word)):
        turned = _through_section(equations, solution)
        if turned is None:
            break
        equations = equations_for(wanted, legs, turned)
        solution = solve_orbit(equations, equations.pack(turned.turn))
        if solution.status != "completed":
            return OrbitResult(
                None, equations, solution.status, _failure(wanted, equations, solution)
            )
    found = finish(wanted, equations, solution)
    if found.status == "inadmissible":
        found = _without_empty_leg(wanted, legs, equations, found) or found
    if found.status == "inadmissible":
        found = _with_other_rebounds(wanted, legs, found) or found
    return found


def _has_come_to_rest(equations: OrbitEquations, solution: Solution, guess: Guess) -> bool:
    """Whether a cycle without events has shrunk to a point."""
    if not equations.autonomous or equations.word.closes_at_event:
        return False
    turn = equations.unpack(solution.unknowns)
    found = equations.legs.follow(equations.word, turn.states, turn.instants)
    way = np.abs(found.start_rates[0]).max() * float(turn.durations[0])
    # of either: a guess may begin at zero, and end at a rest elsewhere
    size = max(np.abs(guess.turn.states).max(), np.abs(turn.states).max())
    return bool(way <= _AT_REST * size)


def _without_empty_leg(
    wanted: OrbitRequest, legs: Legs, equations: OrbitEquations, found: OrbitResult
) -> OrbitResult | None:
    """The orbit without legs of no duration, as beside a graze, or where the start stuck once."""
    assert found.orbit is not None
    turn, word, wiring = found.orbit.turn, equations.word, legs.tables.wiring
    names = [
        f"{'short' if is_graze(word, wiring, int(k)) else 'leg'}:{k}"
        for k in np.flatnonzero(turn.durations <= 0.0)
        if word.paths[k]
    ]
    changes = changes_at_once(equations, turn, names) if len(names) > 1 else []
    for name in names:
        changes += changes_of_word(equations, turn, name)
    for change in changes:
        other = equations_for(wanted, legs, change.guess)
        solution = solve_orbit(other, other.pack(change.guess.turn))
        if solution.status == "completed":
            better = finish(wanted, other, solution)
            if better.status == "completed":
                return better
    return None


def _with_other_rebounds(
    wanted: OrbitRequest, legs: Legs, found: OrbitResult
) -> OrbitResult | None:
    """The orbit with as many rebounds before rest as the motion has."""
    assert found.orbit is not None and found.equations is not None
    guess = with_rebounds_of_engine(found.equations, found.orbit.turn, wanted.tolerance)
    if guess is None or guess.word == found.equations.word:
        return None
    equations = equations_for(wanted, legs, guess)
    solution = solve_orbit(equations, equations.pack(guess.turn))
    if solution.status != "completed":
        return None
    better = finish(wanted, equations, solution)
    return better if better.status == "completed" else None


def _off_fold(equations: OrbitEquations, unknowns: Floats) -> Solution | None:
    """The orbit near a guess that lies on a fold of the branch, from which no step leads to it."""
    try:
        away = null_vector(equations, unknowns)
    except (LegError, np.linalg.LinAlgError):
        return None
    for part in _OFF_FOLD:
        for way in (part, -part):
            solution = solve_orbit(equations, unknowns + way * away)
            if solution.status == "completed":
                return solution
    return None


def _through_section(equations: OrbitEquations, solution: Solution) -> Guess | None:
    """The same orbit where an event has passed the section on the way to it, else None."""
    turn = equations.unpack(solution.unknowns)
    if equations.word.closes_at_event or len(equations.word) < 2:
        return None
    ends = {"leg:0": turn.durations[0], "leg:last": turn.durations[-1]}
    name = min(ends, key=lambda each: ends[each])
    if ends[name] > 0.0:
        return None
    return changes_of_word(equations, turn, name)[0].guess


def finish(wanted: OrbitRequest, equations: OrbitEquations, solution: Solution) -> OrbitResult:
    """An orbit of a solution, judged."""
    orbit = make_orbit(equations, solution, wanted.tolerance)
    orbit = replace(orbit, in_family=_is_in_family(equations, orbit))
    said = []
    if orbit.primitive > 1:
        said.append(
            f"the turn passes {orbit.primitive} times through a shorter orbit; the motion has only"
            " this one there, or the guess is nearer to it"
        )
    if orbit.in_family:
        said.append(
            "a multiplier is 1: the orbit is one of a family, for nothing fixes its amplitude;"
            " this one is the nearest to the guess"
        )
    elif np.any(np.abs(orbit.multipliers.multipliers - 1.0) <= _NEUTRAL):
        said.append(
            "a multiplier is 1: the orbit lies on a fold, where branches cross, or is one of a"
            " family, as where nothing fixes its amplitude"
        )
    if orbit.multipliers.multipliers.size and not np.any(orbit.multipliers.multipliers):
        said.append("superstable: every perturbation is lost within a turn")
    if not orbit.admissibility.admissible:
        said.append(
            f"the equations of the word have this solution, but it is no motion:"
            f" {orbit.admissibility.reason}; {other_ways(wanted)}"
        )
        return OrbitResult(orbit, equations, "inadmissible", "; ".join(said))
    said = said or ["completed"]
    return OrbitResult(orbit, equations, "completed", "; ".join(said))


def other_ways(wanted: OrbitRequest) -> str:
    """What to try in place of a solution that is no motion."""
    if wanted.words:
        return "simulate it, or give another word="
    elsewhere = parameters_elsewhere(wanted.system, wanted.initial)
    begin = f"{elsewhere}; here a motion" if elsewhere else "a motion there"
    return (
        f"{begin} need not repeat after period={wanted.period}, and regime says after how many"
        " periods it does: give that period=, initial= near an orbit of this one, or word="
    )


def _is_in_family(equations: OrbitEquations, orbit: Orbit) -> bool:
    """Whether cycles of other sizes lie beside one that nothing drives."""
    near = np.any(np.abs(orbit.multipliers.multipliers - 1.0) <= _NEARLY_NEUTRAL)
    if not (equations.autonomous and near):
        return False
    return member_of_family(equations, equations.pack(orbit.turn)) is not None


def _guesses(wanted: OrbitRequest, legs: Legs) -> Iterator[Guess]:
    if is_autonomous(legs):
        yield from cycle_guesses(
            wanted.system, wanted.initial, period=wanted.period, transient=wanted.transient,
            mode=wanted.mode, tolerance=wanted.tolerance,
        )  # fmt: skip
    else:
        yield driven_guess(
            wanted.system,
            wanted.initial,
            period=wanted.period,
            phase=wanted.phase,
            transient=wanted.transient,
            mode=wanted.mode,
            tolerance=wanted.tolerance,
        )


def _search_word(wanted: OrbitRequest, legs: Legs) -> OrbitResult:
    """Stretches of motions first, then random durations; motions before constructions."""
    best: OrbitResult | None = None
    autonomous = is_autonomous(legs)
    for guess in islice(_guesses_of_word(wanted, legs), _STRETCHES):
        found = solve_guess(wanted, legs, guess)
        if found.status == "completed":
            return found
        best = _better(best, found)
    length = wanted.period * legs.window
    origin = np.array([wanted.system.rest_state[name] for name in wanted.system.states])
    for word in wanted.words:
        equations = OrbitEquations(
            legs, word, period=wanted.period, phase=wanted.phase, autonomous=autonomous,
            origin=origin, reference=origin.copy(),
        )  # fmt: skip
        tries = _RANDOM if len(word) > 1 else 3
        for unknowns in random_guesses(equations, length, tries, _SEED):
            try:
                solution = solve_orbit(equations, unknowns, steps=_STEPS)
            except LegError:
                continue
            if solution.status != "completed" or np.any(
                equations.unpack(solution.unknowns).durations <= 0.0
            ):
                continue
            found = finish(wanted, equations, solution)
            if found.status == "inadmissible":
                found = _with_other_rebounds(wanted, legs, found) or found
            if found.status == "completed":
                return found
            best = _better(best, found)
    if best is not None:
        return best
    return OrbitResult(
        None, None, "no_orbit",
        f"no orbit of period {wanted.period} with this word was found, in {_PERIODS} periods of"
        f" motion and from {_RANDOM} random durations; it may not exist for these parameters:"
        " follow it from others with continue_orbit, or give initial= near it",
    )  # fmt: skip


def _guesses_of_word(wanted: OrbitRequest, legs: Legs) -> Iterator[Guess]:
    """Stretches of a motion that follow one of the words that are wanted."""
    if not is_autonomous(legs):
        yield from guesses_in_motion(
            wanted.system, wanted.initial, list(wanted.words), period=wanted.period,
            phase=wanted.phase, periods=_PERIODS + wanted.transient, tolerance=wanted.tolerance,
        )  # fmt: skip
        return
    wiring = legs.tables.wiring
    known = {(word.modes, word.paths) for word in (each.collapsed(wiring) for each in wanted.words)}
    try:
        for guess in _guesses(wanted, legs):
            seen = guess.word.collapsed(wiring)
            if (seen.modes, seen.paths) in known:
                yield guess
    except RunError:  # the motion ends, and random durations are left
        return


def _better(best: OrbitResult | None, found: OrbitResult) -> OrbitResult | None:
    """The first motion, else the first construction."""
    if found.orbit is None or (best is not None and best.status == "completed"):
        return best
    return found if best is None or found.status == "completed" else best


def _failure(wanted: OrbitRequest, equations: OrbitEquations, solution: Solution) -> str:
    word = equations.word.text(wanted.system)
    if solution.status == "singular":
        growing = _grows(equations, solution)
        if growing:
            return growing
        return (
            f"the equations of the word '{word}' are singular near the guess: the orbit grazes, a"
            " branch folds there, or nothing fixes its amplitude; change a parameter a little, or"
            " follow a branch with continue_orbit, which passes such points"
        )
    return (
        f"Newton's method finds no orbit of period {wanted.period} with the word '{word}' near the"
        f" guess (residual {solution.residual:.2g} after {solution.iterations} steps); give"
        " initial= nearer to it, transient= for a motion that has settled, another period=, or"
        " word= for the modes that it visits"
    )


def _grows(equations: OrbitEquations, solution: Solution) -> str:
    """Which states grow by a constant over each turn of a word, "" where none does."""
    try:
        grows = equations.steady_growth(solution.unknowns)
    except LegError:
        return ""
    if not grows or len(grows) == equations.legs.n:  # all of them do in a resonance
        return ""
    told = " and ".join(f"{name} changes by {by:.6g}" for name, by in grows.items())
    names = ", ".join(f'"{name}"' for name in grows)
    return (
        f"{told} in each turn of the word '{equations.word.text(equations.legs.system)}', wherever"
        " it begins, so no such turn closes; where such a state comes back after more turns, give"
        f" their number as period=; where it counts on for ever, declare it: drift=[{names}]"
    )
