"""`corner`: the parameters of a fit in pairs, with ellipses and what was drawn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.plot.figures import divided, new_axes
from nonsmooth.plot.fitted_parameters import chosen_parameters, legend_of_panels
from nonsmooth.plot.style import PALETTE, finish_axes
from nonsmooth.plot.ticks import set_numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["corner"]

Floats = npt.NDArray[np.float64]

_SIDE = 3.2  # of a panel in a figure of our own, in cm
_LEAST_SIDE = 8.0  # of that figure
_JOINT = 5.991464547107979, 2.295748928898636  # of chi square, two degrees: 95 % and 68.27 %
_VIEW = 3.3  # standard deviations on either side
_TAIL = 0.003  # part of the draws that may lie outside on either side
_MOST = 2000  # draws of each kind that are shown as dots
_BARS = 10, 24  # of a histogram, at least and at most
_POINTS = 200


class _Draws(NamedTuple):
    """Draws (K, n) of all parameters shown, and how they look."""

    label: str
    colour: str
    values: Floats


@checked
def corner(
    data: xr.Dataset,
    parameters: str | Sequence[str] | None = None,
    *,
    posterior: xr.Dataset | None = None,
    ax: Axes | None = None,
) -> list[Axes]:
    """Parameters of a fit in pairs: how they hang together.

    Below the diagonal each panel has the estimate of two parameters and the ellipses that hold 68 %
    and 95 % of a normal density with the covariance of the fit. On the diagonal stands that density
    of one parameter, on the ground of its 95 % interval from the profile. Dots and histograms are
    the estimates of the bootstrap, where the fit has some, and draws of a posterior. Above the
    diagonal stand the correlations.

    Parameters
    ----------
    data : xarray.Dataset
        Result of `fit`.
    parameters : str or list of str, optional
        Which of them to draw; all by default.
    posterior : xarray.Dataset, optional
        Result of `posterior` for this fit.
    ax : matplotlib.axes.Axes, optional
        Where to draw, axes of a grid, whose place the panels share; a new figure by default.

    Returns
    -------
    list of matplotlib.axes.Axes
        The panels of the lower triangle, row by row; the last one of each row is on the diagonal.

    Raises
    ------
    OptionError
        For another dataset or an unknown parameter.

    Notes
    -----
    Draws that leave the ellipses tell that the record determines the parameters less simply than a
    covariance can say: the posterior, or the profile of each parameter, is then the better measure.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.linspace(0, 20, 200)
    >>> noise = 0.01 * np.random.default_rng(1).standard_normal(t.size)
    >>> x = 0.5 * np.exp(-0.1 * t) * np.cos(2 * t) + noise
    >>> record = ns.measured.from_arrays({"x": x}, times=t)
    >>> spring = ns.System(
    ...     states=["x", "v"],
    ...     parameters={"k": 3.0, "c": 0.1},
    ...     equations={"x": "v", "v": "-k*x - c*v"},
    ... )
    >>> found = ns.fit(spring, record, {"k": (1, 9), "c": (0, 1)}, starts=1)
    >>> panels = ns.plot.corner(found)
    >>> len(panels), panels[1].get_xlabel(), panels[1].get_ylabel()
    (3, 'k', 'c')
    """
    names = chosen_parameters(data, parameters, {"covariance", "correlation"})
    draws = _draws_of(data, posterior, names)
    count = len(names)
    if ax is None:
        side = max(_SIDE * count, _LEAST_SIDE)
        ax = new_axes(width=side, height=side)
    grid = np.array(divided(ax, count, count), dtype=object).reshape(count, count)
    views = [_view(data.sel(parameter=name), [d.values[:, k] for d in draws])
             for k, name in enumerate(names)]  # fmt: skip
    shown = []
    for i, below in enumerate(names):
        for j, across in enumerate(names):
            panel = grid[i, j]
            if j > i:
                _write_correlation(panel, data, below, across)
                continue
            shown.append(panel)
            if i == j:
                _draw_one(panel, data.sel(parameter=below), [(d, d.values[:, i]) for d in draws],
                          views[i])  # fmt: skip
            else:
                _draw_pair(panel, data, (across, below), [(d, d.values[:, [j, i]]) for d in draws])
                panel.set_ylim(views[i])
            panel.set_xlim(views[j])
            _label(panel, across if i == count - 1 else "", below if j == 0 < i else "")
            if i == j:
                panel.set_yticks([])
    legend_of_panels(shown)
    return shown


def _draws_of(data: xr.Dataset, posterior: xr.Dataset | None, names: list[str]) -> list[_Draws]:
    """What was drawn of the parameters shown, the bootstrap first."""
    found = []
    if posterior is not None:
        if "posterior_value" not in posterior or not set(names) <= set(
            posterior["parameter"].values.tolist()
        ):
            raise OptionError(
                f"posterior: give a result of posterior with the parameters {', '.join(names)}"
            )
        values = posterior["posterior_value"].sel(parameter=names)
        flat = values.transpose("draw", "walker", "parameter").values.reshape(-1, len(names))
        found.append(_Draws("posterior", PALETTE["blue"], flat))
    if "bootstrap_estimate" in data:
        values = data["bootstrap_estimate"].sel(parameter=names).transpose("draw", "parameter")
        found.append(_Draws("bootstrap", PALETTE["vermilion"], values.values))
    return found


def _view(one: xr.Dataset, drawn: list[Floats]) -> tuple[float, float]:
    """Range of a parameter: that of its density and of nearly all draws, within its bounds."""
    estimate, deviation = float(one["estimate"]), float(one["standard_error"])
    low, high = estimate - _VIEW * deviation, estimate + _VIEW * deviation
    for values in drawn:
        if values.size:
            first, last = np.quantile(values, [_TAIL, 1.0 - _TAIL])
            low, high = min(low, float(first)), max(high, float(last))
    low, high = max(low, float(one["lower_bound"])), min(high, float(one["upper_bound"]))
    room = 0.03 * (high - low)
    return low - room, high + room


def _draw_one(
    ax: Axes, one: xr.Dataset, draws: list[tuple[_Draws, Floats]], view: tuple[float, float]
) -> None:
    """Density of one parameter."""
    estimate, deviation = float(one["estimate"]), float(one["standard_error"])
    ax.axvspan(float(one["interval_low"]), float(one["interval_high"]), color=PALETTE["sky"],
               alpha=0.25, linewidth=0.0, zorder=0, label="95 % interval of the fit")  # fmt: skip
    for drawn, values in draws:
        count = int(np.clip(len(values) ** 0.5, *_BARS))
        bars = np.linspace(*view, count + 1)
        ax.hist(values, bars.tolist(), density=True, histtype="step", color=drawn.colour,
                linewidth=0.9, label=drawn.label)  # fmt: skip
    across = np.linspace(*view, _POINTS)
    density = np.exp(-0.5 * ((across - estimate) / deviation) ** 2)
    ax.plot(across, density / (deviation * np.sqrt(2.0 * np.pi)), color="black", linewidth=0.9,
            label="normal density of the fit")  # fmt: skip
    ax.set_ylim(bottom=0.0)


def _draw_pair(
    ax: Axes, data: xr.Dataset, pair: tuple[str, str], draws: list[tuple[_Draws, Floats]]
) -> None:
    """Two parameters: draws, ellipses, and the estimate."""
    for drawn, values in draws:
        some = values[:: -(-len(values) // _MOST) or 1]
        ax.plot(
            some[:, 0], some[:, 1], linestyle="none", marker="o", markersize=1.6,
            markeredgewidth=0.0, alpha=0.5, color=drawn.colour, label=drawn.label, rasterized=True,
        )  # fmt: skip
    covariance = data["covariance"].sel(parameter=list(pair), parameter_0=list(pair)).values
    spreads, vectors = np.linalg.eigh(covariance)
    angle = np.linspace(0.0, 2.0 * np.pi, _POINTS)
    circle = np.stack([np.cos(angle), np.sin(angle)])
    middle = data["estimate"].sel(parameter=list(pair)).values
    for level, label in zip(_JOINT, ("its 68 % and 95 %", "_"), strict=True):
        edge = vectors @ (np.sqrt(level * np.maximum(spreads, 0.0))[:, None] * circle)
        ax.plot(*(middle[:, None] + edge), color="black", linewidth=0.9, label=label)
    ax.plot(*middle[:, None], "+", color="black", markersize=6.0, label="estimate")


def _write_correlation(ax: Axes, data: xr.Dataset, one: str, other: str) -> None:
    value = float(data["correlation"].sel(parameter=one, parameter_0=other))
    ax.axis("off")
    text = f"correlation\n{value:.2f}".replace("-", "\N{MINUS SIGN}")
    ax.text(0.5, 0.5, text, transform=ax.transAxes, ha="center", va="center",
            color="0.35", fontsize=ax.xaxis.label.get_fontsize())  # fmt: skip


def _label(ax: Axes, below: str, beside: str) -> None:
    """Numbers and names at the left and at the bottom of the whole only."""
    from matplotlib.ticker import MaxNLocator

    set_numbers(ax)
    ax.yaxis.set_major_locator(MaxNLocator(3, steps=[1, 2, 5, 10]))
    labels: dict[str, Any] = {}
    if not below:
        labels["labelbottom"] = False
    if not beside:
        labels["labelleft"] = False
    ax.tick_params(**labels)
    finish_axes(ax, below or " ", beside or " ")
