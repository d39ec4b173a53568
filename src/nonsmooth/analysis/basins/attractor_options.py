"""How attractors are looked for: the options of a search."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from nonsmooth.errors import OptionError
from nonsmooth.runs.options import finite_number, whole_number

__all__ = ["Search", "read_search"]


@dataclass(frozen=True)
class Search:
    """How attractors are looked for."""

    samples: int
    seed: int
    cells: int
    longest: int
    record: int
    match: float
    tolerance: float

    @property
    def options(self) -> dict[str, Any]:
        """As attributes of a result."""
        return dict(vars(self))


def read_search(
    samples: Any, seed: Any, cells: Any, longest: Any, record: Any, match: Any, tolerance: float
) -> Search:
    """Options of a search, checked."""
    close = finite_number("match", match)
    if not 0.0 < close < 1.0:
        raise OptionError(f"match = {close:g} must lie between 0 and 1; 1e-6 is usual")
    start = finite_number("seed", seed)
    if start != int(start) or start < 0:
        raise OptionError(f"seed = {seed!r:.60} must be a whole number, not negative")
    return Search(
        whole_number("samples", samples), int(start), whole_number("cells", cells),
        whole_number("longest", longest), whole_number("record", record), close, float(tolerance),
    )  # fmt: skip
