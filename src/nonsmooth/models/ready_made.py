"""Which names of this package are ready-made systems."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from nonsmooth.system.system import System

__all__ = ["ready_made"]


def ready_made() -> dict[str, Callable[..., System]]:
    """Functions of `nonsmooth.models` that make a system, by name."""
    from nonsmooth import models

    found: dict[str, Callable[..., System]] = {}
    for name in models.__all__:
        thing = getattr(models, name)
        if inspect.isfunction(thing) and thing.__annotations__.get("return") == "System":
            found[name] = thing
    return found
