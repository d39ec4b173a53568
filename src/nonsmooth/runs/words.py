"""Phase words: the modes that a run visits, in order.

Modes of zero duration, passed within one instant, are no part of a word. Rebounds that end in rest
count once: how many of infinitely many are followed says nothing of the motion. They have no first
one, so that all impacts at the same exit count, one after the other up to the rest, also those that
are far apart; an event of another sort between them ends the row.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.status import EventKind
from nonsmooth.engine.tables import first_exits
from nonsmooth.errors import OptionError
from nonsmooth.runs.clock import rounding_of_events, rounding_of_logged
from nonsmooth.runs.options import finite_number

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.runs.runner import Outcome
    from nonsmooth.system.system import System

__all__ = [
    "last_period_word", "names_of_modes", "phase_word", "rebounds_of", "word_of_modes",
]  # fmt: skip

_LONGEST = 100  # modes in the attribute of a dataset; the function below has no limit


def phase_word(
    run: xr.Dataset, start: float | None = None, stop: float | None = None
) -> tuple[str, ...]:
    """Modes that a run visits between two times, in order.

    The flights between rebounds that end in rest count as one: there are infinitely many, without
    a first one, so that all impacts at the same exit are meant, one after the other up to the rest.
    Rebounds whose rest comes after ``stop`` count one by one.

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
    exits = [path.split(">") for path in run["event_path"].values[keep][within].astype(str)]
    _, first = np.unique([path[0] for path in exits], return_inverse=True)
    alone = np.array([len(path) == 1 for path in exits], bool)
    rests = kinds[keep][within] == EventKind.CHATTER.word
    rebounds = _rebounds(first.ravel(), alone, rests)
    modes = _without_rebounds(entered[within].astype(int), rebounds, turn=False)
    return tuple(names_of_modes(names, modes))


def last_period_word(system: System, outcome: Outcome) -> str:
    """Word of the last period of a run, of the whole run where there is no period."""
    low = -outcome.tables.window if system.period_value is not None else -np.inf
    times, rounding, rows = _latest(outcome, low)
    rows = rows[_between(times, rounding, low, 0.0)]
    modes = rows["to_mode"].astype(int)
    if modes.size == 0:  # no event since the run went on from an earlier one
        modes = np.array([outcome.anchor.mode])
    return word_of_modes(system, modes, rebounds_of(rows[1:]))


def word_of_modes(
    system: System, modes: npt.NDArray[np.int64], rebounds: npt.NDArray[np.int64]
) -> str:
    """Word of modes entered one after the other; the end of a long one.

    rebounds: of the events between them, as `rebounds_of` has them
    """
    modes = _without_rebounds(modes, np.append(0, rebounds), turn=True)
    text = " ".join(names_of_modes(system.mode_names, modes[-_LONGEST:]))
    return ("... " if modes.size > _LONGEST else "") + text


def rebounds_of(rows: npt.NDArray[Any]) -> npt.NDArray[np.int64]:
    """What each row of the log says of rebounds, in one number.

    Where one exit alone is passed, its number from 1 on; where rebounds end in rest, that of their
    exit with the other sign; 0 otherwise.
    """
    rests = rows["kind"] == EventKind.CHATTER
    return _rebounds(first_exits(rows["path"]), rows["passes"] == 1, rests)


def _rebounds(
    exits: npt.NDArray[np.int64], alone: npt.NDArray[np.bool_], rests: npt.NDArray[np.bool_]
) -> npt.NDArray[np.int64]:
    found = np.where(rests, -1 - exits, np.where(alone, 1 + exits, 0))
    return found.astype(np.int64)


def _without_rebounds(
    modes: npt.NDArray[np.int64], rebounds: npt.NDArray[np.int64], *, turn: bool
) -> npt.NDArray[np.int64]:
    """Modes in which rebounds that end in rest count once: there are infinitely many.

    ``rebounds`` at which the modes are entered. A ``turn`` that begins between rebounds ends
    between them too.
    """
    keep = np.ones(modes.size, bool)
    ends = np.flatnonzero(rebounds < 0)
    for i in map(int, ends):
        _drop_repeated(modes, rebounds == -rebounds[i], keep, i - 1)
    if turn and ends.size and ends[0] > 0:
        first = int(ends[0])
        same = rebounds == -rebounds[first]
        if np.all(modes[:first] == modes[-1]) and same[1:first].all():
            _drop_repeated(modes, same, keep, modes.size - 1)
    return modes[keep]


def _drop_repeated(
    modes: npt.NDArray[np.int64],
    same: npt.NDArray[np.bool_],
    keep: npt.NDArray[np.bool_],
    last: int,
) -> None:
    """Of equal modes in a row up to one of them, each entered by the same exit, keep the first."""
    while last > 0 and modes[last - 1] == modes[last] and same[last]:
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
    """Times of the last events, relative to the end, their rounding, and their rows.

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
            return times, rounding[lasting], rows[lasting]
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
