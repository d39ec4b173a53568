"""The pages on the paths from a verb to the engine list the calls that the verbs make."""

import re
import sys
import threading
from pathlib import Path

import nonsmooth as ns

PAGES = Path(__file__).parents[2] / "docs" / "explanation"
PACKAGE = str(Path(ns.__file__).parent)
MOST = 7


def told(page):
    """Names of the calls on a page, and the files that they are said to be in."""
    pattern = re.compile(r"^(\d+)\. `(\w+)` \(\[\w+\]\(([^)]+)\)\)", re.MULTILINE)
    found = pattern.findall((PAGES / page).read_text(encoding="utf-8"))
    assert [int(number) for number, _, _ in found] == list(range(1, len(found) + 1))
    return [(name, (PAGES / path).resolve()) for _, name, path in found]


def own_frames(frame):
    """Functions of the package that are under way, from the outermost on, with their files."""
    frames = []
    while frame is not None:
        if frame.f_code.co_filename.startswith(PACKAGE):
            frames.append((frame.f_code.co_name, Path(frame.f_code.co_filename).resolve()))
        frame = frame.f_back
    return frames[::-1]


def followed(verb, *calls):
    """Frames at the last of some calls that a verb makes, each of them made once.

    Frames of a thread follow those of the caller.
    """
    found = {name: [] for name in calls}

    def watch(frame, event, _):
        code = frame.f_code
        if event == "call" and code.co_name in found and code.co_filename.startswith(PACKAGE):
            found[code.co_name].append(own_frames(frame))

    threading.setprofile(watch)
    sys.setprofile(watch)
    try:
        verb()
    finally:
        sys.setprofile(None)
        threading.setprofile(None)
    assert all(len(frames) == 1 for frames in found.values())
    return [frame for (frames,) in found.values() for frame in frames]


def test_a_diagram_makes_the_calls_that_the_page_tells():
    def diagram():  # one call of the engine for both columns, whose motions have period one
        ns.bifurcation_diagram(
            ns.models.soft_impact(), "omega", [0.61, 0.62], transient=300, record=5, threads=1
        )

    calls = followed(diagram, "run_tasks", "run_sweep")
    assert calls == told("settled-motions.md")
    assert len(calls) <= MOST


def test_a_run_makes_the_calls_that_the_page_tells():
    system = ns.models.soft_impact()
    calls = followed(lambda: ns.simulate(system, periods=3), "run_lanes")
    assert calls == told("architecture.md")
    assert len(calls) <= MOST
