"""What users can reach by name: the objects that the tests of exports and docstrings look at."""

import enum
import inspect
from collections.abc import Iterator
from types import FunctionType, ModuleType
from typing import Any

import nonsmooth


def exported() -> Iterator[tuple[str, Any]]:
    """Every name in ``nonsmooth.__all__``, and in that of each module it names."""
    for name in nonsmooth.__all__:
        thing = getattr(nonsmooth, name)
        yield name, thing
        if isinstance(thing, ModuleType):
            for inner in getattr(thing, "__all__", ()):
                yield f"{name}.{inner}", getattr(thing, inner)


def callables() -> Iterator[tuple[str, Any]]:
    """Exported functions and classes, each class followed by its public methods."""
    for name, thing in exported():
        if not is_ours(thing):
            continue
        yield name, thing
        if inspect.isclass(thing):
            for inner, member in members(thing):
                method = getattr(member, "__func__", member)
                if isinstance(method, FunctionType) and not inner.startswith("_"):
                    yield f"{name}.{inner}", method


def members(cls: type) -> Iterator[tuple[str, Any]]:
    """Attributes of a class by name, those of its bases in this package included."""
    found: dict[str, Any] = {}
    for base in cls.__mro__:
        if is_ours(base):
            found = {**vars(base), **found}
    yield from found.items()


def is_ours(thing: Any) -> bool:
    """Whether it is a function or class written in this package."""
    written = inspect.isfunction(thing) or inspect.isclass(thing)
    return written and thing.__module__.partition(".")[0] == "nonsmooth"


def arguments(thing: Any) -> list[str]:
    """Names of the arguments that a caller gives, without self and stars."""
    if inspect.isclass(thing) and (issubclass(thing, enum.Enum) or not _has_own_call(thing)):
        return []
    names = list(inspect.signature(thing).parameters)
    return [name for name in names if name not in ("self", "cls") and not name.startswith("_")]


def _has_own_call(cls: type) -> bool:
    """Whether the class says in Python how it is made; a plain exception does not."""
    return any(isinstance(getattr(cls, name), FunctionType) for name in ("__init__", "__new__"))
