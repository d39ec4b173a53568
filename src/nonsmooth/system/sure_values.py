"""Values of one parameter that a system takes: all at once, where a sweep has many of them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.system.checks import angle_periods, condition_of
from nonsmooth.system.evaluate import evaluate
from nonsmooth.system.expressions import Expression, names_in

if TYPE_CHECKING:
    from nonsmooth.system.system import System

__all__ = ["rests_alike", "sure_values"]

Bools = npt.NDArray[np.bool_]
_TURN = 5e-15  # half of what the check of a system allows


def sure_values(system: System, sets: Mapping[str, npt.NDArray[np.float64]]) -> Bools:
    """Whether `System.with_parameters` takes each of K sets of values for sure, (K,) by name.

    The others need to be asked for one by one, which also tells what is wrong with them.
    """
    known: dict[str, Any] = {**system.parameter_values, **sets}
    structure = system.structure
    sure = np.ones(next(iter(sets.values())).shape, bool)

    def number(expression: Expression) -> Any:
        return evaluate(expression, known)

    with np.errstate(all="ignore"):
        for condition in system.require:
            sure &= np.asarray(number(condition_of(condition)), bool)
        positive = [form.constant_part for _, _, form in angle_periods(system)]
        for forms in structure.modes.values():
            if not forms.sides:
                positive += [guard for guard in forms.constant_guards if guard is not None]
        for expression in positive:
            value = number(expression)
            sure &= (value > 0.0) & np.isfinite(value)
        for value in structure.coefficient_values.values(known):
            sure &= np.isfinite(value)
        for equation in structure.initial.values():
            sure &= np.isfinite(number(structure.static_form.form(equation).constant_part))
        for period in structure.period_nodes:
            length = number(period)
            sure &= (length > 0.0) & np.isfinite(length)
            for frequency in structure.frequencies:
                turns = number(frequency) * length / (2.0 * math.pi)
                sure &= np.abs(turns - np.rint(turns)) <= _TURN * np.maximum(1.0, np.abs(turns))
    return sure


def rests_alike(system: System, names: Iterable[str]) -> bool:
    """Whether the rest state is the same for all values of some parameters."""
    form, chosen = system.structure.static_form.form, set(names)
    texts: Mapping[str, Any] = system.structure.initial
    return all(
        chosen.isdisjoint(each.name for each in names_in(form(equation).constant_part))
        for equation in texts.values()
    )
