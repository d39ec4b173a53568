"""`contact_regions`: regimes of contact of a rotor and its snubber ring over the rotor's place."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.style import PALETTE, axis_label, finish_axes, mixed

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["contact_regions"]

_NAMES = ("I", "II", "III", "IV", "V")
_PALE = (255, 11)  # towards white, in twentieths: orbits drawn on top must stand out
_LETTER = 1.4  # heights of a letter that a label needs
_DOWN, _UP = -1, 1


@checked
def contact_regions(
    boundaries: xr.Dataset,
    *,
    ax: Axes | None = None,
    view: str = "plane",
    labels: bool = True,
    equations: bool = False,
) -> Axes:
    """Regions of operation I to V of a rotor in a preloaded snubber ring, and their boundaries.

    Parameters
    ----------
    boundaries : xarray.Dataset
        Result of `models.snubber_boundaries`, or that in SI units.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    view : {"plane", "quadrant"}, optional
        All around the ring, or the first quadrant only.
    labels : bool, optional
        Whether to write the names of the regions into them, or beside them with a line.
    equations : bool, optional
        Whether to write the numbers of their equations at the boundaries of the first quadrant.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, of equal scales.

    Raises
    ------
    OptionError
        For another dataset or view.

    Notes
    -----
    The hues are those that `mode_colours` gives to modes of these names, paler.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> ax = ns.plot.contact_regions(ns.models.snubber_boundaries())
    >>> sorted({text.get_text() for text in ax.texts})
    ['I', 'II', 'III', 'IV', 'V']
    """
    if not {"x", "y", "equation", "side_x", "side_y"} <= set(boundaries.variables):
        raise OptionError("the dataset has no boundaries; give it a result of snubber_boundaries")
    if view not in ("plane", "quadrant"):
        raise OptionError(f"view = {view!r}: allowed are 'plane' and 'quadrant'")
    ax = new_axes() if ax is None else ax
    reach = float(boundaries.attrs["extent"])
    ax.set_xlim(-reach if view == "plane" else 0.0, reach)
    ax.set_ylim(-reach if view == "plane" else 0.0, reach)
    ax.set_aspect("equal")
    finish_axes(ax, axis_label(boundaries["x"]), axis_label(boundaries["y"]))
    _fill(ax, boundaries)
    for number in range(boundaries.sizes["curve"]):
        curve = boundaries.isel(curve=number)
        ax.plot(curve["x"], curve["y"], color="black", linewidth=0.8, zorder=2.5)
    if equations:
        _name_equations(ax, boundaries)
    if labels:
        _name_regions(ax, boundaries, view)
    return ax


def _fill(ax: Axes, boundaries: xr.Dataset) -> None:
    """Colours, from the outside inwards: each region covers what does not belong to the last."""
    colours = {
        name: mixed(colour, *_PALE) for name, colour in zip(_NAMES, PALETTE.values(), strict=False)
    }
    ax.set_facecolor(colours["V"])
    wedges = [("III", 65, "side_x", "side_y"), ("IV", 66, "side_y", "side_x")]
    for name, equation, side, other in wedges:
        for sign in (_UP, _DOWN):
            parts = [
                _points(boundaries, equation, **{side: sign, other: end}) for end in (_UP, _DOWN)
            ]
            if all(len(part) for part in parts):
                ax.fill(*np.concatenate([parts[0][::-1], parts[1]]).T, color=colours[name], lw=0)
    around = [(63, _UP, 0), (64, 0, _UP), (63, _DOWN, 0), (64, 0, _DOWN)]
    parts = [_points(boundaries, number, side_x=i, side_y=j) for number, i, j in around]
    if all(len(part) for part in parts):
        order = (1, -1, -1, 1)  # counterclockwise
        ring = [part[::step] for part, step in zip(parts, order, strict=True)]
        ax.fill(*np.concatenate(ring).T, color=colours["II"], lw=0)
    ax.fill(*_points(boundaries, 62, side_x=0, side_y=0).T, color=colours["I"], lw=0)


def _points(boundaries: xr.Dataset, equation: int, *, side_x: int, side_y: int) -> np.ndarray:
    """Points of one curve, none where it does not exist."""
    here = (
        (boundaries["equation"] == equation)
        & (boundaries["side_x"] == side_x)
        & (boundaries["side_y"] == side_y)
    ).values
    if not here.any():
        return np.zeros((0, 2))
    return np.stack([boundaries[name].values[here][0] for name in ("x", "y")], axis=1)


def _name_regions(ax: Axes, boundaries: xr.Dataset, view: str) -> None:
    """Names in the regions; where letters are too high for one, beside it with a line."""
    gap = float(_points(boundaries, 62, side_x=0, side_y=0)[0, 0])
    reach = float(boundaries.attrs["extent"])
    plane = view == "plane"
    signs = (_UP, _DOWN) if plane else (_UP,)
    _write(ax, "I", (0.0, 0.0) if plane else (0.3 * gap, 0.3 * gap))
    side = _points(boundaries, 63, side_x=_UP, side_y=0)
    if len(side):
        corner = side[-1]
        radius = float(np.hypot(*corner))
        middle = corner * 0.5 * (1.0 + gap / radius)
        _write(ax, "II", middle, room=radius - gap, beside=0.72 * gap * corner / radius)
    across = _points(boundaries, 65, side_x=_UP, side_y=_UP)
    along = _points(boundaries, 66, side_x=_UP, side_y=_UP)[:, ::-1]
    for name, curve, step in (("III", across, 1), ("IV", along, -1)):
        if not len(curve):
            continue
        start = max(curve[0, 0], gap + (side[len(side) // 2, 0] - gap if len(side) else 0.0))
        place = 0.5 * (start + reach)
        half = float(np.interp(place, curve[:, 0], curve[:, 1]))
        for sign in signs:
            at = np.array([sign * place, 0.0 if plane else 0.45 * half])[::step]
            beside = np.array([sign * place, half + 0.12 * reach])[::step]
            _write(ax, name, at, room=2.0 * half if plane else half, beside=beside)
    for sign_x in signs:
        for sign_y in signs:
            _write(ax, "V", (0.82 * sign_x * reach, 0.82 * sign_y * reach))


def _write(
    ax: Axes,
    name: str,
    at: tuple[float, float] | np.ndarray,
    *,
    room: float = np.inf,
    beside: np.ndarray | None = None,
) -> None:
    figure = ax.get_figure(root=True)
    assert figure is not None
    size = float(ax.xaxis.label.get_fontsize())
    low, high = ax.get_ylim()
    letter = size / 72.0 * figure.dpi / ax.get_window_extent().height * (high - low)
    style: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": size, "zorder": 4}
    point = (float(at[0]), float(at[1]))
    if beside is None or room >= _LETTER * letter:
        ax.text(*point, name, **style)
        return
    ax.annotate(
        name, point, (float(beside[0]), float(beside[1])),
        arrowprops={"arrowstyle": "-", "linewidth": 0.6, "shrinkA": 0.5, "shrinkB": 0.0}, **style,
    )  # fmt: skip


def _name_equations(ax: Axes, boundaries: xr.Dataset) -> None:
    """Numbers of the equations at curves of the first quadrant, where they are in sight."""
    reach = float(boundaries.attrs["extent"])
    size = 0.85 * float(ax.xaxis.label.get_fontsize())
    for number, sides, share in (
        (62, (0, 0), 0.17), (63, (_UP, 0), 0.8), (64, (0, _UP), 0.8),
        (65, (_UP, _UP), 0.65), (66, (_UP, _UP), 0.65),
    ):  # fmt: skip
        curve = _points(boundaries, number, side_x=sides[0], side_y=sides[1])
        if number == 62:
            curve = curve[(curve[:, 0] >= 0.0) & (curve[:, 1] >= 0.0)]
        curve = curve[(np.abs(curve) <= 0.97 * reach).all(axis=1)]
        if not len(curve):
            continue
        place = curve[int(share * (len(curve) - 1))]
        box = {"boxstyle": "round,pad=0.1", "facecolor": "white", "linewidth": 0.0, "alpha": 0.85}
        ax.text(
            float(place[0]),
            float(place[1]),
            f"({number})",
            fontsize=size,
            ha="center",
            va="center",
            bbox=box,
            zorder=4.5,
        )
