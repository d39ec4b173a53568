"""Phase portraits of the beam at four crack ratios, by both stiffness laws: Fig. 28."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import xarray as xr

from nonsmooth import System, simulate
from nonsmooth.models import breathing_crack
from nonsmooth.plot import PALETTE, phase_portrait_3d, print_figure
from nonsmooth_chapter.fatigue.beam_data import ETA, WIDTH, XI
from nonsmooth_chapter.fatigue.crack_motions import period_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["LAWS", "RATIOS", "closed_arcs", "fig28", "portrait_beam", "settled_orbit"]

RATIOS = (0.32, 0.5, 0.7, 0.9)
LAWS: tuple[Literal["cubic", "guinea"], ...] = ("cubic", "guinea")
_DROPPED, _LOOKED = 2000, 64  # periods from rest, and strobes in which a period is sought
_MOST = 8  # periods of an orbit that are drawn
_SAMPLES = 1000  # per period
_ROWS: tuple[Literal["cubic", "guinea"], ...] = ("guinea", "cubic")
_TITLES = {"guinea": "open stiffness of Eq. (48)", "cubic": "cubic law of Fig. 29"}
_COLOURS = ("black", PALETTE["blue"], PALETTE["green"], PALETTE["vermilion"])
_TEXT = 8


def portrait_beam(
    ratio: float, law: Literal["cubic", "guinea"] = "cubic", **parameters: float
) -> System:
    """Beam with a crack ratio of Fig. 28 and the convention for what the chapter lacks.

    Parameters
    ----------
    ratio : float
        Length of the crack beside the width of the specimen.
    law : {"cubic", "guinea"}, optional
        Open stiffness over the length of the crack.
    **parameters : float
        Changed parameters.

    Returns
    -------
    System

    Examples
    --------
    >>> portrait_beam(0.5).parameter_values["crack"]
    10.0
    """
    system = breathing_crack(xi=XI, eta=ETA, crack=round(ratio * WIDTH, 9), law=law)
    return system.with_parameters(**parameters)


@lru_cache(maxsize=32)
def settled_orbit(system: System) -> xr.Dataset:
    """Orbit that the beam settles to from rest.

    Parameters
    ----------
    system : System
        The beam.

    Returns
    -------
    xarray.Dataset
        Run over one period of the motion, or over 8 of the forcing where it has none; attribute
        ``period_of_motion``.

    Examples
    --------
    >>> settled_orbit(portrait_beam(0.32)).attrs["period_of_motion"]
    1
    """
    run = simulate(system, periods=_DROPPED + _LOOKED, samples_per_period=1, events=False)
    points = np.stack([run["u"].values, run["v"].values], axis=1)
    period = period_of(points[-_LOOKED:], _LOOKED // 2)
    start = {"u": points[-1, 0], "v": points[-1, 1]}
    orbit = simulate(system, start, periods=period or _MOST, samples_per_period=_SAMPLES)
    orbit.attrs["period_of_motion"] = period
    return orbit


def closed_arcs(orbit: xr.Dataset) -> np.ndarray:
    """Points of an orbit in the phase plane while the crack is closed.

    Parameters
    ----------
    orbit : xarray.Dataset
        Run of the beam.

    Returns
    -------
    numpy.ndarray
        Deflection and velocity, one row for each sample.

    Examples
    --------
    >>> bool((closed_arcs(settled_orbit(portrait_beam(0.32)))[:, 0] <= 0.0).all())
    True
    """
    here = orbit["u"].values <= 0.0
    return np.stack([orbit["u"].values[here], orbit["v"].values[here]], axis=1)


def fig28() -> tuple[Figure, xr.Dataset]:
    """Fig. 28: orbits at crack ratios .32, .5, .7 and .9, stacked and in one plane.

    The chapter gives no data for them: xi .014, eta 1.1475, s = 1, d = 0, from rest. Above the open
    stiffness of Eq. (48), which belongs to section 3.5, below the cubic law of Fig. 29.

    Returns
    -------
    figure : matplotlib.figure.Figure
        A row for each law: in three dimensions, and in the plane.
    data : xarray.Dataset
        ``u`` and ``v`` over ``law``, ``ratio`` and ``sample``, nan behind the end of an orbit, and
        ``period``, 0 for none.

    Examples
    --------
    >>> figure, data = fig28()
    >>> data["period"].sel(law="cubic").values.tolist()
    [1, 1, 1, 1]
    """
    figure, axes = print_figure(2, 2, width=16.0, height=14.0)
    orbits = {
        law: {ratio: settled_orbit(portrait_beam(ratio, law)) for ratio in RATIOS} for law in LAWS
    }
    for row, law in enumerate(_ROWS):
        place = axes[2 * row].get_subplotspec()
        axes[2 * row].remove()
        deep = figure.add_subplot(place, projection="3d")
        phase_portrait_3d(orbits[law], "u", "v", label="crack ratio", ax=deep, periods=None)
        for line, colour in zip(deep.lines, _COLOURS, strict=False):  # the shadows stay grey
            line.set_color(colour)
        _small_texts(deep)
        deep.set_box_aspect((3.0, 4.0, 3.0), zoom=1.15)
        _plane(axes[2 * row + 1], orbits[law])
        for ax, letter in ((deep, "ac"[row]), (axes[2 * row + 1], "bd"[row])):
            ax.set_title(f"({letter}) {_TITLES[law]}", loc="left", fontsize=_TEXT)
    return figure, _data(orbits)


def _small_texts(ax: Any) -> None:
    """Texts of a panel of three dimensions in print size."""
    ax.tick_params(labelsize=6.5)
    ax.set_xlabel("$u$ [$A_b$]", fontsize=7, labelpad=-7)
    ax.set_ylabel("crack ratio", fontsize=7, labelpad=-3)
    ax.set_zlabel(r"$v$ [$A_b \omega_M$]", fontsize=7, labelpad=-7)


def _plane(ax: Axes, orbits: dict[float, xr.Dataset]) -> None:
    """Orbits of one law in one plane; the crack is open on the right."""
    for (ratio, orbit), colour in zip(orbits.items(), _COLOURS, strict=True):
        period = int(orbit.attrs["period_of_motion"])
        words = f"period {period}" if period else "no period"
        ax.plot(orbit["u"], orbit["v"], color=colour, linewidth=0.9, label=f"{ratio:g}, {words}")
    ax.axvline(0.0, color="0.7", linewidth=0.6, zorder=0)
    ax.legend(frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.22), ncols=2, fontsize=6.5,
              title="crack ratio and motion", title_fontsize=7)  # fmt: skip
    ax.set_xlabel("deflection $u$ [$A_b$], open where positive")
    ax.set_ylabel(r"velocity $v$ [$A_b \omega_M$]")


def _data(orbits: dict[Any, dict[float, xr.Dataset]]) -> xr.Dataset:
    longest = max(orbit.sizes["time"] for row in orbits.values() for orbit in row.values())
    shape = (len(LAWS), len(RATIOS), longest)
    values = {name: np.full(shape, np.nan) for name in ("u", "v")}
    periods = np.zeros(shape[:2], int)
    for i, law in enumerate(LAWS):
        for j, (ratio, orbit) in enumerate(orbits[law].items()):
            periods[i, j] = orbit.attrs["period_of_motion"]
            for name, array in values.items():
                array[i, j, : orbit.sizes["time"]] = orbits[law][ratio][name].values
    over = ("law", "ratio", "sample")
    labels = {"u": "deflection of the specimen [A_b]", "v": "velocity [A_b omega_M]"}
    return xr.Dataset(
        {name: (over, array, {"long_name": labels[name]}) for name, array in values.items()}
        | {"period": (over[:2], periods, {"long_name": "period of the motion, 0 for none"})},
        {"law": list(LAWS), "ratio": ("ratio", list(RATIOS), {"long_name": "crack ratio"})},
        {"xi": XI, "eta": ETA, "s": 1.0, "d": 0.0, "periods_dropped": _DROPPED + _LOOKED},
    )
