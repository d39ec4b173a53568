"""Motion of the ring: without mass, as the chapter has it, and with some."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from nonsmooth import RunError, RunWarning, System, simulate
from nonsmooth.plot import PALETTE, print_figure
from nonsmooth_chapter.judgement import Evidence
from nonsmooth_chapter.rotor.motions import rig, set_a, set_b

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "PANELS",
    "fig38",
    "heavy_ring",
    "heavy_ring_orbit",
    "in_contact",
    "panel_system",
    "ring_jumps",
    "ring_run",
]


# Motion of the snubber ring: its velocity over its displacement, Fig. 38, and where that jumps.

_MOST_BEGUN, _ASIDE = 500, 1e-9  # runs that are begun anew, and by how much velocity aside
_SIDE = 1e-8  # time before and after an event at which velocities are taken
_TEXT = 8
# Set, preload and eta of the four panels.
PANELS = {"a": ("B", 0.0, 2.5), "b": ("B", 0.05, 2.5), "c": ("A", 0.0, 3.0), "d": ("A", 0.03, 3.0)}


def panel_system(panel: str) -> System:
    """Rotor with the data of one panel of Fig. 38.

    Parameters
    ----------
    panel : str
        Letter of the panel.

    Returns
    -------
    System

    Examples
    --------
    >>> panel_system("d").parameter_values["delta_x"]
    0.03
    """
    name, delta, eta = PANELS[panel]
    return {"A": set_a, "B": set_b}[name](delta, eta)


def ring_run(
    system: System, *, transient: int = 1000, periods: int = 12, samples: int = 400
) -> xr.Dataset:
    """Settled run of the rotor with samples on both sides of every event.

    Parameters
    ----------
    system : System
        The rotor.
    transient : int, optional
        Periods left out, from zero.
    periods, samples : int, optional
        Periods of the run, and samples per period beside those at events.

    Returns
    -------
    xarray.Dataset
        As from `simulate`; ``after`` is true for a sample just behind an event.

    Examples
    --------
    >>> run = ring_run(set_a(0.0, 3.0), transient=100, periods=1)
    >>> int(run["after"].sum()) == run.attrs["n_events"]
    True
    """
    start, begun_anew = _settled_start(system, transient, periods)
    end = periods * float(system.period_value or 0.0)
    events = simulate(system, start, times=[0.0, end])["event_time"].values[1:]
    even = np.linspace(0.0, end, periods * samples + 1)
    far = np.abs(even[:, None] - events).min(axis=1, initial=np.inf) > 2.0 * _SIDE
    times = np.concatenate([even[far], events - _SIDE, events + _SIDE])
    after = np.concatenate([np.zeros(far.sum() + events.size, bool), np.ones(events.size, bool)])
    order = np.argsort(times, kind="stable")
    run = simulate(system, start, times=times[order])
    run.attrs["begun_anew"] = begun_anew
    return run.assign(after=("time", after[order]))


def _settled_start(system: System, transient: int, periods: int) -> tuple[dict[str, float], int]:
    """State at the last strobe of a run from zero from which the motion goes on for a while.

    Without preload the surfaces on both sides of an axis are one. Where the rotor crosses it within
    a ten-thousandth of a time unit behind a contact, as at eta = 3, rounding may hide on which side
    the ring is, and the run ends there. It is begun anew a billionth off its last whole strobe but
    one: how often, is the second result.
    """
    start: dict[str, float] = dict.fromkeys(system.states, 0.0)
    left, begun_anew = transient, 0
    while begun_anew < _MOST_BEGUN:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RunWarning)
            run = simulate(
                system, start, periods=left or periods, samples_per_period=1, events=False
            )
        whole = run.attrs["status"] == "completed"
        if whole and not left:  # the run of the figure from this very start
            return start, begun_anew
        there = left if whole else max(run.sizes["time"] - 3, 0)
        start = {name: float(run[name][there]) for name in system.states}
        left = max(left - there, 0)
        if not whole:
            start["vy"] += _ASIDE
            begun_anew += 1
    raise RunError(f"no {periods} periods of {system.name} without an end: {run.attrs['message']}")


def in_contact(run: xr.Dataset, name: str = "mode") -> np.ndarray:
    """Whether rotor and ring touch, for a run or its events.

    Parameters
    ----------
    run : xarray.Dataset
        Run of the rotor.
    name : str, optional
        Variable with numbers of modes: ``mode``, ``event_from`` or ``event_to``.

    Returns
    -------
    numpy.ndarray of bool

    Examples
    --------
    >>> bool(in_contact(ring_run(set_a(0.0, 3.0), transient=100, periods=1)).all())
    False
    """
    names = run["mode"].attrs["flag_meanings"].split()
    free = [number for number, each in enumerate(names) if each == "free"]
    return ~np.isin(run[name].values, free)


def ring_jumps(run: xr.Dataset) -> list[Evidence]:
    """Where the velocity of the ring in x jumps, and by how much.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `ring_run`.

    Returns
    -------
    list of dict
        For each event its ``name`` ("contact", "release" or "spring" where a spring leaves the
        ring or comes back), ``sx`` and ``sy`` there and the ``jump`` of ring_vx.

    Examples
    --------
    >>> run = ring_run(set_a(0.0, 3.0), transient=100, periods=1)
    >>> ring_jumps(run)[0]["name"]
    'contact'
    """
    touching = in_contact(run)
    found = []
    for k in np.flatnonzero(run["after"].values):
        kind = "spring"
        if touching[k - 1] != touching[k]:
            kind = "contact" if touching[k] else "release"
        # the ring is at the event on the side in contact
        here = k - 1 if kind == "release" else k
        found.append(
            {
                "name": kind,
                "sx": float(run["sx"][here]),
                "sy": float(run["sy"][here]),
                "jump": float(run["ring_vx"][k] - run["ring_vx"][k - 1]),
            }
        )
    return found


def fig38(transient: int = 1000, periods: int = 12) -> tuple[Figure, xr.Dataset]:
    """Fig. 38: velocity of the ring over its displacement in x, four panels.

    Parameters
    ----------
    transient, periods : int, optional
        Periods left out, from zero, and drawn.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Panels (a) to (d); dashed lines are jumps, dotted ones the preload.
    data : xarray.Dataset
        ``sx``, ``ring_vx`` and ``after`` over ``panel`` and ``sample``, nan behind the last one.

    Examples
    --------
    >>> figure, data = fig38(transient=100, periods=2)
    >>> data["sx"].dims, len(figure.axes)
    (('panel', 'sample'), 4)
    """
    from matplotlib.lines import Line2D

    figure, axes = print_figure(2, 2, width=16.0, height=13.0)
    runs = []
    for k, (ax, (panel, (name, delta, eta))) in enumerate(zip(axes, PANELS.items(), strict=True)):
        run = ring_run(panel_system(panel), transient=transient, periods=periods)
        runs.append(run)
        sx, velocity, after = (run[key].values for key in ("sx", "ring_vx", "after"))
        at = np.flatnonzero(after)
        ax.plot(
            np.insert(sx, at, np.nan), np.insert(velocity, at, np.nan), color="black",
            linewidth=0.6, solid_joinstyle="round",
        )  # fmt: skip
        ends = [np.stack([y[at - 1], y[at], np.full(at.size, np.nan)], axis=1) for y in
                (sx, velocity)]  # fmt: skip
        ax.plot(*(end.ravel() for end in ends), **_JUMPS)
        if panel == "d":
            _enlarge_jump(ax, run)
        for side in (end for end in (-delta, delta) if end and sx.min() <= end <= sx.max()):
            ax.axvline(side, color=PALETTE["blue"], linewidth=0.8, linestyle=":", zorder=0)
        ax.set_title(
            rf"({panel}) set {name}, $\eta = {eta:g}$, $\Delta_x = \Delta_y = {delta:g}$",
            loc="left", fontsize=_TEXT,
        )  # fmt: skip
        ax.set_xlabel(r"displacement of the ring, $x_s/\gamma$" if k > 1 else "")
        ax.set_ylabel(r"velocity of the ring, $v_{x_s}$" if k % 2 == 0 else "")
    for pair in (axes[:2], axes[2:]):  # one scale for what is compared
        for limits_of, place in (("get_xlim", "set_xlim"), ("get_ylim", "set_ylim")):
            limits = np.array([getattr(ax, limits_of)() for ax in pair])
            for ax in pair:
                getattr(ax, place)(limits[:, 0].min(), limits[:, 1].max())
    handles = [
        Line2D([], [], color="black", linewidth=0.6, label="motion"),
        Line2D([], [], label="jump", **_JUMPS),
        Line2D([], [], color=PALETTE["blue"], linewidth=0.8, linestyle=":",
               label=r"$x_s = \pm\Delta_x$"),
    ]  # fmt: skip
    figure.legend(
        handles=handles, loc="outside upper center", ncols=3, frameon=False, fontsize=_TEXT
    )
    return figure, _dataset(runs)


def _enlarge_jump(ax: Axes, run: xr.Dataset) -> None:
    """Inset with the largest jump at the end of a spring, too small to be seen beside the rest."""
    places = np.flatnonzero(run["after"].values)
    jumps = [
        (abs(jump["jump"]), jump["sx"], int(k))
        for k, jump in zip(places, ring_jumps(run), strict=True)
        if jump["name"] == "spring"
    ]
    if not jumps:
        return
    size, side, k = max(jumps)
    middle, tall = 0.5 * float(run["ring_vx"][k] + run["ring_vx"][k - 1]), 2.5 * size
    inset = ax.inset_axes(
        (0.29, 0.38, 0.22, 0.3), xlim=(side - _BESIDE, side + _BESIDE),
        ylim=(middle - tall, middle + tall),
    )  # fmt: skip
    for line in ax.lines:
        inset.plot(*line.get_data(), color=line.get_color(), linestyle=line.get_linestyle(),
                   linewidth=0.8)  # fmt: skip
    inset.axvline(side, color=PALETTE["blue"], linewidth=0.8, linestyle=":", zorder=0)
    inset.tick_params(labelsize=6, width=0.5, length=2.0)
    inset.set_xticks([side])
    inset.yaxis.tick_right()  # clear of the line at the end of the spring
    ax.indicate_inset_zoom(inset, edgecolor="0.5", linewidth=0.6)


def _dataset(runs: list[xr.Dataset]) -> xr.Dataset:
    longest = max(run.sizes["time"] for run in runs)
    names = {
        "sx": "displacement of the ring in x",
        "ring_vx": "velocity of the ring in x",
        "after": "1 just behind an event, nan behind the last sample",
    }
    variables = {}
    for name, label in names.items():
        values = np.full((len(runs), longest), np.nan)
        for row, run in zip(values, runs, strict=True):
            row[: run.sizes["time"]] = run[name].values
        variables[name] = (("panel", "sample"), values, {"long_name": label})
    data = xr.Dataset(variables, {"panel": list(PANELS)})
    data.attrs["nonsmooth_version"] = runs[0].attrs["nonsmooth_version"]
    return data


_BESIDE = 0.004  # displacement on either side of the jump in the inset
_JUMPS: dict[str, Any] = {"color": PALETTE["vermilion"], "linewidth": 0.6, "linestyle": (0, (4, 2))}


# The rotor with a ring that has a mass, as a test of leaving it out.

_LONGEST, _REPEATS = 16, 1e-6


def heavy_ring(values: Mapping[str, float], mass: float, stiffness: float) -> System:
    """Rotor and ring as two bodies, with a stiff spring and damper where they touch.

    Parameters
    ----------
    values : mapping of str to float
        Parameters of `nonsmooth.models.rotor`.
    mass : float
        Mass of the ring over that of the rotor.
    stiffness : float
        Of the contact over that of one spring of the ring; its damper is critical for the ring.

    Returns
    -------
    System

    Examples
    --------
    >>> heavy_ring(rig().parameters(), 1 / 17, 50.0).name
    'rotor with a heavy ring'
    """
    contact = stiffness * values["K"]
    drive = "eta_m*rho*eta**2*{}(eta*t + phi0) - 2*nu1*v{} - ({} - eps_{}) - N*n{}"
    held = "(N*n{0} - K*(springs_{0}*s{0} + preload_{0}) - 2*nu2*springs_{0}*u{0})/m_s"
    flow = {
        "x": "vx", "y": "vy", "vx": drive.format("cos", "x", "x", "x", "x"),
        "vy": drive.format("sin", "y", "y", "y", "y"), "sx": "ux", "sy": "uy",
        "ux": held.format("x"), "uy": held.format("y"),
    }  # fmt: skip
    springs = {}
    for axis in "xy":
        beyond = f"where(s{axis} > delta_{axis}, {{}}, where(s{axis} < -delta_{axis}, {{}}, {{}}))"
        springs[f"springs_{axis}"] = beyond.format(1, 1, 2)
        springs[f"preload_{axis}"] = beyond.format(f"delta_{axis}", f"-delta_{axis}", 0)
    return System(
        name="rotor with a heavy ring",
        states=["x", "y", "vx", "vy", "sx", "sy", "ux", "uy"],
        period="2*pi/eta",
        parameters={
            **values, "m_s": mass, "k_c": contact, "c_c": 2.0 * float(np.sqrt(contact * mass)),
        },
        definitions={
            "D": "sqrt((x - sx)**2 + (y - sy)**2 + 1e-30)",
            "nx": "(x - sx)/D",
            "ny": "(y - sy)/D",
            "touch": "k_c*(D - 1) + c_c*((vx - ux)*nx + (vy - uy)*ny)",
            # no pull: neither apart, nor where the damper would hold them together
            "N": "where(D > 1, max(touch, 0), 0)",
            **springs,
        },
        outputs={"touching": "where(D > 1, 1, 0)"},
        equations=flow,
    )  # fmt: skip


def heavy_ring_orbit(
    speed: float, mass: float, stiffness: float, transient: int = 600, samples: int = 200
) -> Evidence:
    """How the settled motion of the rig changes when its ring has a mass.

    Parameters
    ----------
    speed : float
        Speed of the shaft of the rig of Fig. 42 [Hz].
    mass, stiffness : float
        As for `heavy_ring`.
    transient : int, optional
        Periods left out, from zero.
    samples : int, optional
        Samples per period.

    Returns
    -------
    dict
        ``period`` and ``massless_period`` (0: none), ``contacts`` and ``massless_contacts`` per
        period, and ``difference`` of the orbits beside half their width.
    """
    values = rig(speed=speed).parameters()
    massless = _settled(rig(speed=speed).system(), transient, samples)
    heavy = _settled(heavy_ring(values, mass, stiffness), transient, samples)
    size = 0.5 * np.ptp(massless["orbit"], axis=0).max()
    apart = np.abs(heavy["orbit"] - massless["orbit"]).max()
    return {
        "stiffness": stiffness,
        "period": heavy["period"],
        "massless_period": massless["period"],
        "contacts": heavy["contacts"],
        "massless_contacts": massless["contacts"],
        "difference": float(apart / size),
    }


def _settled(system: System, transient: int, samples: int) -> Evidence:
    run = simulate(system, periods=transient + 2 * _LONGEST, samples_per_period=samples)
    orbit = np.stack([run[name].values for name in "xy"], axis=1)[transient * samples :]
    strobes = orbit[::samples]
    period = 0
    for n in range(_LONGEST, 0, -1):
        if np.abs(strobes[n:] - strobes[:-n]).max() <= _REPEATS:
            period = n
    touching = run["touching"].values if "touching" in run else run["gap"].values <= 1e-12
    begins = np.diff(touching[transient * samples :].astype(int)) > 0
    return {
        "period": period,
        "orbit": orbit[: samples * max(period, 1)],
        "contacts": float(begins.sum() / (2 * _LONGEST)),
    }
