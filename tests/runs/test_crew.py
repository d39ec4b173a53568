"""Threads that share tasks, and interruptions of them."""

import subprocess
import sys
import threading

import pytest

from effort import HANG
from nonsmooth.runs.crew import run_tasks

# A user who presses Ctrl-C at one step of this thread after the other.
INTERRUPTED = """
import sys, time
from nonsmooth.runs.crew import run_tasks

steps = 0

def interrupt(frame, event, argument):
    global steps
    steps -= bool(kept)  # counted once the work is under way
    if steps == 0:
        sys.settrace(None)
        raise KeyboardInterrupt
    return interrupt

for k in range(1, 1500, 3):
    steps, kept = k, []
    tasks = [lambda worker, stop: time.sleep(2e-4)] * 8
    sys.settrace(interrupt)
    try:
        run_tasks(tasks, int, threads=2, label="", keep=lambda i, result: kept.append(i))
    except KeyboardInterrupt:  # outside the work
        pass
    sys.settrace(None)
    assert len(kept) == len(set(kept))
"""


@pytest.mark.slow
def test_an_interruption_at_any_moment_ends_the_work():
    subprocess.run([sys.executable, "-c", INTERRUPTED], timeout=HANG, check=True)


def test_every_task_is_kept_once():
    kept = {}
    workers = []

    def make_worker():
        workers.append(1)
        return 10

    assert run_tasks(
        [lambda worker, stop, i=i: worker * i for i in range(50)],
        make_worker, threads=3, label="", keep=kept.__setitem__, done={7, 8},
    )  # fmt: skip
    assert kept == {i: 10 * i for i in range(50) if i not in (7, 8)}
    assert 1 <= len(workers) <= 3


@pytest.mark.parametrize("where", ["task", "worker", "keep"])
def test_a_fault_ends_the_work_and_is_raised(where):
    def fail(*_):
        raise ValueError(where)

    def task(worker, stop):
        return worker

    before = threading.active_count()
    with pytest.raises(ValueError, match=where):
        run_tasks(
            [fail if where == "task" and i == 5 else task for i in range(100)],
            fail if where == "worker" else int,
            threads=2, label="", keep=fail if where == "keep" else lambda i, result: None,
        )  # fmt: skip
    assert threading.active_count() == before
