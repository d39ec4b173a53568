"""Motions followed side by side until each has given its label twice, and the evidence for it."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.diagrams.chain_links import End
from nonsmooth.analysis.exponents.interval_tangents import IntervalTangents, PeriodMaps
from nonsmooth.analysis.exponents.neighbours import (
    is_forgetful,
    may_forget,
    multipliers_of,
    strobe_growth,
)
from nonsmooth.analysis.regimes import labels
from nonsmooth.analysis.regimes.by_growth import EarlierLooks, Evidence, FormerLook, by_growth
from nonsmooth.analysis.regimes.labels import Verdict
from nonsmooth.analysis.regimes.options import RegimeProtocol
from nonsmooth.analysis.regimes.window import Windows, cyclic_word, window_times
from nonsmooth.analysis.settle import Group
from nonsmooth.analysis.statistics.rest import comes_to_rest, natural_sizes, way_left
from nonsmooth.engine.status import Status
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.crew import Stopped
from nonsmooth.runs.sweep_runner import Recorded, Times
from nonsmooth.runs.whole_turns import whole_turns

__all__ = ["first_windows", "settled_regimes"]

_CLOSING = 0.5  # of the residual of a window is left in the next one while a motion settles
_NEARLY = 10.0  # times what strobes repeat to, to which they nearly do
_ROUNDING = 1e-9  # of a multiplier
_MORE_LOOKS = 4  # at a motion that was chaotic and is neither that nor settled when it is run on
_LOOKS_AT_TORI = 2  # at a motion that seemed quasi-periodic, each as far behind the one before
_UNKNOWN = "the derivatives over a period are not known, as at a graze"
_GOLDEN = 0.5 * (5.0**0.5 - 1.0)  # its multiples fall evenly into an interval, whatever the motion

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Complexes = npt.NDArray[np.complex128]


def first_windows(protocol: RegimeProtocol, group: Group) -> Times:
    """Times at which motions are recorded first: two windows of strobes after the transient."""
    return window_times(group, protocol.record, protocol.transient, group.usable)


def settled_regimes(protocol: RegimeProtocol, group: Group, recorded: Recorded) -> list[Verdict]:
    """Regime of each motion of a group, whose first windows were recorded.

    The transient is doubled until one window of strobes gives the label that the window before has
    given. Chaos may be one more transient, and a motion that seems quasi-periodic may settle more
    slowly than two windows tell, so both are run on, and looked at again. What is next is done for
    all motions together that need it. Where the work is stopped, verdicts that stand are handed
    out.
    """
    motions = _Motions(protocol, group)
    going, lasting = group.usable.copy(), np.zeros(group.count, bool)
    endless = [labels.CHAOTIC, labels.QUASI_PERIODIC]
    first = np.full(group.count, protocol.transient)
    found: Recorded | None = recorded
    try:
        while np.any(going):
            following = 2 * np.maximum(first, protocol.record)
            motions.look(going, first, following > protocol.longest, found)
            found = None
            following = np.maximum(following, motions.reached)
            has = np.array([verdict.label for verdict in motions.verdicts])
            lasting |= going & np.isin(has, endless)
            going &= (has == labels.UNSETTLED) & (following <= protocol.longest)
            motions.go_beside(going & motions.part)
            first = following
        if protocol.confirm and np.any(lasting):
            motions.run_on(lasting)
    except Stopped:
        open_yet = going | (lasting if protocol.confirm else False)
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
        self.autonomous = not group.runner.is_driven
        nothing = np.full(self.drifting.size, np.nan)
        self.first_states = np.array(
            [nothing if start is None else start.state for start in group.starts]
        )
        self.first_states = self.first_states - whole_turns(self.first_states, group.angle_periods)
        # (M, n) of the states since the start; one that is left out begins at rest
        self.sizes = np.nan_to_num(np.abs(self.first_states))
        self.natural = self.sizes.copy()  # (M, n): see `natural_sizes`
        self.reached = np.zeros(group.count, np.int64)  # strobes passed
        # (M, 2): strobes at which the windows of evidence of the last look begin
        self.evidence = np.zeros((group.count, 2), np.int64)
        self.history = EarlierLooks.blank(group.count, self.drifting.size)
        # the last look at each motion that seemed quasi-periodic, and its first strobe
        self.former: dict[int, tuple[FormerLook, int]] = {}
        self.verdicts = [Verdict(Status.REFUSED.word, "", 0, np.nan, nothing)] * group.count
        self._tangents = IntervalTangents(group)

    def look(
        self, chosen: Bools, first: Integers, is_last: Bools, recorded: Recorded | None
    ) -> None:
        """Verdicts on the two windows after so many strobes of the chosen motions."""
        windows, alive = self._windows(chosen, first, recorded)
        if windows is None:
            return
        resting = self._resting(windows, alive)
        both = self._returns(windows, alive, resting)
        seen = self._seen(windows, alive, first, both)
        (before, now), (rest_before, rest_now) = (each.T for each in both)
        same = alive & (before == now)
        for i in np.flatnonzero(alive & ~same).tolist():
            why = f"one window has the period {before[i]}, the next {now[i]}"
            if max(rest_before[i], rest_now[i]) <= _NEARLY * self.protocol.match:
                why += (
                    f"; strobes repeat to {rest_now[i]:.2g} with any, as on the last of the way of"
                    " a motion that settles slowly: a larger longest= tells"
                )
            self.verdicts[i] = seen[i].unsettled(why)
        on_the_way = self._on_the_way(windows, same & (now > 1))
        for i in np.flatnonzero(on_the_way).tolist():
            self.verdicts[i] = replace(seen[i], period=0, word="").unsettled(
                f"strobes repeat with period {now[i]}, but are no farther apart than the way that"
                " is left: the motion may settle to a shorter period"
            )
        self._repeating(windows, seen, same & (now > 0) & ~on_the_way & ~resting)
        self._at_rest(windows, seen, resting)
        closing = same & (now == 0) & ~is_last
        with np.errstate(invalid="ignore"):
            closer = rest_now < _CLOSING * rest_before
        shrink = windows.shrink(self.drifting, self.natural, self.protocol.match)
        closing &= closer | (shrink & self.autonomous)
        for i in np.flatnonzero(closing).tolist():
            self.verdicts[i] = seen[i].unsettled(
                "strobes come closer to each other from window to window"
            )
        self._not_repeating(windows, seen, same & (now == 0) & ~closing)

    @property
    def part(self) -> Bools:
        """Whether neighbours of each motion, which does not repeat, leave it, (M,)."""
        return np.array([one.period == 0 and one.exponent > 0.0 for one in self.verdicts])

    def go_beside(self, chosen: Bools) -> None:
        """Let motions whose neighbours part go on beside where they are, see `Group.go_beside`."""
        if np.any(chosen):
            self.group.go_beside(chosen, self.natural)

    def run_on(self, chosen: Bools) -> None:
        """Verdicts on motions without an end that are followed further: they may settle, or end.

        One that is looked at on its way from there to what it settles to is looked at again: soon
        where it was chaotic, and as much later where it seemed quasi-periodic, as only two looks
        that lie far apart tell a slow decay from none.
        """
        before, since = list(self.verdicts), self.evidence[:, 0].copy()
        going, further = chosen.copy(), np.full(chosen.size, self.protocol.confirm)
        torus = np.array([verdict.label == labels.QUASI_PERIODIC for verdict in before])
        self.go_beside(chosen & ~torus)
        for look in range(1 + _MORE_LOOKS):
            going &= ~torus | (look < _LOOKS_AT_TORI)
            if not np.any(going):
                return
            self.look(going, self.reached + further, going, None)
            for i in np.flatnonzero(going).tolist():
                now, first = self.verdicts[i], before[i]
                if now.label == first.label:
                    seen = int(self.evidence[i, 1] - since[i])
                    self.verdicts[i] = replace(
                        first,
                        chaotic_for=seen if now.label == labels.CHAOTIC else 0,
                        last=now.last,
                        uncertain=now.uncertain,
                        estimated=now.estimated,
                    )
                elif not now.is_settled:
                    self.verdicts[i] = now.unsettled(f"{first.label} at first; later {now.reason}")
                going[i] = not now.is_settled
            further[~torus] = max(self.protocol.transient, self.protocol.record)

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
        windows, still = Windows.of(group, recorded), ~self.drifting
        largest = np.maximum(np.abs(windows.low), np.abs(windows.high))[alive]
        self.sizes[alive] = np.maximum(self.sizes[alive], largest)
        self.natural[alive] = self.sizes[alive]
        blocks_over = partial(self._tangents.over_parts, windows.last)
        found = natural_sizes(self.sizes[:, still], alive, blocks_over)
        self.natural[np.ix_(alive, still)] = found[alive]
        return windows, alive

    def _still_going(self, chosen: Bools, first: Integers) -> Bools:
        """Which of the chosen motions have not ended; the others get their verdicts."""
        going = chosen & (self.group.motions.statuses == Status.COMPLETED)
        for i in np.flatnonzero(chosen & ~going).tolist():
            self.verdicts[i] = self._ended(i, int(first[i]))
        return going

    def _resting(self, windows: Windows, alive: Bools) -> Bools:
        """Which motions are at rest, or on the last of their way there, (M,).

        Those that have died away altogether, whatever drives them; and without forcing those that
        hardly move: as their neighbours do, or by half as much in each window while they pass from
        mode to mode.
        """
        still, match = ~self.drifting, self.protocol.match
        driven = not self.autonomous
        resting = alive & windows.sunk(self.drifting, self.natural, match, driven=driven)
        resting &= self.autonomous or bool(np.all(still))  # a drift may be what is driven
        if not self.autonomous or not np.any(still):
            return resting
        small = np.all((windows.ranges <= match * self.natural) | self.drifting, axis=1)
        maybe = alive & ~resting & small
        known, blocks = self._tangents.over_part(windows.last, 1.0, maybe)
        for i in np.flatnonzero(maybe).tolist():
            points, natural = windows.points[i][:, still], self.natural[i, still]
            ranges, block = windows.ranges[i, still], blocks[i] if known[i] else None
            passes = bool(windows.passes[i])
            resting[i] = comes_to_rest(points, ranges, natural, block, match, passes=passes)
        return resting

    def _returns(self, windows: Windows, alive: Bools, resting: Bools) -> tuple[Integers, Floats]:
        """Period and residual of each window of the motions that are alive, (M, 2) each.

        What rests has the period one.
        """
        periods, residuals = np.zeros((alive.size, 2), np.int64), np.full((alive.size, 2), np.nan)
        which = np.flatnonzero(alive)
        periods[which], residuals[which] = windows.returns(
            which, self.drifting, self.natural[which], self.protocol.match
        )
        periods[resting] = 1
        return periods, residuals

    def _on_the_way(self, windows: Windows, repeats: Bools) -> Bools:
        """Which of the motions that repeat may yet settle to a shorter period, (M,)."""
        found = np.zeros(repeats.size, bool)
        which = np.flatnonzero(repeats)
        found[which] = windows.on_the_way(
            which, self.drifting, self.natural[which], self.protocol.match
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
        motions, here = self.group.motions, np.arange(alive.size)
        way = windows.travelled[:, -1] - windows.travelled[here, -1 - count]
        drifts = way / count[:, None]
        progress = self._progress(drifts).tolist()
        seen = {}
        for i in np.flatnonzero(alive).tolist():
            seen[i] = Verdict(
                label=labels.UNSETTLED,
                reason="",
                transient_used=int(first[i]),
                length=self.group.length(i),
                drift=drifts[i],
                period=int(period[i]),
                word=words[i],
                events=float(events[i] / count[i]),
                impacts=float(impacts[i] / count[i]),
                residual=float(residual[i]),
                uncertain=int(motions.uncertain[i]),
                estimated=int(motions.estimated[i]),
                progresses=progress[i],
                last=(windows.points[i, -1], int(windows.modes[i, -1])),
            )
        return seen

    def _progress(self, drifts: Floats) -> Integers:
        """Whether a state drifts by more than ``match`` of the size of the others, or an angle.

        shapes: drifts (M, n); returns (M,)
        """
        match, turns = self.protocol.match, self.group.angle_periods
        sizes = self.sizes[:, ~self.drifting].max(axis=1, initial=0.0)
        going = self.drifting & (np.abs(drifts) > match * sizes[:, None])
        turning = (turns > 0.0) & (np.abs(drifts) > match * turns)
        return np.any(going | turning, axis=1).astype(np.int64)

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
                chosen[i] = False
        self._by_multipliers(windows, seen, chosen, periods)

    def _by_multipliers(
        self, windows: Windows, seen: dict[int, Verdict], chosen: Bools, periods: Integers
    ) -> None:
        """Verdicts on motions that repeat, by their multipliers."""
        match, self.reached[chosen] = self.protocol.match, self.reached[chosen] + 2
        maps = self._period_maps(windows, seen, chosen, periods)
        steady = np.zeros(chosen.size, bool)
        for i in np.flatnonzero(maps.known).tolist():
            steady[i] = periods[i] == 1 and seen[i].events == 0
            steady[i] &= windows.rests(i, self.drifting, self.natural[i], match)
        # along a motion in which drifts alone change no other direction is neutral
        multipliers = self._multipliers(maps, self.autonomous & ~steady)
        forgetful = self._forgetful(maps, multipliers)
        for i, own in multipliers.items():
            one = seen[i].with_multipliers(own)
            if own.size and one.modulus > 1.0 - _ROUNDING:
                self.verdicts[i] = one.unsettled(f"strobes repeat, but {_neutral(one.modulus)}")
            elif steady[i]:
                block = maps.blocks[i]
                creeps = self._creeps(windows, i, block) if self.autonomous and block.size else ""
                self.verdicts[i] = (
                    one.unsettled(creeps) if creeps else self._steady(windows, i, one)
                )
            elif forgetful[i]:
                one = replace(one, multipliers=np.zeros_like(own), exponent=-np.inf)
                said = "every perturbation is lost within a period"
                self.verdicts[i] = one.named(labels.LOCKED, said)
            else:
                said = _repeats(one) + self._turned(one)
                self.verdicts[i] = one.named(labels.PERIODIC, said)

    def _period_maps(
        self, windows: Windows, seen: dict[int, Verdict], chosen: Bools, periods: Integers
    ) -> PeriodMaps:
        """Derivatives of the chosen motions over their periods.

        Those that have ended on the way, or whose derivatives are not known, get their verdicts.
        """
        maps = self._tangents.over_periods(chosen, windows.last, periods)
        going = self._still_going(chosen, self.reached)
        for i in np.flatnonzero(going & ~maps.known).tolist():
            self.verdicts[i] = seen[i].unsettled(_UNKNOWN)
        return maps._replace(known=maps.known & going)

    def _multipliers(self, maps: PeriodMaps, along: Bools) -> dict[int, Complexes]:
        """Multipliers of the motions whose period maps are known, one ``along`` them left out."""
        known = np.flatnonzero(maps.known)
        found = multipliers_of(maps.blocks[known], along[known])
        return dict(zip(known.tolist(), found, strict=True))

    def _forgetful(self, maps: PeriodMaps, multipliers: dict[int, Complexes]) -> Bools:
        """Which motions lose every perturbation within their period, (M,)."""
        asked = np.zeros(maps.known.size, bool)
        for i, own in multipliers.items():
            asked[i] = may_forget(own)
        if not np.any(asked):
            return asked
        return is_forgetful(self._tangents.neighbours(maps.starts, maps.ends, asked))

    def _turned(self, seen: Verdict) -> str:
        """How far angles have turned when a motion repeats, in words."""
        states, period = self.system.states, seen.period
        counts = {
            name: round(period * float(seen.drift[states.index(name)]) / length)
            for name, length in self.system.angles.items()
        }
        return "".join(
            f"; {name} makes {count} turn{'s' if abs(count) > 1 else ''} of its period then"
            for name, count in counts.items()
            if count
        )

    def _at_rest(self, windows: Windows, seen: dict[int, Verdict], chosen: Bools) -> None:
        """Verdicts on motions that rest, or are on the last of their way there.

        Derivatives over an interval say nothing of an equilibrium on a surface, where states pass
        from mode to mode for ever; that they came there does.
        """
        if not np.any(chosen):
            return
        self.reached[chosen] += 2
        maps = self._tangents.over_periods(chosen, windows.last, np.ones(chosen.size, np.int64))
        found = self._multipliers(maps, np.zeros(chosen.size, bool))
        for i in np.flatnonzero(self._still_going(chosen, self.reached)).tolist():
            step = np.abs(windows.points[i, -1] - windows.points[i, -2])[~self.drifting]
            natural = self.natural[i, ~self.drifting]
            unit = np.where(natural > 0.0, natural, 1.0)
            one = replace(seen[i], residual=float((step / unit).max()))
            multipliers = found.get(i)
            known = multipliers is not None and abs(multipliers[0]) <= 1.0 - _ROUNDING
            if multipliers is not None and (known or not windows.passes[i]):
                one = one.with_multipliers(multipliers)
            if known or windows.passes[i]:
                self.verdicts[i] = self._steady(windows, i, one)
            else:
                open_yet = "the derivatives are not known"
                why = open_yet if multipliers is None else _neutral(one.modulus)
                self.verdicts[i] = one.unsettled(f"nothing moves, but {why}")

    def _steady(self, windows: Windows, i: int, seen: Verdict) -> Verdict:
        """Label of a motion in which drifts alone may change."""
        first, match = self.first_states[i], self.protocol.match
        if windows.drifts_rest(i, self.drifting, first, match):
            return seen.named(labels.EQUILIBRIUM, f"nothing changes; {_repeats(seen)}")
        which = ", ".join(self.system.drift_states)
        return seen.named(
            labels.PERIODIC, f"travels in {which}, and nothing else; {_repeats(seen)}"
        )

    def _creeps(self, windows: Windows, i: int, block: Floats) -> str:
        """Why a motion whose strobes hardly differ has a way to go, "" where it has none."""
        still, match = ~self.drifting, self.protocol.match
        away = way_left(windows.points[i, -2:][:, still], block)[0]
        far = away > match * self.natural[i, still]
        if not np.any(far):
            return ""
        states = np.array(self.system.states)[still]
        told = ", ".join(
            f"{name} by {way:.2g}" for name, way in zip(states[far], away[far], strict=True)
        )
        return f"strobes hardly differ, but by their rates they have a way to go: {told}"

    def _not_repeating(self, windows: Windows, seen: dict[int, Verdict], chosen: Bools) -> None:
        """Exponent and 0-1 test of two windows decide on motions that do not repeat."""
        if not np.any(chosen):
            return
        group, turn, count = self.group, self.protocol.record, self.protocol.evidence
        times = group.strobes(self.reached, turn + 2 * count + 1, chosen)
        looked = self._looks(times, turn, chosen) if self.autonomous else times
        states = group.run(looked.at(slice(1, None)), chosen=chosen, log=False).states
        going = self._still_going(chosen, self.reached)
        self.evidence[going] = self.reached[going, None] + turn + np.array([0, count])
        self.reached[going] += turn + 2 * count
        starts = windows.last._replace(numbers=times.numbers[:, 0], phases=times.phases[:, 0])
        found = strobe_growth(self._tangents.neighbours(starts, times, going), turn)
        for i in np.flatnonzero(going).tolist():
            status = Status(int(found.statuses[i]))
            if not found.has_mode[i]:
                why = "no mode takes the last strobe as a start of derivatives"
                self.verdicts[i] = seen[i].unsettled(why)
            elif status != Status.COMPLETED:
                why = f"ended early: {status.word}"
                self.verdicts[i] = seen[i].named(labels.label_of_end(status, group.system), why)
        known = np.flatnonzero(going & found.has_mode & (found.statuses == Status.COMPLETED))
        evidence = Evidence.of(
            group, known, found.growth[known], found.areas[known], states[known, turn - 1 :],
            self.natural[known], self._history(), self.protocol.match,
        )  # fmt: skip
        for k, i in enumerate(known.tolist()):
            verdict = by_growth(seen[i], evidence, k, self.protocol)
            if verdict.label == labels.CHAOTIC:
                length = int(self.evidence[i, 1] - self.evidence[i, 0])
                verdict = replace(verdict, chaotic_for=length)
            self.verdicts[i] = verdict
            if verdict.label == labels.QUASI_PERIODIC or i in self.former:
                look = FormerLook(evidence.strobes[k], evidence.looks[k])
                self.former[i] = look, int(self.evidence[i, 0])
        self.history = self.history.after(known, evidence.strobes)

    def _history(self) -> EarlierLooks:
        """What was seen before this look."""
        former, ago = list(self.history.former), self.history.ago.copy()
        for i, (look, first) in self.former.items():
            former[i], ago[i] = look, self.evidence[i, 0] - first
        return self.history._replace(former=tuple(former), ago=ago)

    def _looks(self, times: Times, turn: int, chosen: Bools) -> Times:
        """Strobes, and behind the turn one more look within every interval, ever elsewhere in it.

        Strobes alone may creep along a cycle that has nearly their period.
        """
        first = np.arange(turn, times.numbers.shape[1] - 1)
        parts = (1.0 + np.arange(first.size)) * _GOLDEN % 1.0
        since = times.phases[:, first] + parts * self.group.lengths[:, None]
        more, inside = self.group.instants(since, chosen)
        return Times(
            np.insert(times.numbers, first + 1, times.numbers[:, first] + more, axis=1),
            np.insert(times.phases, first + 1, inside, axis=1),
        )

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
            label=labels.label_of_end(status, group.system),
            reason="the start fits no mode" if misfit else f"ended early: {status.word}",
            transient_used=max(0, min(first, int(passed))),
            length=group.length(i),
            drift=np.full(self.drifting.size, np.nan),
            uncertain=int(motions.uncertain[i]),
            estimated=int(motions.estimated[i]),
        )


def _repeats(seen: Verdict) -> str:
    """How nearly strobes repeat, and how others come to them."""
    told = f"strobes repeat to {seen.residual:.2g}"
    return f"{told}; largest multiplier {seen.modulus:.3g}" if seen.multipliers.size else told


def _neutral(modulus: float) -> str:
    return (
        f"the largest multiplier has the modulus {modulus:.9g}, which does not lie inside the unit"
        " circle"
    )
