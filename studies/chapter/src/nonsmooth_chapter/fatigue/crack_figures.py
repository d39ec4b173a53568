"""Figures of the cracked beam: stiffness, phase portraits, growth with sections."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import xarray as xr

from nonsmooth import System, ensemble, simulate
from nonsmooth.fatigue import Specimen, cubic_stiffness
from nonsmooth.models import breathing_crack
from nonsmooth.plot import PALETTE, growth_curve, phase_portrait_3d, print_figure, transient_section
from nonsmooth_chapter.fatigue.crack_motions import (
    DROPPED,
    ETA,
    GROWTH,
    TAU_END,
    WIDTH,
    XI,
    beam,
    crack_at,
    period_of,
    tau_at,
)
from nonsmooth_chapter.fatigue.growing_crack import growing_run, strobe_labels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "CRACKS",
    "LAWS",
    "RATIOS",
    "WINDOWS",
    "closed_arcs",
    "fig27",
    "fig28",
    "fig29",
    "fig30",
    "portrait_beam",
    "settled_orbit",
]


# Restoring force of a specimen whose crack opens and closes: Fig. 27.

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


# Phase portraits of the beam at four crack ratios, by both stiffness laws: Fig. 28.

RATIOS = (0.32, 0.5, 0.7, 0.9)
LAWS: tuple[Literal["cubic", "guinea"], ...] = ("cubic", "guinea")
_DROPPED, _LOOKED = 2000, 64  # periods from rest, and strobes in which a period is sought
_MOST = 8  # periods of an orbit that are drawn
_SAMPLES = 1000  # per period
_ROWS: tuple[Literal["cubic", "guinea"], ...] = ("guinea", "cubic")
_TITLES = {"guinea": "open stiffness of Eq. (48)", "cubic": "cubic law of Fig. 29"}
_COLOURS_PORTRAITS = ("black", PALETTE["blue"], PALETTE["green"], PALETTE["vermilion"])


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
        for line, colour in zip(
            deep.lines, _COLOURS_PORTRAITS, strict=False
        ):  # the shadows stay grey
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
    for (ratio, orbit), colour in zip(orbits.items(), _COLOURS_PORTRAITS, strict=True):
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


# Sections along the growth of the crack: Figs. 29 and 30.

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
        inset.set_title(f"{crack:g} mm: {words}\nchapter: {_CHAPTER[crack]}", fontsize=6.5, pad=3.5)
    # once, as all boxes show the same ranges: below each it would lie on the lines to the curve
    (left, right), (low, high) = insets[0].get_xlim(), insets[0].get_ylim()
    spans = f"in each box: u from {left:.2f} to {right:.2f}, v from {low:.2f} to {high:.2f}"
    ax.text(0.07, 0.115, spans.replace("-", "\N{MINUS SIGN}"), transform=ax.transAxes, fontsize=7)
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
