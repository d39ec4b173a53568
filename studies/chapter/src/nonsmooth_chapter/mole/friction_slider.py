"""The simplest progressive system, a mass on a dry-friction slider: Fig. 2(a)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import xarray as xr
from matplotlib.patches import Rectangle

from nonsmooth import simulate
from nonsmooth.models import percussive_drilling
from nonsmooth.plot import PALETTE, phases, print_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["fig2a"]

_TEXT = 8
_PERIODS = 4
_NAMES = {"x": "mass, x", "v": "slider, v"}


def fig2a(a: float = 0.3, b: float = 0.15, omega: float = 0.1) -> tuple[Figure, xr.Dataset]:
    """Fig. 2(a): the model, and its motion from rest.

    Parameters
    ----------
    a, b : float, optional
        Amplitude of the harmonic force and static force over the friction limit; the chapter
        prints none for this model, these are the mole's of Fig. 7(d).
    omega : float, optional
        Frequency, which only sets the scales.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The physical model, and displacements of mass and slider over time with the phases of the
        motion below.
    data : xarray.Dataset
        The run from rest, with its event log.

    Examples
    --------
    >>> figure, data = fig2a()
    >>> data.attrs["phase_word"]
    'flight progression stick flight'
    """
    run = simulate(percussive_drilling(a=a, b=b, omega=omega), periods=_PERIODS)
    figure, (model, history) = print_figure(1, 2, width=16.0, height=7.5)
    _model(model)
    phases(run, ["x", "v"], ax=history, labels=_NAMES)
    history.set_xlabel(r"time, $\tau$")
    history.set_ylabel("displacement over $P_f/(m\\Omega_0^2)$")
    history.legend(loc="upper left", fontsize=_TEXT, framealpha=0.9)
    model.set_title("(a) model", loc="left", fontsize=_TEXT)
    history.set_title("(b) motion from rest", loc="left", fontsize=_TEXT)
    run.attrs["note"] = f"a = {a:g}, b = {b:g}, omega = {omega:g}; the chapter prints none"
    return figure, run


def _model(ax: Axes) -> None:
    """Mass under its force, above a slider that two walls hold by dry friction."""
    grey, force = "0.85", PALETTE["vermilion"]
    ax.add_patch(Rectangle((-0.8, 1.2), 1.6, 1.0, facecolor=grey, edgecolor="black"))
    ax.text(0.0, 1.7, "m", ha="center", va="center", fontsize=_TEXT + 2)
    ax.add_patch(Rectangle((-0.45, -0.75), 0.9, 1.5, facecolor="white", edgecolor="black"))
    ax.plot([-0.8, 0.8], [0.75, 0.75], color="black", linewidth=2.5)
    for side in (-1, 1):
        ax.add_patch(
            Rectangle((side * 0.75 - 0.3, -1.1), 0.6, 1.4, facecolor="none", hatch="////",
                      edgecolor="0.6", linewidth=0.0)
        )  # fmt: skip
        ax.plot([0.45 * side, 0.45 * side], [-1.1, 0.3], color="black", linewidth=1.5)
    _arrow(ax, (0.0, 3.2), (0.0, 2.25), force)
    ax.text(0.15, 2.85, r"$P_s + P_d\cos(\Omega t)$", fontsize=_TEXT, color=force)
    _arrow(ax, (1.35, 2.2), (1.35, 1.3), "black")
    ax.text(1.45, 1.7, "x", fontsize=_TEXT)
    _arrow(ax, (1.35, 0.75), (1.35, -0.15), "black")
    ax.text(1.45, 0.25, "v", fontsize=_TEXT)
    ax.annotate(
        "$P_f$, dry friction", (-0.45, -0.4), (-2.1, -1.55), fontsize=_TEXT,
        arrowprops={"arrowstyle": "-", "linewidth": 0.7},
    )  # fmt: skip
    ax.set_xlim(-2.2, 2.4)
    ax.set_ylim(-1.8, 3.4)
    ax.set_aspect("equal")
    ax.axis("off")


def _arrow(ax: Axes, tail: tuple[float, float], head: tuple[float, float], colour: str) -> None:
    ax.annotate("", head, tail, arrowprops={"arrowstyle": "-|>", "color": colour})
