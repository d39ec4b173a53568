"""The page on the path from a diagram to the engine lists the calls that a diagram makes."""

import re
import sys
import threading
from pathlib import Path

import nonsmooth as ns

PAGE = Path(__file__).parents[2] / "docs" / "explanation" / "settled-motions.md"
PACKAGE = str(Path(ns.__file__).parent)
MOST = 7


def told():
    """Names of the calls on the page, and the files that they are said to be in."""
    pattern = re.compile(r"^(\d+)\. `(\w+)` \(\[\w+\]\(([^)]+)\)\)", re.MULTILINE)
    found = pattern.findall(PAGE.read_text(encoding="utf-8"))
    assert [int(number) for number, _, _ in found] == list(range(1, len(found) + 1))
    return [(name, (PAGE.parent / path).resolve()) for _, name, path in found]


def own_frames(frame):
    """Functions of the package that are under way, from the outermost on, with their files."""
    frames = []
    while frame is not None:
        if frame.f_code.co_filename.startswith(PACKAGE):
            frames.append((frame.f_code.co_name, Path(frame.f_code.co_filename).resolve()))
        frame = frame.f_back
    return frames[::-1]


def followed():
    """Calls from the verb to the engine: those of the caller, then those of the thread."""
    before, within = [], []

    def watch(frame, event, _):
        if event != "call":
            return
        name = frame.f_code.co_name
        if name == "run_tasks":
            before.append(own_frames(frame))
        elif name == "run_sweep" and frame.f_code.co_filename.startswith(PACKAGE):
            within.append(own_frames(frame))

    threading.setprofile(watch)
    sys.setprofile(watch)
    try:
        ns.bifurcation_diagram(
            ns.models.soft_impact(), "omega", [0.7, 0.8], transient=5, record=5, threads=1
        )
    finally:
        sys.setprofile(None)
        threading.setprofile(None)
    assert len(before) == len(within) == 1  # one call of the engine for both columns
    return before[0] + within[0]


def test_a_diagram_makes_the_calls_that_the_page_tells():
    calls = followed()
    assert calls == told()
    assert len(calls) <= MOST
