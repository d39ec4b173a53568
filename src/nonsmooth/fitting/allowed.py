"""Whether a system is allowed within the bounds of what is to be found."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from itertools import product

import numpy as np

from nonsmooth.errors import OptionError, ResultWarning
from nonsmooth.fitting.channels import Range
from nonsmooth.system.model.value_checks import condition_of
from nonsmooth.system.system import System
from nonsmooth.system.text.evaluate import evaluate
from nonsmooth.system.text.expressions import name_set

__all__ = ["check_allowed"]

_BORDER = 1e-9  # of the range, beside its ends
_LOOKS = 1000  # within bounds, at random


def check_allowed(system: System, free: Mapping[str, Range]) -> None:
    """Refuse bounds in which the system is nowhere allowed, and warn of an end at which it is not.

    Where a condition reads several of the parameters to be found, bounds that leave a corner out
    are as good as any; those in which it never holds are not. A bound may lie on the border of what
    is allowed, as 0 for a mass.
    """
    for condition, reason in system.require.items():
        tree = condition_of(condition)
        own = [name for name in free if name in name_set(tree)]
        if not own:
            continue
        ends = np.array(list(product((_BORDER, 1.0 - _BORDER), repeat=len(own))))
        inside = np.random.default_rng(0).random((_LOOKS, len(own)))
        parts = np.concatenate([ends, inside]).T
        looks = {name: free[name].low + free[name].scale * parts[k] for k, name in enumerate(own)}
        with np.errstate(all="ignore"):
            found = np.asarray(evaluate(tree, {**system.parameter_values, **looks}), bool)
        holds = np.broadcast_to(found, parts.shape[1])
        if not holds.any():
            raise OptionError(
                f"free: {condition} is required, and holds nowhere within the bounds of"
                f" {', '.join(own)}: {reason}; give other bounds"
            )
        if len(own) == 1 and not holds[:2].all():
            low, high = free[own[0]].low, free[own[0]].high
            outside = [
                f"{end:g}" for end, is_met in zip((low, high), holds, strict=False) if not is_met
            ]
            warnings.warn(
                f"free[{own[0]!r}] = ({low:g}, {high:g}): {condition} is required, and does not"
                f" hold at {' and '.join(outside)}: {reason}; the fit passes such values by, and"
                " bounds in which it holds lead it better",
                ResultWarning,
                stacklevel=3,
            )
