"""The label of a motion that does not repeat: by how its neighbours part, and where it goes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.regimes import labels
from nonsmooth.analysis.regimes.closed_curves import (
    BEND,
    ClosedCurves,
    Rotation,
    closed_curves,
    told_rotation,
)
from nonsmooth.analysis.regimes.labels import Verdict
from nonsmooth.analysis.regimes.options import TESTED, RegimeProtocol
from nonsmooth.analysis.regimes.slow_decay import KEPT, MotionTube, SteadyRate, steady_rate
from nonsmooth.analysis.regimes.window import (
    APART,
    SHRINKING,
    Growing,
    StrobeTest,
    no_closed_orbit,
    rest_floor,
    run_away,
    shrinks,
    shrunk,
    strobe_test,
    travels,
)
from nonsmooth.analysis.settle import Group
from nonsmooth.analysis.statistics.block_averages import block_averages
from nonsmooth.engine.extremes import state_maxima, state_minima, state_ranges
from nonsmooth.runs.strobe_times import hides_phase
from nonsmooth.system.columns import with_error

__all__ = ["EarlierLooks", "Evidence", "FormerLook", "by_growth"]

_SETTLES = "it settles slowly"
_NOTHING = "decide nothing"
_NEUTRAL = (
    "the states lie on one closed curve, of which neighbours neither come nearer nor go away, as"
    " without damping or where nothing ties equal machines: it attracts nothing"
)
_SAME = 1e-4  # of a step along a curve, by which strobes of a period miss each other
_NEARING = 0.5  # of a step between strobes that nearly repeat is left as they come to a node
_AS_FAST = 0.5  # of the rate of neighbours, by which strobes draw together at least
_MOST_EVIDENCE = 100_000  # strobes that a message asks for

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
_Rates: TypeAlias = tuple[float, float]  # a mean with its standard error


class FormerLook(NamedTuple):
    """What was seen of a motion when it seemed quasi-periodic; n states."""

    strobes: Floats  # (K + 1, n)
    looks: Floats  # (K, n)


class EarlierLooks(NamedTuple):
    """What was seen of M motions before a look; n states."""

    low: Floats  # (M, n): least value of each state at strobes, inf where nothing was seen
    high: Floats  # (M, n): largest one, or -inf
    spread: Floats  # (M, n): that of the window before, or inf
    former: tuple[FormerLook | None, ...]  # the look that gave quasi-periodic motion last
    ago: Integers  # (M,): periods between that look and this one

    @staticmethod
    def blank(count: int, states: int) -> EarlierLooks:
        """Nothing was seen of any motion."""
        unseen = np.full((count, states), np.inf)
        nothing = np.zeros(count, np.int64)
        return EarlierLooks(unseen, -unseen, unseen.copy(), (None,) * count, nothing)

    def of(self, which: Integers) -> EarlierLooks:
        """That of some motions."""
        low, high, spread, former, ago = self
        some = tuple(former[i] for i in which.tolist())
        return EarlierLooks(low[which], high[which], spread[which], some, ago[which])

    def after(self, which: Integers, strobes: Floats) -> EarlierLooks:
        """The same with strobes (m, K, n) of some motions seen too."""
        low, high, spread = (each.copy() for each in self[:3])
        low[which] = np.minimum(low[which], state_minima(strobes))
        high[which] = np.maximum(high[which], state_maxima(strobes))
        spread[which] = state_ranges(np.array_split(strobes, 2, axis=1)[1])
        return self._replace(low=low, high=high, spread=spread)


@dataclass(frozen=True)
class Evidence:
    """Two windows of M motions and of a neighbour of each; n states, K strobe intervals in both."""

    growth: Floats  # (M, K): logarithms
    areas: Floats  # (M, K): those of an area along the motion and across it
    strobes: Floats  # (M, K + 1, n)
    looks: Floats  # (M, K, n): one in each interval
    lengths: Floats  # (M,) of an interval
    names: tuple[str, ...]  # of the states
    drifting: Bools  # (n,)
    angles: Bools  # (n,), which come round without being turned back
    sizes: Floats  # (M, n): natural ones, see `natural_sizes`
    autonomous: bool
    hides_phase: Bools  # (M,): whether strobes see a forcing at different phases
    match: float
    history: EarlierLooks  # of these motions

    @staticmethod
    def of(
        group: Group, which: Integers, growth: Floats, areas: Floats, states: Floats,
        sizes: Floats, history: EarlierLooks, match: float,
    ) -> Evidence:  # fmt: skip
        """Evidence of some motions of a group, (M,), from the states at strobes and looks.

        A motion that is driven has no more looks than strobes.
        """
        lengths, autonomous = group.lengths[which], not group.runner.is_driven
        apart = (states[:, ::2], states[:, 1::2]) if autonomous else (states, states[:, 1:])
        return Evidence(
            growth, areas, *apart, lengths, tuple(group.system.states), group.drifting,
            group.angle_periods > 0.0, sizes, autonomous,
            hides_phase(group.runner.frequencies[which], lengths), match, history.of(which),
        )  # fmt: skip

    def attracting(self, i: int) -> str:
        """Label of motion i where others approach it although its strobes do not repeat.

        Such a motion has a direction without growth; "" where there is none.
        """
        if self.autonomous:
            return labels.LIMIT_CYCLE
        return labels.QUASI_PERIODIC if self.hides_phase[i] else ""

    def steady(self, i: int) -> SteadyRate:
        """Rate across motion i that all of the record has; none is told of one that is driven."""
        if not self.autonomous:
            return SteadyRate(np.nan, np.inf, self.areas.shape[1])
        return steady_rate(self.areas[i])

    @cached_property
    def exponents(self) -> tuple[list[_Rates], list[_Rates], list[_Rates]]:
        """Exponent of each motion with its standard error: of both windows, and of all of it."""
        half = self.growth.shape[1] // 2
        parts = self.growth[:, :half], self.growth[:, half:], self.growth
        first, second, whole = (_mean_rates(part, self.lengths) for part in parts)
        return first, second, whole

    @cached_property
    def windows(self) -> tuple[Floats, Floats]:
        """Looks at states that do not drift in either window, (M, K/2, n)."""
        earlier, later = np.array_split(self.looks[..., ~self.drifting], 2, axis=1)
        return earlier, later

    @cached_property
    def floor(self) -> Floats:
        """Spread of each state below which it rests, (M, n)."""
        return rest_floor(self.looks, self.sizes, self.match)

    @cached_property
    def moving(self) -> Bools:
        """Which states move, (M, n), drifts left out; all others where none of them does.

        Those that rest leave rounding, which must not be taken for what a motion does.
        """
        moving = (state_ranges(self.looks) > self.floor) & ~self.drifting
        return np.where(np.any(moving, axis=1, keepdims=True), moving, ~self.drifting)

    def series(self, i: int) -> Floats:
        """Numbers of motion i at strobes in a row: see `_series`."""
        return _series(self.strobes[i], self.moving[i])

    def names_of(self, i: int) -> tuple[str, ...]:
        """Names of the states of motion i that move."""
        return tuple(np.array(self.names)[self.moving[i]].tolist())

    @cached_property
    def run_away(self) -> list[bool]:
        """Whether each motion grows without bound."""
        still = ~self.drifting
        before = self.history.low[:, still], self.history.high[:, still]
        return run_away(*self.windows, before, self.floor[:, still]).tolist()

    @cached_property
    def growing(self) -> Growing:
        """Which states grow by equal steps or larger ones."""
        before = self.history.low, self.history.high
        return Growing.of(self.strobes, self.moving, self.sizes, before)

    @cached_property
    def shrink(self) -> list[bool]:
        """Whether each motion dies away, and has not grown since the window before: no beat."""
        still = ~self.drifting
        floor, first = self.floor[:, still], state_ranges(self.windows[0])
        spread = np.maximum(self.history.spread[:, still], floor)
        grew = np.any(first > (1.0 + APART) * spread, axis=-1)
        return (shrinks(*self.windows, floor) & ~grew).tolist()

    def seen_before(self, i: int) -> tuple[Floats, Floats]:
        """Least and largest values of the states of motion i that move, in earlier looks."""
        moving = self.moving[i]
        return self.history.low[i, moving], self.history.high[i, moving]


def by_growth(seen: Verdict, found: Evidence, i: int, protocol: RegimeProtocol) -> Verdict:
    """Label of motion i by the growth in each interval, the states at strobes, and one in each."""
    count, length = protocol.evidence, float(found.lengths[i])
    (first, first_error), (second, second_error), (exponent, error) = (
        part[i] for part in found.exponents
    )
    rates, errors = (first, second), (first_error, second_error)
    unasked = protocol.is_survey or found.autonomous  # a cycle turns as well between strobes
    curves = None if unasked else closed_curves(found.series(i))
    turns, attracting = isinstance(curves, ClosedCurves), found.attracting(i)
    label = labels.label_of_growth(rates, errors, count * length, attracting, turns=turns)
    slow = found.steady(i)
    one_curve = found.autonomous and label in ("", labels.QUASI_PERIODIC) and _is_line(found, i)
    if slow.decays and one_curve:
        label, exponent, error = labels.LIMIT_CYCLE, slow.rate / length, slow.error / length
    rate, told = exponent, f"exponent {with_error(exponent, error, 3, 2)}"
    if found.autonomous and np.count_nonzero(~found.drifting) < 2:
        rate, told = np.nan, "one state, and no direction across it"
    elif label == labels.LIMIT_CYCLE and not np.isfinite(error):
        told = "no perturbation across the cycle outlives its events"
    elif label == labels.QUASI_PERIODIC and label != attracting:
        rule = _rule(rates, errors, length, curves, protocol)
        told = f"exponent of two windows, {_of_both(rates, errors)}, {rule}"
    why, factor = _unbounded(label, seen, found, i, turns=turns), None
    if not why and one_curve and not slow.decays and np.isfinite(rates).all():
        why = _NEUTRAL
    if not why and label == labels.QUASI_PERIODIC:
        if found.autonomous:
            why, factor = _thinner(found, i, slow, protocol)
        else:
            why, factor = _moved(found, i, curves, protocol)
    elif not why and label == labels.LIMIT_CYCLE and _strobes_settle(found, i, exponent * length):
        why, factor = f"they draw together: {_SETTLES}", float(np.exp(exponent * length))
    if not (why or label):
        why = _undecided(rates, errors, protocol, slow, autonomous=found.autonomous)
        why += _cure(curves, protocol) if why.endswith(_NOTHING) else ""
        factor = float(np.exp(slow.rate if slow.decays else exponent * length))
    if why:
        if why.endswith(_SETTLES):
            factor = (
                _shrinking_factor(found.looks[i], found.moving[i]) if factor is None else factor
            )
            why += _follow_further(factor, seen, found, i, protocol)
        said = f"strobes do not repeat, and {why}"
        return replace(seen, label=labels.UNSETTLED, reason=said, exponent=rate, error=error)
    test, contradiction = _agreeing_test(label, found.series(i), protocol, turns=turns)
    seen = replace(seen, exponent=rate, error=error, k=test.k)
    if contradiction and rates == (-np.inf, -np.inf):
        return seen.unsettled(
            "every perturbation is lost within a window, so that the motion follows what drives"
            f" it, but {contradiction}: it jumps with the phases of that as a strange nonchaotic"
            " attractor does, which no longer evidence= tells apart"
        )
    if contradiction:
        cure = _cure(curves, protocol)
        return seen.unsettled(f"{told} is {label}, but {contradiction}{cure}")
    tested = "without the 0-1 test" if protocol.is_survey else f"K = {test.k:.2f}"
    is_turn = turns and label == labels.QUASI_PERIODIC
    return seen.named(label, told if is_turn else f"{told}, {tested}")


def _is_line(found: Evidence, i: int) -> bool:
    """Whether the states of motion i lie along a curve, between strobes as at them."""
    moving = found.moving[i]
    states = np.concatenate([found.looks[i][:, moving], found.strobes[i][:, moving]])
    return MotionTube.of(states, np.ptp(states, axis=0)).is_line


def _strobes_settle(found: Evidence, i: int, rate: float) -> bool:
    """Whether strobes of motion i draw together as its neighbours do, by a rate per interval.

    So they do where they lie a period of the cycle apart, or a clock turns once between them. Where
    they only creep along a cycle, neighbours are much faster.
    """
    strobes = found.strobes[i][1:, found.moving[i]]
    floor = rest_floor(strobes, found.sizes[i, found.moving[i]], found.match)
    before, now = (part.std(axis=0) for part in np.array_split(strobes, 2))
    moves = np.ptp(strobes, axis=0) > floor
    most = np.exp(_AS_FAST * rate * (len(strobes) // 2))
    return bool(np.any(moves) and np.all(now[moves] <= most * before[moves]))


def _thinner(
    found: Evidence, i: int, slow: SteadyRate, protocol: RegimeProtocol
) -> tuple[str, float | None]:
    """Why motion i, which nothing drives, is on its way to a cycle, "" where it is a torus.

    With the factor by which it settles per period, if it does. About a cycle it fills a tube, the
    width of which falls with the root of the area of the tube. Where it falls by too little to be
    seen since the last look, and neighbours come nearer steadily, nothing tells it from a torus.
    """
    moving, former, ago = found.moving[i], found.history.former[i], float(found.history.ago[i])
    factor = float(np.exp(slow.rate)) if slow.decays else None
    steadily = f"neighbours approach it steadily: {_SETTLES}"
    if former is None:
        return (steadily, factor) if slow.decays and not protocol.confirm else ("", None)
    earlier, later = former.looks[:, moving], found.looks[i][:, moving]
    unit = np.ptp(earlier, axis=0)
    before, now = MotionTube.of(earlier, unit), MotionTube.of(later, unit)
    if now.width < KEPT * before.width:
        ratio = (now.width / before.width) ** (2.0 / ago)
        said = f"the tube that it fills becomes thinner: {_SETTLES}"
        return said, ratio if factor is None else factor
    if now.width * KEPT > before.width:
        return "the tube that it fills becomes thicker: it grows slowly", None
    is_seen = slow.decays and np.exp(0.5 * slow.rate * ago) < KEPT * KEPT
    return ("", None) if is_seen or not slow.decays else (steadily, factor)


def _moved(
    found: Evidence, i: int, curves: ClosedCurves | Rotation | None, protocol: RegimeProtocol
) -> tuple[str, float | None]:
    """Why motion i is no longer where it was when it first seemed quasi-periodic, "" where it is.

    With the factor by which it settles per period, if it does. Two windows in a row cannot tell a
    slow decay from none; two that lie thousands of periods apart can.
    """
    former, ago = found.history.former[i], float(found.history.ago[i])
    if former is None:
        return "", None
    now, before = (_series(each, found.moving[i]) for each in (found.strobes[i], former.strobes))
    if isinstance(curves, ClosedCurves):
        if curves.meets(before) < _SAME:
            return _long_period(protocol), None
        if curves.away(before) <= BEND:
            left = curves.nearing(before)
            settles = f"strobes come to a cycle on a closed curve: {_SETTLES}"
            return ("", None) if left >= _NEARING else (settles, left ** (1.0 / ago))
        why = "the closed curve on which strobes lie shrinks"
    else:
        why = SHRINKING
    moving, floor = found.moving[i], np.zeros(now.shape[1])
    if np.any(moving):
        floor = rest_floor(found.strobes[i][:, moving], found.sizes[i, moving], found.match)
    moves = shrunk(before, now, floor)
    if moves is not None:
        ratio = float((np.ptp(now, axis=0)[moves] / np.ptp(before, axis=0)[moves]).max())
        return f"{why}: {_SETTLES}", ratio ** (1.0 / ago)
    if isinstance(curves, ClosedCurves):
        return "the closed curve on which strobes lie still moves; give a longer transient=", None
    return "", None


def _cure(curves: ClosedCurves | Rotation | None, protocol: RegimeProtocol) -> str:
    """What tells more of a motion that two windows leave undecided."""
    if isinstance(curves, Rotation) and curves.bend <= BEND and curves.needed:
        half = float(f"{-(-curves.needed // 2):.2g}")
        if half <= _MOST_EVIDENCE:
            return (
                f"; strobes nearly repeat after {curves.lag} periods and creep along a closed"
                f" curve, all of which evidence={max(half, protocol.evidence + 1):.0f} sees"
            )
        return "; strobes nearly repeat, and may come to a cycle: a longer transient= tells"
    longer = 4 * max(protocol.evidence, TESTED)
    return (
        f"; a longer evidence= tells more, such as {longer}: the error falls then, and the exponent"
        " of chaos does not"
    )


def _rule(
    rates: tuple[float, float],
    errors: tuple[float, float],
    length: float,
    curves: ClosedCurves | Rotation | None,
    protocol: RegimeProtocol,
) -> str:
    """Why exponents of two windows are those of quasi-periodic motion."""
    if isinstance(curves, ClosedCurves):
        # as it is on any circle
        error = 0.5 * curves.rotation.pieces / protocol.evidence
        turn, pieces = with_error(told_rotation(curves), error, 4, 1), curves.rotation.pieces
        where = "a closed curve" if pieces == 1 else f"each of {pieces} closed curves"
        return f"strobes keep their order on {where}, with the rotation number {turn}"
    if labels.is_near_zero(rates, errors, protocol.evidence * length):
        return "within three errors of zero"
    return "falls as where neighbours part linearly"


def _of_both(rates: tuple[float, float], errors: tuple[float, float]) -> str:
    """Exponents of two windows with their errors."""
    return " and ".join(with_error(*each, 3, 2) for each in zip(rates, errors, strict=True))


def _undecided(
    rates: tuple[float, float],
    errors: tuple[float, float],
    protocol: RegimeProtocol,
    slow: SteadyRate,
    *,
    autonomous: bool,
) -> str:
    """Why exponents of two windows give no label."""
    longest = protocol.record // 2
    if rates == (-np.inf, -np.inf):
        return (
            "every perturbation is lost within a window: the motion is locked, with a period of"
            f" more than {longest} strobes, half the record, or is about to be; give a longer"
            f" record= than {protocol.record}"
        )
    told = f"exponents of two windows, {_of_both(rates, errors)}"
    if slow.decays:
        return f"{told}, and the same one in all of them, say that {_SETTLES}"
    if max(rate + labels.ERRORS * error for rate, error in zip(rates, errors, strict=True)) >= 0.0:
        return f"{told}, {_NOTHING}"
    if autonomous:
        return f"{told}, say that {_SETTLES}"
    return (
        f"{told}, say that it has a period of more than {longest} strobes, half the record, for"
        f" which record= must be longer, or that {_SETTLES}"
    )


def _follow_further(
    factor: float, seen: Verdict, found: Evidence, i: int, protocol: RegimeProtocol
) -> str:
    """For how long to follow motion i, of which a factor is left after each period.

    It has settled where what is left is ``match`` of its size. The transient is doubled, so some
    doubling of it lies between that time and twice as much.
    """
    looks, sizes = found.looks[i], found.sizes[i]
    moving = found.moving[i] & (sizes > 0.0)
    spread = np.ptp(looks[len(looks) // 2 :, moving], axis=0)
    left = float((spread / sizes[moving]).max(initial=0.0))
    if not found.autonomous:
        left = max(left, seen.residual)
    if not 0.0 < factor < 1.0:
        return "; a larger longest= follows it further"
    periods = max(np.log(left / protocol.match), 1.0) / -np.log(factor)
    passed = seen.transient_used + 2 * (protocol.record + protocol.evidence)
    more, longest = (float(f"{count:.2g}") for count in (periods, 2.0 * (passed + periods)))
    return (
        f", by a factor {factor:.6g} per period; about {more:.0f} more periods leave"
        f" {protocol.match:g} of it (match=), and longest={longest:.0f} is enough for them"
    )


def _shrinking_factor(looks: Floats, moving: Bools) -> float:
    """Part of the spread of the states that is left after each period, of the slowest state.

    Neighbours tell it less well, as they come closer and part in turn while they do so.
    """
    before, now = (np.ptp(part, axis=0) for part in np.array_split(looks, 2))
    moves = moving & (before > 0.0) & (now > 0.0)
    ratio = float((now[moves] / before[moves]).max(initial=0.0))
    return ratio ** (2.0 / len(looks))


def _long_period(protocol: RegimeProtocol) -> str:
    return (
        f"it has a period of more than {protocol.record // 2} strobes, half the record, for which"
        " record= must be longer"
    )


def _unbounded(label: str, seen: Verdict, found: Evidence, i: int, *, turns: bool) -> str:
    """Why two windows of states contradict the label of motion i, "" where they do not."""
    moving = found.moving[i]
    if not np.any(moving) or (turns and label == labels.QUASI_PERIODIC):
        return ""  # nothing to compare, or a closed curve, which is bounded and does not shrink
    if label == labels.CHAOTIC:
        return "the motion grows tenfold from window to window" if found.run_away[i] else ""
    if not found.autonomous:
        why = found.growing.told(i, found.names)
        why = why or (SHRINKING if found.shrink[i] else "")
        return f"{why}: {_SETTLES}" if why == SHRINKING else why
    earlier, later = np.array_split(found.looks[i][:, moving], 2)
    names, sizes, before = found.names_of(i), found.sizes[i, moving], found.seen_before(i)
    if label == labels.LIMIT_CYCLE:
        turns = seen.events > 0 or bool(np.any(found.angles))
        why = no_closed_orbit(earlier, later, names, sizes, turns, found.match)
    else:
        torus = label == labels.QUASI_PERIODIC
        why = travels(earlier, later, names, before) if torus else ""
        why = why or (SHRINKING if found.shrink[i] else "")
    return f"{why}: {_SETTLES}" if why == SHRINKING else why


def _series(strobes: Floats, moving: Bools) -> Floats:
    """Numbers for the 0-1 test: the states that move, or else the steps of drifts."""
    return strobes[1:, moving] if np.any(moving) else np.diff(strobes, axis=0)


def _mean_rates(growth: Floats, lengths: Floats) -> list[_Rates]:
    """Mean growth per unit time with its standard error; nan for a column that is lost.

    shapes: growth (M, K), lengths (M,) of an interval
    """
    means, errors = np.full(len(growth), -np.inf), np.full(len(growth), np.nan)
    kept = np.all(np.isfinite(growth), axis=1)
    means[kept] = growth[kept].mean(axis=1) / lengths[kept]
    errors[kept] = block_averages(growth[kept].T).standard_error / lengths[kept]
    return list(zip(means.tolist(), errors.tolist(), strict=True))


def _agreeing_test(
    label: str, series: Floats, protocol: RegimeProtocol, *, turns: bool
) -> tuple[StrobeTest, str]:
    """Test of the first state that does not contradict a label, or of the last one, and why.

    Short series mislead where a state hardly moves, or jumps, and others do not. In a survey K is
    not known.
    """
    test, contradiction = StrobeTest(np.nan, np.nan), ""
    for values in series.T:
        test = strobe_test(
            values, asked=not protocol.is_survey, beats=label == labels.QUASI_PERIODIC
        )
        contradiction = labels.contradiction(label, test.k, test.nearest, turns=turns)
        if not contradiction:
            break
    return test, contradiction
