"""Diagrams of rotor and rig over the speed, and sections of motions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from nonsmooth import stroboscopic_map
from nonsmooth.plot import PALETTE, branch, place_legend, print_figure
from nonsmooth_chapter.rotor.motions import (
    DELTA_40,
    DELTA_41,
    EPS_40,
    EPS_41,
    STARTS,
    coexisting,
    rig,
    set_a,
)
from nonsmooth_chapter.rotor.speed_sweeps import (
    Sweep,
    branches_at_strobes,
    branches_of_set_a,
    even_values,
    speed_sweeps,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    from nonsmooth.models import RotorRig

__all__ = ["PANELS", "PRINTED_36", "SHOWN", "fig36", "fig37", "fig40", "fig41"]


# Diagrams of the rotor over its speed: Figs. 36, 40(a) and 41(a).
#
# Section 4.3 lets every column begin at zero; section 4.4 lets it begin where the column before has
# ended. Each figure shows both, one beside the other; speeds are raised.

SHOWN = ("restart", "follow up")
# Speeds that the text gives for the dash lines of Fig. 36, by preload.
PRINTED_36 = {0.0: ("2.165", "2.717", "3.803"), 0.1: ("2.213", "2.824", "3.893")}
_TITLES = {"restart": "each column from zero", "follow up": "followed up"}
_TEXT = 8  # points, as in the rest of the figure
_LONGEST = 32  # period that a section is told by
_DOTS: dict[str, Any] = {
    "linestyle": "none",
    "marker": "o",
    "markeredgewidth": 0.0,
    "rasterized": True,
}


def fig36(
    columns: int = 600, transient: int = 300, record: int = 150, longest: int = 3
) -> tuple[Figure, xr.Dataset]:
    """Fig. 36: displacement at strobes over eta from 2 to 5, without and with preload.

    Parameters
    ----------
    columns : int, optional
        Columns of each diagram.
    transient, record : int, optional
        Periods left out and drawn.
    longest : int, optional
        Longest period of the branches, 1 to 3.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Panels (a) and (b), on the left with columns from zero, on the right followed; dashed lines
        are the bifurcations that the text gives. Over the dots, branches of the orbits of period
        one, two and three, stable or not, as far as they were followed.
    data : xarray.Dataset
        Over ``delta``, ``start``, ``column`` and ``point``: ``eta``, ``x``, ``period``; over
        ``delta`` and ``orbit``, in order along the lines: ``orbit_eta``, ``orbit_x``,
        ``orbit_period`` and ``orbit_stable`` (1, 0).

    Examples
    --------
    >>> figure, data = fig36(columns=2, transient=20, record=10, longest=1)
    >>> data["x"].dims, len(figure.axes)
    (('delta', 'start', 'column', 'point'), 4)
    """
    etas = even_values(2.0, 5.0, columns)
    figure, axes = print_figure(2, 2, width=16.0, height=15.0)
    kept = []
    for row, (delta, printed) in enumerate(PRINTED_36.items()):
        sweeps = speed_sweeps(set_a(delta), etas, SHOWN, transient=transient, record=record)
        lines = {
            f"period {period}": branches_at_strobes(set_a(delta), branches)
            for period, branches in branches_of_set_a(delta, longest).items()
        }
        kept.append(_dataset(sweeps).merge(_orbits(lines)))
        for ax, sweep in zip(axes[2 * row : 2 * row + 2], sweeps, strict=True):
            for text in printed:
                ax.axvline(float(text), **_MARKED)
            _draw(ax, sweep.eta, sweep.data["x"].values, "0.55")
            branch(lines, "x", ax=ax, legend=False)
            _shrink_marks(ax)
            ax.set_title(
                rf"({'ab'[row]}) $\Delta_x = \Delta_y = {delta:g}$, {_TITLES[sweep.start]}",
                loc="left", fontsize=_TEXT,
            )  # fmt: skip
            ax.set_xlim(etas[0], etas[-1])
        _same_heights(axes[2 * row : 2 * row + 2])
    _label(axes, r"frequency ratio, $\eta$", r"displacement, $x_r/\gamma$")
    axes[0].add_line(_printed_line("bifurcation as printed", _MARKED))
    place_legend(figure)
    data = xr.concat(kept, xr.DataArray(list(PRINTED_36), dims="delta", name="delta"), join="outer")
    data.attrs = {"transient": transient, "record": record, **_version(sweeps)}
    return figure, data


def fig40(
    columns: int = 215,
    transient: int = 400,
    record: int = 100,
    points: int = 6000,
    starts: int = STARTS,
) -> tuple[Figure, xr.Dataset]:
    """Fig. 40(a): diagram over 7-50 Hz and sections at 30.1 and 37.1 Hz.

    Parameters
    ----------
    columns : int, optional
        Columns of each diagram.
    transient, record : int, optional
        Periods left out and drawn.
    points : int, optional
        Points of each section.
    starts : int, optional
        Random starts from which other motions are sought for each section.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Diagrams by two protocols above, sections below.
    data : xarray.Dataset
        ``x`` over ``start``, ``column`` and ``point``, ``section_x`` and ``section_vx`` over
        ``speed`` and ``strobe``, in mm and mm/s.

    Examples
    --------
    >>> figure, data = fig40(columns=4, transient=50, record=20, points=50, starts=2)
    >>> data["x"].attrs["units"], len(figure.axes)
    ('mm', 4)
    """
    machine = rig(EPS_40, DELTA_40)
    # with the columns of the claims on this diagram, which are computed before
    return _rig_figure(
        machine, (7.0, 50.0), (30.1, 37.1), columns, transient, record, points, starts
    )


def fig41(
    columns: int = 230,
    transient: int = 400,
    record: int = 100,
    points: int = 6000,
    starts: int = STARTS,
) -> tuple[Figure, xr.Dataset]:
    """Fig. 41(a): diagram over 7-30 Hz and sections at 17.6 and 25 Hz.

    Parameters
    ----------
    columns : int, optional
        Columns of each diagram.
    transient, record : int, optional
        Periods left out and drawn.
    points : int, optional
        Points of each section.
    starts : int, optional
        Random starts from which other motions are sought for each section.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Diagrams by two protocols above, sections below.
    data : xarray.Dataset
        As from `fig40`.

    Examples
    --------
    >>> figure, data = fig41(columns=4, transient=50, record=20, points=50, starts=2)
    >>> data["section_vx"].attrs["units"], len(figure.axes)
    ('mm/s', 4)
    """
    machine = rig(EPS_41, DELTA_41)
    return _rig_figure(
        machine, (7.0, 30.0), (17.6, 25.0), columns, transient, record, points, starts
    )


def _rig_figure(
    machine: RotorRig,
    span: tuple[float, float],
    speeds: Sequence[float],
    columns: int,
    transient: int,
    record: int,
    points: int,
    starts: int,
) -> tuple[Figure, xr.Dataset]:
    hertz = machine.natural_frequency
    etas = even_values(span[0] / hertz, span[1] / hertz, columns)
    sweeps = speed_sweeps(machine.system(), etas, SHOWN, transient=transient, record=record)
    figure, axes = print_figure(2, 2, width=16.0, height=13.0)
    data = _dataset(sweeps)
    data["x"] = (data["x"].dims, machine.gap * data["x"].values, _millimetres("x"))
    data = data.drop_vars("eta").assign(
        speed_of_column=("column", hertz * sweeps[0].eta, {"long_name": "speed", "units": "Hz"})
    )
    for ax, sweep in zip(axes, sweeps, strict=False):
        for speed in speeds:
            ax.axvline(speed, **_PRINTED)
        _draw(ax, hertz * sweep.eta, machine.gap * sweep.data["x"].values)
        ax.set_title(_TITLES[sweep.start], loc="left", fontsize=_TEXT)
        ax.set_xlim(*span)
    _same_heights(axes[:2])
    _label(axes[:2], "speed [Hz]", "displacement in x [mm]")
    figure.legend(
        handles=[_printed_line("speeds of the sections")],
        loc="outside upper center", frameon=False, fontsize=_TEXT,
    )  # fmt: skip
    sections = [_section(machine, speed, sweeps, points, starts) for speed in speeds]
    for ax, speed, motions in zip(axes[2:], speeds, sections, strict=True):
        _draw_section(ax, motions)
        name = _name_of_motion(motions["followed up"], machine.gap)
        ax.set_title(f"section at {speed:g} Hz: {name}", loc="left", fontsize=_TEXT)
        place_legend(ax)
    _label(axes[2:], "displacement in x [mm]", "velocity in x [mm/s]")
    for axis, name in (("x", "section_x"), ("vx", "section_vx")):
        values = np.stack([motions["followed up"][axis].values for motions in sections])
        data[name] = (("speed", "strobe"), values, sections[0]["followed up"][axis].attrs)
    data = data.assign_coords(speed=("speed", list(speeds), {"units": "Hz"}))
    data.attrs = {
        "transient": transient, "record": record, "eccentricity_x_mm": machine.eccentricity_x,
        "eccentricity_y_mm": machine.eccentricity_y, "preload_mm": machine.preload_x,
        **_version(sweeps),
    }  # fmt: skip
    return figure, data


def _name_of_motion(found: xr.Dataset, gap: float) -> str:
    """Period of strobes that repeat to a millionth of the gap; else that there is none."""
    x = found["x"].values
    for period in range(1, _LONGEST + 1):
        if np.abs(x[period:] - x[:-period]).max() < 1e-6 * gap:
            return f"period {period}"
    return "no period"


def _section(
    machine: RotorRig, speed: float, sweeps: tuple[Sweep, ...], points: int, starts: int
) -> dict[str, xr.Dataset]:
    """Strobes at a speed: of the motion followed to it, and of others that random starts find."""
    followed = sweeps[-1]
    eta = speed / machine.natural_frequency
    column = int(np.abs(followed.eta - eta).argmin())
    system = machine.system().with_parameters(eta=eta)
    last = followed.data.isel(parameter=column, point=-1)
    start = {name: float(last[name]) for name in system.states}
    found = {"followed up": stroboscopic_map(system, start, transient=400, record=points)}
    place = np.array([found["followed up"][name].values for name in ("x", "vx")])
    for row in coexisting(system, starts):
        near = np.abs(place.T - np.array([row["point"][0], row["point"][2]])).max(axis=1).min()
        if near < (_NEAR_CYCLE if row["period"] else _NEAR_SET):
            continue
        name = f"also period {row['period']}" if row["period"] else "also without period"
        found[name] = stroboscopic_map(system, row["state"], transient=0, record=points)
    return {name: machine.to_si(each) for name, each in found.items()}


def _draw_section(ax: Axes, found: dict[str, xr.Dataset]) -> None:
    styles = (("black", "o"), (PALETTE["vermilion"], "^"), (PALETTE["blue"], "s"))
    for (name, points), (colour, shape) in zip(found.items(), styles, strict=False):
        x, v = points["x"].values, points["vx"].values
        few = np.unique(x.round(6)).size < _FEW
        # one dot for each point of a cycle
        x, v = (np.unique(np.stack([x, v]).round(6), axis=1)) if few else (x, v)
        how = _DOTS | {"marker": shape, "markersize": 4.0 if few else 0.7}
        ax.plot(x, v, color=colour, label=name, **how)
    for low, high, place in ((*ax.get_xlim(), ax.set_xlim), (*ax.get_ylim(), ax.set_ylim)):
        if high - low < _LEAST_SPAN:
            middle = 0.5 * (low + high)
            place(middle - _LEAST_SPAN, middle + _LEAST_SPAN)
    ax.margins(0.1)


def _dataset(sweeps: tuple[Sweep, ...]) -> xr.Dataset:
    over = ("start", "column")
    return xr.Dataset(
        {
            "eta": ("column", sweeps[0].eta, {"long_name": "frequency ratio"}),
            "x": (
                (*over, "point"),
                np.stack([sweep.data["x"].values for sweep in sweeps]),
                {"long_name": "displacement of the rotor in x at strobes"},
            ),
            "period": (
                over,
                np.stack([sweep.data["period"].values for sweep in sweeps]),
                {"long_name": "period of the motion, 0: none found"},
            ),
            "status": (over, np.stack([sweep.data["status"].values for sweep in sweeps])),
        },
        {"start": [sweep.start for sweep in sweeps]},
    )


def _draw(ax: Axes, across: np.ndarray, values: np.ndarray, colour: str = "black") -> None:
    ax.plot(
        np.repeat(across, values.shape[1]), values.ravel(), color=colour, markersize=0.7, **_DOTS
    )


def _orbits(lines: dict[str, xr.Dataset]) -> xr.Dataset:
    """Lines of a panel, one after the other."""
    numbers = [int(name.split()[-1]) for name in lines]
    whole = {
        "orbit_eta": [each["eta"].values for each in lines.values()],
        "orbit_x": [each["x"].values for each in lines.values()],
        "orbit_stable": [each["stable"].values.astype(float) for each in lines.values()],
        "orbit_period": [
            np.full(each.sizes["point"], float(number))
            for number, each in zip(numbers, lines.values(), strict=True)
        ],
    }
    found = xr.Dataset({name: ("orbit", np.concatenate(each)) for name, each in whole.items()})
    return found.assign_coords(orbit=np.arange(found.sizes["orbit"]))


def _shrink_marks(ax: Axes) -> None:
    """Marks of special points small enough for a panel with many of them."""
    for line in ax.lines:
        if str(line.get_gid() or "").startswith("special "):
            line.set_markersize(2.8)
            line.set_markeredgewidth(0.4)


def _label(axes: Sequence[Axes], across: str, up: str) -> None:
    for k, ax in enumerate(axes):
        ax.set_xlabel(across if k >= len(axes) - 2 else "")
        ax.set_ylabel(up if k % 2 == 0 or "velocity" in up else "")


def _same_heights(axes: Sequence[Axes]) -> None:
    """One range for axes side by side, which are compared."""
    low, high = zip(*(ax.get_ylim() for ax in axes), strict=True)
    for ax in axes:
        ax.set_ylim(min(low), max(high))


def _printed_line(label: str, style: dict[str, Any] | None = None) -> Line2D:
    from matplotlib.lines import Line2D

    style = style or _PRINTED
    return Line2D([], [], label=label, **{k: v for k, v in style.items() if k != "zorder"})


def _millimetres(axis: str) -> dict[str, str]:
    return {"long_name": f"displacement of the rotor in {axis} at strobes", "units": "mm"}


def _version(sweeps: tuple[Sweep, ...]) -> dict[str, str]:
    return {"nonsmooth_version": sweeps[0].data.attrs["nonsmooth_version"]}


_FEW = 40  # different points, up to which they are drawn large
_NEAR_CYCLE, _NEAR_SET = 1e-4, 0.02  # of the followed motion: the same one
_LEAST_SPAN = 0.05  # of an axis, in mm and mm/s
_PRINTED: dict[str, Any] = {
    "color": PALETTE["vermilion"], "linewidth": 0.8, "linestyle": (0, (4, 3)), "zorder": 0,
}  # fmt: skip
# beside branches, whose unstable parts are dashed, and their marks: green ones are tori
_MARKED = _PRINTED | {"color": PALETTE["purple"], "linestyle": (0, (6, 2, 1, 2))}


# Sections of the rotor's motion at strobes: Fig. 37.

# Preload and eta of the four panels as printed, and for (a) and (b) the eta of the other one.
PANELS = {"a": (0.0, 2.223), "b": (0.1, 2.181), "c": (0.0, 2.442), "d": (0.1, 2.442)}
_EXCHANGED = {"a": 2.181, "b": 2.223}


def fig37(transient: int = 1000, record: int = 8000) -> tuple[Figure, xr.Dataset]:
    """Fig. 37: velocity over displacement at strobes, from zero, for the four pairs printed.

    Parameters
    ----------
    transient, record : int, optional
        Periods left out and drawn.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Panels (a) to (d). In (a) and (b) orange points belong to the eta printed for the other of
        the two panels.
    data : xarray.Dataset
        ``x`` and ``vx`` over ``panel``, ``reading`` ("printed", "exchanged") and ``point``, and
        their ``eta``; nan where there is no other reading.

    Examples
    --------
    >>> figure, data = fig37(transient=50, record=20)
    >>> data["x"].dims, len(figure.axes)
    (('panel', 'reading', 'point'), 4)
    """
    figure, axes = print_figure(2, 2, width=16.0, height=13.0)
    readings = ("printed", "exchanged")
    shape = (len(PANELS), len(readings))
    values = {name: np.full((*shape, record), np.nan) for name in ("x", "vx")}
    etas = np.full(shape, np.nan)
    for row, (ax, (panel, (delta, printed))) in enumerate(zip(axes, PANELS.items(), strict=True)):
        for column, eta in enumerate((printed, _EXCHANGED.get(panel))):
            if eta is None:
                continue
            found = stroboscopic_map(set_a(delta, eta), transient=transient, record=record)
            few = np.unique(found["x"].values.round(9)).size < 20
            ax.plot(
                found["x"], found["vx"], linestyle="none", rasterized=True,
                marker="o" if column == 0 else "^", markeredgewidth=0.0,
                markersize=5.0 if few else 0.7, label=rf"$\eta$ = {eta:g}, {readings[column]}",
                color=("black", PALETTE["vermilion"])[column],
            )  # fmt: skip
            etas[row, column] = eta
            for name, array in values.items():
                array[row, column] = found[name].values
        ax.set_title(
            rf"({panel}) $\Delta_x = \Delta_y = {delta:g}$, $\eta = {printed:g}$",
            loc="left", fontsize=_TEXT,
        )  # fmt: skip
        if panel in _EXCHANGED:
            place_legend(ax)
        ax.set_xlabel(r"displacement, $x_r/\gamma$" if row > 1 else "")
        ax.set_ylabel(r"velocity, $v_{x_r}$" if row % 2 == 0 else "")
    over = ("panel", "reading", "point")
    names = {"x": "displacement of the rotor in x", "vx": "velocity of the rotor in x"}
    data = xr.Dataset(
        {name: (over, array, {"long_name": names[name]}) for name, array in values.items()}
        | {"eta": (over[:2], etas, {"long_name": "frequency ratio"})},
        {"panel": list(PANELS), "reading": list(readings)},
        {"transient": transient, "record": record},
    )
    return figure, data
