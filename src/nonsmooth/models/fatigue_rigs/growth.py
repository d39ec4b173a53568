"""Lengths through which a growing crack goes, at which a rig is looked at for lost contact."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from nonsmooth.errors import OptionError
from nonsmooth.system.text.evaluate import evaluate
from nonsmooth.system.text.expressions import names_in
from nonsmooth.system.text.grammar import parse

__all__ = ["Reached", "lengths_to_check"]

_WIDTH = 20.0  # mm, of the chapter's specimen
_LONGEST = 19.0  # mm; beyond it the specimen is all but through
_APART = 2.0  # mm between two lengths at most
# of any run, in units of time, each some per cent after the one before
_TIMES = np.array([0.0, *np.geomspace(0.1, 1e10, 1000)])


class Reached(NamedTuple):
    """A length in mm, and a time by which the crack has had it."""

    length: float
    time: float


def lengths_to_check(growth: str) -> list[Reached]:
    """Lengths that a crack has from t = 0 until it is through, the first one at the start."""
    rule = parse(growth, where="growth")
    if others := sorted({each.name for each in names_in(rule)} - {"t", "pi"}):
        raise OptionError(f"growth = {growth!r:.60} uses {others[0]!r}; give a text of t alone")
    lengths = np.broadcast_to(evaluate(rule, {"t": _TIMES}), _TIMES.shape)
    first = float(lengths[0])
    fits = (lengths >= 0.0) & (lengths < _WIDTH)  # nan does not
    if not fits[0]:
        return [Reached(first, 0.0)]
    ends = len(fits) if fits.all() else int(np.argmin(fits))
    # between two looks it went all the way
    seen = [*lengths[:ends], *np.clip(lengths[ends : ends + 1], 0.0, _WIDTH)]
    seen = [float(each) for each in seen if math.isfinite(each)]
    low, high = min(seen), max(min(max(seen), _LONGEST), first)
    count = 1 + math.ceil((high - low) / _APART)
    wanted = {first, *map(float, np.linspace(low, high, count))}
    times = {length: _first_time(seen, length) for length in wanted}
    return sorted((Reached(*pair) for pair in times.items()), key=lambda each: each.time)


def _first_time(seen: list[float], length: float) -> float:
    """First of the times by which the crack has gone from its first length past this one."""
    way = length - seen[0]
    gone = (np.array(seen) - seen[0]) * np.sign(way) >= abs(way) * (1.0 - 1e-12)
    return float(_TIMES[int(np.argmax(gone))])
