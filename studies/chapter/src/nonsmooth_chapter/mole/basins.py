"""Basins of attraction of the mole: Fig. 12.

The chapter prints neither the section that the starts lie on nor the window. Here starts are at a
strobe, tau = 0, at places (p, y) of the mass with the slider top as far out as it admits,
q = max(0, p - g): unloaded, or in touch with the mass.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from nonsmooth import System, basins_of_attraction
from nonsmooth.models import moling
from nonsmooth.plot import basins, print_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["OMEGAS", "SECTION", "WINDOW", "fig12", "oscillator", "section_basins"]

OMEGAS = (1.4, 1.45, 1.56, 1.58, 1.6, 1.7)
WINDOW = {"p": (-3.0, 1.0), "y": (-1.0, 1.0)}
SECTION = {"q": "max(0, p - g)"}
# Numbers, and so colours, that a motion keeps in all panels.
# Chaos is pale, and the others, whose basins are thin, have full colours.
_CHAOS, _PERIOD_FOUR, _OTHERS = 16, 8, (10, 12)
_KINDS = (_PERIOD_FOUR, _CHAOS, *_OTHERS)
_TEXT = 8  # points, as in the rest of the figure


def oscillator(omega: float) -> System:
    """Mole with the data of Fig. 12: a = 0.3, b = 0.1, xi = 0.1.

    Parameters
    ----------
    omega : float
        Frequency of the excitation.

    Returns
    -------
    System

    Examples
    --------
    >>> oscillator(1.4).parameter_values["xi"]
    0.1
    """
    return moling(a=0.3, b=0.1, xi=0.1, omega=omega)


def section_basins(
    omega: float,
    cells: int,
    window: Mapping[str, tuple[float, float]] = WINDOW,
    samples: int = 1000,
) -> xr.Dataset:
    """Basins on the section, on a square grid of cells.

    Parameters
    ----------
    omega : float
        Frequency of the excitation.
    cells : int
        Cells along p and along y.
    window : mapping of str to (float, float), optional
        Range of p and of y.
    samples : int, optional
        Starts from which attractors are sought.

    Returns
    -------
    xarray.Dataset
        Result of `nonsmooth.basins_of_attraction`.

    Examples
    --------
    >>> basins = section_basins(1.4, 4, samples=100)
    >>> sorted(basins["period"].values.tolist())
    [0, 4]
    """
    grid = {name: _centres(*ends, cells) for name, ends in window.items()}
    return basins_of_attraction(oscillator(omega), grid, completion=SECTION, samples=samples)


def _centres(low: float, high: float, cells: int) -> np.ndarray:
    return low + (high - low) * (np.arange(cells) + 0.5) / cells


def fig12(cells: int = 300, samples: int = 1000) -> tuple[Figure, xr.Dataset]:
    """Fig. 12: basins of attraction for six frequencies.

    Parameters
    ----------
    cells : int, optional
        Cells of each panel along p and along y.
    samples : int, optional
        Starts from which the attractors of each panel are sought.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Panels (a) to (f). A colour means one kind of motion in all of them: pale orange chaos,
        blue period four, green and purple another period.
    data : xarray.Dataset
        Over ``omega``: ``label`` (over ``y`` and ``p``), and ``period``, ``kind``, ``fraction`` and
        ``points`` over ``attractor``, whose numbers are 16 for chaos, 8 for period four, 10 and 12
        for others, the larger basin first; period -1 where a panel has no such motion.

    Examples
    --------
    >>> figure, data = fig12(cells=4, samples=60)
    >>> data["label"].dims, len(figure.axes)
    (('omega', 'y', 'p'), 6)
    """
    figure, axes = print_figure(3, 2, width=16.0, height=18.0)
    kept = []
    for k, (omega, ax) in enumerate(zip(OMEGAS, axes, strict=True)):
        data = _numbered_by_kind(section_basins(omega, cells, samples=samples))
        basins(data, ax=ax)
        ax.text(
            0.02, 0.03, f"({'abcdef'[k]}) $\\omega$ = {omega:.2f}", transform=ax.transAxes,
            fontsize=_TEXT, bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.5},
        )  # fmt: skip
        key = ax.get_legend()
        for text in key.get_texts() if key else ():  # numbers mean nothing to a reader here
            text.set_text(text.get_text().partition(": ")[2])
        ax.set_xlabel("displacement, p" if k >= 4 else "")
        ax.set_ylabel("velocity, y" if k % 2 == 0 else "")
        kept.append(_all_kinds(data))
    data = xr.concat(kept, xr.DataArray(list(OMEGAS), dims="omega", name="omega"))
    data["points"].encoding = {"zlib": True}  # mostly padding
    # systems differ between panels
    first = kept[0].attrs
    data.attrs = {name: first[name] for name in ("system_name", "completion", "nonsmooth_version")}
    data.attrs |= {"a": 0.3, "b": 0.1, "xi": 0.1, "phase": 0.0, "samples": samples}
    return figure, data


def _numbered_by_kind(data: xr.Dataset) -> xr.Dataset:
    """The same with one number for one kind of motion, whatever the panel."""
    order = data["attractor"].values[np.argsort(-data["fraction"].values, kind="stable")]
    spare = [*_OTHERS, *range(max(_KINDS) + 1, max(_KINDS) + 1 + len(order))]
    numbers: dict[int, int] = {}
    for one in order:
        period = int(data["period"].sel(attractor=one))
        number = {0: _CHAOS, 4: _PERIOD_FOUR}.get(period, spare[0])
        if number in numbers.values():  # a second one of its kind
            number = spare[0]
        if number == spare[0]:
            spare.pop(0)
        numbers[int(one)] = number
    label = data["label"].copy()
    for one, number in numbers.items():
        label.values[data["label"].values == one] = number
    renamed = data.assign(label=label)
    return renamed.assign_coords(attractor=[numbers[int(k)] for k in data["attractor"].values])


def _all_kinds(data: xr.Dataset) -> xr.Dataset:
    """What the panel shows, with every number that some panel has."""
    shown = data[["label", "period", "kind", "fraction", "points"]]
    numbers = sorted({*_KINDS, *data["attractor"].values.tolist()})
    empty = {"period": -1, "kind": "", "fraction": 0.0, "points": np.nan}
    return shown.reindex(attractor=numbers, fill_value=empty)
