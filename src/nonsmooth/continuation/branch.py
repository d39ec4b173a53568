"""`Branch`: the iterator that `follow` returns."""

from __future__ import annotations

from collections.abc import Iterator

from nonsmooth.continuation.attempt import Attempt, attempt, leaves
from nonsmooth.continuation.corrector import Corrector, Node
from nonsmooth.continuation.endings import message_of
from nonsmooth.continuation.observer import Observer
from nonsmooth.continuation.options import Options
from nonsmooth.continuation.point import Point
from nonsmooth.continuation.refusals import Refused

__all__ = ["Branch"]


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
    refused : int
        Steps that were halved.

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
        self.refused = 0
        self._corrector, self._options = corrector, options
        self._observer = Observer(corrector, options)
        self._last_arclength = 0.0
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

    def _run(self, first: Node) -> Iterator[Point]:
        options, node, step = self._options, first, self._options.step
        outward = leaves(first, options.bounds)
        yield self._point(first, "bound" if outward else "")
        if outward:
            return self._end("bound", first)
        for _ in range(options.steps):
            try:
                done = self._advance(node, first, step)
            except Refused as refusal:
                return self._end(refusal.ending, node, str(refusal))
            for mark in done.marks:
                yield self._point(mark.node, mark.name)
                if mark.last:
                    return self._end(mark.name, mark.node)
            node, step = done.node, done.next_step
            if not done.marked_last:
                yield self._point(node, "")
        return self._end("steps", node)

    def _advance(self, node: Node, origin: Node, step: float) -> Attempt:
        """A step of this length or, where it is refused, of half of it, and so on."""
        options, tried = self._options, step
        while True:
            try:
                done = attempt(self._corrector, options, self._observer, node, origin, tried)
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
            self.message = message_of(ended, node, self._options, reason)
