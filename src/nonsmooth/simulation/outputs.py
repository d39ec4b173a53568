"""Outputs of a system on recorded samples, mode by mode, with numpy."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError
from nonsmooth.system.evaluate import evaluate
from nonsmooth.system.linear import Harmonic, LinearForm, Power
from nonsmooth.system.structure import ModeForms
from nonsmooth.system.system import System

__all__ = ["output_values"]

Array = npt.NDArray[np.float64]


def output_values(
    system: System, time: Array, states: Array, modes: npt.NDArray[np.int64]
) -> dict[str, Array]:
    """Values of every output, shape of ``time``, from states (time, state) and mode numbers."""
    values = {name: np.full(time.shape, np.nan) for name in system.outputs}
    if not values:
        return values
    for m, forms in enumerate(system.structure.modes.values()):
        here = modes == m
        if not np.any(here):
            continue
        names = _Names(system, forms, time[here], states[here])
        for name, target in values.items():
            target[here] = names[name]
    return values


class _Names(Mapping[str, Any]):
    """Values of names in one mode; definitions and outputs are worked out when asked for."""

    def __init__(self, system: System, forms: ModeForms, time: Array, states: Array) -> None:
        self.forms = forms
        self.known: dict[str, Any] = {"t": time, "pi": np.pi, **system.parameter_values}
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
        if name in self.outputs:
            return evaluate(self.outputs[name].tree, self)
        return evaluate(self.forms.definitions[name].tree, self)

    def _form_value(self, form: LinearForm) -> Any:
        total: Any = 0.0
        for basis, coefficient in form.terms.items():
            value = evaluate(coefficient, self)
            if isinstance(basis, Power):
                factor = self.known["t"] ** basis.order
            elif isinstance(basis, Harmonic):
                angle = evaluate(basis.frequency, self) * self.known["t"]
                factor = np.cos(angle) if basis.kind == "cos" else np.sin(angle)
            else:
                factor = self.known[basis.name]
            total = total + value * factor
        return total

    def __iter__(self) -> Iterator[str]:
        return iter(self.known)

    def __len__(self) -> int:
        return len(self.known)
