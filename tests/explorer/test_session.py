"""A page without a browser: what a gesture cancels and begins, and what the page is told."""

import json
from dataclasses import replace

import pytest

from explorer.typed_systems import RIGID, ZENO
from nonsmooth.explorer.descriptions import described
from nonsmooth.explorer.links import from_link
from nonsmooth.explorer.openings import opening
from nonsmooth.explorer.session import Session
from nonsmooth.explorer.tasks import TASKS

MOLE = opening("moling")


CELLS = {"others": {}, "message": "completed", "seconds": 1.0, "waits": False}  # of basins
LINE = """states = ["x"]
period = "2*pi"

[parameters]
c = 1.0

[equations]
x = "sin(t) - c*x"
"""


class Bench:
    """Stands for the crew: keeps jobs, and answers when it is told to."""

    def __init__(self):
        self.begun, self.cancelled = [], []

    def submit(self, job):
        self.begun.append(job)
        return job

    def cancel(self, job):
        if job is not None:
            job.cancelled = True
            self.cancelled.append(job)

    def take(self):
        begun, self.begun = self.begun, []
        return {job.task: job for job in begun}


class Page:
    """A session with all that it is joined to; what comes later is run when it is asked for."""

    def __init__(self, view=MOLE):
        self.crew, self.sent, self.shown, self.queue = Bench(), [], [], []
        self.session = Session(
            view,
            self.crew,
            show=lambda task, view, piece: self.shown.append((task, piece)),
            clear=lambda task: self.shown.append((task, "cleared")),
            send=self.sent.append,
            later=lambda function, milliseconds: self.queue.append(function),
        )
        self.session.open()
        self.settle()

    def settle(self):
        while self.queue:
            self.queue.pop(0)()

    def do(self, settle=True, **gesture):
        self.sent.clear()
        self.session.hear(json.dumps(gesture))
        if settle:
            self.settle()

    def told(self, kind):
        return [message for message in self.sent if message["type"] == kind]


def test_a_page_begins_with_all_tasks_but_the_orbit():
    page = Page()
    assert set(page.crew.take()) == {"motion", "drawing", "ranges", "diagram", "plane"}
    assert from_link(page.told("view")[0]["link"]) == MOLE


def test_a_slider_begins_the_motion_at_once_and_the_rest_when_it_rests():
    page = Page()
    before = page.crew.take()
    page.do(do="value", name="xi", value="0.06", live=True, settle=False)
    assert set(page.crew.begun[0].task for _ in "1") == {"motion"} and len(page.crew.begun) == 1
    assert set(page.crew.cancelled) == set(before.values())
    page.do(do="value", name="xi", value="0.07", live=True, settle=False)
    page.settle()
    begun = page.crew.take()
    assert begun["motion"].view.system.parameter_values["xi"] == 0.07
    assert {begun[task].view for task in ("diagram", "plane")} == {page.session.view}


def test_the_parameter_of_the_diagram_leaves_the_diagram_as_it_is():
    page = Page()
    diagram = page.crew.take()["diagram"]
    page.do(do="value", name="b", value="0.12")
    assert "diagram" not in page.crew.take() and not diagram.cancelled


@pytest.mark.parametrize(
    ("gesture", "begun"),
    [
        ({"do": "click", "pane": "plane", "x": -1.0, "y": 0.5}, {"motion", "drawing", "diagram"}),
        (
            {"do": "box", "pane": "diagram", "x0": 0.1, "x1": 0.2, "y0": 0, "y1": 1},
            {"diagram"},
        ),
        ({"do": "box", "pane": "plane", "x0": -1, "x1": 0, "y0": 0, "y1": 1}, {"plane"}),
        ({"do": "set", "fields": {"start": "follow up"}}, {"diagram"}),
        ({"do": "set", "fields": {"picture": "section"}}, {"plane"}),
        ({"do": "set", "fields": {"portrait": "q,y"}}, {"motion", "drawing"}),
        ({"do": "set", "fields": {"event": "3"}}, set()),
        ({"do": "orbit"}, {"orbit"}),
    ],
)
def test_a_gesture_begins_what_depends_on_it_and_nothing_else(gesture, begun):
    page = Page()
    page.crew.take()
    page.do(**gesture)
    assert set(page.crew.take()) == begun


def test_back_and_forward_and_a_slide_is_one_step():
    page = Page()
    for value in ("0.05", "0.06", "0.07"):
        page.do(do="value", name="xi", value=value, live=True, settle=False)
    page.do(do="value", name="xi", value="0.07", live=False)
    box = {"x0": 0.1, "x1": 0.2, "y0": 0.0, "y1": 1.0}
    page.do(do="box", pane="diagram", **box)
    page.do(do="back")
    assert page.session.view.between == MOLE.between
    assert page.session.view.system.parameter_values["xi"] == 0.07
    page.do(do="back")
    assert page.session.view == MOLE
    page.do(do="back")
    assert "no further step" in page.told("refused")[0]["message"]
    page.do(do="forward")
    page.do(do="forward")
    assert page.session.view.between == (0.1, 0.2)


def test_another_system_empties_all_panes_at_once():
    page = Page()
    page.shown.clear()
    page.do(do="text", text=ZENO, settle=False)
    cleared = {task for task, piece in page.shown if piece == "cleared"}
    assert cleared == {message["task"] for message in page.told("clear")}
    assert cleared == {"motion", "ranges", "drawing", "orbit", "diagram", "plane"}


@pytest.mark.parametrize(
    ("text", "task", "said"),
    [(RIGID, "diagram", "no parameter that can be varied"), (LINE, "plane", "needs two states")],
)
def test_a_pane_with_nothing_to_do_says_why(text, task, said):
    page = Page()
    page.do(do="text", text=text)
    (last,) = [message for message in page.told("work")[-4:] if message["task"] == task]
    assert last["state"] == "none" and said in last["message"]


def test_a_task_that_fails_leaves_no_picture_of_another_view():
    page = Page()
    plane = page.crew.take()["plane"]
    page.shown.clear()
    plane.tell("failed", plane, "for a reason")
    page.settle()
    assert ("plane", "cleared") in page.shown
    assert page.told("work")[-1]["message"] == "for a reason"


def test_a_page_without_a_link_is_answered():
    page = Page()
    page.do(do="hello", n=1)
    assert page.told("heard") == [{"type": "heard", "n": 1}] and not page.told("refused")


def test_a_view_says_whether_a_gesture_made_it():
    page = Page(replace(MOLE, region=()))
    page.do(do="value", name="xi", value="0.06", live=True)
    plane = page.crew.take()["plane"]
    piece = CELLS | {"cells": 4, "attractors": [], "region": (0.0, 1.0, 0.0, 1.0)}
    plane.tell("piece", plane, piece)  # the region around the motion becomes that of the view
    page.settle()
    assert [message["by_gesture"] for message in page.told("view")] == [True, False]


@pytest.mark.slow
def test_ranges_of_sliders_come_when_a_slider_rests():
    page = Page()
    page.crew.take()
    page.do(do="value", name="xi", value="0.06", live=True, settle=False)
    assert "ranges" not in page.crew.take()
    page.settle()
    job = page.crew.take()["ranges"]
    (piece,) = TASKS["ranges"](job.view)
    job.tell("piece", job, piece)
    page.settle()
    (told,) = [message for message in page.told("piece") if message["task"] == "ranges"]
    known = {slider["name"]: slider for slider in told["sliders"]}
    assert known["xi"]["value"] == 0.06 and set(known) <= set(opening("moling").system.parameters)


def test_the_shares_of_a_plane_are_of_all_its_starts():
    from nonsmooth.explorer.descriptions import described

    view = replace(opening("impact_oscillator"), cells=4, region=(-2.0, 2.0, -2.0, 2.0))
    *_, piece = TASKS["plane"](view)
    told = described("plane", view, piece)
    shares = [float(text.rpartition(": ")[2].removesuffix(" %")) for text, _ in told["chips"]]
    assert "inadmissible" in piece["others"]  # behind the wall
    assert sum(shares) == pytest.approx(100.0, abs=0.05 * len(shares))  # one digit each


def test_a_motion_that_ends_early_is_shown_as_far_as_it_goes():
    """At rest on the ground rebounds accumulate at once; nothing is left out of what exists."""
    page = Page()
    page.do(do="text", text=ZENO)
    job = page.crew.take()["motion"]
    assert job.view.leave_out > 0
    (piece,) = TASKS["motion"](job.view)
    assert piece["status"] == "event_limit" and piece["time"][0] == 0.0
    job.tell("piece", job, piece)
    page.settle()
    (told,) = page.told("piece")
    assert "event_limit" in told["remark"] and not told["fine"]


def test_basins_that_take_long_wait_until_they_are_asked_for():
    page = Page()
    plane = page.crew.take()["plane"]
    slow = {"region": (-2.0, 1.0, -1.0, 1.0), "attractors": [], "cells": 625} | CELLS
    plane.tell("piece", plane, slow | {"seconds": 7.5, "waits": True})
    plane.tell("done", plane, None)
    page.settle()
    last = page.told("work")[-1]
    # 100 * 100 cells are sixteen times as many: two minutes
    assert last["message"] == "625 starts took 8 s of work; all 10,000 may take 2 min"
    page.do(do="go on", task="plane")
    assert page.crew.take()["plane"].options == {"every": True}


def test_a_print_takes_what_is_shown():
    page = Page()
    plane = page.crew.take()["plane"]
    shown = {"region": (-2.0, 1.0, -1.0, 1.0), "attractors": [], "cells": 625} | CELLS
    plane.tell("piece", plane, shown | {"result": {"basins": "kept"}})
    page.settle()
    for _ in "12":
        page.do(do="print", pane="plane", suffix=".pdf")
    jobs = page.crew.begun
    assert [job.options["known"] for job in jobs] == [{"basins": "kept"}] * 2
    page.do(do="set", fields={"picture": "section"})
    page.do(do="print", pane="plane", suffix=".pdf")
    assert page.crew.take()["picture"].options["known"] == {}


def test_a_piece_of_a_job_that_was_replaced_is_not_shown():
    page = Page()
    old = page.crew.take()["motion"]
    page.do(do="value", name="b", value="0.12")
    page.shown.clear()
    old.tell("piece", old, {"anything": 1})
    page.settle()
    assert page.shown == []


def test_the_period_of_an_orbit_and_the_region_of_basins_become_part_of_the_view():
    page = Page(replace(MOLE, region=()))
    plane = page.crew.take()["plane"]
    cells = {"region": (-2.0, 1.0, -1.0, 1.0), "attractors": [], "cells": 625} | CELLS
    plane.tell("piece", plane, cells)
    page.do(do="orbit")
    orbit = page.crew.take()["orbit"]
    found = {
        "turn": 2, "message": "completed", "admissible": True, "stable": False, "word": "a b",
        "residual": 0.0, "length": 1.0, "multipliers": [complex(-1.2), complex(0.5, 0.1)],
        "state": {},
    }  # fmt: skip
    orbit.tell("piece", orbit, found)
    page.settle()
    assert (page.session.view.region, page.session.view.turn) == ((-2.0, 1.0, -1.0, 1.0), 2)
    assert not plane.cancelled and not orbit.cancelled
    (told,) = [message for message in page.told("piece") if message["task"] == "orbit"]
    assert told["title"] == "period 2, unstable"
    assert told["multipliers"][0] == ["-1.2", 1.2]


def test_a_wrong_equation_is_told_under_its_place_and_the_page_stays():
    page = Page()
    page.crew.take()
    text = MOLE.system.to_toml().replace("2*xi*y + q", "2*xi*y + w", 1)
    page.do(do="text", text=text)
    (told,) = page.told("refused")
    assert text.split("\n")[told["line"] - 1][told["column"] - 1] == "w"
    assert page.session.view == MOLE and not page.crew.begun


def test_limits_and_stops_are_said_and_work_can_go_on():
    page = Page()
    begun = page.crew.take()
    plane = begun["plane"]
    plane.tell("limit", plane, 60.0)
    page.settle()
    last = page.told("work")[-1]
    assert "nothing came within 60 s" in last["message"] and last["go_on"] == "Go on"
    page.do(do="go on", task="plane")
    assert page.crew.take()["plane"].seconds > plane.seconds
    assert ("plane", "cleared") in page.shown  # nothing had come
    page.do(do="stop")
    assert {message["task"] for message in page.told("work")} >= {"diagram", "plane", "drawing"}
    assert begun["diagram"].cancelled


def test_copies_and_pictures():
    page = Page()
    page.crew.take()
    page.do(do="copy", **{"as": "python"})
    assert "ns.models.moling()" in page.told("copy")[0]["text"]
    page.do(do="print", pane="diagram", suffix=".pdf")
    job = page.crew.take()["picture"]
    job.tell("piece", job, {"file": b"%PDF-", "name": "diagram.pdf"})
    page.settle()
    assert page.told("file")[0]["name"] == "diagram.pdf"
    for wrong in ({"do": "copy", "as": "shell"}, {"do": "print", "pane": "x", "suffix": ".exe"}):
        page.do(**wrong)
        assert page.told("refused") and not page.crew.begun


@pytest.mark.parametrize("text", ["", "[]", "3", "{", '{"do": ["value"]}', '{"do": "value"}'])
def test_what_is_no_message_is_refused(text):
    page = Page()
    page.crew.take()
    page.sent.clear()
    page.session.hear(text)
    assert page.told("refused") and page.session.view == MOLE


def test_a_fault_of_the_program_is_answered_so_that_the_page_goes_on(monkeypatch, caplog):
    page = Page()

    def broken(view, gesture):
        raise ZeroDivisionError("a fault")

    monkeypatch.setattr("nonsmooth.explorer.session.after", broken)
    page.do(do="value", name="b", value="0.1", n=7)
    assert "fault of its program" in page.told("refused")[0]["message"]
    assert page.told("heard") == [{"type": "heard", "n": 7}]
    assert "ZeroDivisionError" in caplog.text and page.session.view == MOLE


def columns(done, n_ended, unsettled):
    return {
        "done": done, "count": 8, "n_ended": n_ended, "ended": ["singular"], "unsettled": unsettled,
    }  # fmt: skip


def test_a_diagram_says_where_none_of_its_motions_has_settled():
    assert described("diagram", MOLE, columns(8, 1, 6))["said"] == "8 columns"
    assert described("diagram", MOLE, columns(4, 0, 4))["said"] == "4 of 8 columns"
    none = described("diagram", MOLE, columns(8, 1, 7))
    assert none["said"] == "none settled"
    assert "1 motion ended early (singular)" in none["title"]
    assert "7 motions have not settled after 100 periods" in none["title"]
