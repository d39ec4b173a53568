"""Rules by which a claim of the chapter is judged, fixed before anything was computed.

A check computes evidence afresh, its predicate looks at the evidence alone and says whether
the claim is true. What follows from that, with the data the chapter lacks, is decided here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from nonsmooth import OptionError

__all__ = ["DIFFERS", "HOLDS", "OPEN", "Check", "Finding", "agreed", "agrees", "verdict"]

HOLDS, DIFFERS, OPEN = "holds", "differs", "not determinable"

Evidence = dict[str, Any]


@dataclass(frozen=True)
class Finding:
    """What a predicate made of the evidence.

    Parameters
    ----------
    true : bool or None
        Whether the claim is true in every case it names; None when admissible readings of
        the chapter disagree.
    computed : str
        One or two sentences with our values.
    for_all : str, optional
        Range of the missing data for all of which the finding was shown.

    Examples
    --------
    >>> Finding(true=False, computed="31.0 Hz, printed 15.5 Hz").true
    False
    """

    true: bool | None
    computed: str
    for_all: str = ""


@dataclass(frozen=True)
class Check:
    """How one claim is judged.

    Parameters
    ----------
    claim : str
        Its name, such as ``"M03"``.
    protocol : str
        Initial state, restart or following, what was dropped and kept.
    compute : callable
        Evidence as a mapping of names to numbers, lists and texts. Every argument has a
        default: what the chapter prints, or what ``protocol`` says.
    judge : callable
        The predicate: from that evidence, and nothing else, to a `Finding`.

    Examples
    --------
    >>> check = Check(
    ...     "X1", "arithmetic", lambda n=2: {"n": n}, lambda e: Finding(e["n"] == 2, str(e["n"]))
    ... )
    >>> check.judge(check.compute(n=3)).true
    False
    """

    claim: str
    protocol: str
    compute: Callable[..., Evidence]
    judge: Callable[[Evidence], Finding]


def verdict(finding: Finding, *, lacks_data: bool) -> str:
    """Verdict from a finding: holds, differs or not determinable.

    Parameters
    ----------
    finding : Finding
        What the predicate found.
    lacks_data : bool
        Whether the chapter lacks data that the judgement needs.

    Returns
    -------
    str
        ``"holds"``, ``"differs"`` or ``"not determinable"``.

    Examples
    --------
    >>> verdict(Finding(True, ""), lacks_data=False)
    'holds'
    >>> verdict(Finding(True, ""), lacks_data=True)
    'not determinable'
    >>> verdict(Finding(False, "", for_all="xi from 0.01 to 1"), lacks_data=True)
    'differs'
    """
    if finding.true is None or (lacks_data and not finding.for_all):
        return OPEN
    return HOLDS if finding.true else DIFFERS


def agrees(value: float, printed: str, *, about: float = 0.0, step: float = 0.0) -> bool:
    """Whether a value agrees with a printed number.

    Within one unit of the last printed digit; after words such as "about" within a share of
    the number or the step of the sweep it was read from, whichever is larger.

    Parameters
    ----------
    value : float
        Our value.
    printed : str
        The number as printed, with its digits.
    about : float, optional
        Share of the number that "about" allows, 0.02 or for ratios of forces 0.1.
    step : float, optional
        Step of the sweep from which the number was read.

    Returns
    -------
    bool

    Examples
    --------
    >>> agrees(13.9, "13.2"), agrees(13.25, "13.2"), agrees(13.4, "13.2", about=0.02)
    (False, True, True)
    """
    number = Decimal(printed)
    exponent = number.as_tuple().exponent
    if not isinstance(exponent, int):
        raise OptionError(f"printed = {printed!r} is not a finite number")
    unit = Decimal(1).scaleb(exponent)
    if not about and not step:
        # decimals, so that a value printed with the same digits differs by exactly one unit
        return abs(Decimal(repr(float(value))) - number) <= unit
    allowed = max(about * abs(float(number)), step, float(unit))
    return abs(value - float(number)) <= allowed


def agreed(readings: Iterable[bool]) -> bool | None:
    """What all readings say, None where they disagree.

    Parameters
    ----------
    readings : iterable of bool
        One for each protocol or reading.

    Returns
    -------
    bool or None

    Examples
    --------
    >>> agreed([True, True]), agreed([True, False])
    (True, None)
    """
    found = {bool(reading) for reading in readings}
    return found.pop() if len(found) == 1 else None
