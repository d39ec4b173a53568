"""Sections along the growth of the crack: Figs. 29 and 30."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from nonsmooth import ensemble
from nonsmooth.plot import PALETTE, growth_curve, print_figure, transient_section
from nonsmooth_chapter.fatigue.beam_data import (
    ETA,
    GROWTH,
    TAU_END,
    XI,
    beam,
    crack_at,
    tau_at,
)
from nonsmooth_chapter.fatigue.crack_motions import DROPPED, period_of
from nonsmooth_chapter.fatigue.growing import growing_run, strobe_labels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["CRACKS", "WINDOWS", "fig29", "fig30"]

CRACKS = (5.0, 12.09, 13.03, 13.4)
_STARTS = {"u": [0.0, 1.0], "v": [0.0, 0.0]}
_CHAPTER = {5.0: "period 1", 12.09: "chaos", 13.03: "chaos", 13.4: "period 4"}
# in steps, so that no line to the curve passes behind another inset
_PLACES = ((0.04, 0.20, 0.18, 0.36), (0.27, 0.20, 0.18, 0.36),
           (0.50, 0.41, 0.18, 0.36), (0.735, 0.62, 0.14, 0.27))  # fmt: skip
_AROUND = 1000.0  # time on either side of a printed one
# First and last time of the panels of Fig. 30, and what the chapter sees there.
WINDOWS = {
    "a": (tau_at(5.05), 900_514.0, "period 1"),
    "b": (tau_at(11.76), tau_at(12.24), "period 2"),
    "c": (915_662.0 - _AROUND, 915_662.0 + _AROUND, "period 3"),
    "d": (928_100.0 - _AROUND, 928_100.0 + _AROUND, "period 2"),
    "e": (936_903.0 - _AROUND, 936_903.0 + _AROUND, "period 2"),
}
_THINNED = 2000  # points of a panel at most
_TEXT = 8


def fig29(record: int = 600) -> tuple[Figure, xr.Dataset]:
    """Fig. 29: growth of the crack with sections at 5, 12.09, 13.03 and 13.4 mm.

    Sections are those of cracks of fixed length, s = 1 and d = 0, from rest and from (1, 0).

    Parameters
    ----------
    record : int, optional
        Strobes of each motion, after 3000 periods left out.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The curve with four insets.
    data : xarray.Dataset
        ``crack`` over ``time``; ``u`` and ``v`` over ``length``, ``start`` and ``point``, and
        their ``period``.

    Examples
    --------
    >>> figure, data = fig29(64)
    >>> data["period"].sel(length=12.09).values.tolist()
    [5, 1]
    """
    runs = ensemble(
        beam(CRACKS[0]), _STARTS, parameters={"crack": list(CRACKS)}, transient=DROPPED,
        record=record,
    )  # fmt: skip
    shape = (len(CRACKS), len(_STARTS["u"]), record)
    values = {name: runs[name].values.reshape(shape) for name in ("u", "v")}
    points = np.stack([values["u"], values["v"]], axis=-1)
    periods = np.array([[period_of(orbit, record // 2) for orbit in row] for row in points])
    time = np.linspace(0.0, TAU_END, 2000)
    over = ("length", "start", "point")
    data = xr.Dataset(
        {name: (over, array, dict(runs[name].attrs)) for name, array in values.items()}
        | {
            "period": (over[:2], periods, {"long_name": "period, 0 for none"}),
            "crack": ("time", [crack_at(t) for t in time],
                      {"long_name": "crack length", "units": "mm"}),
        },
        {"time": ("time", time, {"long_name": "time [1/omega_M]"}),
         "length": ("length", list(CRACKS), {"long_name": "crack length", "units": "mm"})},
        {"xi": XI, "eta": ETA, "s": 1.0, "d": 0.0, "growth": GROWTH, "periods_dropped": DROPPED},
    )  # fmt: skip
    return _curve(data), data


def _curve(data: xr.Dataset) -> Figure:
    figure, (ax,) = print_figure(1, 1, width=16.0, height=9.5)
    # the curve begins a little above the notch, on which the first section stands
    first = float(data["crack"][0])
    sections = {
        max(crack, first): data[["u", "v"]].sel(length=crack).stack(strobe=("start", "point"))
        for crack in CRACKS
    }
    flat = {crack: part.reset_index("strobe", drop=True) for crack, part in sections.items()}
    ax.set_xlabel(r"time, $\tau$")
    growth_curve(data[["crack"]], flat, ax=ax, places=_PLACES)
    insets: Any = ax.child_axes
    for inset, crack in zip(insets, CRACKS, strict=True):
        rest, other = (str(n) if n else "none" for n in data["period"].sel(length=crack).values)
        words = f"period {rest}"
        if other != rest:
            words += f" (square: {other})"
            part = data.sel(length=crack).isel(start=1)
            inset.plot(part["u"], part["v"], linestyle="none", marker="s", markersize=3.5,
                       markeredgewidth=0.0, color=PALETTE["vermilion"])  # fmt: skip
        inset.set_title(
            f"{crack:g} mm: {words}\nchapter: {_CHAPTER[crack]}", fontsize=6.5, pad=2.5,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.0},
        )  # fmt: skip
        spans = (f"{name} {low:.2f} to {high:.2f}" for name, (low, high) in
                 (("u", inset.get_xlim()), ("v", inset.get_ylim())))  # fmt: skip
        inset.set_xlabel(
            "\n".join(spans), fontsize=6, color="0.35", labelpad=2.0,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5},
        )  # fmt: skip
    return figure


def fig30() -> tuple[Figure, xr.Dataset]:
    """Fig. 30: strobes of the beam while its crack grows, in the windows that the chapter names.

    The run begins at rest at 5 mm, s = 1 and d = 0, with the length frozen in every period.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Panels (a) to (e), and (f): local periods over the crack length, frozen per period and
        grown within the flow.
    data : xarray.Dataset
        ``u``, ``v``, ``crack`` and local ``period`` over ``time``.
    """
    figure, axes = print_figure(3, 2, width=16.0, height=19.0)
    run = growing_run("frozen")
    labels = strobe_labels(run.isel(time=slice(200, None)))
    for ax, (letter, (first, last, printed)) in zip(axes, WINDOWS.items(), strict=False):
        part = run.sel(time=slice(first, last))
        every = -(-part.sizes["time"] // _THINNED)
        known = labels.sel(time=slice(first, last))["period"]
        # thinned alike, the points of period one have their arrow still
        thin = slice(None, None, every)
        ax.set_xlabel("deflection $u$ [$A_b$]")
        ax.set_ylabel(r"velocity $v$ [$A_b \omega_M$]")
        ax.margins(0.12)  # room for the arrows
        transient_section(
            part.isel(time=thin), "u", "v", labels=labels.sel(time=part["time"].isel(time=thin)),
            colour="crack", ax=ax,
        )  # fmt: skip
        ax.locator_params(axis="x", nbins=5)
        names, counts = np.unique(known.values, return_counts=True)
        most = int(names[counts.argmax()])
        label = f"period {most}" if most else "no period"
        ax.set_title(
            rf"({letter}) $\tau$ {first:,.0f} to {last:,.0f}"
            + f"\n{label} (chapter: {printed})",
            loc="left", fontsize=_TEXT - 0.5,
        )  # fmt: skip
    _periods(axes[5])
    kept = run.isel(time=slice(200, None)).assign(period=("time", labels["period"].values))
    kept.attrs = {"growth": GROWTH, "xi": XI, "eta": ETA, "s": 1.0, "d": 0.0}
    return figure, kept


def _periods(ax: Axes) -> None:
    """Local periods over the crack length, one row of points for each way of growing."""
    ways = (("frozen", "frozen per period", "black"), ("flow", "within the flow", "vermilion"))
    for row, (grows, name, colour) in enumerate(ways):
        run = growing_run("frozen" if grows == "frozen" else "flow")
        labels = strobe_labels(run.isel(time=slice(200, None)))
        late = labels["crack"].values > 10.0
        ax.plot(
            labels["crack"].values[late], labels["period"].values[late] + 0.16 * row,
            linestyle="none", marker="s", markersize=2.0, markeredgewidth=0.0, rasterized=True,
            color=PALETTE.get(colour, colour), label=name,
        )  # fmt: skip
    for tau in (900_514.0, 915_662.0, 928_100.0, 936_903.0):
        ax.axvline(crack_at(tau), color="0.75", linewidth=0.6, zorder=0)
    ax.legend(frameon=False, fontsize=7, loc="upper left", markerscale=2.0)
    ax.set_ylim(-0.4, 5.0)
    ax.set_yticks(range(5))
    ax.set_xlabel("crack length [mm]")
    ax.set_ylabel("local period, 0 for none")
    ax.set_title("(f) both ways of growing\nlines: printed times", loc="left", fontsize=_TEXT - 0.5)
