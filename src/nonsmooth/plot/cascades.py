"""`waterfall`: spectra over a parameter, below each other or as colours."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, quote, unknown_choice
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.style import PALETTE, axis_label, colour_bar, finish_axes
from nonsmooth.runs.options import positive_number

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["check_drawing", "waterfall"]

Floats = npt.NDArray[np.float64]

_KINDS = ("cascade", "map")
_AXES = ("frequency", "harmonic")
_ORDERS = 5.0  # harmonics shown
_DECADES = 4.0  # of amplitudes that colours tell apart
_MOST = 50  # spectra below each other that are still told apart
_HEIGHT = 8.0  # of the highest line, in distances of spectra
_MOST_MARKED = 12  # orders that are marked
_DASHES = (0, (5.0, 15.0))  # and gaps between them, in widths of the line
_LABEL, _TALL = 2.8, 1.4  # width and height of the name of an order, in letters
_BESIDE = 1.04  # of the highest frequency or harmonic: a line there is seen as a whole
_ORDER = "order (frequency over that of the forcing)"


def check_drawing(chosen: Mapping[str, str]) -> None:
    """Refuse a kind of drawing, or an axis below it, that there is none of; by their options."""
    for (name, value), known in zip(chosen.items(), (_KINDS, _AXES), strict=True):
        if value not in known:
            raise OptionError(unknown_choice(name, value, known))


@checked
def waterfall(
    data: xr.Dataset,
    *,
    ax: Axes | None = None,
    kind: str = "cascade",
    over: str = "frequency",
    highest: float | None = None,
    height: float | None = None,
    orders: bool = True,
) -> Axes:
    """Spectra over a parameter, as lines below each other or as a map of colours.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `waterfall` or `order_tracking`.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    kind : {"cascade", "map"}, optional
        Lines, each raised to its value of the parameter, whose heights are proportional to the
        amplitude; or the parameter over which colours tell the amplitude, in decades.
    over : {"frequency", "harmonic"}, optional
        Frequency in cycles per unit time, or over that of the forcing.
    highest : float, optional
        Highest frequency, or harmonic, to draw, five harmonics by default; the axis ends a little
        beyond it, so that a line there is seen as a whole.
    height : float, optional
        How much of the parameter's axis the highest line takes; a cascade only.
    orders : bool, optional
        Whether to mark the harmonics of the forcing, dashed.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    OptionError
        For another dataset, or an option that is none of those above.

    Notes
    -----
    Of more than 50 spectra a cascade draws every second, or third, and so on, and says so beside
    the axis. There you also read how many motions show no period: some of their lines may be those
    of transients, see `nonsmooth.waterfall`.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> spectra = ns.waterfall(
    ...     ns.models.soft_impact(), "omega", np.linspace(0.7, 0.76, 4), "x", transient=400
    ... )
    >>> ax = ns.plot.waterfall(spectra)
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('frequency in cycles per unit time', 'frequency of the excitation')
    """
    if not {"parameter", "harmonic"} <= set(data.dims) or "amplitude" not in data:
        raise OptionError(
            "the dataset has no amplitudes over 'parameter' and 'harmonic'; give it a result of"
            " waterfall or order_tracking"
        )
    check_drawing({"kind": kind, "over": over})
    if height is not None:
        positive_number("height", height)
    ax = new_axes() if ax is None else ax
    data = data.isel(parameter=np.isfinite(data["period"].values)).sortby("parameter")
    if data.sizes["parameter"] == 0:
        raise OptionError("no motion of the dataset came to its end; see its variable 'status'")
    last = _last(data, over, highest)
    (_draw_lines if kind == "cascade" else _draw_map)(data, ax, over, last, height)
    if orders:
        _mark_orders(data, ax, over, last)
    two_sided = float(data["harmonic"].min()) < 0.0
    ax.set_xlim(-last if two_sided else 0.0, last)
    upward, count = axis_label(data["parameter"]), data.sizes["parameter"]
    said = []
    if kind == "cascade" and _drawn(count).size < count:
        said.append(f"{_drawn(count).size} of {count} drawn")
    if "motion_period" in data and (restless := int((data["motion_period"] == 0).sum())):
        said.append(f"{restless} of {count} without a period")
    if said:
        upward += f" ({', '.join(said)})"
    finish_axes(ax, _ORDER if over == "harmonic" else axis_label(data[over]), upward)
    return ax


def _last(data: xr.Dataset, over: str, highest: float | None) -> float:
    """How far to draw: a little beyond the highest frequency or harmonic."""
    largest = float(data[over].max())
    if highest is not None:
        if not float(highest) > 0.0:
            raise OptionError(f"highest = {quote(highest)} must be positive")
        return min(largest, _BESIDE * float(highest))
    unit = 1.0 if over == "harmonic" else float((1.0 / data["period"]).max())
    return min(largest, _BESIDE * _ORDERS * unit)


def _places(data: xr.Dataset, over: str) -> Floats:
    """Frequency or harmonic of each line of each spectrum."""
    shape = (data.sizes["parameter"], data.sizes["harmonic"])
    values = data[over].transpose(..., "harmonic").values
    return np.asarray(np.broadcast_to(values, shape))


def _drawn(count: int) -> npt.NDArray[np.int64]:
    """Numbers of the spectra that a cascade draws, so few that they are told apart."""
    return np.arange(0, count, -(-count // _MOST))


def _draw_lines(data: xr.Dataset, ax: Axes, over: str, last: float, height: float | None) -> None:
    rows = data["amplitude"].transpose("parameter", "harmonic").values
    here, values = _places(data, over), data["parameter"].values
    chosen = _drawn(values.size)
    spread = float(np.ptp(values)) or 1.0
    tall = _HEIGHT * spread / max(chosen.size, 2 * _HEIGHT) if height is None else float(height)
    shown = np.abs(here) <= last
    # the mean says where a motion is, not what it does
    motion = np.where(data["harmonic"].values == 0.0, 0.0, rows)
    scale = tall / (float(np.max(motion[shown], initial=0.0)) or 1.0)
    for number, i in enumerate(chosen[::-1]):  # the lowest are in front
        x, line = here[i][shown[i]], values[i] + scale * motion[i][shown[i]]
        ax.fill_between(x, values[i], line, color="white", zorder=1 + 1e-3 * number, linewidth=0.0)
        ax.plot(x, line, color="black", linewidth=0.4, zorder=1 + 1e-3 * number)
    ax.set_ylim(values[0] - 0.02 * spread, values[-1] + max(tall, 0.02 * spread))


def _draw_map(data: xr.Dataset, ax: Axes, over: str, last: float, height: float | None) -> None:
    from matplotlib.colors import LogNorm

    if height is not None:
        raise OptionError("height= is that of lines; leave it out of a map")
    rows = data["amplitude"].transpose("parameter", "harmonic").values
    rows = np.where(data["harmonic"].values == 0.0, np.nan, rows)
    here, values = _places(data, over), data["parameter"].values
    shown = np.any(np.abs(here) <= last, axis=0)
    x, rows = here[:, shown], rows[:, shown]
    largest = float(np.nanmax(rows, initial=0.0)) or 1.0
    mesh: Any = ax.pcolormesh(
        _cells(x, axis=1), np.repeat(_edges(values)[:, None], x.shape[1] + 1, axis=1),
        np.maximum(rows, largest * 10.0**-_DECADES),
        norm=LogNorm(largest * 10.0**-_DECADES, largest), cmap="magma_r", rasterized=True,
        linewidth=0.0,
    )  # fmt: skip
    colour_bar(ax, mesh, axis_label(data["amplitude"]), extend="min")
    ax.set_ylim(*_edges(values)[[0, -1]])


def _edges(values: Floats) -> Floats:
    """Borders of the cells around values."""
    if values.size == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    middle = 0.5 * (values[1:] + values[:-1])
    first, last = 2.0 * values[0] - middle[0], 2.0 * values[-1] - middle[-1]
    return np.concatenate([[first], middle, [last]])


def _cells(x: Floats, axis: int) -> Floats:
    """Borders of cells that change their place from row to row, at the borders of the rows."""
    across = np.apply_along_axis(_edges, axis, x)
    return across if len(across) == 0 else np.apply_along_axis(_row_edges, 0, across)


def _row_edges(column: Floats) -> Floats:
    """Means of neighbours, and the line through the outer ones: never beyond them in sign."""
    if column.size == 1:
        return np.repeat(column, 2)
    middle = 0.5 * (column[1:] + column[:-1])
    return np.concatenate([[2.0 * column[0] - middle[0]], middle, [2.0 * column[-1] - middle[-1]]])


def _over_the_axis(data: xr.Dataset, over: str, low: float, top: float) -> tuple[Floats, Floats]:
    """Values of the parameter and the first order at each, from one end of the axis to the other.

    The order goes straight on beyond the first and the last spectrum.
    """
    values, first = np.unique(data["parameter"].values, return_index=True)
    forcing = 1.0 / data["period"].values[first]
    unit = np.ones(values.size) if over == "harmonic" else forcing
    whole = np.concatenate([[low], values, [top]])
    if values.size == 1:
        return whole, np.pad(unit, 1, mode="edge")
    steps = np.gradient(unit, values)[[0, -1]] * (whole[[0, -1]] - values[[0, -1]])
    return whole, np.concatenate([unit[:1] + steps[:1], unit, unit[-1:] + steps[1:]])


def _mark_orders(data: xr.Dataset, ax: Axes, over: str, last: float) -> None:
    """Dashes along the harmonics of the forcing, far apart, with their numbers at the ends.

    Lines of spectra lie on them, and are to be seen between the dashes.
    """
    values, unit = _over_the_axis(data, over, *ax.get_ylim())
    two_sided = float(data["harmonic"].min()) < 0.0
    most = min(int(last / unit[1:-1].max() * (1.0 + 1e-9)), _MOST_MARKED)
    orders = [n for n in range(-most if two_sided else 1, most + 1) if n]
    for order in orders:
        ax.plot(
            order * unit, values, color=PALETTE["blue"], linestyle=_DASHES, linewidth=0.6,
            zorder=3,
        )  # fmt: skip
    ends = {n: _end_of_line(n * unit, values, last) for n in sorted(orders, key=abs)}
    _name_orders(ax, ends, -last if two_sided else 0.0, last)


def _end_of_line(across: Floats, up: Floats, last: float) -> tuple[float, float]:
    """Where a line leaves the picture, at its top or before that at a side."""
    inside = np.flatnonzero(np.abs(across) <= last)
    k = int(inside[-1]) if inside.size else 0
    if k + 1 == across.size:
        return float(across[-1]), float(up[-1])
    side = math.copysign(last, across[k + 1])
    share = (side - across[k]) / (across[k + 1] - across[k])
    return side, float(up[k] + share * (up[k + 1] - up[k]))


def _name_orders(ax: Axes, ends: dict[int, tuple[float, float]], first: float, last: float) -> None:
    """Names of orders at the ends of their lines, of which those stay that touch none before.

    At the left side, where the numbers of the axis stand, there is room for none: the order of the
    other sign has its name at the right.
    """
    low, top = ax.get_ylim()
    size = float(ax.xaxis.label.get_fontsize()) - 1.5
    figure = ax.get_figure(root=True)
    assert figure is not None
    extent = ax.get_window_extent()
    room = np.array([extent.width, extent.height]) / figure.dpi * 72.0
    taken: list[Floats] = []
    for order, (x, y) in ends.items():
        above = y == top
        if not above and x < 0.0:
            continue
        beyond = (0.0, 1.0) if above else (3.0, 0.0)
        middle = np.array([(x - first) / (last - first), (y - low) / (top - low)]) * room
        middle += np.array(beyond) + 0.5 * size * np.array([0.0, _TALL] if above else [_LABEL, 0.0])
        if any((np.abs(middle - each) < (_LABEL * size, _TALL * size)).all() for each in taken):
            continue
        taken.append(middle)
        ax.annotate(
            f"{order}X".replace("-", "\N{MINUS SIGN}"), (x, y), xytext=beyond,
            textcoords="offset points", fontsize=size, color=PALETTE["blue"],
            annotation_clip=False, ha="center" if above else "left",
            va="bottom" if above else "center",
        )  # fmt: skip
