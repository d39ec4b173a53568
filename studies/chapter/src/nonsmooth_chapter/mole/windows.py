"""Windows of periodic motion in a sweep, and the stretches of chaos between them."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import groupby

from nonsmooth_chapter.judgement import Evidence
from nonsmooth_chapter.mole.static_force_sweeps import CHAOTIC, UNSETTLED, Sweep

__all__ = ["at_the_end", "order_of_labels", "stretches", "widest"]


def stretches(sweep: Sweep) -> list[Evidence]:
    """Neighbouring columns with chaos, and those without, in order of b.

    Columns that have not settled, as near a period doubling, do not end a window; among them
    alone there is none.

    Parameters
    ----------
    sweep : Sweep
        Columns with labels.

    Returns
    -------
    list of dict
        ``low`` and ``high`` (first and last b), ``columns`` and ``periods`` that occur: none for a
        stretch of chaos.

    Examples
    --------
    >>> import numpy as np
    >>> sweep = Sweep(np.arange(5.0), np.array([0, 2, -1, 1, 0]), np.zeros(5), np.zeros(5))
    >>> [(part["low"], part["high"], part["periods"]) for part in stretches(sweep)]
    [(0.0, 0.0, []), (1.0, 3.0, [1, 2]), (4.0, 4.0, [])]
    """
    labels = sweep.labels.copy()
    for regular, part in _runs(labels != CHAOTIC):
        if regular and all(labels[i] == UNSETTLED for i in part):
            labels[part] = CHAOTIC
    return [
        {
            "low": float(sweep.b[part[0]]),
            "high": float(sweep.b[part[-1]]),
            "columns": len(part),
            "periods": sorted({int(labels[i]) for i in part} - {CHAOTIC, UNSETTLED}),
        }
        for _, part in _runs(labels != CHAOTIC)
    ]


def _runs(flags: Iterable[bool]) -> list[tuple[bool, list[int]]]:
    numbered = enumerate(bool(flag) for flag in flags)
    return [(flag, [i for i, _ in part]) for flag, part in groupby(numbered, lambda pair: pair[1])]


def widest(parts: list[Evidence]) -> Evidence:
    """Widest window of periodic motion.

    Parameters
    ----------
    parts : list of dict
        Result of `stretches`.

    Returns
    -------
    dict

    Examples
    --------
    >>> widest([{"columns": 9, "periods": []}, {"columns": 2, "periods": [1]}])["columns"]
    2
    """
    return max((part for part in parts if part["periods"]), key=lambda part: part["columns"])


def order_of_labels(sweep: Sweep) -> list[int]:
    """Labels in order of b, each stretch once, without columns that have not settled.

    Parameters
    ----------
    sweep : Sweep
        Columns with labels.

    Returns
    -------
    list of int

    Examples
    --------
    >>> import numpy as np
    >>> order_of_labels(Sweep(np.arange(5.0), np.array([4, 4, -1, 2, 0]), np.zeros(5), np.zeros(5)))
    [4, 2, 0]
    """
    return [int(label) for label, _ in groupby(sweep.labels[sweep.labels != UNSETTLED])]


def at_the_end(b: float, window: Evidence, step: float) -> bool:
    """Whether b is the upper end of a window, within 2 % or a step of the sweep.

    Parameters
    ----------
    b : float
        Static force.
    window : dict
        Part of `stretches`.
    step : float
        Distance of columns.

    Returns
    -------
    bool

    Examples
    --------
    >>> at_the_end(0.98, {"high": 1.0}, 0.01), at_the_end(0.97, {"high": 1.0}, 0.01)
    (True, False)
    """
    return abs(b - window["high"]) <= max(0.02 * window["high"], step) * (1.0 + 1e-9)
