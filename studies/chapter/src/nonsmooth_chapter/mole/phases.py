"""The motion of the mole taken apart: phases of a period, and drift against oscillation.

The chapter prints the parameters of neither Fig. 9 nor Fig. 11; both are drawn here for the
period-one motion of Fig. 7(d).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from nonsmooth import phase_word, simulate
from nonsmooth.models import moling
from nonsmooth.plot import phases, print_figure, time_history

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["fig11", "period_one_phases"]

_TIME = r"time, $\tau$"
_NAMES = {"x": "mass, x", "z": "slider top, z", "v": "slider bottom, v"}
_PROGRESSION = 2  # number of the mode
_TEXT = 8  # points, as in the rest of the figure
_SETTLED = 40  # periods; this motion settles to rounding within twenty


def fig11(b: float = 0.15) -> tuple[Figure, xr.Dataset]:
    """Fig. 11: drifting motion, bounded oscillation p, and progression v.

    Parameters
    ----------
    b : float, optional
        Static force; the chapter does not print the parameters of this figure.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Three panels.
    data : xarray.Dataset
        The run from rest.

    Examples
    --------
    >>> figure, data = fig11()
    >>> len(figure.axes)
    3
    """
    run = simulate(moling(b=b), periods=12)
    figure, axes = print_figure(3, 1, width=12.0, height=15.0, share_x=True)
    panels = (
        (["x", "v"], "displacement", "(a) drifting motion"),
        (["p"], "p = x - v", "(b) bounded oscillation of the mass"),
        (["v"], "v", "(c) progression of the slider bottom"),
    )
    for ax, (names, label, title) in zip(axes, panels, strict=True):
        ax.set_ylabel(label)
        ax.set_xlabel(_TIME)
        time_history(run, names, ax=ax, labels=_NAMES, legend=False)
        ax.set_title(title, loc="left", fontsize=_TEXT)
    axes[2].lines[0].set(**{name: axes[0].lines[1].properties()[name] for name in _LOOK})
    for ax in axes[:-1]:
        ax.set_xlabel("")
    axes[0].legend(loc="upper left", frameon=False, fontsize=_TEXT)
    run.attrs["note"] = f"parameters of Fig. 7, b = {b:g}; the chapter prints none for this figure"
    return figure, run


_LOOK = ("color", "linestyle", "linewidth")  # one curve looks the same in both panels


def period_one_phases(b: float = 0.15) -> tuple[Figure, xr.Dataset]:
    """Phases of one period of a period-one motion, as in Fig. 9, with both contacts enlarged.

    Parameters
    ----------
    b : float, optional
        Static force; the chapter does not print the parameters of Fig. 9.

    Returns
    -------
    figure : matplotlib.figure.Figure
        One period from the beginning of progression, and blow-ups of its two contacts.
    data : xarray.Dataset
        The period and its event log; time and drift are zero where it begins.

    Examples
    --------
    >>> figure, data = period_one_phases()
    >>> data.attrs["phases"]
    'progression contact no_contact contact'
    """
    run = _one_period(b)
    began, left, released, hit = run["event_time"].values[:4]
    ended = float(run["time"][-1])
    figure, axes = print_figure(3, 1, width=12.0, height=18.0)
    panels = (
        ("(a) one period", (began, ended)),
        ("(b) end of progression", (2.5 * left - 1.5 * released, 2.5 * released - 1.5 * left)),
        ("(c) impact", (2.0 * hit - ended, ended)),
    )
    numerals = dict(zip((began, left, released, hit), ("I", "II", "III", "IV"), strict=True))
    for ax, (title, window) in zip(axes, panels, strict=True):
        ax.set_xlabel(r"time since progression began, $\tau - \tau_0$")
        ax.set_ylabel("displacement")
        phases(run, list(_NAMES), ax=ax, time_range=window, labels=_NAMES, legend=False)
        ax.set_title(title, loc="left", fontsize=_TEXT)
        _number_phases(ax, numerals, window)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside upper center", ncols=3, frameon=False, fontsize=_TEXT
    )
    return figure, run


def _one_period(b: float) -> xr.Dataset:
    """One period of the settled motion from the beginning of progression, where v is zero."""
    system = moling(b=b)
    settled = simulate(system, simulate(system, periods=_SETTLED), periods=2)
    begins = settled["event_to"].values == _PROGRESSION
    first = int(np.flatnonzero(begins & (settled["event_kind"].values != "start"))[0])
    state = dict(zip("pyq", settled["state_after"].values[first], strict=False))
    # the phase of the forcing is moved, so that time counts from the beginning of progression
    values = system.parameter_values
    phase = values["phi"] + values["omega"] * float(settled["event_phase"][first])
    system = system.with_parameters(phi=phase)
    # two contacts last a hundredth of a period or less: samples stand closer round them
    switches = settled["event_time"].values[first : first + 5]
    switches = switches - switches[0]
    period = settled.attrs["period"]
    times = np.concatenate(
        [np.linspace(0.0, period, 1001)]
        + [np.linspace(max(0.0, t - 1.0), min(period, t + 1.0), 2001) for t in switches]
    )
    run = simulate(system, state, mode="progression", times=np.unique(times))
    run.attrs["phases"] = " ".join(phase_word(run, 0.0, (1.0 - 1e-9) * period))
    run.attrs["note"] = f"parameters of Fig. 7, b = {b:g}; the chapter prints none for Fig. 9"
    return run


def _number_phases(ax: Axes, numerals: dict[float, str], window: tuple[float, float]) -> None:
    """Roman numerals of the chapter in the phases that are wide enough to hold them."""
    edges = [*numerals, float("inf")]
    for (start, numeral), end in zip(numerals.items(), edges[1:], strict=True):
        low, high = max(start, window[0]), min(end, window[1])
        if high - low > 0.03 * (window[1] - window[0]):
            ax.text(
                0.5 * (low + high), 0.05, numeral, transform=ax.get_xaxis_transform(),
                ha="center", va="bottom", fontsize=_TEXT,
            )  # fmt: skip
