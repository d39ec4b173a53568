"""Progression per period over frequency, dynamic and static force: Fig. 10.

The chapter prints neither the amplitudes of (a) and (c) nor the static forces of (b), nor how the
motion was detected. Here the curves are branches of orbits, and the dots are motions from rest.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr

from nonsmooth import bifurcation_diagram
from nonsmooth.models import moling
from nonsmooth.plot import branch as draw_branch
from nonsmooth.plot import place_legend, print_figure
from nonsmooth_chapter.mole.orbit_branches import branches_of_panel, near_observed, observed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["PANELS", "Panel", "fig10"]

_TEXT = 8  # points, as in the rest of the figure
_LEFT, _KEPT = 300, 60  # periods of the motions from rest: left out, and kept
_XI, _OMEGA = 0.01, 0.1


class Panel(NamedTuple):
    """One panel: over what, and which parameter tells its curves apart."""

    letter: str
    over: str
    label: str
    between: tuple[float, float]
    curve: str
    values: tuple[float, ...]
    fixed: dict[str, float]


PANELS = (
    Panel("a", "omega", r"frequency, $\omega$", (0.04, 0.25), "a", (0.3, 0.35, 0.4, 0.5),
          {"b": 0.15, "xi": _XI}),
    Panel("b", "a", "dynamic force, a", (0.1, 1.0), "b", (0.1, 0.15, 0.2, 0.3),
          {"omega": _OMEGA, "xi": _XI}),
    Panel("c", "b", "static force, b", (0.02, 0.8), "a", (0.3, 0.5, 0.7, 0.9),
          {"omega": _OMEGA, "xi": _XI}),
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
        "xi": _XI,
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
    ax.set_ylim(bottom=0.0)
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
