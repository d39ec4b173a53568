"""`mode_shapes`: deflections of a shaft or of any structure in its natural modes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.leading_entry import leading_entry
from nonsmooth.plot.figures import divided, new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import LINES, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["mode_shapes"]

_MOST = 4  # panels of one picture by default
_PANEL = 3.2  # height in centimetres
_DIRECTIONS = "xyz"
_STILL = 1e-6  # of the largest deflection: rounding, which has no sign


@checked
def mode_shapes(
    data: xr.Dataset,
    modes: Annotated[Sequence[int] | int | None, "numbers of modes, from 1"] = None,
    *,
    positions: Annotated[Sequence[float] | None, "a position for each node"] = None,
    ax: Axes | None = None,
    legend: bool = True,
) -> list[Axes]:
    """Shapes of natural modes, one below the other.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `nonsmooth.structures.natural_modes`.
    modes : int or sequence of int, optional
        Numbers of the modes to draw, from 1; the first four by default.
    positions : sequence of float, optional
        Where along the shaft each node is, in m; nodes are numbered by default.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    list of matplotlib.axes.Axes
        Axes for each mode, with its frequency, damping ratio and sense of whirl above. The first
        direction is drawn at the instant at which it is deflected most, each other one at its own
        such instant that is nearest to a quarter of a turn later. So in forward whirl x and y are
        deflected to the same side, in backward whirl to opposite sides. Where coordinates are not
        named by node and direction, they are drawn in their order.

    Raises
    ------
    OptionError
        For another dataset, an unknown mode, or positions that do not fit.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> beam = ns.structures.shaft([ns.structures.Beam(0.2, 0.05)] * 5).fixed(
    ...     ["0x", "0y", "5x", "5y"]
    ... )
    >>> axes = ns.plot.mode_shapes(ns.structures.natural_modes(beam, count=4), [1, 3])
    >>> len(axes), axes[-1].get_xlabel()
    (2, 'node')
    """
    if not {"shape", "frequency", "damping_ratio"} <= set(data.variables):
        raise OptionError("data: give a result of structures.natural_modes")
    known = data["mode"].values.tolist()
    wanted = known[:_MOST] if modes is None else np.atleast_1d(modes).astype(int).tolist()
    if not wanted:
        raise OptionError("modes: there is none; give numbers from 1")
    for number in wanted:
        if number not in known:
            raise OptionError(f"modes: there is no mode {number}; they are 1 to {len(known)}")
    groups = _groups([str(name) for name in data["coordinate"].values])
    if positions is not None and len(positions) != len(groups[0]):
        raise OptionError(
            f"positions: {len(positions)} numbers for {len(groups[0])} nodes; give one for each"
        )
    if ax is None:
        ax = new_axes(height=_PANEL * len(wanted) + 1.0)
    axes = divided(ax, len(wanted)) if len(wanted) > 1 else [ax]
    for panel, number in zip(axes, wanted, strict=True):
        _draw(panel, data.sel(mode=number), groups, positions)
    for panel in axes[:-1]:
        panel.tick_params(labelbottom=False)
    across = "position [m]" if positions is not None else groups[1]
    for panel in axes:
        finish_axes(panel, across if panel is axes[-1] else "", "shape")
    if legend and len(groups[2]) > 1:
        place_legend(axes[0])
    return axes


def _groups(names: list[str]) -> tuple[list[str], str, dict[str, list[tuple[int, int]]]]:
    """Nodes, what they are called, and by direction the node and coordinate of each value."""
    found = [(name[:-1].rstrip(" _.:-"), name[-1:]) for name in names]
    moving = {
        i: pair
        for i, pair in enumerate(found)
        if pair[1] in _DIRECTIONS and pair[1] and not pair[0].endswith("r")
    }
    if not moving:
        return names, "coordinate", {"": [(i, i) for i in range(len(names))]}
    nodes = list(dict.fromkeys(pair[0] for pair in found if pair[1] in _DIRECTIONS))
    nodes = list(dict.fromkeys(node.removesuffix("r") for node in nodes))
    directions: dict[str, list[tuple[int, int]]] = {}
    for i, (node, direction) in moving.items():
        directions.setdefault(direction, []).append((nodes.index(node), i))
    return nodes, "node", directions


def _is_against(deflection: complex) -> bool:
    """Whether a deflection is negative a quarter of a turn later, or where it is zero then, now."""
    later = -deflection.imag
    return bool((later if abs(later) > _STILL * abs(deflection) else deflection.real) < 0.0)


def _draw(panel: Axes, mode: xr.Dataset, groups: Any, positions: Any) -> None:
    nodes, _, directions = groups
    places = np.arange(len(nodes)) if positions is None else np.asarray(positions, dtype=float)
    panel.axhline(0.0, color="0.7", linewidth=0.6, zorder=0)
    shape = mode["shape"].values
    whole = np.abs(shape[[i for each in directions.values() for _, i in each]]).max()
    first = None
    for style, (direction, pairs) in zip(LINES, directions.items(), strict=False):
        at, values = places[[node for node, _ in pairs]], shape[[i for _, i in pairs]]
        largest = complex(values[leading_entry(values)])
        instant = np.angle(largest)
        if first is not None and _is_against(largest * np.exp(-1j * first)):
            instant += np.pi
        if first is None and np.abs(largest) > _STILL * whole:
            first = instant
        turned = (values * np.exp(-1j * instant)).real / (whole or 1.0)
        panel.plot(at, turned, **style, marker=".", markersize=3.0, label=direction)
    words = [f"mode {int(mode['mode'])}: {float(mode['frequency']):.4g} Hz"]
    words.append(f"damping ratio {float(mode['damping_ratio']):.2g}")
    if "direction" in mode and str(mode["direction"].item()) != "none":
        words.append(str(mode["direction"].item()))
    panel.set_title(
        ", ".join(words), fontsize=float(panel.xaxis.label.get_fontsize()) - 1.0, loc="left"
    )
    panel.set_ylim(-1.15, 1.15)
    if positions is None and len(nodes) <= 12:
        panel.set_xticks(places, nodes)
