"""Options of a regime: how long a motion is followed, and when it is looked at."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from nonsmooth.analysis.options import check_match
from nonsmooth.errors import OptionError
from nonsmooth.runs.options import check_count, whole_number
from nonsmooth.runs.strobe_times import check_phase, require_period, require_repeats
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.system.system import System

__all__ = ["TESTED", "RegimeProtocol", "check_system", "make_protocol"]

TESTED = 200  # strobes of evidence from which the 0-1 test says something
_LEAST_EVIDENCE = 20  # strobes of which averages of an exponent can be told apart
_DOUBLINGS = 16  # of the transient, as a factor, where no longest one is given


@dataclass(frozen=True)
class RegimeProtocol:
    """How a motion is looked at; lengths in strobes."""

    transient: int
    record: int
    evidence: int
    longest: int
    confirm: int  # strobes for which a motion without an end is run on
    phase: float
    match: float

    @property
    def is_survey(self) -> bool:
        """Whether exponents alone decide, as there are too few strobes for the 0-1 test."""
        return self.evidence < TESTED


def make_protocol(
    transient: Any,
    record: Any,
    evidence: Any,
    longest: Any,
    confirm: Any,
    phase: Any,
    match: Any,
) -> RegimeProtocol:
    """RegimeProtocol of these options, all of them checked."""
    left_out = whole_number("transient", transient, 0)
    kept = whole_number("record", record)
    if kept < 2:
        raise OptionError("record = 1: a period has to be seen twice; give 2 strobes at least")
    window = whole_number("evidence", evidence)
    if window < _LEAST_EVIDENCE:
        raise OptionError(
            f"evidence = {window}: give {_LEAST_EVIDENCE} strobes at least; a survey by exponents"
            f" alone takes fewer than {TESTED}, and the 0-1 test joins them from there on"
        )
    most = _DOUBLINGS * max(left_out, kept) if longest is None else whole_number("longest", longest)
    if most < left_out:
        raise OptionError(
            f"longest = {most} is less than transient = {left_out}, from which the transient is"
            " doubled"
        )
    more = whole_number("confirm", confirm, 0)
    check_count(most + 4 * window + more)
    close = check_match(match)
    return RegimeProtocol(left_out, kept, window, most, more, check_phase(phase), close)


def check_system(system: System, period: Any, verb: str) -> None:
    """Refuse what cannot settle, and systems that nobody says when to look at."""
    if system.slow:
        raise OptionError(
            f"{verb}: the parameters in slow= change from period to period, so nothing settles;"
            " leave slow= out"
        )
    require_repeats(system, verb)
    if period is None:
        require_period(system, verb)
    StroboscopicMap(system, period=period).check_whole_periods()
