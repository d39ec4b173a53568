"""Figures of the rig: its two models, and motions from zero and settled."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from nonsmooth import System
from nonsmooth.models import breathing_crack, fatigue_rig
from nonsmooth.plot import PALETTE, phases, print_figure
from nonsmooth_chapter.drawing import arrow, bare, damper, spring
from nonsmooth_chapter.fatigue.record_claims import passages
from nonsmooth_chapter.fatigue.rig import SET_25, Stay, rig_system, start_up, stays, steady
from nonsmooth_chapter.fatigue.rig_claims import rig_of_fig_25

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["fig23", "fig24", "fig25", "fig26"]


# Drawings of the fatigue-testing rig: two masses, Fig. 23, and one, Fig. 26.

_TEXT = 8
_FORCE, _MOTION = PALETTE["vermilion"], PALETTE["blue"]


def fig23() -> tuple[Figure, xr.Dataset]:
    """Fig. 23: two masses above and below the specimen.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Masses, springs and dashpots between the base and the specimen.
    data : xarray.Dataset
        ``value`` over ``parameter``: those of `nonsmooth.models.fatigue_rig`, the model drawn.

    Examples
    --------
    >>> figure, data = fig23()
    >>> data.sizes["parameter"] > 5
    True
    """
    figure, (ax,) = print_figure(width=11.0, height=12.0)
    for at in (0.0, 10.0):
        _wall(ax, (-4.0, at), (4.0, at))
    for side in (-4.0, 4.0):
        _wall(ax, (side, 0.0), (side, 10.0))
    for number, mass, end, near in (("1", 7.0, 10.0, 8.0), ("2", 2.0, 0.0, 2.0)):
        _box(ax, (-1.7, mass), (3.4, 1.0), f"$m_{number}$", "0.88")
        names = (rf"$k_{{Ls{number}}}$", rf"$c_{{Ls{number}}}$",
                 rf"$k_{{p{number}}}$", rf"$c_{{p{number}}}$")  # fmt: skip
        for at, name, part in zip((-1.5, -0.8, 0.8, 1.5), names, (spring, damper) * 2, strict=True):
            part(ax, np.array([at, near]), np.array([at, end]))
            beside = -0.75 if at < -1.0 else (0.75 if at > 1.0 else 0.0)
            if beside:
                _name(ax, (at + beside, 0.5 * (near + end) + 0.35), name)
            else:
                _name(ax, (at, end + (0.35 if end > near else -0.35)), name)
        arrow(ax, (0.0, near + 0.65 * (end - near)), (0.0, near), _FORCE, "")
        _name(ax, (0.0, near + 0.8 * (end - near)), f"$P_{number}$", _FORCE)
        face = 7.0 if number == "1" else 3.0
        spring(ax, np.array([0.0, face]), np.array([0.0, 5.3 if number == "1" else 5.0]))
        _name(ax, (0.75, 0.5 * (face + 5.15)), rf"$k_{{sc{number}}}$")
        arrow(ax, (2.3, mass + 1.0), (2.3, mass), _MOTION, "")
        _name(ax, (2.85, mass + 0.5), f"$x_{{m{number}}}$", _MOTION)
    _specimen(ax)
    arrow(ax, (4.6, 5.8), (4.6, 4.4), _MOTION, "")
    _name(ax, (5.7, 5.1), r"$A_b\,\sin\,\Omega t$", _MOTION)
    bare(ax, (-4.4, 6.8), (-0.8, 10.8))
    return figure, _parameters(fatigue_rig())


def fig26() -> tuple[Figure, xr.Dataset]:
    """Fig. 26: one mass, while both are in contact with the specimen.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The mass with the springs and the dashpot of Eq. (45).
    data : xarray.Dataset
        ``value`` over ``parameter``: those of `nonsmooth.models.breathing_crack`, which has the
        same mass on a cracked specimen.

    Examples
    --------
    >>> figure, data = fig26()
    >>> len(figure.axes)
    1
    """
    figure, (ax,) = print_figure(width=8.0, height=7.0)
    _wall(ax, (-2.6, 0.0), (2.6, 0.0))
    _box(ax, (-2.0, 2.6), (4.0, 1.2), "$M = m_1 + m_2$", "0.88")
    for at, name, part in ((-1.5, "$k_M$", spring), (0.0, "$c_M$", damper), (1.5, "$k_s$", spring)):
        part(ax, np.array([at, 0.0]), np.array([at, 2.6]))
        _name(ax, (at + 0.55, 1.3), name)
    arrow(ax, (2.5, 3.8), (2.5, 2.6), _MOTION, "")
    _name(ax, (3.0, 3.2), "$z_M$", _MOTION)
    arrow(ax, (3.0, 0.7), (3.0, -0.5), _MOTION, "")
    _name(ax, (4.0, 0.1), r"$A_b\,\sin\,\Omega t$", _MOTION)
    bare(ax, (-3.0, 5.0), (-0.8, 4.2))
    return figure, _parameters(breathing_crack())


def _specimen(ax: Axes) -> None:
    """The rigid beam on its springs and dashpots, between the contacts."""
    _box(ax, (-3.4, 5.0), (6.8, 0.3), "", "0.75")
    for side in (-1.0, 1.0):
        _wall(ax, (4.0 * side, 3.4), (2.2 * side, 3.4))
        spring(ax, np.array([3.2 * side, 3.4]), np.array([3.2 * side, 5.0]))
        damper(ax, np.array([2.5 * side, 3.4]), np.array([2.5 * side, 5.0]))
        _name(ax, (3.1 * side, 2.95), r"$\frac{1}{2}k_s,\ \frac{1}{2}c_s$")
    _name(ax, (-2.4, 5.65), "specimen")


def _wall(ax: Axes, begin: Any, end: Any) -> None:
    ax.plot(*zip(begin, end, strict=True), color="black", linewidth=1.6)


def _box(ax: Axes, corner: Any, size: Any, name: str, colour: str) -> None:
    from matplotlib.patches import Rectangle

    ax.add_patch(Rectangle(corner, *size, facecolor=colour, edgecolor="black", linewidth=1.0))
    _name(ax, (corner[0] + 0.5 * size[0], corner[1] + 0.5 * size[1]), name)


def _name(ax: Axes, at: Any, text: str, colour: str = "black") -> None:
    ax.text(at[0], at[1], text, ha="center", va="center", fontsize=_TEXT, color=colour)


def _parameters(system: System) -> xr.Dataset:
    values = system.parameter_values
    return xr.Dataset(
        {"value": ("parameter", list(values.values()), {"long_name": "value of the parameter"})},
        {"parameter": list(values)},
        {"system": system.to_toml()},
    )


# Histories of the two-mass rig: Figs. 24 and 25.

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
    ax.set_xlabel(r"time, $\tau$")


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
        ("base acceleration", ("base",), "X_b''", "m/s$^2$"),
        ("relative acceleration", ("acceleration1", "acceleration2"), "X_1'', X_4''", "m/s$^2$"),
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
            ax.set_xlabel(
                r"time in steady motion, $\tau$" if column == 0 else "time in steady motion [s]"
            )
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
