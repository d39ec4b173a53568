"""Attractors and basins of the mole's oscillator, and how fractal their boundaries are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from nonsmooth import (
    StroboscopicMap,
    System,
    attractors,
    basins_of_attraction,
    ensemble,
    uncertainty_exponent,
)
from nonsmooth.models import moling
from nonsmooth.plot import basins, print_figure
from nonsmooth_chapter.judgement import Evidence

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "DISTANCES",
    "MORE_SECTIONS",
    "OMEGAS",
    "SECTION",
    "SECTIONS",
    "WINDOW",
    "Section",
    "by_cells",
    "by_recurrences",
    "by_runs",
    "exponent_on_grid",
    "exponents_of_pairs",
    "fig12",
    "newton_residual",
    "oscillator",
    "section_basins",
]


# Basins of attraction of the mole: Fig. 12.
#
# The chapter prints neither the section that the starts lie on nor the window. Here starts are at a
# strobe, tau = 0, at places (p, y) of the mass with the slider top as far out as it admits,
# q = max(0, p - g): unloaded, or in touch with the mass.

OMEGAS = (1.4, 1.45, 1.56, 1.58, 1.6, 1.7)
WINDOW = {"p": (-3.0, 1.0), "y": (-1.0, 1.0)}
SECTION = {"q": "max(0, p - g)"}
# Numbers of a kind of motion in the data of all panels.
_CHAOS, _PERIOD_FOUR, _OTHERS = 16, 8, (10, 12)
_KINDS = (_PERIOD_FOUR, _CHAOS, *_OTHERS)
# Numbers, and so colours, of each period in the picture: chaos is pale, and the others, whose
# basins are thin, have full colours; a multiple of a shorter period beside it has its hue, paler.
_DRAWN = {0: _CHAOS, 4: 8, 12: 1, 6: 10, 24: 3, 3: 11, 9: 4, 5: 12}
_MORE = (13, 14, 9)
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
        Panels (a) to (f). A colour means one period in all of them: pale orange chaos, blue four,
        pale blue 12, green six, pale green 24, vermilion three, pale vermilion nine, purple five.
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
        found = section_basins(omega, cells, samples=samples)
        data = _renumbered(found, {0: _CHAOS, 4: _PERIOD_FOUR}, _OTHERS)
        basins(_renumbered(found, _DRAWN, _MORE), ax=ax)
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


def _renumbered(
    data: xr.Dataset, by_period: Mapping[int, int], others: Sequence[int]
) -> xr.Dataset:
    """The same with one number for one period, whatever the panel; 0 is chaos."""
    order = data["attractor"].values[np.argsort(-data["fraction"].values, kind="stable")]
    beyond = max(*by_period.values(), *others) + 1
    spare = [*others, *range(beyond, beyond + len(order))]
    numbers: dict[int, int] = {}
    for one in order:
        period = int(data["period"].sel(attractor=one))
        number = by_period.get(period, spare[0])
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


# Which attractors of the mole coexist: by recurrences on several sections, and by cell mapping.


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


# Which attractors of the mole coexist: by plain long runs, told apart by their strobes.

# The slowest cycle, of period 24, gains a digit in 640 periods.
_LONGEST, _REPEATS = 64, 1e-6
_SAME = 1e-4  # between points of one cycle
_CELLS, _SHARED = 64, 0.5  # across the strobes, and the part of its cells that one set has twice
_LONG_LANES, _LONG_RECORD = 8, 4000


def by_runs(
    omega: float, starts: int = 2000, transient: int = 4000, record: int = 129, seed: int = 0
) -> Evidence:
    """Attractors by plain long runs from random starts on the section.

    Motions repeat or not; cycles are one where their points agree, and motions that do not repeat
    where their longer records fill the same cells. A start is unsettled whose motion repeats in a
    longer record only. Nothing here is shared with `nonsmooth.attractors`.

    Parameters
    ----------
    omega : float
        Frequency of the excitation.
    starts : int, optional
        Starts, evenly over the window.
    transient, record : int, optional
        Periods left out and looked at.
    seed : int, optional
        Of the starts.

    Returns
    -------
    dict
        As from `mole_coexistence.by_recurrences`; residuals are those of cycles refined by Newton's
        method here.

    Examples
    --------
    >>> [each["period"] for each in by_runs(1.4, starts=100, transient=600)["attractors"]]
    [4, 0]
    """
    random = np.random.default_rng(seed)
    initial = {name: random.uniform(*ends, starts) for name, ends in WINDOW.items()}
    initial["q"] = np.maximum(0.0, initial["p"] - 0.02)
    points = _strobes(omega, initial, transient, record)
    periods = _periods(points)
    found = [
        {
            "period": period,
            "kind": "periodic",
            "fraction": count / starts,
            "residual": newton_residual(omega, orbit),
        }
        for period, orbit, count in _cycles(points, periods)
    ]
    lanes = np.flatnonzero(periods == 0)
    longer = {name: values[lanes[:_LONG_LANES]] for name, values in initial.items()}
    sets, unsettled = 0, 0
    if lanes.size:
        records = _strobes(omega, longer, transient, _LONG_RECORD)
        repeats = _periods(records[:, -record:]) > 0
        unsettled = int(repeats.sum())
        sets = _distinct_sets(records[~repeats])
    found += [
        {"period": 0, "kind": "aperiodic", "fraction": lanes.size / starts / sets, "residual": None}
        for _ in range(sets)
    ]
    return {
        "route": "runs",
        "section": "strobe phase 0",
        "starts": starts,
        "unsettled": unsettled,
        "attractors": found,
    }


def _strobes(
    omega: float, initial: Mapping[str, np.ndarray], transient: int, record: int
) -> np.ndarray:
    """States p, y, q at strobes, shape (start, record, 3)."""
    runs = ensemble(oscillator(omega), initial, transient=transient, record=record)
    return np.stack([runs[name].values for name in "pyq"], axis=-1)


def _periods(points: np.ndarray) -> np.ndarray:
    """Least number of strobes after which a record repeats, 0 where it does not."""
    periods = np.zeros(len(points), int)
    for n in range(min(_LONGEST, points.shape[1] - 1), 0, -1):
        periods[np.abs(points[:, n:] - points[:, :-n]).max(axis=(1, 2)) <= _REPEATS] = n
    return periods


def _cycles(points: np.ndarray, periods: np.ndarray) -> list[tuple[int, np.ndarray, int]]:
    """Period, points and number of starts of each cycle."""
    found: list[tuple[int, np.ndarray, int]] = []
    for lane in np.flatnonzero(periods):
        period = int(periods[lane])
        orbit = points[lane, :period]
        for i, (known, other, count) in enumerate(found):
            if known == period and np.abs(other - orbit[0]).max(axis=1).min() < _SAME:
                found[i] = (known, other, count + 1)
                break
        else:
            found.append((period, orbit, 1))
    return sorted(found, key=lambda one: -one[2])


def _distinct_sets(records: np.ndarray) -> int:
    """How many sets do the records fill, told by the cells of p and y that they visit."""
    places = records[..., :2]
    low, high = places.min(axis=(0, 1)), places.max(axis=(0, 1))
    cells = (_CELLS * (places - low) / (high - low)).astype(int) @ (1, 2 * _CELLS)
    sets: list[set[int]] = []
    for lane in cells:
        visited = set(lane.tolist())
        known = (k for k, one in enumerate(sets) if len(visited & one) > _SHARED * len(visited))
        k = next(known, None)
        if k is None:
            sets.append(visited)
        else:
            sets[k] |= visited
    return len(sets)


def newton_residual(omega: float, orbit: np.ndarray, steps: int = 5) -> float:
    """Distance of a cycle from its image after some steps of Newton's method.

    Parameters
    ----------
    omega : float
        Frequency of the excitation.
    orbit : numpy.ndarray, shape (period, 3)
        Its points p, y, q.
    steps : int, optional
        Steps.

    Returns
    -------
    float

    Examples
    --------
    >>> import numpy as np
    >>> newton_residual(
    ...     1.4,
    ...     np.array(
    ...         [[0.84, 0.38, 0.82], [-1.57, -0.25, 0.0], [-2.67, 0.19, 0.0], [-1.75, 0.64, 0.0]]
    ...     ),
    ... ) < 1e-12
    True
    """
    turn = StroboscopicMap(oscillator(omega), every=len(orbit))
    # begin in free flight, furthest from contact, where the state has no constraint
    point = orbit[np.argmax(orbit[:, 2] - orbit[:, 0])]
    for _ in range(steps):
        start = dict(zip("pyq", point.tolist(), strict=True))
        slope = turn.tangent(start).values[:3, :3]
        point = point - np.linalg.solve(slope - np.eye(3), _image(turn, point) - point)
    return float(np.abs(_image(turn, point) - point).max())


def _image(turn: StroboscopicMap, point: np.ndarray) -> np.ndarray:
    image = turn.iterate(dict(zip("pyq", point.tolist(), strict=True)), 1)
    return np.array([float(image[name][-1]) for name in "pyq"])


# How fractal the boundaries between basins of the mole are.
#
# By the grid of a window round a periodic point (`nonsmooth.uncertainty_exponent`), and over the
# whole section by pairs of starts that lie a small distance apart.

DISTANCES = tuple(10.0 ** (-k / 2) for k in range(4, 11))

_HALF = (0.25, 0.125)  # of the window round a periodic point, in p and y
_FEWEST, _COUNTED = 3, 10  # distances through which a line is fitted, pairs that make one count
_BLOCKS = 5  # along p and along y, left out one by one
_MIXED = 0.5  # part of what labels strewn at random would give, above which it saturates


def exponent_on_grid(omega: float, cells: int = 96) -> Evidence:
    """Uncertainty exponent in a window round a point of the largest periodic basin.

    Parameters
    ----------
    omega : float
        Frequency of the excitation.
    cells : int, optional
        Cells along p and along y.

    Returns
    -------
    dict
        ``period`` of the point, its ``place``, ``exponent``, ``error`` and ``message``.

    Examples
    --------
    >>> found = exponent_on_grid(1.7, cells=32)
    >>> found["period"], 0.0 < found["exponent"] < 0.8
    (3, True)
    """
    found = attractors(oscillator(omega), WINDOW, completion=SECTION)
    cycles = found.isel(attractor=np.flatnonzero(found["period"].values))
    largest = cycles.isel(attractor=int(np.argmax(cycles["fraction"].values)))
    p, y = (float(largest["points"].sel(state=name)[0]) for name in "py")
    window = {"p": (p - _HALF[0], p + _HALF[0]), "y": (y - _HALF[1], y + _HALF[1])}
    found = uncertainty_exponent(section_basins(omega, cells, window))
    return {
        "period": int(largest["period"]),
        "place": [p, y],
        "exponent": float(found["uncertainty_exponent"]),
        "error": float(found["standard_error"]),
        "message": str(found.attrs["message"]),
    }


def exponents_of_pairs(
    omega: float, starts: int = 50, distances: Sequence[float] = DISTANCES
) -> list[Evidence]:
    """Uncertainty exponents over the whole section, from pairs of starts.

    Starts on an even grid and those displaced along p are compared: do both lead to the same
    attractor (all basins together), or both to this one or not (one basin against the rest).

    Parameters
    ----------
    omega : float
        Frequency of the excitation.
    starts : int, optional
        Along p and along y.
    distances : sequence of float, optional
        Displacements.

    Returns
    -------
    list of dict
        First all basins together, then each: ``basin`` (period, 0: chaos, None: all), ``share`` of
        the starts, ``uncertain`` fractions over ``distances``, ``exponent`` and ``error``, None
        where fewer than three distances have ten uncertain pairs without being mixed throughout.

    Examples
    --------
    >>> rows = exponents_of_pairs(1.7, starts=20, distances=(0.01, 0.001))
    >>> [row["basin"] for row in rows]
    [None, 3, 9, 0]
    """
    grid = {
        name: np.linspace(*ends, starts, endpoint=False) + 0.5 * (ends[1] - ends[0]) / starts
        for name, ends in WINDOW.items()
    }
    displaced = np.unique(np.concatenate([grid["p"], *(grid["p"] + d for d in distances)]))
    found = basins_of_attraction(
        oscillator(omega), {"p": displaced, "y": grid["y"]}, completion=SECTION
    )
    label = found["label"].values
    here = label[:, np.searchsorted(displaced, grid["p"])]
    there = [label[:, np.searchsorted(displaced, grid["p"] + d)] for d in distances]
    together = np.stack([here != other for other in there])
    rows = [{"basin": None, "share": 1.0, **_law(together, distances, _strewn(here))}]
    for number, period in zip(found["attractor"].values, found["period"].values, strict=True):
        inside = here == number
        differ = np.stack([inside != (other == number) for other in there])
        of_one = {"basin": int(period), "share": float(inside.mean())}
        rows.append({**of_one, **_law(differ, distances, _strewn(inside))})
    return rows


def _strewn(labels: np.ndarray) -> float:
    """Fraction of pairs that differ when the same labels are strewn at random."""
    counts = np.unique(labels, return_counts=True)[1] / labels.size
    return float(1.0 - counts @ counts)


def _law(differ: np.ndarray, distances: Sequence[float], strewn: float) -> Evidence:
    """Power law through the fractions of pairs that differ, shape (distance, y, p)."""
    sizes = np.array(distances)
    counts = differ.sum(axis=(1, 2))
    fraction = counts / differ[0].size
    used = (fraction <= _MIXED * strewn) & (counts >= _COUNTED)
    law: Evidence = {
        "distances": sizes.tolist(), "uncertain": fraction.tolist(),
        "exponent": None, "error": None,
    }  # fmt: skip
    if used.sum() < _FEWEST:
        return law
    across, kept = np.log(sizes[used]), differ[used]
    slope, offset = np.polyfit(across, np.log(fraction[used]), 1)
    residuals = np.log(fraction[used]) - slope * across - offset
    scatter = np.sqrt(
        np.sum(residuals**2) / (used.sum() - 2) / np.sum((across - across.mean()) ** 2)
    )
    without = [np.polyfit(across, np.log(left), 1)[0] for left in _left_out(kept)]
    jackknife = np.sqrt((len(without) - 1) * np.var(without))
    return law | {"exponent": float(slope), "error": float(np.hypot(scatter, jackknife))}


def _left_out(differ: np.ndarray) -> list[np.ndarray]:
    """Counts over the distances without one block of the section after the other."""
    sums = np.array(
        [
            block.sum(axis=(1, 2))
            for band in np.array_split(differ, _BLOCKS, axis=1)
            for block in np.array_split(band, _BLOCKS, axis=2)
        ]
    )
    rest = sums.sum(axis=0) - sums
    return [left for left in rest if left.all()]
