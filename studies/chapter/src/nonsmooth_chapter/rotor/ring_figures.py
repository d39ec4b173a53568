"""Figures of the ring: drawings, forces, and regions of operation."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from nonsmooth.models import snubber_boundaries, snubber_ring
from nonsmooth.plot import PALETTE, contact_regions, place_legend, print_figure
from nonsmooth_chapter.drawing import arrow, bare, damper, spring

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["fig31", "fig32", "fig33", "fig34", "fig35"]


# Drawings of the model: Figs. 31 and 32, and the forces of the ring, Fig. 33.

_TEXT = 8
_SIZE = 0.55  # radius of the drawn rotor; the ring's is larger by the gap, 1
_RING, _ROTOR, _FORCE = PALETTE["blue"], "black", PALETTE["vermilion"]
# Position of the rotor that is drawn, far out so that the ring is seen to give way.
_DRAWN = (1.1, 0.8)


def fig31() -> tuple[Figure, xr.Dataset]:
    """Fig. 31: the model, and its coordinates.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The physical model with its springs, and the vectors of rotor and ring.
    data : xarray.Dataset
        Rotor and ring as drawn in the right panel: result of `nonsmooth.models.snubber_ring`.

    Examples
    --------
    >>> figure, data = fig31()
    >>> round(float(np.hypot(data["x"] - data["sx"], data["y"] - data["sy"])), 12)
    1.0
    """
    figure, (model, coordinates) = print_figure(1, 2, width=16.0, height=8.5)
    _physical_model(model)
    # unequal preloads, so that ring and rotor are not on one line with the origin
    data = snubber_ring(*_DRAWN, K=1.0, delta_x=0.0, delta_y=0.8)
    _coordinates(coordinates, data)
    for ax, letter, title in ((model, "a", "model"), (coordinates, "b", "coordinates")):
        ax.set_title(f"({letter}) {title}", loc="left", fontsize=_TEXT)
    return figure, data


def fig32() -> tuple[Figure, xr.Dataset]:
    """Fig. 32: force of the ring against the normal of contact.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Ring and rotor in contact, the normal n and the force F_s with their angles.
    data : xarray.Dataset
        Result of `nonsmooth.models.snubber_ring` for the position drawn, in fast sliding, so
        that damping turns the force off the normal.

    Examples
    --------
    >>> figure, data = fig32()
    >>> float(data["normal_force"]) > 0.0
    True
    """
    figure, (ax,) = print_figure(width=8.0, height=7.5)
    data = snubber_ring(0.9, 0.9, -1.2, 1.2, K=1.0, nu2=0.2)
    ring = np.array([float(data["sx"]), float(data["sy"])])
    rotor = np.array([float(data["x"]), float(data["y"])])
    normal = rotor - ring
    force = np.array([float(data["force_x"]), float(data["force_y"])])
    force = 1.1 * force / np.hypot(*force)
    _circle(ax, ring, 1.0 + _SIZE, _RING)
    _circle(ax, rotor, _SIZE, _ROTOR)
    touch = ring + normal * (1.0 + _SIZE)
    ax.plot(*zip(ring, touch, strict=True), color="0.6", linewidth=0.6, linestyle="--")
    arrow(ax, touch, touch + 0.9 * normal, "black", r"$\mathbf{n}$")
    arrow(ax, touch, touch + force, _FORCE, r"$\mathbf{F}_s$")
    ax.plot([touch[0], touch[0] + 1.0], [touch[1]] * 2, color="0.6", linewidth=0.6)
    for vector, radius, name in ((normal, 0.45, r"$\psi$"), (force, 0.75, r"$\varphi$")):
        _angle(ax, touch, vector, radius, name)
    _point(ax, ring, r"$O_s$", _RING)
    _point(ax, rotor, r"$O_r$", _ROTOR)
    bare(ax, (-1.7, 2.6), (-1.6, 2.6))
    return figure, data


def fig33(delta: float = 0.1) -> tuple[Figure, xr.Dataset]:
    """Fig. 33: the four forces on the ring, and how they depend on its displacement.

    Parameters
    ----------
    delta : float, optional
        Preload along both axes.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The displaced ring with its forces, and each force over the displacement along its axis,
        without damping.
    data : xarray.Dataset
        ``F1`` to ``F4`` (components along their axis over k_s gamma), and ``resultant``, over
        ``s``: Eqs. (55)-(59).

    Examples
    --------
    >>> figure, data = fig33()
    >>> float(data["F3"].sel(s=0.0, method="nearest").round(3))
    -0.1
    """
    figure, (ring, law) = print_figure(1, 2, width=16.0, height=9.3)
    s = np.linspace(-2.5 * delta, 2.5 * delta, 501)
    behind = np.where(s > -delta, -(delta + s), 0.0)
    ahead = np.where(s < delta, delta - s, 0.0)
    over, unit = "s", {"long_name": "force over stiffness and gap"}
    data = xr.Dataset(
        {"F1": (over, behind, unit), "F2": (over, ahead, unit), "F3": (over, behind, unit),
         "F4": (over, ahead, unit), "resultant": (over, -(behind + ahead), unit)},
        {"s": (over, s, {"long_name": "displacement of the ring along the axis"})},
        {"delta": delta},
    )  # fmt: skip
    _forces_on_ring(ring)
    lines: list[tuple[np.ndarray, str, dict[str, Any]]] = [
        (behind, r"$F_1$ ($y$), $F_3$ ($x$)", {"color": PALETTE["blue"], "linestyle": "--"}),
        (ahead, r"$F_2$ ($y$), $F_4$ ($x$)", {"color": PALETTE["green"], "linestyle": "-."}),
        (-(behind + ahead), r"$F_s$ along the axis", {"color": "black", "linewidth": 1.4}),
    ]
    for values, label, how in lines:
        law.plot(s, values, label=label, **how)
    for side in (-delta, delta):
        law.axvline(side, color="0.6", linewidth=0.6, linestyle=":")
    law.set_xlabel(r"displacement, $x_s/\gamma$ or $y_s/\gamma$")
    law.set_ylabel(r"force, $F/(k_s\gamma)$")
    for ax, letter, words in ((ring, "a", "forces on the ring"), (law, "b", "laws")):
        ax.set_title(f"({letter}) {words}", loc="left", fontsize=_TEXT)
    place_legend(law)
    return figure, data


def _physical_model(ax: Axes) -> None:
    outer = 1.0 + _SIZE
    _circle(ax, (0.0, 0.0), outer, _RING)
    rotor = (0.35, 0.2)
    _circle(ax, rotor, _SIZE, _ROTOR, fill="0.9")
    _point(ax, rotor, "$M$", _ROTOR)
    mass = (rotor[0] + 0.33, rotor[1] + 0.25)
    ax.plot(*mass, "o", color=_FORCE, markersize=4.0)
    ax.plot(*zip(rotor, mass, strict=True), color=_FORCE, linewidth=0.8)
    ax.annotate(r"$m,\ \rho$", mass, (6, 9), textcoords="offset points", fontsize=_TEXT)
    for turn, preload in ((0, r"$\Delta_x$"), (1, r"$\Delta_y$"), (2, r"$\Delta_x$"),
                          (3, r"$\Delta_y$")):  # fmt: skip
        way = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)][turn], float)
        side = np.array([-way[1], way[0]])
        spring(ax, way * outer + 0.22 * side, way * 2.35 + 0.22 * side)
        damper(ax, way * outer - 0.22 * side, way * 2.35 - 0.22 * side)
        ends = np.stack([way * 2.35 - 0.5 * side, way * 2.35 + 0.5 * side])
        ax.plot(*ends.T, color="black", linewidth=1.6)
        at = way * 2.0 + (0.62 + 0.2 * (turn % 2)) * side
        ax.annotate(rf"$k_s,$ {preload}", tuple(at), ha="center", va="center", fontsize=_TEXT)
        at = way * 2.0 - 0.55 * side
        ax.annotate("$c_s$", tuple(at), ha="center", va="center", fontsize=_TEXT)
    ax.annotate(
        r"rods: $k_r,\ c_r$", (rotor[0] - 0.2, rotor[1] - 0.35), (-0.3, -0.95), ha="center",
        fontsize=_TEXT, arrowprops={"arrowstyle": "-", "linewidth": 0.5},
    )  # fmt: skip
    ax.annotate(r"gap $\gamma$", (-0.85, 0.35), ha="center", fontsize=_TEXT)
    bare(ax, (-2.7, 2.7), (-2.7, 2.7))


def _coordinates(ax: Axes, data: xr.Dataset) -> None:
    ring = np.array([float(data["sx"]), float(data["sy"])])
    rotor = np.array([float(data["x"]), float(data["y"])])
    origin, rest = np.zeros(2), np.array([0.45, -0.3])
    _circle(ax, origin, 1.0 + _SIZE, "0.7", dashed=True)
    _circle(ax, rest, _SIZE, "0.7", dashed=True)
    _circle(ax, ring, 1.0 + _SIZE, _RING)
    _circle(ax, rotor, _SIZE, _ROTOR)
    for way, name in (((2.3, 0.0), "$x$"), ((0.0, 2.3), "$y$")):
        arrow(ax, origin, np.array(way), "0.4", name, width=0.6)
    arrow(ax, origin, rotor, _ROTOR, "")
    arrow(ax, origin, ring, _RING, "")
    arrow(ax, origin, rest, PALETTE["green"], "")
    ax.annotate(
        r"$\mathbf{R}_r$", tuple(0.72 * rotor - (0.12, -0.16)), color=_ROTOR, fontsize=_TEXT
    )
    ax.annotate(r"$\mathbf{R}_s$", tuple(ring - (0.0, 0.28)), color=_RING, fontsize=_TEXT)
    ax.annotate(
        r"$\varepsilon$", tuple(0.5 * rest - (0.08, 0.24)), color=PALETTE["green"], fontsize=_TEXT
    )
    ends = np.stack([ring, rotor])
    ax.plot(*ends.T, color=_FORCE, linewidth=1.0, linestyle="--")
    ax.annotate(r"$D=\gamma$", tuple(0.4 * ring + 0.6 * rotor + (0.1, -0.17)), color=_FORCE,
                fontsize=_TEXT)  # fmt: skip
    _point(ax, origin, r"$O_{s,0}$", "0.4", (-22, -10))
    _point(ax, rest, r"$O_{r,0}$", "0.4", (4, -9))
    _point(ax, ring, "", _RING)
    _point(ax, rotor, r"$O_r$", _ROTOR)
    bare(ax, (-2.0, 2.6), (-2.0, 2.6))


def _forces_on_ring(ax: Axes) -> None:
    ring = np.array([0.35, 0.25])
    outer = 1.0 + _SIZE
    _circle(ax, (0.0, 0.0), outer, "0.7", dashed=True)
    _circle(ax, ring, outer, _RING)
    arrow(ax, (0.0, 0.0), 1.0 * ring, _RING, "")
    _point(ax, (0.0, 0.0), r"$O_{s,0}$", "0.4", (-22, -10))
    _point(ax, ring, r"$O_s$", _RING)
    longer, shorter = 1.0, 0.35  # the springs in front press more
    for name, way, length, offset in (
        ("1", (0, 1), longer, (5, -8)), ("2", (0, -1), shorter, (6, -6)),
        ("3", (1, 0), longer, (-8, 6)), ("4", (-1, 0), shorter, (-18, -3)),
    ):  # fmt: skip
        foot = ring + outer * np.array(way, float)
        tail = foot + length * np.array(way, float)
        arrow(ax, tail, foot, _FORCE, "")
        ax.annotate(rf"$\mathbf{{F}}_{name}$", tuple(tail), offset, textcoords="offset points",
                    fontsize=_TEXT, color=_FORCE)  # fmt: skip
    bare(ax, (-2.2, 3.3), (-2.2, 3.1))


def _circle(
    ax: Axes, centre: Any, radius: float, colour: str, *, dashed: bool = False, fill: str = "none"
) -> None:
    from matplotlib.patches import Circle

    ax.add_patch(
        Circle(
            tuple(centre), radius, edgecolor=colour, facecolor=fill,
            linewidth=0.8 if dashed else 1.2, linestyle="--" if dashed else "-",
        )
    )  # fmt: skip


def _angle(ax: Axes, centre: np.ndarray, vector: np.ndarray, radius: float, name: str) -> None:
    end = float(np.arctan2(vector[1], vector[0]))
    turn = np.linspace(0.0, end, 40)
    ax.plot(centre[0] + radius * np.cos(turn), centre[1] + radius * np.sin(turn), color="0.4",
            linewidth=0.6)  # fmt: skip
    ax.annotate(
        name, (centre[0] + radius * np.cos(end / 3), centre[1] + radius * np.sin(end / 3)), (2, 1),
        textcoords="offset points", fontsize=_TEXT,
    )  # fmt: skip


def _point(
    ax: Axes, at: Any, name: str, colour: str, offset: tuple[float, float] = (3, -9)
) -> None:
    ax.plot(*at, "o", color=colour, markersize=3.0)
    ax.annotate(name, tuple(at), offset, textcoords="offset points", color=colour, fontsize=_TEXT)


# Regions of operation over the position of the rotor, and their boundaries: Figs. 34 and 35.

# The chapter prints no preload; one that is large enough to see all regions.
_DELTA = 0.3
_SMALL = 7
_CONDITIONS = {
    "I": r"$D<\gamma$",
    "II": "$|x_s|\\leq\\Delta_x$, $|y_s|\\leq\\Delta_y$",
    "III": "$|x_s|>\\Delta_x$\n$|y_s|\\leq\\Delta_y$",
    "IV": "$|x_s|\\leq\\Delta_x$, $|y_s|>\\Delta_y$",  # low region: in one line
    "V": "$|x_s|>\\Delta_x$\n$|y_s|>\\Delta_y$",
}

_WITHIN = (-1.09, 0.0)  # the narrow second region, where there is no name


def fig34(delta: float = _DELTA) -> tuple[Figure, xr.Dataset]:
    """Fig. 34: regions I to V for the whole plane.

    Parameters
    ----------
    delta : float, optional
        Preload along both axes.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The regions with their names, and the conditions for them in the first quadrant.
    data : xarray.Dataset
        Result of `nonsmooth.models.snubber_boundaries`.

    Examples
    --------
    >>> figure, data = fig34()
    >>> data.attrs["delta_x"]
    0.3
    """
    figure, data = _regions(delta, "plane", 11.0, equations=False)
    _conditions(figure.axes[0])
    return figure, data


def fig35(delta: float = _DELTA) -> tuple[Figure, xr.Dataset]:
    """Fig. 35: the first quadrant with the boundaries by Eqs. (62)-(66).

    Parameters
    ----------
    delta : float, optional
        Preload along both axes.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The regions and the numbers of their boundaries.
    data : xarray.Dataset
        Result of `nonsmooth.models.snubber_boundaries`.

    Examples
    --------
    >>> figure, data = fig35()
    >>> sorted(set(data["equation"].values.tolist()))
    [62, 63, 64, 65, 66]
    """
    return _regions(delta, "quadrant", 9.0, equations=True)


def _conditions(ax: Axes) -> None:
    """What holds in each region, under its name in the first quadrant, as the chapter has it."""
    named = {text.get_text(): text for text in ax.texts if min(text.get_position()) >= 0.0}
    for name, told in _CONDITIONS.items():
        if name in named and name != "II":
            ax.annotate(told, named[name].get_position(), (0, -7), textcoords="offset points",
                        ha="center", va="top", fontsize=_SMALL)  # fmt: skip
    ax.text(*_WITHIN, _CONDITIONS["II"], rotation=90, ha="center", va="center", fontsize=_SMALL)


def _regions(
    delta: float, view: str, width: float, *, equations: bool
) -> tuple[Figure, xr.Dataset]:
    data = snubber_boundaries(delta_x=delta, delta_y=delta)
    figure, (ax,) = print_figure(width=width, height=width)
    contact_regions(data, ax=ax, view=view, equations=equations)
    ax.set_xlabel(r"displacement of the rotor, $x_r/\gamma$")
    ax.set_ylabel(r"displacement of the rotor, $y_r/\gamma$")
    return figure, data
