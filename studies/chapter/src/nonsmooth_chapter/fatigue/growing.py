"""The beam whose crack grows as in Fig. 30: its strobes, and what they do at each time."""

from __future__ import annotations

from functools import lru_cache
from typing import Literal

import numpy as np
import xarray as xr

from nonsmooth import local_regimes, lyapunov_spectrum, simulate
from nonsmooth.models import breathing_crack
from nonsmooth_chapter.fatigue.beam_data import ETA, GROWTH, TAU_END, XI
from nonsmooth_chapter.judgement import Evidence

__all__ = [
    "LATE_STARTS",
    "Growth",
    "growing_run",
    "labelled_stretches",
    "local_exponent",
    "strobe_labels",
]

Growth = Literal["frozen", "flow"]
LATE_STARTS = ((0.0, 0.0), (1.0, 0.0), (-1.0, 1.0), (0.3, -2.0), (-0.4, 0.5), (2.0, 2.0))
_TURN = 2.0 * np.pi / ETA
_MOST_PERIOD, _WINDOW = 8, 64  # of local labels, in strobes


@lru_cache(maxsize=32)
def growing_run(
    grows: Growth = "frozen",
    start: tuple[float, float] = (0.0, 0.0),
    first: float = 0.0,
    last: float = TAU_END,
    **parameters: float,
) -> xr.Dataset:
    """Strobes of the beam while its crack grows by the law of Fig. 30.

    Parameters
    ----------
    grows : {"frozen", "flow"}, optional
        Whether the length is kept for each period, or grows within the flow.
    start : (float, float), optional
        Deflection and velocity at the beginning.
    first, last : float, optional
        Time at which the run begins, rounded down to a strobe, and ends.
    **parameters : float
        Changed parameters.

    Returns
    -------
    xarray.Dataset
        ``u``, ``v`` and ``crack`` over ``time``, one strobe per period of the forcing.

    Examples
    --------
    >>> run = growing_run(first=900_000.0, last=900_100.0)
    >>> run.sizes["time"], round(float(run["crack"][0]), 2)
    (19, 10.67)
    """
    system = breathing_crack(xi=XI, eta=ETA, growth=GROWTH, grows=grows)
    system = system.with_parameters(**parameters)
    k, end = int(first // _TURN), int(last // _TURN)
    initial = dict(zip("uv", start, strict=True))
    if grows == "frozen":
        run = simulate(
            system, initial, periods=end - k, samples_per_period=1, t_start=k * _TURN, events=False
        )
    else:
        times = _TURN * np.arange(k, end + 1)
        run = simulate(system, initial, times=times, t_start=float(times[0]), events=False)
    return run[["u", "v", "crack"]]


def strobe_labels(run: xr.Dataset) -> xr.Dataset:
    """Local labels of a run with a growing crack.

    Parameters
    ----------
    run : xarray.Dataset
        As from `growing_run`.

    Returns
    -------
    xarray.Dataset
        As from `local_regimes`, periods up to 8 in windows of 64 strobes.
    """
    return local_regimes(
        run, window=_WINDOW, most_period=_MOST_PERIOD, variables=["u", "v"], parameter="crack"
    )


def labelled_stretches(labels: xr.Dataset) -> list[Evidence]:
    """Stretches of one label in the order of time.

    Parameters
    ----------
    labels : xarray.Dataset
        As from `strobe_labels`.

    Returns
    -------
    list of dict
        ``period`` (0: none), ``from_tau``, ``to_tau``, ``from_crack``, ``to_crack`` and number of
        ``strobes``.
    """
    names = {"from_tau": "from_time", "to_tau": "to_time", "from_crack": "from_crack",
             "to_crack": "to_crack"}  # fmt: skip
    rows = []
    for k in range(labels.sizes["stretch"]):
        one = labels.isel(stretch=k)
        row: Evidence = {"period": int(one["stretch_period"])}
        row |= {name: float(one[key]) for name, key in names.items()}
        rows.append(row | {"strobes": int(one["last"] - one["first"]) + 1})
    return rows


def local_exponent(run: xr.Dataset, first: float, last: float, **parameters: float) -> Evidence:
    """Growth of small deviations along a stretch of a run, per period.

    Parameters
    ----------
    run : xarray.Dataset
        As from `growing_run`.
    first, last : float
        Times of its first and last strobe.
    **parameters : float
        Changed parameters of the run.

    Returns
    -------
    dict
        ``exponent`` per period over the stretch, of the beam whose crack grows within the flow,
        its ``error``, and whether it is ``chaotic``: above three errors, and above three over
        the periods of the stretch.
    """
    k = int(np.searchsorted(run["time"].values, first))
    start = {name: float(run[name][k]) for name in ("u", "v")}
    begin = float(run["time"][k])
    periods = max(round((last - begin) / _TURN), 1)
    system = breathing_crack(xi=XI, eta=ETA, growth=GROWTH, grows="flow")
    found = lyapunov_spectrum(
        system.with_parameters(**parameters), start, t_start=begin, transient=0.0,
        record=periods * _TURN, interval=_TURN, exponents=1,
    )  # fmt: skip
    value = _TURN * float(found["lyapunov_exponent"][0])
    error = _TURN * float(found["standard_error"][0])
    chaotic = value > 3.0 * max(error, 1.0 / periods)
    return {"exponent": value, "error": error, "chaotic": bool(chaotic)}
