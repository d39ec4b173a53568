"""The label of a motion that does not repeat: by how its neighbours part, and where it goes."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.regimes import labels
from nonsmooth.analysis.regimes.labels import Verdict
from nonsmooth.analysis.regimes.options import RegimeProtocol
from nonsmooth.analysis.regimes.window import (
    SHRINKING,
    StrobeTest,
    grows,
    no_closed_orbit,
    rest_floor,
    rotation_number,
    run_away,
    shrinks,
    strobe_test,
    travels,
)
from nonsmooth.analysis.settle import Group
from nonsmooth.analysis.statistics.block_averages import block_averages
from nonsmooth.runs.strobe_times import hides_phase
from nonsmooth.system.columns import with_error

__all__ = ["Evidence", "by_growth"]

_SETTLES = "it settles slowly"

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
_Rates: TypeAlias = tuple[float, float]  # a mean with its standard error


@dataclass(frozen=True)
class Evidence:
    """Two windows of M motions and of a neighbour of each; n states, K strobe intervals in both."""

    growth: Floats  # (M, K): logarithms
    strobes: Floats  # (M, K + 1, n)
    looks: Floats  # (M, K, n): one in each interval
    lengths: Floats  # (M,) of an interval
    names: tuple[str, ...]  # of the states
    drifting: Bools  # (n,)
    angles: Bools  # (n,), which come round without being turned back
    sizes: Floats  # (M, n) since the start
    autonomous: bool
    hides_phase: Bools  # (M,): whether strobes see a forcing at different phases
    match: float

    @staticmethod
    def of(
        group: Group, which: Integers, growth: Floats, states: Floats, sizes: Floats, match: float
    ) -> Evidence:
        """Evidence of some motions of a group, (M,), from the states at strobes and looks.

        A motion that is driven has no more looks than strobes.
        """
        lengths, autonomous = group.lengths[which], not group.runner.is_driven
        apart = (states[:, ::2], states[:, 1::2]) if autonomous else (states, states[:, 1:])
        return Evidence(
            growth, *apart, lengths, tuple(group.system.states), group.drifting,
            group.angle_periods > 0.0, sizes, autonomous,
            hides_phase(group.runner.frequencies[which], lengths), match,
        )  # fmt: skip

    def attracting(self, i: int) -> str:
        """Label of motion i where others approach it although its strobes do not repeat.

        Such a motion has a direction without growth; "" where there is none.
        """
        if self.autonomous:
            return labels.LIMIT_CYCLE
        return labels.QUASI_PERIODIC if self.hides_phase[i] else ""

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
    def run_away(self) -> list[bool]:
        """Whether each motion grows without bound."""
        return run_away(*self.windows).tolist()

    @cached_property
    def shrink(self) -> list[bool]:
        """Whether each motion dies away."""
        still = ~self.drifting
        floor = rest_floor(self.looks[..., still], self.sizes[:, still], self.match)
        return shrinks(*self.windows, floor).tolist()


def by_growth(seen: Verdict, found: Evidence, i: int, protocol: RegimeProtocol) -> Verdict:
    """Label of motion i by the growth in each interval, the states at strobes, and one in each."""
    count, length = protocol.evidence, float(found.lengths[i])
    (first, first_error), (second, second_error), (exponent, error) = (
        part[i] for part in found.exponents
    )
    rates, errors = (first, second), (first_error, second_error)
    series = _series(found, i)
    unasked = protocol.is_survey or found.autonomous  # a cycle turns as well between strobes
    rotation = np.nan if unasked else _rotation_number(series)
    turns, attracting = math.isfinite(rotation), found.attracting(i)
    label = labels.label_of_growth(rates, errors, count * length, attracting, turns=turns)
    both = f"{with_error(first, first_error, 3, 2)} and {with_error(second, second_error, 3, 2)}"
    rate, told = exponent, f"exponent {with_error(exponent, error, 3, 2)}"
    if found.autonomous and np.count_nonzero(~found.drifting) < 2:
        rate, told = np.nan, "one state, and no direction across it"
    elif label == labels.LIMIT_CYCLE and not np.isfinite(error):
        told = "no perturbation across the cycle outlives its events"
    elif label == labels.QUASI_PERIODIC and label != attracting:
        rule = _rule(rates, errors, length, rotation, protocol)
        told = f"exponent of two windows, {both}, {rule}"
    why, factor = _unbounded(label, seen, found, i), None
    if not (why or label):
        why = _undecided(rates, errors, both, protocol, autonomous=found.autonomous)
        factor = float(np.exp(exponent * length))
    if why:
        if why.endswith(_SETTLES):
            factor = _shrinking_factor(found.looks[i], found.drifting) if factor is None else factor
            why += _follow_further(factor, seen, found, i, protocol)
        said = f"strobes do not repeat, and {why}"
        return replace(seen, label=labels.UNSETTLED, reason=said, exponent=rate, error=error)
    test, contradiction = _agreeing_test(label, series, protocol, turns=turns)
    seen = replace(seen, exponent=rate, error=error, k=test.k)
    if contradiction:
        return seen.unsettled(f"{told} is {label}, but {contradiction}")
    tested = "without the 0-1 test" if protocol.is_survey else f"K = {test.k:.2f}"
    is_turn = turns and label == labels.QUASI_PERIODIC
    return seen.named(label, told if is_turn else f"{told}, {tested}")


def _rotation_number(series: Floats) -> float:
    """Rotation number of the first state that turns round a circle, nan where none does."""
    found = (rotation_number(values) for values in series.T)
    return next((rotation for rotation in found if np.isfinite(rotation)), np.nan)


def _rule(
    rates: tuple[float, float],
    errors: tuple[float, float],
    length: float,
    rotation: float,
    protocol: RegimeProtocol,
) -> str:
    """Why exponents of two windows are those of quasi-periodic motion."""
    if np.isfinite(rotation):
        turn = with_error(rotation, 0.5 / protocol.evidence, 4, 1)  # as it is on any circle
        return f"strobes keep their order on a circle, with the rotation number {turn}"
    if labels.is_near_zero(rates, errors, protocol.evidence * length):
        return "within three errors of zero"
    return "falls as where neighbours part linearly"


def _undecided(
    rates: tuple[float, float],
    errors: tuple[float, float],
    both: str,
    protocol: RegimeProtocol,
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
    told = f"exponents of two windows, {both}"
    if max(rate + labels.ERRORS * error for rate, error in zip(rates, errors, strict=True)) >= 0.0:
        return f"{told}, decide nothing"
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
    moving = ~found.drifting & (sizes > 0.0)
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


def _shrinking_factor(looks: Floats, drifting: Bools) -> float:
    """Part of the spread of the states that is left after each period, of the slowest state.

    Neighbours tell it less well, as they come closer and part in turn while they do so.
    """
    before, now = (np.ptp(part, axis=0) for part in np.array_split(looks, 2))
    moves = ~drifting & (before > 0.0) & (now > 0.0)
    ratio = float((now[moves] / before[moves]).max(initial=0.0))
    return ratio ** (2.0 / len(looks))


def _unbounded(label: str, seen: Verdict, found: Evidence, i: int) -> str:
    """Why two windows of states contradict the label of motion i, "" where they do not."""
    earlier, later = found.windows[0][i], found.windows[1][i]
    if earlier.shape[1] == 0:
        return ""
    if label == labels.CHAOTIC:
        return "the motion grows tenfold from window to window" if found.run_away[i] else ""
    names = tuple(
        name for name, drifts in zip(found.names, found.drifting, strict=True) if not drifts
    )
    if not found.autonomous:
        still = ~found.drifting
        why = grows(found.strobes[i][:, still], names, found.sizes[i, still])
        if why:
            return why
    if label == labels.LIMIT_CYCLE:
        turns = seen.events > 0 or bool(np.any(found.angles))
        sizes = found.sizes[i, ~found.drifting]
        why = no_closed_orbit(earlier, later, names, sizes, turns, found.match)
    else:
        torus = label == labels.QUASI_PERIODIC and found.autonomous
        why = travels(earlier, later, names) if torus else ""
        why = why or (SHRINKING if found.shrink[i] else "")
    return f"{why}: {_SETTLES}" if why == SHRINKING else why


def _series(found: Evidence, i: int) -> Floats:
    """Numbers for the 0-1 test: the states without drift, or else the steps of drifts."""
    strobes = found.strobes[i]
    moving = strobes[1:, ~found.drifting]
    return moving if moving.shape[1] else np.diff(strobes, axis=0)


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
        test = strobe_test(values, asked=not protocol.is_survey)
        contradiction = labels.contradiction(label, test.k, test.nearest, turns=turns)
        if not contradiction:
            break
    return test, contradiction
