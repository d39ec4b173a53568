"""Crack length over time: Figs. 18-20 (Table 3) and 21, 22 (chaotic and harmonic shaking)."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from scipy.interpolate import PchipInterpolator

from nonsmooth.fatigue import CrackCurve, LoadBlock, Specimen, chapter_tests, life
from nonsmooth.plot import PALETTE, place_legend, print_figure
from nonsmooth_chapter.fatigue.chaotic_loads import (
    DAMPINGS,
    RIGS,
    WAVES,
    curves,
    fitted_law,
    spread,
    stated_lives,
)
from nonsmooth_chapter.fatigue.crack_motions import RATE, tau_at

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["fig18", "fig19", "fig20", "fig21", "fig22"]

_TEXT = 8
_FIRST, _LAST = 6.4, 19.0  # mm; the last is ours, 1 mm short of the width
_POINTS = 400
_FREE = 3  # constants of the fitted law
_SCATTER_AT = 18.0  # mm; the bars beside each curve stand below the dots
_COLOURS = {  # of a test, in each figure that shows it
    "hl0(100)": "black",
    "hl100(100)": PALETTE["blue"],
    "hl150(100)": PALETTE["vermilion"],
    "hl200(100)": PALETTE["green"],
    "hl0(78.5)": PALETTE["orange"],
    "hl0(273.5)": PALETTE["purple"],
    "hl150(50)": PALETTE["sky"],
}
_TESTS = {
    "fig18": ("hl0(100)", "hl100(100)", "hl150(100)", "hl200(100)"),
    "fig19": ("hl0(78.5)", "hl0(100)", "hl0(273.5)"),
    "fig20": ("hl150(50)", "hl150(100)"),
}
_NOTE = (
    "The measured curves are not available. Dots: lives of Table 3, drawn at 19 mm, a length"
    " that is ours.\nFull: Walker's law, fitted in sample to the eight lives. Broken: Eq. (49)"
    " from 6.4 mm to the dot; of its\nconstants only those of Fig. 30 are printed, from which its"
    " sharpness is taken."
)


def fig18() -> tuple[Figure, xr.Dataset]:
    """Fig. 18: crack length over time at an amplitude of 100 N, four mean loads.

    Returns
    -------
    figure : matplotlib.figure.Figure
        End points of Table 3 and model curves; the measured curves are not available.
    data : xarray.Dataset
        ``time`` of the fitted law and ``time_49`` of Eq. (49), in s, over ``test`` and ``crack``;
        ``life`` measured; ``scatter``, the factor between lives and their fits.

    Examples
    --------
    >>> figure, data = fig18()
    >>> data["life"].values.tolist()
    [9191.0, 1628.0, 547.0, 331.0]
    """
    return _table_3("fig18", "fixed amplitude of 100 N")


def fig19() -> tuple[Figure, xr.Dataset]:
    """Fig. 19: the same at a mean load of zero, three amplitudes.

    Returns
    -------
    figure : matplotlib.figure.Figure
        As of `fig18`.
    data : xarray.Dataset
        As of `fig18`.
    """
    return _table_3("fig19", "fixed mean load of 0 N")


def fig20() -> tuple[Figure, xr.Dataset]:
    """Fig. 20: the same at a mean load of 150 N, two amplitudes.

    Returns
    -------
    figure : matplotlib.figure.Figure
        As of `fig18`.
    data : xarray.Dataset
        As of `fig18`.
    """
    return _table_3("fig20", "fixed mean load of 150 N")


def _table_3(name: str, title: str) -> tuple[Figure, xr.Dataset]:
    tests = chapter_tests().sel(test=list(_TESTS[name]))
    cracks = np.linspace(_FIRST, _LAST, _POINTS)
    fitted, by_49 = [], []
    for mean, size, measured in zip(
        tests["mean_load"].values, tests["load_amplitude"].values, tests["life"].values, strict=True
    ):
        load = LoadBlock.constant_amplitude(float(mean), float(size), 20.0)
        grown = life(Specimen().stress_intensity, fitted_law(), load, initial=_FIRST, final=_LAST)
        times = grown["time"].values
        fitted.append(np.interp(cracks, grown["crack"].values, times))
        by_49.append(_curve_49(float(measured)).time(cracks[1:]))
    data = xr.Dataset(
        {
            "time": (("test", "crack"), np.array(fitted),
                     {"long_name": "time by Walker's law, fitted in sample", "units": "s"}),
            "time_49": (("test", "crack"), np.pad(by_49, ((0, 0), (1, 0))),
                        {"long_name": "time by Eq. (49)", "units": "s"}),
            "life": tests["life"],
            "scatter": ((), fit_scatter(), {"long_name": "factor of one standard deviation"}),
        },
        {"test": list(_TESTS[name]),
         "crack": ("crack", cracks, {"long_name": "crack length", "units": "mm"})},
        {"law": repr(fitted_law()), "note": _NOTE},
    )  # fmt: skip
    return _drawn(data, tests, title), data


@lru_cache(maxsize=1)
def fit_scatter() -> float:
    """Factor by which measured and fitted lives differ: one standard deviation, eight tests.

    Returns
    -------
    float

    Examples
    --------
    >>> round(fit_scatter(), 1)
    1.8
    """
    tests = chapter_tests()
    ratios = [
        float(measured) / fitted_life(float(mean), float(size))
        for mean, size, measured in zip(
            tests["mean_load"].values, tests["load_amplitude"].values, tests["life"].values,
            strict=True,
        )
    ]  # fmt: skip
    degrees = len(ratios) - _FREE
    return float(np.exp(np.sqrt(np.sum(np.log(ratios) ** 2) / degrees)))


def fitted_life(mean: float, size: float) -> float:
    """Time in s to the last length by the fitted law.

    Parameters
    ----------
    mean, size : float
        Mean load and amplitude, in N.

    Returns
    -------
    float

    Examples
    --------
    >>> fitted_life(0.0, 100.0) > fitted_life(100.0, 100.0)
    True
    """
    load = LoadBlock.constant_amplitude(mean, size, 20.0)
    grown = life(Specimen().stress_intensity, fitted_law(), load, initial=_FIRST, final=_LAST)
    return float(grown["time"].values[-1])


def _explain_lines(ax: Axes) -> None:
    """Entries of the legend for the kinds of lines, whatever their colour."""
    grey: dict[str, Any] = {"color": "0.4"}
    ax.plot([], [], **grey, linewidth=1.4, label="Walker's law, fitted")
    ax.plot([], [], **grey, linewidth=1.1, linestyle="--", label="Eq. (49) to the measured life")
    ax.plot([], [], "|-", **grey, linewidth=0.8, markersize=4, label="scatter of the eight fits")


def _curve_49(measured: float) -> CrackCurve:
    """Eq. (49) through both ends of a test, as sharp as that of Fig. 30 from its notch on."""
    growth = RATE / tau_at(_LAST)
    a3 = growth * measured
    start = 1.0 / growth
    # a0 such that the first length is met at time 0
    a0 = (_FIRST - _LAST * np.exp(-start)) / (1.0 - np.exp(-start))
    return CrackCurve(a0, 1.0, measured - a3 * float(np.log(_LAST - a0)), a3)


def _drawn(data: xr.Dataset, tests: xr.Dataset, title: str) -> Figure:
    figure, (ax,) = print_figure(1, 1, width=16.0, height=9.5)
    factor = float(data["scatter"])
    for k, test in enumerate(data["test"].values):
        colour = _COLOURS[str(test)]
        mean, size = (float(tests[n][k]) for n in ("mean_load", "load_amplitude"))
        measured = float(data["life"][k])
        ax.plot(data["time"][k], data["crack"], color=colour, linewidth=1.4)
        ends = float(data["time"][k, -1]) * factor ** np.array([-1.0, 0.0, 1.0])
        ax.plot(
            ends, np.full(3, _SCATTER_AT - 0.5 * k), "|-", color=colour, linewidth=0.8, markersize=4
        )
        ax.plot(data["time_49"][k], data["crack"], color=colour, linewidth=1.1, linestyle="--")
        label = f"({'abcd'[k]}) mean {mean:g} N, amplitude {size:g} N: {measured:g} s"
        ax.plot(measured, _LAST, "o", color=colour, markersize=6, label=label, clip_on=False)
        ax.annotate(f"({'abcd'[k]})", (measured, _LAST), (0, 5), textcoords="offset points",
                    ha="center", fontsize=_TEXT)  # fmt: skip
    ax.set_xscale("log")
    ax.set_xlim(30.0, 1e5)
    ax.set_ylim(5.0, 20.6)
    ax.axhline(_FIRST, color="0.7", linewidth=0.6, linestyle=":", zorder=0)
    ax.annotate("6.4 mm, pre-crack at time 0", (33.0, _FIRST), (0, -9),
                textcoords="offset points", fontsize=7)  # fmt: skip
    ax.set_xlabel("time [s]")
    ax.set_ylabel("crack length [mm]")
    ax.set_title(title, loc="left", fontsize=_TEXT)
    _explain_lines(ax)
    place_legend(ax)
    figure.supxlabel(_NOTE, fontsize=7, ha="left", x=0.01)
    return figure


def fig21(
    waves: tuple[str, ...] = tuple(WAVES), dampings: tuple[float, ...] = DAMPINGS
) -> tuple[Figure, xr.Dataset]:
    """Fig. 21: crack length under harmonic and chaotic shaking of equal power, mean load zero.

    Parameters
    ----------
    waves : tuple of str, optional
        Waves of the spread, by name.
    dampings : tuple of float, optional
        Damping ratios of the spread.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Time over the harmonic life: the stated case, the spread over what the chapter does not
        give, and the printed ratio.
    data : xarray.Dataset
        ``harmonic`` and ``chaotic``, times in s over ``crack``, and the spread of the ratios.

    Examples
    --------
    >>> figure, data = fig21(waves=("Ueda, displacement",), dampings=(0.392,))
    >>> bool(data["ratio_least"] < data["ratio_stated"] < data["ratio_most"])
    True
    """
    return _shaken(0.0, 4.0, waves, dampings)


def fig22(
    waves: tuple[str, ...] = tuple(WAVES), dampings: tuple[float, ...] = DAMPINGS
) -> tuple[Figure, xr.Dataset]:
    """Fig. 22: the same at a mean load of 150 N.

    Parameters
    ----------
    waves, dampings : optional
        As of `fig21`.

    Returns
    -------
    figure : matplotlib.figure.Figure
        As of `fig21`.
    data : xarray.Dataset
        As of `fig21`.
    """
    return _shaken(150.0, 56.0, waves, dampings)


def _shaken(
    mean: float, printed: float, waves: tuple[str, ...], dampings: tuple[float, ...]
) -> tuple[Figure, xr.Dataset]:
    first, second = curves(mean)
    every = np.concatenate(
        [spread(rig, waves, dampings)["ratio"].sel(mean_load=mean).values.ravel() for rig in RIGS]
    )
    low, top = float(first["crack"][0]), float(first["crack"][-1])
    cracks = low + (top - low) * np.concatenate([[0.0], np.geomspace(1e-4, 1.0, _POINTS)])
    seconds = {"units": "s"}
    data = xr.Dataset(
        {
            **{
                name: ("crack", PchipInterpolator(part["crack"], part["time"])(cracks), seconds)
                for name, part in (("harmonic", first), ("chaotic", second))
            },
            "ratio_stated": ((), float(stated_lives(mean)["ratio"])),
            "ratio_least": ((), float(every.min())),
            "ratio_most": ((), float(every.max())),
            "ratio_printed": ((), printed),
            "ratios": ("case", np.sort(every)),
        },
        {"crack": ("crack", cracks, {"long_name": "crack length", "units": "mm"})},
        {"mean_load": mean, "law": str(first.attrs["law"])},
    )
    return _shaken_figure(data, mean, printed), data


def _shaken_figure(data: xr.Dataset, mean: float, printed: float) -> Figure:
    figure, (ax,) = print_figure(1, 1, width=16.0, height=9.5)
    end = float(data["harmonic"][-1])
    top = float(data["crack"][-1])
    styles: dict[str, dict[str, Any]] = {
        "chaotic": {"color": PALETTE["vermilion"], "linewidth": 1.6,
                    "label": "(a) Duffing excitation, stated case"},
        "harmonic": {"color": "black", "linewidth": 1.6, "label": "(b) harmonic excitation"},
    }  # fmt: skip
    for name, style in styles.items():
        ax.plot(data[name].values / end, data["crack"].values, **style)
    ax.plot(
        1.0 / data["ratios"].values, np.full(data.sizes["case"], top + 0.35), "|", color="0.35",
        markersize=8, label="(a) ends for other waves, dampings, powers, laws",
    )  # fmt: skip
    ax.plot(1.0 / printed, top + 0.8, "v", color=PALETTE["blue"], markersize=7,
            label=f"(a) ends if the lives differ {printed:g} times, as printed")  # fmt: skip
    ax.set_xscale("log")
    ax.set_xlim(4e-4, 3.0)
    ax.set_ylim(6.0, top + 1.3)
    ax.set_xlabel("time over the harmonic life")
    ax.set_ylabel("crack length [mm]")
    ax.set_title(f"mean load {mean:g} N, base accelerations of equal power", loc="left",
                 fontsize=_TEXT)  # fmt: skip
    ax.legend(frameon=False, fontsize=7, loc="center left")
    figure.supxlabel(
        "The measured curves are not available. Model: rig of Fig. 25 as one mass, 100 N at 6.4 mm"
        " under the sine, Ueda's wave,\nWalker's law with handbook constants (harmonic life"
        f" {float(f'{end:.2g}'):,.0f} s from 6.4 to {top:g} mm). The chapter gives\nneither wave,"
        " damping nor measure of power.",
        fontsize=7, ha="left", x=0.01,
    )  # fmt: skip
    return figure
