"""`lives`: predicted lives over measured ones."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.point_names import named_points, write_names
from nonsmooth.plot.style import PALETTE, axis_label, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["lives"]

_MARKS = "osD^v<>P"
_ROOM = 2.5  # factor left free around the points


def lives(
    compared: xr.Dataset,
    *,
    ax: Axes | None = None,
    label: str | None = None,
    factor: float = 2.0,
    names: bool = True,
    legend: bool = True,
) -> Axes:
    """Predicted lives over measured ones, both logarithmic, with the line on which they agree.

    Two calls on the same axes show two laws together; tests of one name are named once.

    Parameters
    ----------
    compared : xarray.Dataset
        Result of `fatigue.compare_lives`.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    label : str, optional
        Text of the legend; it says by itself where a law was fitted to these lives.
    factor : float, optional
        Dashed lines at this factor above and below; none for one.
    names : bool, optional
        Whether to write the names of the tests beside the points.
    legend : bool, optional
        Whether to draw a legend, of the points and of the lines.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; lives that are infinite are left out.

    Raises
    ------
    OptionError
        For another dataset, or a factor below one.

    Examples
    --------
    >>> import xarray as xr
    >>> import nonsmooth as ns
    >>> found = xr.Dataset(
    ...     {"measured": ("test", [100.0, 900.0]), "predicted": ("test", [200.0, 1000.0])},
    ...     attrs={"in_sample": 1},
    ... )
    >>> _, (ax,) = ns.plot.print_figure()
    >>> ax = ns.plot.lives(found, ax=ax, label="Walker")
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['Walker (fitted, in sample)', 'predicted as measured', 'a factor of 2 off']
    """
    if "measured" not in compared or "predicted" not in compared or "test" not in compared.dims:
        raise OptionError("give a result of fatigue.compare_lives")
    if not factor >= 1.0:
        raise OptionError(f"factor = {factor!r:.40} is below one")
    ax = new_axes() if ax is None else ax
    x, y = compared["measured"].values, compared["predicted"].values
    there = np.isfinite(x) & np.isfinite(y)
    if not there.any():
        raise OptionError("no life is finite, so there is none to draw")
    number = len(ax.collections)
    text = label or "predicted"
    if compared.attrs.get("in_sample"):
        text += " (fitted, in sample)"
    ax.scatter(
        x[there], y[there], s=14.0, marker=_MARKS[number % len(_MARKS)],
        color=list(PALETTE.values())[number % len(PALETTE)], label=text, zorder=3,
    )  # fmt: skip
    ax.set_xscale("log")
    ax.set_yscale("log")
    _limits(ax, factor)
    finish_axes(ax, _axis(compared, "measured"), _axis(compared, "predicted"))
    if legend:
        place_legend(ax)
    named = named_points(ax)
    if names and "test" in compared.coords:
        known = {name for name, _ in named}
        tests = [str(name) for name in compared["test"].values[there]]
        points = zip(tests, zip(x[there], y[there], strict=True), strict=True)
        named += [(name, (float(a), float(b))) for name, (a, b) in points if name not in known]
    if named:
        write_names(ax, named, float(ax.xaxis.label.get_fontsize()) - 2.0)
    return ax


def _axis(compared: xr.Dataset, name: str) -> str:
    variable = compared[name]
    return axis_label(variable) if "long_name" in variable.attrs else f"{name} life"


def _limits(ax: Axes, factor: float) -> None:
    """Limits of all points drawn so far, and the line of agreement across them."""
    points = np.concatenate([np.asarray(c.get_offsets()) for c in ax.collections])
    low, high = points.min(axis=0) / _ROOM, points.max(axis=0) * _ROOM
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(low[1], high[1])
    for line in list(ax.lines):
        line.remove()
    ends = np.array([min(low) / factor, max(high) * factor])
    rows: list[tuple[float, str, str | None]] = [(1.0, "-", "predicted as measured")]
    if factor > 1.0:
        rows += [(factor, "--", f"a factor of {factor:g} off"), (1.0 / factor, "--", None)]
    for times, style, text in rows:
        ax.plot(
            ends, times * ends, color="black", linestyle=style, linewidth=0.6, zorder=1, label=text
        )
