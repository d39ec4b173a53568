"""Exceptions that nonsmooth raises on purpose.

::

    NonsmoothError
    ├── ModelError(ValueError)      the system as written cannot be right
    ├── OptionError(ValueError)     an argument of a verb cannot be right
    └── RunError(RuntimeError)      the run could not start or had to stop

Every message says what was required, what came instead and what to do.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterable
from difflib import get_close_matches
from typing import Any

__all__ = [
    "ModelError",
    "NonsmoothError",
    "OptionError",
    "ResultWarning",
    "RunError",
    "RunWarning",
    "is_known",
    "quote",
    "unknown_choice",
    "unknown_name",
]

_MOST_LISTED = 60  # of the known names; all of a large system would hide the message
_WIDTH = 60  # characters of a value that a message repeats


class NonsmoothError(Exception):
    """Base of every exception that nonsmooth raises on purpose.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> try:
    ...     ns.models.soft_impact(zeta=-0.1)
    ... except ns.NonsmoothError as error:
    ...     print(type(error).__name__, error)
    ModelError zeta >= 0 is required, zeta = -0.1 was given: negative damping would feed energy in
    """


class ModelError(NonsmoothError, ValueError):
    """The system as written cannot be right; the message points at the place.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> ns.System(states=["x", "v"], equations={"x": "v", "v": "-omega**2*x"})
    Traceback (most recent call last):
    nonsmooth.errors.ModelError: equations['v']: unknown name 'omega' (known: v, x)
        -omega**2*x
         ^
    """


class OptionError(NonsmoothError, ValueError):
    """An argument given to a verb cannot be right.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> ns.simulate(ns.models.duffing(), {"y": 1.0}, periods=1)
    Traceback (most recent call last):
    nonsmooth.errors.OptionError: initial: unknown state 'y' (known: v, x)
    """


class RunError(NonsmoothError, RuntimeError):
    """A run could not start, or stopped where the caller asked for an exception.

    Parameters
    ----------
    message : str
        What happened and what can be done.
    status : str, optional
        Status word of the run, the same as in a result's attributes.
    time : float, optional
        Time at which the run stopped.
    partial : object, optional
        What was computed up to then.

    Examples
    --------
    A spring that swings below 1 comes through no section above it:

    >>> import nonsmooth as ns
    >>> spring = ns.System(states=["x", "v"], equations={"x": "v", "v": "-x - v"})
    >>> try:
    ...     ns.PoincareMap(spring, "x - 2").tangent({"x": 1.0})
    ... except ns.RunError as error:
    ...     print(error.status)
    time_limit
    """

    def __init__(
        self, message: str, *, status: str = "", time: float = float("nan"), partial: Any = None
    ) -> None:
        super().__init__(message)
        self.status = status
        self.time = time
        self.partial = partial


class RunWarning(UserWarning):
    """A run ended before its time; the result says why and holds what was computed.

    Examples
    --------
    >>> import warnings
    >>> import nonsmooth as ns
    >>> growing = ns.System(states=["x"], equations={"x": "x"})
    >>> with warnings.catch_warnings(record=True) as told:
    ...     warnings.simplefilter("always")
    ...     run = ns.simulate(growing, {"x": 1.0}, t_end=100)
    >>> told[0].category.__name__, run.attrs["status"]
    ('RunWarning', 'diverged')
    """


class ResultWarning(UserWarning):
    """A result that may mislead; the message says why and what to do.

    Examples
    --------
    A slow sine looks the same from sample to sample:

    >>> import warnings
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> with warnings.catch_warnings(record=True) as told:
    ...     warnings.simplefilter("always")
    ...     test = ns.zero_one_test(np.sin(0.01 * np.arange(2000)))
    >>> told[0].category.__name__, "try every=" in str(told[0].message)
    ('ResultWarning', True)
    """


def quote(value: Any) -> str:
    """A value as messages repeat it: short, in one line, also where Python refuses to write it.

    Of arrays and datasets that fill lines it is the kind that tells more than how they begin.
    """
    if isinstance(value, str):
        value = str(value)  # of a text of numpy no more
    elif getattr(value, "shape", None) == () and hasattr(value, "item"):
        value = value.item()
    try:
        text = repr(value)
    except ValueError:  # a whole number of thousands of digits
        return f"a whole number of {int(math.log10(2) * value.bit_length()) + 1} digits"
    shape = getattr(value, "shape", None)
    if "\n" in text and isinstance(shape, tuple):
        return f"<array of shape {shape}>"
    if "\n" in text and not isinstance(value, str | list | tuple | dict | set):
        kind = type(value)
        return f"<{kind.__module__.partition('.')[0]}.{kind.__name__}>"
    text = " ".join(text.split())
    return text if len(text) <= _WIDTH else f"{text[: _WIDTH - 3]}..."


def is_known(value: Any, known: Container[str]) -> bool:
    """Whether a value is one of some names; what is no text, such as an array, is none of them."""
    return isinstance(value, str) and value in known


def unknown_choice(option: str, value: Any, known: Iterable[str]) -> str:
    """Sentence for a value of an option that is none of those it may have."""
    names = list(map(str, known))
    return f"{option} = {quote(value)}: give one of {', '.join(names)}{_nearest(value, names)}"


def _nearest(name: Any, names: list[str]) -> str:
    """Question that suggests the nearest of some names, where one is near."""
    begun = [each for each in names if str(name) and each.startswith(str(name))]
    near = begun or get_close_matches(str(name), names, n=1)
    return f"; did you mean {near[0]!r}?" if near else ""


def unknown_name(kind: str, name: Any, known: Iterable[str]) -> str:
    """Sentence for a name that is not declared: what is known, and the nearest one."""
    names = sorted(map(str, known))
    hint = _nearest(name, names)
    listed = ", ".join(names[:_MOST_LISTED]) if names else "none"
    if len(names) > _MOST_LISTED:
        listed += f" and {len(names) - _MOST_LISTED:,} more"
    return f"unknown {kind} {quote(name)}{hint} (known: {listed})"
