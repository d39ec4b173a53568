"""`tie_parameters`: parameters that follow others."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from nonsmooth.errors import OptionError, quote, unknown_name
from nonsmooth.system.parts import Text
from nonsmooth.system.system import System

__all__ = ["tie_parameters"]


def tie_parameters(system: System, ties: Mapping[str, Text], **values: float) -> System:
    """Let some parameters of a system follow others, so that these are changed together.

    Parameters
    ----------
    system : System
        The system.
    ties : mapping of str to str
        Parameters with what each of them is: an expression of other parameters.
    **values : float
        Default values of parameters that are new.

    Returns
    -------
    System
        The system with the tied parameters among its definitions, for every analysis to use.

    Raises
    ------
    OptionError
        For an unknown parameter, or a new one that has the name of another.
    ModelError
        For an expression that is none, or that uses unknown names; where the values are refused.

    Examples
    --------
    The same preload in both directions:

    >>> import nonsmooth as ns
    >>> rotor = ns.tie_parameters(
    ...     ns.models.rotor(), {"delta_x": "delta", "delta_y": "delta"}, delta=0.1
    ... )
    >>> softer = rotor.with_parameters(delta=0.02)
    >>> softer == rotor, "delta_x" in softer.parameters
    (False, False)
    """
    if not isinstance(system, System):
        raise OptionError(f"system = {quote(system)} is not a System")
    if not isinstance(ties, Mapping) or not ties:
        raise OptionError(f'ties = {quote(ties)}: give a mapping, such as {{"c_2": "2*c_1"}}')
    for name in ties:
        if name not in system.parameters:
            raise OptionError(f"ties: {unknown_name('parameter', name, system.parameters)}")
    for name in values:
        if name in system.parameters and name not in ties:
            raise OptionError(
                f"{name} = {quote(values[name])}: the system has this parameter; change its value"
                " with with_parameters"
            )
    # where definitions may not stand, their text takes the place of the name
    pattern = re.compile(r"\b(" + "|".join(re.escape(name) for name in ties) + r")\b")

    def untied(text: Any) -> Any:
        return pattern.sub(lambda m: f"({ties[m[1]]})", text) if isinstance(text, str) else text

    kept = {name: value for name, value in system.parameters.items() if name not in ties}
    drift: Any = system.drift
    if isinstance(drift, Mapping):
        drift = {name: untied(text) for name, text in drift.items()}
    return replace(
        system,
        parameters={**kept, **values},
        definitions={**ties, **system.definitions},
        require={untied(condition): reason for condition, reason in system.require.items()},
        initial={name: untied(text) for name, text in system.initial.items()},
        drift=drift,
    )
