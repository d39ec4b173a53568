"""`fit`: a measured channel beside what was fitted to it, and the difference below."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, unknown_choice, unknown_name
from nonsmooth.plot.alignment import folded, marks_of, turns_of
from nonsmooth.plot.compared_spectra import MEASURED
from nonsmooth.plot.figures import divided, new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import LINES, PALETTE, axis_label, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["fit", "fitted_channel"]

_HEIGHTS = (5, 2)  # of the record and of the residuals
_BAND = 1.96  # standard deviations that hold 95 % of a normal variable
_WAYS = ("time", "phase")
_DOT: dict[str, Any] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 2.4,
    "markeredgewidth": 0.0,
}
_HELD = PALETTE["blue"]
_GAP = 3.5  # steps of time between two samples, between which some were left out

Floats = npt.NDArray[np.float64]


@checked
def fit(
    data: xr.Dataset,
    channel: str | None = None,
    *,
    align: str = "time",
    periods: int | None = None,
    ax: Axes | None = None,
    time_range: tuple[float, float] | None = None,
) -> Axes:
    """Measured samples with the fitted motion, and the residuals in a panel below.

    Of a channel of events it shows the times between them, as they were picked and as they are
    fitted.

    The grey band of the panel holds 95 % of the residuals where the noise is normal. What was
    held back and predicted has a coloured ground, or coloured dots where periods lie over each
    other.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `fit`.
    channel : str, optional
        Channel of the record; the first one by default.
    align : {"time", "phase"}, optional
        ``"time"`` shows the record as it was measured. ``"phase"`` lays periods over each other,
        from mark to mark of the record, or by the forcing where the record has no marks.
    periods : int, optional
        With ``align="phase"``, number of periods beside each other; by default those of the cycle
        of a steady motion, else one.
    ax : matplotlib.axes.Axes, optional
        Where to draw, axes of a grid; new axes of a column's width by default. The panel of the
        residuals takes a part of their place and is the last of the ``axes`` of the figure.
    time_range : tuple of float, optional
        First and last time to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The axes of the measured samples.

    Raises
    ------
    OptionError
        For another dataset, a channel that was not fitted, or a phase without marks or of events.

    See Also
    --------
    fit_spectra : the same over frequency.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.linspace(0, 10, 200)
    >>> noise = 0.01 * np.random.default_rng(1).standard_normal(t.size)
    >>> record = ns.measured.from_arrays({"x": np.exp(-0.5 * t) + noise}, times=t)
    >>> decay = ns.System(states=["x"], parameters={"k": 1.0}, equations={"x": "-k*x"})
    >>> ax = ns.plot.fit(ns.fit(decay, record, {"k": (0.1, 2)}))
    >>> [each.get_ylabel() for each in ax.figure.axes]
    ['displacement x', 'residual']
    """
    name = chosen_channel(data, channel)
    of_events = not np.isfinite(data["measured"].sel(channel=name)).any()
    shown = picked_events(data, name) if of_events else fitted_channel(data, name)
    if of_events and align == "phase":
        raise OptionError(f"align = 'phase': {name} has instants of events; give align='time'")
    by_phase = _checked_way(data, align, periods)
    if time_range is not None:
        first, last = map(float, time_range)
        shown = shown.isel(time=(shown["time"].values >= first) & (shown["time"].values <= last))
        if not shown.sizes["time"]:
            raise OptionError(f"time_range = ({first:g}, {last:g}) has no samples of the record")
    ax = new_axes() if ax is None else ax
    _, panel = divided(ax, 2, heights=_HEIGHTS)
    panel.sharex(ax)
    level = _BAND * float(shown["noise"])
    panel.axhspan(-level, level, color="0.88", linewidth=0.0, zorder=0)
    ax.fill_between([], [], color="0.88", linewidth=0.0, label="95 % of the noise")
    if by_phase:
        cycle = str(data.attrs["cycle"])
        across = (int(cycle) if cycle.isdecimal() else 1) if periods is None else periods
        _draw_phases(ax, panel, shown, across)
        label = "phase [periods since the mark]"
    else:
        _draw_times(ax, panel, shown)
        label = axis_label(data["time"])
    ax.tick_params(labelbottom=False)
    panel.set_xlabel(label)
    # the panel is too low for both in one line
    panel.set_ylabel(_height_label(data, name, "residual").replace(" [", "\n["))
    heading = f"{name}: time since the one before" if of_events else _quantity_of(data, name)
    finish_axes(ax, " ", _height_label(data, name, heading))
    place_legend(ax)
    return ax


def _quantity_of(data: xr.Dataset, name: str) -> str:
    """Name of a channel and what it shows, as far as the fit knows that."""
    said = ""
    if "channel_quantity" in data:
        said = str(data["channel_quantity"].sel(channel=name).item())
    if said in ("", name):
        return name
    return said if name in said.split() else f"{name}: {said}"


def _height_label(data: xr.Dataset, name: str, heading: str) -> str:
    """A heading with the units of the record of a channel; older results tell none."""
    said = data["channel"].sel(channel=name).copy()
    said.attrs["long_name"] = heading
    if "channel_units" in data:
        said.attrs["units"] = str(data["channel_units"].sel(channel=name).item())
    return axis_label(said)


def chosen_channel(data: xr.Dataset, channel: str | None) -> str:
    """Name of a channel of a fit, by default of the first one that has samples."""
    if not {"measured", "fitted", "residual", "noise", "held_back"} <= set(data.variables):
        raise OptionError("data: draw a result of fit")
    channels = [str(name) for name in data["channel"].values]
    if channel is not None and channel not in channels:
        raise OptionError(f"channel: {unknown_name('channel', channel, channels)}")
    there = np.isfinite(data["measured"].values).any(axis=1)
    return channels[int(there.argmax())] if channel is None else channel


def fitted_channel(data: xr.Dataset, channel: str | None) -> xr.Dataset:
    """Samples of one channel of a fit, by default of the first one that has some."""
    name = chosen_channel(data, channel)
    shown = data.sel(channel=name)
    there = np.isfinite(shown["measured"].values)
    if not there.any():
        raise OptionError(
            f"channel: {name} has instants of events and no samples to draw; they are in"
            " picked_residual of the result"
        )
    if "segment_record" in data and data["segment_record"].values.any():
        # several records, whose times stand between each other
        shown = shown.isel(time=there)
    return shown


def picked_events(data: xr.Dataset, channel: str) -> xr.Dataset:
    """The times between the events of a channel as samples over the instants of the later ones."""
    import xarray as xr

    number = data["channel"].values.tolist().index(channel)
    events = data.isel(picked=data["picked_channel"].values == number)
    instants = events["picked_measured"].values[1:]
    variables = {
        name: ("time", np.diff(events[f"picked_{name}"].values)) for name in ("measured", "fitted")
    }
    variables["residual"] = "time", events["picked_residual"].values[1:]
    variables["held_back"] = "time", events["picked_held_back"].values[1:]
    found = xr.Dataset(variables, {"time": ("time", instants, data["time"].attrs)}, data.attrs)
    return found.assign(noise=data["noise"].sel(channel=channel))


def _checked_way(data: xr.Dataset, align: str, periods: int | None) -> bool:
    """Whether periods are laid over each other."""
    if align not in _WAYS:
        raise OptionError(unknown_choice("align", align, _WAYS))
    if periods is not None and (align == "time" or periods < 1):
        raise OptionError(
            f"periods = {periods}: give a number of at least 1, together with align='phase'"
        )
    if align == "phase" and marks_of(data).size < 2:
        raise OptionError(
            "align = 'phase': the record has no two marks, and its system no two periods in that"
            " time; give align='time'"
        )
    return align == "phase"


def _draw_times(ax: Axes, panel: Axes, shown: xr.Dataset) -> None:
    """Over time, with a ground behind what was held back."""
    time, held = shown["time"].values, shown["held_back"].values
    ax.plot(time, shown["measured"].values, **_DOT, color=MEASURED, label="measured")
    ax.plot(*_broken(time, shown["fitted"].values), **LINES[0] | {"linewidth": 0.8},
            label="fitted")  # fmt: skip
    panel.plot(time, shown["residual"].values, **_DOT | {"markersize": 1.5}, color="black")
    if held.any():
        for each in (ax, panel):
            each.axvspan(
                time[held][0], time[-1], color=PALETTE["sky"], alpha=0.25, linewidth=0.0, zorder=0,
                label="held back",
            )  # fmt: skip
    ax.set_xlim(time[0], time[-1])


def _broken(time: Floats, fitted: Floats) -> tuple[Floats, Floats]:
    """A curve that is broken where samples were left out, since a line would hide what was."""
    good = np.isfinite(fitted)
    time, fitted = time[good], fitted[good]
    steps = np.diff(time)
    usual = float(np.median(steps)) if steps.size else 0.0
    after = np.flatnonzero(steps > _GAP * usual) + 1
    return np.insert(time, after, time[after]), np.insert(fitted, after, np.nan)


def _draw_phases(ax: Axes, panel: Axes, shown: xr.Dataset, periods: int) -> None:
    """Periods over each other; dots of what was held back have their own colour."""
    time, held = shown["time"].values, shown["held_back"].values
    phase = np.mod(turns_of(time, shown), periods)
    for here, colours, label in (
        (~held, (MEASURED, "black"), "measured"), (held, (_HELD, _HELD), "held back")
    ):  # fmt: skip
        if here.any():
            ax.plot(phase[here], shown["measured"].values[here], **_DOT, color=colours[0],
                    label=label)  # fmt: skip
            panel.plot(phase[here], shown["residual"].values[here], **_DOT | {"markersize": 1.5},
                       color=colours[1])  # fmt: skip
    curve = folded(*_broken(time, shown["fitted"].values), shown, periods)
    ax.plot(*curve, **LINES[0] | {"linewidth": 0.6}, label="fitted")
    ax.set_xlim(0.0, float(periods))
