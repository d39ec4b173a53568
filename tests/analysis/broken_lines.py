"""Manifolds of piecewise-linear planar maps in closed form: broken lines, by mpmath.

A border-collision normal form is linear on both sides of x = 0, and so is its inverse where the
image of that line is crossed. The manifold of a fixed point is the eigenvector's line as long as
it stays on one side, and then image after image of it: each is a broken line whose vertices are
images of vertices, and of the places where the line before crosses the border.
"""

from collections.abc import Callable
from itertools import pairwise

import mpmath as mp
import numpy as np

import nonsmooth as ns

Point = tuple[mp.mpf, mp.mpf]


def kicked(a: float, b: float, c: float = 0.0) -> tuple[ns.System, ns.PoincareMap]:
    """Lozi's map as a system: states hold still between kicks, one per unit of time.

    With c, kicks at positive x are stronger by that, so that the map jumps at x = 0.
    """
    jump = " + where(x > 0, c, 0)" if c else ""
    reset = {"clock": "clock - 1", "x": f"1 - a*abs(x) + y{jump}", "y": "b*x"}
    kick = ns.Exit("1 - clock", reset=reset, name="kick")
    system = ns.System(
        states=["x", "y", "clock"],
        parameters={"a": a, "b": b, **({"c": c} if c else {})},
        modes={"hold": ns.Mode({"x": "0", "y": "0", "clock": "1"}, exits=[kick])},
        name="kicked",
    )
    return system, ns.PoincareMap(system, "kick", side="after")


def lozi(a: float, b: float, c: float = 0.0) -> tuple[Callable, Callable]:
    """The map and its inverse (of the continuous one), for numbers of mpmath."""

    def forward(point: Point) -> Point:
        x, y = point
        return 1 - mp.mpf(a) * abs(x) + y + (mp.mpf(c) if x > 0 else 0), mp.mpf(b) * x

    def backward(point: Point) -> Point:
        x, y = point
        before = y / mp.mpf(b)
        return before, x - 1 + mp.mpf(a) * abs(before)

    return forward, backward


def image_of_line(line: list[Point], one: Callable, border: int) -> list[Point]:
    """Image of a broken line under a map that is linear where coordinate ``border`` has a sign."""
    found = [one(line[0])]
    for begin, end in pairwise(line):
        if begin[border] * end[border] < 0:
            part = begin[border] / (begin[border] - end[border])
            cut = tuple(p + part * (q - p) for p, q in zip(begin, end, strict=True))
            found.append(one(cut))
        found.append(one(end))
    return found


def manifold_line(
    fixed: Point, along: Point, one: Callable, border: int, times: int, images: int
) -> np.ndarray:
    """Vertices of a manifold from the fixed point on; one step is the map so many ``times``."""
    line = [fixed, tuple(p + q for p, q in zip(fixed, along, strict=True))]
    for _ in range(images * times):
        line = image_of_line(line, one, border)
    return np.array([[float(x), float(y)] for x, y in line])


def bends(line: np.ndarray) -> np.ndarray:
    """Vertices at which a broken line turns."""
    steps = np.diff(line, axis=0)
    steps /= np.linalg.norm(steps, axis=1)[:, None]
    turned = np.linalg.norm(steps[1:] - steps[:-1], axis=1) > 1e-6
    return line[1:-1][turned]


def distances(points: np.ndarray, line: np.ndarray) -> np.ndarray:
    """How far points lie off a broken line."""
    begin, step = line[:-1], np.diff(line, axis=0)
    away = points[:, None] - begin
    part = np.clip((away * step).sum(axis=2) / (step**2).sum(axis=1), 0.0, 1.0)
    return np.linalg.norm(away - part[..., None] * step, axis=2).min(axis=1)
