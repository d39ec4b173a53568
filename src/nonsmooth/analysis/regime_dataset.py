"""Verdicts as variables of datasets, for one motion or for many."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.regime_verdict import Verdict
from nonsmooth.simulation.labels import labels_of
from nonsmooth.system.system import System

__all__ = ["numbers_of", "said_of_start"]

_PLAIN: dict[str, tuple[str, str]] = {
    "events": ("events", "events per period"),
    "impacts": ("impacts", "impacts per period"),
    "exponent": ("exponent", "largest Lyapunov exponent"),
    "error": ("exponent_error", "standard error of the exponent"),
    "k": ("K", "K of the 0-1 test"),
    "residual": ("residual", "what is left of the size of the states after a period"),
}


def numbers_of(
    system: System, verdicts: Sequence[Verdict | None], dims: tuple[str, ...], shape: Any
) -> dict[str, Any]:
    """Variables with one value for each verdict; nan, 0 and "" where there is none."""

    def variable(values: Any, name: str, **words: str) -> Any:
        return dims, np.asarray(values).reshape(shape), {"long_name": name, **words}

    time = labels_of(system).attributes("time")
    per_time = {"units": f"1/{time['units']}"} if "units" in time else {}
    variables: dict[str, Any] = {
        "period": variable(
            [v.period if v else 0 for v in verdicts], "period in strobes, 0 for none"
        ),
        "word": variable([v.word if v else "" for v in verdicts], "modes of one period"),
    }
    for field, (name, text) in _PLAIN.items():
        values = [getattr(v, field) if v else np.nan for v in verdicts]
        units = per_time if field in ("exponent", "error") else {}
        variables[name] = variable(values, text, **units)
    variables["transient_used"] = variable(
        [v.transient_used if v else 0 for v in verdicts], "strobes before what was looked at"
    )
    variables["n_uncertain"] = variable(
        [v.uncertain if v else 0 for v in verdicts], "events that rounding leaves open"
    )
    return variables | _drifts(system, verdicts, variable)


def _drifts(system: System, verdicts: Sequence[Verdict | None], variable: Any) -> dict[str, Any]:
    """Mean change of every drifting state."""
    variables = {}
    for name in system.drift_states:
        k = system.states.index(name)
        label = labels_of(system).attributes(name)["long_name"]
        per_period: npt.NDArray[np.float64] = np.array(
            [v.drift[k] if v else np.nan for v in verdicts]
        )
        lengths = np.array([v.length if v else np.nan for v in verdicts])
        variables[f"{name}_per_period"] = variable(per_period, f"{label}, per period")
        variables[f"{name}_per_time"] = variable(per_period / lengths, f"{label}, per unit time")
    return variables


def said_of_start(initial: Any) -> str:
    """An initial state as the protocol tells it."""
    if initial is None:
        return "at rest"
    return str(dict(initial)) if isinstance(initial, dict) else "a point of a dataset"
