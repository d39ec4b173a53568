"""Colours of periods and of other regimes: one scale for diagrams, maps and basins.

Periods go from yellow by red to dark purple, along the colours "inferno" of matplotlib (S. van
der Walt and N. Smith, 2015), so that a longer period is darker whatever colours one can see. Steps
are longest where periods double, from 1 to 2 and 2 to 4. What has no period is blue, green or grey,
and chaos is black: a motion that has *not settled* is a blue that no period comes near to.

The colours were chosen so that the two that are most alike lie as far apart as they can, for full
colour vision and without one kind of cones; a test has the distances.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

__all__ = [
    "LONGER",
    "NOT_SETTLED",
    "OTHER_REGIMES",
    "PERIODS",
    "REGIME_COLOURS",
    "by_period",
    "colour_of_motion",
]

PERIODS = {
    1: "#F6D543", 2: "#FA9008", 3: "#EF6C23", 4: "#DB503B", 5: "#C73E4C", 6: "#B1325A",
    7: "#9A2865", 8: "#7F1E6C",
}  # fmt: skip
LONGER = "#550F6D"
NOT_SETTLED = "#6697E8"
OTHER_REGIMES = {
    "equilibrium": "#2ECC89",
    "locked": "#0E6FB0",
    "limit-cycle": "#2A30B3",
    "quasi-periodic": "#7F8D94",
    "chaotic": "#000000",
    "absorbed": "#DCDCDC",
    "unsettled": NOT_SETTLED,
}
REGIME_COLOURS = {
    **{f"period {n}": colour for n, colour in PERIODS.items()},
    f"period > {len(PERIODS)}": LONGER,
    **OTHER_REGIMES,
}

Mask = npt.NDArray[np.bool_]


def colour_of_motion(period: int, kind: str) -> str:
    """Colour of a motion of a period, or of a kind where it has none."""
    if period > 0:
        return PERIODS.get(period, LONGER)
    return OTHER_REGIMES.get(kind, NOT_SETTLED)


def by_period(periods: npt.NDArray[np.int64], where: Mask) -> Iterator[tuple[str, str, Mask]]:
    """Name, colour and place of each period, in order; ``where`` are the periodic motions."""
    for n, colour in PERIODS.items():
        yield f"period {n}", colour, where & (periods == n)
    yield f"period > {len(PERIODS)}", LONGER, where & (periods > len(PERIODS))
