"""`settle`: the one path from parameter values and a start to what a settled motion leaves behind.

Diagrams, sweeps, regimes and ensembles are reductions of what it records. Motions at several sets
of parameter values are set up, settled and recorded side by side, in one call of the engine.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, partial
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.chain_links import End
from nonsmooth.engine.lanes import SAME
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import FREE, Tables
from nonsmooth.errors import ModelError
from nonsmooth.runs.clock import Instant, instants
from nonsmooth.runs.crew import Stopped
from nonsmooth.runs.start import Start, resolve_start
from nonsmooth.runs.strobe_times import strobes_of_motions
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.runs.sweep_runner import Motions, Recorded, SweepRunner, SweepStarts, Times
from nonsmooth.runs.whole_turns import cuts_of, folded, periods_of_states, whole_turns
from nonsmooth.system.model.value_checks import rests_alike, sure_values
from nonsmooth.system.system import System

__all__ = [
    "Group",
    "ParameterSet",
    "ParameterSets",
    "Reduce",
    "at_time_zero",
    "beside",
    "said_of_start",
    "settle",
]

T = TypeVar("T")
Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


_BESIDE = 1e-8  # of the size of a state: far above rounding, and soon as nothing beside chaos
_SEED = 0  # of the direction in which a point lies beside another one


def beside(states: Floats, sizes: Floats, drifting: Bools) -> Floats:
    """Points a little beside some, in a direction of no symmetry; but for drifts.

    shapes: states (..., n), sizes (..., n), drifting (n,)
    """
    direction = np.random.default_rng(_SEED).uniform(-1.0, 1.0, drifting.size)
    return states + np.where(drifting, 0.0, _BESIDE * direction * sizes)


def at_time_zero(start: Start) -> Start:
    """The start at time zero, in the first of the modes that it may have."""
    return Start(start.state, Instant(0, 0.0), start.modes[:1])


def said_of_start(initial: Any) -> str:
    """An initial state as the protocol tells it."""
    if hasattr(initial, "data_vars"):  # datasets are mappings too
        return "a point of a dataset"
    if initial is None or (isinstance(initial, Mapping) and not initial):
        return "at rest"
    return str(dict(initial)) if isinstance(initial, Mapping) else "a point of a dataset"


class ParameterSet(NamedTuple):
    """Values of all parameters, the time between strobes (None: the period), and the start.

    The start is known, or found with the tables that belong to the values.
    """

    values: dict[str, float]
    length: float | None
    start: Start | Callable[[Tables], Start]


class ParameterSets:
    """Sets of parameter values with a start each, checked together where that says enough.

    ``chosen`` is a map, whose points are the times of the motions; or a system, where the times
    come from elsewhere. ``values`` has K values of each parameter that is varied, or none.
    ``initial`` is what the user gave, or a list with a mapping for each set, of the same states; or
    where values are not varied, a start. ``begins`` makes the start of a motion from the one that
    was asked for; without it that is the start.
    """

    def __init__(
        self,
        chosen: StroboscopicMap | System,
        values: Mapping[str, Floats],
        initial: Any,
        mode: str | None,
        begins: Callable[[Start], Start] | None = None,
    ) -> None:
        self.chosen, self._values = chosen, values
        self.count = next(iter(values.values())).size if values else 1
        self.system = _system_of(chosen)
        self._initial, self._mode, self._begins = initial, mode, begins
        self._known = self.system.parameter_values

    @cached_property
    def _is_named(self) -> bool:
        """Whether the start is given by names of states.

        A point of a dataset has a time too, whose phase depends on the period; a run goes on only
        with the values that it has had.
        """
        initial = self._initial
        return (
            initial is None
            or isinstance(initial, list)
            or (isinstance(initial, Mapping) and not hasattr(initial, "data_vars"))
        )

    @cached_property
    def _sure(self) -> Bools:
        """Which sets the system takes for sure, with the same state at rest."""
        chosen, values = self.chosen, self._values
        if not values:
            return np.ones(1, bool)
        strobes_vary = isinstance(chosen, StroboscopicMap) and isinstance(chosen.period, str)
        if not self._is_named or strobes_vary or not rests_alike(self.system, values):
            return np.zeros(self.count, bool)
        return sure_values(self.system, values)

    @cached_property
    def _known_starts(self) -> list[Start] | None:
        """Starts of sets that are sure; None where a mode completes them, or for points."""
        initial = self._initial
        if isinstance(initial, Start):
            return [initial] * self.count
        given = initial[0] if isinstance(initial, list) else (initial or {})
        left_out = [name for name, value in self.system.open_state.items() if np.isnan(value)]
        if not self._is_named or not set(left_out).issubset(given):
            return None
        first = self._resolved(0, self.system, None)
        if not isinstance(initial, list):
            return [first] * self.count
        states = np.tile(first.state, (self.count, 1))
        for k, name in enumerate(self.system.states):
            if name in given:
                states[:, k] = [each[name] for each in initial]
        return [Start(state, first.instant, first.modes) for state in states]

    @property
    def varied(self) -> list[str]:
        """Names of the parameters that are varied."""
        return list(self._values)

    def one(self, i: int) -> ParameterSet:
        """Set i; `ModelError` where the system refuses its values."""
        changed = {name: float(each[i]) for name, each in self._values.items()}
        if not self._sure[i]:
            chosen = self.chosen.with_parameters(**changed)
            system = _system_of(chosen)
            return ParameterSet(
                system.parameter_values, _length_of(chosen), partial(self._resolved, i, system)
            )
        known = self._known_starts
        start = partial(self._resolved, i, self.system) if known is None else known[i]
        return ParameterSet(self._known | changed, self._length, start)

    @cached_property
    def _length(self) -> float | None:
        return _length_of(self.chosen)

    def _resolved(self, i: int, system: System, tables: Any) -> Start:
        initial = self._initial[i] if isinstance(self._initial, list) else self._initial
        found = resolve_start(system, tables, initial, None, self._mode, repeated=True)
        return found if self._begins is None else self._begins(found)


def _system_of(chosen: StroboscopicMap | System) -> System:
    return chosen if isinstance(chosen, System) else chosen.system


def _length_of(chosen: StroboscopicMap | System) -> float | None:
    """Time between strobes, None where that is the period or where there are none."""
    return None if isinstance(chosen, System) else chosen.length


class Group:
    """Motions at some parameter sets, side by side on their way; one that is refused has no start.

    ``left`` is where the last motion has come to, as a state and a mode: the start of a motion that
    follows. It is None where the motion has ended early.
    """

    def __init__(
        self,
        runner: SweepRunner,
        all_sets: ParameterSets,
        numbers: Sequence[int],
        stop: threading.Event,
    ) -> None:
        self.runner, self.stop = runner, stop
        self.system, self.varied = all_sets.system, all_sets.varied
        self._chosen = all_sets.chosen
        self.numbers, self.count = numbers, len(numbers)
        sets = [_unless_refused(all_sets, i) for i in numbers]
        own = list(self.system.parameter_values.values())
        rows = [own if each is None else list(each.values.values()) for each in sets]
        self.values = np.array(rows)  # (K, p), of all parameters
        self.usable = runner.set_up(self.values)
        self.usable &= np.array([each is not None for each in sets])
        self.windows = runner.windows
        self.periods = [None if each is None else each.length for each in sets]
        self.drifting = np.array([name in self.system.drift_states for name in self.system.states])
        self.angle_periods = periods_of_states(self.system)  # (n,): zero of what is no angle
        self.starts: list[Start | None] = [None] * self.count
        for i in np.flatnonzero(self.usable).tolist():
            each = sets[i]
            assert each is not None
            start = each.start
            self.starts[i] = start(runner.tables(i)) if callable(start) else start
        self.motions = runner.start(self._as_arrays(), self.usable)
        self._left: End | None = None
        self._is_left = False

    def follow(self, behind: End | None) -> None:
        """Let the first motion begin where another one has been left.

        States that drift begin at their initial value everywhere.
        """
        start = self.starts[0]
        if behind is None or start is None:
            return
        times = self.strobes(0, 1)
        begin = Instant(int(times.numbers[0, 0]), float(times.phases[0, 0]))
        state = np.where(self.drifting, start.state, behind.state)
        self.starts[0] = Start(state, begin, (SAME - behind.mode,))
        self.motions = self.runner.start(self._as_arrays(), self.usable)

    def choose_modes(self) -> None:
        """Begin in the first mode that admits each start, where it may be one of several."""
        starts = [start for start in self.starts if start is not None]
        most = max((len(start.modes) for start in starts), default=1)
        if most == 1:
            return
        self.motions = self._begun(self._as_arrays(), self.usable)
        for k in range(1, most):
            misfit = self.is_misfit
            if not np.any(misfit):
                return
            self._take(self._begun(self._as_arrays(k), misfit), misfit)

    def go_beside(self, chosen: Bools, sizes: Floats) -> None:
        """Let the chosen motions go on from points a little beside those where they are.

        Machines in step that would part by themselves never do so in arithmetic that gives them the
        same digits. What is chaotic forgets so small a change at once. A motion stays where it is
        where it slides or rests, or where its mode does not take the other point.

        shapes: chosen (K,); sizes (K, n) of the states
        """
        place, since = self.motions.places, self.motions.since
        kinds = self.system.compiled.program.wiring.modes["kind"]
        chosen = chosen & (kinds[place["mode"]] == FREE)
        states = beside(self.motions.end_states, sizes, self.drifting)
        numbers = np.where(chosen, since["number"], 0.0).astype(np.int64)
        phases = np.where(chosen, since["phase"], 0.0)
        starts = SweepStarts(states, place["mode"].copy(), numbers, phases)
        begun = self._begun(starts, chosen)
        self._take(begun, chosen & (begun.statuses == Status.COMPLETED))

    def _begun(self, starts: SweepStarts, chosen: Bools) -> Motions:
        """Some motions at other starts, what happens there being behind them."""
        begun = self.runner.start(starts, chosen)
        here = Times(starts.numbers[:, None].copy(), starts.phases[:, None].copy())
        self.runner.run(begun, here, log=False, stop=self.stop)
        return begun

    def _take(self, others: Motions, chosen: Bools) -> None:
        """Take some of other motions in the place of these; what was counted of these stays."""
        own = self.motions
        for name in own.anchors.in_lanes:
            getattr(own.anchors, name)[chosen] = getattr(others.anchors, name)[chosen]
        for name in ("modes", "statuses", "end_states", "since", "counters"):
            getattr(own, name)[chosen] = getattr(others, name)[chosen]
        for name in ("uncertain", "estimated"):
            getattr(own, name)[chosen] += getattr(others, name)[chosen]

    @property
    def chosen(self) -> StroboscopicMap:
        """The map whose strobes are the times of the motions."""
        assert isinstance(self._chosen, StroboscopicMap)
        return self._chosen

    @property
    def is_misfit(self) -> Bools:
        """Whether the start of each motion lies in no mode, rather than an end that was reached."""
        motions = self.motions
        ended = self.usable & (motions.statuses != Status.COMPLETED)
        return np.asarray(ended & (motions.places["mode"] < 0))

    @property
    def left(self) -> End | None:
        """Where a motion begins that follows the last one."""
        if self._is_left:
            return self._left
        if self.motions.statuses[-1] != Status.COMPLETED:
            return None
        state = self.motions.end_states[-1]
        state = state - whole_turns(state, self.angle_periods)  # it would grow from link to link
        return End(state, int(self.motions.places["mode"][-1]))

    def leave(self, end: End | None) -> None:
        """Say where the last motion is left, if that is not where it has come to."""
        self._left, self._is_left = end, True

    def values_of(self, parameter: str) -> Floats:
        """Values of a parameter, (K,)."""
        return np.asarray(self.values[:, list(self.system.parameters).index(parameter)])

    @cached_property
    def lengths(self) -> Floats:
        """Time between strobes of each motion, (K,)."""
        return np.where(np.isnan(self._periods), self.windows, self._periods)

    @cached_property
    def _periods(self) -> Floats:
        """Time between strobes where it is asked for, nan where that is the period, (K,)."""
        return np.array([np.nan if period is None else period for period in self.periods])

    def length(self, i: int) -> float:
        """Time between strobes of motion i."""
        return float(self.lengths[i])

    def strobes(self, first: int | Integers, count: int, chosen: Any = None) -> Times:
        """Strobes first ... first + count - 1 of each motion, or of those that are chosen, (K,)."""
        numbers, phases = np.zeros((self.count, count), np.int64), np.zeros((self.count, count))
        which = np.arange(self.count) if chosen is None else np.flatnonzero(chosen)
        begun, since = self._begins()
        numbers[which], phases[which] = strobes_of_motions(
            self.windows[which], (begun[which], since[which]), self._periods[which],
            self.chosen.phase, np.broadcast_to(first, self.count)[which], count,
        )  # fmt: skip
        return Times(numbers, phases)

    def instants(self, times: Floats, chosen: Bools) -> tuple[Integers, Floats]:
        """Windows and phases of some times of the chosen motions, (K, s) each; zero for others."""
        numbers, phases = np.zeros(times.shape, np.int64), np.zeros(times.shape)
        numbers[chosen], phases[chosen] = instants(times[chosen], self.windows[chosen, None])
        return numbers, phases

    def iterates(self, first: int, count: int) -> Times:
        """Iterates first ... first + count - 1 of the map, for each motion."""
        every = self.chosen.every
        return self.strobes(first * every, (count - 1) * every + 1).at(slice(None, None, every))

    def run(
        self, times: Times, *, chosen: Bools | None = None, ends: Times | None = None,
        log: bool = True,
    ) -> Recorded:  # fmt: skip
        """Run motions on through some times, those that are chosen."""
        found = self.runner.run(
            self.motions, times, chosen=chosen, ends=ends, log=log, stop=self.stop
        )
        return self.fold(found)

    def fold(self, found: Recorded) -> Recorded:
        """What motions left behind, with angles within one turn.

        So points that are whole turns apart are one point to whoever compares them.
        """
        if not np.any(self.angle_periods):
            return found
        cuts = cuts_of(found.states, self.angle_periods)
        at_events = np.repeat(cuts, np.diff(found.logs), axis=0)[:, None]
        return found._replace(
            states=folded(found.states, cuts[:, None], self.angle_periods),
            event_states=folded(found.event_states, at_events, self.angle_periods),
        )

    def _begins(self) -> tuple[Integers, Floats]:
        """Windows and phases at which motions begin."""
        instants = [Instant(0, 0.0) if one is None else one.instant for one in self.starts]
        numbers = np.array([each.number for each in instants], np.int64)
        return numbers, np.array([each.phase for each in instants], float)

    def _as_arrays(self, k: int = 0) -> SweepStarts:
        """Starts, each in the mode number ``k`` of those that it may have."""
        states = np.zeros((self.count, self.drifting.size))
        modes = np.zeros(self.count, np.int64)
        for i, start in enumerate(self.starts):
            if start is not None:
                states[i], modes[i] = start.state, start.modes[min(k, len(start.modes) - 1)]
        return SweepStarts(states, modes, *self._begins())


Reduce: TypeAlias = Callable[[Group, Recorded], list[T]]


def settle(
    runner: SweepRunner,
    stop: threading.Event,
    *,
    sets: ParameterSets,
    which: Sequence[int] | None = None,
    times: Callable[[Group], Times],
    reduce: Reduce[T],
    follow: Callable[[], End | None] | None = None,
    alone: bool = False,
    log: bool = True,
) -> tuple[list[T], End | None]:
    """What ``reduce`` makes of a motion at each set of values, and where the last one was left.

    Of all sets those are taken that ``which`` numbers, in this order; without it each of them.
    Each motion runs to the first of its ``times`` without a log of events, and on to the last one
    with it, unless no ``log`` is wanted. Some run side by side; ``reduce`` is given these and may
    run them further. With ``follow`` a motion begins where the one before was left, and the first
    one where ``follow()`` says. After values at which the motion has ended early, or that the
    system refuses, it begins anew. Motions that follow others which ``reduce`` runs further go
    ``alone``.
    """
    found: list[T] = []
    end = None if follow is None else follow()
    size = 1 if alone else runner.most
    numbers = range(sets.count) if which is None else which
    for first in range(0, len(numbers), size):
        group = Group(runner, sets, numbers[first : first + size], stop)
        if follow is not None:
            group.follow(end)
        group.choose_modes()
        recorded = runner.run(
            group.motions,
            times(group),
            follows=None if follow is None else group.strobes(0, 1),
            log=log,
            stop=stop,
        )
        try:
            found += reduce(group, group.fold(recorded))
        except Stopped as stopped:
            raise Stopped(([*found, *(stopped.done or ())], None)) from None
        end = group.left
    return found, end if follow is not None else None


def _unless_refused(sets: ParameterSets, i: int) -> ParameterSet | None:
    try:
        return sets.one(i)
    except ModelError:
        return None
