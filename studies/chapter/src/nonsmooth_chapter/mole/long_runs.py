"""Which attractors of the mole coexist: by plain long runs, told apart by their strobes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from nonsmooth import StroboscopicMap, ensemble
from nonsmooth_chapter.judgement import Evidence
from nonsmooth_chapter.mole.basins import WINDOW, oscillator

__all__ = ["by_runs", "newton_residual"]

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
