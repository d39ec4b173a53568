"""`profiles`: how fast the likelihood falls away from each estimate of a fit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import divided, new_axes
from nonsmooth.plot.fitted_parameters import chosen_parameters, legend_of_panels
from nonsmooth.plot.style import LINES, PALETTE, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["profiles"]

Floats = npt.NDArray[np.float64]

_COLUMNS = 3  # panels beside each other
_WIDTH, _HEIGHT = 5.4, 4.6  # of a panel in a figure of our own, in cm
_LEAST_WIDTH = 8.0  # of that figure
_BOTTOM, _TOP = -0.04, 1.4  # of the threshold: what is drawn
_ROOM = 0.12  # of what is drawn across, on either side
_POINTS = 200  # of a curve
_WHAT = "fall of 2 log L"


@checked
def profiles(
    data: xr.Dataset,
    parameters: str | Sequence[str] | None = None,
    *,
    ax: Axes | None = None,
) -> list[Axes]:
    """Profiles of the likelihood, a panel for each parameter.

    The black curve says by how much twice the logarithm of the likelihood falls where one parameter
    is held and everything else is found anew. Dots are the points that were computed. Where the
    curve meets the dotted line the 95 % interval ends, whose ground is coloured. The dashed curve
    is the quadratic one that the standard error alone would give. What the bounds forbid is
    hatched.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `fit`.
    parameters : str or list of str, optional
        Which of them to draw; all by default.
    ax : matplotlib.axes.Axes, optional
        Where to draw, axes of a grid, whose place the panels share; a new figure by default.

    Returns
    -------
    list of matplotlib.axes.Axes
        The panels.

    Raises
    ------
    OptionError
        For another dataset, an unknown parameter, or a fit whose profiles could not be found.

    Notes
    -----
    A profile that stays below the line up to a bound tells that the record does not determine the
    parameter. One that leaves the dashed curve tells that the standard error is not enough, so that
    the interval is to be taken from the profile.

    Between the computed points the curve follows the signed root of the fall, which is nearly
    straight and is interpolated by a monotone cubic.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.linspace(0, 3, 60)
    >>> noise = 0.1 * np.random.default_rng(3).standard_normal(t.size)
    >>> record = ns.measured.from_arrays({"x": np.exp(-0.5 * t) + noise}, times=t)
    >>> decay = ns.System(states=["x"], parameters={"k": 1.0}, equations={"x": "-k*x"})
    >>> (panel,) = ns.plot.profiles(ns.fit(decay, record, {"k": (0.01, 2)}, starts=1))
    >>> panel.get_xlabel()
    'k'
    """
    names = chosen_parameters(data, parameters, {"profile_value", "profile_rise"})
    columns = min(len(names), _COLUMNS)
    rows = -(-len(names) // columns)
    if ax is None:
        ax = new_axes(width=max(_WIDTH * columns, _LEAST_WIDTH), height=_HEIGHT * rows + 1.2)
    panels = divided(ax, rows, columns)
    for spare in panels[len(names) :]:
        spare.remove()
    panels = panels[: len(names)]
    for k, (panel, name) in enumerate(zip(panels, names, strict=True)):
        _draw(panel, data.sel(parameter=name), float(data.attrs["profile_threshold"]))
        finish_axes(panel, name, _WHAT if k % columns == 0 else " ")
    legend_of_panels(panels)
    return panels


def _draw(ax: Axes, one: xr.Dataset, threshold: float) -> None:
    """Profile of one parameter."""
    values, rises = one["profile_value"].values, one["profile_rise"].values
    good = np.isfinite(values) & np.isfinite(rises)
    if np.count_nonzero(good) < 2:
        raise OptionError(
            f"data: no profile of {one['parameter'].item()!r} was found; its attribute 'message'"
            " says what went wrong"
        )
    values, rises = values[good], rises[good]
    estimate, deviation = float(one["estimate"]), float(one["standard_error"])
    low, high = float(one["interval_low"]), float(one["interval_high"])
    seen = np.append(values[rises <= _TOP * threshold], (low, high))
    room = _ROOM * float(np.ptp(seen))
    first, last = float(seen.min()) - room, float(seen.max()) + room
    ax.axvspan(low, high, color=PALETTE["sky"], alpha=0.25, linewidth=0.0, zorder=0,
               label="95 % interval")  # fmt: skip
    ax.axhline(threshold, color="0.35", linestyle=":", linewidth=1.0, label="threshold")
    ax.axvline(estimate, color="0.35", linewidth=0.6, label="estimate")
    across = np.linspace(first, last, _POINTS)
    ax.plot(across, ((across - estimate) / deviation) ** 2,
            **LINES[1] | {"linewidth": 0.8}, label="quadratic")  # fmt: skip
    ax.plot(*_curve(values, rises, estimate), **LINES[0], label="profile")
    ax.plot(values, rises, "o", markersize=2.5, color="black", markeredgewidth=0.0)
    for bound, beyond in (
        (float(one["lower_bound"]), first), (float(one["upper_bound"]), last)
    ):  # fmt: skip
        if first <= bound <= last:
            ax.axvspan(*sorted((bound, beyond)), facecolor="none", edgecolor="0.6", hatch="////",
                       linewidth=0.0, label="beyond the bounds")  # fmt: skip
            ax.axvline(bound, color="0.35", linewidth=1.2)
    ax.set_xlim(first, last)
    ax.set_ylim(_BOTTOM * threshold, _TOP * threshold)


def _curve(values: Floats, rises: Floats, estimate: float) -> tuple[Floats, Floats]:
    """The profile between its points."""
    from scipy.interpolate import PchipInterpolator

    roots = np.sign(values - estimate) * np.sqrt(rises)
    across = np.linspace(values[0], values[-1], _POINTS)
    return across, PchipInterpolator(values, roots)(across) ** 2
