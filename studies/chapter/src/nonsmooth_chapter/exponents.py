"""Largest exponents of the chapter's motions, per period of the forcing."""

from __future__ import annotations

from collections.abc import Mapping

import xarray as xr

from nonsmooth import System, lyapunov_spectrum

__all__ = ["largest_exponent"]


def largest_exponent(
    system: System,
    start: Mapping[str, float] | xr.Dataset,
    *,
    transient: int,
    record: int,
    interval: float | None = None,
) -> tuple[float, float]:
    """Largest exponent per period, and its standard error.

    Parameters
    ----------
    system : System
        A machine with a period.
    start : mapping or xarray.Dataset
        Settled state at a strobe.
    transient, record : int
        Periods left out and averaged.
    interval : float, optional
        Periods after which the growth is noted; one by default.

    Returns
    -------
    exponent, error : float

    Notes
    -----
    The motion is not run on behind the record. The rules of the claims judge the motion over the
    periods that they state, so what comes after 10,000 more would change no verdict; such a run
    costs many times as much as the exponent.

    Examples
    --------
    A disturbance of an oscillator with damping ratio 0.01 that meets nothing decays with it.

    >>> from nonsmooth.models import soft_impact
    >>> free = soft_impact(omega=1.0, a=0.001)
    >>> exponent, error = largest_exponent(free, {"x": 0.0, "v": 0.0}, transient=9, record=400)
    >>> round(exponent / free.period_value, 4)
    -0.01
    """
    found = lyapunov_spectrum(
        system, start, transient=transient, record=record, interval=interval, exponents=1,
        confirm=0,
    )  # fmt: skip
    turn = float(system.period_value or 0.0)
    return turn * float(found["lyapunov_exponent"][0]), turn * float(found["standard_error"][0])
