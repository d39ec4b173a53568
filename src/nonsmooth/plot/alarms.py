"""Windows of a watched machine: their scores with the threshold, and how well a score tells."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.style import LINES, PALETTE, axis_label, finish_axes, plain_numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["alarm", "roc"]

_BELOW: dict[str, Any] = {
    "linestyle": "none", "marker": ".", "markersize": 3.5, "color": "0.45",
    "markeredgewidth": 0.0,
}  # fmt: skip
# of windows above the threshold, by the indicator that leads: colour and shape, either is enough
_MARKS = tuple(zip("os^Dv", ("vermilion", "blue", "green", "purple", "orange"), strict=True))
_OTHERS = {"marker": "x", "color": "black"}
_PALE = 0.12  # opacity of an interval
_CURVE = "roc"  # group of the lines that are curves


@checked
def alarm(found: xr.Dataset, *, ax: Axes | None = None, legend: bool = True) -> Axes:
    """Scores of watched windows over time, with the threshold and the first alarm.

    Windows above the threshold have a mark for the indicator that is farthest from its healthy
    mean.

    Parameters
    ----------
    found : xarray.Dataset
        Result of `measured.alarm` with watched windows.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, logarithmic upwards. They go over the ``time`` of the windows where it increases,
        and else over their number.

    Raises
    ------
    OptionError
        For another dataset, or an alarm without watched windows.

    See Also
    --------
    roc : how well the score tells healthy windows from others.

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> import nonsmooth as ns
    >>> noise = np.random.default_rng(0).normal(size=600)
    >>> healthy = xr.Dataset({"second": ("window", noise[:500])})
    >>> watched = xr.Dataset({"second": ("window", noise[500:] + np.linspace(0, 6, 100))})
    >>> ax = ns.plot.alarm(ns.measured.alarm(healthy, watched))
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('window', 'distance from healthy windows')
    """
    if not {"score", "threshold", "exceeded", "leading"} <= set(found.variables):
        raise OptionError("found: give a result of measured.alarm with watched= windows")
    ax = new_axes() if ax is None else ax
    scores, above = found["score"].values, found["exceeded"].values
    over, label = np.arange(1.0, scores.size + 1.0), "window"
    if "time" in found.coords and np.all(np.diff(found["time"].values) > 0.0):
        over, label = found["time"].values, axis_label(found["time"])
    ax.set_yscale("log")
    ax.plot(over[~above], scores[~above], **_BELOW, label="below the threshold")
    leading = found["leading"].values[above]
    names, counts = np.unique(leading, return_counts=True)
    named = [str(name) for name in names[np.argsort(-counts, kind="stable")][: len(_MARKS)]]
    for name, (marker, colour) in zip(named, _MARKS, strict=False):
        here = np.flatnonzero(above)[leading == name]
        style = {"marker": marker, "color": PALETTE[colour]}
        ax.plot(over[here], scores[here], **_mark(style), label=f"leading: {name}")
    rest = np.flatnonzero(above)[~np.isin(leading, named)]
    if rest.size:
        ax.plot(over[rest], scores[rest], **_mark(_OTHERS), label="leading: another one")
    limit = {**LINES[0], "linestyle": "--"}
    ax.axhline(float(found["threshold"]), **limit, label=f"threshold for {found.attrs['rate']:g}")
    first = int(found["first_alarm"])
    if first >= 0:
        ax.axvline(over[first], **LINES[2], label="first alarm")
    plain_numbers(ax.yaxis)
    finish_axes(ax, label, axis_label(found["score"]))
    if legend:
        place_legend(ax)
    return ax


def _mark(style: dict[str, Any]) -> dict[str, Any]:
    return {"linestyle": "none", "markersize": 3.5, "markeredgewidth": 0.6, **style}


@checked
def roc(
    data: xr.Dataset,
    *,
    ax: Axes | None = None,
    label: str | None = None,
    logarithmic: bool = False,
    legend: bool = True,
) -> Axes:
    """Detections against false alarms, with the 95 % interval of the detections.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `measured.roc`.
    ax : matplotlib.axes.Axes, optional
        Where to draw, also beside curves that were drawn before; new axes of a column's width by
        default.
    label : str, optional
        What the legend calls the curve, before its area.
    logarithmic : bool, optional
        Whether the axis of false alarms is logarithmic, since small rates are those that matter.
    legend : bool, optional
        Whether to draw a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    OptionError
        For another dataset.

    See Also
    --------
    alarm : one threshold, over time.

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> import nonsmooth as ns
    >>> noise = np.random.default_rng(0).normal(size=600)
    >>> healthy = xr.Dataset({"second": ("window", noise[:500])})
    >>> faulty = xr.Dataset({"second": ("window", noise[500:] + 3.0)})
    >>> ax = ns.plot.roc(ns.measured.roc(healthy, faulty), label="3 sigma")
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('rate of false alarms', 'rate of detections')
    """
    if not {"false_alarms", "detections", "detections_low", "area"} <= set(data.variables):
        raise OptionError("data: give a result of measured.roc")
    ax = new_axes() if ax is None else ax
    curves = [line for line in ax.lines if line.get_gid() == _CURVE]
    if not curves:
        chance = np.linspace(0.0, 1.0, 200) if not logarithmic else np.geomspace(1e-6, 1.0, 200)
        ax.plot(chance, chance, color="0.6", linewidth=0.8, linestyle=(0, (1, 1)), label="chance")
    style = LINES[len(curves) % len(LINES)]
    false, seen = data["false_alarms"].values, data["detections"].values
    area = f"area {float(data['area']):.3f}"
    ax.plot(
        false, seen, **style, gid=_CURVE, drawstyle="steps-post",
        label=area if label is None else f"{label}, {area}",
    )  # fmt: skip
    ax.fill_between(
        false, data["detections_low"].values, data["detections_high"].values, step="post",
        color=style["color"], alpha=_PALE, linewidth=0.0,
    )  # fmt: skip
    if logarithmic:
        least = 0.5 / max(int(data.attrs["n_healthy"]), 1)
        before = float(ax.get_xlim()[0]) if curves else 1.0
        ax.set(xscale="log", xlim=(min(least, before), 1.0))
    else:
        ax.set(xlim=(-0.01, 1.0))
    ax.set_ylim(0.0, 1.02)
    finish_axes(ax, axis_label(data["false_alarms"]), axis_label(data["detections"]))
    if legend:
        place_legend(ax)
    return ax
