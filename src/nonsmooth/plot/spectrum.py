"""`spectrum`: amplitudes over frequency, with the harmonics of the forcing."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.style import LINES, PALETTE, axis_label, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["spectrum"]

_FLOOR = 1e-12  # of the largest value; rounding lies below
_ORDERS = 10.0  # harmonics shown


@checked
def spectrum(
    data: xr.Dataset,
    variable: str = "amplitude",
    *,
    ax: Axes | None = None,
    over: str = "frequency",
    highest: float | None = None,
) -> Axes:
    """Amplitude or power density over frequency, logarithmic, with the harmonics marked.

    Of a full spectrum forward whirl stands on the right, backward whirl on the left.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `power_spectrum` or `full_spectrum`.
    variable : {"amplitude", "power_density"}, optional
        What to draw.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    over : {"frequency", "harmonic"}, optional
        Frequency in cycles per unit time, or over that of the forcing, as orders of a speed.
    highest : float, optional
        Highest frequency, or harmonic, to draw; ten times that of the forcing by default, five of a
        full spectrum.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; dashed lines stand at the multiples of the forcing's frequency.

    Raises
    ------
    OptionError
        For another dataset or variable.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.soft_impact(), periods=120)
    >>> ax = ns.plot.spectrum(ns.power_spectrum(run, "x", transient=100))
    >>> ax.get_yscale(), ax.get_xlabel()
    ('log', 'frequency in cycles per unit time')
    """
    if variable not in ("amplitude", "power_density") or variable not in data:
        raise OptionError(
            f"variable = {variable!r}: draw 'amplitude' or 'power_density' of a result of"
            " power_spectrum or full_spectrum"
        )
    if over not in ("frequency", "harmonic") or over not in data.coords:
        raise OptionError(
            f"over = {over!r}: draw over 'frequency', or over 'harmonic' where the run has a period"
        )
    ax = new_axes() if ax is None else ax
    frequency, values = data[over].values, data[variable].values
    forcing = 1.0 / data.attrs["period"] if "period" in data.attrs else None
    if over == "harmonic":
        forcing = 1.0
    two_sided = frequency[0] < 0.0
    last = float(frequency[-1])
    if highest is not None:
        last = min(last, float(highest))
    elif forcing is not None:
        last = min(last, (_ORDERS if not two_sided else _ORDERS / 2) * forcing * (1.0 + 1e-9))
    if forcing is not None:
        most = int(last / forcing * (1.0 + 1e-9))
        for order in range(-most if two_sided else 1, most + 1):
            ax.axvline(
                order * forcing, color=PALETTE["sky"], linestyle="--" if order else "-",
                linewidth=0.5, zorder=0,
            )  # fmt: skip
    shown = np.abs(frequency) <= last * (1.0 + 1e-9)
    floor = _FLOOR * float(values.max(initial=0.0)) or 1e-300
    ax.semilogy(frequency[shown], np.maximum(values[shown], floor), **LINES[0] | {"linewidth": 0.7})
    ax.set_xlim(-last if two_sided else 0.0, last)
    finish_axes(ax, axis_label(data[over]), axis_label(data[variable]))
    return ax
