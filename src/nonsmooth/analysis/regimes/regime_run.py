"""Motions followed side by side until each has given its label twice, and the evidence for it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.chain_links import End
from nonsmooth.analysis.exponents.neighbours import (
    Neighbours,
    OrbitTangent,
    is_forgetful,
    orbit_multipliers,
    strobe_growth,
)
from nonsmooth.analysis.regimes import labels
from nonsmooth.analysis.regimes.labels import Verdict
from nonsmooth.analysis.regimes.options import RegimeProtocol
from nonsmooth.analysis.regimes.window import (
    StrobeTest,
    Windows,
    cyclic_word,
    no_closed_orbit,
    runs_away,
    strobe_test,
    travels,
    window_times,
)
from nonsmooth.analysis.settle import Group
from nonsmooth.analysis.statistics.block_averages import block_averages
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import Tables
from nonsmooth.runs.clock import Instant, instants
from nonsmooth.runs.crew import Stopped
from nonsmooth.runs.runner import Derivatives, build_derivatives
from nonsmooth.runs.strobe_times import hides_phase, is_driven
from nonsmooth.runs.sweep_runner import Recorded, Times
from nonsmooth.runs.tangent_flow import TangentFlow
from nonsmooth.system.columns import with_error

__all__ = ["first_windows", "settled_regimes"]

_CLOSING = 0.5  # of the residual of a window is left in the next one while a motion settles
_ROUNDING = 1e-9  # of a multiplier
_GOLDEN = 0.5 * (5.0**0.5 - 1.0)  # its multiples fall evenly into an interval, whatever the motion
_ELSEWHERE = (0.0, 0.382, 0.764)  # parts of a period at which derivatives may begin

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def first_windows(protocol: RegimeProtocol, group: Group) -> Times:
    """Times at which motions are recorded first: two windows of strobes after the transient."""
    return window_times(group, protocol.record, protocol.transient, group.usable)


def settled_regimes(protocol: RegimeProtocol, group: Group, recorded: Recorded) -> list[Verdict]:
    """Regime of each motion of a group, whose first windows were recorded.

    The transient is doubled until one window of strobes gives the label that the window before has
    given. Chaos may be one more transient, so chaotic motions are run on. What is next is done for
    all motions together that need it. Where the work is stopped, verdicts that stand are handed
    out.
    """
    motions = _Motions(protocol, group)
    going, chaotic = group.usable.copy(), np.zeros(group.count, bool)
    first = np.full(group.count, protocol.transient)
    found: Recorded | None = recorded
    try:
        while np.any(going):
            following = 2 * np.maximum(first, protocol.record)
            motions.look(going, first, following > protocol.longest, found)
            found = None
            following = np.maximum(following, motions.reached)
            has = np.array([verdict.label for verdict in motions.verdicts])
            chaotic |= going & (has == labels.CHAOTIC)
            going &= (has == labels.UNSETTLED) & (following <= protocol.longest)
            first = following
        if protocol.confirm and np.any(chaotic):
            motions.run_on(chaotic)
    except Stopped:
        open_yet = going | (chaotic if protocol.confirm else False)
        verdicts = zip(motions.verdicts, open_yet.tolist(), strict=True)
        raise Stopped([None if is_open else verdict for verdict, is_open in verdicts]) from None
    last = motions.verdicts[-1].last
    group.leave(None if last is None else End(*last))
    return motions.verdicts


class _Motions:
    """Motions on their way, and what is seen of them; M motions."""

    def __init__(self, protocol: RegimeProtocol, group: Group) -> None:
        self.protocol, self.group, self.system = protocol, group, group.system
        self.drifting = group.drifting
        self.autonomous = not is_driven(group.runner.tables(0))
        nothing = np.full(self.drifting.size, np.nan)
        self.first_states = np.array(
            [nothing if start is None else start.state for start in group.starts]
        )
        self.sizes = np.abs(self.first_states)  # (M, n) of the states since the start
        self.reached = np.zeros(group.count, np.int64)  # strobes passed
        self.verdicts = [Verdict(Status.REFUSED.word, "", 0, np.nan, nothing)] * group.count
        self._known: dict[int, tuple[Tables, Derivatives]] = {}
        self._flow: TangentFlow | None = None

    def look(
        self, chosen: Bools, first: Integers, is_last: Bools, recorded: Recorded | None
    ) -> None:
        """Verdicts on the two windows after so many strobes of the chosen motions."""
        windows, alive = self._windows(chosen, first, recorded)
        if windows is None:
            return
        both = self._returns(windows, alive)
        seen = self._seen(windows, alive, first, both)
        (before, now), (rest_before, rest_now) = (each.T for each in both)
        same = alive & (before == now)
        for i in np.flatnonzero(alive & ~same).tolist():
            self.verdicts[i] = seen[i].unsettled(
                f"one window has the period {before[i]}, the next {now[i]}"
            )
        on_the_way = self._on_the_way(windows, same & (now > 1))
        for i in np.flatnonzero(on_the_way).tolist():
            self.verdicts[i] = replace(seen[i], period=0, word="").unsettled(
                f"strobes repeat with period {now[i]}, but are no farther apart than the way that"
                " is left: the motion may settle to a shorter period"
            )
        self._repeating(windows, seen, same & (now > 0) & ~on_the_way)
        with np.errstate(invalid="ignore"):
            closing = same & (now == 0) & ~is_last & (rest_now < _CLOSING * rest_before)
        for i in np.flatnonzero(closing).tolist():
            self.verdicts[i] = seen[i].unsettled(
                "strobes come closer to each other from window to window"
            )
        self._not_repeating(windows, seen, same & (now == 0) & ~closing)

    def run_on(self, chosen: Bools) -> None:
        """Verdicts on chaotic motions that are followed further: they may settle, or end."""
        first = self.reached + self.protocol.confirm
        windows, alive = self._windows(chosen, first, None)
        if windows is None:
            return
        both = self._returns(windows, alive)
        periods = both[0]
        repeats = alive & (periods[:, 0] == periods[:, 1]) & (periods[:, 1] > 0)
        for i in np.flatnonzero(alive & ~repeats).tolist():
            chaotic = self.verdicts[i]
            self.verdicts[i] = replace(
                chaotic,
                reason=f"{chaotic.reason}; it has not settled within {self.reached[i]} periods",
            )
        self._repeating(windows, self._seen(windows, alive, first, both), repeats)

    def _windows(
        self, chosen: Bools, first: Integers, recorded: Recorded | None
    ) -> tuple[Windows | None, Bools]:
        """The two windows after so many strobes, and which of the motions have come to their end.

        The others get their verdicts; where none is left there are no windows.
        """
        group, record = self.group, self.protocol.record
        if recorded is None:
            recorded = group.run(window_times(group, record, first, chosen), chosen=chosen)
        alive = self._still_going(chosen, first)
        if not np.any(alive):
            return None, alive
        self.reached[alive] = first[alive] + 2 * record
        largest = np.abs(recorded.states[alive]).max(axis=1)
        self.sizes[alive] = np.maximum(self.sizes[alive], largest)
        return Windows.of(group, recorded), alive

    def _still_going(self, chosen: Bools, first: Integers) -> Bools:
        """Which of the chosen motions have not ended; the others get their verdicts."""
        going = chosen & (self.group.motions.statuses == Status.COMPLETED)
        for i in np.flatnonzero(chosen & ~going).tolist():
            self.verdicts[i] = self._ended(i, int(first[i]))
        return going

    def _returns(self, windows: Windows, alive: Bools) -> tuple[Integers, Floats]:
        """Period and residual of each window of the motions that are alive, (M, 2) each."""
        periods, residuals = np.zeros((alive.size, 2), np.int64), np.full((alive.size, 2), np.nan)
        which = np.flatnonzero(alive)
        periods[which], residuals[which] = windows.returns(
            which, self.drifting, self.sizes[which], self.protocol.match
        )
        return periods, residuals

    def _on_the_way(self, windows: Windows, repeats: Bools) -> Bools:
        """Which of the motions that repeat may yet settle to a shorter period, (M,)."""
        found = np.zeros(repeats.size, bool)
        which = np.flatnonzero(repeats)
        found[which] = windows.on_the_way(
            which, self.drifting, self.sizes[which], self.protocol.match
        )
        return found

    def _seen(
        self, windows: Windows, alive: Bools, first: Integers, both: tuple[Integers, Floats]
    ) -> dict[int, Verdict]:
        """What strobes and events alone tell of each motion that is alive."""
        period, residual = (each[:, 1] for each in both)
        last = np.full(alive.size, 2 * windows.record)
        count = np.where(period > 0, period, last)
        within = windows.events.between(last - count, last)
        events, impacts = windows.events.counts(within)
        words = windows.events.words(last - count, within, alive & (period > 0))
        motions = self.group.motions
        seen = {}
        for i in np.flatnonzero(alive).tolist():
            points = windows.points[i]
            drift = (points[-1] - points[-1 - count[i]]) / count[i]
            seen[i] = Verdict(
                label=labels.UNSETTLED,
                reason="",
                transient_used=int(first[i]),
                length=self.group.length(i),
                drift=drift,
                period=int(period[i]),
                word=words[i],
                events=float(events[i] / count[i]),
                impacts=float(impacts[i] / count[i]),
                residual=float(residual[i]),
                uncertain=int(motions.uncertain[i]),
                estimated=int(motions.estimated[i]),
                progresses=self._progresses(i, drift),
                last=(points[-1], int(windows.modes[i, -1])),
            )
        return seen

    def _progresses(self, i: int, drift: Floats) -> int:
        """Whether a state drifts by more than ``match`` of the size of the other states."""
        size = float(self.sizes[i, ~self.drifting].max(initial=0.0))
        return int(np.any(np.abs(drift[self.drifting]) > self.protocol.match * size))

    def _repeating(self, windows: Windows, seen: dict[int, Verdict], chosen: Bools) -> None:
        """Multipliers decide whether motions that repeat are some to settle to."""
        if not np.any(chosen):
            return
        periods = np.array([seen[i].period if chosen[i] else 1 for i in range(chosen.size)])
        # as many whole periods earlier as lead into the window before
        earlier = 2 * windows.record - periods * -(-windows.record // periods)
        within = windows.events.between(earlier - periods, earlier)
        words = windows.events.words(earlier - periods, within, chosen)
        for i in np.flatnonzero(chosen).tolist():
            if cyclic_word(words[i]) != cyclic_word(seen[i].word):
                self.verdicts[i] = seen[i].unsettled("the words of two periods differ")
            else:
                self.verdicts[i] = self._by_multipliers(windows, i, seen[i])

    def _by_multipliers(self, windows: Windows, i: int, seen: Verdict) -> Verdict:
        """Label of a motion that repeats, by its multipliers."""
        p = seen.period
        self.reached[i] += 2  # what follows looks into the next two intervals
        steady = p == 1 and seen.events == 0 and self._rests(windows, i)
        # along a motion in which drifts alone change no other direction is neutral
        found = self._multipliers(windows, i, p, self.autonomous and not steady)
        if self._has_ended(i):
            return self._ended(i, int(self.reached[i]))
        if found is None:
            return seen.unsettled("the derivatives over a period are not known, as at a graze")
        orbit, multipliers = found
        duration = p * self.group.length(i)
        modulus = float(np.abs(multipliers).max(initial=0.0))
        with np.errstate(divide="ignore"):  # all multipliers are zero
            exponent = float(np.log(modulus)) / duration if multipliers.size else np.nan
        known: dict[str, Any] = {"multipliers": multipliers, "exponent": exponent}
        seen = replace(seen, **known)
        if modulus > 1.0 - _ROUNDING:
            return seen.unsettled(
                f"strobes repeat, but the largest multiplier has the modulus {modulus:.9g}, which"
                " does not lie inside the unit circle"
            )
        told = f"strobes repeat to {seen.residual:.2g}" + (
            f"; largest multiplier {modulus:.3g}" if multipliers.size else ""
        )
        if steady and self._drifts_rest(windows, i):
            return _named(seen, labels.EQUILIBRIUM, f"nothing changes; {told}")
        if steady:
            which = ", ".join(self.system.drift_states)
            return _named(seen, labels.PERIODIC, f"travels in {which}, and nothing else; {told}")
        if is_forgetful(orbit, multipliers, self.drifting):
            lost: dict[str, Any] = {"multipliers": np.zeros_like(multipliers), "exponent": -np.inf}
            seen = replace(seen, **lost)
            return _named(seen, labels.LOCKED, "every perturbation is lost within a period")
        return _named(seen, labels.PERIODIC, told)

    def _rests(self, windows: Windows, i: int) -> bool:
        """Whether the states between strobes are those at strobes, but for drifts."""
        here, match = windows.points[i, -1], self.protocol.match
        away = np.abs(windows.between[i] - here).max(axis=0)
        close = away <= match * np.maximum(np.abs(here), match * self.sizes[i])
        same_mode = np.all(windows.modes_between[i] == windows.modes[i, -1])
        return bool(np.all(close | self.drifting) and same_mode)

    def _drifts_rest(self, windows: Windows, i: int) -> bool:
        """Whether drifts have come to rest: hardly a step is left of the way since the start."""
        here, before = windows.points[i, -1], windows.points[i, -2]
        way = np.abs(here - self.first_states[i]) * self.protocol.match
        rounding = 16.0 * np.finfo(float).eps * np.abs(here)
        step = np.maximum(np.abs(windows.between[i] - here).max(axis=0), np.abs(here - before))
        return bool(np.all((step <= way + rounding)[self.drifting]))

    def _multipliers(
        self, windows: Windows, i: int, p: int, autonomous: bool
    ) -> tuple[OrbitTangent, npt.NDArray[np.complex128]] | None:
        """Multipliers and the point at which their period begins.

        At a strobe, or elsewhere: a strobe may lie on a guard. The motion is carried on to there.
        """
        tolerance = self.group.runner.tolerance
        if self._flow is None:
            self._flow = TangentFlow(*self._tables_of(i), self.drifting.size, tolerance)
        state, mode, end = windows.points[i, -1], int(windows.modes[i, -1]), windows.end(i)
        for part in _ELSEWHERE:
            begin = self._after(i, end, 1.0 + part) if part else end
            if part:
                state, mode = self._state_at(i, begin)
                if self._has_ended(i):
                    return None
            orbit = OrbitTangent(
                *self._tables_of(i), tolerance, state, mode, begin, self._after(i, begin, p),
                self._flow,
            )  # fmt: skip
            found = orbit_multipliers(orbit, self.drifting, autonomous)
            if found is not None:
                return orbit, found
        return None

    def _state_at(self, i: int, instant: Instant) -> tuple[Floats, int]:
        """State and mode of a motion that runs on to an instant."""
        count = self.group.count
        times = Times(np.full((count, 1), instant.number), np.full((count, 1), instant.phase))
        found = self.group.run(times, chosen=np.arange(count) == i, log=False)
        return found.states[i, 0], int(found.modes[i, 0])

    def _tables_of(self, i: int) -> tuple[Tables, Derivatives]:
        """Tables of a motion, and what derivatives by its initial state need."""
        if i not in self._known:
            values = dict(zip(self.system.parameters, self.group.values[i].tolist(), strict=True))
            tables = self.group.runner.tables(i)
            self._known[i] = tables, build_derivatives(self.system, tables, (), values)
        return self._known[i]

    def _not_repeating(self, windows: Windows, seen: dict[int, Verdict], chosen: Bools) -> None:
        """Exponent and 0-1 test of two windows decide on motions that do not repeat."""
        if not np.any(chosen):
            return
        group, turn, count = self.group, self.protocol.record, self.protocol.evidence
        times = group.strobes(self.reached, turn + 2 * count + 1, chosen)
        looked = self._looks(times, turn, chosen) if self.autonomous else times
        states = group.run(looked.at(slice(1, None)), chosen=chosen, log=False).states
        going = self._still_going(chosen, self.reached)
        self.reached[going] += turn + 2 * count
        for i in np.flatnonzero(going).tolist():
            neighbours = Neighbours(
                *self._tables_of(i), group.runner.tolerance, windows.points[i, -1],
                int(windows.modes[i, -1]), times.numbers[i], times.phases[i], turn,
                self.drifting, group.stop,
            )  # fmt: skip
            self.verdicts[i] = self._by_neighbours(i, seen[i], neighbours, states[i])

    def _by_neighbours(
        self, i: int, seen: Verdict, neighbours: Neighbours, states: Floats
    ) -> Verdict:
        """Label of a motion that does not repeat, from how its neighbours part from it."""
        status, growth = strobe_growth(neighbours)
        if status != Status.COMPLETED:
            return _named(seen, labels.label_of_end(status), f"ended early: {status.word}")
        if growth.size == 0:
            return seen.unsettled("no mode takes the last strobe as a start of derivatives")
        evidence = states[neighbours.turn - 1 :]
        if not self.autonomous:
            return self._by_growth(i, seen, growth, evidence, evidence[1:])
        return self._by_growth(i, seen, growth, evidence[::2], evidence[1::2])

    def _looks(self, times: Times, turn: int, chosen: Bools) -> Times:
        """Strobes, and behind the turn one more look within every interval, ever elsewhere in it.

        Strobes alone may creep along a cycle that has nearly their period.
        """
        first = np.arange(turn, times.numbers.shape[1] - 1)
        parts = (1.0 + np.arange(first.size)) * _GOLDEN % 1.0
        more = np.zeros((self.group.count, first.size), np.int64)
        inside = np.zeros(more.shape)
        for i in np.flatnonzero(chosen).tolist():
            since = times.phases[i, first] + parts * self.group.length(i)
            more[i], inside[i] = instants(since, float(self.group.windows[i]))
        return Times(
            np.insert(times.numbers, first + 1, times.numbers[:, first] + more, axis=1),
            np.insert(times.phases, first + 1, inside, axis=1),
        )

    def _by_growth(
        self, i: int, seen: Verdict, growth: Floats, states: Floats, looks: Floats
    ) -> Verdict:
        """Label by the growth in each interval, the states at the strobes, and one in each."""
        count, length = self.protocol.evidence, self.group.length(i)
        windows = [_mean_rate(part, length) for part in (growth[:count], growth[count:])]
        (first, first_error), (second, second_error) = windows
        label = labels.label_of_growth(
            (first, second), (first_error, second_error), count * length, self._attracting(i)
        )
        exponent, error = _mean_rate(growth, length)
        seen = replace(seen, exponent=exponent, error=error)
        told = f"exponent {with_error(exponent, error, 3, 2)}"
        if self.autonomous and np.count_nonzero(~self.drifting) < 2:
            seen, told = replace(seen, exponent=np.nan), "one state, and no direction across it"
        elif label == labels.LIMIT_CYCLE and not np.isfinite(error):
            told = "no perturbation across the cycle outlives its events"
        why = self._unbounded(i, label, seen, looks)
        if why:
            return seen.unsettled(f"strobes do not repeat, and {why}")
        if not label:
            return seen.unsettled(
                f"strobes do not repeat, and exponents of two windows, {first:.3g} and"
                f" {second:.3g}, decide nothing; their errors are {first_error:.2g} and"
                f" {second_error:.2g}"
            )
        test, contradiction = _agreeing_test(label, self._series(states), self.protocol)
        seen = replace(seen, k=test.k)
        if contradiction:
            return seen.unsettled(f"{told} is {label}, but {contradiction}")
        tested = "without the 0-1 test" if self.protocol.is_survey else f"K = {test.k:.2f}"
        return _named(seen, label, f"{told}, {tested}")

    def _attracting(self, i: int) -> str:
        """Label of a motion that others approach although its strobes do not repeat.

        Such a motion has a direction without growth; "" where there is none.
        """
        if self.autonomous:
            return labels.LIMIT_CYCLE
        hidden = hides_phase(self.group.runner.tables(i), self.group.length(i))
        return labels.QUASI_PERIODIC if hidden else ""

    def _unbounded(self, i: int, label: str, seen: Verdict, looks: Floats) -> str:
        """Why two windows of states contradict a label, "" where they do not."""
        moving = looks[:, ~self.drifting]
        if moving.shape[1] == 0:
            return ""
        earlier, later = np.array_split(moving, 2)
        if label == labels.CHAOTIC:
            return runs_away(earlier, later)
        names = tuple(name for name in self.system.states if name not in self.system.drift_states)
        if label == labels.QUASI_PERIODIC and self.autonomous:
            return travels(earlier, later, names)
        if label != labels.LIMIT_CYCLE:
            return ""
        return no_closed_orbit(
            earlier, later, names, self.sizes[i, ~self.drifting], seen.events > 0,
            self.protocol.match,
        )  # fmt: skip

    def _series(self, states: Floats) -> Floats:
        """Numbers for the 0-1 test: the states without drift, or else the steps of drifts."""
        moving = states[1:, ~self.drifting]
        return moving if moving.shape[1] else np.diff(states, axis=0)

    def _after(self, i: int, begin: Instant, intervals: float) -> Instant:
        """Instant some strobe intervals later; of whole periods without rounding."""
        group = self.group
        if group.periods[i] is None and intervals == int(intervals):
            return Instant(begin.number + int(intervals), begin.phase)
        window = float(group.windows[i])
        number, phase = instants([begin.phase + intervals * group.length(i)], window)
        return Instant(begin.number + int(number[0]), float(phase[0]))

    def _has_ended(self, i: int) -> bool:
        return int(self.group.motions.statuses[i]) != Status.COMPLETED

    def _ended(self, i: int, first: int) -> Verdict:
        """A motion that did not go on."""
        group, motions = self.group, self.group.motions
        start, window = group.starts[i], float(group.windows[i])
        assert start is not None
        status = Status(int(motions.statuses[i]))
        place = Instant(int(motions.places["number"][i]), float(motions.places["phase"][i]))
        passed = (place.time(window) - start.instant.time(window)) / group.length(i)
        misfit = bool(group.is_misfit[i])
        return Verdict(
            label=labels.label_of_end(status),
            reason="the start fits no mode" if misfit else f"ended early: {status.word}",
            transient_used=max(0, min(first, int(passed))),
            length=group.length(i),
            drift=np.full(self.drifting.size, np.nan),
            uncertain=int(motions.uncertain[i]),
            estimated=int(motions.estimated[i]),
        )


def _named(seen: Verdict, label: str, reason: str) -> Verdict:
    return replace(seen, label=label, reason=reason)


def _mean_rate(growth: Floats, length: float) -> tuple[float, float]:
    """Mean growth per unit time with its standard error; nan for a column that is lost."""
    if not np.all(np.isfinite(growth)):
        return -np.inf, np.nan
    error = float(block_averages(growth[:, None]).standard_error[0])
    return float(growth.mean()) / length, error / length


def _agreeing_test(label: str, series: Floats, protocol: RegimeProtocol) -> tuple[StrobeTest, str]:
    """Test of the first state that does not contradict a label, or of the last one, and why.

    Short series mislead where a state hardly moves, or jumps, and others do not. In a survey K is
    not known.
    """
    test, contradiction = StrobeTest(np.nan, np.nan), ""
    for values in series.T:
        test = strobe_test(values)
        if protocol.is_survey:
            test = test._replace(k=np.nan)
        contradiction = labels.contradiction(label, test.k, test.nearest)
        if not contradiction:
            break
    return test, contradiction
