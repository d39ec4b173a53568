"""Labels of regimes, the rules by which evidence becomes one, and what is known of a motion."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.status import Status
from nonsmooth.system.system import System

__all__ = [
    "ABSORBED",
    "CHAOTIC",
    "EQUILIBRIUM",
    "INADMISSIBLE",
    "INTERRUPTED",
    "LABELS",
    "LIMIT_CYCLE",
    "LOCKED",
    "PERIODIC",
    "QUASI_PERIODIC",
    "REPEATING",
    "UNSETTLED",
    "Verdict",
    "contradiction",
    "is_near_zero",
    "label_of_end",
    "label_of_growth",
]

Floats = npt.NDArray[np.float64]

EQUILIBRIUM, LOCKED, PERIODIC = "equilibrium", "locked", "periodic"
LIMIT_CYCLE, QUASI_PERIODIC, CHAOTIC = "limit-cycle", "quasi-periodic", "chaotic"
ABSORBED, UNSETTLED = "absorbed", "unsettled"
INADMISSIBLE, INTERRUPTED = Status.INADMISSIBLE.word, Status.INTERRUPTED.word

REPEATING = (EQUILIBRIUM, LOCKED, PERIODIC)  # labels of motions that have a period

# The number of a label in a map is its place here; new ones come last.
LABELS = (
    EQUILIBRIUM, LOCKED, PERIODIC, LIMIT_CYCLE, QUASI_PERIODIC, CHAOTIC, ABSORBED, UNSETTLED,
    Status.DIVERGED.word, Status.UNDECIDED.word, Status.NONUNIQUE.word, INADMISSIBLE,
    Status.STEP_LIMIT.word, Status.SINGULAR.word, Status.SLIDING.word, Status.REFUSED.word,
    INTERRUPTED, Status.EVENT_LIMIT.word,
)  # fmt: skip

ERRORS = 3.0  # standard errors that an exponent must keep from zero
LARGEST_GROWTH = 3.0  # logarithm of the growth in a window that may still be none
UNSURE = 2.0  # times that growth, as a standard error, tells no label
FALLING = 0.75  # of an exponent is left in the next window where growth is linear
NEARLY = 0.01  # of the scatter of strobes is left between those that repeat nearly
ROUNDING = 1e-9  # of the growth in a window
K_CHAOTIC, K_REGULAR = 0.2, 0.5  # below, and above, the 0-1 test contradicts the exponent


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
    chaotic_for: int = 0  # strobes for which chaos was seen, without an end
    uncertain: int = 0
    estimated: int = 0
    progresses: int = 0  # whether a state drifts from period to period
    last: tuple[Floats, int] | None = None  # state and mode at the last strobe that was looked at

    @property
    def is_settled(self) -> bool:
        """Whether the label is final."""
        return self.label != UNSETTLED

    def named(self, label: str, reason: str) -> Verdict:
        """The same evidence with a label."""
        return replace(self, label=label, reason=reason)

    def unsettled(self, reason: str) -> Verdict:
        """The same evidence without a label."""
        return self.named(UNSETTLED, reason)

    def with_multipliers(self, multipliers: npt.NDArray[np.complex128]) -> Verdict:
        """The same evidence with multipliers over the period, and their exponent."""
        modulus, exponent = float(np.abs(multipliers).max(initial=0.0)), np.nan
        if multipliers.size:
            with np.errstate(divide="ignore"):  # all multipliers are zero
                exponent = float(np.log(modulus)) / (self.period * self.length)
        return replace(self, multipliers=multipliers, exponent=exponent)

    @property
    def modulus(self) -> float:
        """Modulus of the largest multiplier, nan where none is known."""
        return (
            float(np.abs(self.multipliers).max(initial=-np.inf))
            if self.multipliers.size
            else np.nan
        )


def label_of_end(status: Status, system: System) -> str:
    """Label of a motion that ended: impacts that accumulate, and exits to 'stop', absorb.

    Where no exit has a reset there are no impacts: switches may accumulate without end.
    """
    hits = any(exit_.reset for mode in system.modes.values() for exit_ in mode.exits)
    if status == Status.STOPPED or (status == Status.EVENT_LIMIT and hits):
        return ABSORBED
    return status.word


def label_of_growth(
    rates: tuple[float, float],
    errors: tuple[float, float],
    duration: float,
    attracting: str,
    *,
    turns: bool,
) -> str:
    """Label that the exponents of two windows give, "" where they give none or differ.

    No window tells an exponent better than to one over its duration. A motion that still settles
    has a small exponent too: it is as steady as the damping, while that of quasi-periodic motion
    comes and goes, or falls as neighbours part linearly.

    attracting: label of a motion that others approach although its strobes do not repeat, as a
    direction without growth is left out; "" where there is none
    turns: whether strobes of both windows keep their order on a closed curve, which chaos does not
    and which needs no exponent: where neighbours come and go by large factors, or so evenly that no
    error is seen, the exponent decides nothing
    """
    least = LARGEST_GROWTH / duration
    if rates == (-np.inf, -np.inf):
        return attracting
    if not all(map(math.isfinite, errors)):
        return ""
    if turns and min(rates) <= least:
        return QUASI_PERIODIC
    both = float(np.hypot(*errors))
    if abs(rates[0] - rates[1]) > max(ERRORS * both, least):
        return ""
    mean, enough = 0.5 * (rates[0] + rates[1]), max(0.5 * ERRORS * both, least)
    if mean > enough and min(rates) > least:
        return CHAOTIC
    if attracting and mean < -enough and max(rates) < -least:
        return attracting
    if max(map(abs, rates)) > least or max(errors) > UNSURE * least:
        return ""
    falls = abs(rates[1]) < FALLING * abs(rates[0])
    near_zero = is_near_zero(rates, errors, duration)
    return QUASI_PERIODIC if falls or near_zero else ""


def is_near_zero(rates: tuple[float, float], errors: tuple[float, float], duration: float) -> bool:
    """Whether the exponent of each window is within three standard errors of zero."""
    rounding = ROUNDING / duration
    return all(
        abs(rate) <= ERRORS * error + rounding for rate, error in zip(rates, errors, strict=True)
    )


def contradiction(label: str, k: float, nearest: float, *, turns: bool) -> str:
    """How the strobes contradict what an exponent says, "" where they do not.

    k: K of the 0-1 test; nearest: how near strobes come to repeating, in their scatter; turns:
    whether they keep their order on a closed curve, of which neither says anything: K takes jumps,
    and beats longer than the series, for chaos
    """
    if label == CHAOTIC and k < K_CHAOTIC:
        return f"K = {k:.2f}"
    if label != QUASI_PERIODIC or turns:
        return ""
    if k > K_REGULAR:
        return f"K = {k:.2f}"
    if nearest < NEARLY:
        return "strobes nearly repeat, as they do while a motion settles slowly"
    return ""
