"""The page of errors and statuses holds every one of them, with its cure, as the code says it."""

import contextlib
import inspect
import io
import re
import warnings
from pathlib import Path

import pytest

import nonsmooth
from nonsmooth import errors
from nonsmooth.engine.status import CURES, EventKind, Status

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "reference" / "errors.md").read_text(encoding="utf-8")
HEADINGS = re.findall(r"^### (.+)$", PAGE, re.MULTILINE)
STATUSES = [status for status in Status if status < Status.BUFFER_FULL]
# What the engine says to its caller alone, or what becomes a ModelError.
WITHIN = {Status.BUFFER_FULL, Status.PAUSED, Status.NOT_FINITE, Status.NOT_CONVERGED}


def test_every_status_has_a_part_of_its_own():
    assert sorted(HEADINGS) == sorted(status.word for status in STATUSES)
    assert set(Status) - set(STATUSES) == WITHIN


@pytest.mark.parametrize("status", [s for s in STATUSES if s in CURES], ids=lambda s: s.word)
def test_every_cure_is_told_as_the_code_tells_it(status):
    part = PAGE.split(f"\n### {status.word}\n")[1].split("\n#")[0]
    assert CURES[status] in " ".join(part.split())


def test_every_status_but_completed_has_a_cure():
    assert set(CURES) == set(STATUSES) - {Status.COMPLETED}


def test_every_error_and_warning_is_named():
    classes = [
        name
        for name in errors.__all__
        if inspect.isclass(thing := getattr(errors, name)) and issubclass(thing, Exception)
    ]
    assert len(classes) >= 6
    assert not [name for name in classes if f"| `{name}` |" not in PAGE]
    assert not [name for name in classes if name not in nonsmooth.__all__]


def test_every_kind_of_event_is_named():
    table = PAGE.split("## Kinds of event")[1]
    named = set(re.findall(r"`(\w+)`", table))
    assert {kind.word for kind in EventKind} <= named


def statuses_in_the_code() -> set[str]:
    """Words that are written out where errors are raised and results are made."""
    written = re.compile(r"""\bstatus"?[=:] ?"([a-z_]+(?: [a-z]+)?)\"""")
    paths = (ROOT / "src" / "nonsmooth").rglob("*.py")
    texts = [path.read_text() for path in paths]
    return {word for text in texts for word in written.findall(text)}


def test_every_status_of_other_results_is_in_a_table():
    found = statuses_in_the_code()
    assert {"no_orbit", "tangent", "contact lost"} <= found  # the search sees them
    assert not sorted(word for word in found if f"`{word}` |" not in PAGE and word not in HEADINGS)


def test_what_explain_says_is_quoted_as_it_says_it():
    table = PAGE.split("## Before a run")[1].split("```")[0]
    quoted = re.findall(r"`([^`]+)`", table.partition("|---|---|")[2])
    said = (ROOT / "src" / "nonsmooth" / "system" / "model" / "explain.py").read_text(
        encoding="utf-8"
    )
    words = {status.word for status in Status}
    parts = [phrase for phrase in quoted if phrase not in words]
    assert len(parts) == 7
    assert not [phrase for phrase in parts if phrase not in said]


def test_what_the_page_shows_is_what_is_printed():
    shown = {line.rstrip() for line in PAGE.splitlines() if line.startswith("    ")}
    names: dict = {}
    said = io.StringIO()
    with contextlib.redirect_stdout(said), warnings.catch_warnings():
        warnings.simplefilter("error")
        for block in re.findall(r"```python\n(.*?)```", PAGE, re.S):
            exec(compile(block, "errors.md", "exec"), names)
    printed = [line for line in said.getvalue().splitlines() if line.strip()]
    assert len(printed) > 30
    assert not [line for line in printed if f"    {line}".rstrip() not in shown]
