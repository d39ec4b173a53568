"""A spectrum of Lyapunov exponents as an xarray dataset."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.exponents.exponent_run import ExponentRun
from nonsmooth.analysis.exponents.horizon import Horizon
from nonsmooth.analysis.options import result_attributes
from nonsmooth.analysis.statistics.block_averages import block_averages
from nonsmooth.analysis.statistics.escape import escape_rate_below, said_of_chaos
from nonsmooth.engine.status import CURES, Status
from nonsmooth.runs.labels import labels_of, with_doubts
from nonsmooth.system.system import System

__all__ = ["exponent_dataset", "kaplan_yorke_dimension"]

Vector = npt.NDArray[np.float64]

# ends of a run whose record is there: an interruption leaves out what would confirm it
_WHOLE = (Status.COMPLETED, Status.INTERRUPTED)


def exponent_dataset(
    system: System,
    run: ExponentRun,
    horizon: Horizon,
    unit: float,
    counts: str,
    options: dict[str, Any],
) -> xr.Dataset:
    """Exponents in order with their errors, the running estimate, sum and dimension.

    ``unit``: how many of what the record ``counts`` in a window of the clock
    """
    running = _running(run)
    values = running[-1] if len(running) else np.full(run.growth.shape[1], np.nan)
    order = np.argsort(-values, kind="stable")
    values, running = values[order], running[:, order]
    with np.errstate(invalid="ignore"):  # of lost columns
        rates = np.diff(run.growth[:, order], axis=0) / np.diff(run.times)[:, None]
    finite = np.isfinite(values)
    blocks = block_averages(rates[:, finite])
    errors = np.full(values.size, np.nan)
    errors[finite] = blocks.standard_error
    duration = float(run.times[-1] - run.times[0]) if len(running) else 0.0
    whole = values.size == run.n_states
    chaotic_for = horizon.chaotic_for * unit
    time = labels_of(system).attributes("time")
    per_time = {"units": f"1/{time['units']}"} if "units" in time else {}
    variables: dict[str, Any] = {
        "lyapunov_exponent": (
            ("exponent",), values, {"long_name": "Lyapunov exponent", **per_time},
        ),
        "standard_error": (
            ("exponent",), errors, {"long_name": "standard error of the exponent", **per_time},
        ),
        "running_exponent": (
            ("time", "exponent"), running,
            {"long_name": "Lyapunov exponent up to that time", **per_time},
        ),
        "exponent_sum": (
            (), float(np.sum(values)) if whole else np.nan,
            {"long_name": "sum of all exponents", **per_time},
        ),
        "kaplan_yorke_dimension": (
            (), kaplan_yorke_dimension(values, errors, duration, complete=whole),
            {"long_name": "Kaplan-Yorke dimension"},
        ),
    }  # fmt: skip
    coords = {
        "exponent": ("exponent", np.arange(1, values.size + 1), {"long_name": "number"}),
        "time": ("time", run.times[1:], time),
    }
    told = {
        "settled": int(not horizon.unsettled and run.status in _WHOLE),
        "chaotic_for": chaotic_for,
        "escape_rate_below": float(escape_rate_below(chaotic_for)),
        "duration": duration,
        "n_events": run.n_events,
        "n_impacts": run.n_impacts,
        "certified": int(run.n_uncertain == run.n_estimated == 0),
        "n_uncertain": run.n_uncertain,
        "n_estimated": run.n_estimated,
        "block_length": blocks.length,
        "n_blocks": blocks.n_blocks,
        "blocks_independent": int(blocks.independent),
        **({} if system.period_value is None else {"period": system.period_value}),
        **options,
    }
    message = _message(run)
    if horizon.unsettled:
        message += f"; {horizon.unsettled}"
    elif chaotic_for:
        message += f"; {said_of_chaos(chaotic_for, counts)}"
    attrs = result_attributes(system, run.status.word, message, told)
    return xr.Dataset(variables, coords, attrs)


def kaplan_yorke_dimension(
    values: Vector, errors: Vector, duration: float, *, complete: bool
) -> float:
    """Dimension at which the sum of the leading exponents would be zero; nan where unknown.

    ``values`` decrease; those that cannot be told from zero count as zero.
    """
    if not np.all(values <= np.inf) or duration <= 0.0:  # nan
        return float("nan")
    unclear = np.maximum(3.0 * np.nan_to_num(errors), 1.0 / duration)
    total = 0.0
    for j, value in enumerate(np.where(np.abs(values) <= unclear, 0.0, values)):
        if total + value < 0.0:
            return j - total / float(value)
        total += float(value)
    return float(values.size) if complete else float("nan")


def _running(run: ExponentRun) -> Vector:
    """Averages from the end of the transient to the end of each interval."""
    if len(run.growth) < 2:
        return np.empty((0, run.growth.shape[1]))
    with np.errstate(invalid="ignore"):
        total = run.growth[1:] - run.growth[0]
    total[np.isneginf(run.growth[1:])] = -np.inf
    return np.asarray(total / (run.times[1:] - run.times[0])[:, None])


def _message(run: ExponentRun) -> str:
    if run.status == Status.COMPLETED:
        return with_doubts(run.status.word, run.n_uncertain, run.n_estimated)
    text = f"{run.status.word} at t = {run.end_time:.9g}: {CURES[run.status]}"
    return text + ("" if len(run.growth) > 1 else "; there is no record, so no exponent")
