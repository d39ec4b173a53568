"""The three problems: parameters, states, start, and how each is told to the implementations."""

from dataclasses import dataclass
from math import pi


@dataclass(frozen=True)
class Problem:
    """A forced system at rest at tau = 0, sampled once per forcing period.

    `error_bound` is the largest error after 20 periods that counts as exact; the errors of heyoka,
    a few times the rounding of a result times its growth along the orbit, set its scale.
    """

    name: str
    states: tuple[str, ...]
    parameters: dict[str, float]
    error_bound: float

    @property
    def period(self):
        return 2.0 * pi / self.parameters["omega"]

    @property
    def rest(self):
        return dict.fromkeys(self.states, 0.0)


SOFT_IMPACT = Problem(
    "soft impact",
    ("x", "v"),
    {"zeta": 0.01, "e": 1.26, "beta": 29.0, "a": 0.7, "omega": 0.85},
    1e-12,
)
MOLE = Problem(
    "mole",
    ("p", "y", "q", "v"),
    {"a": 0.3, "b": 0.1, "xi": 0.1, "omega": 1.6, "g": 0.02},
    1e-12,
)
CHAIN = Problem(
    "chain",
    ("x1", "x2", "x3", "v1", "v2", "v3"),
    {"m": 1.0, "k": 1.0, "c": 0.05, "k_stop": 10.0, "e": 0.5, "A": 0.5, "omega": 0.45},
    2e-12,
)
PROBLEMS = {"soft_impact": SOFT_IMPACT, "mole": MOLE, "chain": CHAIN}
