"""For how long chaos was seen, and how fast it may still end.

No finite run tells a chaotic attractor from a long chaotic transient. But motions leave a chaotic
set that is none at a rate of their own: once they have forgotten their starts, a share exp(-k) is
left after each period, whatever the time before. A motion that was followed for N periods on such a
set is still there with the probability exp(-k N). Rates above -log(0.05)/N would have ended
19 motions in 20 by then, and so they are excluded at 95 %. Motions that do not depend on each other
add their periods up, since their probabilities multiply.
"""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["escape_rate_below", "said_of_chaos"]

_RISK = 0.05  # of the statement that the rate is lower


def escape_rate_below(observed: Any) -> Any:
    """Upper 95 % bound of the escape rate per step, of no escape in so many steps.

    nan where no chaos was observed, which is what zero steps stand for. Steps of motions that do
    not depend on each other add up.
    """
    steps = np.asarray(observed, float)
    return np.divide(-np.log(_RISK), steps, out=np.full(steps.shape, np.nan), where=steps > 0)


def said_of_chaos(observed: float, unit: str) -> str:
    """The horizon in words, such as ``chaotic for at least 900 periods, escape rate below ...``."""
    bound = float(escape_rate_below(observed))
    seen = f"chaotic for at least {observed:.10g} {unit}s"
    return f"{seen}, escape rate below {bound:.2g} per {unit} (95 %)"
