"""Verdicts as variables of datasets, for one motion or for many."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.options import result_attributes
from nonsmooth.analysis.regimes.labels import INTERRUPTED, LABELS, Verdict
from nonsmooth.analysis.statistics.escape import escape_rate_below, said_of_chaos
from nonsmooth.runs.labels import labels_of
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["map_dataset", "numbers_of"]

Floats = npt.NDArray[np.float64]

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

    def variable(values: Any, name: str, **words: Any) -> Any:
        return dims, np.asarray(values).reshape(shape), {"long_name": name, **words}

    time = labels_of(system).attributes("time")
    per_time: dict[str, str] = {"units": f"1/{time['units']}"} if "units" in time else {}
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
    chaotic_for = [v.chaotic_for if v else 0 for v in verdicts]
    variables["chaotic_for"] = variable(chaotic_for, "strobe intervals of chaos without an end")
    variables["escape_rate_below"] = variable(
        escape_rate_below(chaotic_for), "bound of the rate per interval at which chaos may end"
    )
    variables["n_uncertain"] = variable(
        [v.uncertain if v else 0 for v in verdicts], "events that rounding leaves open"
    )
    variables["n_estimated"] = variable(
        [v.estimated if v else 0 for v in verdicts], "steps the errors of which are estimated"
    )
    return variables | _drifts(system, verdicts, variable)


def _drifts(system: System, verdicts: Sequence[Verdict | None], variable: Any) -> dict[str, Any]:
    """Mean change of every drifting state and angle."""
    variables = {}
    for name in system.drift:
        k = system.states.index(name)
        label = labels_of(system).attributes(name)["long_name"]
        per_period: npt.NDArray[np.float64] = np.array(
            [v.drift[k] if v else np.nan for v in verdicts]
        )
        lengths = np.array([v.length if v else np.nan for v in verdicts])
        variables[f"{name}_per_period"] = variable(per_period, f"{label}, per period")
        variables[f"{name}_per_time"] = variable(per_period / lengths, f"{label}, per unit time")
    if system.drift:
        values = np.array([v.progresses if v else 0 for v in verdicts], np.int8)
        words = _flags(("stands", "progresses"))
        variables["progresses"] = variable(values, "whether the motion drifts", **words)
    return variables


def map_dataset(
    system: System,
    names: tuple[str, str],
    values: tuple[Floats, Floats],
    verdicts: npt.NDArray[np.object_],
    filled: npt.NDArray[np.int64],
    options: dict[str, Any],
) -> xr.Dataset:
    """Dataset over the second and the first parameter; None is a verdict that is missing."""
    import xarray as xr

    dims, shape = (names[1], names[0]), verdicts.shape
    flat: list[Verdict | None] = list(verdicts.ravel())
    codes = np.array([LABELS.index(v.label if v else INTERRUPTED) for v in flat], np.int8)
    computed = np.array([v is not None for v in flat], np.int8).reshape(shape)
    computed[filled[:, 0], filled[:, 1]] = 0
    variables: dict[str, Any] = {
        "regime": (dims, codes.reshape(shape), {"long_name": "regime", **_flags(LABELS)}),
        "computed": (
            dims, computed, {"long_name": "how it is known", **_flags(("filled", "computed"))},
        ),
        **numbers_of(system, flat, dims, shape),
    }  # fmt: skip
    modulus = np.array([v.modulus if v else np.nan for v in flat]).reshape(shape)
    variables["multiplier"] = dims, modulus, {"long_name": "modulus of the largest multiplier"}
    variables = {
        f"{name}_of_motion" if name in names else name: each for name, each in variables.items()
    }
    coords = {
        name: ((name,), array, {"long_name": system.describe.get(name, name)})
        for name, array in zip(names, values, strict=True)
    }
    found, counts = np.unique(codes[computed.ravel() == 1], return_counts=True)
    told = [f"{count} {LABELS[code]}" for code, count in zip(found, counts, strict=True)]
    horizons = [v.chaotic_for for v in flat if v and v.chaotic_for]
    n_missing = sum(v is None for v in flat)
    message = f"computed: {', '.join(told) or 'none'}"
    if horizons:
        message += f"; {said_of_chaos(min(horizons), 'period')}"
    if n_missing:
        done = f"{len(flat) - n_missing} of {len(flat)} points are done and kept"
        message = f"interrupted by the user; {done}; {message}"
    status = "interrupted" if n_missing else "completed"
    return xr.Dataset(variables, coords, result_attributes(system, status, message, options))


def _flags(names: tuple[str, ...]) -> dict[str, Any]:
    """CF flags that say what a number stands for."""
    return {
        "flag_values": np.arange(len(names), dtype=np.int8),
        "flag_meanings": " ".join(names),
    }
