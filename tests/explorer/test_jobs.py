"""Work aside: pieces come, a cancelled job is silent and soon over, a long one meets its limit."""

import subprocess
import sys
import time
from dataclasses import replace
from queue import Empty, SimpleQueue

import numpy as np
import pytest

from nonsmooth.explorer.jobs import Crew, Job
from nonsmooth.explorer.openings import opening
from nonsmooth.explorer.tasks import TASKS

PATIENCE = 120.0  # seconds for a machine that is busy with all other tests
MOLE = opening("moling")
# ten thousand starts that a chaotic rotor keeps busy for minutes, whatever the machine
LONG = replace(
    opening("rotor"), picture="basins", plane=("x", "y"), region=(-1.0, 1.0, -1.0, 1.0), cells=100
)
ALL = {"every": True}  # coarse ones first would end where they take long


@pytest.fixture(scope="module")
def crew():
    made = Crew(quick=1, slow=1)
    yield made
    made.close()


class Ear:
    """Hears of jobs, in the order in which things happen."""

    def __init__(self):
        self.heard = SimpleQueue()

    def __call__(self, event, job, value):
        self.heard.put((event, job, value))

    def next(self, seconds=PATIENCE):
        return self.heard.get(timeout=seconds)

    def rest(self, job):
        found = [self.next()]
        while found[-1][0] == "piece":
            found.append(self.next())
        assert all(each is job for _, each, _ in found)
        return found


@pytest.mark.slow
def test_pieces_are_those_of_the_task(crew):
    ear, view = Ear(), replace(MOLE, columns=16, transient=20, record=10)
    *pieces, last = ear.rest(crew.submit(Job("diagram", view, ear)))
    known = list(TASKS["diagram"](view))
    assert last[0] == "done" and len(pieces) == len(known) > 1
    for (_, _, piece), other in zip(pieces, known, strict=True):
        assert np.array_equal(piece["value"], other["value"])


@pytest.mark.slow
def test_a_task_that_fails_says_why_and_the_next_one_runs(crew):
    ear = Ear()
    refused = replace(MOLE, values=(("xi", "-1"),))
    ((event, _, message),) = ear.rest(crew.submit(Job("motion", refused, ear)))
    assert event == "failed" and "xi > 0 is required" in message
    assert ear.rest(crew.submit(Job("motion", MOLE, ear)))[-1][0] == "done"


@pytest.mark.slow
def test_a_job_that_waits_is_cancelled_without_a_word(crew):
    ear = Ear()
    long = crew.submit(Job("plane", LONG, ear, options=ALL))
    waiting = crew.submit(Job("plane", LONG, ear, options=ALL))
    after = crew.submit(Job("drawing", MOLE, ear))
    crew.cancel(waiting)
    crew.cancel(long)
    assert {job for _, job, _ in ear.rest(after)} == {after}
    with pytest.raises(Empty):
        ear.next(0.2)


def test_a_cancelled_job_gives_its_place_to_the_next_one_soon(crew):
    """Much sooner than it would have ended: the library stops, or the process is ended."""
    ear = Ear()
    crew.submit(Job("drawing", MOLE, ear))  # the worker is there
    ear.next()
    ear.next()
    long = crew.submit(Job("plane", LONG, ear, options=ALL))
    time.sleep(1.0)
    began = time.monotonic()
    crew.cancel(long)
    after = crew.submit(Job("drawing", MOLE, ear))
    assert {job for _, job, _ in ear.rest(after)} == {after}
    assert time.monotonic() - began < 60.0


def test_a_limit_stops_a_job_and_is_told(crew):
    ear = Ear()
    job = crew.submit(Job("plane", LONG, ear, seconds=0.5, options=ALL))
    *_, (event, told, seconds) = ear.rest(job)
    assert (event, told, seconds) == ("limit", job, 0.5)
    assert ear.rest(crew.submit(Job("drawing", MOLE, ear)))[-1][0] == "done"


@pytest.mark.slow
def test_a_worker_that_ends_is_replaced(crew):
    ear = Ear()
    job = crew.submit(Job("plane", LONG, ear, options=ALL))
    (worker,) = crew.benches[False].workers
    worker.process.kill()
    ((event, _, message),) = ear.rest(job)
    assert event == "failed" and "has ended" in message
    assert ear.rest(crew.submit(Job("drawing", MOLE, ear)))[-1][0] == "done"


def test_a_closed_crew_takes_no_jobs_and_leaves_no_process():
    crew, ear = Crew(quick=1, slow=1), Ear()
    crew.start()
    crew.submit(Job("plane", LONG, ear, options=ALL))
    processes = [worker.process for bench in crew.benches.values() for worker in bench.workers]
    crew.close()
    assert crew.submit(Job("motion", MOLE, ear)).cancelled
    assert [process.wait(PATIENCE) is not None for process in processes] == [True, True]


@pytest.mark.slow
def test_a_worker_whose_page_has_gone_ends_without_a_word():
    worker = subprocess.Popen(
        [sys.executable, "-m", "nonsmooth.explorer.worker"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    worker.stdout.close()  # before it is ready: what it writes first finds nobody
    said = worker.stderr.read()
    assert (worker.wait(PATIENCE), said) == (0, b"")
    worker.stdin.close()
    worker.stderr.close()
