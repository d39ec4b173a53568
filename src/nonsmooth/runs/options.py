"""Checks of the options of a run, before anything is computed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, is_known, quote, unknown_name
from nonsmooth.real_numbers import finite_numbers, finite_real, whole_number
from nonsmooth.runs.memory import free_memory, size_text
from nonsmooth.system.system import System

__all__ = [
    "check_count",
    "check_flag",
    "check_run_options",
    "check_signals",
    "finite_number",
    "parameters_of_tangent",
    "positive_number",
    "time_grid",
    "whole_number",
]

_LARGEST_TIME = 1e15  # whole windows must stay exact, and far below 64 bits
_MOST_SAMPLES = 10**8


def finite_number(name: str, value: Any) -> float:
    """Value of an option that must be a finite number of reasonable size."""
    number = finite_real(name, value)
    if abs(number) > _LARGEST_TIME:
        raise OptionError(f"{name} = {number:g} must be at most {_LARGEST_TIME:g} in size")
    return number


def positive_number(name: str, value: Any) -> float:
    """Value of an option that must be positive."""
    number = finite_number(name, value)
    if not number > 0.0:
        raise OptionError(f"{name} = {number:g} must be positive")
    return number


def check_flag(name: str, value: Any) -> bool:
    """Value of an option that is true or false."""
    if not isinstance(value, (bool, np.bool_)):
        raise OptionError(f"{name} = {quote(value)}: give True or False")
    return bool(value)


def time_grid(value: Any) -> npt.NDArray[np.float64]:
    """Times to sample: one dimension, finite, not decreasing."""
    grid = np.atleast_1d(finite_numbers("times", value))
    if grid.ndim != 1 or grid.size == 0 or not np.all(np.abs(grid) <= _LARGEST_TIME):
        raise OptionError(
            "times= takes a one-dimensional, non-empty list of finite numbers, at most"
            f" {_LARGEST_TIME:g} in size"
        )
    if np.any(np.diff(grid) < 0.0):
        raise OptionError("times= must not decrease; sort it")
    return grid


def check_count(count: float, sample_bytes: int = 0) -> int:
    """Number of samples, refused where it would fill the memory."""
    if count > _MOST_SAMPLES:
        raise OptionError(
            f"{count:.3g} samples are asked for, at most {_MOST_SAMPLES:g} in one run; lower"
            " samples_per_period= or the length, or go on from run to run"
        )
    if sample_bytes and (need := count * sample_bytes) > (free := free_memory()):
        raise OptionError(
            f"{count:.3g} samples take {size_text(need)}, and {size_text(free)} of memory are free;"
            " lower samples_per_period= or the length, or go on from run to run"
        )
    return int(count)


def check_signals(system: System, start: float, end: float) -> None:
    """Every signal is known from the start of a run to its end."""
    for name, signal in system.signals.items():
        low, high = signal.span
        slack = 4.0 * np.finfo(float).eps * max(abs(low), abs(high))
        if start < low - slack or end > high + slack:
            raise OptionError(
                f"the signal {name!r} is known from t = {low:.9g} to {high:.9g}, and the run goes"
                f" from t = {start:.9g} to {end:.9g}; give it a later t_start= or an earlier end"
                " that lies within"
            )


def is_mapping_of_names(value: Any) -> bool:
    """Whether a value maps texts to something."""
    return isinstance(value, Mapping) and all(isinstance(name, str) for name in value)


def check_run_options(system: Any, parameters: Any, mode: Any, tolerance: Any) -> System:
    """System with its parameters changed; everything else checked for its kind."""
    if not isinstance(system, System):
        raise OptionError(
            f"system = {quote(system)} is not a System; write one, or take one from ns.models"
        )
    if parameters is not None and not is_mapping_of_names(parameters):
        raise OptionError(f"parameters = {quote(parameters)}: give a mapping of names to numbers")
    if mode is not None and not isinstance(mode, str):
        raise OptionError(f"mode = {quote(mode)} is not the name of a mode")
    if not 0.0 < finite_number("tolerance", tolerance) < 1e-3:
        raise OptionError(f"tolerance = {tolerance} must lie between 0 and 1e-3")
    return system.with_parameters(**parameters) if parameters else system


def parameters_of_tangent(system: System, tangent: Any) -> tuple[str, ...] | None:
    """Parameters by which derivatives are wanted; None where none are wanted at all."""
    if isinstance(tangent, (bool, np.bool_)):
        return tuple(system.parameters) if tangent else None
    if isinstance(tangent, str) or not isinstance(tangent, Sequence):
        raise OptionError(
            f"tangent = {quote(tangent)}: give True, False, or a list of parameters, such as"
            " ['omega'], for derivatives by the initial state and by these"
        )
    for name in tangent:
        if not is_known(name, system.parameters):
            raise OptionError(f"tangent: {unknown_name('parameter', name, system.parameters)}")
    if len(set(tangent)) < len(tangent):
        raise OptionError("tangent: a parameter is named twice")
    return tuple(tangent)
