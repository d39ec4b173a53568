"""Values of texts by numpy, with a namespace of its own: no code shared with the package."""

from __future__ import annotations

import math
import re
from functools import reduce
from typing import Any

import numpy as np

from properties.words import Words, modes_of

FUNCTIONS = {
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "exp": np.exp,
    "log": np.log,
    "sqrt": np.sqrt,
    "tanh": np.tanh,
    "atan": np.arctan,
    "sign": np.sign,
    "abs": np.abs,
    "min": lambda *values: reduce(np.minimum, values),
    "max": lambda *values: reduce(np.maximum, values),
    "heaviside": lambda x: np.where(x >= 0, 1.0, 0.0),
    "clip": lambda x, low, high: np.minimum(np.maximum(x, low), high),
    "where": np.where,
    "pi": math.pi,
    "__builtins__": {},
}


def elementwise(text: str) -> str:
    """A text with its conditions joined for arrays; each comparison stands in parentheses."""
    for word, sign in (("and", "&"), ("or", "|"), ("not", "~")):
        text = re.sub(rf"\b{word}\b", sign, text)
    return text


class Texts:
    """Texts of a system at states and times; definitions and surfaces are named texts."""

    def __init__(self, words: Words) -> None:
        self.states = list(words["states"])
        self.modes = modes_of(words)
        constants = {k: float(v) for k, v in words.get("parameters", {}).items()}
        self._always = FUNCTIONS | constants
        self._named = dict(words.get("definitions", {}))
        self._named |= {name: s["function"] for name, s in words.get("surfaces", {}).items()}
        self._codes: dict[str, Any] = {}

    def value(self, text: str | float, z: np.ndarray, t: Any) -> np.ndarray:
        """Value of a text at states ``z[..., i]`` and times ``t``."""
        return self._shaped(self._eval(text, self._names(z, t)), z)

    def _names(self, z: np.ndarray, t: Any) -> dict[str, Any]:
        names = self._always | {"t": t}
        for i, state in enumerate(self.states):
            names[state] = z[..., i]
        for name, inner in self._named.items():
            names[name] = self._eval(inner, names)
        return names

    def _eval(self, text: str | float, names: dict[str, Any]) -> Any:
        code = self._codes.get(str(text))
        if code is None:
            code = self._codes[str(text)] = compile(elementwise(str(text)), "a drawn text", "eval")
        return eval(code, names)

    @staticmethod
    def _shaped(value: Any, z: np.ndarray) -> np.ndarray:
        value, shape = np.asarray(value, float), np.shape(z)[:-1]
        return value if value.shape == shape else np.broadcast_to(value, shape)

    def slaved(self, mode: str) -> dict[str, str]:
        """Texts that vanish, by the state that is slaved."""
        return {
            state: "({}) - ({})".format(*(text if "=" in text else f"{state} = {text}").split("="))
            for state, text in self.modes[mode].get("slaved", {}).items()
        }

    def field(self, mode: str, z: np.ndarray, t: Any) -> np.ndarray:
        """Rates of all states; those of slaved ones along the others."""
        flow = self.modes[mode]["flow"]
        rates, names = np.zeros(np.shape(z)), self._names(z, t)
        for i, state in enumerate(self.states):
            if state in flow:
                rates[..., i] = self._eval(flow[state], names)
        for state, text in self.modes[mode].get("slaved", {}).items():
            if "=" not in text:
                rates[..., self.states.index(state)] = self.along(text, z, t, rates)
        given = self.modes[mode].get("slaved", {})
        solved = {k: text for k, text in self.slaved(mode).items() if "=" in given[k]}
        if solved:
            self._add_implicit_rates(solved, z, t, rates)
        return rates

    def _add_implicit_rates(
        self, vanishing: dict[str, str], z: np.ndarray, t: Any, rates: np.ndarray
    ) -> None:
        """Rates of states given by equations, such that what vanishes has no rate.

        Where the equations do not tell them, to first order, they are not a number.
        """
        columns = [self.states.index(state) for state in vanishing]
        texts = list(vanishing.values())
        moved = np.stack([self.along(text, z, t, rates) for text in texts], axis=-1)
        slopes = np.empty((*np.shape(moved), len(columns)))
        for k, column in enumerate(columns):
            one = np.zeros(np.shape(z))
            one[..., column] = 1.0
            for i, text in enumerate(texts):
                slopes[..., i, k] = self._slope(text, z, t, one)
        flat = np.linalg.det(slopes) == 0.0
        slopes[flat] = np.eye(len(columns))
        found = -np.linalg.solve(slopes, moved[..., None])[..., 0]
        found[flat] = np.nan
        rates[..., columns] = found

    def _slope(self, text: str, z: np.ndarray, t: Any, way: np.ndarray, step: float = 1e-5) -> Any:
        """Derivative of a smooth text in one direction of the states."""
        return (self.value(text, z + step * way, t) - self.value(text, z - step * way, t)) / (
            2 * step
        )

    def along(self, text: str, z: np.ndarray, t: Any, rates: np.ndarray, step: float = 1e-5) -> Any:
        """Rate of a smooth text along a field, by differences: to about 1e-9 where sizes are 1."""
        up = self.value(text, z + step * rates, t + step)
        down = self.value(text, z - step * rates, t - step)
        return (up - down) / (2 * step)

    def change(self, text: str, z: np.ndarray, t: float, error: float) -> float:
        """What errors of the states at one point, and of the time, make of a text: as it stands,
        without derivatives, for flat texts have none."""
        moves = error * np.eye(len(self.states) + 1)
        value, total = float(self.value(text, z, t)), np.zeros(len(moves))
        for signed in (moves, -moves):
            moved = self.value(text, z + signed[:, :-1], t + signed[:, -1])
            total = np.maximum(total, np.abs(moved - value))
        return float(total.sum())

    def gradient(self, text: str, z: np.ndarray, t: float, step: float = 1e-5) -> np.ndarray:
        """Derivatives of a smooth text by the states at one point."""
        moves = step * np.eye(len(self.states))
        return (self.value(text, z + moves, t) - self.value(text, z - moves, t)) / (2 * step)
