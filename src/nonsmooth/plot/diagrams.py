"""`bifurcation`: settled motions over a parameter."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.flagged_samples import are_flagged, mark_flagged
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.period_colours import NOT_SETTLED, OTHER_REGIMES, by_period
from nonsmooth.plot.style import PALETTE, axis_label, finish_axes, largest_state

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["bifurcation"]

_DENSE = 20_000  # points; more become an image within a PDF
_FEW = 3_000  # points that are drawn large enough to be seen one by one
_MARKERS = "osD^v<>"
_LAYERS = 40  # in which points of several colours are drawn in turn, so that none hides another
_COLOURED = 1.5  # times as large: small dots of pale colours are faint
_COLOURS = ("initial", "period")
_NO_PERIOD = "no period found"

Floats = npt.NDArray[np.float64]


@checked
def bifurcation(
    diagram: xr.Dataset,
    variable: str,
    *,
    ax: Axes | None = None,
    colour: str = "initial",
    legend: bool = True,
) -> Axes:
    """Points of a bifurcation diagram over its parameter.

    Parameters
    ----------
    diagram : xarray.Dataset
        Result of `bifurcation_diagram`, or of `measured.diagram`.
    variable : str
        A state or output, or what there is once per column, such as ``"period"``, ``"events"`` or
        ``"v_per_time"``.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    colour : {"initial", "period"}, optional
        What the colours tell: initial states, or the period of the motion in each column.
    legend : bool, optional
        Whether to name the periods, to tell several initial states apart, and to name points that
        were made of flagged samples of a record (blue crosses), in a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, with one set of points for each initial state, or for each colour; with many
        points in layers, each of which has some points of each colour, so that none hides another.

    Raises
    ------
    OptionError
        For an unknown variable, or a dataset that is no diagram.

    Notes
    -----
    More than 20000 points become an image within a PDF, so that the file stays small.

    Colours of periods are those of `regime_map` and `basins`: a longer period is darker. A motion
    for which the diagram found no period may be chaotic, quasi-periodic, of a longer period or
    still a transient; it is blue. Where the dataset has a variable ``regime`` over ``parameter``
    and ``lane`` with the words of `nonsmooth.regime`, they decide: chaos is black then.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> diagram = ns.bifurcation_diagram(
    ...     ns.models.soft_impact(), "omega", [0.7, 0.8], transient=50, record=10
    ... )
    >>> ax = ns.plot.bifurcation(diagram, "x")
    >>> ax.get_ylabel()
    'displacement of the mass'
    """
    if "parameter" not in diagram.dims or "lane" not in diagram.dims:
        raise OptionError("the dataset has no dimensions 'parameter' and 'lane'; give it a diagram")
    known = [str(name) for name, values in diagram.data_vars.items() if values.dtype.kind in "fi"]
    if colour not in _COLOURS:
        raise OptionError(f"colour: {unknown_name('choice', colour, _COLOURS)}")
    if variable not in known:
        raise OptionError(unknown_name("variable", variable, known))
    ax = new_axes() if ax is None else ax
    table = diagram[variable].transpose("parameter", "lane", ...)
    flagged = are_flagged(diagram.assign({variable: table}), [variable])
    values, faulty = (
        np.where(flagged, np.nan, table.values),
        np.where(flagged, table.values, np.nan),
    )
    if values.ndim == 2:
        values, faulty = values[:, :, None], faulty[:, :, None]
    count = int(np.isfinite(values).sum())
    size = 3.0 if count <= _FEW else (1.5 if count <= _DENSE else 0.9)
    size *= _COLOURED if colour == "period" else 1.0
    parts = _lanes(values) if colour == "initial" else _periods(diagram, values)
    _draw(ax, diagram["parameter"].values, list(parts), size, count)
    here = np.broadcast_to(diagram["parameter"].values[:, None, None], faulty.shape)
    mark_flagged(ax, here, faulty, np.isfinite(faulty))
    # columns without a point, such as an event that does not happen, belong to the picture too
    over = diagram["parameter"].values
    if over.size:
        ax.update_datalim([(over.min(), 0.0), (over.max(), 0.0)], updatey=False)
        ax.autoscale_view(scaley=False)
    sizes = 0.0, *largest_state(diagram, variable)
    finish_axes(ax, axis_label(diagram["parameter"]), _height_label(diagram, variable), sizes=sizes)
    if legend:
        place_legend(ax)
    return ax


def _draw(ax: Axes, over: Floats, parts: list[_Part], size: float, count: int) -> None:
    """Draw points: few of them in sizes that leave those below visible, many in layers.

    Each layer has some points of each part, drawn at random.
    """
    layers = _LAYERS if count > _FEW and len(parts) > 1 else 1
    rng = np.random.default_rng(0)
    points = []
    for part in parts:
        here = np.broadcast_to(over[:, None], part.values.shape)[np.isfinite(part.values)]
        both = np.stack([here, part.values[np.isfinite(part.values)]])
        points.append(both if layers == 1 else rng.permutation(both, axis=1))
    for layer in range(layers):
        for part, both in zip(parts, points, strict=True):
            ax.plot(
                *both[:, layer::layers],
                linestyle="none",
                marker="." if count > _FEW else _MARKERS[part.lane % len(_MARKERS)],
                markersize=size * (1.0 if layers > 1 else max(0.4, 1.0 - 0.3 * part.lane)),
                markeredgewidth=0.0,
                color=part.colour,
                label=part.label if layers == 1 else None,
                rasterized=count > _DENSE,
            )
    for part in parts if layers > 1 else ():  # large enough to tell colours apart
        ax.plot(
            [],
            [],
            linestyle="none",
            marker=".",
            markersize=6.0,
            markeredgewidth=0.0,
            color=part.colour,
            label=part.label,
        )


class _Part(NamedTuple):
    """Points of one colour; nan where there are none."""

    values: Floats
    lane: int
    colour: str
    label: str | None


def _lanes(values: Floats) -> Iterator[_Part]:
    """A part for each initial state."""
    colours = list(PALETTE.values())
    single = values.shape[1] == 1
    for lane in range(values.shape[1]):
        colour = "black" if single else colours[lane % len(colours)]
        yield _Part(values[:, lane], lane, colour, None if single else f"initial state {lane + 1}")


def _periods(diagram: xr.Dataset, values: Floats) -> Iterator[_Part]:
    """A part for each period that motions have, and each other regime, by initial states."""
    if "period" not in diagram or set(diagram["period"].dims) != {"parameter", "lane"}:
        raise OptionError(
            "colour = 'period': the diagram has no variable 'period' over its columns; give a"
            " result of bifurcation_diagram"
        )
    period = diagram["period"].transpose("parameter", "lane").values
    regime = _regimes(diagram, period)
    for name, colour, where in (
        *by_period(period, regime == "periodic"),
        *((name, colour, regime == name) for name, colour in OTHER_REGIMES.items()),
        (_NO_PERIOD, NOT_SETTLED, regime == _NO_PERIOD),
    ):
        label: str | None = name
        for lane in np.flatnonzero(where.any(axis=0)):
            chosen = np.where(where[:, lane, None], values[:, lane], np.nan)
            if np.isfinite(chosen).any():
                yield _Part(chosen, int(lane), colour, label)
                label = None  # stands in the legend once


def _regimes(diagram: xr.Dataset, period: npt.NDArray[np.int64]) -> npt.NDArray[np.str_]:
    """What each motion is: of itself the diagram knows whether it has a period."""
    found = np.where(period > 0, "periodic", _NO_PERIOD).astype("<U32")
    if "regime" not in diagram:
        return found
    given = diagram["regime"].broadcast_like(diagram["period"]).transpose("parameter", "lane")
    words = given.values.astype(str)
    unknown = sorted(set(words.ravel()) - {"periodic", *OTHER_REGIMES})
    if unknown:
        known = ", ".join(["periodic", *OTHER_REGIMES])
        raise OptionError(
            f"colour = 'period': the variable 'regime' of the diagram has the word {unknown[0]!r};"
            f" known ones are {known}"
        )
    return np.where(period > 0, found, np.where(words == "periodic", _NO_PERIOD, words))


def _height_label(diagram: xr.Dataset, variable: str) -> str:
    """Label of what is drawn, and on which side of which event; samples at strobes need no word."""
    event = str(diagram.attrs.get("at", "strobe"))
    side = str(diagram.attrs.get("side", ""))
    recorded = {"parameter", "lane"} < set(diagram[variable].dims)
    if not recorded or not side or event == "strobe":
        return axis_label(diagram[variable])
    named = diagram[variable].assign_attrs(
        long_name=f"{diagram[variable].attrs.get('long_name') or variable} {side} {event}"
    )
    return axis_label(named)
