"""Which attractors of the mole coexist: by recurrences on several sections, and by cell mapping."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import xarray as xr

from nonsmooth import StroboscopicMap, attractors, basins_of_attraction
from nonsmooth_chapter.judgement import Evidence
from nonsmooth_chapter.mole.basins import SECTION, WINDOW, oscillator

__all__ = ["MORE_SECTIONS", "SECTIONS", "Section", "by_cells", "by_recurrences"]


@dataclass(frozen=True)
class Section:
    """Where starts lie: strobe phase, window, and how the states that it lacks follow.

    Parameters
    ----------
    name : str
        In words.
    phase : float, optional
        Part of the period at which the motion is looked at and starts.
    window : mapping of str to (float, float), optional
        Range of each state that is drawn.
    completion : mapping of str to str, optional
        The others.

    Examples
    --------
    >>> Section("strobe at half a period", phase=0.5).window["y"]
    (-1.0, 1.0)
    """

    name: str
    phase: float = 0.0
    window: Mapping[str, tuple[float, float]] = field(default_factory=lambda: WINDOW)
    completion: Mapping[str, str] = field(default_factory=lambda: SECTION)


_WIDE = {"p": (-6.0, 2.0), "y": (-2.0, 2.0)}
SECTIONS = (
    Section("strobe phase 0"),
    Section("phase .25", 0.25),
    Section("phase .5", 0.5),
    Section("phase .75", 0.75),
    Section("q = max(0, p - g) + .5", completion={"q": "max(0, p - g) + 0.5"}),
    Section("p -6..2, y -2..2", window=_WIDE),
    Section("(p, y, q), q 0..1", window={**WINDOW, "q": (0.0, 1.0)}, completion={}),
)
MORE_SECTIONS = (
    Section("q = max(0, p - g + 1)", completion={"q": "max(0, p - g + 1)"}),
    Section("in touch", window={"p": (0.02, 1.5), "y": (-1.0, 1.0)}, completion={"q": "p - g"}),
    Section("p -30..3, y -5..5", window={"p": (-30.0, 3.0), "y": (-5.0, 5.0)}),
    Section("(p, y, q), wide", 0.0, {"p": (-6.0, 3.0), "y": (-2.0, 2.0), "q": (-1.0, 3.0)}, {}),
)


def by_recurrences(omega: float, section: Section, samples: int = 1000, seed: int = 0) -> Evidence:
    """Attractors by recurrences, cycles refined by Newton's method.

    Parameters
    ----------
    omega : float
        Frequency of the excitation.
    section : Section
        Where the starts lie.
    samples, seed : int, optional
        Starts.

    Returns
    -------
    dict
        ``route``, ``section``, ``starts``, how many of them are ``unsettled``, and ``attractors``
        with ``period`` (0: none), ``kind``, ``fraction``, a ``point`` on it and the ``residual`` of
        cycles.

    Examples
    --------
    >>> found = by_recurrences(1.4, SECTIONS[0], samples=100)
    >>> [each["period"] for each in found["attractors"]]
    [4, 0]
    """
    found = attractors(
        StroboscopicMap(oscillator(omega), phase=section.phase), section.window,
        completion=section.completion, samples=samples, seed=seed,
    )  # fmt: skip
    unsettled = int(found.attrs["unsettled_starts"] + found.attrs["ended_starts"])
    return _route("recurrences", section.name, samples, unsettled, found)


def by_cells(omega: float, cells: tuple[int, int, int]) -> Evidence:
    """Attractors by cell mapping in all three states, over the window and q from 0 to 1.

    Attractors whose basins are thinner than the cells may be missed.

    Parameters
    ----------
    omega : float
        Frequency of the excitation.
    cells : tuple of int
        Cells along p, y and q.

    Returns
    -------
    dict
        As from `by_recurrences`; starts are admissible cells.

    Examples
    --------
    >>> by_cells(1.4, (20, 20, 5))["route"]
    'cell mapping'
    """
    ranges = {**WINDOW, "q": (0.0, 1.0)}
    grid = {
        name: np.linspace(*ends, count)
        for (name, ends), count in zip(ranges.items(), cells, strict=True)
    }
    found = basins_of_attraction(oscillator(omega), grid, method="cell mapping")
    label = found["label"].values
    name = f"(p, y, q), {' x '.join(map(str, cells))} cells"
    return _route(
        "cell mapping", name, int(np.sum(label != -2)), int(np.isin(label, (0, -1)).sum()), found
    )


def _route(route: str, section: str, starts: int, unsettled: int, found: xr.Dataset) -> Evidence:
    each = [
        {
            "period": int(one["period"]),
            "kind": str(one["kind"].item()),
            "fraction": float(one["fraction"]),
            "residual": float(one["residual"]) if int(one["period"]) else None,
            "point": dict(zip("pyq", one["points"].values[0, :3].tolist(), strict=True)),
        }
        for one in (found.sel(attractor=k) for k in found["attractor"].values)
    ]
    return {
        "route": route,
        "section": section,
        "starts": starts,
        "unsettled": unsettled,
        "attractors": each,
    }
