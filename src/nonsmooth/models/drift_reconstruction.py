"""The drift of the mole, rebuilt from its bounded motion: the chapter's Eqs. (28) and (29).

Only displacements relative to the slider's bottom, the velocity and the order of the phases
are read; the integrated drift gives no more than the constant at the first sample.
"""

from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from nonsmooth.errors import OptionError
from nonsmooth.models.rigs.data import check_contents
from nonsmooth.system.model.evaluated import parameter_values

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["drift_reconstruction"]

_VARIABLES = ("p", "y", "v", "mode", "phase", "period_number", "event_phase", "event_period_number",
              "state", "state_after")  # fmt: skip
_SERIES_BELOW = 0.5  # sin(x) - x: a series of six terms is exact to rounding up to here


class _Segments(NamedTuple):
    """Where each segment starts: period number, phase, bounded state, whether it progresses."""

    number: np.ndarray
    phase: np.ndarray
    p: np.ndarray
    y: np.ndarray
    progresses: np.ndarray


def drift_reconstruction(run: xr.Dataset, *, as_printed: bool = False) -> xr.DataArray:
    r"""Drift of the mole, rebuilt from the bounded motion (p, y, q) alone.

    Without progression the drift keeps its value (Eq. 28). With progression, which starts
    at :math:`\tau_0` with :math:`p_0, y_0, v_0`, it is Eq. (29) with its sign corrected:

    .. math::

        v = v_0 + (p_0 - g - 1)(1 - e^{-s/2\xi}) + y_0 s + \tfrac{b - 1}{2} s^2
            - \tfrac{a}{\omega^2} [\cos(\theta_0 + \omega s) - \cos\theta_0
            + \omega s \sin\theta_0], \quad s = \tau - \tau_0,
            \ \theta_0 = \omega\tau_0 + \varphi.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `simulate` for the system of `moling`.
    as_printed : bool, optional
        Take Eq. (29) as the chapter prints it, with a plus before the exponential term.

    Returns
    -------
    xarray.DataArray
        Drift over ``time``, equal to that of the run at its first sample.

    Raises
    ------
    OptionError
        When the run is not one of `moling`, or has no event log.

    See Also
    --------
    progression : drift per period and per unit time.

    Notes
    -----
    Each term is evaluated without cancellation and with phases reduced to one period, so a
    segment is right to some units of rounding of the drift. Over n segments these add up
    to about n units at worst, here and in the integrated drift alike.

    References
    ----------
    The chapter, section 2.3, Eqs. (24)-(29).

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.moling(b=0.15), periods=20)
    >>> error = abs(ns.models.drift_reconstruction(run) - run["v"]).max()
    >>> bool(error < 1e-12 * run["v"].max())
    True
    """
    import xarray as xr

    if run.attrs.get("system_name") != "moling":
        raise OptionError(
            f"the run is of {run.attrs.get('system_name')!r}; the chapter's Eqs. (28) and (29)"
            " hold for the system that nonsmooth.models.moling returns"
        )
    if "event_to" not in run:
        raise OptionError("the run has no event log; simulate without events=False")
    check_contents("run", run, _VARIABLES, ("system", "window"))
    values = parameter_values(tomllib.loads(run.attrs["system"])["parameters"])
    window = float(run.attrs["window"])
    segments = _segments(run)
    gains = _gains(segments, values, window, as_printed)
    start = np.concatenate([[0.0], np.cumsum(gains)])
    which = _segment_of_samples(run, segments)
    lag, whole = _lags(run["period_number"].values, run["phase"].values, segments, which)
    here = _Segments(*(column[which] for column in segments))
    drift = run["v"].values[0] + start[which] + _gain(here, lag, whole, values, window, as_printed)
    return xr.DataArray(drift, {"time": run["time"]}, ("time",), "v", dict(run["v"].attrs))


def _segments(run: xr.Dataset) -> _Segments:
    """Every event from the first sample on; that sample itself where no event is at its time."""
    names = run["event_to"].attrs["flag_meanings"].split()
    number, phase = run["event_period_number"].values, run["event_phase"].values
    first_number, first_phase = run["period_number"].values[0], run["phase"].values[0]
    same = (number == first_number) & (phase == first_phase)
    later = same | (number > first_number) | ((number == first_number) & (phase > first_phase))
    head = slice(0, 0 if np.any(same) else 1)
    modes = np.concatenate([run["mode"].values[head], run["event_to"].values[later]])
    after = {name: run["state_after"].sel(state=name).values[later] for name in "py"}
    return _Segments(
        number=np.concatenate([run["period_number"].values[head], number[later]]),
        phase=np.concatenate([run["phase"].values[head], phase[later]]),
        p=np.concatenate([run["p"].values[head], after["p"]]),
        y=np.concatenate([run["y"].values[head], after["y"]]),
        progresses=modes == names.index("progression"),
    )


def _segment_of_samples(run: xr.Dataset, segments: _Segments) -> np.ndarray:
    """Number of the segment of each sample, compared by period first: no digits are lost."""
    n_segments, n_samples = len(segments.number), run.sizes["time"]
    number = np.concatenate([segments.number, run["period_number"].values])
    phase = np.concatenate([segments.phase, run["phase"].values])
    is_sample = np.arange(len(number)) >= n_segments
    order = np.lexsort((is_sample, phase, number))
    passed = np.cumsum(~is_sample[order]) - 1
    which = np.empty(n_samples, dtype=int)
    which[order[is_sample[order]] - n_segments] = passed[is_sample[order]]
    return which


def _lags(
    number: np.ndarray, phase: np.ndarray, segments: _Segments, which: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Time since the start of a segment: part within a period, and whole periods."""
    return phase - segments.phase[which], number - segments.number[which]


def _gains(
    segments: _Segments, values: dict[str, float], window: float, as_printed: bool
) -> np.ndarray:
    """Drift gained in each segment but the last."""
    which = np.arange(len(segments.number) - 1)
    lag, whole = _lags(segments.number[1:], segments.phase[1:], segments, which)
    here = _Segments(*(column[:-1] for column in segments))
    return _gain(here, lag, whole, values, window, as_printed)


def _gain(
    start: _Segments,
    lag: np.ndarray,
    whole: np.ndarray,
    values: dict[str, float],
    window: float,
    as_printed: bool,
) -> np.ndarray:
    """Drift gained since the start of a segment, Eqs. (28) and (29)."""
    s = whole * window + lag
    omega = values["omega"]
    theta = omega * start.phase + values["phi"]
    # cos(theta + w) - cos(theta) + w sin(theta), without its cancellation for small w
    wave = -2.0 * np.cos(theta) * np.sin(0.5 * omega * lag) ** 2 - np.sin(theta) * _sine_defect(
        omega * lag, omega * s
    )
    offset = start.p - values["g"] - 1.0
    if as_printed:
        slider = offset + offset * np.exp(-s / (2.0 * values["xi"]))
    else:
        slider = -offset * np.expm1(-s / (2.0 * values["xi"]))
    gain = slider + start.y * s + 0.5 * (values["b"] - 1.0) * s**2 - values["a"] / omega**2 * wave
    return np.where(start.progresses, gain, 0.0)


def _sine_defect(reduced: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """sin(angle) - angle; ``reduced`` is the angle less whole turns."""
    square = angle**2
    series = np.ones_like(angle)
    for k in (156.0, 110.0, 72.0, 42.0, 20.0):
        series = 1.0 - square / k * series
    small = np.abs(angle) < _SERIES_BELOW
    return np.where(small, -angle * square / 6.0 * series, np.sin(reduced) - angle)
