"""A process that computes figures and claims: ``python -m nonsmooth_chapter.worker FOLDER``."""

from __future__ import annotations

import importlib
import io
import json
import os
import signal
import sys
import threading
import time
import traceback
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any, NamedTuple

from nonsmooth_chapter.results import basis, plain, read_entry, write_entry

__all__ = ["Item", "do_item", "main"]


# Single items of the chapter, a figure or a claim, computed into a folder.


class Item(NamedTuple):
    """A figure or a claim, and the function that makes it.

    Parameters
    ----------
    kind : str
        ``"figure"`` or ``"claim"``.
    name : str
        Its name, such as ``"fig8"``.
    module, function : str
        Where it is made. Of a figure the function draws; of a claim it takes the name and returns
        its `Check` and a function that judges.
    title : str, optional
        What a figure shows.

    Examples
    --------
    >>> Item("claim", "M03", "nonsmooth_chapter.claims", "check_of").name
    'M03'
    """

    kind: str
    name: str
    module: str
    function: str
    title: str = ""


def do_item(item: Item, folder: Path) -> dict[str, Any]:
    """Compute an item, unless the folder has it from the same code and options.

    Parameters
    ----------
    item : Item
        What to compute.
    folder : pathlib.Path
        Folder of the results.

    Returns
    -------
    dict
        ``name``, ``kind``, ``state`` ("done", "kept" or "fault") and ``told``; of a fault
        ``message`` and ``trace`` in place of the last.

    Examples
    --------
    >>> import tempfile
    >>> item = Item("claim", "M03", "nonsmooth_chapter.claims", "check_of")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found = [do_item(item, Path(folder))["state"] for _ in range(2)]
    >>> found
    ['done', 'kept']
    """
    named = {"name": item.name, "kind": item.kind}
    try:
        function = getattr(importlib.import_module(item.module), item.function)
        make = {"figure": _figure, "claim": _claim}[item.kind]
        state, told = make(item, function, folder)
    except Exception as fault:  # of one figure; the others go on
        said = f"{type(fault).__name__}: {fault}"
        return named | {"state": "fault", "message": said, "trace": traceback.format_exc()}
    return named | {"state": state, "told": told}


def _figure(item: Item, draw: Callable[..., Any], folder: Path) -> tuple[str, dict[str, Any]]:
    depends = basis(draw) | {"title": item.title}
    kept = read_entry(folder, item.name, depends)
    if kept is not None:
        return "kept", kept
    from nonsmooth_chapter.figures import write_figure

    (figure, data), told = _watched(draw)
    files = write_figure(item.name, item.title, figure, data, folder)
    told |= {
        "files": [path.name for path in files],
        "options": depends["options"],
        "attributes": {str(name): value for name, value in data.attrs.items()},
    }
    write_entry(folder, item.name, depends, files, told)
    return "done", told


def _claim(item: Item, check_of: Callable[..., Any], folder: Path) -> tuple[str, dict[str, Any]]:
    check, judge = check_of(item.name)
    depends = basis(check.compute)
    kept = read_entry(folder, item.name, depends)
    if kept is not None:
        return "kept", kept
    row, told = _watched(judge)
    told |= {"row": row}
    write_entry(folder, item.name, depends, [], told)
    return "done", told


def _watched(function: Callable[[], Any]) -> tuple[Any, dict[str, Any]]:
    """Result of a function, how long it took and worked, and what it warned of."""
    began, worked = time.monotonic(), time.process_time()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default")
        result = function()
    said = list(dict.fromkeys(str(each.message) for each in caught))
    told = {
        "seconds": round(time.monotonic() - began, 2),
        "processor_seconds": round(time.process_time() - worked, 2),  # of all threads
        "warnings": said,
    }
    return result, told


# A process that computes items of the chapter: ``python -m nonsmooth_chapter.worker FOLDER``.
#
# It reads one item a line from its input and answers each with one line. Ctrl-C is the business of
# the process that started it; it ends when its input does.


class _NoTerminal(io.TextIOWrapper):
    """Messages as before, but no progress bars among those of other processes."""

    def isatty(self) -> bool:
        return False


def main(folder: str) -> None:
    """Compute the items that stand in the input.

    Parameters
    ----------
    folder : str
        Folder of the results.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what a library prints is no answer
    sys.stdout = sys.stderr = _NoTerminal(os.fdopen(2, "wb", closefd=False), line_buffering=True)
    questions = sys.stdin
    for line in questions:
        _answer(answers, _done(json.loads(line), Path(folder)))


def _done(question: dict[str, Any], folder: Path) -> dict[str, Any]:
    if "item" in question:
        return do_item(Item(*question["item"]), folder)
    return {}


def _answer(answers: IO[str], told: dict[str, Any]) -> None:
    answers.write(json.dumps(plain(told)) + "\n")
    answers.flush()


def _end_with_parent() -> None:
    """End soon after the process that started this one, in the middle of an item too."""
    parent = os.getppid()
    while os.getppid() == parent:
        threading.Event().wait(_ATTENTION)
    os._exit(1)


_ATTENTION = 1.0  # seconds

if __name__ == "__main__":
    if os.name == "posix":  # elsewhere processes keep the number of a parent that is gone
        threading.Thread(target=_end_with_parent, daemon=True).start()
    main(sys.argv[1])
