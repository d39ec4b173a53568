"""`multipliers`: multipliers of an orbit, or along a branch, and the unit circle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, quote
from nonsmooth.plot.branch_curves import check_branch, mark_special_points
from nonsmooth.plot.crowding import spaced
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import PALETTE, axis_label, colour_bar, finish_axes, growing_colours

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["multiplier_paths", "multipliers", "path_pieces"]

Complex = npt.NDArray[np.complex128]

_LEAST, _MOST = 1.25, 3.0  # from the middle of the circle to a side of the picture
_MOST_ALONG = 2.0  # of paths: farther out they only lead away
_BESIDE = 1.2  # width of axes over what the bar beside them leaves
_SPACE = 1.12  # from the outermost multiplier to the border
_OUTSIDE = "0.94"  # grey
_BETWEEN = 10.0  # points from a mark to the next one of its kind
_CROSSING = ("fold", "flip", "torus", "symmetry_breaking")  # of the unit circle
_FAR = 1e3  # times the picture, beyond which a path only leads out of it
_INFINITE = 1e300
_SAME = 1e-6  # multipliers closer than this look like one

_JUMPS = (  # where multipliers may jump
    "grazing", "corner", "border_collision", "gained", "lost",
    "crossing_sliding", "grazing_sliding", "switching_sliding", "adding_sliding",
)  # fmt: skip
NO_BOUND = 1e8  # larger at a graze of a rigid wall: infinite but for rounding, and on no path
_JUMP = 0.1  # beyond it a line would show a motion that there is none of


@checked
def multipliers(
    data: xr.Dataset,
    *,
    radius: float | None = None,
    special: bool = True,
    ax: Axes | None = None,
    legend: bool = True,
) -> Axes:
    """Multipliers in the complex plane, with the unit circle; what is outside of it is grey.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `find_orbit`, or of `continue_orbit`: then each multiplier is a path, in the
        colour of the parameter.
    radius : float, optional
        Largest real and imaginary part shown; by default so that all is seen, but not more
        than 3, and 2 along a branch.
    special : bool, optional
        Whether to mark the multipliers that make the special points of a branch.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, with equal scales.

    Raises
    ------
    OptionError
        For another dataset, or a radius that does not hold the unit circle.

    Notes
    -----
    Of marks of one kind that would lie on each other the first one is drawn, so a mark may stand
    for several special points. Multipliers of one orbit that lie beyond the picture are drawn at
    its border, and the legend tells how large they are. Paths end where a multiplier jumps, as it
    does where an orbit grazes, or is infinite, as at the graze of a rigid wall.

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> import nonsmooth as ns
    >>> step = ns.StroboscopicMap(ns.models.duffing()).tangent({"x": 0.1})
    >>> orbit = xr.Dataset({"multipliers": ("multiplier", np.linalg.eigvals(step) + 0j)})
    >>> ax = ns.plot.multipliers(orbit)
    >>> ax.get_aspect(), ax.get_xlabel()
    (1.0, 'real part of the multiplier')
    """
    if "multiplier" not in data.dims or "multipliers" not in data:
        raise OptionError(
            "the dataset has no variable 'multipliers'; give it a result of find_orbit or"
            " continue_orbit"
        )
    along = data["multipliers"].dims != ("multiplier",)
    if along and "point" not in data["multipliers"].dims:
        raise OptionError(
            f"there are orbits over {data['multipliers'].dims[0]!r}; choose one, such as"
            " data.isel(orbit=0)"
        )
    values = np.asarray(data["multipliers"].values, dtype=complex)
    ax = new_axes() if ax is None else ax
    limits = _limits_of_paths(values, ax) if along and radius is None else _limits(values, radius)
    ax.set_aspect("equal", adjustable="box")
    ax.set_xlim(*limits[:2])
    ax.set_ylim(-limits[2], limits[2])
    _draw_circle(ax)
    if along:
        _draw_paths(data, ax, special, _FAR * max(limits))
    else:
        _draw_points(values[~np.isnan(np.abs(values))], ax, limits)
    finish_axes(ax, "real part of the multiplier", "imaginary part")
    if legend:
        place_legend(ax)
    return ax


def _limits(
    values: Complex, radius: float | None = None, most: float = _MOST
) -> tuple[float, float, float]:
    """Left and right end, and half the height, of a picture in which all is seen."""
    if radius is not None:
        if not 1.0 < float(radius) < np.inf:
            raise OptionError(f"radius = {quote(radius)} must be more than 1, the unit circle")
        return -float(radius), float(radius), float(radius)
    finite = values[np.abs(values) <= NO_BOUND]
    extents = (-finite.real, finite.real, np.abs(finite.imag))
    left, right, up = (
        float(np.clip(_SPACE * extent.max(initial=0.0), _LEAST, most)) for extent in extents
    )
    return -left, right, up


def _limits_of_paths(values: Complex, ax: Axes) -> tuple[float, float, float]:
    """Limits between which the circle is large, and the picture as high as the axes have room."""
    left, right, up = _limits(values, most=_MOST_ALONG)
    room = ax.get_window_extent()
    return left, right, max(up, 0.5 * (right - left) * min(1.0, _BESIDE * room.height / room.width))


def _draw_circle(ax: Axes) -> None:
    """The unit circle, white inside, on grey."""
    from matplotlib.patches import Circle

    ax.set_facecolor(_OUTSIDE)
    ax.add_patch(Circle((0.0, 0.0), 1.0, facecolor="white", edgecolor="black", linewidth=0.8))
    for draw in (ax.axhline, ax.axvline):
        draw(0.0, color="0.6", linewidth=0.4, zorder=1.5)


def _draw_points(values: Complex, ax: Axes, limits: tuple[float, float, float]) -> None:
    """Dots inside and diamonds outside; triangles at the border for what is beyond."""
    left, right, up = limits
    largest = np.abs(values).max(initial=0.0)
    endless = np.where(values.real < 0.0, -_INFINITE, _INFINITE)
    values = np.where(np.isfinite(values), values, endless)
    excess = np.maximum(values.real / np.where(values.real < 0.0, left, right), 0.0)
    excess = np.maximum(excess, np.abs(values.imag) / up)
    beyond = excess > 1.0
    outside = (np.abs(values) > 1.0) & ~beyond
    shown = values / np.where(beyond, excess, 1.0)
    for where, label, marker, colour in (
        (~outside & ~beyond, "inside", "o", PALETTE["blue"]),
        (outside, "outside", "D", PALETTE["vermilion"]),
        (beyond, f"beyond, up to {largest:.3g}", "^", PALETTE["vermilion"]),
    ):
        if np.any(where):
            ax.plot(
                shown[where].real, shown[where].imag, linestyle="none", marker=marker,
                markersize=4.5, color=colour, markeredgecolor="black", markeredgewidth=0.5,
                label=label, clip_on=False, zorder=4,
            )  # fmt: skip
    _count(shown, ax)


def _count(values: Complex, ax: Axes) -> None:
    """Write how many multipliers lie on one place, such as those that events contract to 0."""
    size = float(ax.xaxis.label.get_fontsize()) - 1.0
    left = np.ones(values.size, bool)
    for value in values:
        same = left & (np.abs(values - value) < _SAME)
        left &= ~same
        if np.count_nonzero(same) < 2:
            continue
        text = f"{np.count_nonzero(same)}\N{MULTIPLICATION SIGN}"
        ax.annotate(
            text, (value.real, value.imag), (3.0, 3.0), textcoords="offset points", fontsize=size,
            zorder=5,
        )  # fmt: skip


def _draw_paths(branch: xr.Dataset, ax: Axes, special: bool, far: float) -> None:
    """Lines in the colour of the parameter, with a bar, and marks at special points."""
    from matplotlib.collections import LineCollection

    values = branch[check_branch(branch)].values.astype(float)
    pieces, begin = path_pieces(branch)
    middle = 0.5 * (values[begin] + values[np.minimum(begin + 1, values.size - 1)])
    lines = LineCollection(
        list(np.clip(pieces, -far, far)), cmap=growing_colours(), linewidths=1.6, zorder=3,
        capstyle="round",
    )  # fmt: skip
    lines.set_array(middle)
    lines.set_clim(float(np.nanmin(values)), float(np.nanmax(values)))
    ax.add_collection(lines, autolim=False)
    colour_bar(ax, lines, axis_label(branch[branch.attrs["parameter"]]), inset=True)
    if special and branch.sizes.get("special") and "special_multiplier" in branch:
        marked = branch.isel(special=np.isin(branch["special_kind"].values, _CROSSING))
        at = np.asarray(marked["special_multiplier"].values, dtype=complex)
        kinds = marked["special_kind"].values.astype(str)
        pair = at.imag != 0.0  # of which one is told; a real one marked twice would look crowded
        at = np.append(at, at[pair].conj())
        kinds = np.append(kinds, kinds[pair])
        known = np.isfinite(at)
        at, kinds = at[known], kinds[known]
        # along a branch many tori may begin, all on the circle
        kept = spaced(ax, at.real, at.imag, kinds.tolist(), _BETWEEN)
        mark_special_points(ax, kinds[kept].tolist(), at[kept].real, at[kept].imag)


def multiplier_paths(multipliers: npt.ArrayLike) -> Complex:
    """Multipliers (point, multiplier) in such an order that each column is one path.

    From orbit to orbit those belong together whose distances add up to the least. What is no
    number, where an orbit has fewer, stays so.
    """
    from scipy.optimize import linear_sum_assignment

    paths: Complex = np.array(multipliers, dtype=complex)
    last = paths[0].copy()
    for k in range(1, len(paths)):
        distance = np.abs(last[:, None] - paths[k][None, :])
        # missing ones take what places are left
        far = 1.0 + 2.0 * np.nansum(distance[np.isfinite(distance)])
        _, order = linear_sum_assignment(np.where(np.isfinite(distance), distance, far))
        paths[k] = paths[k][order]
        last = np.where(np.isnan(paths[k]), last, paths[k])
    return paths


def path_pieces(branch: xr.Dataset) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Straight pieces (piece, end, re and im) of all paths, and the point where each begins."""
    values = branch["multipliers"].transpose("point", "multiplier").values
    with np.errstate(invalid="ignore"):
        values = np.where(np.abs(values) <= NO_BOUND, values, np.nan)
    paths = multiplier_paths(values)
    jumps = np.zeros(max(len(paths) - 1, 0), bool)
    if branch.sizes.get("special") and jumps.size:
        at = branch["special_point"].values[np.isin(branch["special_kind"].values, _JUMPS)]
        jumps[np.clip(at, 0, jumps.size - 1)] = True
    begin, end = paths[:-1], paths[1:]
    with np.errstate(invalid="ignore"):
        drawn = np.isfinite(begin) & np.isfinite(end)
        drawn &= ~(jumps[:, None] & (np.abs(end - begin) > _JUMP))
    meeting = _meetings(begin, end) if paths.size else end
    straight, bent = np.nonzero(drawn & np.isnan(meeting)), np.nonzero(drawn & ~np.isnan(meeting))
    ends = np.concatenate(
        [
            np.stack([first[where], last[where]], axis=1)
            for first, last, where in (
                (begin, end, straight), (begin, meeting, bent), (meeting, end, bent),
            )
        ]
    )  # fmt: skip
    return np.stack([ends.real, ends.imag], axis=2), np.concatenate([straight[0], bent[0], bent[0]])


def _meetings(begin: Complex, end: Complex) -> Complex:
    """Where a pair becomes two real multipliers on its way, or they a pair; nan for all others.

    There both are the root of their product, which does not jump: that of a pair is the square of
    its size.
    """
    turns = (begin.imag != 0.0) != (end.imag != 0.0)
    turns &= np.isfinite(begin) & np.isfinite(end)
    turns &= (np.count_nonzero(turns, axis=1) == 2)[:, None]
    real = np.where(end.imag == 0.0, end, begin).real
    product = np.where(turns, real, 1.0).prod(axis=1)  # of the two real ones
    size = np.abs(np.where(end.imag == 0.0, begin, end))
    middle = np.sqrt(0.5 * (np.maximum(product, 0.0)[:, None] + size**2))
    found = np.where(turns & (product > 0.0)[:, None], np.copysign(middle, real), np.nan)
    return found.astype(complex)
