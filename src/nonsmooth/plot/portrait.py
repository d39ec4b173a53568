"""`phase_portrait`: one variable of a run over another."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.flagged_samples import are_flagged, mark_flagged
from nonsmooth.plot.histories import mode_label
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import (
    LINES,
    axis_label,
    finish_axes,
    largest_state,
    mode_colours,
    modes_visited,
)
from nonsmooth.plot.trace import DENSE, Trace, broken, check_range, check_variables, curve
from nonsmooth.system.algebra.linear import CONSTANT, LinearForm, State
from nonsmooth.system.system import System
from nonsmooth.system.text.evaluate import evaluate
from nonsmooth.system.text.expressions import Expression, name_set

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["phase_portrait"]

_CELLS = 2_000  # per side; 8 cm at 600 dots per inch are 1890 pixels

_POINTS = 201  # per side; a circle of this many pieces looks round
_SAME = 1e-9  # of two guards that differ by a factor

Plane = npt.NDArray[np.float64]


@checked
def phase_portrait(
    run: xr.Dataset,
    x: str,
    y: str,
    *,
    ax: Axes | None = None,
    phases: bool = False,
    surfaces: bool = False,
    time_range: tuple[float, float] | None = None,
    legend: bool = True,
) -> Axes:
    """One variable of a run over another.

    Two states are drawn through their values just before and just after each event. Where
    one of the two is an output, both are drawn at samples only. Samples of a measured motion that
    `measured.flagged` has marked have blue crosses.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `simulate`, or a measured motion.
    x, y : str
        States or outputs.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    phases : bool, optional
        Whether each part has the colour of its mode; jumps are then thin grey lines.
    surfaces : bool, optional
        Whether to draw, dashed, where guards vanish: stops and switching surfaces. Only
        those that depend on the two states drawn and on parameters have a place here.
    time_range : tuple of float, optional
        First and last time to draw, to leave out a transient; the whole run by default.
    legend : bool, optional
        Whether to draw a legend of the modes with ``phases=True``, and of flagged samples.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; one line, or one per mode and one for the jumps.

    Raises
    ------
    OptionError
        For an unknown variable, or a range that does not meet the run.

    Notes
    -----
    Of more than 20000 points those are left out that lie in one pixel with both
    neighbours; if many remain, the curve is an image within a PDF.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.moling(), periods=20)
    >>> T = run.attrs["period"]
    >>> ax = ns.plot.phase_portrait(run, "p", "y", phases=True, time_range=(10 * T, 20 * T))
    >>> [line.get_label() for line in ax.lines]
    ['no contact', 'contact', 'progression']
    """
    names = check_variables(run, [x, y])
    time_range = check_range(run, time_range)
    ax = new_axes() if ax is None else ax
    trace = _without_crowds(curve(run, names, time_range))
    dense = trace.time.size > DENSE
    if phases:
        _draw_by_mode(run, trace, ax, dense)
    else:
        alone = "." if trace.time.size == 1 else ""  # no line leads anywhere
        ax.plot(
            *trace.values, color=LINES[0]["color"], linewidth=0.6, marker=alone, rasterized=dense
        )
    time = run["time"].values
    low, high = time_range or (-np.inf, np.inf)
    flagged = are_flagged(run, names) & (time >= low) & (time <= high)
    mark_flagged(ax, run[x].values, run[y].values, flagged)
    if surfaces:
        draw_surfaces(run, x, y, ax)
    sizes = largest_state(run, x, y, time_range=time_range)
    finish_axes(ax, axis_label(run[x]), axis_label(run[y]), sizes=sizes)
    if (phases or flagged.any()) and legend:
        place_legend(ax)
    return ax


def _draw_by_mode(run: xr.Dataset, trace: Trace, ax: Axes, dense: bool) -> None:
    """A line per mode, broken where the run is in another mode, and one for the jumps."""
    colours = mode_colours(run)
    for name, here in modes_visited(run, trace.mode).items():
        points = broken(trace.values, here & ~trace.jumps)
        if points.size:
            label = mode_label(name)
            ax.plot(*points, color=colours[name], linewidth=1.2, label=label, rasterized=dense)
    # slaved states meet their equation at an event, which moves them by rounding
    visible = np.ptp(trace.values, axis=1, keepdims=True) / _CELLS
    moved = np.append(np.any(np.abs(np.diff(trace.values, axis=1)) > visible, axis=0), False)
    points = broken(trace.values, trace.jumps & moved)
    if points.size:
        ax.plot(*points, color="0.6", linewidth=0.8, label="jump", rasterized=dense, zorder=1)


def _without_crowds(trace: Trace) -> Trace:
    """Leave out points that lie in one pixel with both neighbours, in one mode."""
    if trace.time.size <= DENSE:
        return trace
    low = np.nanmin(trace.values, axis=1, keepdims=True)
    width = np.nanmax(trace.values, axis=1, keepdims=True) - low
    with np.errstate(invalid="ignore"):
        cell = np.floor((trace.values - low) / np.where(width > 0.0, width, 1.0) * _CELLS)
    # a point that is not a number differs from its neighbours, so the gap stays
    same = np.all(cell[:, 1:] == cell[:, :-1], axis=0) & (np.diff(trace.mode) == 0)
    same &= ~(trace.jumps[1:] | trace.jumps[:-1])
    crowded = np.zeros(trace.time.size, bool)
    crowded[1:-1] = same[1:] & same[:-1]
    return trace.take(~crowded)


def draw_surfaces(run: xr.Dataset, x: str, y: str, ax: Axes) -> None:
    """Dashed lines, within the range drawn so far, where guards of x and y alone vanish."""
    if "system" not in run.attrs:
        raise OptionError(
            "surfaces=True: the run does not say of which system it is, as one in other units does"
            " not; draw the run as it came from simulate"
        )
    system = System.from_toml(run.attrs["system"])
    if not {x, y} <= set(system.states) or x == y:
        return
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    xs, ys = np.linspace(left, right, _POINTS), np.linspace(low, high, _POINTS)
    across, up = np.meshgrid(xs, ys)
    found: list[Plane] = []
    for guard in _guards(system, x, y, across, up):
        size = np.abs(guard).max()
        if not np.isfinite(size) or guard.min() * guard.max() >= 0.0:
            continue
        shape = guard / size
        # both modes beside a surface have a guard that vanishes there
        if not any(min(abs(shape - g).max(), abs(shape + g).max()) < _SAME for g in found):
            found.append(shape)
            ax.contour(
                xs,
                ys,
                shape,
                levels=[0.0],
                colors="0.45",
                linestyles="--",
                linewidths=0.7,
                zorder=1,
            )
    ax.set_xlim(left, right)
    ax.set_ylim(low, high)


def _guards(system: System, x: str, y: str, across: Plane, up: Plane) -> Iterator[Plane]:
    """Values of the guards that depend on these two states and on parameters."""
    values: dict[str, float | Plane] = {**system.parameter_values, x: across, y: up}
    for mode in system.structure.running:
        forms = mode.taylor or mode.linear
        assert forms is not None
        for way in forms.exits:
            names = _names(way.guard)
            if names <= set(values) | {"pi"} and names & {x, y}:
                yield np.broadcast_to(_value(way.guard, values), across.shape)


def _names(guard: LinearForm | Expression) -> set[str]:
    """Names in a guard, ``t`` for whatever depends on time."""
    if not isinstance(guard, LinearForm):
        return name_set(guard)
    names: set[str] = set()
    for basis, coefficient in guard.terms.items():
        names |= name_set(coefficient)
        if isinstance(basis, State):
            names.add(basis.name)
        elif basis != CONSTANT:
            names.add("t")
    return names


def _value(guard: LinearForm | Expression, values: dict[str, float | Plane]) -> Plane:
    if not isinstance(guard, LinearForm):
        return np.asarray(evaluate(guard, values), dtype=float)
    total = np.zeros(())
    for basis, coefficient in guard.terms.items():
        factor = values[basis.name] if isinstance(basis, State) else 1.0
        total = total + evaluate(coefficient, values) * factor
    return total
