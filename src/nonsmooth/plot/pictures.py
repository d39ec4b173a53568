"""`bifurcation_picture`: attractors and branches over a parameter, above the shares of basins."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.plot.attractor_style import (
    ENDED_EARLY,
    UNSETTLED,
    AttractorStyle,
    attractor_styles,
    state_label,
)
from nonsmooth.plot.branch_curves import (
    branch_curve,
    mark_special_points,
    quantity,
    special_points,
)
from nonsmooth.plot.branches import KIND_STYLES, draw_curve
from nonsmooth.plot.figures import divided, print_figure
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import axis_label, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["bifurcation_picture", "branches_of"]

_ENDS = ("bound", "end")  # of the range, not of the system
_DOT, _MANY = 2.8, 0.9  # diameters of points of cycles and of sets
_LONGEST = 12  # points of a cycle; more are drawn as a set
_HEIGHTS = (3.0, 1.0)
_NAMED = 7  # attractors in the legend: as many as there are hues


@checked
def bifurcation_picture(
    picture: xr.Dataset, y: str, *, special: bool = True, ax: Axes | None = None
) -> Axes:
    """Attractors and branches of orbits over a parameter, and below them the shares of basins.

    Parameters
    ----------
    picture : xarray.Dataset
        Result of `bifurcation_picture`.
    y : str
        A state.
    special : bool, optional
        Whether to mark folds, flips, grazings and other special points.
    ax : matplotlib.axes.Axes, optional
        Where to draw, in a grid of axes: it is made smaller, with room for the shares below; new
        axes by default.

    Returns
    -------
    matplotlib.axes.Axes
        The upper axes; those of the shares are ``ax.figure.axes[-1]``.

    Raises
    ------
    OptionError
        For a dataset that is no bifurcation picture, or an unknown state.

    See Also
    --------
    branch : branches alone.
    bifurcation : settled motions alone.

    Notes
    -----
    An attractor has one colour in both axes, pale for its share of the starts. The legend names
    the seven attractors with most of the starts. Branches are black: solid where the orbit is
    stable, dashed where it is not. Where an impact passes the phase of a strobe, states jump, and
    the line is broken. White shares belong to starts that are unsettled, grey ones to motions that
    ended early.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> soft = ns.models.soft_impact(omega=0.8)
    >>> picture = ns.bifurcation_picture(
    ...     soft,
    ...     "a",
    ...     (0.3, 0.5),
    ...     {"x": (-2, 2), "v": (-2, 2)},
    ...     columns=3,
    ...     samples=4,
    ...     searches=0,
    ...     longest=1,
    ... )
    >>> ax = ns.plot.bifurcation_picture(picture, "x")
    >>> [each.get_ylabel().split()[0] for each in ax.figure.axes]
    ['displacement', 'share']
    """
    if "settled" not in picture or "parameter" not in picture.dims:
        raise OptionError(
            "picture: the dataset has no attractors over a parameter; give a result of"
            " bifurcation_picture"
        )
    states = [str(name) for name in picture["state"].values]
    if y not in states:
        raise OptionError(unknown_name("state", y, states))
    own = ax is None
    ax = print_figure(width=16.0, height=11.0)[1][0] if ax is None else ax
    upper, lower = divided(ax, 2, heights=_HEIGHTS)
    styles = _styles(picture)
    for number, style in styles.items():
        _draw_attractor(picture, number, y, upper, style)
    _name_attractors(picture, upper, styles)
    marks: list[Any] = []
    for k, branch in enumerate(branches_of(picture)):
        across, _ = quantity(branch, str(picture.attrs["parameter"]))
        points = special_points(branch)
        strobes = branch["strobes"].sel(state=y).transpose("strobe_of_turn", "point").values
        for turn, up in enumerate(strobes):
            if np.isfinite(up).any():
                places = points.value, points.between(up)
                curve = branch_curve(branch, (across, up), points, places, turn)
                draw_curve(curve, upper, "black", k)
                marks.append((points.kinds_shown(branch), *places))
    known = {line.get_label() for line in upper.lines}
    for name, line in KIND_STYLES.values():
        if f"_{name}" in known:
            upper.plot([], [], color="black", **line, label=name)
    if special and marks:
        kinds = np.concatenate([np.array(kind, str) for kind, _, _ in marks])
        x, height = (np.concatenate([mark[k] for mark in marks]) for k in (1, 2))
        inner = ~np.isin(kinds, _ENDS)
        mark_special_points(upper, kinds[inner].tolist(), x[inner], height[inner])
    _draw_shares(picture, lower, styles)
    label = axis_label(picture["parameter"])
    finish_axes(upper, "", state_label(picture, y))
    finish_axes(lower, label, "share of the starts")
    lower.set_ylim(0.0, 1.0)
    values = picture["parameter"].values
    beside = 0.5 * (values[-1] - values[0]) / max(values.size - 1, 1)  # or frames hide points
    for each in (upper, lower):
        each.set_xlim(values[0] - beside, values[-1] + beside)
    upper.tick_params(labelbottom=False)
    place_legend(upper, may_grow=own)
    return upper


def branches_of(picture: xr.Dataset) -> list[xr.Dataset]:
    """The branches of a picture one by one, as `continue_orbit` gives them."""
    found = []
    for i in range(picture.sizes.get("branch", 0)):
        of_points = np.flatnonzero(picture["branch_of_point"].values == i)
        of_specials = np.flatnonzero(picture["branch_of_special"].values == i)
        names = [
            name
            for name, values in picture.data_vars.items()
            if {"point", "special"} & set(values.dims) and not str(name).startswith("branch_of_")
        ]
        part = picture[names].isel(point=of_points, special=of_specials)
        part = part.assign_coords(point=np.arange(of_points.size))
        part.attrs = dict(picture.attrs) | {"period": int(picture["branch_period"][i])}
        found.append(part)
    return found


def _areas(picture: xr.Dataset) -> dict[int, float]:
    """What each attractor has of the picture of shares, where all of it is 1."""
    shares = picture["fraction"].transpose("attractor", "parameter").values
    means = np.nan_to_num(shares).mean(axis=1)
    return dict(zip(picture["attractor"].values.tolist(), means.tolist(), strict=True))


def _styles(picture: xr.Dataset) -> dict[int, AttractorStyle]:
    """Styles of attractors by their numbers; those with most of the starts differ most."""
    areas = _areas(picture)
    ranks = sorted(areas, key=lambda number: -areas[number])
    styles = attractor_styles(picture, range(1, len(ranks) + 1))
    return {number: styles[ranks.index(number) + 1] for number in areas}


def _name_attractors(picture: xr.Dataset, ax: Axes, styles: dict[int, AttractorStyle]) -> None:
    """Entries of the legend: the attractors with most of the starts, and how many others."""
    areas = _areas(picture)
    named = sorted(sorted(areas, key=lambda number: -areas[number])[:_NAMED])
    for number in named:
        ax.plot([], [], color=styles[number].basin, linewidth=3.0, label=f"attractor {number}")
    others = len(areas) - len(named)
    if others:
        ax.plot([], [], color="none", linewidth=3.0, label=f"and {others} with fewer starts")


def _draw_attractor(
    picture: xr.Dataset, number: int, y: str, ax: Axes, style: AttractorStyle
) -> None:
    """Points of one attractor at all values at which it exists."""
    own = picture.sel(attractor=number)
    height = own["settled"].sel(state=y).transpose("parameter", "strobe").values
    across = np.broadcast_to(picture["parameter"].values[:, None], height.shape)
    period = own["period"].values
    cycle = ((period > 0) & (period <= _LONGEST))[:, None]
    there = np.isfinite(height)
    label = f"attractor {number}"
    for chosen, size in ((there & cycle, _DOT), (there & ~cycle, _MANY)):
        if chosen.any():
            ax.plot(
                across[chosen], height[chosen], linestyle="none", marker="o", markersize=size,
                markeredgewidth=0.0, color=style.hue, zorder=2, gid=label,
            )  # fmt: skip


def _draw_shares(picture: xr.Dataset, ax: Axes, styles: Any) -> None:
    """Shares of the starts, one on top of the other."""
    values = picture["parameter"].values
    shares = np.nan_to_num(picture["fraction"].transpose("attractor", "parameter").values)
    rows = [*shares, picture["unsettled"].values, picture["ended"].values]
    colours = [style.basin for style in styles.values()]
    ax.stackplot(
        values, *rows, colors=[*colours, UNSETTLED, ENDED_EARLY], step="mid", linewidth=0.0
    )
