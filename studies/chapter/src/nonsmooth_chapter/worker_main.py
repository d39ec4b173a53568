"""A process that computes items of the chapter: ``python -m nonsmooth_chapter.worker_main FOLDER``.

It reads one item a line from its input and answers each with one line. Ctrl-C is the business of
the process that started it; it ends when its input does.
"""

from __future__ import annotations

import io
import json
import os
import signal
import sys
import threading
from pathlib import Path
from typing import IO, Any

from nonsmooth_chapter.files import plain
from nonsmooth_chapter.items import Item, do_item

__all__ = ["main"]


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
