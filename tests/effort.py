"""How much a piece of Python does, counted: the same number on every machine, however busy."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from inspect import CO_GENERATOR
from types import FrameType
from typing import Any

import pytest

__all__ = ["HANG", "calls_at_most", "each_call_of_ours"]

# Seconds after which a process is taken to hang: what is waited for takes some seconds, so there
# is room for a machine a hundred times slower.
HANG = 1800.0


@contextmanager
def each_call(tell: Callable[[FrameType, bool], None]) -> Iterator[None]:
    """Tell of each function that this thread calls: its frame, or its caller's if in C."""

    def note(frame: FrameType, event: str, argument: Any) -> None:
        if event in ("call", "c_call"):
            tell(frame, event == "c_call")

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        yield
    finally:
        sys.setprofile(before)


@contextmanager
def calls_at_most(limit: float) -> Iterator[None]:
    """Fail where this thread calls more functions than that, written in Python or in C.

    It fails at the first call beyond the limit, so that work without an end ends too. What goes on
    within one function of C, a search in a text for instance, counts as one call.
    """
    count = 0

    def tell(frame: FrameType, in_c: bool) -> None:
        nonlocal count
        count += 1
        if count > limit:
            sys.setprofile(None)
            pytest.fail(f"more than {limit:g} calls; the last one in {frame.f_code.co_qualname}")

    with each_call(tell):
        yield


@contextmanager
def each_call_of_ours(tell: Callable[[FrameType], None]) -> Iterator[None]:
    """Tell of each function of the package that this thread calls, but for generators.

    A generator is also called when it is cleared away, where Python does not pass faults on.
    """

    def select(frame: FrameType, in_c: bool) -> None:
        ours = frame.f_globals.get("__name__", "").startswith("nonsmooth.")
        if ours and not in_c and not frame.f_code.co_flags & CO_GENERATOR:
            tell(frame)

    with each_call(select):
        yield
