"""Spectra on the same axes, in decibels: a measured one and a computed one, or more."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.plot.style import LINES, PALETTE

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = [
    "MEASURED",
    "SpectrumCurve",
    "decibel_label",
    "draw_compared_spectra",
    "draw_spectra",
    "is_spectrum",
]

MEASURED = PALETTE["orange"]  # in all comparisons
_PER_DECADE = {"amplitude": 20.0, "power_density": 10.0}
_RANGE = 120.0  # decibels below the largest value; what lies lower is drawn there
_ORDERS = 10.0  # harmonics shown of a comparison


def is_spectrum(data: xr.Dataset, y: str) -> bool:
    """Whether a variable is that of one spectrum."""
    return y in _PER_DECADE and y in data and data[y].dims == ("frequency",)


class SpectrumCurve(NamedTuple):
    """A spectrum, its text in the legend, and how its curve looks."""

    data: xr.Dataset
    label: str
    look: dict[str, Any]


def draw_compared_spectra(
    computed: xr.Dataset, measured: xr.Dataset, x: str, y: str, ax: Axes, labels: tuple[str, str]
) -> None:
    """Both as curves, with the period of either."""
    curves = (
        SpectrumCurve(measured, labels[1], {"color": MEASURED, "linewidth": 0.9}),
        SpectrumCurve(computed, labels[0], {"color": LINES[0]["color"], "linewidth": 0.7}),
    )
    period = next((d.attrs["period"] for d in (computed, measured) if "period" in d.attrs), None)
    draw_spectra(curves, x, y, ax, None if period is None else float(period))


def draw_spectra(
    curves: Sequence[SpectrumCurve],
    x: str,
    y: str,
    ax: Axes,
    period: float | None,
    n_orders: float | None = _ORDERS,
) -> None:
    """Curves in decibels; dashed lines stand at the multiples of the forcing's frequency.

    With a period so many of them are shown; without a number, all frequencies.
    """
    largest = max(float(each.data[y].max()) for each in curves) or 1.0
    floor = largest * 10.0 ** (-_RANGE / _PER_DECADE[y])
    for data, label, look in curves:
        ax.plot(data[x].values, _decibels(data[y].values, floor, y), label=label, **look)
    last = max(float(each.data[x].max()) for each in curves)
    two_sided = min(float(each.data[x].min()) for each in curves) < 0.0
    if period is not None:
        forcing = 1.0 if x == "harmonic" else 1.0 / period
        if n_orders is not None:
            last = min(last, n_orders * (0.5 if two_sided else 1.0) * forcing)
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
