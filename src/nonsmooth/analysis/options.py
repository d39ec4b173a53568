"""The options that nearly all verbs share, and the attributes that nearly all results have."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError, OptionError, is_known, quote, unknown_name
from nonsmooth.runs.crew import check_threads
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.maps import Map
from nonsmooth.runs.options import check_run_options, finite_number
from nonsmooth.system.system import System
from nonsmooth.system.text.expressions import Expression, names_in, to_text
from nonsmooth.system.text.grammar import parse
from nonsmooth.version import __version__

__all__ = [
    "SharedOptions",
    "check_match",
    "check_seed",
    "check_values",
    "completion_rule",
    "derived_attributes",
    "refuse_fixed",
    "result_attributes",
    "system_attributes",
]


@dataclass(frozen=True)
class SharedOptions:
    """Options that nearly all verbs share.

    The texts below are the source of what each verb says about them: its docstring repeats the
    text word for word, and may go on with what holds for that verb alone. A test compares them.

    Parameters
    ----------
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.
    mode : str, optional
        Mode to start in, where several would fit; a cell, or a mode for any of its cells.
    threads : int, optional
        Number of threads; without it, one for each processor. The result does not depend on it.
    store : str or Path, optional
        Folder in which finished parts are kept, made where it is missing. After an interruption
        the same call goes on from them.
    seed : int, optional
        Seed of the random numbers: the same seed gives the same result.
    """

    parameters: Mapping[str, float | str] | None = None
    tolerance: float = 1e-12
    mode: str | None = None
    threads: int | None = None
    store: str | Path | None = None
    seed: int = 0

    @property
    def recorded(self) -> dict[str, Any]:
        """What every result tells of them, as attributes."""
        return {"tolerance": float(self.tolerance), "changed_parameters": self.changes}

    @property
    def changes(self) -> str:
        """The parameters that were changed, as a text; empty where none was."""
        return str(dict(self.parameters)) if self.parameters else ""

    def system_of(self, given: Any) -> System:
        """The system with its parameters changed, these and the other options checked."""
        return check_run_options(given, self.parameters, self.mode, self.tolerance)

    @property
    def workers(self) -> int:
        """Number of threads that run."""
        return check_threads(self.threads)


def check_seed(seed: Any) -> int:
    """Seed of random numbers: a whole number that is not negative."""
    value = finite_number("seed", seed)
    if value != int(value) or value < 0:
        raise OptionError(f"seed = {quote(seed)} must be a whole number, not negative")
    return int(value)


def check_match(match: Any) -> float:
    """Part of the spread of each state to which points agree that count as the same."""
    number = finite_number("match", match)
    if not 0.0 < number < 1.0:
        raise OptionError(f"match = {number:g} must lie between 0 and 1; 1e-6 is usual")
    return number


def check_values(system: System, parameter: Any, values: Any) -> npt.NDArray[np.float64]:
    """Values of the parameter, one for each column."""
    if not is_known(parameter, system.parameters):
        raise OptionError(unknown_name("parameter", parameter, system.parameters))
    try:
        grid = np.atleast_1d(np.asarray(values, dtype=float))
    except (TypeError, ValueError, OverflowError):
        raise OptionError(f"values = {quote(values)}: give a list of numbers") from None
    if grid.ndim != 1 or grid.size == 0 or not np.all(np.isfinite(grid)):
        raise OptionError(
            "values= takes a one-dimensional, non-empty list of finite numbers, such as"
            " np.linspace(0.5, 1.0, 400)"
        )
    if isinstance(values, tuple) and grid.size == 2:
        low, high = grid.tolist()
        raise OptionError(
            f"values = ({low:g}, {high:g}) looks like a range, and each value is needed here, such"
            f" as np.linspace({low:g}, {high:g}, 400); for these two values alone give the list"
            f" [{low:g}, {high:g}]"
        )
    return grid


def refuse_fixed(
    given: System | Map, parameters: Mapping[str, Any] | None, changed: Collection[str], by: str
) -> None:
    """Refuse a value of a parameter that is ``changed`` anyway, since it would be lost.

    given: what the verb was given; by: the argument that says how the parameter is changed.
    The value stays where the system refuses the other ones without it.
    """
    if not parameters:
        return
    own = given if isinstance(given, System) else given.system
    for name in changed:
        if name not in parameters:
            continue
        try:
            own.with_parameters(**{key: each for key, each in parameters.items() if key != name})
        except ModelError:
            continue
        raise OptionError(
            f"parameters: the value of {name!r} counts for nothing, since {by} gives its values;"
            f" leave {name!r} out of parameters="
        )


def completion_rule(place: str, text: str, known: list[str], given: str) -> Expression:
    """What completes a start: a text of what is ``given`` and of the ``known`` names beside it."""
    try:
        rule = parse(text, where=place)
    except ModelError as fault:
        raise OptionError(str(fault)) from None
    for each in names_in(rule):
        if each.name not in known and each.name != "pi":
            raise OptionError(
                f"{place} = {quote(text)}: {unknown_name('name', each.name, known)}; {given},"
                " parameters, and states completed before may stand here"
            )
    if "rate(" in to_text(rule):
        raise OptionError(f"{place} = {quote(text)}: a start has no rates yet; leave rate() out")
    return rule


def result_attributes(
    system: System, status: str, message: str, options: Mapping[str, Any]
) -> dict[str, Any]:
    """Attributes that tell of which system a result is, how it ended, and with which options."""
    return {**system_attributes(system), "status": status, "message": message, **options}


def derived_attributes(data: Any, *more: str) -> dict[str, Any]:
    """Attributes of what is made from a result: the system and the status that it tells.

    ``more`` are names of others that are kept.
    """
    kept = ("system_name", "system", "status", *more)
    found = {name: data.attrs[name] for name in kept if name in data.attrs}
    return found | {"nonsmooth_version": __version__}


def system_attributes(system: System) -> dict[str, Any]:
    """Attributes that tell of which system a result is, and which version made it."""
    return {
        "system_name": system.name,
        "system": labels_of(system).system,
        "nonsmooth_version": __version__,
    }
