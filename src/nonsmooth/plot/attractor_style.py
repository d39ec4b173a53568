"""How attractors look: one hue each, pale for the basin and dark for the points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.plot.crowding import uncrowded
from nonsmooth.plot.period_colours import LONGER, OTHER_REGIMES, colour_of_motion
from nonsmooth.plot.style import PALETTE, axis_label, mixed
from nonsmooth.runs.labels import labels_of
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

__all__ = [
    "ENDED_EARLY",
    "INADMISSIBLE",
    "NOT_COMPUTED",
    "UNSETTLED",
    "AttractorStyle",
    "attractor_entry",
    "attractor_points",
    "attractor_styles",
    "check_states",
    "draw_attractors",
    "percent",
    "state_label",
    "styles_by_period",
]

UNSETTLED, ENDED_EARLY, INADMISSIBLE, NOT_COMPUTED = "#FFFFFF", "#5A5A5A", "#D4D4D4", "#A8A8A8"

# Twentieths of white in a basin and of black in its points, for the first seven attractors, the
# next seven, ...; further ones begin anew.
_SHADES = ((11, 8), (5, 13), (15, 2))
_SHAPES = "osD^v<>pPX"  # of the first periods; longer ones are stars
_DARK = (LONGER, OTHER_REGIMES["chaotic"])  # basins on which black points would be lost
_STARS = 5  # with three points and more

Marker = Any  # a letter, or a tuple for a star
_SAME = 1e-9  # of the largest spread, within which a state is constant
_MARK, _LEAST = 4.0, 2.6  # diameters of marks in points; where they are crowded
_DENSE = 20_000  # points that are drawn as curves in a PDF


class AttractorStyle(NamedTuple):
    """Colours and marker of one attractor, and what a legend says of it."""

    basin: str
    points: str
    marker: Marker
    size: float
    text: str
    hue: str  # between both colours


def attractor_styles(data: xr.Dataset, numbers: Sequence[int]) -> dict[int, AttractorStyle]:
    """Styles by number; the marker tells the period, dots are motion without one."""
    hues = list(PALETTE.values())
    styles = {}
    for number in numbers:
        round_, hue = divmod(number - 1, len(hues))
        white, black = _SHADES[round_ % len(_SHADES)]
        period = _one(data, "period", number)
        periodic = period is not None and int(period) > 0
        shape = _shape(int(period)) if periodic else "."
        styles[number] = AttractorStyle(
            mixed(hues[hue], 255, white),
            mixed(hues[hue], 0, black),
            shape,
            _MARK if periodic else 1.6,
            _text(data, number, int(period) if periodic else None),
            hues[hue],
        )
    return styles


def styles_by_period(
    data: xr.Dataset, styles: Mapping[int, AttractorStyle]
) -> dict[int, AttractorStyle]:
    """The same with basins in the colours of periods and kinds, and points black or white."""
    found = {}
    for number, style in styles.items():
        period, kind = _one(data, "period", number), _one(data, "kind", number)
        shade = colour_of_motion(0 if period is None else int(period), str(kind or ""))
        points = "#FFFFFF" if shade in _DARK else "#000000"
        found[number] = style._replace(basin=shade, points=points)
    return found


def _shape(period: int) -> Marker:
    return _SHAPES[period - 1] if period <= len(_SHAPES) else (3 + period % _STARS, 1, 0)


def attractor_points(data: xr.Dataset, number: int, x: str, y: str) -> tuple[Any, Any]:
    """Points of an attractor in two states; none where a coordinate is missing."""
    if "points" not in data or "attractor" not in data.coords:
        return np.empty(0), np.empty(0)
    known = data["state"].values.tolist()
    if number not in data["attractor"].values or x not in known or y not in known:
        return np.empty(0), np.empty(0)
    chosen = data["points"].sel(attractor=number)
    across, up = chosen.sel(state=x).values, chosen.sel(state=y).values
    there = np.isfinite(across) & np.isfinite(up)
    return across[there], up[there]


def draw_attractors(
    ax: Axes, points: Mapping[int, tuple[Any, Any]], styles: Mapping[int, AttractorStyle]
) -> None:
    """Draw the points of attractors so that they stand out before any basin.

    Marks are as large as they can be without lying on each other.
    """
    lines = {k: _draw_points(ax, *points[k], style) for k, style in styles.items()}
    ax.autoscale_view()
    marked = [k for k, style in styles.items() if style.marker != "."]
    if marked:
        across, up = (np.concatenate([points[k][axis] for k in marked]) for axis in (0, 1))
        size = uncrowded(ax, across, up, _MARK, _LEAST)
        for k in marked:
            lines[k].set_markersize(size)


def _draw_points(ax: Axes, across: Any, up: Any, style: AttractorStyle) -> Line2D:
    dots = style.marker == "."
    (line,) = ax.plot(
        across,
        up,
        linestyle="none",
        marker="o" if dots else style.marker,
        markersize=min(style.size, 1.0) if dots and len(across) > 2_000 else style.size,
        markerfacecolor=style.points,
        markeredgecolor=style.points if dots else "white",
        markeredgewidth=0.0 if dots else 0.5,
        rasterized=len(across) > _DENSE,
        zorder=3,
        label=style.text,
    )
    return line


def state_label(data: xr.Dataset, name: str) -> str:
    """Label of a state: from the coordinate of that name, or of all states, or from the system."""
    if name in data.coords and {"long_name", "units"} & set(data[name].attrs):
        return axis_label(data[name])
    import xarray as xr

    words = {
        key: str(data[f"state_{key}"].sel(state=name).values)
        for key in ("long_name", "units")
        if f"state_{key}" in data.coords and name in data["state"].values
    }
    if words:
        return axis_label(xr.DataArray(0.0, name=name, attrs=words))
    if "system" in data.attrs:
        system = System.from_toml(data.attrs["system"])
        if name in system.states:
            texts = labels_of(system).attributes(name)
            return axis_label(xr.DataArray(0.0, name=name, attrs=texts))
    return name


def check_states(data: xr.Dataset, x: str | None, y: str | None) -> tuple[str, str]:
    """Two states to draw: those named, else the first two with points that do not drift.

    A state that is the same in all points, such as that of a section, comes last.
    """
    if "points" not in data or "attractor" not in data.dims or "state" not in data.coords:
        raise OptionError(
            "the dataset has no points of attractors; give a result of attractors or of"
            " basins_of_attraction"
        )
    known = [str(name) for name in data["state"].values]
    drift = System.from_toml(data.attrs["system"]).drift_states if "system" in data.attrs else ()
    there = [n for n in known if np.isfinite(data["points"].sel(state=n)).any() and n not in drift]
    finite = sorted(there or known, key=lambda name: _is_constant(data["points"], name))
    chosen = [finite[0] if x is None else x, finite[min(1, len(finite) - 1)] if y is None else y]
    for name in chosen:
        if name not in known:
            raise OptionError(unknown_name("state", name, known))
    return chosen[0], chosen[1]


def _is_constant(points: xr.DataArray, state: str) -> bool:
    """Whether a state differs by rounding only, beside the one that differs most."""
    spread = {
        str(name): float(np.ptp(values[np.isfinite(values)])) if np.isfinite(values).any() else 0.0
        for name in points["state"].values
        for values in (points.sel(state=name).values,)
    }
    return spread[state] <= _SAME * max(spread.values())


def _text(data: xr.Dataset, number: int, period: int | None) -> str:
    kind = _one(data, "kind", number)
    what = f"period {period}" if period else str(kind or "")
    share = _one(data, "fraction", number)
    size = "" if share is None or not np.isfinite(share) else percent(float(share))
    text = ", ".join(part for part in (what, size) if part)
    return f"{number}: {text}" if text else f"{number}"


def percent(share: float) -> str:
    """Share in percent, with one digit more where it is small."""
    return f"{100.0 * share:.{1 if share >= 0.0095 else 2}f} %"


def _one(data: xr.Dataset, name: str, number: int) -> Any:
    """Value of a variable for one attractor; None where there is no such thing."""
    if name not in data or "attractor" not in data.coords:
        return None
    if data[name].dims != ("attractor",) or number not in data["attractor"].values:
        return None
    return data[name].sel(attractor=number).item()


def attractor_entry(style: AttractorStyle, *, basin: bool) -> Artist:
    """Marker of an attractor, before the colour of its basin where that is shown."""
    from matplotlib.lines import Line2D

    dots = style.marker == "."
    return Line2D(
        [],
        [],
        linestyle="-" if basin else "none",
        linewidth=6.0,
        solid_capstyle="butt",
        color=style.basin,
        marker="o" if dots else style.marker,
        markersize=2.6 if dots else style.size,
        markerfacecolor=style.points,
        markeredgecolor=style.points if dots else "white",
        markeredgewidth=0.0 if dots else 0.5,
        label=style.text,
    )
