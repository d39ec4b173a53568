"""Which initial state and which parameters each lane of an ensemble has."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, is_known, quote, unknown_choice, unknown_name
from nonsmooth.runs.memory import free_memory, size_text
from nonsmooth.runs.start import check_carried, unknown_state
from nonsmooth.system.system import System

__all__ = ["Members", "mappings_of", "members_of", "split_parameters"]

Floats = npt.NDArray[np.float64]
_WAYS = ("grid", "pairs")


@dataclass(frozen=True)
class Members:
    """Initial states and parameter sets, and how lanes are made of them.

    In a grid every set has all the initial states, which follow each other; in pairs the lane i has
    initial state i and set i.
    """

    starts: dict[str, Floats]  # (S,) each: states that are given
    sets: dict[str, Floats]  # (P,) each: parameters that differ between lanes
    n_starts: int
    n_sets: int
    paired: bool

    @property
    def count(self) -> int:
        """Number of lanes."""
        return self.n_starts if self.paired else self.n_starts * self.n_sets

    def set_numbers(self, lanes: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
        """Parameter set of each lane."""
        return lanes if self.paired else lanes // self.n_starts

    def parameters(self, number: int) -> dict[str, float]:
        """Parameters of a set that are not the system's."""
        return {name: float(values[number]) for name, values in self.sets.items()}

    def states(self, lanes: npt.NDArray[np.int64], rest: Mapping[str, float]) -> Floats:
        """Initial states of lanes, (lane, state); those that are not given as at ``rest``."""
        starts = lanes if self.paired else lanes % self.n_starts
        found = np.empty((lanes.size, len(rest)))
        for k, (name, value) in enumerate(rest.items()):
            found[:, k] = self.starts[name][starts] if name in self.starts else value
        return found

    def mappings(self, lanes: npt.NDArray[np.int64]) -> list[dict[str, float]]:
        """What is given of the initial state of each lane."""
        starts = (lanes if self.paired else lanes % self.n_starts).tolist()
        return [{name: float(each[i]) for name, each in self.starts.items()} for i in starts]


def members_of(system: System, initial: Any, arrays: Mapping[str, Floats], combine: Any) -> Members:
    """Lanes of initial states and of parameters with several values, as users give them."""
    if not is_known(combine, _WAYS):
        raise OptionError(unknown_choice("combine", combine, _WAYS))
    starts, n_starts = _starts(system, initial)
    if combine == "grid":
        _check_room(arrays)
        grids = np.meshgrid(*arrays.values(), indexing="ij") if arrays else []
        sets = {name: grid.ravel() for name, grid in zip(arrays, grids, strict=True)}
        n_sets = math.prod(values.size for values in arrays.values())
        return Members(starts, sets, n_starts, n_sets, paired=False)
    lengths = {name: values.size for name, values in arrays.items()}
    if n_starts > 1:
        lengths["initial"] = n_starts
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{name} has {length}" for name, length in lengths.items())
        raise OptionError(
            f"combine='pairs' takes one value of each for every lane, and {told}; give as many of"
            " each, or combine='grid' for every combination"
        )
    count = max(lengths.values(), default=1)
    starts = {name: np.broadcast_to(values, count) for name, values in starts.items()}
    return Members(starts, dict(arrays), count, count, paired=True)


def _check_room(arrays: Mapping[str, Floats]) -> None:
    """Refuse a grid whose values alone fill the memory."""
    count = math.prod(values.size for values in arrays.values())
    need, free = 2 * 8 * len(arrays) * count, free_memory()  # the grids, and their copies in a row
    if need > free:
        told = " and ".join(f"{name} has {values.size} values" for name, values in arrays.items())
        raise OptionError(
            f"{told}: a grid of {count:.3g} sets takes {size_text(need)}, and {size_text(free)} of"
            " memory are free; give fewer values, or combine='pairs' for one set of each"
        )


def mappings_of(
    system: System, initial: Any, parameters: Mapping[str, Any] | None, several: Mapping[str, Any]
) -> Any:
    """Initial states with the points of datasets as mappings; `OptionError` for what is no point.

    A point belongs to the parameters of the call, but for those with several values.
    """

    def mapping(each: Any) -> Any:
        if not hasattr(each, "data_vars"):
            return each
        check_carried(system, each, parameters, several)
        for name in system.states:
            if name not in each.data_vars:
                raise OptionError(f"initial: the dataset has no state {name!r} of {system.name!r}")
            if each[name].ndim:
                raise OptionError(
                    f"initial: {name!r} of the dataset is over {', '.join(each[name].dims)}; give"
                    " one of its points, as in data.isel(time=-1)"
                )
        return {name: float(each[name]) for name in system.states}

    if isinstance(initial, list | tuple):
        return [mapping(each) for each in initial]
    return mapping(initial)


def split_parameters(
    system: Any, parameters: Any
) -> tuple[dict[str, float | str], dict[str, Floats]]:
    """Parameters with one value, and those with several."""
    if parameters is None:
        return {}, {}
    if not isinstance(parameters, Mapping):
        raise OptionError(
            f"parameters = {quote(parameters)}: give a mapping of names to numbers or to lists of"
            " numbers"
        )
    single: dict[str, float | str] = {}
    several: dict[str, Floats] = {}
    for name, value in parameters.items():
        if isinstance(system, System) and name not in system.parameters:
            raise OptionError(unknown_name("parameter", name, system.parameters))
        if isinstance(value, str | Real) or np.ndim(value) == 0:
            single[name] = value
        else:
            several[name] = _list(f"parameters[{name!r}]", value)
    return single, several


def _starts(system: System, initial: Any) -> tuple[dict[str, Floats], int]:
    """Given states by name, with a value for each initial state, and how many these are."""
    if initial is None:
        return {}, 1
    if isinstance(initial, Mapping):
        return _of_mapping(system, initial)
    if not isinstance(initial, Sequence) or isinstance(initial, str):
        first = system.states[0]
        raise OptionError(
            f"initial = {quote(initial)}: give a mapping of states to numbers or lists of numbers,"
            f" such as {{{first!r}: [0.1, 0.2]}}, or a list of mappings"
        )
    if not initial:
        raise OptionError("initial= is an empty list; give at least one initial state")
    names = None
    for i, each in enumerate(initial):
        if not isinstance(each, Mapping):
            raise OptionError(f"initial[{i}] = {quote(each)} is not a mapping of states to numbers")
        if names is not None and set(each) != names:
            raise OptionError(
                f"initial[{i}] names {', '.join(map(str, each)) or 'no state'}, and initial[0]"
                f" {', '.join(sorted(map(str, names))) or 'none'}; name the same states in all"
            )
        names = set(each)
    columns = {name: [each[name] for each in initial] for name in initial[0]}
    starts, _ = _of_mapping(system, columns)
    return starts, len(initial)


def _of_mapping(system: System, initial: Mapping[Any, Any]) -> tuple[dict[str, Floats], int]:
    starts: dict[str, Floats] = {}
    for name, values in initial.items():
        if name not in system.states:
            raise OptionError(f"initial: {unknown_state(system, str(name))}")
        starts[name] = _list(f"initial[{name!r}]", values)
    lengths = {name: values.size for name, values in starts.items() if values.size > 1}
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{name} has {length}" for name, length in lengths.items())
        raise OptionError(
            f"initial: {told} values; give as many of each, one for every initial state (for all"
            " combinations see numpy.meshgrid)"
        )
    count = max(lengths.values(), default=1)
    return {name: np.broadcast_to(values, count) for name, values in starts.items()}, count


def _list(name: str, values: Any) -> Floats:
    """A number or a list of numbers, all of them finite."""
    try:
        array = np.atleast_1d(np.asarray(values, dtype=float))
    except (TypeError, ValueError, OverflowError):
        raise OptionError(f"{name} = {quote(values)}: give a number or a list of numbers") from None
    if array.ndim != 1 or array.size == 0:
        raise OptionError(
            f"{name} has the shape {array.shape}; give a number or a one-dimensional, non-empty"
            " list of numbers"
        )
    if not np.all(np.isfinite(array)):
        place = int(np.flatnonzero(~np.isfinite(array))[0])
        raise OptionError(f"{name}[{place}] = {array[place]:g} is not a finite number")
    return array
