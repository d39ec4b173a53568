"""`translation`: the plane in which the 0-1 test sees chaos wander."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import new_axes
from nonsmooth.plot.style import LINES, axis_label, finish_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["translation"]


def translation(test: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Translation p, q of the 0-1 test: bounded for regular motion, wandering for chaotic motion.

    Parameters
    ----------
    test : xarray.Dataset
        Result of `zero_one_test`.
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a column's width by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, with K as their title.

    Raises
    ------
    OptionError
        For another dataset.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.duffing(), periods=400, samples_per_period=1)
    >>> ax = ns.plot.translation(ns.zero_one_test(run, "x", transient=50))
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('p', 'q')
    """
    if "p" not in test or "q" not in test or "K" not in test:
        raise OptionError("the dataset has no translation; give a result of zero_one_test")
    ax = new_axes() if ax is None else ax
    style = LINES[0] | {"linewidth": 0.4}
    ax.plot(test["p"].values, test["q"].values, **style)
    ax.set_aspect("equal", adjustable="datalim")
    size = ax.xaxis.label.get_fontsize()
    low, high = float(test["K_low"]), float(test["K_high"])
    ax.set_title(f"K = {float(test['K']):.3f} ({low:.3f} to {high:.3f})", fontsize=size)
    names = (axis_label(test[name].assign_attrs(long_name=name)) for name in ("p", "q"))
    finish_axes(ax, *names)
    return ax
