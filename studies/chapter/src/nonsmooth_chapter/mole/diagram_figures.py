"""Diagrams of the mole over the static force, and its progression along branches of orbits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr

from nonsmooth import bifurcation_diagram
from nonsmooth.models import moling
from nonsmooth.plot import PALETTE, place_legend, print_figure
from nonsmooth.plot import branch as draw_branch
from nonsmooth_chapter.mole.orbits import branches_of_panel, near_observed, observed
from nonsmooth_chapter.mole.sweeps import (
    AMPLITUDES,
    PROTOCOLS,
    Sweep,
    even_forces,
    first_fifty,
    main_window,
    settled_labels,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["PANELS", "Panel", "fig8", "fig10"]


# Diagrams of the mole over its static force: Fig. 8.
#
# The chapter prints neither the range of b nor how the columns begin. Here b goes up to a, above
# which the force never draws the mass off the ground, and every column begins at rest; where the
# column of a followed sweep ends in another motion, that one is drawn too.

_XI, _OMEGA = 0.05, 0.1
_TEXT = 8  # points, as in the rest of the figure
_SAME = 1e-4  # between strobes of one periodic motion that two protocols found
_MARKS = {  # colour, and on the right a shape too
    "restart": ("black", "."),
    "follow up": (PALETTE["blue"], "^"),
    "follow down": (PALETTE["vermilion"], "v"),
}


def fig8(columns: int = 400, transient: int = 400, record: int = 100) -> tuple[Figure, xr.Dataset]:
    """Fig. 8: velocity at strobes and progression in 50 periods, over b for three amplitudes.

    Parameters
    ----------
    columns : int, optional
        Columns of each diagram.
    transient, record : int, optional
        Periods left out and drawn.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Panels (a) to (c) left, (d) to (f) right; dashed lines are the ends of the widest periodic
        window.
    data : xarray.Dataset
        Over ``a``, ``start``, ``column`` and ``point``: ``b``, ``y``, ``period``, ``per_period``;
        ``first_50`` from rest.

    Examples
    --------
    >>> figure, data = fig8(columns=6, transient=50, record=20)
    >>> data["y"].dims, len(figure.axes)
    (('a', 'start', 'column', 'point'), 6)
    """
    figure, axes = print_figure(3, 2, width=16.0, height=17.0)
    kept = []
    for row, a in enumerate(AMPLITUDES):
        data = _diagrams(a, columns, transient, record)
        kept.append(data)
        velocity, progression = axes[2 * row : 2 * row + 2]
        _draw_velocity(data, velocity)
        _draw_progression(data, progression)
        for ax, letter in ((velocity, "abc"[row]), (progression, "def"[row])):
            ax.set_title(f"({letter}) a = {a:g}", loc="left", fontsize=_TEXT)
            ax.set_xlabel("static force, b" if row == len(AMPLITUDES) - 1 else "")
            ax.set_xlim(0.0, a)
            for b in data["window"].values:
                ax.axvline(b, color="0.45", linewidth=0.7, linestyle=(0, (4, 3)), zorder=0)
    _place_legend(figure)
    data = xr.concat(kept, xr.DataArray(list(AMPLITUDES), dims="a", name="a"))
    data.attrs = kept[0].attrs
    return figure, data


def _diagrams(a: float, columns: int, transient: int, record: int) -> xr.Dataset:
    """All that the two panels of one amplitude show."""
    forces = even_forces(a, columns)
    system = moling(a=a, xi=_XI, omega=_OMEGA)
    found = [
        bifurcation_diagram(
            system, "b", forces, start=start, transient=transient, record=record
        ).isel(lane=0)
        for start in PROTOCOLS
    ]
    over = ("start", "column")
    gain = [diagram["v_per_period"].values for diagram in found]
    periods = np.stack([diagram["period"].values for diagram in found])
    # near a period doubling a motion without a period need not be chaotic: exponents decide
    labels, exponents = settled_labels(found[0].expand_dims("lane"), a=a, xi=_XI, omega=_OMEGA)
    window = main_window(a, Sweep(np.array(forces), labels, gain[0], exponents))
    units = {"long_name": "progression in the first 50 periods from rest"}
    return xr.Dataset(
        {
            "b": ("column", list(forces), {"long_name": "static force"}),
            "y": (
                (*over, "point"),
                np.stack([diagram["y"].values for diagram in found]),
                {"long_name": "velocity of the mass at strobes"},
            ),
            "period": (over, periods, {"long_name": "period of the motion, 0: none found"}),
            "per_period": (over, np.stack(gain), {"long_name": "settled progression per period"}),
            "first_50": ("column", first_fifty(a, forces), units),
            "window": ("edge", [window["low"], window["high"]]),
            "status": (over, np.stack([diagram["status"].values for diagram in found])),
        },
        {"start": list(PROTOCOLS)},
        {
            "xi": _XI,
            "omega": _OMEGA,
            "transient": transient,
            "record": record,
            "nonsmooth_version": found[0].attrs["nonsmooth_version"],
        },
    )


def _elsewhere(data: xr.Dataset, start: str) -> np.ndarray:
    """Columns in which a followed sweep ends in another motion than from rest."""
    rest, other = data.sel(start="restart"), data.sel(start=start)
    periods = rest["period"].values, other["period"].values
    extremes = [
        np.stack([part["y"].min("point").values, part["y"].max("point").values])
        for part in (rest, other)
    ]
    apart = np.abs(extremes[0] - extremes[1]).max(axis=0) > _SAME
    periodic = (periods[0] > 0) | (periods[1] > 0)
    return periodic & apart


def _draw_velocity(data: xr.Dataset, ax: Axes) -> None:
    for start in PROTOCOLS:
        part = data.sel(start=start)
        if start != "restart":
            part = part.isel(column=_elsewhere(data, start))
        y = part["y"].values
        ax.plot(
            np.repeat(part["b"].values, y.shape[1]), y.ravel(), linestyle="none",
            marker=_MARKS[start][1], markersize=0.9 if start == "restart" else 2.0,
            markeredgewidth=0.0, color=_MARKS[start][0], rasterized=True,
        )  # fmt: skip
    ax.set_ylabel("velocity, y")


def _draw_progression(data: xr.Dataset, ax: Axes) -> None:
    ax.plot(data["b"], data["first_50"], linestyle="none", marker=".", markersize=2.5,
            markeredgewidth=0.0, color="black")  # fmt: skip
    for start in PROTOCOLS[1:]:
        part = data.sel(start=start).isel(column=_elsewhere(data, start))
        colour, shape = _MARKS[start]
        ax.plot(
            part["b"], 50.0 * part["per_period"], linestyle="none", marker=shape, markersize=3.0,
            markeredgewidth=0.0, color=colour,
        )  # fmt: skip
    ax.set_ylabel("progression in 50 periods")


def _place_legend(figure: Figure) -> None:
    from matplotlib.lines import Line2D

    names = ("each column from rest", "another motion as b rises", "another as b falls")
    handles = [
        Line2D([], [], linestyle="none", marker=shape, color=colour, markersize=4.0, label=name,
               markeredgewidth=0.0)
        for name, (colour, shape) in zip(names, _MARKS.values(), strict=True)
    ]  # fmt: skip
    handles.append(
        Line2D([], [], color="0.45", linewidth=0.7, linestyle=(0, (4, 3)),
               label="widest periodic window")
    )  # fmt: skip
    figure.legend(
        handles=handles, loc="outside upper center", ncols=4, frameon=False, fontsize=7,
        title=rf"$\xi = {_XI:g}$, $\omega = {_OMEGA:g}$", title_fontsize=7,
    )  # fmt: skip


# Progression per period over frequency, dynamic and static force: Fig. 10.
#
# The chapter prints neither the amplitudes of (a) and (c) nor the static forces of (b), nor how the
# motion was detected. Here the curves are branches of orbits, and the dots are motions from rest.

_LEFT, _KEPT = 300, 60  # periods of the motions from rest: left out, and kept
_XI_BEST_PROGRESSION, _OMEGA_BEST_PROGRESSION = 0.01, 0.1


class Panel(NamedTuple):
    """One panel: over what, and which parameter tells its curves apart."""

    letter: str
    over: str
    label: str
    between: tuple[float, float]
    curve: str
    values: tuple[float, ...]
    fixed: dict[str, float]
    lowest: float = 0.0  # progression shown; above zero the axis is logarithmic


PANELS = (
    Panel("a", "omega", r"frequency, $\omega$", (0.04, 0.25), "a", (0.3, 0.35, 0.4, 0.5),
          {"b": 0.15, "xi": _XI_BEST_PROGRESSION}, lowest=1.0),
    Panel("b", "a", "dynamic force, a", (0.1, 1.0), "b", (0.1, 0.15, 0.2, 0.3),
          {"omega": _OMEGA_BEST_PROGRESSION, "xi": _XI_BEST_PROGRESSION}),
    Panel("c", "b", "static force, b", (0.02, 0.8), "a", (0.3, 0.5, 0.7, 0.9),
          {"omega": _OMEGA_BEST_PROGRESSION, "xi": _XI_BEST_PROGRESSION}),
)  # fmt: skip


def fig10(columns: int = 60) -> tuple[Figure, xr.Dataset]:
    """Fig. 10: progression per period over (a) omega, (b) a and (c) b.

    Parameters
    ----------
    columns : int, optional
        Motions from rest for each curve.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Three panels: stable orbits solid, unstable ones dashed, constructions that are no motions
        dotted; dots are motions from rest, filled where they have the period of the forcing.
    data : xarray.Dataset
        For each panel ``x`` the curves ``x_curve`` by ``x_parameter`` and ``x_progression``, with
        ``x_stable`` and ``x_admissible``, over ``x_point``, and the motions ``x_simulated`` with
        their ``x_period`` over ``x_column``.

    Examples
    --------
    >>> figure, data = fig10(columns=4)
    >>> len(figure.axes), data["c_simulated"].dims
    (3, ('c_curve', 'c_column'))
    """
    figure, axes = print_figure(3, 1, width=12.0, height=21.0)
    kept: dict[str, Any] = {}
    for panel, ax in zip(PANELS, axes, strict=True):
        whole = branches_of_panel(panel.over, panel.between, panel.curve, panel.values)
        branches = [near_observed(branch) for branch in whole]
        motions = [_motions(panel, value, columns) for value in panel.values]
        _draw(panel, branches, motions, ax)
        kept |= _kept(panel, branches, motions)
    _explain_dots(figure)
    data = xr.Dataset(kept)
    data.attrs = {
        "xi": _XI_BEST_PROGRESSION,
        "transient": _LEFT,
        "record": _KEPT,
        "note": "the chapter prints neither the amplitudes of (a) and (c) nor the b of (b)",
        "nonsmooth_version": branches[0].attrs["nonsmooth_version"],
    }
    return figure, data


def _motions(panel: Panel, value: float, columns: int) -> xr.Dataset:
    """What motions from rest settle to."""
    system = moling(**{**panel.fixed, panel.curve: value})
    over = np.linspace(*panel.between, columns)
    found = bifurcation_diagram(system, panel.over, over, transient=_LEFT, record=_KEPT)
    return found.isel(lane=0)


def _draw(panel: Panel, branches: list[xr.Dataset], motions: list[xr.Dataset], ax: Axes) -> None:
    if panel.lowest:
        ax.set_yscale("log")
    names = [f"{panel.curve} = {value:g}" for value in panel.values]
    draw_branch(dict(zip(names, branches, strict=True)), "v_per_period", ax=ax, legend=False)
    colours = {line.get_gid(): line.get_color() for line in ax.lines if line.get_gid()}
    for k, found in enumerate(motions):
        colour = colours[f"branch {k}"]
        one = found["period"].values == 1
        for shown, filled in ((one, True), (~one, False)):
            ax.plot(
                found["parameter"].values[shown], found["v_per_period"].values[shown],
                linestyle="none", marker="o", markersize=2.6, color=colour, markeredgewidth=0.5,
                markerfacecolor=colour if filled else "none", zorder=2,
            )  # fmt: skip
    words = {"omega": r"$\omega$", "xi": r"$\xi$"}
    fixed = ", ".join(f"{words.get(key, key)} = {value:g}" for key, value in panel.fixed.items())
    ax.set_title(f"({panel.letter}) {fixed}", loc="left", fontsize=_TEXT)
    ax.set_xlabel(panel.label)
    ax.set_ylabel("progression per period")
    ax.set_xlim(*panel.between)
    ax.set_ylim(bottom=panel.lowest)
    place_legend(ax)


def _explain_dots(figure: Figure) -> None:
    from matplotlib.lines import Line2D

    names = {"motion from rest, period one": "0.3", "from rest, another period or none": "none"}
    handles = [
        Line2D([], [], linestyle="none", marker="o", color="0.3", markersize=4.0,
               markerfacecolor=face, label=name)
        for name, face in names.items()
    ]  # fmt: skip
    figure.legend(
        handles=handles, loc="outside upper center", ncols=2, frameon=False, fontsize=_TEXT
    )


def _kept(
    panel: Panel, branches: list[xr.Dataset], motions: list[xr.Dataset]
) -> dict[str, tuple[tuple[str, ...], np.ndarray, dict[str, str]]]:
    """Data of one panel, curves side by side."""
    width = max(branch.sizes["point"] for branch in branches)

    def rows(values: list[np.ndarray]) -> np.ndarray:
        table = np.full((len(values), width), np.nan)
        for row, each in zip(table, values, strict=True):
            row[: each.size] = each
        return table

    def over(name: str, dim: str, table: np.ndarray, text: str) -> None:
        kept[f"{panel.letter}_{name}"] = (
            (f"{panel.letter}_curve", f"{panel.letter}_{dim}"), table, {"long_name": text},
        )  # fmt: skip

    kept: dict[str, tuple[tuple[str, ...], np.ndarray, dict[str, str]]] = {}
    kept[f"{panel.letter}_curve"] = (
        (f"{panel.letter}_curve",), np.array(panel.values), {"long_name": panel.curve},
    )  # fmt: skip
    over("parameter", "point", rows([b[panel.over].values for b in branches]), panel.label)
    over("progression", "point", rows([b["v_per_period"].values for b in branches]),
         "progression per period of the orbit")  # fmt: skip
    over("stable", "point", rows([b["stable"].values.astype(float) for b in branches]),
         "1 where the orbit is stable")  # fmt: skip
    over("admissible", "point", rows([b["admissible"].values.astype(float) for b in branches]),
         "1 where the construction is a motion")  # fmt: skip
    over("observed", "point", rows([observed(b).astype(float) for b in branches]),
         "1 where both are true: solid")  # fmt: skip
    over("simulated", "column", np.stack([m["v_per_period"].values for m in motions]),
         "progression per period of the motion from rest")  # fmt: skip
    over("period", "column", np.stack([m["period"].values for m in motions]),
         "its period, 0: none found")  # fmt: skip
    kept[f"{panel.letter}_at"] = (
        (f"{panel.letter}_column",), motions[0]["parameter"].values, {"long_name": panel.label},
    )  # fmt: skip
    return kept
