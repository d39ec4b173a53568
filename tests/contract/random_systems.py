"""Random systems of two smooth modes, as texts and as functions made from the same texts.

Both modes push the first state towards the other one's guard, a curved and moving surface.
What happens there is a reset that is not linear, or none.
"""

from typing import NamedTuple

import numpy as np

import nonsmooth as ns
from reference.nonlinear import SmoothExit, SmoothMode, SmoothModel
from reference.nonlinear_models import Case
from reference.power_series import cos, exp, sin, sqrt

FUNCTIONS = {"sin": sin, "cos": cos, "exp": exp, "sqrt": sqrt}
NUMBERS = ["k0", "k1", "k2", "k3"]


class Drawn(NamedTuple):
    """The words of a system and a start inside mode ``a``."""

    states: list[str]
    parameters: dict[str, float]
    rates: dict[str, dict[str, str]]
    guards: dict[str, str]
    resets: dict[str, dict[str, str]]
    start: list[float]
    times: list[float]

    def system(self) -> ns.System:
        modes = {
            name: ns.Mode(
                self.rates[name],
                exits=[ns.Exit(self.guards[name], to=other, reset=self.resets[name])],
            )
            for name, other in (("a", "b"), ("b", "a"))
        }
        return ns.System(states=self.states, parameters=self.parameters, modes=modes)

    def case(self) -> Case:
        modes = {}
        for name, other in (("a", "b"), ("b", "a")):
            reset = [self.resets[name].get(state, state) for state in self.states]
            way = SmoothExit(self._scalar(self.guards[name]), other, self._vector(reset))
            modes[name] = SmoothMode(self._vector(list(self.rates[name].values())), [way])
        model = SmoothModel(self.states, modes)
        return Case(model, self.parameters, self.start, "a", self.times)

    def _vector(self, texts):
        parts = [self._scalar(text) for text in texts]
        return lambda t, z, p: [part(t, z, p) for part in parts]

    def _scalar(self, text):
        code = compile(text, "a drawn text", "eval")

        def value(t, z, p):
            names = dict(zip(self.states, z, strict=True)) | vars(p)
            return eval(code, {"__builtins__": {}}, FUNCTIONS | names | {"t": t})

        return value


def draw_system(seed: int) -> Drawn:
    rng = np.random.default_rng(seed)
    states = ["x", "y", "z"][: rng.integers(2, 4)]
    parameters = {name: round(float(rng.uniform(0.3, 1.5)), 3) for name in NUMBERS}
    others = states[1:]
    surface = f"x + k0/4*{rng.choice(others)}**2 - {_term(rng, states)}/4"
    rates = {name: _rates(rng, states, push) for name, push in (("a", "+ 6/5"), ("b", "- 6/5"))}
    guards = {"a": f"1/2 - ({surface})", "b": f"{surface} + 1/2"}
    resets = {name: _reset(rng, states) for name in "ab"}
    start = [float(x) for x in np.append(-0.3, rng.uniform(-0.4, 0.4, len(others)))]
    times = [1.7 * (k + 1) for k in range(6)]
    return Drawn(states, parameters, rates, guards, resets, start, times)


def _term(rng, states):
    """A bounded smooth function of some states, or of time."""
    one, two = rng.choice(states, 2)
    return str(
        rng.choice(
            [
                f"sin({one} + k1*{two})",
                f"cos(k2*t)*{one}/sqrt(1 + {one}**2)",
                f"k3*{one}*exp(-{two}**2)",
                f"{one}*{two}/(1 + {one}**2 + {two}**2)",
                "sin(k1*t + k2)",
                f"cos({one}*t/(1 + t))",
            ]
        )
    )


def _rates(rng, states, push):
    rates = {}
    for state in states:
        other = rng.choice([name for name in states if name != state])
        turn = rng.choice(["+", "-"])
        text = f"-k{rng.integers(4)}*{state}/2 {turn} k{rng.integers(4)}*{other}/2"
        text = f"{text} + {_term(rng, states)}/2"
        rates[state] = f"{text} {push}" if state == states[0] else text
    return rates


def _reset(rng, states):
    if rng.random() < 0.4:
        return {}
    state = str(rng.choice(states[1:]))
    return {state: f"-k{rng.integers(4)}*{state}/2 + {_term(rng, states)}/3"}
