"""Phase words: the modes that a run visits, in order.

Modes of zero duration, passed within one instant, are no part of a word.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.engine import records as at
from nonsmooth.engine.status import EventKind
from nonsmooth.errors import OptionError

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.simulation.runner import Outcome
    from nonsmooth.system.system import System

__all__ = ["last_period_word", "phase_word", "word_of_modes"]

_LONGEST = 100  # modes in the attribute of a dataset; the function below has no limit


def phase_word(
    run: xr.Dataset, start: float | None = None, stop: float | None = None
) -> tuple[str, ...]:
    """Modes that a run visits between two times, in order.

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
    low = -np.inf if start is None else start
    high = np.inf if stop is None else stop
    if high < low:
        raise OptionError(f"stop = {high:g} lies before start = {low:g}")
    if "event_to" not in run:
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
    keep = run["event_kind"].values != EventKind.GRAZE.word
    times, entered = run["event_time"].values[keep], run["event_to"].values[keep]
    return tuple(_merged(names, _modes_between(times, entered, low, high)))


def last_period_word(system: System, outcome: Outcome) -> str:
    """Word of the last period of a run, of the whole run where there is no period."""
    low = -float(outcome.tables.clock[0]) if system.period_value is not None else -np.inf
    modes = _modes_between(*_latest(outcome, low), low, 0.0)
    if modes.size == 0:  # no event since the run went on from an earlier one
        modes = outcome.anchor.place[1:2]
    return word_of_modes(system.mode_names, modes)


def word_of_modes(names: Sequence[str], modes: np.ndarray, *, whole: bool = False) -> str:
    """Word of modes entered one after the other; the end of a long one, if not the ``whole``."""
    if whole:
        return " ".join(_merged(names, modes))
    text = " ".join(_merged(names, modes[-_LONGEST:]))
    return ("... " if modes.size > _LONGEST else "") + text


def _merged(names: Sequence[str], modes: np.ndarray) -> Iterator[str]:
    """Names in order; a cell that follows another one of its name is no new word."""
    before = -1
    for mode in modes:
        if before in (-1, mode) or names[mode] != names[before]:
            yield names[mode]
        before = int(mode)


def _latest(outcome: Outcome, low: float) -> tuple[np.ndarray, np.ndarray]:
    """Times, relative to the end, and modes entered of the last events.

    All since ``low``, or enough for a word: a run may be long, and its last period is short,
    so the log is read from its end.
    """
    window, end = float(outcome.tables.clock[0]), outcome.end
    count = 2 * _LONGEST
    while True:
        rows, phase = outcome.event_integers[-count:], outcome.event_floats[-count:, at.PHASE]
        lasting = rows[:, at.KIND] != EventKind.GRAZE
        if outcome.history is None:
            times = (rows[:, at.NUMBER] - end.number) * window + (phase - end.phase)
        else:
            times = outcome.times(rows[:, at.NUMBER], phase) - outcome.end_time
        times = times[lasting]
        before = int(np.searchsorted(times, 0.0))
        enough = before > _LONGEST + 1 or (before > 0 and times[0] <= low)
        if enough or count >= len(outcome.event_integers):
            return times, rows[lasting, at.TO]
        count *= 4


def _modes_between(times: np.ndarray, entered: np.ndarray, low: float, high: float) -> np.ndarray:
    first = int(np.searchsorted(times, low, side="right"))
    last = int(np.searchsorted(times, high, side="left"))
    return entered[max(0, first - 1) : max(last, first)].astype(int)
