"""Guesses of orbits: what a motion visits, where it comes back, or a given word."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.record import columns
from nonsmooth.engine.status import CURES, EventKind, Status
from nonsmooth.engine.tables import Tables
from nonsmooth.errors import OptionError, RunError
from nonsmooth.periodic_orbits.equations import OrbitEquations, Turn
from nonsmooth.periodic_orbits.legs import LegError
from nonsmooth.periodic_orbits.strobes import strobes_of
from nonsmooth.periodic_orbits.word import Word, path_of_bits
from nonsmooth.runs.clock import Instant, Plan, since_strobe
from nonsmooth.runs.first_mode import in_first_mode
from nonsmooth.runs.runner import NoMode, Outcome, WorkLimits, build_tables, run_plan
from nonsmooth.runs.start import Start, resolve_start, start_at_end
from nonsmooth.runs.whole_turns import periods_of_states, whole_turns
from nonsmooth.system.system import System

__all__ = [
    "Guess",
    "cycle_guesses",
    "driven_guess",
    "from_nearest_strobe",
    "guesses_in_motion",
    "part_of_turn",
    "random_guesses",
    "strobe_of_start",
]

Floats = npt.NDArray[np.float64]

_LATER = 20  # stretches of a motion that are tried
_WINDOWS = 64  # in which a return is looked for, per period
_SAMPLES = 128  # in a window
# Times that: a fast cycle is found in a short stretch. Longer ones where nothing comes back in it,
# as a cycle may be slow beside a stiff cell that it never visits.
_STRETCHES = (1 / 4096, 1 / 64, 1, 64, 4096)
_RESOLVED = 0.3  # of the spread of the states: the median way between samples of a cycle
_NEAR = (1e-3, 1e-2, 5e-2)  # of the spread of the states: the first return as near is taken
_AS_NEAR = 1e-6  # of the spread: returns that are no nearer than that to each other are the same
_MOST_EVENTS = 256
_MOST_PASSED = 10_000_000  # by a motion from which an orbit is guessed: 1 GB
_STILL = 1e-9  # of the size of a state: what it must change by to move
_SWEEPS = 3  # of the states, for fixed instants
_NEARER = 1.0 - 1e-6  # of the distance of the strobe that is told: others are as near by rounding


class Guess(NamedTuple):
    """A word with states and instants that nearly close."""

    word: Word
    turn: Turn


def part_of_turn(word: Word, turn: Turn, parts: int) -> Guess:
    """The first of so many equal parts of a turn: the shorter orbit that the turn repeats."""
    length = float(turn.instants[-1] - turn.instants[0]) / parts
    count = word.n_events // parts
    if word.closes_at_event:
        short = Word(word.modes[:count], word.paths[:count])
        return Guess(short, Turn(turn.states[:count].copy(), turn.instants[: count + 1].copy()))
    short = Word(word.modes[: count + 1], (*word.paths[:count], ()))
    instants = np.append(turn.instants[: count + 1], turn.instants[0] + length)
    return Guess(short, Turn(turn.states[: count + 1].copy(), instants))


def driven_guess(
    system: System,
    initial: object,
    *,
    period: int,
    phase: float,
    transient: int,
    mode: str | None,
    tolerance: float,
) -> Guess:
    """Legs of ``period`` periods of the motion from a start, after a transient.

    Where they end in another mode than they begin in, a stretch some periods later is taken.
    Raises `RunError` where the motion ends before, `OptionError` where no mode admits the start.
    """
    for later in range(_LATER):
        guess = _stretch(system, initial, period, phase, transient + later, mode, tolerance)
        closed = _closed(guess)
        if closed is None and transient + later == 0:
            closed = _from_last_cell(system, initial, period, phase, tolerance, guess)
        if closed is not None:
            return closed
    raise RunError(
        f"{system.name}: at phase {phase:g} the motion is in another mode than {period} periods"
        f" before, {_LATER} times in a row, so no orbit of period {period} is near it; give another"
        " period=, or transient= for a motion that has settled",
        status="no_orbit",
    )


def _from_last_cell(
    system: System, initial: object, period: int, phase: float, tolerance: float, guess: Guess
) -> Guess | None:
    """The same stretch begun in the cell in which it ends, if the start lies there too.

    What has decayed lies on a border of cells, and in any of them.
    """
    running = system.structure.running
    first, last = (running[guess.word.modes[k]] for k in (0, -1))
    if first.parent != last.parent:
        return None
    try:
        return _closed(_stretch(system, initial, period, phase, 0, last.name, tolerance))
    except (OptionError, RunError):
        return None


def strobe_of_start(
    system: System, initial: object, *, phase: float, transient: int, mode: str | None,
    tolerance: float,
) -> Floats:  # fmt: skip
    """State at the section to which a start comes first, after a transient."""
    return _stretch(system, initial, 1, phase, transient, mode, tolerance).turn.states[0]


def _stretch(
    system: System, initial: object, period: int, phase: float, transient: int, mode: str | None,
    tolerance: float,
) -> Guess:  # fmt: skip
    """Legs of a motion, wherever they end."""
    tables = build_tables(system)
    window = tables.window
    start = resolve_start(system, tables, initial, mode=mode)
    start = start_at_end(start)
    late = start.instant.phase > phase * window * (1.0 + 1e-14)
    begin = Instant(start.instant.number + late + transient, phase * window)
    end = Instant(begin.number + period, begin.phase)
    numbers = np.array([begin.number, end.number], np.int64)
    plan = Plan(end, numbers, np.full(2, begin.phase))
    outcome = _run_for_guess(system, tables, start, plan, tolerance)
    return _legs_of_outcome(system, outcome, begin, end)


def _run_for_guess(
    system: System, tables: Tables, start: Start, plan: Plan, tolerance: float,
    most_events: int = _MOST_PASSED,
) -> Outcome:  # fmt: skip
    """The motion from a start, in the first mode that admits it; `RunError` where it ends early."""
    run = partial(
        run_plan, tables, plan, tolerance, state=start.state, begin=start.instant,
        limits=WorkLimits(most_events=most_events),
    )  # fmt: skip
    outcome = in_first_mode(system, tables, start, run)
    if outcome.status == Status.WORK_LIMIT:
        raise RunError(
            f"{system.name}: the motion from which the orbit is guessed has passed"
            f" {most_events:,} events at t = {outcome.end_time:.6g}, as between thresholds that"
            " meet; check them, or begin near the orbit with a smaller transient=",
            status=outcome.status.word,
            time=outcome.end_time,
        )
    if outcome.status != Status.COMPLETED:
        raise RunError(
            f"{system.name}: the motion from which the orbit is guessed ended at"
            f" t = {outcome.end_time:.6g}: {CURES.get(outcome.status, outcome.status.word)}",
            status=outcome.status.word,
            time=outcome.end_time,
        )
    return outcome


def _closed(guess: Guess) -> Guess | None:
    """A guess that ends in the mode in which it begins, an event next to the section left out."""
    word, turn = guess
    if word.modes[0] == word.modes[-1]:
        return guess
    found = []
    if word.modes[-2] == word.modes[0]:
        paths = (*word.paths[:-2], ())
        instants = np.delete(turn.instants, -2)
        new = Guess(Word(word.modes[:-1], paths), Turn(turn.states[:-1], instants))
        found.append((float(turn.durations[-1]), new))
    if word.modes[1] == word.modes[-1]:
        instants = np.delete(turn.instants, 1)
        new = Guess(Word(word.modes[1:], word.paths[1:]), Turn(turn.states[1:], instants))
        found.append((float(turn.durations[0]), new))
    return min(found, key=lambda pair: pair[0])[1] if found else None


def _legs_of_outcome(system: System, outcome: Outcome, begin: Instant, end: Instant) -> Guess:
    """Legs of a run between two of its samples, the last two; times count from window zero."""
    window = outcome.window
    rows, after = outcome.events, outcome.event_states[:, 1]
    times = since_strobe(rows["number"], rows["phase"], begin, window)
    # an event at a section comes behind it
    inside = (times >= 0.0) & (times < (end.number - begin.number) * window)
    inside &= ~np.isin(rows["kind"], (EventKind.GRAZE, EventKind.START))
    records = outcome.records
    modes, paths = [int(records.sample_mode[-2])], []
    states = [np.array(records.sample_state[-2])]
    for row, state in zip(rows[inside], after[inside], strict=True):
        path = path_of_bits(int(row["path"]), int(row["passes"]))
        if path is None:
            raise RunError(
                f"{system.name}: more exits are passed at one instant than an orbit can hold",
                status=Status.EVENT_LIMIT.word,
                time=float(row["phase"]),
            )
        paths.append(path)
        modes.append(int(row["to_mode"]))
        states.append(state.copy())
    paths.append(())
    instants = np.concatenate([[0.0], times[inside], [(end.number - begin.number) * window]])
    return Guess(Word(tuple(modes), tuple(paths)), Turn(np.array(states), instants + begin.phase))


def cycle_guesses(
    system: System, initial: Any, *, period: int, transient: int, mode: str | None,
    tolerance: float, most_events: int = _MOST_PASSED,
) -> Iterator[Guess]:  # fmt: skip
    """Legs of a motion from an event to its nearest return, or around a smooth cycle.

    ``transient`` counts windows. Guesses of short cycles come first; none where the motion does not
    come back. A motion that decays slowly while it turns about its cycle is nearest to where it was
    after many turns; the shorter returns of such a motion come last.
    """
    tables = build_tables(system)
    start = resolve_start(system, tables, initial, mode=mode)
    start = start_at_end(start)
    begin = start.instant.number + transient
    open_states = _OpenStates.of(system)
    returns = False
    for stretch in _STRETCHES:
        samples, final = _SAMPLES / stretch, stretch >= 1.0
        plan, step = _plan(tables.window, samples, period, begin, start, transient)
        outcome = _run_for_guess(system, tables, start, plan, tolerance, most_events)
        found = _between_events(system, outcome, begin, open_states, period, final)
        found = found or _around(outcome, open_states, period, step, final)
        returns = returns or bool(found)
        yield from found
        if final and (returns or _rests(outcome, open_states)):
            return


def _plan(
    window: float, samples: float, period: int, begin: int, start: Start, transient: int
) -> tuple[Plan, float]:
    """Samples of so many per window, a power of two, and the time between them.

    Their number is the same, however many there are in a window.
    """
    count = np.arange(_WINDOWS * _SAMPLES * period + 1)
    step = window / samples
    number = begin + np.floor(count / samples).astype(np.int64)
    phase: Floats = np.asarray((count % samples if samples > 1.0 else 0.0 * count) * step)
    if transient == 0:
        phase[0] = max(phase[0], start.instant.phase)
    return Plan(Instant(int(number[-1]), float(phase[-1])), number, phase), step


def _rests(outcome: Outcome, open_states: _OpenStates) -> bool:
    """Whether nothing moves in the second half of a stretch."""
    states = open_states.without_drifts(outcome.records.sample_state)
    late = states[len(states) // 2 :]
    return not np.any(open_states.spread(late) > _STILL * (np.abs(late).max(axis=0) + 1e-12))


class _OpenStates(NamedTuple):
    """The states in which a motion may come back elsewhere: drifts, and angles by whole turns."""

    drifting: npt.NDArray[np.bool_]  # (n,)
    periods: Floats  # (n,): of angles, zero of other states

    @classmethod
    def of(cls, system: System) -> _OpenStates:
        drifting = np.array([name in system.drift_states for name in system.states])
        return cls(drifting, periods_of_states(system))

    def without_drifts(self, states: Floats) -> Floats:
        """States, those that drift being zero."""
        return np.where(self.drifting, 0.0, states)

    def spread(self, states: Floats) -> Floats:
        """Range of each state, of an angle one turn at most, (n,)."""
        found = np.ptp(self.without_drifts(states), axis=0)
        return np.where(self.periods > 0.0, np.minimum(found, self.periods), found)

    def apart(self, states: Floats, first: Floats) -> Floats:
        """How far states are from the first one, drifts and whole turns left out."""
        change = self.without_drifts(states - first)
        return np.asarray(change - whole_turns(change, self.periods))


def _is_resolved(outcome: Outcome, open_states: _OpenStates) -> bool:
    """Whether samples follow the motion, rather than being anywhere on it."""
    states = open_states.without_drifts(outcome.records.sample_state)
    spread = open_states.spread(states)
    if not np.any(spread > 0.0):
        return True
    ways = np.abs(np.diff(states, axis=0)) / np.where(spread > 0.0, spread, 1.0)
    return bool(np.median(ways.max(axis=1)) <= _RESOLVED)


def _between_events(
    system: System, outcome: Outcome, begin: int, open_states: _OpenStates, period: int,
    final: bool,
) -> list[Guess]:  # fmt: skip
    """From an event to returns of the same kind, as `_returns` chooses them."""
    window, rows = outcome.window, outcome.events
    keep = (rows["number"] >= begin) & ~np.isin(rows["kind"], (EventKind.GRAZE, EventKind.START))
    rows, states = rows[keep][:_MOST_EVENTS], outcome.event_states[keep, 1][:_MOST_EVENTS]
    if len(rows) < 2:
        return []
    times = (rows["number"] - begin) * window + rows["phase"]
    kinds = columns(rows, "from_mode", "path", "to_mode")
    same = np.all(kinds == kinds[0], axis=1)
    spread = np.maximum(open_states.spread(outcome.records.sample_state), 1e-12)
    apart = (np.abs(open_states.apart(states, states[0])) / spread).max(axis=1)
    returns = np.flatnonzero(same)[1:]
    found = []
    for turn in returns[_returns(apart[returns], _NEAR, final)].tolist():
        last = min(turn * period, len(rows) - 1)
        paths = [path_of_bits(int(r["path"]), int(r["passes"])) for r in rows[1 : last + 1]]
        if any(path is None for path in paths):
            continue
        modes = tuple(int(m) for m in rows["to_mode"][:last])
        word = Word(modes, tuple(path for path in paths if path is not None))
        found.append(Guess(word, Turn(states[:last].copy(), times[: last + 1] - times[0])))
    return found


def _returns(apart: Floats, limits: tuple[float, ...], final: bool) -> npt.NDArray[np.intp]:
    """Which of some returns to try: the first that is near, by the closest limit that one meets.

    At last the nearest, if none is; and behind that the shorter ones, each of which is nearer than
    all before it.
    """
    chosen = next((k for near in limits for k in np.flatnonzero(apart <= near)[:1]), None)
    if not apart.size or not (final or chosen is not None):
        return np.zeros(0, np.intp)
    # behind an event that wipes out what was before, all returns are as near but for rounding
    nearest = int(np.flatnonzero(apart <= apart.min() + _AS_NEAR)[0])
    first = nearest if chosen is None else int(chosen)
    if not final:
        return np.array([first])
    before = np.minimum.accumulate(np.append(np.inf, apart))[:first]
    return np.append(first, np.flatnonzero(apart[:first] < before))


def _around(
    outcome: Outcome, open_states: _OpenStates, period: int, step: float, final: bool
) -> list[Guess]:
    """Around a cycle without events, from its first sample; to crossings that `_returns` chooses.

    They are those of the plane across the flow at that sample.
    """
    states = open_states.without_drifts(outcome.records.sample_state)
    spread = open_states.spread(states)
    at_rest = not np.any(spread > _STILL * (np.abs(states).max(axis=0) + 1e-12))
    if at_rest or not _is_resolved(outcome, open_states):
        return []
    scaled = open_states.apart(states, states[0]) / np.where(spread > 0.0, spread, 1.0)
    forward = scaled @ (scaled[1] - scaled[0])
    crossings = np.flatnonzero((forward[1:-1] < 0.0) & (forward[2:] >= 0.0)) + 2
    # between samples
    part = forward[crossings] / (forward[crossings] - forward[crossings - 1])
    before, behind = scaled[crossings - 1], scaled[crossings]
    apart = np.abs(behind + part[:, None] * (before - behind)).max(axis=1)
    word = Word((int(outcome.records.sample_mode[0]),), ((),))
    first = outcome.records.sample_state[:1].copy()
    chosen = _returns(apart, _NEAR[-1:], final)
    lengths = (crossings[chosen] - part[chosen]) * step * period
    return [Guess(word, Turn(first, np.array([0.0, length]))) for length in lengths]


def guesses_in_motion(
    system: System, initial: Any, words: list[Word], *, period: int, phase: float, periods: int,
    tolerance: float,
) -> Iterator[Guess]:  # fmt: skip
    """Stretches of a driven motion that follow one of some words, the nearly closed ones first.

    Words count rebounds that accumulate as one; those of the guesses have all that were followed.
    """
    tables = build_tables(system)
    window = tables.window
    start = resolve_start(system, tables, initial)
    if start.anchor is not None:
        return
    first = start.instant.number + (start.instant.phase > phase * window)
    numbers = first + np.arange(periods + 1, dtype=np.int64)
    plan = Plan(
        Instant(int(numbers[-1]), phase * window), numbers, np.full(periods + 1, phase * window)
    )
    try:
        outcome = run_plan(
            tables, plan, tolerance, state=start.state, begin=start.instant, mode=start.modes[0]
        )
    except NoMode:
        return
    rows, after = outcome.unless_interrupted().events, outcome.event_states[:, 1]
    lasting = ~np.isin(rows["kind"], (EventKind.GRAZE, EventKind.START))
    rows, after = rows[lasting], after[lasting]
    times = since_strobe(rows["number"], rows["phase"], Instant(first, phase * window), window)
    states, modes = outcome.records.sample_state, outcome.records.sample_mode
    open_states = _OpenStates.of(system)
    reached = outcome.n_samples
    wiring = system.compiled.program.wiring
    wanted = {(word.modes, word.paths) for word in (each.collapsed(wiring) for each in words)}
    found = []
    for k in range(max(0, reached - period)):
        low, high = np.searchsorted(times, [k * window, (k + period) * window])
        part = slice(int(low), int(high))
        paths = [path_of_bits(int(r["path"]), int(r["passes"])) for r in rows[part]]
        if None in paths:
            continue
        visited = (int(modes[k]), *(int(m) for m in rows["to_mode"][part]))
        word = Word(visited, (*[path for path in paths if path is not None], ()))
        seen = word.collapsed(wiring)
        if (seen.modes, seen.paths) in wanted:
            gap = float(np.abs(open_states.apart(states[k + period], states[k])).max())
            inner = times[part] - k * window
            instants = np.concatenate([[0.0], inner, [period * window]]) + phase * window
            legs = np.vstack([states[k][None], after[part]])
            found.append((gap, Guess(word, Turn(legs, instants))))
    for _, guess in sorted(found, key=lambda pair: pair[0]):
        yield guess


def random_guesses(
    equations: OrbitEquations, length: float, count: int, seed: int
) -> Iterator[Floats]:
    """Unknowns for random durations of the legs: states follow, as far as flows are linear."""
    rng = np.random.default_rng(seed)
    word, n = equations.word, equations.legs.n
    for _ in range(count):
        shares = rng.dirichlet(np.full(len(word), rng.choice([0.4, 1.0, 3.0])))
        span = length if not equations.autonomous else length * rng.uniform(0.2, 3.0)
        begin = equations.phase * equations.legs.window
        instants = begin + span * np.concatenate([[0.0], np.cumsum(shares)])
        states = np.where(equations.drifting, equations.origin, 0.0) + np.zeros((len(word), n))
        unknowns = equations.pack(Turn(states, instants))
        try:
            for _ in range(_SWEEPS):
                residual, jacobian, _ = equations.evaluate(unknowns)
                size = len(word) * n
                step = np.linalg.lstsq(jacobian[:size, :size], -residual[:size], rcond=None)[0]
                unknowns[:size] += step
        except (LegError, np.linalg.LinAlgError):
            continue
        if np.all(np.isfinite(unknowns)):
            yield unknowns


def from_nearest_strobe(equations: OrbitEquations, turn: Turn, wanted: Floats) -> Guess | None:
    """The orbit from its strobe nearest to a state; None where that is the one it is told from.

    Drifts are compared nowhere: they begin anywhere.
    """
    free = ~equations.drifting
    if equations.autonomous or equations.period == 1 or not np.any(free):
        return None
    try:
        strobes = strobes_of(equations, turn).states
    except LegError:
        return None
    scale = np.abs(np.vstack([strobes, turn.states, wanted])[:, free]).max(axis=0)
    away = (strobes - wanted)[:, free] / np.where(scale > 0.0, scale, 1.0)
    distance = np.linalg.norm(away, axis=1)
    nearest = int(np.argmin(distance))
    if not distance[nearest] < _NEARER * distance[0]:
        return None
    return _turned(equations, turn, nearest, strobes[nearest])


def _turned(equations: OrbitEquations, turn: Turn, later: int, strobe: Floats) -> Guess:
    """Legs from a strobe some periods later on.

    The leg in which that lies is cut there. The last leg and the first one, which are parts of one
    stay in a mode, become one.
    """
    word, window = equations.word, equations.legs.window
    cut = turn.instants[0] + later * window
    k = int(np.searchsorted(turn.instants[1:-1], cut, side="right"))
    first, last = slice(k, len(word)), slice(1, k + 1)
    modes = word.modes[first] + word.modes[last]
    paths = (*word.paths[k:-1], *word.paths[:k], ())
    closed = equations.legs.follow(word, turn.states, turn.instants).nexts[-1]
    over = equations.carried(closed - turn.states[0])
    states = np.vstack([strobe, turn.states[k + 1 :], turn.states[last] + over])
    length = equations.period * window
    inner = np.concatenate([turn.instants[k + 1 : -1], turn.instants[1 : k + 1] + length])
    begin, end = turn.instants[0], turn.instants[-1]
    instants = np.concatenate([[begin], inner - later * window, [end]])
    return Guess(Word(modes, paths), Turn(states, instants))
