"""`Branch`: the iterator that `follow` returns."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from nonsmooth.continuation.corrector import Corrector, Node, effort, next_step
from nonsmooth.continuation.observer import CurveSegment, Mark, Observer
from nonsmooth.continuation.options import Options
from nonsmooth.continuation.point import Array, Jump, PastBound, Point, Refused

__all__ = ["Branch"]


_HARDEST = 2.0  # effort of a step that is taken
_SAME = 1e-6  # scaled distance from the start at which a branch has come back to it
_SAME_CROSSING = 1e-4  # the same where it cannot be corrected, since branches cross there


def _message_of(ended: str, node: Node, options: Options, reason: str) -> str:
    """A sentence for the end of a branch."""
    where = f"at p = {node.p:.10g}"
    why = f" ({reason})" if reason else ""
    smallest = f"smallest_step = {options.smallest:g}"
    return {
        "bound": _bound(node, options),
        "steps": f"{options.steps} steps were taken, up to p = {node.p:.10g}; allow more with"
        " steps=, or longer ones with largest_step=",
        "closed": "the branch came back to its start: it is a closed curve",
        "domain": f"the residual has no finite value beyond p = {node.p:.10g}{why}: the branch ends"
        f" there to within {smallest}",
        "singular": f"the derivatives are singular {where}{why}: no single smooth curve goes on; if"
        " branches cross there, branch_directions says where they go",
        "smallest_step": f"no step from {smallest} on was taken {where}{why}: the curve has a"
        " corner or a jump there, or derivatives that are given are wrong; try a smaller"
        " smallest_step=, more max_newton=, a larger tolerance= for a residual that is not good"
        " to 1e-9, or no derivatives",
    }[ended]


def _bound(node: Node, options: Options) -> str:
    """Which parameter came to its bound; the last unknown has one only where it is a parameter."""
    first = float(node.u[-1])
    if first in options.unknown_bounds:
        return (
            f"the first parameter reached its bound {first:.10g}, where the second one is"
            f" {node.p:.10g}"
        )
    return f"the branch reached the bound at p = {node.p:.10g}"


@dataclass(slots=True)
class _Attempt:
    """A step that was taken: its end, the special points on it, the length to try next."""

    node: Node
    marks: list[Mark]
    next_step: float

    @property
    def marked_last(self) -> bool:
        """Whether the end itself is among the special points."""
        return any(mark.node is self.node for mark in self.marks)


@dataclass(frozen=True)
class _Origin:
    """The start of a branch, and vectors (K, n) by which its solutions repeat."""

    node: Node
    repeats: Array | None = None

    def near(self, node: Node) -> Node:
        """The start, or that of its copies which is nearest to a point."""
        if self.repeats is None:
            return self.node
        u = self.node.u.copy()
        for by in self.repeats:
            u += round(float((node.u - u) @ by) / float(by @ by)) * by
        return replace(self.node, u=u)


def _attempt(
    corrector: Corrector,
    options: Options,
    observer: Observer,
    node: Node,
    origin: _Origin,
    step: float,
) -> _Attempt:
    """A step of this length; `Refused` where there is none."""
    try:
        end = _ahead(corrector, node, step)
        return _judged(corrector, options, observer, node, origin, step, end)
    except PastBound:
        end = _on_bound(corrector, node, step)
        return _judged(corrector, options, observer, node, origin, step, end)


def _leaves(node: Node, bounds: tuple[float, float]) -> bool:
    """Whether the branch heads out of its bounds at a point on one of them."""
    low, high = bounds
    ahead = float(node.tangent[-1])
    return (node.p >= high and ahead > 0.0) or (node.p <= low and ahead < 0.0)


def _leaves_first(corrector: Corrector, node: Node, options: Options) -> bool:
    """Whether the last unknown, a parameter with bounds, is on one of them and heads out.

    The start is corrected, so it is there to rounding; then it is put there.
    """
    ahead = float(node.tangent[-2]) if node.tangent.size > 1 else 0.0
    near = corrector.tolerance * (1.0 + corrector.length(node.u, node.p))
    for bound, way in zip(options.unknown_bounds, (-1.0, 1.0), strict=True):
        inside = way * (bound - float(node.u[-1]))
        if way * ahead > 0.0 and inside <= near * float(corrector.equations.scale[-2]):
            node.u[-1] = bound
            return True
    return False


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
    return corrector.onto_bound(corrector.across(y[:-1] * scale[:-1], p, node.tangent, step))


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
    corrector: Corrector, options: Options, observer: Observer, node: Node, origin: _Origin,
    step: float, end: Node,
) -> _Attempt:  # fmt: skip
    """The step with its special points, if it can be believed."""
    segment = CurveSegment(corrector, node, end)
    work = effort(node, end, segment.chord)
    if work > _HARDEST:
        raise Jump("the curve turns too much")
    segment.placed(end)
    curvature = (end.tangent - node.tangent) / segment.length
    end.curvature = curvature - end.tangent * float(end.tangent @ curvature)
    marks = observer.marks(segment)
    if _leaves(end, options.bounds):
        marks.append(Mark(1.0, end, "bound", last=True))
    home = None if node is origin.node else _home(segment, origin.near(end))
    if home:
        marks = [mark for mark in marks if mark.x < home.x] + [home]
    if options.accept is not None and not options.accept(_points_of(observer, node, marks, end)):
        raise Jump("the step is not accepted")
    return _Attempt(end, marks, next_step(step, work, options.largest))


def _points_of(observer: Observer, node: Node, marks: list[Mark], end: Node) -> list[Point]:
    """The points of a step in order, from its start to where the branch or the step ends."""
    places = [(node, ""), *((mark.node, mark.name) for mark in marks)]
    if not any(mark.last or mark.node is end for mark in marks):
        places.append((end, ""))
    return [observer.point(each, each.step, name) for each, name in places]


def _home(segment: CurveSegment, origin: Node) -> Mark | None:
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


class Branch(Iterator[Point]):
    """Points along a branch, in order, each found when it is asked for.

    Made by `follow`.

    Parameters
    ----------
    corrector, options, first : object
        What `follow` hands over.

    Attributes
    ----------
    ended : str
        Empty while the branch goes on; then ``"bound"``, ``"steps"``, ``"closed"`` (it came back to
        its start), ``"domain"`` (the residual has no value beyond), ``"smallest_step"``,
        ``"singular"`` or ``"stopped"``.
    message : str
        The same in a sentence, with what to try.
    taken, refused : int
        Steps that were taken so far, and those that were halved.

    See Also
    --------
    follow : what makes it.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> circle = ns.continuation.follow(lambda u, p: u**2 + p**2 - 1, 1.0, 0.0)
    >>> points = list(circle)
    >>> circle.ended, round(points[-1].arclength, 6)
    ('closed', 6.283185)
    """

    def __init__(self, corrector: Corrector, options: Options, first: Node) -> None:
        self.ended = self.message = ""
        self.taken = self.refused = 0
        self._corrector, self._options = corrector, options
        self._observer = Observer(corrector, options)
        self._last_arclength = 0.0
        self._origin = _Origin(first)
        self._points = self._run(first)

    @property
    def evaluations(self) -> int:
        """How often the residual was asked so far."""
        return self._corrector.equations.evaluations

    def __next__(self) -> Point:
        if self.ended == "stopped":
            raise StopIteration
        return next(self._points)

    def stop(self, message: str = "stopped on request") -> None:
        """End the branch with the point that was given last.

        Parameters
        ----------
        message : str, optional
            Why; it becomes the message of the branch.
        """
        if not self.ended:
            self.ended, self.message = "stopped", message

    def begun_at(self, u: Array, p: float, direction: tuple[Array, float]) -> None:
        """Let the branch be the rest of a curve that began elsewhere, where it closes.

        Parameters
        ----------
        u : array
            Unknowns where the curve began.
        p : float
            The parameter there.
        direction : tuple of array and float
            In which the curve left.
        """
        ahead = self._corrector.scaled(*direction)
        try:
            origin = self._corrector.across(u, p, ahead / math.sqrt(float(ahead @ ahead)))
        except Refused:  # it cannot be told from there, so the branch closes at its own start
            return
        self._origin = replace(self._origin, node=origin.turned(ahead))

    def repeats(self, by: Array) -> None:
        """Let the branch be closed, too, where it comes to its start but for whole multiples.

        Parameters
        ----------
        by : array
            Vectors of the unknowns, (K, n), that lead from each solution to another one which
            counts as the same, as a whole turn of an angle.
        """
        self._origin = replace(self._origin, repeats=by)

    def _run(self, first: Node) -> Iterator[Point]:
        options, node, step = self._options, first, self._options.step
        outward = _leaves(first, options.bounds) or _leaves_first(self._corrector, first, options)
        yield self._point(first, "bound" if outward else "")
        if outward:
            return self._end("bound", first)
        for _ in range(options.steps):
            try:
                done = self._advance(node, self._origin, step)
            except Refused as refusal:
                return self._end(refusal.ending, node, str(refusal))
            self.taken += 1
            for mark in done.marks:
                yield self._point(mark.node, mark.name)
                if mark.last:
                    return self._end(mark.name, mark.node)
            node, step = done.node, done.next_step
            if not done.marked_last:
                yield self._point(node, "")
        return self._end("steps", node)

    def _advance(self, node: Node, origin: _Origin, step: float) -> _Attempt:
        """A step of this length or, where it is refused, of half of it, and so on."""
        options, tried = self._options, step
        while True:
            try:
                done = _attempt(self._corrector, options, self._observer, node, origin, tried)
            except Refused:
                self.refused += 1
                tried *= 0.5
                if tried < options.smallest:
                    raise
            else:
                if tried < step:  # a step that was just refused is not tried again at once
                    done.next_step = min(done.next_step, tried)
                return done

    def _point(self, node: Node, name: str) -> Point:
        point = self._observer.point(node, node.arclength - self._last_arclength, name)
        self._last_arclength = node.arclength
        return point

    def _end(self, ended: str, node: Node, reason: str = "") -> None:
        if not self.ended:
            self.ended = ended
            self.message = _message_of(ended, node, self._options, reason)
