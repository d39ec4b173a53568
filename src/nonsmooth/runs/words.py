"""Phase words: the modes that a run visits, in order.

Modes of zero duration, passed within one instant, are no part of a word. Rebounds that accumulate
count once: how many of infinitely many are followed says nothing of the motion.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.status import EventKind
from nonsmooth.engine.tables import RESTING
from nonsmooth.errors import OptionError
from nonsmooth.runs.clock import rounding_of_events, rounding_of_logged
from nonsmooth.runs.options import finite_number

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.runs.runner import Outcome
    from nonsmooth.system.system import System

__all__ = [
    "last_period_word", "names_of_modes", "phase_word", "without_rebounds", "word_of_modes",
]  # fmt: skip

_LONGEST = 100  # modes in the attribute of a dataset; the function below has no limit


def phase_word(
    run: xr.Dataset, start: float | None = None, stop: float | None = None
) -> tuple[str, ...]:
    """Modes that a run visits between two times, in order.

    The flights between rebounds that end in rest count as one: there are infinitely many.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `simulate`.
    start, stop : float, optional
        Times; the whole run by default. The mode in force at ``start`` comes first.

    Returns
    -------
    tuple of str
        Names of modes.

    Raises
    ------
    OptionError
        When ``stop`` is before ``start``, or the run was made with ``events=False``.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.moling(a=0.3, b=0.15, xi=0.05, omega=0.1), periods=20)
    >>> T = run.attrs["period"]
    >>> ns.phase_word(run, 18.25 * T, 19.25 * T)
    ('no_contact', 'contact', 'progression', 'contact', 'no_contact')
    """
    low, high = _time("start", start, -np.inf), _time("stop", stop, np.inf)
    if high < low:
        raise OptionError(f"stop = {high:g} lies before start = {low:g}")
    if "event_to" not in getattr(run, "variables", ()):
        raise OptionError(
            "the dataset has no event log; simulate without events=False, or read the word of the"
            " last period in its attribute 'phase_word'"
        )
    names = run["event_to"].attrs.get("flag_meanings", "").split()
    if not names:
        raise OptionError(
            "the variable 'event_to' has lost its attribute 'flag_meanings', the names of modes;"
            " keep the attributes of the run, as with xarray.set_options(keep_attrs=True)"
        )
    kinds = run["event_kind"].values
    keep = kinds != EventKind.GRAZE.word
    times, entered = run["event_time"].values[keep], run["event_to"].values[keep]
    rounding = rounding_of_logged(run)[keep]
    within = _between(times, rounding, low, high)
    rests = kinds[keep][within] == EventKind.CHATTER.word
    modes = without_rebounds(entered[within].astype(int), rests, turn=False)
    return tuple(names_of_modes(names, modes))


def last_period_word(system: System, outcome: Outcome) -> str:
    """Word of the last period of a run, of the whole run where there is no period."""
    low = -outcome.tables.window if system.period_value is not None else -np.inf
    times, rounding, entered = _latest(outcome, low)
    modes = entered[_between(times, rounding, low, 0.0)].astype(int)
    if modes.size == 0:  # no event since the run went on from an earlier one
        modes = np.array([outcome.anchor.mode])
    return word_of_modes(system, modes)


def word_of_modes(system: System, modes: npt.NDArray[np.int64]) -> str:
    """Word of modes entered one after the other; the end of a long one."""
    rests = system.compiled.program.wiring.modes["kind"][modes] == RESTING
    modes = without_rebounds(modes, rests, turn=True)
    text = " ".join(names_of_modes(system.mode_names, modes[-_LONGEST:]))
    return ("... " if modes.size > _LONGEST else "") + text


def without_rebounds(
    modes: npt.NDArray[np.int64], rests: npt.NDArray[np.bool_], *, turn: bool
) -> npt.NDArray[np.int64]:
    """Modes in which rebounds that accumulate count once: there are infinitely many.

    ``rests``: which modes they end in. A ``turn`` that begins between them ends between them too.
    """
    keep = np.ones(modes.size, bool)
    ends = np.flatnonzero(rests)
    for i in ends:
        _drop_repeated(modes, keep, int(i) - 1)
    if turn and ends.size and ends[0] > 0 and np.all(modes[: ends[0]] == modes[-1]):
        _drop_repeated(modes, keep, modes.size - 1)
    return modes[keep]


def _drop_repeated(modes: npt.NDArray[np.int64], keep: npt.NDArray[np.bool_], last: int) -> None:
    """Of equal modes in a row up to one of them, keep the first."""
    while last > 0 and modes[last - 1] == modes[last]:
        keep[last] = False
        last -= 1


def names_of_modes(names: Sequence[str], modes: npt.NDArray[np.int64]) -> Iterator[str]:
    """Names in order; a cell that follows another one of its name is no new word."""
    before = -1
    for mode in modes:
        if before in (-1, mode) or names[mode] != names[before]:
            yield names[mode]
        before = int(mode)


def _latest(outcome: Outcome, low: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times of the last events, relative to the end, their rounding, and modes entered.

    All since ``low``, or enough for a word: a run may be long, and its last period is short,
    so the log is read from its end.
    """
    window, end = outcome.tables.window, outcome.end
    count = 2 * _LONGEST
    while True:
        rows, phase = outcome.events[-count:], outcome.events["phase"][-count:]
        lasting = rows["kind"] != EventKind.GRAZE
        if outcome.history is None:
            times = (rows["number"] - end.number) * window + (phase - end.phase)
        else:
            times = outcome.times(rows["number"], phase) - outcome.end_time
        times = times[lasting]
        before = int(np.searchsorted(times, 0.0))
        enough = before > _LONGEST + 1 or (before > 0 and times[0] <= low)
        if enough or count >= len(outcome.events):
            rounding = rounding_of_events(rows["number"], phase, window)
            return times, rounding[lasting], rows["to_mode"][lasting]
        count *= 4


def _time(name: str, value: Any, unbounded: float) -> float:
    """A time, or one without a bound."""
    if value is None or (isinstance(value, float) and value == unbounded):
        return unbounded
    return finite_number(name, value)


def _between(times: np.ndarray, rounding: np.ndarray, low: float, high: float) -> slice:
    """Events between two times, with the last one before: it has led to where that begins.

    One at the first time, up to rounding, leads there too; one at the other is not before it.
    """
    first = int(np.searchsorted(times - rounding, low, side="right"))
    last = int(np.searchsorted(times + rounding, high, side="left"))
    return slice(max(0, first - 1), max(last, first))
