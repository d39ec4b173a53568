"""Initial velocities that make a run of the mole graze: solved for with the 50-digit route."""

from collections.abc import Callable, Mapping
from typing import Any

from mpmath import mp, mpf

from .mole import DIGITS, MoleRun, mole_events
from .roots import bracketed_root

N_PERIODS = 2


@mp.workdps(DIGITS)
def hit(parameters: Mapping[str, Any], low: float, high: float, rate: Any) -> float:
    """The y0 next to a graze between ``low`` and ``high`` for which one guard falls at ``rate``.

    The sequence of events must differ between the two, by one graze.
    """
    run = _runner(parameters)
    missing, hitting = _bisect(run, mpf(low), mpf(high))
    number = _slowest(run(hitting))

    def excess(y0: mpf) -> mpf:
        return abs(run(y0).guard_rates[number]) - mpf(rate)

    away = hitting + (hitting - missing)
    while excess(away) < 0:
        away += away - missing
    return float(bracketed_root(excess, *sorted((hitting, away))))


@mp.workdps(DIGITS)
def miss(parameters: Mapping[str, Any], low: float, high: float, depth: Any) -> float:
    """The y0 on the other side of that graze, where the guard stays ``depth`` above zero."""
    run = _runner(parameters)
    missing, hitting = _bisect(run, mpf(low), mpf(high))

    def excess(y0: mpf) -> mpf:
        return run(y0).nearest_miss - mpf(depth)

    away = missing + (missing - hitting)
    while excess(away) < 0:
        away += away - hitting
    return float(bracketed_root(excess, *sorted((missing, away))))


def _runner(parameters: Mapping[str, Any]) -> Callable[[mpf], MoleRun]:
    return lambda y0: mole_events(parameters, {"y": y0}, N_PERIODS)


def _bisect(run: Callable[[mpf], MoleRun], low: mpf, high: mpf) -> tuple[mpf, mpf]:
    """Two neighbours, the first of which misses what the second hits."""
    words = [_word(run(low)), _word(run(high))]
    while high - low > mpf(10) ** -14:
        middle = (low + high) / 2
        word = _word(run(middle))
        if word == words[0]:
            low = middle
        elif word == words[1]:
            high = middle
        else:
            raise ValueError("more than one change of the events in this range")
    return (low, high) if _slowest_rate(run(low)) > _slowest_rate(run(high)) else (high, low)


def _word(run: MoleRun) -> list[tuple[str, str]]:
    return [(mode_from, mode_to) for _, mode_from, mode_to in run.events]


def _slowest(run: MoleRun) -> int:
    return min(range(len(run.guard_rates)), key=lambda i: abs(run.guard_rates[i]))


def _slowest_rate(run: MoleRun) -> mpf:
    return abs(run.guard_rates[_slowest(run)])
