"""All curves of one manifold of a saddle: each side of each point of the orbit."""

from __future__ import annotations

from typing import Any

from nonsmooth.analysis.manifolds.curve import Spacing
from nonsmooth.analysis.manifolds.first_segment import first_segment
from nonsmooth.analysis.manifolds.manifold_dataset import CurveOfSide
from nonsmooth.analysis.manifolds.saddle import Saddle, check_plane
from nonsmooth.analysis.manifolds.stable import grow_stable
from nonsmooth.analysis.manifolds.unstable import grow_unstable
from nonsmooth.errors import OptionError, is_known, quote
from nonsmooth.progress import HeldInterrupts, Progress
from nonsmooth.runs.options import positive_number as positive
from nonsmooth.runs.options import whole_number

__all__ = ["SIDES", "check_choice", "grow_curves", "read_spacing"]

SIDES = {"both": (1.0, -1.0), "+": (1.0,), "-": (-1.0,)}
_STEPS = 200  # of the length, where nothing is said
_FINEST = 1e-3  # of the largest step
_LEAST_STEP = 1e-14  # of the length: between points that double precision still tells apart
_FIRST = 0.1  # of the length: the longest first piece
_SHARPEST = 3.0


def grow_curves(
    saddle: Saddle, which: str, side: str, spacing: Spacing, accuracy: float
) -> tuple[list[CurveOfSide], bool]:
    """Curves of the unstable or the stable manifold, and whether all are there."""
    grow = grow_unstable if which == "unstable" else grow_stable
    tasks = [(k, way) for k in range(len(saddle.points)) for way in SIDES[side]]
    branches: list[CurveOfSide] = []
    with HeldInterrupts() as held, Progress("manifold", len(tasks) * spacing.length) as progress:
        for number, (k, way) in enumerate(tasks):

            def report(done: float, number: int = number) -> None:
                progress.update((number + min(done / spacing.length, 1.0)) * spacing.length)
                held.check()

            point = saddle.points[k]
            if which == "stable":
                check_plane(point, _FIRST * spacing.length)
            first = first_segment(saddle, point, way, _FIRST * spacing.length, accuracy)
            branches.append(CurveOfSide(k, first, grow(saddle, point, first, spacing, report)))
            if branches[-1].curve.ended == "interrupted":
                break
    return branches, all(branch.curve.ended != "interrupted" for branch in branches)


def check_choice(name: str, value: Any, known: tuple[str, ...]) -> None:
    """Refuse what is none of some texts."""
    if not is_known(value, known):
        raise OptionError(f"{name} = {quote(value)} must be {' or '.join(map(repr, known))}")


def read_spacing(
    length: Any, largest: Any, smallest: Any, angle: Any, steps: Any, longest: Any
) -> Spacing:
    """How long curves are to be, and how dense."""
    whole = positive("length", length)
    large = whole / _STEPS if largest is None else positive("largest_step", largest)
    small = large * _FINEST if smallest is None else positive("smallest_step", smallest)
    if not small < large < whole:
        raise OptionError(
            f"smallest_step = {small:g}, largest_step = {large:g} and length = {whole:g} must grow"
            " in this order"
        )
    if small < _LEAST_STEP * whole:
        name, value = ("largest_step", large) if smallest is None else ("smallest_step", small)
        raise OptionError(
            f"{name} = {value:g} asks for points that rounding moves, with length = {whole:g}; the"
            f" smallest step, {small:g} here, must be {_LEAST_STEP:g} of the length at least"
        )
    turn = positive("angle", angle)
    if turn > _SHARPEST:
        raise OptionError(f"angle = {turn:g} must be less than {_SHARPEST:g} (rad); 0.2 is usual")
    return Spacing(
        whole, large, small, turn, whole_number("steps", steps), whole_number("longest", longest)
    )
