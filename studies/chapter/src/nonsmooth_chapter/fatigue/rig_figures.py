"""Histories of the two-mass rig: Figs. 24 and 25."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import xarray as xr

from nonsmooth.plot import PALETTE, phases, print_figure
from nonsmooth_chapter.fatigue.phase_claims import passages
from nonsmooth_chapter.fatigue.rig_data import SET_25, Stay, rig_system, start_up, stays, steady
from nonsmooth_chapter.fatigue.rig_si_claims import rig_of_fig_25

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["fig24", "fig25"]

_TEXT = 8
_BODIES = {"X1": "mass 1", "X3": "specimen", "X4": "mass 2"}
_NOTE_25 = (
    "The measured records of panels (b), (d), (f) of the chapter are not available; on the right"
    " stands the theory in SI units."
)


def fig24(periods: int = 6) -> tuple[Figure, xr.Dataset]:
    """Fig. 24: displacements from zero, the order of phases that its part b shows, steady motion.

    Parameters
    ----------
    periods : int, optional
        Periods of the base in part (a).

    Returns
    -------
    figure : matplotlib.figure.Figure
        Panels (a) start-up, (b) a part of it, (c) steady motion; the phases as colours.
    data : xarray.Dataset
        The start-up; the steady motion as ``steady_X1`` and so on over ``steady_time``.

    Examples
    --------
    >>> figure, data = fig24()
    >>> round(data.attrs["shown_from"], 2), data.attrs["steady_phases"]
    (2.69, 'iv iii iv ii iv')
    """
    system = rig_system()
    run, late = start_up(system, 40, 2000), steady(system)
    period = float(run.attrs["period"])
    rows = passages(stays(run))
    shown = next(
        piece for piece in rows if piece[0][2] - piece[0][1] == min(b - a for _, a, b in piece)
    )
    window = (shown[0][1] - 0.15, shown[-1][2] + 0.15)
    figure, axes = print_figure(3, 1, width=16.0, height=17.0)
    end = float(late["time"][0])
    panels = [
        (run, (0.0, periods * period), "(a) start-up from zero"),
        (run, window, "(b) part of (a): (i), (iii), (iv), (ii) in turn"),
        (late, (end, end + 2.0 * period), "(c) steady motion, after 400 periods: no phase (i)"),
    ]
    for ax, (part, when, title) in zip(axes, panels, strict=True):
        _displacements(ax, part, when)
        ax.set_title(title, loc="left", fontsize=_TEXT)
    low, high = axes[1].get_ylim()
    axes[1].set_ylim(low, high + 0.15 * (high - low))  # room for the names above the curves
    _name_phases(axes[1], shown)
    _legend(figure, axes[0])
    names = ("X1", "X3", "X4")
    steady_part = {
        f"steady_{n}": ("steady_time", late[n].values, dict(late[n].attrs)) for n in names
    }
    data = (
        run[[*names, "mode"]]
        .assign(steady_part)
        .assign_coords(
            steady_time=("steady_time", late["time"].values, {"long_name": "time in steady motion"})
        )
    )
    data.attrs = {
        "shown_from": window[0] + 0.15,
        "shown_to": window[1] - 0.15,
        "steady_phases": str(late.attrs["phase_word"]),
    }
    return figure, data


def _displacements(ax: Axes, run: xr.Dataset, when: tuple[float, float]) -> None:
    phases(run, list(_BODIES), ax=ax, time_range=when, legend=False)
    styles: tuple[dict[str, Any], ...] = (
        {"linewidth": 1.6},
        {"linestyle": ":", "linewidth": 1.4},
        {"linestyle": "--"},
    )
    for line, style in zip(ax.lines, styles, strict=False):
        line.set(color="black", **style)
    ax.set_ylabel(r"displacement [$A_b$]")
    ax.set_xlabel(r"$\tau$")


def _name_phases(ax: Axes, rows: Sequence[Stay]) -> None:
    for name, begin, end in rows:
        ax.annotate(
            f"({name})", (0.5 * (begin + end), 1.0), xycoords=("data", "axes fraction"),
            xytext=(0, -10), textcoords="offset points", ha="center", fontsize=_TEXT,
        )  # fmt: skip


def _legend(figure: Figure, ax: Axes) -> None:
    lines = list(ax.lines)[: len(_BODIES)]
    spans = {str(c.get_label()): c for c in ax.collections}
    order = [name for name in ("i", "ii", "iii", "iv") if name in spans]
    figure.legend(
        [*lines, *(spans[name] for name in order)],
        [*_BODIES.values(), *(f"phase ({name})" for name in order)],
        loc="outside upper center", ncols=7, frameon=False, fontsize=7,
    )  # fmt: skip


def fig25(periods: int = 4) -> tuple[Figure, xr.Dataset]:
    """Fig. 25: theoretical histories, dimensionless and in SI units at 19.15 Hz and 2.8 mm.

    The measured histories of its panels (b), (d), (f) are not available; the SI units of the
    theory stand in their place.

    Parameters
    ----------
    periods : int, optional
        Periods of the steady motion that are drawn, 4 at most.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Acceleration of the base, of the masses, and displacements; left dimensionless, right SI.
    data : xarray.Dataset
        The steady run in SI units.

    Examples
    --------
    >>> figure, data = fig25()
    >>> data["X1"].attrs["units"], round(float(data["base"].max()), 1)
    ('mm', 40.5)
    """
    machine = rig_of_fig_25()
    run = steady(rig_system(SET_25))
    data = machine.to_si(steady(machine.system()))
    figure, axes = print_figure(3, 2, width=16.0, height=15.0)
    rows = (
        ("base acceleration", ("base",), "X''_b", "m/s$^2$"),
        ("relative acceleration", ("acceleration1", "acceleration2"), "X''_1, X''_4", "m/s$^2$"),
        ("relative displacement", ("X1", "X4", "X3"), "X_1, X_4, X_3", "mm"),
    )
    for column, part in enumerate((run, data)):
        time = part["time"].values - float(part["time"][0])
        keep = slice(0, 1 + periods * 1000)
        for row, (title, names, symbol, unit) in enumerate(rows):
            ax = axes[2 * row + column]
            for name in names:
                ax.plot(time[keep], part[name].values[keep], **_style(name))
            where = "" if column == 0 else ", in SI"
            ax.set_title(f"({'ace'[row]}) {title}{where}", loc="left", fontsize=_TEXT)
            ax.set_ylabel(f"${symbol}$" if column == 0 else f"{title.split()[-1]} [{unit}]")
            ax.set_xlabel(r"$\tau$, steady motion" if column == 0 else "time [s], steady motion")
    figure.legend(
        *axes[4].get_legend_handles_labels(), loc="outside upper center", ncols=3, frameon=False,
        fontsize=_TEXT,
    )  # fmt: skip
    figure.supxlabel(_NOTE_25, fontsize=7, ha="left", x=0.01)
    data.attrs["note"] = _NOTE_25
    return figure, data


def _style(name: str) -> dict[str, Any]:
    if name in ("X1", "acceleration1"):
        return {"color": "black", "linewidth": 1.8, "label": "mass 1"}
    if name == "X3":
        return {"color": PALETTE["vermilion"], "linestyle": ":", "linewidth": 1.5,
                "label": "specimen"}  # fmt: skip
    if name == "base":
        return {"color": "black", "linewidth": 1.0}
    return {"color": PALETTE["blue"], "linewidth": 0.9, "label": "mass 2"}
