"""A dict that cannot be changed: systems are values, and what is derived from them is kept."""

from __future__ import annotations

from typing import Any, NoReturn, TypeVar

__all__ = ["FrozenDict"]

K = TypeVar("K")
V = TypeVar("V")


class FrozenDict(dict[K, V]):
    """A dict whose methods of change raise TypeError."""

    def _refuse(self, *arguments: Any, **named: Any) -> NoReturn:
        raise TypeError("a system is a value and cannot be changed; make a new one")

    __setitem__ = __delitem__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse
    __ior__ = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return FrozenDict, (dict(self),)
