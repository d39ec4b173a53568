"""`reduction`: receptance of a reduced model beside that of the full one, and its error."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import PALETTE, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["reduction"]

_NEEDED = ("error", "full", "reduced")


@checked
def reduction(
    data: xr.Dataset,
    *,
    show: Literal["receptance", "error"] = "receptance",
    coordinate: str | None = None,
    ax: Axes | None = None,
    legend: bool = True,
) -> Axes:
    """Receptance of a reduced model beside that of the full one, or its relative error.

    Parameters
    ----------
    data : xarray.Dataset
        ``estimate`` of a `nonsmooth.structures.ReducedStructure`.
    show : {"receptance", "error"}, optional
        The size of the receptance at one kept coordinate, or the error at all of them together.
    coordinate : str, optional
        The kept coordinate; the first by default.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes. The full model is a wide grey line, the reduced one blue, and the error black;
        of several speeds each has its own dashes.

    Raises
    ------
    OptionError
        For another dataset, or a coordinate that is not in it.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> n = 40
    >>> stiffness = n * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    >>> chain = ns.Structure(np.eye(n) / n, stiffness)
    >>> small = ns.structures.reduce(chain, keep=["q39"], frequency_range=(0.0, 10.0))
    >>> ax = ns.plot.reduction(small.estimate)
    >>> ax.get_ylabel(), ax.get_yscale()
    ('receptance at q39 [m/N]', 'log')
    """
    missing = [name for name in _NEEDED if name not in data]
    if missing:
        raise OptionError(
            f"data: it has no {missing[0]!r}; give the estimate of a ReducedStructure that was made"
            " with frequency_range="
        )
    known = [str(name) for name in data["coordinate"].values]
    coordinate = known[0] if coordinate is None else coordinate
    if coordinate not in known:
        raise OptionError(f"coordinate = {coordinate!r} is not in the estimate: {', '.join(known)}")
    ax = new_axes() if ax is None else ax
    frequency = data["frequency"].values
    speeds = data["speed"].values
    for i, speed in enumerate(speeds):
        at = data.isel(speed=i)
        suffix = f", {speed:g} rad/s" if len(speeds) > 1 else ""
        dashes: dict[str, Any] = {"linestyle": ("-", "--", ":", "-.")[i % 4]}
        if show == "error":
            ax.semilogy(frequency, at["error"], color="black", label=f"error{suffix}", **dashes)
            continue
        at = at.sel(coordinate=coordinate)
        full, reduced = (f"{name} model{suffix}" for name in ("full", "reduced"))
        ax.semilogy(frequency, at["full"], color="0.75", linewidth=3.0, label=full, **dashes)
        ax.semilogy(frequency, at["reduced"], color=PALETTE["blue"], label=reduced, **dashes)
    ax.set_xlim(frequency[0], frequency[-1])
    label = "relative error"
    if show == "receptance":
        label = f"receptance at {coordinate}"
        if "unit" in data.coords:  # estimates that were saved earlier have none
            label += f" [{data['unit'].sel(coordinate=coordinate).item()}]"
    finish_axes(ax, "frequency [rad/s]", label)
    if legend and (show != "error" or len(speeds) > 1):
        place_legend(ax)
    return ax
