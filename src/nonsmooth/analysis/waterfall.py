"""`waterfall`: spectra of settled motions over a parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.options import SharedOptions, check_values, refuse_fixed
from nonsmooth.analysis.spectra.segments import check_window, without_drift
from nonsmooth.analysis.spectra.spectrum_dataset import Rows, check_plane, waterfall_dataset
from nonsmooth.analysis.spectra.transforms import lines_of, phases
from nonsmooth.analysis.sweeps.settled import SweptMotion
from nonsmooth.analysis.sweeps.sweep import (
    SweepProtocol,
    make_sweep,
    motion_periods,
    parameter_coordinate,
    run_sweep,
    stacked,
    statuses,
    sweep_attributes,
)
from nonsmooth.errors import OptionError
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.options import whole_number

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.runs.stroboscopic_map import StroboscopicMap
    from nonsmooth.system.system import System

__all__ = ["waterfall"]


def waterfall(
    system: System | StroboscopicMap,
    parameter: str,
    values: npt.ArrayLike,
    variable: str | Sequence[str],
    *,
    initial: Any = None,
    start: str = "restart",
    transient: int = 200,
    record: int = 60,
    samples_per_period: int = 64,
    window: str = "hann",
    segments: int = 1,
    parameters: Mapping[str, float] | None = None,
    tolerance: float = 1e-12,
    mode: str | None = None,
    threads: int | None = None,
    store: str | Path | None = None,
) -> xr.Dataset:
    """Spectra of settled motions for many values of a parameter: a waterfall, or cascade.

    Parameters
    ----------
    system : System or StroboscopicMap
        A system with a period, or a map that gives it another one.
    parameter : str
        The parameter that is changed, such as a speed.
    values : array_like
        Its values, one spectrum each.
    variable : str or pair of str
        A state or output, of which the spectrum has one side; or two, the coordinates of a motion
        in a plane, with forward and backward whirl apart as in `full_spectrum`.

    Other Parameters
    ----------------
    initial : mapping or dataset, optional
        Initial state as in `simulate`.
    start : {"restart", "follow up", "follow down"}, optional
        As in `bifurcation_diagram`: where the motions begin.
    transient : int, optional
        Periods left out at the beginning of each motion.
    record : int, optional
        Periods of each record; lines are ``segments / record`` of the forcing's frequency apart.
        Sixty holds motions of the periods 1 to 6 as a whole.
    samples_per_period : int, optional
        Samples per period; harmonics above half of it are folded back.
    window : str, optional
        As in `power_spectrum`; the boxcar keeps lines of motions that fit into the record
        narrower, and smears others over all frequencies.
    segments : int, optional
        As in `power_spectrum`; whole periods each.
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.
    mode : str, optional
        Mode to start in, where several would fit; a cell, or a mode for any of its cells.
    threads : int, optional
        Number of threads; without it, one for each processor. The result does not depend on it.
    store : str or Path, optional
        Folder in which finished parts are kept, made where it is missing. After an interruption the
        same call goes on from them.

    Returns
    -------
    xarray.Dataset
        Over ``parameter`` and ``harmonic``, the frequency over that of the forcing, which counts
        orders of a speed: ``amplitude`` and ``power_density`` as in `power_spectrum` or
        `full_spectrum`, of the motion about its mean, whose size is the amplitude at zero, and
        ``frequency`` in cycles per unit time. Of a single segment also ``phase``: a line is
        ``amplitude*cos(2*pi*harmonic*t/period + phase)``, or the circle whose real part that is,
        with t from the beginning of the record, which is that of a period. At zero it is pi where
        the mean is negative. Over ``parameter``:
        ``period`` of the forcing in time, ``motion_period``, see notes, and ``status``.

    Raises
    ------
    OptionError
        For an option out of its range, an unknown name, a system without a period, or a ``store``
        that was begun with other options.
    RunError
        When the store could not be written, for want of room for one; what is done is kept there.

    See Also
    --------
    order_tracking : spectra along one run whose speed changes.
    bifurcation_diagram : the states at the strobes.

    Notes
    -----
    The ``motion_period``, in periods of the forcing, is found as in `bifurcation_diagram`: strobes
    repeat after it to 1e-6 of the size of each state. It is at most half of ``record``. Motions
    with a 0 are chaotic or quasi-periodic, have a longer period, or still hold a transient, whose
    lines at natural frequencies look like whirl. The message says how many there are. A larger
    ``transient`` takes a transient away, `regime` tells chaos.

    References
    ----------
    F. F. Ehrich (editor), Handbook of Rotordynamics, 2nd edition, Krieger, 1999: cascade spectra.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> spectra = ns.waterfall(ns.models.soft_impact(), "omega", [0.7, 0.83], "x", transient=400)
    >>> dict(spectra.sizes)
    {'parameter': 2, 'harmonic': 1921}
    >>> amplitude = spectra["amplitude"].sel(harmonic=0.5)
    >>> [float(value) > 1e-6 for value in amplitude]  # period 1, period 2
    [False, True]
    """
    sweep = make_sweep(
        system, "waterfall", initial=initial, start=start, transient=transient, record=record,
        shared=SharedOptions(parameters, tolerance, mode, threads, store),
    )  # fmt: skip
    model = sweep.system
    grid = check_values(model, parameter, values)
    refuse_fixed(system, parameters, (parameter,), "values")
    names = check_plane(variable, [*model.states, *model.outputs], labels_of(model).attributes)
    per_period = whole_number("samples_per_period", samples_per_period)
    count = whole_number("segments", segments)
    periods = sweep.record // count
    length = periods * per_period
    if length < 4:
        raise OptionError(
            f"record = {sweep.record} periods with samples_per_period = {per_period} are too few"
            f" for {count} segments of whole periods; take more, or fewer segments="
        )
    weights = check_window(window, length)

    def reduce(settled: SweptMotion) -> dict[str, npt.NDArray[Any]]:
        parts = _record(settled, sweep, names, per_period, count * length).reshape(count, length)
        lines = lines_of(parts, weights, settled.period / per_period)
        return {
            "amplitude": lines.amplitude,
            "density": lines.density,
            "period": np.array(settled.period),
        } | ({"phase": phases(parts[0], weights)} if count == 1 else {})

    options = {
        "samples_per_period": per_period,
        "window": window,
        "segments": count,
        "variable": names[0],
        "second_variable": names[1] if len(names) == 2 else "",
    }
    swept = run_sweep(
        sweep, parameter, grid, reduce, call="waterfall", options=options,
    )  # fmt: skip
    number = np.arange(length // 2 + 1) if len(names) == 1 else np.arange(length) - length // 2
    rows = Rows(
        number / periods,
        stacked(swept.found, "amplitude", number.shape),
        stacked(swept.found, "density", number.shape),
        stacked(swept.found, "period", ()),
        stacked(swept.found, "phase", number.shape) if count == 1 else None,
    )
    attrs = sweep_attributes(sweep, swept, sweep.options | options)
    result = waterfall_dataset(
        rows, names, [labels_of(model).attributes(name) for name in names],
        parameter_coordinate(model, parameter, swept.values),
        labels_of(model).attributes("time").get("units", ""), attrs | {"parameter": parameter},
    )  # fmt: skip
    result["motion_period"] = motion_periods(swept.found)
    result["status"] = statuses(swept.found)
    return result


def _record(
    settled: SweptMotion, sweep: SweepProtocol, names: tuple[str, ...], per_period: int, size: int
) -> npt.NDArray[Any]:
    """So many samples at the end of the record, complex for two variables."""
    count = sweep.record * per_period
    samples = settled.samples(np.linspace(0.0, settled.duration, count + 1))
    columns = []
    for name in names:
        values = settled.values(name, samples)[count - size :]
        columns.append(without_drift(values) if name in sweep.system.drift_states else values[1:])
    return columns[0] if len(names) == 1 else columns[0] + 1j * columns[1]
