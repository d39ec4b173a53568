"""The label of a motion that does not repeat: by how its neighbours part, and where it goes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.regimes import labels
from nonsmooth.analysis.regimes.labels import Verdict
from nonsmooth.analysis.regimes.options import RegimeProtocol
from nonsmooth.analysis.regimes.window import (
    SHRINKING,
    StrobeTest,
    no_closed_orbit,
    rest_floor,
    rotation_number,
    runs_away,
    shrinks,
    strobe_test,
    travels,
)
from nonsmooth.analysis.statistics.block_averages import block_averages
from nonsmooth.system.columns import with_error

__all__ = ["Evidence", "by_growth"]

_SETTLES = "it settles slowly"

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Evidence:
    """Two windows of a motion and of a neighbour; n states, K strobe intervals in both windows."""

    growth: Floats  # (K,): logarithms
    strobes: Floats  # (K + 1, n)
    looks: Floats  # (K, n): one in each interval
    length: float  # of an interval
    names: tuple[str, ...]  # of the states
    drifting: npt.NDArray[np.bool_]  # (n,)
    angles: npt.NDArray[np.bool_]  # (n,), which come round without being turned back
    sizes: Floats  # (n,) since the start
    autonomous: bool
    hides_phase: bool  # whether strobes see a forcing at different phases

    @property
    def attracting(self) -> str:
        """Label of a motion that others approach although its strobes do not repeat.

        Such a motion has a direction without growth; "" where there is none.
        """
        if self.autonomous:
            return labels.LIMIT_CYCLE
        return labels.QUASI_PERIODIC if self.hides_phase else ""


def by_growth(seen: Verdict, found: Evidence, protocol: RegimeProtocol) -> Verdict:
    """Label by the growth in each interval, the states at the strobes, and one in each."""
    count, length = protocol.evidence, found.length
    windows = [_mean_rate(part, length) for part in (found.growth[:count], found.growth[count:])]
    (first, first_error), (second, second_error) = windows
    rates, errors = (first, second), (first_error, second_error)
    series = _series(found)
    unasked = protocol.is_survey or found.autonomous  # a cycle turns as well between strobes
    rotation = np.nan if unasked else _rotation_number(series)
    turns = bool(np.isfinite(rotation))
    label = labels.label_of_growth(rates, errors, count * length, found.attracting, turns=turns)
    exponent, error = _mean_rate(found.growth, length)
    seen = replace(seen, exponent=exponent, error=error)
    both = f"{with_error(first, first_error, 3, 2)} and {with_error(second, second_error, 3, 2)}"
    told = f"exponent {with_error(exponent, error, 3, 2)}"
    if found.autonomous and np.count_nonzero(~found.drifting) < 2:
        seen, told = replace(seen, exponent=np.nan), "one state, and no direction across it"
    elif label == labels.LIMIT_CYCLE and not np.isfinite(error):
        told = "no perturbation across the cycle outlives its events"
    elif label == labels.QUASI_PERIODIC and label != found.attracting:
        rule = _rule(rates, errors, length, rotation, protocol)
        told = f"exponent of two windows, {both}, {rule}"
    why, factor = _unbounded(label, seen, found, protocol.match), _shrinking_factor(found)
    if not (why or label):
        why = _undecided(rates, errors, both, protocol, autonomous=found.autonomous)
        factor = float(np.exp(exponent * length))
    if why:
        if why.endswith(_SETTLES):
            why += _follow_further(factor, seen, found, protocol)
        return seen.unsettled(f"strobes do not repeat, and {why}")
    test, contradiction = _agreeing_test(label, series, protocol, turns=turns)
    seen = replace(seen, k=test.k)
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


def _follow_further(factor: float, seen: Verdict, found: Evidence, protocol: RegimeProtocol) -> str:
    """For how long to follow a motion of which a factor is left after each period.

    It has settled where what is left is ``match`` of its size. The transient is doubled, so some
    doubling of it lies between that time and twice as much.
    """
    moving = ~found.drifting & (found.sizes > 0.0)
    spread = np.ptp(found.looks[len(found.looks) // 2 :, moving], axis=0)
    left = float((spread / found.sizes[moving]).max(initial=0.0))
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


def _shrinking_factor(found: Evidence) -> float:
    """Part of the spread of the states that is left after each period, of the slowest state.

    Neighbours tell it less well, as they come closer and part in turn while they do so.
    """
    before, now = (np.ptp(part, axis=0) for part in np.array_split(found.looks, 2))
    moves = ~found.drifting & (before > 0.0) & (now > 0.0)
    ratio = float((now[moves] / before[moves]).max(initial=0.0))
    return ratio ** (2.0 / len(found.looks))


def _unbounded(label: str, seen: Verdict, found: Evidence, match: float) -> str:
    """Why two windows of states contradict a label, "" where they do not."""
    moving = found.looks[:, ~found.drifting]
    if moving.shape[1] == 0:
        return ""
    earlier, later = np.array_split(moving, 2)
    if label == labels.CHAOTIC:
        return runs_away(earlier, later)
    names = tuple(
        name for name, drifts in zip(found.names, found.drifting, strict=True) if not drifts
    )
    sizes = found.sizes[~found.drifting]
    if label == labels.LIMIT_CYCLE:
        turns = seen.events > 0 or bool(np.any(found.angles))
        why = no_closed_orbit(earlier, later, names, sizes, turns, match)
    else:
        torus = label == labels.QUASI_PERIODIC and found.autonomous
        why = travels(earlier, later, names) if torus else ""
        why = why or shrinks(earlier, later, rest_floor(moving, sizes, match))
    return f"{why}: {_SETTLES}" if why == SHRINKING else why


def _series(found: Evidence) -> Floats:
    """Numbers for the 0-1 test: the states without drift, or else the steps of drifts."""
    moving = found.strobes[1:, ~found.drifting]
    return moving if moving.shape[1] else np.diff(found.strobes, axis=0)


def _mean_rate(growth: Floats, length: float) -> tuple[float, float]:
    """Mean growth per unit time with its standard error; nan for a column that is lost."""
    if not np.all(np.isfinite(growth)):
        return -np.inf, np.nan
    error = float(block_averages(growth[:, None]).standard_error[0])
    return float(growth.mean()) / length, error / length


def _agreeing_test(
    label: str, series: Floats, protocol: RegimeProtocol, *, turns: bool
) -> tuple[StrobeTest, str]:
    """Test of the first state that does not contradict a label, or of the last one, and why.

    Short series mislead where a state hardly moves, or jumps, and others do not. In a survey K is
    not known.
    """
    test, contradiction = StrobeTest(np.nan, np.nan), ""
    for values in series.T:
        test = strobe_test(values)
        if protocol.is_survey:
            test = test._replace(k=np.nan)
        contradiction = labels.contradiction(label, test.k, test.nearest, turns=turns)
        if not contradiction:
            break
    return test, contradiction
