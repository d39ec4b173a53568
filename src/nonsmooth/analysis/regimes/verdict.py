"""What is known of one motion: its label and the evidence for it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.regimes.labels import UNSETTLED

__all__ = ["TESTED", "RegimeProtocol", "Verdict"]

TESTED = 200  # strobes of evidence from which the 0-1 test says something

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class RegimeProtocol:
    """How a motion is looked at; lengths in strobes."""

    transient: int
    record: int
    evidence: int
    longest: int
    confirm: int  # strobes for which a chaotic motion is run on
    phase: float
    match: float

    @property
    def is_survey(self) -> bool:
        """Whether exponents alone decide, as there are too few strobes for the 0-1 test."""
        return self.evidence < TESTED


@dataclass(frozen=True)
class Verdict:
    """Label of a motion and the numbers that it rests on; n states."""

    label: str
    reason: str
    transient_used: int
    length: float  # time between strobes
    drift: Floats  # (n,): change of each state from strobe to strobe
    period: int = 0
    word: str = ""
    events: float = np.nan  # per strobe interval
    impacts: float = np.nan
    multipliers: npt.NDArray[np.complex128] = field(default_factory=lambda: np.zeros(0, complex))
    exponent: float = np.nan
    error: float = np.nan
    k: float = np.nan
    residual: float = np.nan
    uncertain: int = 0
    estimated: int = 0
    progresses: int = 0  # whether a state drifts from period to period
    last: tuple[Floats, int] | None = None  # state and mode at the last strobe that was looked at

    @property
    def is_settled(self) -> bool:
        """Whether the label is final."""
        return self.label != UNSETTLED

    def unsettled(self, reason: str) -> Verdict:
        """The same evidence without a label."""
        return replace(self, label=UNSETTLED, reason=reason)

    @property
    def modulus(self) -> float:
        """Modulus of the largest multiplier, nan where none is known."""
        return (
            float(np.abs(self.multipliers).max(initial=-np.inf))
            if self.multipliers.size
            else np.nan
        )
