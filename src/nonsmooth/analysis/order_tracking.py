"""`order_tracking`: spectra along a run whose speed changes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.options import derived_attributes
from nonsmooth.analysis.spectra.segments import check_run, check_window, record_of
from nonsmooth.analysis.spectra.spectrum_dataset import Rows, check_plane, waterfall_dataset
from nonsmooth.analysis.spectra.transforms import lines_of, phases
from nonsmooth.analysis.statistics.series import clock_name, is_by_angle, slow_names
from nonsmooth.errors import OptionError, is_known, unknown_name
from nonsmooth.runs.options import whole_number

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["order_tracking"]


def order_tracking(
    run: xr.Dataset,
    variable: str | Sequence[str],
    *,
    over: str | None = None,
    periods: int = 16,
    window: str = "hann",
) -> xr.Dataset:
    """Spectra of a run block by block, such as those of a run-up over its speed.

    A run has the same number of samples in each period, however long that is. So harmonics of the
    forcing, the orders of a speed, stay sharp while the speed changes.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `simulate`, with or without slow parameters; or of `measured.synchronous`.
    variable : str or pair of str
        A state or output, of which the spectrum has one side; or two, the coordinates of a motion
        in a plane, with forward and backward whirl apart as in `full_spectrum`.
    over : str, optional
        The slow parameter that tells the blocks apart, or ``"time"``; the only slow parameter, or
        the time, by default. Of a measured motion ``"time"`` is the measured one, and ``"speed"``
        is known too.
    periods : int, optional
        Periods in a block; lines are one over them apart.
    window : str, optional
        As in `power_spectrum`; a motion that changes within a block needs one.

    Returns
    -------
    xarray.Dataset
        As of `waterfall`. ``parameter`` is the mean of the parameter, or of the time, over the
        block; ``time`` is that in its middle. ``period`` and ``frequency`` are those of the block;
        of a measured motion, all are by its measured time.

    Raises
    ------
    OptionError
        For an unknown name, a run without a period or whose samples are not equal parts of a
        period, or one that is too short.

    See Also
    --------
    waterfall : spectra of settled motions.
    period_statistics : largest and smallest values period by period.

    Examples
    --------
    The forcing of an oscillator runs up through its resonance, at 1:

    >>> import nonsmooth as ns
    >>> spring = ns.System(
    ...     states=["x", "v"],
    ...     parameters={"w": 0.5},
    ...     period="2*pi/w",
    ...     equations={"x": "v", "v": "cos(w*t) - 0.1*v - x"},
    ...     slow={"w": "0.5 + t/4000"},
    ... )
    >>> tracked = ns.order_tracking(ns.simulate(spring, t_end=4000), "x", periods=8)
    >>> first = tracked["amplitude"].sel(harmonic=1)
    >>> float(first["parameter"][first.argmax("parameter")].round(2))
    1.01
    """
    check_run(run)
    names = check_plane(
        variable,
        [str(name) for name in run.data_vars if run[name].dims == ("time",)],
        lambda name: run[name].attrs,
    )
    series = [record_of(run, name) for name in names]
    first, per_period = _whole_periods(run)
    count = whole_number("periods", periods)
    length = count * per_period
    blocks = (run.sizes["time"] - first - 1) // length
    if blocks < 1 or length < 4:
        raise OptionError(
            f"the run has {(run.sizes['time'] - first - 1) // per_period} whole periods, too few"
            f" for a block of periods = {count} with four samples or more"
        )
    name, values = _told_apart(run, over)
    places = first + length * np.arange(blocks + 1)
    clock = run[clock_name(run)]
    times = clock.values.astype(float)
    weights = check_window(window, length)
    columns = [one.values[first + 1 : places[-1] + 1].reshape(blocks, length) for one in series]
    whole: Any = columns[0] if len(names) == 1 else columns[0] + 1j * columns[1]
    spans = np.diff(times[places]) / count
    found = [lines_of(whole[k : k + 1], weights, spans[k] / per_period) for k in range(blocks)]
    rows = Rows(
        found[0].number / count,
        np.stack([one.amplitude for one in found]),
        np.stack([one.density for one in found]),
        spans,
        np.stack([phases(block, weights) for block in whole]),
    )
    middle = values[first + 1 : places[-1] + 1].reshape(blocks, length).mean(axis=1)
    label = run[name].attrs | {"long_name": run[name].attrs.get("long_name", name)}
    attrs: dict[str, Any] = derived_attributes(run) | {
        "parameter": name,
        "variable": names[0],
        "second_variable": names[1] if len(names) == 2 else "",
        "periods": count,
        "window": window,
    }
    result = waterfall_dataset(
        rows, names, [one.label for one in series], (("parameter",), middle, label),
        clock.attrs.get("units", ""), attrs,
    )  # fmt: skip
    centre = 0.5 * (times[places[:-1]] + times[places[1:]])
    return result.assign_coords(time=("parameter", centre, clock.attrs))


def _whole_periods(run: xr.Dataset) -> tuple[int, int]:
    """Sample at which the first whole period begins, and samples in each period."""
    if "phase" not in run.coords or "period" not in run.attrs:
        raise OptionError("the system of the run has no period, so there are no orders to track")
    begins = np.flatnonzero(run["phase"].values == 0.0)
    steps = np.diff(begins)
    if (
        steps.size == 0
        or np.any(steps != steps[0])
        or np.any(np.diff(run["period_number"].values[begins]) != 1)
    ):
        raise OptionError(
            "the samples are not equal parts of a period; simulate with samples_per_period= and"
            " periods= or t_end=, for two periods at least"
        )
    return int(begins[0]), int(steps[0])


def _told_apart(run: xr.Dataset, over: str | None) -> tuple[str, npt.NDArray[np.float64]]:
    """Name and values over time of what tells the blocks apart."""
    slow, clock = slow_names(run), clock_name(run)
    if over is None:
        over = slow[0] if len(slow) == 1 else clock
    known = [*dict.fromkeys(["time", clock]), *slow]
    known += ["speed"] if is_by_angle(run) and "speed" in run.coords else []
    if not is_known(over, known):
        what = "coordinate" if is_by_angle(run) else "slow parameter"
        raise OptionError(f"over: {unknown_name(what, over, known)}")
    over = clock if over == "time" else over
    return over, run[over].values.astype(float)
