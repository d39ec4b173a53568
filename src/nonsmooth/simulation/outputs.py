"""Outputs of a system on recorded samples, mode by mode, with numpy."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.layout import Tables
from nonsmooth.errors import ModelError
from nonsmooth.system.equations import Equation
from nonsmooth.system.evaluate import evaluate
from nonsmooth.system.linear import Basis, Harmonic, LinearForm, Power
from nonsmooth.system.structure import ModeForms, Structure
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
        angle: Array = frequency * self.phase
        if turns != round(turns):
            angle = 2.0 * np.pi * np.mod(turns * self.number, 1.0) + angle
        return angle

    def at(self, here: npt.NDArray[np.int64]) -> Clock:
        """Clock of some of the samples."""
        part = object.__new__(Clock)
        part.number, part.phase = self.number.take(here), self.phase.take(here)
        part.window, part.turns = self.window, self.turns
        return part


def output_values(
    system: System, clock: Clock, states: Array, modes: npt.NDArray[np.int64]
) -> dict[str, Array]:
    """Values of every output over the samples, from states (state, time) and mode numbers."""
    values = {name: np.full(modes.shape, np.nan) for name in system.outputs}
    if not values:
        return values
    for m, linear in enumerate(_linear_forms(system.structure)):
        here = np.flatnonzero(modes == m)
        if here.size == 0:
            continue
        names = _Names(system, m, linear, clock.at(here), states.take(here, axis=1))
        for name, target in values.items():
            target.put(here, names[name])
    return values


@lru_cache(maxsize=32)
def _linear_forms(structure: Structure) -> tuple[dict[str, LinearForm], ...]:
    """Outputs and definitions that are linear forms, mode by mode."""
    return tuple(
        {
            name: form
            for name, equation in {**forms.definitions, **structure.outputs}.items()
            if (form := _linear_form(forms, equation)) is not None
        }
        for forms in structure.modes.values()
    )


def _linear_form(forms: ModeForms, equation: Equation) -> LinearForm | None:
    try:
        return forms.form(equation)
    except (ModelError, KeyError):  # not linear, or made of other outputs
        return None


class _Names(Mapping[str, Any]):
    """Values of names in one mode; definitions and outputs are worked out when asked for."""

    def __init__(
        self,
        system: System,
        mode: int,
        linear: Mapping[str, LinearForm],
        clock: Clock,
        states: Array,
    ) -> None:
        self.forms = system.structure.modes[system.mode_names[mode]]
        self.linear = linear
        self.clock = clock
        self.known: dict[str, Any] = {"t": clock.time, "pi": np.pi, **system.parameter_values}
        self.known |= zip(system.states, states, strict=True)
        self.outputs = system.structure.outputs
        self._waves: dict[Harmonic, Array] = {}
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
        if name in self.linear:  # harmonics of a linear form are exact however late it is
            return self._form_value(self.linear[name])
        return evaluate((self.outputs.get(name) or self.forms.definitions[name]).tree, self)

    def _form_value(self, form: LinearForm) -> Any:
        total: Any = 0.0
        for basis, coefficient in form.terms.items():
            total = total + evaluate(coefficient, self) * self._basis_value(basis)
        return total

    def _basis_value(self, basis: Basis) -> Any:
        if isinstance(basis, Power):
            return self.known["t"] ** basis.order
        if not isinstance(basis, Harmonic):
            return self.known[basis.name]
        if basis not in self._waves:
            angle = self.clock.angle(float(evaluate(basis.frequency, self)))
            self._waves[basis] = np.cos(angle) if basis.kind == "cos" else np.sin(angle)
        return self._waves[basis]

    def __iter__(self) -> Iterator[str]:
        return iter(self.known)

    def __len__(self) -> int:
        return len(self.known)
