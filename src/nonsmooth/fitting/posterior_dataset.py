"""A chain as a dataset: moments, intervals, and whether the chain is long enough."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.analysis.options import derived_attributes
from nonsmooth.fitting.chain import Chain, require_emcee

__all__ = ["posterior_dataset", "split_r_hat"]

Floats = npt.NDArray[np.float64]

_ENDS = (0.025, 0.975)
_LONG = 50.0  # autocorrelation times: from there on their estimate is trusted
_AGREE = 1.05  # split R-hat up to which walkers agree
_LOST = 0.02  # of the steps
_FEWEST = 10  # draws of which something can be said


def posterior_dataset(
    fit: xr.Dataset,
    names: list[str],
    values_of: Callable[[Floats], Floats],
    chain: Chain,
    transient: int,
    options: dict[str, Any],
) -> xr.Dataset:
    """Dataset of what was drawn after a transient."""
    values = values_of(chain.places[transient:])
    draws, walkers, count = values.shape
    moved = chain.accepted[transient:]
    acceptance = moved.mean(axis=0) if draws else np.full(walkers, np.nan)
    variables: dict[str, Any] = {
        "posterior_value": (
            ("walker", "draw", "parameter"), values.swapaxes(0, 1), {"long_name": "drawn value"},
        ),
        "log_probability": (
            ("walker", "draw"), chain.heights[transient:].T,
            {"long_name": "logarithm of the posterior, up to a constant"},
        ),
        "acceptance": (
            "walker", acceptance,
            {"long_name": "part of the steps in which the walker has moved"},
        ),
    }  # fmt: skip
    times, agreement = np.full(count, np.nan), np.full(count, np.nan)
    if draws >= _FEWEST:
        times = autocorrelation_times(values)
        agreement = np.array([split_r_hat(values[:, :, i].T) for i in range(count)])
        variables |= _moments(values.reshape(-1, count))
    over: Any = "parameter"
    variables |= {
        "autocorrelation_time": (
            over, times, {"long_name": "autocorrelation time", "units": "steps"},
        ),
        "effective_number": (
            over, draws * walkers / times, {"long_name": "number of independent draws"},
        ),
        "split_r_hat": (over, agreement, {"long_name": "split R-hat, 1 where walkers agree"}),
        **_bounds(fit, names),
    }  # fmt: skip
    status, message = _ended(names, draws, times, agreement, chain)
    ended = {"status": status, "message": message, "n_lost": chain.n_lost}
    attrs = derived_attributes(fit) | ended | options
    words = {"long_name": "what is found"}
    coords = {"parameter": (over, np.array(names), words)}
    if draws >= _FEWEST:
        coords["parameter_0"] = ("parameter_0", np.array(names), words)
    return xr.Dataset(variables, coords, attrs)


def _moments(drawn: Floats) -> dict[str, Any]:
    low, high = np.quantile(drawn, _ENDS, axis=0)
    deviation = drawn.std(axis=0, ddof=1)
    with np.errstate(invalid="ignore", divide="ignore"):  # of walkers that never moved
        correlation = np.cov(drawn.T).reshape(low.size, low.size) / np.outer(deviation, deviation)
    columns = {
        "mean": (drawn.mean(axis=0), "mean"),
        "standard_deviation": (deviation, "standard deviation"),
        "interval_low": (low, "2.5 % of the draws lie below"),
        "interval_high": (high, "2.5 % of the draws lie above"),
    }
    found: dict[str, Any] = {
        name: ("parameter", each, {"long_name": words}) for name, (each, words) in columns.items()
    }
    found["correlation"] = (
        ("parameter", "parameter_0"), correlation, {"long_name": "correlation"},
    )  # fmt: skip
    return found


def _bounds(fit: xr.Dataset, names: list[str]) -> dict[str, Any]:
    """Bounds of the fit; noise is positive."""
    own = fit.sizes["parameter"]
    return {
        f"{side}_bound": (
            "parameter",
            np.append(fit[f"{side}_bound"].values, np.full(len(names) - own, beyond)),
            {"long_name": words},
        )
        for side, beyond, words in (
            ("lower", 0.0, "least value allowed"), ("upper", np.inf, "largest allowed")
        )
    }  # fmt: skip


def autocorrelation_times(values: Floats) -> Floats:
    """Integrated autocorrelation times in steps; (K, W, d) values of K steps of W walkers."""
    with np.errstate(invalid="ignore", divide="ignore"):  # of walkers that never moved
        times: Floats = require_emcee().autocorr.integrated_time(values, tol=0)
    return times


def split_r_hat(values: Floats) -> float:
    """Spread of all halves of chains over that within them; (W, K) values of W walkers."""
    half = values.shape[1] // 2
    parts = np.concatenate([values[:, :half], values[:, -half:]])
    within = float(parts.var(axis=1, ddof=1).mean())
    between = half * float(parts.mean(axis=1).var(ddof=1))
    if within == 0.0:
        return float("inf") if between else float("nan")
    return float(np.sqrt((half - 1) / half + between / (half * within)))


def _ended(
    names: list[str], draws: int, times: Floats, agreement: Floats, chain: Chain
) -> tuple[str, str]:
    """How the chain ended, and what speaks against it."""
    if draws < _FEWEST:
        return "interrupted", "interrupted before anything was kept; repeat the same call"
    faults = []
    worst = int(np.nanargmax(np.where(np.isnan(times), np.inf, times)))
    time = float(times[worst])
    if not draws >= _LONG * time:
        enough = f"give draws={int(np.ceil(_LONG * time))}" if time < draws else "give more draws="
        faults.append(
            f"the chain is too short: {draws} draws of each walker are {draws / time:.0f}"
            f" autocorrelation times of {names[worst]}, and {_LONG:.0f} are needed; {enough}, with"
            " the same store= to go on"
        )
    apart = [f"{name} ({each:.2f})" for name, each in zip(names, agreement, strict=True)
             if not each <= _AGREE]  # fmt: skip
    if apart:
        faults.append(
            f"walkers do not agree, by their split R-hat, about {', '.join(apart)}: give more"
            " draws=, or narrower bounds in free= of the fit"
        )
    if chain.n_lost > _LOST * chain.heights.size:
        faults.append(
            f"no motion could be found at {chain.n_lost} of {chain.heights.size} places, which"
            " count as impossible: give narrower bounds in free= of the fit"
        )
    if not chain.complete:
        return "interrupted", "; ".join(["interrupted", *faults])
    return ("not_converged" if faults else "completed"), "; ".join(faults) or "completed"
