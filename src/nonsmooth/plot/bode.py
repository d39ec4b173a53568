"""Amplitude and phase of linear responses, over the speed of a shaft or a frequency."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.plot.figures import divided, new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import LINES, axis_label, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["frequency_response", "unbalance_response"]

Array = npt.NDArray[Any]
Names = Annotated[str | Sequence[str] | None, "names of coordinates"]

_HEIGHT = 9.0  # of both panels, in centimetres
_MARKS = 6  # speeds that are written along a polar curve
_PHASE = "phase [degrees]"


@checked
def unbalance_response(
    data: xr.Dataset,
    coordinates: Names = None,
    *,
    kind: Literal["bode", "polar"] = "bode",
    ax: Axes | None = None,
    legend: bool = True,
) -> list[Axes]:
    """Unbalance response: amplitude and phase over the speed, or a polar plot.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `nonsmooth.structures.unbalance_response`.
    coordinates : str or sequence of str, optional
        What to draw, at most four; by default the four of largest amplitude.
    kind : {"bode", "polar"}, optional
        Amplitude above the phase, over the speed; or the complex displacement in its plane, with
        speeds written along the curve.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    list of matplotlib.axes.Axes
        Two axes, that of the amplitude above that of the phase, or one of the polar plot. A
        negative phase lags behind the angle 0 of the shaft, from which the phases of unbalances
        count too.

    Raises
    ------
    OptionError
        For another dataset, or an unknown coordinate.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> disc = ns.Structure(
    ...     [[2, 0], [0, 2]],
    ...     [[800, 0], [0, 900]],
    ...     damping=[[4, 0], [0, 4]],
    ...     coordinates=["1x", "1y"],
    ... )
    >>> found = ns.structures.unbalance_response(disc, range(1, 60), (1, 1e-3))
    >>> above, below = ns.plot.unbalance_response(found, "1x")
    >>> above.get_ylabel(), below.get_ylabel()
    ('amplitude [m]', 'phase [degrees]')
    """
    if not {"displacement", "speed", "coordinate"} <= set(data.variables):
        raise OptionError("data: give a result of structures.unbalance_response")
    known = [str(name) for name in data["coordinate"].values]
    if coordinates is None:
        order = np.argsort(-data["amplitude"].max("speed").values, kind="stable")
        chosen = [known[i] for i in np.sort(order[: len(LINES)])]
    else:
        chosen = _chosen("coordinates", coordinates, known)
    curves = {name: data["displacement"].sel(coordinate=name).values for name in chosen}
    if kind == "polar":
        return [_polar(data["speed"], curves, ax, legend)]
    return _bode(data["speed"], curves, axis_label(data["amplitude"]), ax, legend, False)


@checked
def frequency_response(
    data: xr.Dataset,
    outputs: Names = None,
    inputs: Names = None,
    *,
    ax: Axes | None = None,
    legend: bool = True,
) -> list[Axes]:
    """Frequency response: amplitude, logarithmic, above the phase.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `nonsmooth.structures.frequency_response`.
    outputs, inputs : str or sequence of str, optional
        Coordinates of the answer and of the force. Pairs of them are drawn, at most four; the first
        ones by default.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    list of matplotlib.axes.Axes
        The axes of the amplitude and those of the phase.

    Raises
    ------
    OptionError
        For another dataset, an unknown coordinate, or more than four pairs.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> mass = ns.Structure([[1.0]], [[4.0]], damping=[[0.1]])
    >>> found = ns.structures.frequency_response(mass, [1.0, 2.0, 3.0])
    >>> above, below = ns.plot.frequency_response(found)
    >>> above.get_yscale(), below.get_xlabel()
    ('log', 'frequency [rad/s]')
    """
    if not {"response", "frequency", "output", "input"} <= set(data.variables):
        raise OptionError("data: give a result of structures.frequency_response")
    most = len(LINES)
    seen, driven = ([str(name) for name in data[side].values] for side in ("output", "input"))
    ends = [
        known[:most] if given is None else _chosen(name, given, known)
        for name, given, known in (("outputs", outputs, seen), ("inputs", inputs, driven))
    ]
    pairs = [(output, force) for force in ends[1] for output in ends[0]]
    if outputs is None and inputs is None:
        pairs = pairs[:most]
    if len(pairs) > most:
        raise OptionError(f"outputs: {len(pairs)} pairs with inputs; at most {most} are told apart")
    curves = {
        f"{output} over {force}": data["response"].sel(output=output, input=force).values
        for output, force in pairs
    }
    return _bode(data["frequency"], curves, axis_label(data["amplitude"]), ax, legend, True)


def _chosen(option: str, given: str | Sequence[str], known: list[str]) -> list[str]:
    names = [given] if isinstance(given, str) else list(given)
    for name in names:
        if name not in known:
            raise OptionError(f"{option}: {unknown_name('coordinate', name, known)}")
    if not 0 < len(names) <= len(LINES):
        raise OptionError(f"{option}: give one to {len(LINES)} names; more are not told apart")
    return names


def _bode(
    over: xr.DataArray,
    curves: dict[str, Array],
    label: str,
    ax: Axes | None,
    legend: bool,
    logarithmic: bool,
) -> list[Axes]:
    """Amplitude above the phase in degrees, the latter without jumps by a whole turn."""
    above, below = divided(new_axes(height=_HEIGHT) if ax is None else ax, 2)
    for style, (name, values) in zip(LINES, curves.items(), strict=False):
        size = np.abs(values)
        if logarithmic:
            size = np.where(size > 0.0, size, np.nan)
        above.plot(over.values, size, **style, label=name)
        below.plot(over.values, np.degrees(np.unwrap(np.angle(values))), **style)
    if logarithmic:
        above.set_yscale("log")
    else:
        above.set_ylim(bottom=0.0)
    limits = float(over.values[0]), float(over.values[-1])
    for panel in (above, below):
        if limits[0] < limits[1]:
            panel.set_xlim(*limits)
    above.tick_params(labelbottom=False)
    below.yaxis.set_major_locator(_quarters(below))
    finish_axes(above, "", label)
    finish_axes(below, axis_label(over), _PHASE)
    if legend and len(curves) > 1:
        place_legend(above)
    return [above, below]


def _quarters(ax: Axes) -> Any:
    """Ticks at multiples of an eighth of a turn, or as many as are legible."""
    from matplotlib.ticker import MultipleLocator

    low, high = ax.dataLim.intervaly
    steps = [step for step in (45.0, 90.0, 180.0, 360.0) if (high - low) / step <= 6.0]
    return MultipleLocator(steps[0] if steps else 360.0 * np.ceil((high - low) / 2160.0))


def _polar(over: xr.DataArray, curves: dict[str, Array], ax: Axes | None, legend: bool) -> Axes:
    """Complex displacements in their plane, real part along the unbalance."""
    ax = new_axes(height=8.0) if ax is None else ax
    ax.axhline(0.0, color="0.7", linewidth=0.6, zorder=0)
    ax.axvline(0.0, color="0.7", linewidth=0.6, zorder=0)
    size = float(ax.xaxis.label.get_fontsize()) - 2.0
    for k, (style, (name, values)) in enumerate(zip(LINES, curves.items(), strict=False)):
        ax.plot(values.real, values.imag, **style, label=name)
        if k:
            continue
        for i in _spread(values):
            ax.plot(
                values[i].real, values[i].imag, color=style["color"], marker=".", markersize=4.0
            )
            outward = values[i] / (abs(values[i]) or 1.0)
            ax.annotate(
                f"{over.values[i]:.4g}", (values[i].real, values[i].imag), fontsize=size,
                xytext=(9.0 * outward.real, 7.0 * outward.imag), textcoords="offset points",
                ha="center", va="center", color="0.25",
            )  # fmt: skip
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.12)
    units = over.attrs.get("units", "")
    finish_axes(ax, "in phase with the angle 0 of the shaft [m]", "a quarter of a turn ahead [m]")
    ax.set_title(f"speeds in {units}", fontsize=size, loc="right")
    if legend and len(curves) > 1:
        place_legend(ax)
    return ax


def _spread(values: Array) -> list[int]:
    """Points of a curve at about equal distances along it."""
    lengths = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(values)))])
    wanted = np.linspace(0.0, lengths[-1], _MARKS + 2)[1:-1]
    return sorted({int(np.argmin(np.abs(lengths - each))) for each in wanted})
