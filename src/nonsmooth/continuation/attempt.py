"""One step along a branch, or the reason why it cannot be taken."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from nonsmooth.continuation.corrector import Corrector, Node
from nonsmooth.continuation.observer import Mark, Observer
from nonsmooth.continuation.options import Options
from nonsmooth.continuation.refusals import Jump, PastBound, Refused
from nonsmooth.continuation.segment import Segment
from nonsmooth.continuation.steps import effort, next_step

__all__ = ["Attempt", "attempt", "leaves"]

_HARDEST = 2.0  # effort of a step that is taken
_SAME = 1e-6  # scaled distance from the start at which a branch has come back to it
_SAME_CROSSING = 1e-4  # the same where it cannot be corrected, since branches cross there


@dataclass(slots=True)
class Attempt:
    """A step that was taken: its end, the special points on it, the length to try next."""

    node: Node
    marks: list[Mark]
    next_step: float

    @property
    def marked_last(self) -> bool:
        """Whether the end itself is among the special points."""
        return any(mark.node is self.node for mark in self.marks)


def attempt(
    corrector: Corrector,
    options: Options,
    observer: Observer,
    node: Node,
    origin: Node,
    step: float,
) -> Attempt:
    """A step of this length; `Refused` where there is none."""
    try:
        end = _ahead(corrector, node, step)
        return _judged(corrector, options, observer, node, origin, step, end)
    except PastBound:
        end = _on_bound(corrector, node, step)
        return _judged(corrector, options, observer, node, origin, step, end)


def leaves(node: Node, bounds: tuple[float, float]) -> bool:
    """Whether the branch heads out of its bounds at a point on one of them."""
    low, high = bounds
    ahead = float(node.tangent[-1])
    return (node.p >= high and ahead > 0.0) or (node.p <= low and ahead < 0.0)


def _ahead(corrector: Corrector, node: Node, step: float) -> Node:
    """The point a step ahead; `PastBound` where that is out of bounds, which are not passed."""
    y = corrector.scaled(node.u, node.p) + step * node.tangent
    if node.curvature is not None:
        y += 0.5 * step * step * node.curvature
    scale = corrector.equations.scale
    p = float(y[-1] * scale[-1])
    low, high = corrector.equations.bounds
    if not low <= p <= high:
        raise PastBound
    return corrector.across(y[:-1] * scale[:-1], p, node.tangent, step)


def _on_bound(corrector: Corrector, node: Node, step: float) -> Node:
    """The point on the bound that lies ahead, not much farther than a step."""
    low, high = corrector.equations.bounds
    scale, ahead = corrector.equations.scale, float(node.tangent[-1])
    bound = high if ahead > 0.0 else low
    away = (bound - node.p) / float(scale[-1])
    along = away / ahead if ahead else math.inf
    if not 0.0 < along <= 2.0 * step:
        raise Jump("the parameter leaves its bounds in between")
    u = node.u + along * node.tangent[:-1] * scale[:-1]
    return corrector.at_parameter(u, bound, along).turned(node.tangent)


def _judged(
    corrector: Corrector, options: Options, observer: Observer, node: Node, origin: Node,
    step: float, end: Node,
) -> Attempt:  # fmt: skip
    """The step with its special points, if it can be believed."""
    segment = Segment(corrector, node, end)
    work = effort(node, end, segment.chord)
    if work > _HARDEST:
        raise Jump("the curve turns too much")
    segment.placed(end)
    curvature = (end.tangent - node.tangent) / segment.length
    end.curvature = curvature - end.tangent * float(end.tangent @ curvature)
    marks = observer.marks(segment)
    if leaves(end, options.bounds):
        marks.append(Mark(1.0, end, "bound", last=True))
    home = None if node is origin else _home(segment, origin)
    if home:
        marks = [mark for mark in marks if mark.x < home.x] + [home]
    return Attempt(end, marks, next_step(step, work, options.largest))


def _home(segment: Segment, origin: Node) -> Mark | None:
    """The start of the branch, if the step passes it in the same direction."""
    corrector = segment.corrector
    start = corrector.scaled(origin.u, origin.p)
    away = start - segment.start
    ahead = float(away @ segment.first.tangent) > 0.0
    behind = float((away - segment.chord) @ segment.last.tangent) <= 0.0
    near = float(away @ away) <= 4.0 * segment.length**2
    if not (ahead and behind and near and float(origin.tangent @ segment.first.tangent) > 0.5):
        return None
    x = min(1.0, float(away @ segment.chord) / float(segment.chord @ segment.chord))
    y = segment.guess(x)[0]
    y = y - origin.tangent * float(origin.tangent @ (y - start))
    size = 1.0 + math.sqrt(float(start @ start))
    try:
        found = corrector.across(*segment.unscaled(y), origin.tangent, segment.length)
        apart, same = corrector.scaled(found.u, found.p) - start, _SAME * size
    except Refused:
        apart, same = y - start, _SAME_CROSSING * size
    if math.sqrt(float(apart @ apart)) > same:
        return None
    return Mark(x, segment.placed(replace(origin, tests=None)), "closed", last=True)
