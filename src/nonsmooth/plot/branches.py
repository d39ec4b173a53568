"""`branch`: orbits over a parameter, stable and unstable ones told apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.branch_curves import (
    INADMISSIBLE,
    SPECIAL,
    STABLE,
    UNSTABLE,
    BranchCurve,
    branch_curve,
    check_branch,
    mark_special_points,
    output_of_states,
    quantity,
    special_points,
)
from nonsmooth.plot.diagram_behind import (
    check_diagram,
    check_origin,
    draw_diagram,
    warn_of_other_parameters,
)
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import LINES, PALETTE, axis_label, finish_axes, largest_state
from nonsmooth.plot.trace import broken
from nonsmooth.system.text.evaluate import evaluate
from nonsmooth.system.text.expressions import Name

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes


__all__ = ["KIND_STYLES", "branch", "draw_curve"]

Branches: TypeAlias = "xr.Dataset | Sequence[xr.Dataset] | Mapping[str, xr.Dataset]"

KIND_STYLES: dict[int, tuple[str, dict[str, Any]]] = {
    STABLE: ("stable", {"linestyle": "-", "linewidth": 1.1}),
    UNSTABLE: ("unstable", {"linestyle": (0, (4.0, 1.6)), "linewidth": 1.1}),
    SPECIAL: ("{} curve", {"linestyle": "-", "linewidth": 1.1}),
    INADMISSIBLE: ("inadmissible", {"linestyle": (0, (1.0, 1.4)), "linewidth": 1.2}),
}
# dark, so that they stand out before the dots of a diagram
_COLOURS = (
    *(LINES[0]["color"], PALETTE["blue"], PALETTE["vermilion"], LINES[2]["color"]),
    *(LINES[3]["color"], PALETTE["orange"], PALETTE["sky"]),
)
_BELOW = 0.97  # of an axis that is cut: where marks of points beyond it are
_LAYER = 1e-3  # in the order of drawing, between a branch and the next one

_SHARE, _TIMES, _LEAST = 0.9, 3.0, 10.0
_LOW = 0.04  # of the height, below zero


@checked
def branch(
    branches: Branches,
    y: str,
    *,
    x: str | None = None,
    leg: int | str | None = None,
    diagram: xr.Dataset | None = None,
    special: bool = True,
    ax: Axes | None = None,
    legend: bool = True,
) -> Axes:
    """Branch of orbits over its parameter: stable solid, unstable dashed, inadmissible dotted.

    Parameters
    ----------
    branches : xarray.Dataset, sequence or mapping
        Result of `continue_orbit`, or of `continue_special`, whose points have no stability and
        are one solid line; several are told apart by colour, and named in the legend by the keys
        of a mapping.
    y : str
        A variable over the points of the branch, such as a state, ``"v_per_time"``, ``"length"``
        or ``"residual"``; an output of the system that is an expression of states alone, such as a
        displacement of a reduced structure; ``"multipliers"`` for the modulus of the largest one,
        with an axis that ends where single orbits, such as a graze at a rigid wall, are far beyond
        all others; ``"durations"`` for that of ``leg``.
    x : str, optional
        Another variable over the points of the branch than its parameter.
    leg : int or str, optional
        With ``y="durations"``: the number of a leg, from 0 on, or the name of a mode for the time
        in it per turn.
    diagram : xarray.Dataset, optional
        Result of `bifurcation_diagram` of the same system over the same parameter, drawn behind as
        grey dots. Where ``y`` differs from point to point, as a state does, these are strobes at
        the phase of the branch, and an orbit of several periods has a point at each of them.
    special : bool, optional
        Whether to mark folds, flips, grazings and other special points.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default. Branches that are there already
        stay, and a legend names what is on the axes once.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; of each branch one line per kind of orbit, and one set of marks per kind of
        special point.

    Raises
    ------
    OptionError
        For a dataset that is no branch, an unknown variable, or a diagram of another system, over
        another parameter, of other points, or without the variable.

    Warns
    -----
    ResultWarning
        When the diagram has other values of parameters than a branch.

    See Also
    --------
    bifurcation : a diagram alone.
    multipliers : why a branch changes its stability.

    Notes
    -----
    A change lies at its special point, also where that is between two points of the branch: there
    the line goes through it. Inadmissible orbits solve the equations of their word, but pass a
    guard in between, so no motion follows them. Where an impact passes the phase at which states
    are taken, they jump, and the line is broken.

    Examples
    --------
    A branch of equilibria that loses its stability at 0.5; those of `continue_orbit` have the
    same variables, and more.

    >>> import numpy as np
    >>> import xarray as xr
    >>> import nonsmooth as ns
    >>> p = np.linspace(0.0, 1.0, 11)
    >>> orbits = xr.Dataset(
    ...     {
    ...         "p": ("point", p),
    ...         "x": ("point", p**2),
    ...         "stable": ("point", p < 0.5),
    ...         "special_kind": ("special", ["flip"]),
    ...         "special_value": ("special", [0.47]),
    ...         "special_point": ("special", [4]),
    ...     },
    ...     attrs={"parameter": "p"},
    ... )
    >>> ax = ns.plot.branch(orbits, "x")
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['stable', 'unstable', 'flip']
    """
    named = _named(branches)
    own = ax is None
    ax = new_axes() if ax is None else ax
    if diagram is not None:
        for one in named.values():
            check_diagram(diagram, check_branch(one), y, x)
            check_origin(diagram, one.attrs, y)
        warn_of_other_parameters(diagram, named.values())
        draw_diagram(diagram, y, ax)
    drawn = len({line.get_gid() for line in ax.lines if _is_branch(line)})
    colours = {name: _COLOURS[(drawn + k) % len(_COLOURS)] for k, name in enumerate(named)}
    labels = []
    marks: list[tuple[list[str], Any, Any]] = []
    for k, (name, one) in enumerate(named.items()):
        parameter = check_branch(one)
        across, x_label = quantity(one, x or parameter)
        up, y_label = quantity(one, y, leg)
        points = special_points(one)
        over = points.value if x in (None, parameter) else points.between(across)
        # over strobes of settled motions, an orbit of several periods has several points
        heights = [up] if diagram is None or x not in (None, parameter) else _strobes(one, y, up)
        for turn, each in enumerate(heights):
            places = over, points.between(each)
            curve = branch_curve(one, (across, each), points, places, turn)
            draw_curve(curve, ax, colours[name], drawn + k)
            marks.append((points.kinds_shown(one), *places))
        labels.append((x_label, y_label))
    _explain(ax, colours)
    top = np.inf
    if y == "multipliers":
        heights = [line.get_ydata() for line in ax.lines if _is_branch(line)]
        top = cut_axis(ax, np.concatenate([np.asarray(each, float) for each in heights]))
    for kinds, at_x, at_y in marks if special else ():
        mark_special_points(ax, kinds, at_x, np.minimum(at_y, _BELOW * top))
    x_label, y_label = labels[0]
    sizes = [largest_state(one, x or check_branch(one), y) for one in named.values()]
    largest = tuple(max(each) for each in zip(*sizes, strict=True))
    finish_axes(ax, x_label, y_label if diagram is None else axis_label(diagram[y]), sizes=largest)
    if legend:
        place_legend(ax, may_grow=own)
    return ax


def _strobes(branch: xr.Dataset, y: str, up: Any) -> list[Any]:
    """A state at the beginning of each period of a turn; other variables as they are."""
    if "strobes" not in branch or f"{y}_per_period" in branch:
        return [up]
    strobes = branch["strobes"].transpose("state", "strobe_of_turn", "point").values
    states = dict(zip(branch["state"].values.tolist(), strobes, strict=True))
    expression = Name(y) if y in states else output_of_states(branch, y)
    if expression is None:
        return [up]
    values = np.broadcast_to(evaluate(expression, states), strobes.shape[1:])
    return [row for row in values if np.isfinite(row).any()]


def _named(branches: Branches) -> dict[str, xr.Dataset]:
    """Branches with their names in the legend."""
    import xarray as xr

    if isinstance(branches, xr.Dataset):  # which is a mapping too
        return {"": branches}
    several: Any = branches
    if isinstance(branches, Mapping):
        named = {str(name): one for name, one in several.items()}
    else:
        named = {
            f"{one.attrs['special_kind']} curve {k}"
            if isinstance(one, xr.Dataset) and "special_kind" in one.attrs
            else f"branch {k}": one
            for k, one in enumerate(several, start=1)
        }
    if not named:
        raise OptionError("branches: there is none; give a result of continue_orbit, or several")
    return named


def _is_branch(line: Any) -> bool:
    return str(line.get_gid() or "").startswith("branch ")


def draw_curve(curve: BranchCurve, ax: Axes, colour: str, number: int) -> None:
    """One line per kind of orbit, broken where orbits are of another kind.

    The first branch is in front: others may end on it, as an orbit run through twice.
    """
    gid, front = f"branch {number}", 3.0 - _LAYER * number
    if curve.x.size == 1:  # no line leads anywhere
        ax.plot(curve.x, curve.y, marker=".", color=colour, linestyle="none", gid=gid)
    curve = curve.rounded()
    points = np.stack([curve.x, curve.y])
    for kind, (name, style) in KIND_STYLES.items():
        line = broken(points, curve.ways(kind))
        if line.size:
            label = f"_{name.format(curve.special)}"
            ax.plot(*line, color=colour, **style, zorder=front, label=label, gid=gid)


def _explain(ax: Axes, colours: Mapping[str, str]) -> None:
    """Entries of the legend: kinds of orbits without a colour, and branches by colour."""
    known = ax.get_legend_handles_labels()[1]
    drawn = {str(line.get_label()) for line in ax.lines if _is_branch(line)}
    # black may be the colour of a branch
    neutral = "0.5" if len(colours) > 1 else "black"
    named = [(name, style) for name, style in KIND_STYLES.values() if f"_{name}" in drawn]
    # curves of special points differ by colour, and not by the kind of their lines: a name tells
    told = any(colours)
    curves = sorted(label[1:] for label in drawn if label.endswith(" curve") and not told)
    named += [(name, KIND_STYLES[SPECIAL][1]) for name in curves]
    for name, style in named:
        if name not in known:
            ax.plot([], [], color=neutral, **style, label=name)
    for name, colour in colours.items():
        if name and name not in known:
            ax.plot([], [], color=colour, linewidth=3.0, label=name)


def cut_axis(ax: Axes, values: npt.NDArray[np.float64]) -> float:
    """End the vertical axis where positive values can be read; infinite if it needs no end.

    That is at three times what nine of ten are below, or at 10.
    """
    finite = values[np.isfinite(values)]
    usual = float(np.quantile(finite, _SHARE)) if finite.size else 0.0
    top = max(_LEAST, _TIMES * usual)
    low, high = ax.get_ylim()
    set_here = low == -_LOW * high  # by an earlier call
    if not np.any(values > _TIMES * top) or not (ax.get_autoscaley_on() or set_here):
        return np.inf
    ax.set_ylim(-_LOW * top, top)
    return top
