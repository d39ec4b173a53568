"""One motion followed until its label comes out twice, and the evidence for it."""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.exponents.orbit_multipliers import (
    OrbitTangent,
    is_forgetful,
    orbit_multipliers,
)
from nonsmooth.analysis.exponents.strobe_growth import (
    Neighbours,
    strobe_growth,
)
from nonsmooth.analysis.regimes import labels
from nonsmooth.analysis.regimes.recurrence import no_closed_orbit, runs_away, travels
from nonsmooth.analysis.regimes.strobe_test import StrobeTest, strobe_test
from nonsmooth.analysis.regimes.verdict import Protocol, Verdict
from nonsmooth.analysis.regimes.window import Windows, cyclic_word
from nonsmooth.analysis.statistics.block_averages import block_averages
from nonsmooth.engine.status import Status
from nonsmooth.runs.clock import Instant, instants
from nonsmooth.runs.lane_runner import LaneRunner
from nonsmooth.runs.runner import build_derivatives
from nonsmooth.runs.start import Start
from nonsmooth.runs.strobe_times import hides_phase, is_driven, strobes
from nonsmooth.system.system import System

__all__ = ["settled_regime"]

_CLOSING = 0.5  # of the residual of a window is left in the next one while a motion settles
_ROUNDING = 1e-9  # of a multiplier
_BETWEEN = (0.25, 0.5, 0.75)  # parts of a period at which a motion is looked at once more
_GOLDEN = 0.5 * (5.0**0.5 - 1.0)  # its multiples fall evenly into an interval, whatever the motion
_ELSEWHERE = (0.0, 0.382, 0.764)  # parts of a period at which derivatives may begin

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def settled_regime(
    protocol: Protocol,
    system: System,
    runner: LaneRunner,
    start: Start,
    length: float | None,
    stop: threading.Event | None = None,
) -> Verdict:
    """Regime of the motion from a start; ``length`` between strobes, None for the period.

    The runner has the parameters of the system. The transient is doubled until one window of
    strobes gives the label that the window before has given. Chaos may be one more transient, so a
    chaotic motion is run on.
    """
    motion = _Motion(protocol, system, runner, start, length, stop)
    first = protocol.transient
    while True:
        following = 2 * max(first, protocol.record)
        verdict = motion.look(first, is_last=following > protocol.longest)
        following = max(following, motion.reached)
        if verdict.label == labels.CHAOTIC and protocol.confirm:
            return motion.run_on(verdict)
        if verdict.is_settled or following > protocol.longest:
            return verdict
        first = following


class _Motion:
    """A lane on its way, and what is seen of it."""

    def __init__(
        self,
        protocol: Protocol,
        system: System,
        runner: LaneRunner,
        start: Start,
        length: float | None,
        stop: threading.Event | None,
    ) -> None:
        self.protocol, self.system, self.runner, self.stop = protocol, system, runner, stop
        self.begin, self.first_state = start.instant, start.state
        self.period = length
        self.length = runner.window if length is None else length
        self.drifting = np.array([name in system.drift_states for name in system.states])
        self.sizes = np.abs(start.state)  # of the states since the start
        self.reached = 0  # strobes passed
        self.derivatives = build_derivatives(system, runner.tables, ())
        self.autonomous = not is_driven(runner.tables)
        hidden = hides_phase(runner.tables, self.length)
        # a motion that others approach has a direction without growth where strobes do not repeat
        self.attracting = (
            labels.LIMIT_CYCLE if self.autonomous else labels.QUASI_PERIODIC if hidden else ""
        )
        for mode in start.modes:
            self.lanes = runner.start(start.state[None], start.instant, mode)
            if len(start.modes) > 1:
                self._go_to(start.instant)
            if not self._is_misfit:
                break

    def look(self, first: int, *, is_last: bool) -> Verdict:
        """Verdict on the two windows after so many strobes."""
        windows = self._windows(first)
        if windows is None:
            return self._ended(first)
        before, now = windows.returns(self.drifting, self.sizes, self.protocol.match)
        seen = self._seen(windows, first, now)
        if before[0] != now[0]:
            return seen.unsettled(f"one window has the period {before[0]}, the next {now[0]}")
        if now[0]:
            return self._repeating(windows, seen)
        if not is_last and now[1] < _CLOSING * before[1]:
            return seen.unsettled("strobes come closer to each other from window to window")
        return self._not_repeating(windows, seen)

    def run_on(self, chaotic: Verdict) -> Verdict:
        """Verdict on a chaotic motion that is followed further: it may settle, or end."""
        first = self.reached + self.protocol.confirm
        windows = self._windows(first)
        if windows is None:
            return self._ended(first)
        before, now = windows.returns(self.drifting, self.sizes, self.protocol.match)
        if before[0] == now[0] and now[0]:
            return self._repeating(windows, self._seen(windows, first, now))
        return replace(
            chaotic, reason=f"{chaotic.reason}; it has not settled within {self.reached} periods"
        )

    def _windows(self, first: int) -> Windows | None:
        """The two windows after so many strobes; None where the motion ends before."""
        record = self.protocol.record
        if self._has_ended:
            return None
        numbers, phases = self._strobes(first, 2 * record + 1)
        self._go_to(_instant(numbers, phases, 0))
        if self._has_ended:
            return None
        # the states between the last two strobes tell how large they are, and whether they rest
        between = [self._after(_instant(numbers, phases, -2), part) for part in _BETWEEN]
        numbers = np.insert(numbers, -1, [instant.number for instant in between])
        phases = np.insert(phases, -1, [instant.phase for instant in between])
        states, modes, rows, _ = self.runner.record(self.lanes, 0, numbers, phases)
        if self._has_ended:
            return None
        self.reached = first + 2 * record
        self.sizes = np.maximum(self.sizes, np.abs(states).max(axis=0))
        others = np.arange(-1 - len(between), -1)
        self.between, self.modes_between = states[others], modes[others]
        return Windows(
            np.delete(states, others, axis=0),
            np.delete(modes, others),
            np.delete(numbers, others),
            np.delete(phases, others),
            rows,
            rows["phase"],
            self.runner.window,
        )

    def _seen(self, windows: Windows, first: int, found: tuple[int, float]) -> Verdict:
        """What strobes and events alone tell."""
        last = len(windows.points) - 1
        count = found[0] or last
        events, impacts = windows.counts(self.system, last - count, last)
        drift = (windows.points[-1] - windows.points[-1 - count]) / count
        return Verdict(
            label=labels.UNSETTLED,
            reason="",
            transient_used=first,
            length=self.length,
            drift=drift,
            period=found[0],
            word=windows.word(self.system, last - count, last) if found[0] else "",
            events=events / count,
            impacts=impacts / count,
            residual=found[1],
            uncertain=int(self.lanes.uncertain[0]),
            estimated=int(self.lanes.estimated[0]),
            progresses=self._progresses(drift),
            last=(windows.points[-1], int(windows.modes[-1])),
        )

    def _progresses(self, drift: Floats) -> int:
        """Whether a state drifts by more than ``match`` of the size of the other states."""
        size = float(self.sizes[~self.drifting].max(initial=0.0))
        return int(np.any(np.abs(drift[self.drifting]) > self.protocol.match * size))

    def _repeating(self, windows: Windows, seen: Verdict) -> Verdict:
        """Multipliers decide whether a motion that repeats is one to settle to."""
        p = seen.period
        # as many whole periods earlier as lead into the window before
        earlier = 2 * windows.record - p * -(-windows.record // p)
        word = windows.word(self.system, earlier - p, earlier)
        if cyclic_word(word) != cyclic_word(seen.word):
            return seen.unsettled("the words of two periods differ")
        self.reached += 2  # what follows looks into the next two intervals
        steady = p == 1 and seen.events == 0 and self._rests(windows)
        # along a motion in which drifts alone change no other direction is neutral
        found = self._multipliers(windows, p, self.autonomous and not steady)
        if self._has_ended:
            return self._ended(self.reached)
        if found is None:
            return seen.unsettled("the derivatives over a period are not known, as at a graze")
        orbit, multipliers = found
        duration = p * self.length
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
        if steady and self._drifts_rest(windows):
            return _named(seen, labels.EQUILIBRIUM, f"nothing changes; {told}")
        if steady:
            which = ", ".join(self.system.drift_states)
            return _named(seen, labels.PERIODIC, f"travels in {which}, and nothing else; {told}")
        if is_forgetful(orbit, multipliers, self.drifting):
            lost: dict[str, Any] = {"multipliers": np.zeros_like(multipliers), "exponent": -np.inf}
            seen = replace(seen, **lost)
            return _named(seen, labels.LOCKED, "every perturbation is lost within a period")
        return _named(seen, labels.PERIODIC, told)

    def _rests(self, windows: Windows) -> bool:
        """Whether the states between strobes are those at strobes, but for drifts."""
        here, match = windows.points[-1], self.protocol.match
        away = np.abs(self.between - here).max(axis=0)
        close = away <= match * np.maximum(np.abs(here), match * self.sizes)
        return bool(
            np.all(close | self.drifting) and np.all(self.modes_between == windows.modes[-1])
        )

    def _drifts_rest(self, windows: Windows) -> bool:
        """Whether drifts have come to rest: hardly a step is left of the way since the start."""
        here, before = windows.points[-1], windows.points[-2]
        way = np.abs(here - self.first_state) * self.protocol.match
        rounding = 16.0 * np.finfo(float).eps * np.abs(here)
        step = np.maximum(np.abs(self.between - here).max(axis=0), np.abs(here - before))
        return bool(np.all((step <= way + rounding)[self.drifting]))

    def _multipliers(
        self, windows: Windows, p: int, autonomous: bool
    ) -> tuple[OrbitTangent, npt.NDArray[np.complex128]] | None:
        """Multipliers and the point at which their period begins.

        At a strobe, or elsewhere: a strobe may lie on a guard. The motion is carried on to there.
        """
        state, mode = windows.points[-1], int(windows.modes[-1])
        for part in _ELSEWHERE:
            begin = self._after(windows.end, 1.0 + part) if part else windows.end
            if part:
                one = np.array([begin.number]), np.array([begin.phase])
                states, modes = self.runner.run(self.lanes, begin, *one, self.stop)
                if self._has_ended:
                    return None
                state, mode = states[0, 0], int(modes[0, 0])
            orbit = OrbitTangent(
                self.runner.tables, self.derivatives, self.runner.tolerance, state, mode, begin,
                self._after(begin, p),
            )  # fmt: skip
            found = orbit_multipliers(orbit, self.drifting, autonomous)
            if found is not None:
                return orbit, found
        return None

    def _not_repeating(self, windows: Windows, seen: Verdict) -> Verdict:
        """Exponent and 0-1 test of two windows decide on a motion that does not repeat."""
        turn, count = self.protocol.record, self.protocol.evidence
        numbers, phases = self._strobes(self.reached, turn + 2 * count + 1)
        end = _instant(numbers, phases, -1)
        looked = self._looks(numbers, phases, turn) if self.autonomous else (numbers, phases)
        states, _ = self.runner.run(self.lanes, end, looked[0][1:], looked[1][1:], self.stop)
        if self._has_ended:
            return self._ended(self.reached)
        self.reached += turn + 2 * count
        neighbours = Neighbours(
            self.runner.tables, self.derivatives, self.runner.tolerance, windows.points[-1],
            int(windows.modes[-1]), numbers, phases, turn, self.drifting,
            self.stop,
        )  # fmt: skip
        status, growth = strobe_growth(neighbours)
        if status != Status.COMPLETED:
            return _named(seen, labels.label_of_end(status), f"ended early: {status.word}")
        if growth.size == 0:
            return seen.unsettled("no mode takes the last strobe as a start of derivatives")
        evidence = states[0, turn - 1 :]
        if not self.autonomous:
            return self._by_growth(seen, growth, evidence, evidence[1:])
        return self._by_growth(seen, growth, evidence[::2], evidence[1::2])

    def _looks(self, numbers: Integers, phases: Floats, turn: int) -> tuple[Integers, Floats]:
        """Strobes, and behind the turn one more look within every interval, ever elsewhere in it.

        Strobes alone may creep along a cycle that has nearly their period.
        """
        first = np.arange(turn, numbers.size - 1)
        parts = (1.0 + np.arange(first.size)) * _GOLDEN % 1.0
        window = self.runner.window
        more, inside = instants(phases[first] + parts * self.length, window)
        return (
            np.insert(numbers, first + 1, numbers[first] + more),
            np.insert(phases, first + 1, inside),
        )

    def _by_growth(self, seen: Verdict, growth: Floats, states: Floats, looks: Floats) -> Verdict:
        """Label by the growth in each interval, the states at the strobes, and one in each."""
        count = self.protocol.evidence
        windows = [_mean_rate(part, self.length) for part in (growth[:count], growth[count:])]
        (first, first_error), (second, second_error) = windows
        label = labels.label_of_growth(
            (first, second), (first_error, second_error), count * self.length, self.attracting
        )
        exponent, error = _mean_rate(growth, self.length)
        seen = replace(seen, exponent=exponent, error=error)
        told = f"exponent {exponent:.3g} +- {error:.2g}"
        if self.autonomous and np.count_nonzero(~self.drifting) < 2:
            seen, told = replace(seen, exponent=np.nan), "one state, and no direction across it"
        elif label == labels.LIMIT_CYCLE and not np.isfinite(error):
            told = "no perturbation across the cycle outlives its events"
        why = self._unbounded(label, seen, looks)
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

    def _unbounded(self, label: str, seen: Verdict, looks: Floats) -> str:
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
            earlier, later, names, self.sizes[~self.drifting], seen.events > 0,
            self.protocol.match,
        )  # fmt: skip

    def _series(self, states: Floats) -> Floats:
        """Numbers for the 0-1 test: the states without drift, or else the steps of drifts."""
        moving = states[1:, ~self.drifting]
        return moving if moving.shape[1] else np.diff(states, axis=0)

    def _strobes(self, first: int, count: int) -> tuple[Integers, Floats]:
        return strobes(
            self.runner.window, self.begin, self.period, self.protocol.phase, first, count
        )

    def _after(self, begin: Instant, intervals: float) -> Instant:
        """Instant some strobe intervals later; of whole periods without rounding."""
        if self.period is None and intervals == int(intervals):
            return Instant(begin.number + int(intervals), begin.phase)
        window = self.runner.window
        number, phase = instants([begin.phase + intervals * self.length], window)
        return Instant(begin.number + int(number[0]), float(phase[0]))

    def _go_to(self, end: Instant) -> None:
        self.runner.run(self.lanes, end, np.zeros(0, np.int64), np.zeros(0), self.stop)

    @property
    def _has_ended(self) -> bool:
        return int(self.lanes.status[0]) != Status.COMPLETED

    @property
    def _is_misfit(self) -> bool:
        """Whether the start lies in no mode, rather than an end that was reached."""
        return self._has_ended and int(self.lanes.anchors.place["mode"][0]) < 0

    def _ended(self, first: int) -> Verdict:
        """A motion that did not go on."""
        status = Status(int(self.lanes.status[0]))
        anchors = self.lanes.anchors
        place = Instant(int(anchors.place["number"][0]), float(anchors.place["phase"][0]))
        passed = (
            place.time(self.runner.window) - self.begin.time(self.runner.window)
        ) / self.length
        reason = "the start fits no mode" if self._is_misfit else f"ended early: {status.word}"
        return Verdict(
            label=labels.label_of_end(status),
            reason=reason,
            transient_used=max(0, min(first, int(passed))),
            length=self.length,
            drift=np.full(self.drifting.size, np.nan),
            uncertain=int(self.lanes.uncertain[0]),
            estimated=int(self.lanes.estimated[0]),
        )


def _instant(numbers: Integers, phases: Floats, k: int) -> Instant:
    return Instant(int(numbers[k]), float(phases[k]))


def _named(seen: Verdict, label: str, reason: str) -> Verdict:
    return replace(seen, label=label, reason=reason)


def _mean_rate(growth: Floats, length: float) -> tuple[float, float]:
    """Mean growth per unit time with its standard error; nan for a column that is lost."""
    if not np.all(np.isfinite(growth)):
        return -np.inf, np.nan
    error = float(block_averages(growth[:, None]).standard_error[0])
    return float(growth.mean()) / length, error / length


def _agreeing_test(label: str, series: Floats, protocol: Protocol) -> tuple[StrobeTest, str]:
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
