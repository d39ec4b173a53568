"""One visitor's page: gestures come in, views change, jobs begin, pieces are shown.

What a pane shows is a function of the view. The key of a pane is all that its task depends on; a
gesture that changes the key cancels the task and begins it anew.
"""

from __future__ import annotations

import base64
import json
import logging
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
from nonsmooth.explorer.wording import in_words_of_page, of_field

__all__ = ["Session"]

_log = logging.getLogger(__name__)

_ORDER = ("motion", "drawing", "ranges", "orbit", "diagram", "plane")
_QUIET = 180  # milliseconds after a live gesture until long work begins
_MOST_STEPS = 200  # back
_MOST_LOGGED = 200  # characters of a gesture
_LONGER = 4.0  # times the limit, where the visitor asks to go on
_NOTHING = {
    "diagram": "the system has no parameter that can be varied, so there is no diagram",
    "plane": "a plane needs two states, and the system has one",
}
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
    clear : callable
        Told a task whose pictures are no longer of the system that is shown.
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
        clear: Callable[[str], None],
        send: Send,
        later: Callable[[Callable[[], None], int], None],
        seconds: float = 60.0,
    ) -> None:
        self.view, self.crew, self.seconds = view, crew, seconds
        self.show, self.clear, self.send, self.later = show, clear, send, later
        self.keys: dict[str, Any] = {}
        self.jobs: dict[str, Job] = {}
        self.results: dict[str, dict[str, Any]] = {}  # of the pictures that are shown
        self.waits: dict[str, str] = {}  # tasks that go on only when they are asked to, and why
        self.empty: set[str] = set()  # tasks that have shown nothing since they began
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
        except Exception:  # a fault of the program: the page must hear an answer, and go on
            _log.exception("a gesture of the page could not be done: %s", text[:_MOST_LOGGED])
            said = "the page could not do this, by a fault of its program; the shell tells which"
            self.send({"type": "refused", "of": "", "message": said, "n": gesture.get("n")})
        if "n" in gesture:  # the page counts what it sends; a tap in a plot comes without it
            self.send({"type": "heard", "n": gesture["n"]})

    def _refuse(self, gesture: dict[str, Any], fault: NonsmoothError) -> None:
        message: dict[str, Any] = {"type": "refused", "of": gesture["do"]}
        if gesture["do"] == "text":
            place = find_fault(str(gesture.get("text", "")), str(fault))
            message |= {"line": place.line, "column": place.column, "message": place.message}
        else:
            words = of_field if gesture["do"] == "set" else in_words_of_page
            message |= {"message": words(str(fault))}
        message |= {"name": gesture.get("name", ""), "n": gesture.get("n")}
        self.send(message)

    def _do(self, gesture: dict[str, Any]) -> None:
        do = gesture["do"]
        if do == "hello":
            return  # of a page whose link is empty: it shows the first view
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
        if moves and not other:  # before all else, because a slider waits for it
            self._begin("motion", n=n)
        self._tell_view(n, new_system=other, moves=moves, by_gesture=True)
        for task in _ORDER:
            if other:
                self.keys.pop(task, None)
                self._clear(task)
            if self._is_up_to_date(task):
                continue
            self.crew.cancel(self.jobs.pop(task, None))
            if task == "motion":
                self._begin(task, n=n)
            elif task in self.keys:  # it is not stale already
                self.keys.pop(task)
                self.results.pop(task, None)
                self.send({"type": "work", "task": task, "state": "stale"})
        self.waiting += 1
        turn = self.waiting
        self.later(lambda: self._begin_rest(turn), _QUIET if self.live else 0)

    def _begin_rest(self, turn: int) -> None:
        if turn != self.waiting:  # another gesture has come
            return
        self.live = False
        for task in _ORDER[1:]:
            if not self._is_up_to_date(task):
                self._begin(task)

    def _is_up_to_date(self, task: str) -> bool:
        """Whether a task has begun for what is shown; one with nothing to do has begun too."""
        return task in self.keys and self.keys[task] == self._key(task)

    def _clear(self, task: str) -> None:
        self.clear(task)
        self.send({"type": "clear", "task": task})

    def _begin(
        self, task: str, n: Any = None, seconds: float | None = None, **options: Any
    ) -> None:
        self.crew.cancel(self.jobs.pop(task, None))
        self.keys[task] = key = self._key(task)
        self.show(task, self.view, None)
        self.empty.add(task)
        if not options:  # what is shown stays where a task goes on
            self.results.pop(task, None)
        if key is None:
            self._clear(task)
            why = _NOTHING.get(task, "")
            self.send({"type": "work", "task": task, "state": "none", "message": why})
            return
        view = self.view

        def tell(event: str, job: Job, value: Any) -> None:
            self.later(lambda: self._hear_of(task, view, job, event, value, n), 0)

        self.send({"type": "work", "task": task, "state": "busy"})
        self.jobs[task] = self.crew.submit(Job(task, view, tell, seconds or self.seconds, options))

    def _hear_of(
        self, task: str, view: View, job: Job, event: str, value: Any, n: Any = None
    ) -> None:
        if self.jobs.get(task) is not job:
            return  # of a job that a later gesture has replaced
        if event == "piece":
            self._take(task, value)
            self.empty.discard(task)
            self.results[task] = value.get("result", {})
            told = described(task, view, value)
            self.waits[task] = told.get("waits", "")
            self.show(task, view, value)
            self.send({"type": "piece", "task": task, **told, "n": n})
            return
        self.jobs.pop(task)
        words = {"done": self.waits.pop(task, ""), "failed": value}.get(event, "")
        words = in_words_of_page(words)
        go_on = "Go on for all cells" if event == "done" and words else ""
        if event != "done" and task in self.empty:
            self._clear(task)  # what stands there is of another view
        if event == "limit":
            words = (
                f"stopped after {value:g} s of work, its limit; choose a smaller range, or let it"
                " go on"
            )
            if task in self.empty:
                words = f"nothing came within {value:g} s of work: motions settle slowly here"
            go_on = "Go on"
        message = {"type": "work", "task": task, "state": event, "message": words}
        self.send(message | {"go_on": go_on})

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
        if task == "ranges":
            return system
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

    def _tell_view(
        self, n: Any, *, new_system: bool, moves: bool = False, by_gesture: bool = False
    ) -> None:
        from nonsmooth.explorer.descriptions import described_view

        message = described_view(self.view, new_system=new_system)
        steps = {"back": bool(self.past), "forward": bool(self.future)}
        self.send(
            {
                "type": "view",
                "link": to_link(self.view),
                "n": n,
                "moves": moves,
                "by_gesture": by_gesture,
            }
            | steps
            | message
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
            if task in self.empty:
                self._clear(task)
                message = "stopped before there was anything to show"
            self.send({"type": "work", "task": task, "state": "stopped", "message": message})

    def _go_on(self, task: str) -> None:
        """Begin a task once more, with a longer limit."""
        if task not in _ORDER:
            raise OptionError(f"go on: {task!r} is no task of the page")
        # coarse cells are there already
        options = {"every": True} if task == "plane" else {}
        self._begin(task, seconds=_LONGER * self.seconds, **options)

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
        known = {name: of for found in self.results.values() for name, of in found.items()}
        options = {"which": pane, "suffix": suffix, "known": known}
        self.crew.submit(Job("picture", self.view, tell, self.seconds, options))

    def _hear_of_print(self, job: Job, event: str, value: Any) -> None:
        if event == "piece":
            file = base64.b64encode(value["file"]).decode()
            self.send({"type": "file", "name": value["name"], "data": file})
        else:
            message = in_words_of_page(value) if event == "failed" else ""
            self.send({"type": "work", "task": "picture", "state": event, "message": message})

    def close(self) -> None:
        """The visitor has gone."""
        for job in self.jobs.values():
            self.crew.cancel(job)
        self.jobs.clear()
