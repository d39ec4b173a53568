"""A measured spectrum and a computed one on the same axes, in decibels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.plot.style import LINES, PALETTE

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["MEASURED", "decibel_label", "draw_spectra", "is_spectrum"]

MEASURED = PALETTE["orange"]  # in all comparisons
_PER_DECADE = {"amplitude": 20.0, "power_density": 10.0}
_RANGE = 120.0  # decibels below the largest value; what lies lower is drawn there
_ORDERS = 10.0  # harmonics shown


def is_spectrum(data: xr.Dataset, y: str) -> bool:
    """Whether a variable is that of one spectrum."""
    return y in _PER_DECADE and y in data and data[y].dims == ("frequency",)


def draw_spectra(
    computed: xr.Dataset, measured: xr.Dataset, x: str, y: str, ax: Axes, labels: tuple[str, str]
) -> None:
    """Both as curves; dashed lines stand at the multiples of the forcing's frequency."""
    looks: Any = (
        (measured, labels[1], {"color": MEASURED, "linewidth": 0.9}),
        (computed, labels[0], {"color": LINES[0]["color"], "linewidth": 0.7}),
    )
    largest = max(float(data[y].max()) for data in (computed, measured)) or 1.0
    floor = largest * 10.0 ** (-_RANGE / _PER_DECADE[y])
    for data, label, look in looks:
        ax.plot(data[x].values, _decibels(data[y].values, floor, y), label=label, **look)
    period = next((d.attrs["period"] for d in (computed, measured) if "period" in d.attrs), None)
    last = max(float(data[x].max()) for data in (computed, measured))
    two_sided = min(float(data[x].min()) for data in (computed, measured)) < 0.0
    if period is not None:
        forcing = 1.0 if x == "harmonic" else 1.0 / float(period)
        last = min(last, _ORDERS * (0.5 if two_sided else 1.0) * forcing)
        most = int(last / forcing * (1.0 + 1e-9))
        for order in range(-most if two_sided else 1, most + 1):
            ax.axvline(
                order * forcing, color="0.75", linestyle="--" if order else "-", linewidth=0.5,
                zorder=0,
            )  # fmt: skip
    ax.set_xlim(-last if two_sided else 0.0, last)


def _decibels(values: Any, floor: float, y: str) -> npt.NDArray[np.float64]:
    return np.asarray(_PER_DECADE[y] * np.log10(np.maximum(values, floor)), float)


def decibel_label(variable: xr.DataArray) -> str:
    """Label of a spectrum in decibels: of what, and relative to which unit."""
    name = str(variable.attrs.get("long_name", variable.name))
    unit = str(variable.attrs.get("units", ""))
    return f"{name} [dB re 1{' ' + unit if unit not in ('', '1') else ''}]"
