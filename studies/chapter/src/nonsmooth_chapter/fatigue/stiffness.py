"""Restoring force of a specimen whose crack opens and closes: Fig. 27."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from nonsmooth.fatigue import Specimen, cubic_stiffness
from nonsmooth.plot import PALETTE, print_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["fig27"]

_CRACKS = (5.0, 6.4, 10.0, 14.0, 18.0)  # mm; 6.4 is where the tests of Table 3 begin
_FIXED = 10.0
_TEXT = 8
_REACH = 0.5  # mm of deflection to either side
_COLOURS = ("black", "blue", "green", "orange", "vermilion")


def fig27(points: int = 201) -> tuple[Figure, xr.Dataset]:
    """Fig. 27: force over deflection for (a) a crack that stays and (b) one that grows.

    The stiffness is that of the whole beam while the crack is closed, Eq. (47), and that of Eq.
    (48) while it is open; broken lines have the cubic law of Fig. 29 in its place, scaled to the
    same closed stiffness.

    Parameters
    ----------
    points : int, optional
        Deflections.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Panels (a) and (b).
    data : xarray.Dataset
        ``force`` in N over ``law``, ``crack`` and ``deflection`` in mm, and ``stiffness_open`` in
        N/mm.

    Examples
    --------
    >>> figure, data = fig27(11)
    >>> round(float(data["force"].sel(law="guinea", crack=10.0, deflection=-0.5)), 1)
    -588.5
    """
    specimen = Specimen()
    deflection = np.linspace(-_REACH, _REACH, points)
    closed = float(specimen.closed_stiffness)
    cracks = np.array(_CRACKS)
    open_ = np.stack(
        [specimen.stiffness(cracks), closed * cubic_stiffness(cracks) / cubic_stiffness(5.0)]
    )
    stiffness = np.where(deflection > 0.0, open_[:, :, None], closed)
    force = stiffness * deflection
    data = xr.Dataset(
        {
            "force": (("law", "crack", "deflection"), force,
                      {"long_name": "restoring force", "units": "N"}),
            "stiffness_open": (("law", "crack"), open_,
                               {"long_name": "stiffness with the crack open", "units": "N/mm"}),
        },
        {
            "law": ["guinea", "cubic"],
            "crack": ("crack", cracks, {"long_name": "crack length", "units": "mm"}),
            "deflection": ("deflection", deflection, {"long_name": "deflection", "units": "mm"}),
        },
        {"closed_stiffness": closed},
    )  # fmt: skip
    return _drawn(data), data


def _drawn(data: xr.Dataset) -> Figure:
    figure, (left, right) = print_figure(1, 2, width=16.0, height=7.0)
    one = data["force"].sel(law="guinea", crack=_FIXED)
    left.plot(data["deflection"], one, color="black", linewidth=1.2)
    left.annotate("open", (0.25, float(one.sel(deflection=0.25, method="nearest"))),
                  xytext=(6, -12), textcoords="offset points", fontsize=_TEXT)  # fmt: skip
    left.annotate("closed", (-0.25, float(one.sel(deflection=-0.25, method="nearest"))),
                  xytext=(6, -10), textcoords="offset points", fontsize=_TEXT)  # fmt: skip
    left.set_title(f"(a) crack of {_FIXED:g} mm, Eqs. (47), (48)", loc="left", fontsize=_TEXT)
    for crack, name in zip(_CRACKS, _COLOURS, strict=True):
        colour = PALETTE.get(name, name)
        for law, style in (("guinea", "-"), ("cubic", "--")):
            right.plot(
                data["deflection"], data["force"].sel(law=law, crack=crack), style, color=colour,
                linewidth=1.1, label=f"{crack:g} mm" if law == "guinea" else None,
            )  # fmt: skip
    # closed, all cracks are the same: one line for all, in no crack's colour
    shut = data["force"].sel(law="guinea", crack=_FIXED).where(data["deflection"] <= 0.0)
    right.plot(data["deflection"], shut, color="black", linewidth=1.4)
    right.set_title("(b) growing crack; broken: cubic law", loc="left", fontsize=_TEXT)
    right.legend(
        frameon=False, loc="upper left", title="crack length", title_fontsize=7, fontsize=7
    )
    for ax in (left, right):
        _finish(ax)
    left.set_ylabel("restoring force [N]")
    left.set_ylim(right.get_ylim())
    return figure


def _finish(ax: Axes) -> None:
    ax.axhline(0.0, color="0.7", linewidth=0.5, zorder=0)
    ax.axvline(0.0, color="0.7", linewidth=0.5, zorder=0)
    ax.set_xlabel("deflection, positive opens the crack [mm]")
