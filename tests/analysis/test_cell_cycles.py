"""Cycles of maps of whole numbers, against following every number."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from nonsmooth.analysis.basins.by_cell_mapping import cycles_of


def _followed(image: list[int], start: int) -> tuple[frozenset[int], int]:
    """The cycle to which a number comes, empty for none, and the steps until then."""
    seen: dict[int, int] = {}
    here = start
    while here >= 0 and here not in seen:
        seen[here] = len(seen)
        here = image[here]
    if here < 0:
        return frozenset(), len(seen)
    cycle = frozenset(i for i, k in seen.items() if k >= seen[here])
    return cycle, seen[here]


@given(st.lists(st.integers(-3, 30), min_size=1, max_size=31))
def test_every_number_comes_to_its_cycle(raw: list[int]) -> None:
    image = [min(i, len(raw) - 1) for i in raw]
    found = cycles_of(np.array(image, np.int64))
    for i in range(len(image)):
        cycle, steps = _followed(image, i)
        number = int(found.of_cell[i])
        if not cycle:
            assert number == -1
        else:
            assert int(found.first[number]) == min(cycle)
            assert int(found.length[number]) == len(cycle)
        assert int(found.steps[i]) == steps
    assert len(found.first) == len(
        {_followed(image, i)[0] for i in range(len(image))} - {frozenset()}
    )
