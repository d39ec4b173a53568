"""The rig over its speed, and its orbits at 13.1 Hz."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth import regime, simulate
from nonsmooth.models import RotorRig
from nonsmooth.plot import PALETTE, print_figure
from nonsmooth_chapter.judgement import Evidence
from nonsmooth_chapter.rotor.motions import DELTA_40, DELTA_41, EPS_40, EPS_41, coexisting, rig
from nonsmooth_chapter.rotor.ring import in_contact
from nonsmooth_chapter.rotor.speed_sweeps import (
    CHAOTIC,
    PROTOCOLS,
    Sweep,
    even_values,
    last_strobe,
    speed_sweeps,
    with_exponents,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = [
    "LOW",
    "SETS",
    "chaotic_span",
    "column_at",
    "fig42",
    "followed_motion",
    "machine_of",
    "rig_sweeps",
    "speed_scan",
]


# The rig over its speed, by three protocols, and its motions at single speeds.

# Eccentricity, preload and last speed of the two diagrams; both begin at 7 Hz.
SETS = {"40": (EPS_40, DELTA_40, 50.0), "41": (EPS_41, DELTA_41, 30.0)}
LOW, _STEP = 7.0, 0.2  # Hz
_TRANSIENT, _RECORD = 400, 100


def machine_of(figure: str) -> RotorRig:
    """Rig with the data of Fig. 40 or 41.

    Parameters
    ----------
    figure : str
        ``"40"`` or ``"41"``.

    Returns
    -------
    RotorRig

    Examples
    --------
    >>> machine_of("40").preload_x
    0.1
    """
    eps, delta, _ = SETS[figure]
    return rig(eps, delta)


@lru_cache(maxsize=4)
def rig_sweeps(figure: str, step: float = _STEP) -> dict[str, Sweep]:
    """Diagrams of the rig over its speed with labels, by three protocols.

    Parameters
    ----------
    figure : str
        ``"40"`` or ``"41"``.
    step : float, optional
        Distance of columns [Hz].

    Returns
    -------
    dict of str to Sweep
        By protocol, over eta.

    Examples
    --------
    >>> sorted(rig_sweeps("41", step=11.5))
    ['follow down', 'follow up', 'restart']
    """
    machine, last = machine_of(figure), SETS[figure][2]
    hertz = machine.natural_frequency
    etas = even_values(LOW / hertz, last / hertz, round((last - LOW) / step))
    system = machine.system()
    found = speed_sweeps(system, etas, PROTOCOLS, transient=_TRANSIENT, record=_RECORD)
    return {sweep.start: with_exponents(system, sweep) for sweep in found}


def column_at(figure: str, start: str, speed: float) -> tuple[Sweep, int]:
    """Sweep by a protocol, and its column next to a speed.

    Parameters
    ----------
    figure, start : str
        Diagram and protocol.
    speed : float
        Speed [Hz].

    Returns
    -------
    Sweep
    column : int
    """
    sweep = rig_sweeps(figure)[start]
    eta = speed / machine_of(figure).natural_frequency
    return sweep, int(np.abs(sweep.eta - eta).argmin())


def followed_motion(figure: str, speed: float, start: str = "follow up") -> Evidence:
    """Regime at a speed, begun where the nearest column of a diagram ended.

    Parameters
    ----------
    figure : str
        Diagram.
    speed : float
        Speed [Hz].
    start : str, optional
        Protocol of the diagram.

    Returns
    -------
    dict
        ``regime``, ``period``, ``message``; ``exponent`` per period with ``error`` where there is
        no period; ``motions`` that random starts lead to.
    """
    sweep, column = column_at(figure, start, speed)
    machine = machine_of(figure)
    system = machine.system().with_parameters(eta=speed / machine.natural_frequency)
    last = sweep.data.isel(parameter=column, point=-1)
    found = regime(system, {name: float(last[name]) for name in system.states}, transient=400)
    row: Evidence = {
        "speed": speed,
        "start": start,
        "regime": found["regime"].item(),
        "period": int(found["period"]),
        "message": found.attrs["message"],
        "motions": [_shown(each) for each in coexisting(system)],
    }
    if not row["period"]:
        turn = float(system.period_value or 0.0)
        row["exponent"] = float(found["exponent"]) * turn
        row["error"] = float(found["exponent_error"]) * turn
    return row


def _shown(row: Evidence) -> Evidence:
    kept = ("period", "share", "from_zero", "exponent", "error", "chaotic")
    return {name: row[name] for name in kept if name in row}


@lru_cache(maxsize=4)
def speed_scan(figure: str, every: int = 3, periods: int = 48) -> list[Evidence]:
    """Contacts, contact force and amplitude of the followed motions, speed by speed.

    Parameters
    ----------
    figure : str
        Diagram.
    every : int, optional
        Columns from one speed to the next.
    periods : int, optional
        Periods of each run, after the column's own.

    Returns
    -------
    list of dict
        ``speed`` [Hz], ``label`` as in the sweep, ``contacts`` per period, largest ``force`` of
        contact [N], ``amplitude`` (half the widest range of x or y) [mm].
    """
    machine = machine_of(figure)
    sweep = rig_sweeps(figure)["follow up"]
    force = machine.units.force
    rows = []
    for column in range(0, sweep.eta.size, every):
        system = machine.system().with_parameters(eta=float(sweep.eta[column]))
        last = sweep.data.isel(parameter=column, point=-1)
        start = {name: float(last[name]) for name in system.states}
        run = simulate(system, start, periods=periods, samples_per_period=60)
        begin, end = (in_contact(run, name) for name in ("event_from", "event_to"))
        widths = [float(np.ptp(run[name].values)) for name in "xy"]
        rows.append(
            {
                "speed": float(sweep.eta[column] * machine.natural_frequency),
                "label": int(sweep.labels[column]),
                "contacts": float(np.sum(~begin & end) / periods),
                "force": force * float(run["force"].values.max()),
                "amplitude": 0.5 * machine.gap * max(widths),
            }
        )
    return rows


def chaotic_span(sweep: Sweep) -> tuple[int, int] | None:
    """First and last chaotic column of a sweep.

    Parameters
    ----------
    sweep : Sweep
        With labels.

    Returns
    -------
    tuple of int, or None
    """
    chaos = np.flatnonzero(sweep.labels == CHAOTIC)
    return (int(chaos[0]), int(chaos[-1])) if chaos.size else None


# Orbits of the rig at 13.1 Hz in both directions: Fig. 42(b), (d).

_SPEED = 13.1
_TEXT = 8


def fig42(transient: int = 1000, samples: int = 500) -> tuple[Figure, xr.Dataset]:
    """Fig. 42: velocity over displacement in x and in y at 13.1 Hz, the model's part.

    Parameters
    ----------
    transient : int, optional
        Periods left out, from zero.
    samples : int, optional
        Samples per period.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Panels (b) and (d) of the chapter; the thick parts are in contact with the ring.
    data : xarray.Dataset
        The run over one period of the motion, in mm and mm/s.

    Examples
    --------
    >>> figure, data = fig42(transient=200, samples=50)
    >>> data["vx"].attrs["units"], data.attrs["period_of_motion"]
    ('mm/s', 1)
    """
    machine = rig(speed=_SPEED)
    system = machine.system()
    period = int(regime(system, transient=transient)["period"]) or 8
    run = machine.to_si(
        simulate(system, last_strobe(system, transient), periods=period, samples_per_period=samples)
    )
    run.attrs["period_of_motion"] = period
    figure, axes = print_figure(1, 2, width=16.0, height=7.0)
    touching = in_contact(run)
    for ax, axis, letter in zip(axes, "xy", "bd", strict=True):
        place, velocity = run[axis].values, run[f"v{axis}"].values
        ax.plot(place, velocity, color="black", linewidth=0.9, label="free")
        ax.plot(
            np.where(touching, place, np.nan), np.where(touching, velocity, np.nan),
            color=PALETTE["vermilion"], linewidth=2.2, label="in contact",
        )  # fmt: skip
        ax.plot(place[0], velocity[0], "o", color=PALETTE["blue"], markersize=3.5, label="strobe")
        ax.set_xlabel(f"displacement in {axis} [mm]")
        ax.set_ylabel(f"velocity in {axis} [mm/s]")
        ax.set_title(f"({letter}) {_SPEED:g} Hz, period {period}", loc="left", fontsize=_TEXT)
    figure.legend(
        *axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3, frameon=False,
        fontsize=_TEXT,
    )  # fmt: skip
    return figure, run
