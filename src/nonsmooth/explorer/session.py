"""One visitor's page: gestures come in, views change, jobs begin, pieces are shown.

What a pane shows is a function of the view. The key of a pane is all that its task depends on; a
gesture that changes the key cancels the task and begins it anew.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from nonsmooth.errors import NonsmoothError, OptionError
from nonsmooth.explorer import calls, scripts
from nonsmooth.explorer.descriptions import described
from nonsmooth.explorer.faults import find_fault
from nonsmooth.explorer.gestures import after
from nonsmooth.explorer.jobs import Crew, Job
from nonsmooth.explorer.links import to_link
from nonsmooth.explorer.printing import SUFFIXES
from nonsmooth.explorer.tasks import Piece
from nonsmooth.explorer.view import View

__all__ = ["Session"]

_ORDER = ("motion", "drawing", "orbit", "diagram", "plane")
_QUIET = 180  # milliseconds after a live gesture until long work begins
_MOST_STEPS = 200  # back
_LONGER = 4.0  # times the limit, where the visitor asks to go on
_COPIES = {
    "python": scripts.python_text,
    "command": scripts.command_text,
    "toml": scripts.toml_text,
}

Send = Callable[[dict[str, Any]], None]


class Session:
    """The page of one visitor.

    Parameters
    ----------
    view : View
        What is shown first.
    crew : Crew
        Who computes.
    show : callable
        Told ``(task, view, piece)`` for each piece, and ``(task, view, None)`` when a task begins.
    send : callable
        Told messages for the page: dictionaries of plain values.
    later : callable
        Runs a function in the thread of the page, after some milliseconds.
    seconds : float
        Work limit of a job.
    """

    def __init__(
        self,
        view: View,
        crew: Crew,
        *,
        show: Callable[[str, View, Piece | None], None],
        send: Send,
        later: Callable[[Callable[[], None], int], None],
        seconds: float = 60.0,
    ) -> None:
        self.view, self.crew, self.seconds = view, crew, seconds
        self.show, self.send, self.later = show, send, later
        self.keys: dict[str, Any] = {}
        self.jobs: dict[str, Job] = {}
        self.past: list[View] = []
        self.future: list[View] = []
        self.live = False
        self.waiting = 0

    def hear(self, text: str) -> None:
        """A message of the page: JSON that names a gesture."""
        try:
            gesture = json.loads(text)
        except json.JSONDecodeError:
            gesture = None
        if not isinstance(gesture, dict) or not isinstance(gesture.get("do"), str):
            said = "a gesture is an object of JSON with a text under the key 'do'"
            self.send({"type": "refused", "of": "", "message": said})
            return
        try:
            self._do(gesture)
        except NonsmoothError as fault:
            self._refuse(gesture, fault)
        if "n" in gesture:  # the page counts what it sends; a tap in a plot comes without it
            self.send({"type": "heard", "n": gesture["n"]})

    def _refuse(self, gesture: dict[str, Any], fault: NonsmoothError) -> None:
        message: dict[str, Any] = {"type": "refused", "of": gesture["do"]}
        if gesture["do"] == "text":
            place = find_fault(str(gesture.get("text", "")), str(fault))
            message |= {"line": place.line, "column": place.column, "message": place.message}
        else:
            message |= {"message": str(fault)}
        message |= {"name": gesture.get("name", ""), "n": gesture.get("n")}
        self.send(message)

    def _do(self, gesture: dict[str, Any]) -> None:
        do = gesture["do"]
        if do == "back":
            self._step(self.past, self.future)
        elif do == "forward":
            self._step(self.future, self.past)
        elif do == "stop":
            self.stop()
        elif do == "go on":
            self._go_on(str(gesture.get("task", "")))
        elif do == "copy":
            self._copy(str(gesture.get("as", "")))
        elif do == "print":
            self._print(str(gesture.get("pane", "")), str(gesture.get("suffix", "")))
        else:
            self._change(after(self.view, gesture), gesture)

    def _change(self, view: View, gesture: dict[str, Any]) -> None:
        live = bool(gesture.get("live"))
        # a slider on its way makes one step back, not one for each place on the way
        if view != self.view and not (live and self.live) and not gesture.get("first"):
            self.past = [*self.past[1 - _MOST_STEPS :], self.view]
            self.future = []
        self.live = live
        self._become(view, n=gesture.get("n"))

    def _step(self, source: list[View], target: list[View]) -> None:
        if not source:
            raise OptionError("there is no further step in the history of this page")
        target.append(self.view)
        self._become(source.pop())

    def _become(self, view: View, n: Any = None) -> None:
        """Show another view: the motion at once, long work when no gesture follows."""
        other = (view.model, view.text) != (self.view.model, self.view.text)
        self.view = view
        moves = self._key("motion") != self.keys.get("motion")
        self._tell_view(n, new_system=other, moves=moves)
        for task in _ORDER:
            key = self._key(task)
            if key == self.keys.get(task):
                continue
            self.crew.cancel(self.jobs.pop(task, None))
            if task == "motion":
                self._begin(task, n=n)
            else:
                self.keys.pop(task, None)
                self.send({"type": "work", "task": task, "state": "stale"})
        self.waiting += 1
        turn = self.waiting
        self.later(lambda: self._begin_rest(turn), _QUIET if self.live else 0)

    def _begin_rest(self, turn: int) -> None:
        if turn != self.waiting:  # another gesture has come
            return
        if self.live:  # a slider rests: what else depends on its place
            self.live = False
            self._tell_view(None, new_system=False)
        for task in _ORDER[1:]:
            if self.keys.get(task) != self._key(task):
                self._begin(task)

    def _begin(self, task: str, n: Any = None, seconds: float | None = None) -> None:
        self.crew.cancel(self.jobs.pop(task, None))
        self.keys[task] = key = self._key(task)
        self.show(task, self.view, None)
        if key is None:
            self.send({"type": "work", "task": task, "state": "none"})
            return
        view = self.view

        def tell(event: str, job: Job, value: Any) -> None:
            self.later(lambda: self._hear_of(task, view, job, event, value, n), 0)

        self.send({"type": "work", "task": task, "state": "busy"})
        self.jobs[task] = self.crew.submit(Job(task, view, tell, seconds or self.seconds))

    def _hear_of(
        self, task: str, view: View, job: Job, event: str, value: Any, n: Any = None
    ) -> None:
        if self.jobs.get(task) is not job:
            return  # of a job that a later gesture has replaced
        if event == "piece":
            self._take(task, value)
            self.show(task, view, value)
            self.send({"type": "piece", "task": task, **described(task, view, value), "n": n})
            return
        self.jobs.pop(task)
        words = {"done": "", "failed": value}.get(event, "")
        if event == "limit":
            words = (
                f"stopped after {value:g} s of work, its limit; choose a smaller range, or let it"
                " go on"
            )
        self.send({"type": "work", "task": task, "state": event, "message": words})

    def _take(self, task: str, piece: Piece) -> None:
        """Results that belong to the view: the region around a motion, the period of an orbit."""
        found = self.view
        if task == "plane" and "region" in piece and not found.region:
            found = replace(found, region=tuple(piece["region"]))
        if task == "orbit" and "turn" in piece and found.turn != piece["turn"]:
            found = replace(found, turn=piece["turn"])
        if found != self.view:
            self.view = found
            self.keys[task] = self._key(task)
            self._tell_view(None, new_system=False)

    def _key(self, task: str) -> Any:
        """All that a task depends on; None where there is nothing to do."""
        view = self.view
        system = (view.model, view.text, view.values)
        motion = (system, calls.motion(view), view.drawn, view.portrait)
        if task in ("motion", "drawing"):
            return motion
        if task == "orbit":
            shown = (view.over, view.between, view.shown) if view.branch else ()
            return (motion, view.turn, shown) if view.turn else None
        if task == "diagram":
            if not view.over:
                return None
            others = tuple(item for item in view.values if item[0] != view.over)
            return (system[:2], others, calls.diagram(view), view.shown)
        if not view.plane:
            return None
        if view.picture == "section":
            return (system, calls.points(view), view.plane)
        return (system, calls.map_of(view), view.plane, view.region, view.cells)

    def _tell_view(self, n: Any, *, new_system: bool, moves: bool = False) -> None:
        from nonsmooth.explorer.descriptions import described_view

        message = described_view(self.view, new_system=new_system, live=self.live)
        steps = {"back": bool(self.past), "forward": bool(self.future)}
        self.send(
            {"type": "view", "link": to_link(self.view), "n": n, "moves": moves} | steps | message
        )

    def open(self) -> None:
        """Show the first view."""
        self.keys.clear()
        self._tell_view(None, new_system=True)
        self._become(self.view)

    def stop(self) -> None:
        """Cancel all work."""
        for task, job in list(self.jobs.items()):
            self.crew.cancel(job)
            self.jobs.pop(task)
            message = "stopped; what was computed is shown"
            self.send({"type": "work", "task": task, "state": "stopped", "message": message})

    def _go_on(self, task: str) -> None:
        """Begin a task once more, with a longer limit."""
        if task not in _ORDER:
            raise OptionError(f"go on: {task!r} is no task of the page")
        self._begin(task, seconds=_LONGER * self.seconds)

    def _copy(self, kind: str) -> None:
        if kind not in _COPIES:
            raise OptionError(f"copy: {kind!r} is none of {', '.join(_COPIES)}")
        self.send({"type": "copy", "as": kind, "text": _COPIES[kind](self.view)})

    def _print(self, pane: str, suffix: str) -> None:
        if suffix not in SUFFIXES:
            raise OptionError(f"print: {suffix!r} is none of {', '.join(SUFFIXES)}")

        def tell(event: str, job: Job, value: Any) -> None:
            self.later(lambda: self._hear_of_print(job, event, value), 0)

        self.send({"type": "work", "task": "picture", "state": "busy"})
        options = {"which": pane, "suffix": suffix}
        self.crew.submit(Job("picture", self.view, tell, self.seconds, options))

    def _hear_of_print(self, job: Job, event: str, value: Any) -> None:
        if event == "piece":
            file = base64.b64encode(value["file"]).decode()
            self.send({"type": "file", "name": value["name"], "data": file})
        else:
            message = value if event == "failed" else ""
            self.send({"type": "work", "task": "picture", "state": event, "message": message})

    def close(self) -> None:
        """The visitor has gone."""
        for job in self.jobs.values():
            self.crew.cancel(job)
        self.jobs.clear()
