"""`periodic_orbit`, `orbit_history`: one turn of a periodic orbit, its legs in colours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, quote, unknown_name
from nonsmooth.plot.histories import common_label, phases
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.markers import EVENT_MARK, EVENT_SHAPES, event_markers
from nonsmooth.plot.portrait import phase_portrait
from nonsmooth.plot.style import mode_colours
from nonsmooth.plot.trace import DENSE, broken, curve

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["as_run", "orbit_history", "periodic_orbit"]

_DOTTED: Any = (0, (1.0, 1.2))
_VISIBLE = 1e-3  # of the range of a curve: smaller jumps are rounding, or cannot be seen
_SECTION: dict[str, Any] = {
    "linestyle": "none", "marker": "s", "markersize": 4.0, "color": "black", "zorder": 5,
    "label": "section",
}  # fmt: skip

Floats = npt.NDArray[np.float64]


@checked
def periodic_orbit(
    samples: xr.Dataset,
    x: str,
    y: str,
    *,
    turns: int = 1,
    drift: bool = True,
    events: bool = True,
    ax: Axes | None = None,
    legend: bool = True,
) -> Axes:
    """Phase portrait of a periodic orbit: each leg in the colour of its mode.

    Parameters
    ----------
    samples : xarray.Dataset
        Result of `orbit_samples`.
    x, y : str
        States or outputs.
    turns : int, optional
        How often the orbit is run through; more than once only shows where it drifts.
    drift : bool, optional
        Whether drifts stay in. Without them the curve closes: each state that drifts is less its
        mean motion.
    events : bool, optional
        Whether to mark the events of the first turn, where they happen.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes: a line per mode, one for the jumps, a square at the section point.

    Raises
    ------
    OptionError
        For an unknown variable, a dataset without legs, or a number of turns below one.

    See Also
    --------
    orbit_history : variables over time.
    orbit : the path of a rotor, with equal axes; samples of a periodic orbit are drawn too.

    Notes
    -----
    The orbit is drawn as it was sampled, leg by leg, and not simulated: a run would leave an
    unstable one. The curves of an inadmissible orbit are dotted, and the legend says so.

    Examples
    --------
    A mass that bounces between two walls, without loss: two legs.

    >>> import xarray as xr
    >>> import nonsmooth as ns
    >>> flags = {"flag_values": [0, 1], "flag_meanings": "right left"}
    >>> samples = xr.Dataset(
    ...     {
    ...         "x": ("time", [0.0, 1.0, 1.0, 0.0]),
    ...         "v": ("time", [1.0, 1.0, -1.0, -1.0]),
    ...         "mode": ("time", [0, 0, 1, 1], flags),
    ...         "leg": ("time", [0, 0, 1, 1]),
    ...     },
    ...     {"time": [0.0, 1.0, 1.0, 2.0]},
    ... )
    >>> ax = ns.plot.periodic_orbit(samples, "x", "v")
    >>> [line.get_label() for line in ax.lines]
    ['right', 'left', 'jump', 'event', 'section']
    """
    run = as_run(_checked(samples, [x, y]), turns=turns, drift=drift)
    before = 0 if ax is None else len(ax.lines)
    ax = phase_portrait(run, x, y, ax=ax, phases=True, legend=False)
    _dot(samples, ax, before)
    if events:
        _mark_events(run, x, y, ax, turns)
    ax.plot(run[x].values[:1], run[y].values[:1], **_SECTION)
    if legend:
        place_legend(ax)
    return ax


@checked
def orbit_history(
    samples: xr.Dataset,
    variables: str | Sequence[str],
    *,
    turns: int = 1,
    drift: bool = True,
    events: bool = False,
    ax: Axes | None = None,
    labels: Mapping[str, str] | None = None,
    legend: bool = True,
) -> Axes:
    """Variables of a periodic orbit over time, from the section point on, with the modes behind.

    Parameters
    ----------
    samples : xarray.Dataset
        Result of `orbit_samples`.
    variables : str or sequence of str
        States and outputs.
    turns : int, optional
        How often the orbit is run through.
    drift : bool, optional
        Whether drifts stay in; without them each state that drifts is less its mean motion.
    events : bool, optional
        Whether to mark the events on every curve.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    labels : mapping of str to str, optional
        Texts of the legend by name of the variable or mode; the name by default.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; one line per variable, broken where a reset makes it jump, with dotted lines
        across the jumps; one collection of rectangles per mode, a square at the section point of
        each curve.

    Raises
    ------
    OptionError
        For an unknown variable, a dataset without legs, or a number of turns below one.

    See Also
    --------
    periodic_orbit : one variable over another.
    phases : the same of a run.

    Examples
    --------
    >>> import xarray as xr
    >>> import nonsmooth as ns
    >>> flags = {"flag_values": [0, 1], "flag_meanings": "right left"}
    >>> samples = xr.Dataset(
    ...     {
    ...         "x": ("time", [0.0, 1.0, 1.0, 0.0]),
    ...         "mode": ("time", [0, 0, 1, 1], flags),
    ...         "leg": ("time", [0, 0, 1, 1]),
    ...     },
    ...     {"time": [0.0, 1.0, 1.0, 2.0]},
    ... )
    >>> ax = ns.plot.orbit_history(samples, "x", turns=2)
    >>> ax.get_xlim(), [c.get_label() for c in ax.collections]
    ((np.float64(0.0), np.float64(4.0)), ['right', 'left'])
    """
    names = [variables] if isinstance(variables, str) else list(variables)
    run = as_run(_checked(samples, names), turns=turns, drift=drift)
    before = 0 if ax is None else len(ax.lines)
    ax = phases(run, names, ax=ax, labels=labels, legend=False)
    _part_jumps(run, names, ax, before)
    if before == 0 and len(names) > 1 and any("less its drift" in str(run[n].attrs) for n in names):
        ax.set_ylabel(f"{common_label(run, names)} less drift")
    _dot(samples, ax, before)
    for k, name in enumerate(names):
        if events:
            event_markers(run, name, ax)
        style = _SECTION | ({"label": "_section"} if k else {})
        ax.plot(run["time"].values[:1], run[name].values[:1], clip_on=False, **style)
    if legend:
        place_legend(ax)
    return ax


def _checked(samples: xr.Dataset, names: Sequence[str]) -> xr.Dataset:
    """Samples, if they have some variables; said before anything is made of them."""
    known = over_time(samples) if "time" in samples.dims else []
    if "leg" in samples.variables and known:
        for name in names:
            if name not in known:
                raise OptionError(unknown_name("variable", name, known))
    return samples


def _part_jumps(run: xr.Dataset, names: Sequence[str], ax: Axes, before: int) -> None:
    """Break each curve where it jumps, which is no motion, and dot the way across."""
    drawn = ax.lines[before : before + len(names)]
    for name, line in zip(names, drawn, strict=True):
        trace = curve(run, [name])
        if trace.time.size > DENSE:  # thinned
            continue
        moved = np.abs(np.diff(trace.values[0])) > _VISIBLE * np.ptp(trace.values[0])
        jumps = trace.jumps & np.append(moved, False)
        if not np.any(jumps):
            continue
        points = np.stack([trace.time, trace.values[0]])
        line.set_data(*broken(points, ~jumps))
        ax.plot(
            *broken(points, jumps), color=line.get_color(), linestyle=_DOTTED, linewidth=0.7,
            label=f"_jump of {name}", zorder=line.get_zorder(),
        )  # fmt: skip


def _dot(samples: xr.Dataset, ax: Axes, before: int) -> None:
    """Dot the curves of an orbit that no motion follows, and say so."""
    if "admissible" not in samples or bool(samples["admissible"]):
        return
    for line in ax.lines[before:]:
        line.set_linestyle(_DOTTED)
    ax.plot([], [], linestyle=_DOTTED, color="0.4", label="inadmissible")


def _mark_events(run: xr.Dataset, x: str, y: str, ax: Axes, turns: int) -> None:
    """Marks at the states just before the events of the first turn, one shape for each name."""
    names = run["event_name"].values.astype(str)
    count = run.sizes["event"] // turns
    states = [str(name) for name in run["state"].values]
    at = run["state_before"].values[:count][:, [states.index(x), states.index(y)]]
    for k, name in enumerate(np.unique(names)):
        here = names[:count] == name
        ax.plot(*at[here].T, marker=EVENT_SHAPES[k % len(EVENT_SHAPES)], label=name, **EVENT_MARK)


def over_time(samples: xr.Dataset) -> list[str]:
    """Names of the states and outputs of samples."""
    return [
        str(name)
        for name, values in samples.data_vars.items()
        if values.dims == ("time",) and values.dtype.kind == "f"
    ]


def exits_of_legs(samples: xr.Dataset, legs: int) -> list[str]:
    """Names of the exits passed at the end of each leg, "" at the section."""
    if "leg_exit" not in samples:  # then it is no event where a mode is cut by the section
        modes = samples["mode"].values
        return ["event"] * (legs - 1) + ["event" if modes[0] != modes[-1] else ""]
    names = [str(name) for name in samples["leg_exit"].values]
    if samples["leg_exit"].dims == ("time",):
        leg = np.append(samples["leg"].values.astype(int), -1)
        names = [names[k] for k in np.flatnonzero(np.diff(leg))]
    return names[:legs]


def as_run(samples: xr.Dataset, *, turns: int = 1, drift: bool = True) -> xr.Dataset:
    """Samples as a run: so many turns, then the instant at which the next one begins.

    Without its drift each state that drifts, and each output that goes with it, is less the mean
    motion.
    """
    import xarray as xr

    _check(samples, turns)
    names = over_time(samples)
    time = samples["time"].values.astype(float)
    leg = samples["leg"].values.astype(np.int64)
    legs = int(leg[-1]) + 1
    length = float(samples["length"]) if "length" in samples else float(time[-1] - time[0])
    exits = exits_of_legs(samples, legs)
    change = _changes(samples, names, jumps=bool(exits[-1]))
    turn = np.repeat(np.arange(turns), time.size)
    clock = np.append(np.tile(time - time[0], turns) + turn * length, turns * length)
    numbers = np.append(np.tile(leg, turns) + turn * legs, turns * legs)
    modes = samples["mode"].values
    variables: dict[str, Any] = {
        "mode": ("time", np.append(np.tile(modes, turns), modes[0]), samples["mode"].attrs),
        "leg": ("time", numbers),
    }
    for name in names:
        values = samples[name].values.astype(float)
        tiled = np.append(np.tile(values, turns) + turn * change[name], 0.0)
        tiled[-1] = values[0] + turns * change[name]
        attrs = dict(samples[name].attrs)
        if not drift and change[name] != 0.0:
            tiled = tiled - change[name] * clock / length
            attrs["long_name"] = f"{attrs.get('long_name') or name} less its drift"
        variables[name] = ("time", tiled, attrs)
    run = xr.Dataset(
        variables, {"time": ("time", time[0] + clock, samples["time"].attrs)}, samples.attrs
    )
    return run.assign(_log(run, names, exits))


def _check(samples: xr.Dataset, turns: int) -> None:
    if not {"leg", "mode"} <= set(samples.variables) or "time" not in samples.dims:
        raise OptionError(
            "the dataset has no variables 'leg' and 'mode' over 'time'; draw the samples of an"
            " orbit: ns.orbit_samples(orbit)"
        )
    mode_colours(samples)  # names of modes are there
    if samples.sizes["time"] < 2:
        raise OptionError("the orbit has no samples to draw; see its attribute 'message'")
    if isinstance(turns, bool) or not isinstance(turns, int | np.integer) or turns < 1:
        raise OptionError(f"turns = {quote(turns)} must be a whole number, 1 or more")


def _changes(samples: xr.Dataset, names: list[str], *, jumps: bool) -> dict[str, float]:
    """Change of each variable over a turn; of most it is zero but for rounding."""
    drifts: dict[str, float] = {}
    if "drift" in samples:
        pairs = zip(samples["drift_state"].values, samples["drift"].values, strict=True)
        drifts = {str(name): float(value) for name, value in pairs}
    change = dict.fromkeys(names, 0.0)
    states = set(names)
    if "system" in samples.attrs:
        from nonsmooth.system.system import System

        system = System.from_toml(samples.attrs["system"])
        states = set(system.states)
        drifts = dict.fromkeys(system.drift_states, np.nan) | drifts
    for name in names:
        values = samples[name].values
        if name in drifts:
            known = np.isfinite(drifts[name])
            change[name] = drifts[name] if known else float(values[-1] - values[0])
        elif name not in states and drifts and not jumps:
            # an output that follows a drift: nothing jumps where the turn ends
            moved = float(values[-1] - values[0])
            change[name] = moved if abs(moved) > 1e-9 * float(np.ptp(values)) else 0.0
    return change


def _log(run: xr.Dataset, names: list[str], exits: list[str]) -> dict[str, Any]:
    """Event log of the changes from leg to leg that are events."""
    leg = run["leg"].values
    ends = np.flatnonzero(np.diff(leg))
    labels = np.array([exits[leg[k] % len(exits)] for k in ends], str)
    ends, labels = ends[labels != ""], labels[labels != ""]
    states = np.stack([run[name].values for name in names], axis=1)
    modes = run["mode"].values
    return {
        "event_time": ("event", run["time"].values[ends + 1]),
        "event_name": ("event", labels),
        "event_kind": ("event", np.full(ends.size, "switch")),
        "event_from": ("event", modes[ends]),
        "event_to": ("event", modes[ends + 1]),
        "state_before": (("event", "state"), states[ends]),
        "state_after": (("event", "state"), states[ends + 1]),
        "state": ("state", np.array(names)),
    }
