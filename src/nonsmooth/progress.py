"""While a long computation runs: a progress bar, and Ctrl-C that waits for what is under way."""

from __future__ import annotations

import signal
import sys
import threading
import time
from types import FrameType, TracebackType
from typing import Any, ClassVar

__all__ = ["HeldInterrupts", "Progress"]


_PATIENCE = 1.0  # seconds before a bar appears


class Progress:
    """Context that shows how much of a known amount of work is done.

    Of one task only that it is under way: it is not known how much of it is done. Where work is
    made of work that has a bar of its own, the bar that appears first is the only one.
    """

    _shown: ClassVar[Progress | None] = None  # a terminal takes one

    def __init__(self, label: str, total: float) -> None:
        self.label = label
        self.total = total
        self._began = time.monotonic()
        self._visible = sys.stderr.isatty()
        self._bar: Any = None
        self._task: Any = None

    def __enter__(self) -> Progress:
        return self

    def update(self, done: float) -> None:
        """Say how much is done."""
        if not self._visible or time.monotonic() - self._began < _PATIENCE:
            return
        if Progress._shown not in (None, self):
            return
        if self._bar is None:
            from rich.console import Console
            from rich.progress import Progress as RichProgress

            self._bar = RichProgress(console=Console(stderr=True), transient=True)
            self._task = self._bar.add_task(
                self.label, total=self.total if self.total > 1 else None
            )
            self._bar.start()
            Progress._shown = self
        self._bar.update(self._task, completed=done)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.stop()
            Progress._shown = None


class HeldInterrupts:
    """While it holds, Ctrl-C is noted and comes with the next `check`, or at the end.

    Elsewhere than in the main thread, and where the program has switched interrupts off, nothing
    is changed.
    """

    def __init__(self) -> None:
        self._pending = False
        self._before: Any = None

    def check(self) -> None:
        """Raise KeyboardInterrupt if Ctrl-C has come."""
        if self._pending:
            self._pending = False
            raise KeyboardInterrupt

    def __enter__(self) -> HeldInterrupts:
        if threading.current_thread() is threading.main_thread():
            before = signal.getsignal(signal.SIGINT)
            if callable(before):
                self._before = before
                signal.signal(signal.SIGINT, self._note)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._before is not None:
            signal.signal(signal.SIGINT, self._before)
        if kind is None:
            self.check()

    def _note(self, number: int, frame: FrameType | None) -> None:
        self._pending = True
