"""Excursions out of a mode of which nothing remains: they vanish at a graze, or at a corner."""

from __future__ import annotations

from collections.abc import Iterator

from nonsmooth.engine.tables import Wiring
from nonsmooth.periodic_orbits.word import Word

__all__ = ["is_graze", "path_at_corner"]


def is_graze(word: Word, wiring: Wiring, k: int) -> bool:
    """Whether leg k is an excursion out of a mode and back into it, that nothing remains of.

    The first leg of a driven orbit is one together with the last, which the section cuts off.
    """
    last = k - 2 if k == 0 and not word.closes_at_event and len(word) > 2 else k - 1
    if len(word) < 2 or not word.paths[k] or not word.paths[last % len(word)]:
        return False
    before, path = word.modes[last % len(word)], word.paths[last % len(word)]
    resetting, slaved = wiring.exits["resetting"]["words"], wiring.modes["slaved"]["words"]
    resets = any(
        (resetting[m, e] & ~slaved[m]).any()
        for m, e in _passed(wiring, before, path + word.paths[k])
    )
    return not resets and word.last_target(wiring, k) == before


def path_at_corner(word: Word, wiring: Wiring, k: int) -> tuple[int, ...] | None:
    """The path past an excursion of legs k and k + 1; None where they are no such excursion.

    A guard whose rate is another guard has its lowest value where that one is zero. So an excursion
    behind it is cut in two, and vanishes where the guard is touched at the corner of both: legs k
    and k + 1 at once. The path leads straight from the leg before to the one behind.
    """
    if not 0 < k < len(word) - 2:
        return None
    (before, first), (inside, middle), (_, last) = (
        (word.modes[i], word.paths[i]) for i in (k - 1, k, k + 1)
    )
    after = word.modes[k + 2]
    single = len(first) == len(middle) == len(last) == 1
    legs = (before, inside, word.modes[k + 1], after)
    if not single or len(set(legs)) < len(legs):
        return None
    passed = zip(legs[:3], (first, middle, last), strict=True)
    if any(wiring.resets(mode, path[0]) for mode, path in passed):
        return None
    straight = [
        e
        for e in range(int(wiring.modes["n_exits"][before]))
        if int(wiring.exits["target"][before, e]) == after and not wiring.resets(before, e)
    ]
    return (straight[0],) if straight else None


def _passed(wiring: Wiring, mode: int, path: tuple[int, ...]) -> Iterator[tuple[int, int]]:
    """Modes and the exits passed in them."""
    for e in path:
        yield mode, e
        mode = int(wiring.exits["target"][mode, e])
