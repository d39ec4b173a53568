"""Progression: how far a run with a drift gets per period of the forcing."""

from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.models.rigs.data import check_contents
from nonsmooth.real_numbers import whole_number

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["progression"]

_SAME_PHASE = 1e-9  # share of a period; samples are laid out to rounding, events play no part


def progression(run: xr.Dataset, state: str = "v", *, periods: int | None = None) -> xr.Dataset:
    """Progression of a drift state per period, per unit time and over a number of periods.

    The state is read once per period, at the phase of the first sample, so the result has
    no part of the oscillation in it.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `simulate` for a system with a period and a declared drift.
    state : str, optional
        Name of the drift state.
    periods : int, optional
        Number of periods at the end of the run to take the means over; all by default.

    Returns
    -------
    xarray.Dataset
        ``progression`` over ``period`` (the number of the period, counted like
        ``period_number`` of the run), and for the last ``periods`` of them ``per_period``,
        ``per_unit_time`` and ``total``.

    Raises
    ------
    OptionError
        When the state is no drift state of the run, the system has no period, or the run
        has fewer periods than asked for.

    See Also
    --------
    drift_reconstruction : the drift of the mole from its bounded motion alone.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.moling(b=0.15), periods=60)
    >>> steady = ns.models.progression(run, periods=10)
    >>> round(float(steady["per_period"]), 4), round(float(steady["per_unit_time"]), 4)
    (31.3453, 0.4989)
    """
    import xarray as xr

    _check_drift(run, state)
    check_contents("run", run, (state, "time", "phase", "period_number"))
    number, values = _strobes(run, state)
    available = len(values) - 1
    wanted = available if periods is None else whole_number("periods", periods)
    if wanted > available:
        raise OptionError(
            f"periods = {wanted}, but the run has {available} whole periods with a sample at each"
            " end; simulate longer, or ask for fewer"
        )
    total = values[-1] - values[-1 - wanted]
    window = float(run.attrs["period"])
    units = run[state].attrs.get("units", "")
    clock = run["time"].attrs.get("units", "")
    per_time = f"{units}/{clock}" if units and clock else ""
    label = run[state].attrs.get("long_name", state)
    return xr.Dataset(
        {
            "progression": ("period", np.diff(values), _label("progression in a period", units)),
            "per_period": ((), total / wanted, _label("mean progression per period", units)),
            "per_unit_time": (
                (),
                total / (wanted * window),
                _label("mean progression per unit time", per_time),
            ),
            "total": ((), total, _label("progression over the periods averaged", units)),
        },
        {"period": ("period", number[:-1], {"long_name": "whole periods before"})},
        {
            "state": state,
            "state_long_name": label,
            "periods": wanted,
            "period": window,
            "status": run.attrs["status"],
        },
    )


def _label(text: str, units: str) -> dict[str, str]:
    return {"long_name": text, "units": units} if units else {"long_name": text}


def _check_drift(run: xr.Dataset, state: str) -> None:
    if "system" not in run.attrs or "status" not in run.attrs:
        raise OptionError(
            "run: progression takes the result of nonsmooth.simulate; this dataset does not say"
            " which system made it"
        )
    drifts = list(tomllib.loads(run.attrs["system"]).get("drift", ()))
    if not drifts:
        raise OptionError(
            f"{run.attrs['system_name']!r} has no drift state; declare drift= in the system"
        )
    if state not in drifts:
        raise OptionError(f"state: {unknown_name('drift state', state, drifts)}")
    if "period" not in run.attrs:
        raise OptionError(
            f"{run.attrs['system_name']!r} has no period, so it has no progression per period;"
            f" read {state!r} at times of your choice instead"
        )


def _strobes(run: xr.Dataset, state: str) -> tuple[np.ndarray, np.ndarray]:
    """Period numbers and values at the samples whose phase is that of the first one."""
    number = run["period_number"].values
    # rounding may put a sample at the end of a period instead of the start of the next one
    lag = (run["phase"].values - run["phase"].values[:1]) / float(run.attrs["period"])
    turn = np.rint(lag).astype(int)
    index = np.flatnonzero(np.abs(lag - turn) <= _SAME_PHASE)
    number, first = np.unique(number[index] + turn[index], return_index=True)
    if len(number) < 2 or np.any(np.diff(number) != 1):
        raise OptionError(
            f"the run has {len(number)} samples at the phase of its first one, not one in every"
            " period; simulate with periods=, or with t_end= over at least one period"
        )
    return number, run[state].values[index[first]]
