"""`comparison`: a measured motion and a computed one on the same axes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, quote, unknown_name
from nonsmooth.plot.alignment import folded, shift_to_marks, way_to_align
from nonsmooth.plot.compared_spectra import (
    MEASURED,
    decibel_label,
    draw_compared_spectra,
    is_spectrum,
)
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import LINES, axis_label, finish_axes
from nonsmooth.plot.trace import DENSE, curve

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["comparison"]

Floats = npt.NDArray[np.float64]

_SIZES = ((200, 4.0), (2_000, 2.4), (DENSE, 1.4))  # diameters by the number of measured points
_SMALLEST = 0.8
_BROAD = 1.6  # width of what was measured, seen on both sides of a computed curve that agrees


@checked
def comparison(
    computed: xr.Dataset,
    measured: xr.Dataset,
    x: str,
    y: str,
    *,
    align: str | None = None,
    ax: Axes | None = None,
    labels: tuple[str, str] = ("computed", "measured"),
    legend: bool = True,
) -> Axes:
    """Measured motion and computed one on the same axes.

    These are orbits, histories, sections, diagrams or spectra.

    Parameters
    ----------
    computed : xarray.Dataset
        Result of `simulate` (curves), of `stroboscopic_map` or `poincare_section` (points), of
        `bifurcation_diagram` (points over the parameter), or of `power_spectrum` or
        `full_spectrum` (curves in decibels).
    measured : xarray.Dataset
        Record, `measured.section` or `measured.diagram`, of the same kind and with the same
        units.
    x, y : str
        Variables of both; ``x="time"`` for histories, ``x="parameter"`` for diagrams,
        ``x="frequency"`` or ``x="harmonic"`` for spectra.
    align : {"mark", "phase", "time"}, optional
        How histories are brought together. ``"mark"`` moves the computed motion in time: its last
        period begins at the last mark of the record, and the axes show the time that both cover.
        ``"phase"`` folds both, from 0 at each mark to 1 at the next. ``"time"`` takes both as they
        are. By default ``"mark"`` where both have marks or a period of the forcing, else
        ``"time"``.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    labels : tuple of str, optional
        Texts of the legend.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes: measured in colour, computed in black above it.

    Raises
    ------
    OptionError
        For a variable that one of the two has not, results of different kinds, units that
        differ, or motions that cannot be aligned as asked.

    Notes
    -----
    A motion of several periods has several marks in each of them, so that it may be moved by whole
    periods: leave out periods at the end of the run, as in ``run.sel(time=slice(0, 40 * period))``.

    Decibels are 20 times the decimal logarithm of an amplitude over one unit, and 10 times that of
    a power density. What lies more than 120 dB below the largest value is drawn there.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> spring = ns.System(
    ...     states=["x", "v"], period="pi", equations={"x": "v", "v": "cos(2*t) - 0.5*v - x"}
    ... )
    >>> run = ns.simulate(spring, periods=30)
    >>> record = ns.measured.from_arrays(
    ...     {"x": run["x"]}, times=run["time"], marks=np.arange(30) * np.pi
    ... )
    >>> ax = ns.plot.comparison(run, ns.measured.velocities(record, names={"x": "v"}), "x", "v")
    >>> [line.get_label() for line in ax.lines]
    ['measured', 'computed']
    """
    for data, which in ((computed, "computed"), (measured, "measured")):
        _check(data, which, x, y)
    way = way_to_align(align, x, computed, measured)
    _check_units(computed, measured, (y,) if way == "phase" else (x, y))
    one, other = computed[y].dims, measured[y].dims
    if ("time" in one) != ("time" in other) or ("parameter" in one) != ("parameter" in other):
        raise OptionError(
            f"{y!r} is over {one} in what was computed and over {other} in what was measured; give"
            " two results of one kind"
        )
    ax = new_axes() if ax is None else ax
    x_label, y_label = axis_label(computed[x]), axis_label(computed[y])
    if "time" in one and x == "time":
        x_label = _draw_histories(computed, measured, y, ax, labels, way)
    elif "time" in one:
        _draw_orbits(computed, measured, x, y, ax, labels)
    elif is_spectrum(computed, y) and is_spectrum(measured, y):
        draw_compared_spectra(computed, measured, x, y, ax, labels)
        y_label = decibel_label(measured[y])
    else:
        _draw_points(computed, measured, x, y, ax, labels)
    finish_axes(ax, x_label, y_label)
    if legend:
        place_legend(ax)
    return ax


def _looks(
    computed: xr.Dataset, measured: xr.Dataset, labels: tuple[str, str]
) -> tuple[tuple[xr.Dataset, dict[str, Any]], ...]:
    """The curve of each of the two, the one below first."""
    return (
        (measured, {"label": labels[1], "color": MEASURED, "linewidth": _BROAD}),
        (computed, {"label": labels[0], "color": LINES[0]["color"], "linewidth": 0.7}),
    )


def _draw_orbits(
    computed: xr.Dataset, measured: xr.Dataset, x: str, y: str, ax: Axes, labels: tuple[str, str]
) -> None:
    for data, look in _looks(computed, measured, labels):
        names = [name for name in (x, y) if name != "time"]
        trace = curve(data, names)
        values = dict(zip(names, trace.values, strict=True)) | {"time": trace.time}
        ax.plot(values[x], values[y], rasterized=trace.time.size > DENSE, **look)


def _draw_histories(
    computed: xr.Dataset,
    measured: xr.Dataset,
    y: str,
    ax: Axes,
    labels: tuple[str, str],
    way: str,
) -> str:
    """Both over time, aligned in one of the ways; what the axis shows."""
    shift = shift_to_marks(computed, measured) if way == "mark" else 0.0
    spans = []
    for data, look in _looks(computed, measured, labels):
        trace = curve(data, [y])
        time, values = trace.time, trace.values[0]
        if way == "phase":
            time, values = folded(time, values, data)
        elif data is computed and way == "mark":
            time = time + shift
            seen = (time >= float(measured["time"][0])) & (time <= float(measured["time"][-1]))
            if np.any(seen):  # a transient before the record would set the range of the axes
                time, values = time[seen], values[seen]
        spans.append((float(np.nanmin(time)), float(np.nanmax(time))))
        ax.plot(time, values, rasterized=time.size > DENSE, **look)
    low, high = max(span[0] for span in spans), min(span[1] for span in spans)
    if way == "phase":
        ax.set_xlim(0.0, 1.0)
        return "phase [periods since the mark]"
    if way == "mark" and low < high:
        ax.set_xlim(low, high)
    label = axis_label(measured["time"] if measured["time"].attrs else computed["time"])
    return label.replace("time", "time of the record", 1) if way == "mark" else label


def _draw_points(
    computed: xr.Dataset, measured: xr.Dataset, x: str, y: str, ax: Axes, labels: tuple[str, str]
) -> None:
    across, up = _points(measured, x, y)
    size = next((size for most, size in _SIZES if up.size <= most), _SMALLEST)
    _dots(ax, across, up, labels[1], size, MEASURED)
    across, up = _points(computed, x, y)
    size = next((size for most, size in _SIZES if up.size <= most), _SMALLEST)
    _dots(ax, across, up, labels[0], 0.6 * size, LINES[0]["color"])


def _dots(ax: Axes, across: Floats, up: Floats, label: str, size: float, colour: Any) -> None:
    ax.plot(
        across, up, linestyle="none", marker="o", markersize=size, markeredgewidth=0.0,
        color=colour, label=label, rasterized=up.size > DENSE,
    )  # fmt: skip


def _points(data: xr.Dataset, x: str, y: str) -> tuple[Floats, Floats]:
    """Points of a section or a diagram, those that are nan left out."""
    first = data[x].dims[0]
    dims = (first, *(dim for dim in data[y].dims if dim != first))
    up = data[y].transpose(*dims).values.astype(float)
    across = data[x].values.astype(float)
    across = np.broadcast_to(across.reshape(-1, *(1,) * (up.ndim - 1)), up.shape)
    here = np.isfinite(up)
    return across[here], up[here]


def _check(data: Any, which: str, x: str, y: str) -> None:
    if not hasattr(data, "data_vars"):
        raise OptionError(f"{which} = {quote(data)}: give a dataset")
    known = [str(v) for v in (*data.data_vars, *data.coords) if data[v].dtype.kind in "fiu"]
    for name in (x, y):
        if name not in known:
            raise OptionError(f"{which}: {unknown_name('variable', name, known)}")
    if data[x].ndim != 1 or data[x].dims[0] not in data[y].dims:
        raise OptionError(
            f"{which}: {x!r} is over {data[x].dims} and {y!r} over {data[y].dims}; draw two"
            " variables over the same points, or one of a diagram over x='parameter'"
        )
    if data[y].size == 0:
        raise OptionError(f"{which}: there is nothing to draw; see its attribute 'message'")


def _check_units(computed: xr.Dataset, measured: xr.Dataset, names: tuple[str, ...]) -> None:
    """Refuse millimetres over what has no dimension."""
    for name in names:
        units = [str(data[name].attrs.get("units", "")) for data in (computed, measured)]
        if units[0] != units[1]:
            raise OptionError(
                f"{name!r} is in {units[0] or 'no units'} as computed and in"
                f" {units[1] or 'no units'} as measured; bring them to the same, such as by"
                " measured.dimensionless"
            )
