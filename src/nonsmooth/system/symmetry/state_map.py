"""The map of states that a user declares as a symmetry, as a matrix and an offset."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError, quote
from nonsmooth.system.algebra.linear import CONSTANT, LinearForm, NotLinear, State
from nonsmooth.system.equations.equation import Equation
from nonsmooth.system.model.evaluated import EvaluatedSystem
from nonsmooth.system.text.evaluate import constant_value
from nonsmooth.system.text.expressions import name_set

__all__ = ["StateMap", "read_state_map"]

Floats = npt.NDArray[np.float64]

_ROUNDING = 1e-12  # of the entries of a map that is applied twice


@dataclass(frozen=True)
class StateMap:
    """The affine map ``matrix @ state + offset``, and the images of modes that the user names."""

    matrix: Floats  # (n, n)
    offset: Floats  # (n,)
    modes: Mapping[str, str]  # declared modes by name, both ways
    text: str  # the map in words
    varies: bool  # whether it depends on parameters

    def __call__(self, states: Floats) -> Floats:
        """Images of some states, the last axis being that of the states."""
        return np.asarray(states @ self.matrix.T + self.offset)


def read_state_map(system: EvaluatedSystem) -> StateMap:
    """Map of a declared symmetry for the present parameter values.

    Raises `ModelError` where a text is not affine in the states, or the map is not its own
    inverse. Offsets of drifting states are free: orbits are the same modulo any constant there.
    """
    n, states = len(system.states), list(system.states)
    matrix, offset = np.eye(n), np.zeros(n)
    told: dict[str, str] = {}
    varies = False
    for name, text in system.symmetry.items():
        if name not in states:
            told[name] = str(text)
            continue
        form, row = _form(system, name), states.index(name)
        varies |= any(name_set(c) - {"pi"} for c in form.terms.values())
        coefficients = {basis: _value(system, name, c) for basis, c in form.terms.items()}
        offset[row] = coefficients.pop(CONSTANT, 0.0)
        matrix[row] = [coefficients.get(State(state), 0.0) for state in states]
    _check_involution(system, matrix, offset)
    _check_modes(told)
    told |= {image: name for name, image in told.items()}
    words = ", ".join(f"{name} -> {text}" for name, text in system.symmetry.items())
    return StateMap(matrix, offset, told, words, varies)


def _form(system: EvaluatedSystem, name: str) -> LinearForm:
    """Linear form of the image of a state."""
    where, text = f"symmetry[{name!r}]", system.symmetry[name]
    known = {*system.states, *system.parameters, *system.definitions, "pi"}
    equation = Equation.read(text, where, known)
    structure = system.structure
    node = structure.static_form.resolver.lenient().tree(equation)
    try:
        form = structure.graph.form(node)
    except NotLinear:
        form = None
    if form is None or any(not isinstance(b, State) and b != CONSTANT for b in form.terms):
        raise ModelError(
            f"{where} = {quote(str(text))} is not affine in the states; give sums of states with"
            " constant factors, such as '-x', 'x2' or '2*c - x'"
        )
    return form


def _value(system: EvaluatedSystem, name: str, coefficient: Any) -> float:
    value = constant_value(coefficient, system.parameter_values)
    if not np.isfinite(value):
        raise ModelError(f"symmetry[{name!r}]: a coefficient is {value} for the parameters given")
    return value


def _check_involution(system: EvaluatedSystem, matrix: Floats, offset: Floats) -> None:
    """The map applied twice leaves every state where it was."""
    n = len(offset)
    twice = np.column_stack([matrix @ matrix, matrix @ offset + offset])
    sizes = np.column_stack([np.abs(matrix) @ np.abs(matrix), np.abs(matrix) @ np.abs(offset)])
    sizes[:, -1] += np.abs(offset)
    away = np.abs(twice - np.eye(n, n + 1)) > _ROUNDING * np.maximum(sizes, 1.0)
    away[[system.states.index(name) for name in system.drift_states], -1] = False
    if away.any():
        name = system.states[int(np.flatnonzero(away.any(axis=1))[0])]
        raise ModelError(
            f"symmetry: applied twice, the map does not give {name!r} back; a symmetry is its own"
            " inverse, as {'x': '-x'} and {'x1': 'x2', 'x2': 'x1'} are; name all states that change"
        )
    if np.array_equal(matrix, np.eye(n)) and not offset.any():
        raise ModelError(
            "symmetry: it leaves every state as it is; name the states that change, as in"
            " {'x': '-x', 'v': '-v'}, or leave it out"
        )


def _check_modes(told: Mapping[str, str]) -> None:
    """A mode has one image, of which it is the image."""
    for name, image in told.items():
        back = told.get(image, name)
        others = [mode for mode, other in told.items() if other == image and mode != name]
        if back != name or others:
            other = others[0] if others else back
            raise ModelError(
                f"symmetry: the modes {name!r} and {other!r} cannot both belong to {image!r}; two"
                " modes are images of each other, or a mode is its own image"
            )
