"""Four stages of a period-one orbit: Fig. 9, from the equations of the orbit.

The chapter prints no parameters for the figure; those of Fig. 7(d) are taken.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from nonsmooth import find_orbit, simulate
from nonsmooth.models import moling, progression_start
from nonsmooth.plot import phases, print_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["fig9", "stages"]

_NAMES = {"x": "mass, x", "z": "slider top, z", "v": "slider bottom, v"}
_NUMERALS = ("I", "II", "III", "IV")
_MODES = ("progression", "contact", "no_contact", "contact")
_TEXT = 8  # points, as in the rest of the figure


def stages(
    a: float = 0.3, b: float = 0.15, xi: float = 0.05, omega: float = 0.1
) -> tuple[xr.Dataset, xr.Dataset]:
    """An orbit of the mole that begins with progression, and its start.

    Parameters
    ----------
    a, b, xi, omega : float, optional
        Parameters; those of Fig. 7(d) by default.

    Returns
    -------
    orbit : xarray.Dataset
        From `find_orbit`, the turn cut just where progression begins.
    start : xarray.Dataset
        From `progression_start`.

    Examples
    --------
    >>> orbit, start = stages()
    >>> [round(float(each), 3) for each in orbit["durations"]]
    [8.459, 1.53, 52.806, 0.038]
    """
    system = moling(a=a, b=b, xi=xi, omega=omega)
    orbit = find_orbit(system)
    start = progression_start(orbit)
    # legs on both sides of the section are one
    first = int(np.flatnonzero(orbit["leg_time"].values == start["tau_0"].values[0])[0])
    durations = np.roll(orbit["durations"].values, -first)
    modes = np.roll(orbit["leg_mode"].values, -first)
    if orbit["leg_exit"].values[-1] == "" and durations.size > 1:
        cut = durations.size - 1 - first  # the leg before the section
        durations[cut] += durations[cut + 1]
        durations, modes = np.delete(durations, cut + 1), np.delete(modes, cut + 1)
    flags = orbit["leg_mode"].attrs
    turned = xr.Dataset(
        {
            "durations": ("stage", durations, {"long_name": "duration of each stage"}),
            "stage_mode": ("stage", modes, {**flags, "long_name": "mode of each stage"}),
            "v_per_period": orbit["v_per_period"],
        },
        attrs={**orbit.attrs, "stable": int(orbit["stable"]), "word": orbit["word"].item()},
    )
    return turned, start


def fig9() -> tuple[Figure, xr.Dataset]:
    """Fig. 9: four stages of a periodic response, with the beginning and the end enlarged.

    Returns
    -------
    figure : matplotlib.figure.Figure
        One period from the start of progression, and both of its ends.
    data : xarray.Dataset
        The period over ``time``, ``durations`` of the stages I to IV, and ``psi_0``, ``x_0`` and
        ``y_0`` of Eqs. (18)-(20).

    Examples
    --------
    >>> figure, data = fig9()
    >>> data.attrs["phases"]
    'progression contact no_contact contact'
    """
    orbit, start = stages()
    run = _along(orbit, start)
    switches = np.concatenate([[0.0], np.cumsum(orbit["durations"].values)])
    figure, axes = print_figure(3, 1, width=12.0, height=18.0)
    period = float(switches[-1])
    panels = (
        (f"(a) one period; durations {_told(orbit['durations'].values)}", (0.0, period)),
        ("(b) its beginning: progression and release", (0.0, 1.6 * switches[2])),
        ("(c) its end: impact and progression", (period - 4.0 * (period - switches[3]), period)),
    )
    for ax, (title, window) in zip(axes, panels, strict=True):
        ax.set_xlabel(r"time since progression began, $\tau - \tau_0$")
        ax.set_ylabel("displacement")
        phases(run, list(_NAMES), ax=ax, time_range=window, labels=_NAMES, legend=False)
        ax.set_title(title, loc="left", fontsize=_TEXT)
        _number(ax, switches, window)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside upper center", ncols=3, frameon=False, fontsize=_TEXT
    )
    data = run.assign({name: start[name][0] for name in ("psi_0", "x_0", "y_0")})
    data = data.assign(durations=orbit["durations"])
    data.attrs |= {
        "phases": " ".join(_MODES),
        "note": "parameters of Fig. 7(d); the chapter prints none for Fig. 9",
    }
    return figure, data


def _along(orbit: xr.Dataset, start: xr.Dataset) -> xr.Dataset:
    """The motion along the orbit from the start of progression, where time and v are zero."""
    values = moling().parameter_values
    x, y = float(start["x_0"][0]), float(start["y_0"][0])
    system = moling().with_parameters(phi=float(start["psi_0"][0]))
    state = {"p": x, "y": y, "q": x - values["g"]}
    switches = np.concatenate([[0.0], np.cumsum(orbit["durations"].values)])
    # two contacts last a hundredth of a period or less: samples stand closer round them
    times = [np.linspace(0.0, switches[-1], 1001)]
    times += [np.clip(np.linspace(t - 0.3, t + 0.3, 801), 0.0, switches[-1]) for t in switches]
    return simulate(system, state, mode="progression", times=np.unique(np.concatenate(times)))


def _number(ax: Axes, switches: np.ndarray, window: tuple[float, float]) -> None:
    """Roman numerals of the chapter in the stages that are wide enough to hold them."""
    for numeral, start, end in zip(_NUMERALS, switches[:-1], switches[1:], strict=True):
        low, high = max(start, window[0]), min(end, window[1])
        if high - low > 0.03 * (window[1] - window[0]):
            ax.text(
                0.5 * (low + high), 0.05, numeral, transform=ax.get_xaxis_transform(),
                ha="center", va="bottom", fontsize=_TEXT,
            )  # fmt: skip


def _told(durations: np.ndarray) -> str:
    return ", ".join(f"{n} {d:.4g}" for n, d in zip(_NUMERALS, durations, strict=True))
