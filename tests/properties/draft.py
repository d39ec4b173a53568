"""A system while it is drawn: numbers, smooth terms and piecewise terms by chance."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from properties.words import Switch

_MOST_PARAMETERS = 9


@dataclass
class Draft:
    """Rates as lists of terms: those of all modes, and those of single modes beside them."""

    rng: np.random.Generator
    pairs: list[tuple[str, str]] = field(default_factory=list)
    singles: list[str] = field(default_factory=list)
    parameters: dict[str, float] = field(default_factory=dict)
    rates: dict[str, list[str]] = field(default_factory=dict)
    modes: dict[str, dict[str, list[str]]] = field(default_factory=lambda: {"flow": {}})
    exits: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    slaved: dict[str, dict[str, str]] = field(default_factory=dict)
    surfaces: dict[str, dict[str, Any]] = field(default_factory=dict)
    definitions: dict[str, str] = field(default_factory=dict)
    switches: list[Switch] = field(default_factory=list)
    features: set[str] = field(default_factory=set)
    frequency: str | None = None
    aperiodic: bool = False
    ends: list[str] = field(default_factory=list)  # of chains
    at_zero: set[str] = field(default_factory=set)  # states that begin there

    # ------------------------------------------------------------ chance

    def chance(self, share: float) -> bool:
        return bool(self.rng.random() < share)

    def pick(self, items: Any) -> Any:
        return items[int(self.rng.integers(len(items)))]

    def number(self, low: float, high: float) -> str:
        """A number as it stands in a text, or a parameter with that value."""
        value = round(float(self.rng.uniform(low, high)), 3)
        if self.chance(0.4) and len(self.parameters) < _MOST_PARAMETERS:
            name = f"p{len(self.parameters)}"
            self.parameters[name] = value
            return name
        return repr(value) if value >= 0 else f"({value!r})"

    # ------------------------------------------------------------ names

    @property
    def states(self) -> list[str]:
        return [*(s for pair in self.pairs for s in pair), *self.singles]

    @property
    def moving(self) -> list[str]:
        """States that no mode slaves."""
        slaved = {state for relations in self.slaved.values() for state in relations}
        return [state for state in self.states if state not in slaved]

    @property
    def driven(self) -> list[str]:
        """States whose rates take any term: no positions."""
        return [*(v for _, v in self.pairs), *self.singles]

    def exit_name(self) -> str:
        return f"e{sum(map(len, self.exits.values()))}"

    def add(self, state: str, term: str, mode: str | None = None) -> None:
        target = self.rates if mode is None else self.modes[mode]
        target.setdefault(state, []).append(term)

    # ------------------------------------------------------------ forcing

    def omega(self) -> str:
        """The angular frequency of the forcing, drawn when first asked for."""
        if self.frequency is None:
            self.frequency = "omega"
            self.parameters["omega"] = round(float(self.rng.uniform(0.7, 4.0)), 3)
            self.features.add("forced")
        return self.frequency

    def harmonic(self, low: float, high: float) -> str:
        multiple = self.pick(["", "", "", "2*", "3*"])
        shape = self.pick(["cos", "sin"])
        shift = self.pick(["", f" + {self.number(0, 3)}"])
        return f"{self.number(low, high)}*{shape}({multiple}{self.omega()}*t{shift})"

    # ------------------------------------------------------------ smooth terms

    def line(self, count: int = 2) -> str:
        """A linear function of some states."""
        some = self.rng.choice(self.moving, min(count, len(self.moving)), replace=False)
        first, *others = (str(state) for state in some)
        return " ".join(
            [first, *(f"{self.pick('+-')} {self.number(0.2, 1.2)}*{s}" for s in others)]
        )

    def smooth(self) -> str:
        """A smooth term that is not linear; nearly all of them are bounded or bounded by lines."""
        a, b = self.pick(self.moving), self.pick(self.moving)
        k, q = self.number(0.2, 1.0), self.line()
        self.features.add("nonlinear")
        return str(
            self.pick(
                [
                    f"{k}*sin({q})",
                    f"{k}*cos({a})*{b}",
                    f"{k}*tanh({q})",
                    f"{k}*{a}*{b}/(1 + {a}**2 + {b}**2)",
                    f"{k}*{a}/(1 + {b}**2)",
                    f"{k}*exp(-{a}**2)",
                    f"{k}*sqrt(1 + ({q})**2)",
                    f"{k}*atan({q})",
                    f"{k}/4*{a}*{b}",
                    f"{k}/4*({a}**2 - {b})",
                ]
            )
        )

    # ------------------------------------------------------------ piecewise terms

    def switching(self) -> str:
        """A function that changes sign somewhere near the start."""
        kind = self.rng.random()
        if kind < 0.55:
            return f"{self.line(self.pick([1, 1, 2]))} - {self.number(-0.6, 0.6)}"
        if kind < 0.7:
            self.features.add("surface in time")
            return f"{self.line(1)} - {self.harmonic(0.1, 0.6)}"
        self.features.add("curved surface")
        a, b = self.pick(self.moving), self.pick(self.moving)
        if kind < 0.85:
            return f"{a}**2 + {b}**2/2 - {self.number(0.2, 1.0)}"
        return self.pick([f"{a} - sin({self.line()})", f"{a}*{b} - {self.number(-0.3, 0.3)}"])

    def piecewise(self, mode: str | None) -> str:
        """A piecewise term, its switching functions noted."""
        q, k, other = self.switching(), self.number(0.2, 1.2), self.line()
        c = self.number(0.1, 0.8)
        self.features.add("surfaces")
        form = int(self.rng.integers(12))
        if form == 9:
            self.note(mode, f"({q}) + {c}", f"({q}) - {c}")
            return f"{k}*clip({q}, -{c}, {c})"
        if form == 10:
            q2 = self.switching()
            self.note(mode, q)
            self.switches.append(Switch(q2, mode, q))
            return f"where({q} > 0, {k}*abs({q2}), {c}*({q}))"
        if form == 11:
            self.note(mode, f"({q}) - ({other})")
            return f"{k}*max({q}, {other})"
        self.note(mode, q)
        return [
            f"{k}*sign({q})",
            f"-{k}*sign({q})",
            f"{k}*abs({q})",
            f"-{k}*max({q}, 0)",
            f"{k}*min(0, {q})",
            f"where({q} > 0, -{k}*({other}), {c})",
            f"where(0 <= {q}, {k}, -{c}*({other}))",
            f"-{k}*heaviside({q})",
            f"({q})/(1 + abs({q}))",
        ][form]

    def note(self, mode: str | None, *functions: str) -> None:
        self.switches += [Switch(text, mode) for text in functions]
