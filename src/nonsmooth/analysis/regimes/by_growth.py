"""The label of a motion that does not repeat: by how its neighbours part, and where it goes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.regimes import labels
from nonsmooth.analysis.regimes.labels import Verdict
from nonsmooth.analysis.regimes.options import RegimeProtocol
from nonsmooth.analysis.regimes.window import (
    StrobeTest,
    no_closed_orbit,
    rest_floor,
    runs_away,
    shrinks,
    strobe_test,
    travels,
)
from nonsmooth.analysis.statistics.block_averages import block_averages
from nonsmooth.system.columns import with_error

__all__ = ["Evidence", "by_growth"]

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
    label = labels.label_of_growth(rates, errors, count * length, found.attracting)
    exponent, error = _mean_rate(found.growth, length)
    seen = replace(seen, exponent=exponent, error=error)
    both = f"{with_error(first, first_error, 3, 2)} and {with_error(second, second_error, 3, 2)}"
    told = f"exponent {with_error(exponent, error, 3, 2)}"
    if found.autonomous and np.count_nonzero(~found.drifting) < 2:
        seen, told = replace(seen, exponent=np.nan), "one state, and no direction across it"
    elif label == labels.LIMIT_CYCLE and not np.isfinite(error):
        told = "no perturbation across the cycle outlives its events"
    elif label == labels.QUASI_PERIODIC and label != found.attracting:
        near = labels.is_near_zero(rates, errors, count * length)
        rule = "within three errors of zero" if near else "falls as where neighbours part linearly"
        told = f"exponent of two windows, {both}, {rule}"
    why = _unbounded(label, seen, found, protocol.match)
    if why:
        return seen.unsettled(f"strobes do not repeat, and {why}")
    if not label:
        return seen.unsettled(f"strobes do not repeat, and {_undecided(rates, both, protocol)}")
    test, contradiction = _agreeing_test(label, _series(found), protocol)
    seen = replace(seen, k=test.k)
    if contradiction:
        return seen.unsettled(f"{told} is {label}, but {contradiction}")
    tested = "without the 0-1 test" if protocol.is_survey else f"K = {test.k:.2f}"
    return seen.named(label, f"{told}, {tested}")


def _undecided(rates: tuple[float, float], both: str, protocol: RegimeProtocol) -> str:
    """Why exponents of two windows give no label."""
    if rates == (-np.inf, -np.inf):
        longest = protocol.record // 2
        return (
            "every perturbation is lost within a window: the motion is locked, with a period of"
            f" more than {longest} strobes, half the record, or is about to be; give a longer"
            f" record= than {protocol.record}"
        )
    return f"exponents of two windows, {both}, decide nothing"


def _unbounded(label: str, seen: Verdict, found: Evidence, match: float) -> str:
    """Why two windows of states contradict a label, "" where they do not."""
    moving = found.looks[:, ~found.drifting]
    if moving.shape[1] == 0:
        return ""
    earlier, later = np.array_split(moving, 2)
    if label == labels.CHAOTIC:
        return runs_away(earlier, later)
    if not found.autonomous:
        return ""
    names = tuple(
        name for name, drifts in zip(found.names, found.drifting, strict=True) if not drifts
    )
    sizes = found.sizes[~found.drifting]
    if label == labels.LIMIT_CYCLE:
        return no_closed_orbit(earlier, later, names, sizes, seen.events > 0, match)
    floor = rest_floor(moving, sizes, match)
    goes = travels(earlier, later, names) if label == labels.QUASI_PERIODIC else ""
    return goes or shrinks(earlier, later, floor)


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
