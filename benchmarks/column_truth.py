"""What the columns of the soft impact diagram are, and which columns of others are wrong.

The truth comes from `hand_kernels.soft_impact_scan`, an exact solution that shares nothing with
those it judges, from rest and from starts next to it. A column is decided where all these come to
the same points; where they do not, rounding decides and no program can be right. Among those,
columns in which all starts stay aperiodic are called chaotic. A period found there is counted,
though it may be the end of a chaotic transient. A decided column of which no period is told is left
open, and not wrong: at omega 0.87786 points repeat to 1e-6 after ten periods only because a motion
of period five still settles, by a factor near -0.8 each time.
"""

from typing import NamedTuple

import numpy as np
from hand_kernels import soft_impact_scan

NEAR = 1e-12  # distance of the other starts from rest: ten thousand times the rounding
COPIES = 6
SAME = 1e-8  # of the size of a state: copies that agree like this have decided
MATCH = 1e-6  # of the size of a state: points repeat, as in bifurcation_diagram
VISIBLE = 1e-3  # of the size of a state: a point is off by what a figure shows


class Truth(NamedTuple):
    points: np.ndarray  # (columns, recorded, 2), from rest
    label: np.ndarray  # (columns,): period, 0 for none
    scale: np.ndarray  # (columns, 2)
    decided: np.ndarray  # (columns,)
    chaotic: np.ndarray  # (columns,)


def truth(parameters, omegas, periods, recorded):
    p = parameters
    starts = [(0.0, 0.0)] + [
        (NEAR * np.cos(k), NEAR * np.sin(k)) for k in 2.0 * np.pi * np.arange(COPIES) / COPIES
    ]
    strobes = np.zeros((len(starts), omegas.size, periods + 1, 2))
    for j, (x, v) in enumerate(starts):
        for i, omega in enumerate(omegas):
            soft_impact_scan.simulate(
                strobes[j, i, 1:], p["zeta"], p["e"], p["beta"], p["a"], omega, x, v
            )
    points = strobes[:, :, recorded]
    scale = np.abs(points[0]).max(axis=1)
    apart = (np.abs(points - points[0]) / scale[:, None]).max(axis=(0, 2, 3))
    labels = np.array([[period(each) for each in copy] for copy in points])
    decided = apart <= SAME
    chaotic = ~decided & np.all(labels == 0, axis=0)
    return Truth(points[0], labels[0], scale, decided, chaotic)


def period(points):
    """Smallest p after which all points repeat, seen twice; 0 for none."""
    scale = np.abs(points).max(axis=0)
    for p in range(1, (len(points) - 1) // 2 + 1):
        if np.all(np.abs(points[p:] - points[:-p]) <= MATCH * scale):
            return p
    return 0


def distance(points, others, scale):
    """How far two sets of points are apart, relative to the size of each state."""
    apart = (np.abs(points[:, None] - others[None]) / scale).max(axis=2)
    return max(apart.min(axis=0).max(), apart.min(axis=1).max())


class Verdict(NamedTuple):
    labels: int  # decided columns with a wrong period
    open: int  # decided columns of which no period is told
    points: int  # decided columns with points that are visibly off
    chaos: int  # chaotic columns called periodic
    error: float  # median over the decided columns of the distance of the sets of points
    wrong: np.ndarray  # numbers of the decided columns that are wrong


def judge(true, points, labels):
    """Count wrong columns; shapes: points (columns, recorded, 2), labels (columns,)."""
    apart = np.array(
        [distance(*each) for each in zip(points, true.points, true.scale, strict=True)]
    )
    open_yet = true.decided & (labels == 0) & (true.label != 0)
    other_label = true.decided & (labels != true.label) & ~open_yet
    off = true.decided & ~(apart <= VISIBLE)
    chaos = true.chaotic & (labels != 0)
    return Verdict(
        int(other_label.sum()),
        int(open_yet.sum()),
        int(off.sum()),
        int(chaos.sum()),
        float(np.median(apart[true.decided])),
        np.flatnonzero(other_label | off),
    )
