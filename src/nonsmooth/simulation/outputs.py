"""Outputs of a system on recorded samples, mode by mode, with numpy."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.layout import Tables
from nonsmooth.errors import ModelError
from nonsmooth.system.evaluate import evaluate
from nonsmooth.system.linear import Harmonic, LinearForm, Power
from nonsmooth.system.structure import ModeForms
from nonsmooth.system.system import System

__all__ = ["output_values"]

Array = npt.NDArray[np.float64]


class Clock:
    """Times of samples, and angles of harmonics that lose nothing over many periods."""

    def __init__(self, number: npt.NDArray[np.int64], phase: Array, tables: Tables) -> None:
        self.number, self.phase = number, phase
        self.window = float(tables.clock[0])
        self.turns = {float(w): float(turns) for w, turns in tables.harmonics.T}

    @property
    def time(self) -> Array:
        """Times as single numbers."""
        return self.number * self.window + self.phase

    def angle(self, frequency: float) -> Array:
        """Angle of a harmonic, up to whole turns."""
        turns = self.turns.get(frequency)
        if turns is None:
            return frequency * self.time
        angle: Array = 2.0 * np.pi * np.mod(turns * self.number, 1.0) + frequency * self.phase
        return angle

    def at(self, here: npt.NDArray[np.bool_]) -> Clock:
        """Clock of some of the samples."""
        part = object.__new__(Clock)
        part.number, part.phase = self.number[here], self.phase[here]
        part.window, part.turns = self.window, self.turns
        return part


def output_values(
    system: System, clock: Clock, states: Array, modes: npt.NDArray[np.int64]
) -> dict[str, Array]:
    """Values of every output over the samples, from states (time, state) and mode numbers."""
    values = {name: np.full(modes.shape, np.nan) for name in system.outputs}
    if not values:
        return values
    for m, forms in enumerate(system.structure.modes.values()):
        here = modes == m
        if not np.any(here):
            continue
        names = _Names(system, forms, clock.at(here), states[here])
        for name, target in values.items():
            target[here] = names[name]
    return values


class _Names(Mapping[str, Any]):
    """Values of names in one mode; definitions and outputs are worked out when asked for."""

    def __init__(self, system: System, forms: ModeForms, clock: Clock, states: Array) -> None:
        self.forms = forms
        self.clock = clock
        self.known: dict[str, Any] = {"t": clock.time, "pi": np.pi, **system.parameter_values}
        self.known |= {name: states[:, i] for i, name in enumerate(system.states)}
        self.outputs = system.structure.outputs
        self._open: list[str] = []

    def __getitem__(self, name: str) -> Any:
        if name not in self.known:
            if name in self._open:
                raise ModelError(f"outputs: {name!r} is defined by itself; break the circle")
            self._open.append(name)
            self.known[name] = self._work_out(name)
            self._open.pop()
        return self.known[name]

    def _work_out(self, name: str) -> Any:
        if name.startswith("rate("):
            return self._form_value(self.forms.rates[name[5:-1]])
        equation = self.outputs.get(name) or self.forms.definitions[name]
        try:
            # as a linear form, harmonics are exact however late it is
            return self._form_value(self.forms.form(equation))
        except (ModelError, KeyError):
            return evaluate(equation.tree, self)

    def _form_value(self, form: LinearForm) -> Any:
        total: Any = 0.0
        for basis, coefficient in form.terms.items():
            value = evaluate(coefficient, self)
            if isinstance(basis, Power):
                factor = self.known["t"] ** basis.order
            elif isinstance(basis, Harmonic):
                angle = self.clock.angle(float(evaluate(basis.frequency, self)))
                factor = np.cos(angle) if basis.kind == "cos" else np.sin(angle)
            else:
                factor = self.known[basis.name]
            total = total + value * factor
        return total

    def __iter__(self) -> Iterator[str]:
        return iter(self.known)

    def __len__(self) -> int:
        return len(self.known)
