"""Options of `orbits`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nonsmooth.analysis.basins.region import read_box
from nonsmooth.analysis.orbit_search.collect import HowToCollect
from nonsmooth.analysis.orbit_search.options import read_wanted
from nonsmooth.errors import OptionError
from nonsmooth.periodic_orbits.orbit import OrbitRequest
from nonsmooth.runs.options import check_flag, finite_number, whole_number

__all__ = ["read_many"]

_LONGEST = 1000


def read_many(
    system: Any, region: Any, *, longest: Any, initial: Any, completion: Any, samples: Any,
    seed: Any, guesses: Any, record: Any, match: Any, inadmissible: Any,
    parameters: Mapping[str, float] | None, **rest: Any,
) -> tuple[OrbitRequest, HowToCollect]:  # fmt: skip
    """What is looked for, and how."""
    wanted, _ = read_wanted(
        system, initial, period=1, word=None, parameters=parameters, verb="orbits", **rest
    )
    longest = whole_number("longest", longest)
    if longest * wanted.period > _LONGEST:
        raise OptionError(f"longest = {longest}: at most {_LONGEST // wanted.period}")
    if wanted.period > 1:
        raise OptionError(
            f"system: the map leads {wanted.period} periods on, and orbits are those of the"
            " forcing; give a map with every=1"
        )
    close = finite_number("match", match)
    if not 0.0 < close < 1.0:
        raise OptionError(f"match = {close:g} must lie between 0 and 1; 1e-6 is usual")
    start = finite_number("seed", seed)
    if start != int(start) or start < 0:
        raise OptionError(f"seed = {seed!r:.60} must be a whole number, not negative")
    if region is None and completion is not None:
        raise OptionError("completion= is for states outside the region; give region= with it")
    box = None if region is None else read_box(wanted.system, region, completion)
    how = HowToCollect(
        longest, whole_number("record", record), whole_number("samples", samples),
        whole_number("guesses", guesses), int(start), close,
        check_flag("inadmissible", inadmissible), box,
    )  # fmt: skip
    return wanted, how
